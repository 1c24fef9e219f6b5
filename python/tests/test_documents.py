# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The documents' Python, run one after the other as it stands there."""

import importlib.util
import pathlib
import re

import pytest

import pliant

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCUMENTS = ["README.md", "docs/hello.md", "docs/howto/python.md", "docs/howto/augment.md"]


def blocks_of(document):
    blocks = re.findall(r"^```python\n(.*?)^```", (ROOT / document).read_text(), re.M | re.S)
    assert blocks
    return blocks


@pytest.mark.parametrize("document", DOCUMENTS)
def test_its_examples_run(document, tmp_path, monkeypatch):
    blocks = blocks_of(document)
    monkeypatch.chdir(tmp_path)
    airway = pliant.make_phantom("airway")
    airway.save("airway.nrrd")
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, document, "exec"), names)
    pushed = pliant.read_volume("pushed.nrrd")
    assert (pushed.array != airway.array).sum() > 1000


def test_other_programs_read_results(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    airway = pliant.make_phantom("airway", size=(64, 64, 64))
    tissue = pliant.make_chainmail(airway)
    tissue.push((12.6, -2.7, -14.8), (-2.5, -4, -3.7), sphere_radius_mm=4)
    airway.save("airway.nrrd")
    tissue.volume().save("pushed.nrrd")
    tissue.displacement_field().save("field.nrrd")
    tissue.inverse_field().save("transform.nrrd")
    document = "docs/howto/other_programs.md"
    names: dict[str, object] = {}
    for block in blocks_of(document):
        if "import ants" not in block or importlib.util.find_spec("ants"):
            exec(compile(block, document, "exec"), names)
    series = pliant.read_volume("dicom")
    assert (series.array == tissue.volume().array).all()
    assert series.origin_mm == pytest.approx(airway.origin_mm, abs=1e-5)
