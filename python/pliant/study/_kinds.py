# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""What an item can run: commands of the program, augmentation, an endoscope, a function.

A kind gets its arguments with all inputs as paths on this machine, writes files into the folder of
its work, and returns results. Both depend on nothing but the arguments and the seed.
"""

from __future__ import annotations

import contextlib
import dataclasses
import fnmatch
import functools
import importlib
import importlib.util
import inspect
import json
import os
import pathlib
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy

from pliant._core import Field, Volume, read_volume
from pliant._error import Error
from pliant._program import program
from pliant.augment import TissueMotions
from pliant.study._keys import digest, digest_of_path

Results = dict[str, Any]
_here = threading.local()
_loading = threading.Lock()


@contextlib.contextmanager
def at_work() -> Iterator[None]:
    """Marks this thread as at work on items."""
    _here.is_working = True
    try:
        yield
    finally:
        _here.is_working = False


def refuse_in_items() -> None:
    """Raises an error if this thread is at work on an item."""
    if getattr(_here, "is_working", False):
        raise Error(
            "study: expected a file whose items don't make the study again; put it below "
            'if __name__ == "__main__":'
        )


@dataclasses.dataclass(frozen=True)
class Work:
    """One item at work.

    Attributes:
        arguments: Those of [run], with the parameters.
        seed: Of the item.
        folder: Where files go.
        threads: That the item may use.
        keep: Patterns of files that are kept; None: the kind's own.
        timeout_s: After which a command is ended; 0: no limit.
    """

    arguments: dict[str, Any]
    seed: int
    folder: str
    threads: int
    keep: list[str] | None
    timeout_s: float = 0.0

    def path(self, name: str) -> str:
        """A file in the folder."""
        return os.path.join(self.folder, name)

    def wants(self, name: str, by_itself: bool = False) -> bool:
        """Whether a file is kept."""
        if self.keep is None:
            return by_itself
        return any(fnmatch.fnmatchcase(name, pattern) for pattern in self.keep)


def too_long(seconds: float) -> Error:
    """The error of an item that has taken too long."""
    line = f"run.timeout_s: expected an end within {seconds:g} s, found none"
    return Error(line, "limit_exceeded")


# ---- commands of the program

_TIMES = ("seconds", "peak_memory_mb", "memory_mb", "pace", "file", "trace", "notes")


def without_times(report: Any) -> Any:
    """A report without numbers that differ from run to run, and names of files."""
    if isinstance(report, list):
        return [without_times(entry) for entry in report]
    if not isinstance(report, Mapping):
        return report
    return {
        name: without_times(value)
        for name, value in report.items()
        if name not in _TIMES and (not name.endswith("_ms") or name == "time_step_ms")
    }


def _run(work: Work, words: list[str], options: Mapping[str, Any]) -> None:
    command = [str(program()), *words]
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if value is True:
            command.append(option)
        elif value is not False and value is not None:
            for one in value if isinstance(value, list) else [value]:
                command += [f"{option}={one!r}" if isinstance(one, float) else f"{option}={one}"]
    try:
        done = subprocess.run(
            command,
            cwd=work.folder,
            capture_output=True,
            text=True,
            check=False,
            timeout=work.timeout_s or None,
        )
    except subprocess.TimeoutExpired:
        raise too_long(work.timeout_s) from None
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        how = f"ended with {done.returncode}" if done.returncode > 0 else "was killed"
        raise Error(lines[-1].removeprefix("pliant: ") if lines else f"pliant {words[0]} {how}")


def _toml(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{json.dumps(k)} = {_toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_toml(v) for v in value) + "]"
    return repr(value)


def _write_toml(path: str, tables: Mapping[str, Any]) -> None:
    """Tables with their own headings, so that the program's errors name lines."""
    lines = [f"{json.dumps(k)} = {_toml(v)}" for k, v in tables.items() if not _is_table(v)]
    for name, value in tables.items():
        if isinstance(value, Mapping):
            lines += [f"[{json.dumps(name)}]"]
            lines += [f"{json.dumps(k)} = {_toml(v)}" for k, v in value.items()]
        elif _is_table(value):
            for entry in value:
                lines += [f"[[{json.dumps(name)}]]"]
                lines += [f"{json.dumps(k)} = {_toml(v)}" for k, v in entry.items()]
    pathlib.Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")


def _is_table(value: Any) -> bool:
    is_list = isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)
    return isinstance(value, Mapping) or is_list


def _with_config(work: Work) -> dict[str, Any]:
    options = dict(work.arguments)
    for name in ("config", "scene"):
        if isinstance(options.get(name), Mapping):
            _write_toml(work.path(f"{name}.toml"), options[name])
            options[name] = f"{name}.toml"
    return options


def _report(work: Work, name: str = "report.json") -> Any:
    found = json.loads(pathlib.Path(work.path(name)).read_text(encoding="utf-8"))
    os.unlink(work.path(name))
    return found


def _drop(work: Work, *names: str) -> None:
    for name in names:
        pathlib.Path(work.path(name)).unlink(missing_ok=True)


def _extra(work: Work, outputs: Mapping[str, str]) -> dict[str, str]:
    """Options of the output files that are kept."""
    return {option: name for name, option in outputs.items() if work.wants(name)}


def deform(work: Work) -> Results:
    """`pliant deform`: deformed.nrrd, and other outputs if they are kept."""
    options = _with_config(work)
    extra = _extra(
        work,
        {
            "displacement.nrrd": "displacement",
            "transform.nrrd": "transform",
            "jacobian.nrrd": "jacobian",
            "strain.nrrd": "strain",
            "picture.png": "png",
            "state.plst": "save_state",
        },
    )
    outputs = {"out": "deformed.nrrd", "report": "report.json", "threads": work.threads}
    _run(work, ["deform", options.pop("scan")], {**options, **extra, **outputs})
    _drop(work, "config.toml")
    found: Results = without_times(_report(work))
    return found


def vessel(work: Work) -> Results:
    """`pliant vessel`: measures.csv, and other outputs if they are kept."""
    options = _with_config(work)
    extra = _extra(work, {"volume.nrrd": "volume", "picture.png": "png", "hand.log": "record"})
    if work.wants("measures.csv", True):
        extra["csv"] = "measures.csv"
    outputs = {"report": "report.json", "threads": work.threads}
    _run(work, ["vessel", options.pop("scene")], {**options, **extra, **outputs})
    _drop(work, "scene.toml")
    found: Results = without_times(_report(work))
    return found


def fit(work: Work) -> Results:
    """`pliant fit`: values and errors of each method; with a mesh network.json."""
    options = _with_config(work)
    extra = _extra(work, {"fitted.vtu": "out"} if "mesh" in options else {})
    if "mesh" in options and work.wants("network.json", True):
        extra["network_out"] = "network.json"
    if "annealing" in options.get("method", []):
        options.setdefault("seed", work.seed)
    _run(work, ["fit"], {**options, **extra, "report": "report.json", "threads": work.threads})
    report = without_times(_report(work))
    for method in report.get("methods", []):
        method["cases"] = {case.pop("load"): case for case in method.get("cases", [])}
        method.pop("directions", None)
    report.update({method.pop("method"): method for method in report.pop("methods", [])})
    found: Results = report
    return found


def truth(work: Work) -> Results:
    """`pliant truth make` with the item's seed: the files of a case, and errors at rest."""
    options = _with_config(work)
    scan = options.pop("scan")
    made = {"cases": 1, "seed": work.seed, "out": "data", "threads": work.threads}
    _run(work, ["truth", "make", scan], {**options, **made})
    scores = {"report": "report.json", "threads": work.threads}
    _run(work, ["truth", "score", "data"], scores)
    report = _report(work)
    _drop(work, "config.toml")
    (case,) = pathlib.Path(work.path("data")).glob("case_*")
    for path in case.iterdir():
        shutil.move(path, work.path(path.name))
    shutil.rmtree(work.path("data"))
    found: Results = json.loads(pathlib.Path(work.path("case.json")).read_text(encoding="utf-8"))
    found["motions"] = " ".join(motion["kind"] for motion in found["motions"])
    found.pop("settings", None)
    return {**found, "before": report["methods"][0]["over_cases"]}


# ---- augmentation


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


# ---- an endoscope


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


# ---- functions


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
