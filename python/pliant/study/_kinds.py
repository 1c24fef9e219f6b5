# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Kinds of items: commands of the program, augmentation, an endoscope, a function.

A kind gets its arguments with all inputs as paths on this machine, writes files into the folder of
its work, and returns results. Both depend on nothing but the arguments and the seed.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib.util
import inspect
import json
import os
import pathlib
import sys
import threading
from collections.abc import Callable, Mapping
from typing import Any

import numpy

from pliant._core import Field, Volume, read_volume
from pliant._error import Error
from pliant.augment import TissueMotions
from pliant.study._commands import deform, fit, truth, vessel
from pliant.study._keys import digest, digest_of_path
from pliant.study._work import Results, Work

_here = threading.local()  # the prepared scan of this thread's last item
_loading = threading.Lock()


def _prepared(path: str, settings: str) -> tuple[Any, Any]:
    """Motions with this thread's scan, which is kept for the next item."""
    if getattr(_here, "prepared_key", None) != (path, settings):
        motions: Any = TissueMotions(**json.loads(settings))
        _here.prepared = motions, motions.prepare(read_volume(path))
        _here.prepared_key = path, settings
    found: tuple[Any, Any] = _here.prepared
    return found


def augment(work: Work) -> Results:
    """`pliant.augment.TissueMotions`: moved.nrrd, plan.json, labels.nrrd if there are labels."""
    options = dict(work.arguments)
    scan, labels = options.pop("scan"), options.pop("labels", None)
    settings = json.dumps({"threads": work.threads, **options}, sort_keys=True)
    motions, prepared = _prepared(scan, settings)
    label_map = None if labels is None else read_volume(labels)
    array = None if label_map is None else label_map.array
    moved = motions(prepared, numpy.random.default_rng(work.seed), labels=array)
    if work.wants("moved.nrrd", True):
        moved.image.save(work.path("moved.nrrd"))
    if work.wants("plan.json", True):
        moved.plan.save(work.path("plan.json"))
    if label_map is not None and work.wants("labels.nrrd", True):
        _save_array(work, "labels", moved.labels, label_map)
    if work.wants("forward.nrrd"):
        moved.forward.save(work.path("forward.nrrd"))
    if work.wants("inverse.nrrd"):
        moved.inverse.save(work.path("inverse.nrrd"))
    done = [motion["fraction"] for motion in moved.report]
    return {
        "motions": len(done),
        "mean_fraction": float(numpy.mean(done)) if done else 0.0,
        "smallest_jacobian": float(moved.smallest_jacobian),
        "changed_voxels": int((moved.image.array != read_volume(scan).array).sum()),
    }


def _save_array(work: Work, name: str, array: Any, grid: Volume) -> None:
    made = Volume(array, grid.spacing_mm, grid.origin_mm, numpy.array(grid.direction), 0)
    made.save(work.path(f"{name}.nrrd"))


@functools.lru_cache(maxsize=2)
def _lumen(scan: str) -> Any:
    from pliant import gym

    return gym.EndoscopeEnv(scan, ("guide",), (4, 4)).lumen


def _follow(observation: Mapping[str, Any], rng: numpy.random.Generator) -> Any:
    """Turns to the path's next point, and goes there."""
    ahead = observation["guide"][:3] / max(float(numpy.linalg.norm(observation["guide"][:3])), 1e-9)
    turns = numpy.clip([-4 * ahead[1], 4 * ahead[0]], -1.5, 1.5)
    return numpy.array([20 * max(ahead[2], 0) ** 2, 0, *turns])


def _wander(observation: Mapping[str, Any], rng: numpy.random.Generator) -> Any:
    return rng.uniform([-20, -1.5, -1.5, -1.5], [20, 1.5, 1.5, 1.5])


def endoscope(work: Work) -> Results:
    """An episode of pliant.gym's EndoscopeEnv: tip.npy, and measures of the way."""
    from pliant import gym

    options = dict(work.arguments)
    policy = options.pop("policy", "guide")
    act = {"guide": _follow, "random": _wander}[policy]
    lumen = _lumen(options.pop("scan", "airway"))
    rng = numpy.random.default_rng(work.seed)
    observed = ("guide", *options.pop("obs", ()))
    env = gym.EndoscopeEnv(lumen, observed, threads=work.threads, **{"size": (16, 16), **options})
    observation, info = env.reset(seed=work.seed)
    tips, reward, force, is_over = [info["tip_lps_mm"]], 0.0, 0.0, False
    while not is_over:
        observation, gain, ended, is_cut, info = env.step(act(observation, rng))
        tips.append(info["tip_lps_mm"])
        reward, force, is_over = reward + gain, max(force, info["wall_force_n"]), ended or is_cut
    if work.wants("tip.npy", True):
        numpy.save(work.path("tip.npy"), numpy.array(tips))
    return {
        "reward": reward,
        "steps": len(tips) - 1,
        "is_success": info["is_success"],
        "left_mm": info["left_mm"],
        "largest_force_n": force,
        "target": info["target"],
    }


_loaded = dict[str, tuple[str, Any]]()  # modules by name or file, with the hash of their source


def _module(source: str, expected_hash: str) -> Any:
    """The module of a function, again where a worker that goes on has another version of it."""
    is_file = source.endswith(".py")
    title = f"pliant_study_{digest(source.encode())}" if is_file else source
    found = (
        importlib.util.spec_from_file_location(title, source)
        if is_file
        else importlib.util.find_spec(source)
    )
    if found is None or found.loader is None:
        raise Error(f"run.function: expected the module {source} here", field="run.function")
    is_there = found.origin is not None and os.path.isfile(found.origin)
    here = digest_of_path(str(found.origin)) if is_there else ""
    if expected_hash and here != expected_hash:
        raise Error(
            f"run.function: expected the study's version of {source} here, found another",
            field="run.function",
        )
    if _loaded.get(source, ("",))[0] != here:
        module = importlib.util.module_from_spec(found)
        sys.modules[title] = module
        found.loader.exec_module(module)
        _loaded[source] = here, module
    return _loaded[source][1]


def function_of(source: str, name: str, expected_hash: str = "") -> Callable[..., Any]:
    """A function of a module or file."""
    with _loading:
        found = _module(source, expected_hash)
    for part in name.split("."):
        found = getattr(found, part, None)
    if not callable(found):
        raise Error(
            f"run.function: expected a function {name} in {source}, found none",
            field="run.function",
        )
    called: Callable[..., Any] = found
    return called


def _kept(work: Work, name: str, value: Any) -> Any:
    """Saves arrays, scans and fields as files; returns other values."""
    if isinstance(value, (Volume, Field)):
        value.save(work.path(f"{name}.nrrd"))
    elif isinstance(value, numpy.ndarray) and value.ndim:
        numpy.save(work.path(f"{name}.npy"), value, allow_pickle=False)
    else:
        return value
    return None


def python(work: Work) -> Results:
    """A function of the parameters, which may take rng, seed, folder and threads as well.

    It returns a dictionary: arrays, scans and fields become files of their names, others results.
    """
    arguments = dict(work.arguments)
    function = function_of(*(arguments.pop(name) for name in ("source", "function", "source_hash")))
    offered: dict[str, Callable[[], Any]] = {
        "rng": lambda: numpy.random.default_rng(work.seed),
        "seed": lambda: work.seed,
        "folder": lambda: pathlib.Path(work.folder),
        "threads": lambda: work.threads,
    }
    names = inspect.signature(function).parameters
    given = {name: make() for name, make in offered.items() if name in names}
    returned = function(**{**given, **arguments})
    if returned is None:
        return {}
    if not isinstance(returned, Mapping):
        returned = {"result": returned}
    kept = {str(name): _kept(work, str(name), value) for name, value in returned.items()}
    return {name: value for name, value in kept.items() if value is not None}


@dataclasses.dataclass(frozen=True)
class Kind:
    """A kind of work.

    Attributes:
        run: Does it.
        files: Arguments that name files: "scan", "file", or "toml", whose contents are taken.
        needed: An argument that must be there.
    """

    run: Callable[[Work], Results]
    files: dict[str, str]
    needed: str | None = None


_SCAN = {"scan": "scan", "labels": "file"}
KINDS = {
    "deform": Kind(
        deform,
        {
            **_SCAN,
            "config": "toml",
            "directions": "file",
            "mesh": "file",
            "network": "file",
            "load_state": "file",
        },
        "scan",
    ),
    "augment": Kind(augment, _SCAN, "scan"),
    "truth": Kind(truth, {"scan": "scan", "config": "toml"}, "scan"),
    "fit": Kind(fit, {"mesh": "file", "labels": "file", "target": "file", "creep": "file"}),
    "vessel": Kind(vessel, {"scene": "toml", "replay": "file"}, "scene"),
    "endoscope": Kind(endoscope, {"scan": "scan"}),
    "python": Kind(python, {}, "function"),
}
