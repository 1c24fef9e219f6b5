# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Kinds of work that are commands of the program, with their reports as results."""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import subprocess
from collections.abc import Mapping
from typing import Any

from pliant._error import Error
from pliant._program import program
from pliant.study._work import Results, Work, too_long

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
