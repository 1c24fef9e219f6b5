# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Every public name is exported and has a docstring; settings have rows."""

import inspect
import json
import operator
import subprocess
import sys

import pytest

import pliant


def members(kind):
    """A class's own public members."""
    for name, member in vars(kind).items():
        if not name.startswith("_"):
            yield f"{kind.__name__}.{name}", member


def test_everything_has_a_docstring():
    bare = []
    for name in pliant.__all__:
        if name == "__version__":
            continue
        public = getattr(pliant, name)
        if not (public.__doc__ or "").strip():
            bare.append(name)
        if inspect.isclass(public):
            bare += [
                title
                for title, member in members(public)
                if not described(getattr(member, "__doc__", None))
            ]
    assert bare == []


def described(text):
    """nanobind's docstrings begin with the signature, which says nothing."""
    if not text:
        return False
    lines = [line for line in text.strip().splitlines() if line.strip()]
    return any("->" not in line and not line.startswith("def ") for line in lines)


def test_every_function_has_a_signature():
    bare = []
    for name in [*pliant.__all__, "Tissue.push", "Volume.from_sitk"]:
        public = operator.attrgetter(name)(pliant)
        if not callable(public):
            continue
        try:
            inspect.signature(public)
        except (TypeError, ValueError) as error:
            bare.append(f"{name}: {error}")
    # Reports and results are made by the library alone.
    assert [line for line in bare if "Tissue" in line or not line[0].isupper()] == []
    push = inspect.signature(pliant.Tissue.push)
    assert list(push.parameters) == ["self", "point_mm", "push_mm", "sphere_radius_mm", "tool"]
    assert push.parameters["tool"].default == 1
    assert push.return_annotation == "pliant._core.PushReport"
    tissue = pliant.make_chainmail(pliant.make_phantom("airway", (8, 8, 8)))
    assert list(inspect.signature(tissue.undo).parameters) == []
    assert list(inspect.signature(tissue.push).parameters)[0] == "point_mm"
    made = inspect.signature(pliant.make_chainmail).parameters
    assert made["offset"].kind is inspect.Parameter.KEYWORD_ONLY
    assert isinstance(made["offset"].default, float)
    assert list(inspect.signature(pliant.Volume).parameters)[:2] == ["array", "spacing_mm"]


def test_names_are_exported_once():
    assert len(pliant.__all__) == len(set(pliant.__all__))
    assert all(hasattr(pliant, name) for name in pliant.__all__)


@pytest.mark.parametrize(
    "model",
    ["chainmail", "elastic_scan", "springs", "body", "network", "catheter", "wall"]
    + ["spring_solver", "elastic", "fit", "gauss_newton", "annealing", "organs", "organ", "truth"]
    + ["morph"],
)
def test_settings_have_rows(model):
    rows = pliant.settings_of(model)
    assert rows
    assert model in pliant.settings_of.__doc__
    for row in rows:
        assert row["name"]
        assert row["text"]


def test_importing_needs_numpy_alone():
    program = (
        "import sys, json, pliant; names = {m.split('.')[0] for m in sys.modules}; "
        "print(json.dumps(sorted(names)))"
    )
    found = subprocess.run(
        [sys.executable, "-c", program], check=True, capture_output=True, text=True
    )
    optional = {"SimpleITK", "nibabel", "matplotlib", "torch", "gymnasium", "IPython", "pyvista"}
    assert optional & set(json.loads(found.stdout)) == set()
