# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Studies: ids, runs that are killed, full disks, changed inputs. Without optional packages."""

import concurrent.futures
import csv
import dataclasses
import errno
import inspect
import json
import os
import pathlib
import random
import re
import signal
import subprocess
import sys
import threading
import time

import numpy
import pytest

import pliant
import pliant.augment
import pliant.truth
from pliant import study as study_module
from pliant.study import Input, LocalPool, Study
from pliant.study.__main__ import main

SOLVE = """
import os, signal, time
import numpy

def solve(x, n=0, *, rng, sleep_s=0.0):
    time.sleep(sleep_s)
    return {"y": x * x + rng.normal(), "field": rng.normal(size=(5, 5))}

def large(n, *, rng):
    return {"field": rng.normal(size=(64, 256))}

def bad(x, *, folder):
    (folder / "half.txt").write_text("half")
    if x == 2 and os.environ.get("PLIANT_TEST_BAD"):
        raise ValueError("no\\nequilibrium")
    if x == 3:
        raise SystemExit("the end")
    if x == 4:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"x": x}

def size_of(path):
    return {"bytes": os.path.getsize(path), "path": os.path.isabs(path)}
"""


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """A folder with the functions, and a cache of this test's own."""
    monkeypatch.setenv("PLIANT_STUDY_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "solve.py").write_text(SOLVE)
    return tmp_path


def small_study(**changes):
    given = {"parameters": {"x": [1, 2, 3], "n": {"count": 20}}, "seed": 7, **changes}
    return Study("small", "solve.py:solve", **given)


def ids_of(study):
    return {item.id for item in study.items}


def merged(out):
    return [(out / "merged" / name).read_bytes() for name in ("table.csv", "manifest.json")]


def test_ids_and_seeds_depend_on_the_item_alone(rng):
    study = small_study()
    shuffled = small_study(
        parameters={"n": rng.permutation(20).tolist(), "x": rng.permutation([1, 2, 3]).tolist()}
    )
    assert len(ids_of(study)) == 60
    assert {(i.id, i.seed) for i in study.items} == {(i.id, i.seed) for i in shuffled.items}
    longer = small_study(parameters={"x": [1, 2, 3, 4], "n": {"count": 20}})
    assert ids_of(study) < ids_of(longer)
    assert not ids_of(study) & ids_of(small_study(seed=8))
    assert not ids_of(study) & ids_of(small_study(keep={"files": ["*.npy"]}))
    renamed = Study("other", "solve.py:solve", seed=7, parameters=study.parameters)
    assert ids_of(study) == ids_of(renamed)
    assert len({i.seed for i in study.items}) == 60


def test_ids_are_the_same_in_every_version_of_the_test():
    """They name files of earlier runs: a change of this number makes those worthless."""
    study = Study("known", {"what": "fit", "size": "5,5,5"}, parameters={"young": [1.5, 2]})
    if pliant.__version__ != "0.2.0":
        pytest.skip("the version is part of the ids")
    assert study.items[0].id == "2742b60643034ada847ce0927bc1a2e7"


def test_a_changed_file_concerns_its_items_alone(place):
    for name in "abc":
        (place / f"{name}.dat").write_bytes(name.encode() * 10)
    parameters = {"path": {"files": "*.dat"}}
    before = Study("files", "solve.py:size_of", parameters=parameters).items
    (place / "b.dat").write_bytes(b"other")
    after = Study("files", "solve.py:size_of", parameters=parameters).items
    same = {i.id for i in before} & {i.id for i in after}
    assert {i.parameters["path"].name for i in after if i.id not in same} == {"b.dat"}
    assert len(same) == 2
    (place / "c.dat").write_bytes(b"other")  # the contents count, not the name
    twins = Study("files", "solve.py:size_of", parameters=parameters)
    assert len(twins.items) == 2
    assert twins.duplicates == 1
    source = (place / "solve.py").read_text()
    (place / "solve.py").write_text(source + "\n# changed\n")
    changed = Study("files", "solve.py:size_of", parameters=parameters)
    assert not ids_of(changed) & ids_of(twins)


@pytest.mark.parametrize("method", ["random", "latin-hypercube"])
def test_samples_fill_their_range(rng, method):
    count, seed = int(rng.integers(20, 60)), int(rng.integers(1000))
    parameters = {
        "a": {"low": -2, "high": 3},
        "b": {"low": 1e-3, "high": 1e3, "scale": "log"},
        "k": {"low": 1, "high": 4, "whole": True},
    }

    def drawn(n):
        sample = {"method": method, "count": n}
        study = Study("s", "solve.py:solve", parameters=parameters, sample=sample, seed=seed)
        return [item.parameters for item in study.items]

    rows = drawn(count)
    a = numpy.array([row["a"] for row in rows])
    b = numpy.log10([row["b"] for row in rows])
    assert a.min() >= -2
    assert a.max() < 3
    assert {row["k"] for row in rows} <= {1, 2, 3, 4}
    if method == "latin-hypercube":
        for column, low, high in ((a, -2, 3), (b, -3, 3)):
            part = numpy.floor((column - low) / (high - low) * count).astype(int)
            assert sorted(part) == list(range(count))
        assert abs(numpy.corrcoef(a, b)[0, 1]) < 0.75
    else:
        assert drawn(count + 5)[:count] == rows


def test_a_span_with_steps_is_a_list():
    parameters = {
        "x": {"low": 1, "high": 100, "steps": 3, "scale": "log"},
        "n": {"low": 0, "high": 1, "steps": 5},
    }
    rows = [i.parameters for i in Study("s", "solve.py:solve", parameters=parameters).items]
    assert sorted({row["x"] for row in rows}) == [1, 10, 100]
    assert sorted({row["n"] for row in rows}) == [0, 0.25, 0.5, 0.75, 1]


def test_results_are_the_same_bytes_for_any_number_of_workers(place):
    study = small_study()
    hashes = set()
    for workers in (1, 3):
        report = study.run(place / f"out{workers}", workers=workers)
        assert (report.done, report.failed, report.is_complete) == (60, {}, True)
        hashes.add(study.merge(place / f"out{workers}"))
    with concurrent.futures.ThreadPoolExecutor(2) as threads:
        assert study.run(place / "threads", threads).is_complete
    hashes.add(study.merge(place / "threads"))
    assert len(hashes) == 1
    assert merged(place / "out1") == merged(place / "out3")
    again = study.run(place / "out1")
    assert (again.done, again.known) == (0, 60)
    rows = list(csv.DictReader((place / "out1" / "merged" / "table.csv").open()))
    assert [row["id"] for row in rows] == sorted(ids_of(study))
    item = next(i for i in study.items if i.id == rows[0]["id"])
    rng = numpy.random.default_rng(item.seed)
    assert float(rows[0]["y"]) == item.parameters["x"] ** 2 + rng.normal()
    field = numpy.load(place / "out1" / "items" / item.id[:2] / item.id / "field.npy")
    assert (field == rng.normal(size=(5, 5))).all()
    assert study.table(place / "out1")[0]["y"] == float(rows[0]["y"])
    assert not list((place / "out1" / "tmp").iterdir())


def kill_at_random(pool, seed, stop, kills, most=12):
    chance = random.Random(seed)
    while len(kills) < most and not stop.wait(chance.uniform(0.02, 0.25)):
        if pids := pool.pids:
            try:
                os.kill(chance.choice(pids), signal.SIGKILL)
            except ProcessLookupError:
                continue
            kills.append(1)


def test_killed_workers_change_nothing(place, rng):
    study = small_study(parameters={"x": [1, 2], "n": {"count": 40}, "sleep_s": [0.03]})
    study.run(place / "quiet", workers=2)
    stop, kills, pool = threading.Event(), [], LocalPool(2)
    killer = threading.Thread(
        target=kill_at_random, args=(pool, int(rng.integers(2**31)), stop, kills)
    )
    killer.start()
    try:
        for _ in range(3):  # an item may be lost five times by chance
            report = study.run(place / "killed", pool, retry_failed=True)
            if report.is_complete:
                break
    finally:
        stop.set()
        killer.join()
        pool.shutdown()
    assert report.is_complete, report
    assert kills
    assert study.merge(place / "quiet") == study.merge(place / "killed")
    assert merged(place / "quiet") == merged(place / "killed")


def test_a_process_that_dies_at_its_start_is_told(place, monkeypatch):
    from pliant.study import _local

    monkeypatch.setattr(_local, "_START", "import sys; sys.exit(3)")
    monkeypatch.setattr(_local, "_STARTS", 2)
    pool = LocalPool(1)
    for _ in range(2):
        with pytest.raises(_local.WorkerLost, match="2 processes ended with status 3 at"):
            pool.submit(len, "abc").result()
    monkeypatch.undo()
    assert pool.submit(len, "abc").result() == 3
    pool.shutdown()


def test_a_killed_study_goes_on(place, rng):
    study = small_study(parameters={"x": [1], "n": {"count": 30}, "sleep_s": [0.05]})
    study.run(place / "quiet", workers=2)
    (place / "s.toml").write_text(
        '[study]\nname = "small"\nseed = 7\n[parameters]\nx = [1]\nn = {count = 30}\n'
        'sleep_s = [0.05]\n[run]\nwhat = "python"\nfunction = "solve.py:solve"\n'
    )
    command = [sys.executable, "-m", "pliant.study", "run", "s.toml", "--out", "killed"]
    for _ in range(2):
        program = subprocess.Popen([*command, "--workers", "2"], stdout=subprocess.DEVNULL)
        time.sleep(rng.uniform(0.3, 1.2))
        program.kill()
        program.wait()
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert study.merge(place / "quiet") == study.merge(place / "killed")
    staged = list((place / "killed" / "tmp").iterdir())
    assert len(staged) <= 2  # of workers that were at work for the last killed program


def test_failures_are_told_and_repeated(place, monkeypatch, capsys):
    (place / "bad.toml").write_text(
        '[study]\nname = "bad"\n[parameters]\nx = [1, 2, 3, 4, 5]\n'
        '[run]\nwhat = "python"\nfunction = "solve.py:bad"\n'
    )
    monkeypatch.setenv("PLIANT_TEST_BAD", "1")
    assert main(["run", "bad.toml", "--workers", "2"]) == 1
    told = capsys.readouterr()
    assert "2 items done, 3 failed" in told.out
    assert "ValueError: no equilibrium" in told.err
    assert "SystemExit: the end" in told.err
    assert "SIGKILL; 5 times" in told.err
    study = Study.load("bad.toml")
    assert len(study.status().failed) == 3
    assert not list((place / "bad-results" / "tmp").iterdir())
    assert main(["status", "bad.toml"]) == 1
    assert "2 done, 3 failed, 0 left" in capsys.readouterr().out
    assert main(["run", "bad.toml"]) == 1
    assert "3 failed before" in capsys.readouterr().out
    monkeypatch.delenv("PLIANT_TEST_BAD")
    assert main(["run", "bad.toml", "--retry-failed"]) == 1
    assert len(study.status().failed) == 2
    page = pathlib.Path(study.report()).read_text()
    assert "SystemExit: the end" in page
    assert "Traceback" in page
    assert "http" not in page
    assert main(["merge", "bad.toml"]) == 1


def test_items_that_take_too_long_are_ended(place):
    run = {"what": "python", "function": "solve.py:solve", "timeout_s": 0.5}
    study = Study("slow", run, parameters={"x": [1], "sleep_s": [0, 30]})
    report = study.run()
    assert report.done == 1
    (error,) = report.failed.values()
    assert error == "run.timeout_s: expected an end within 0.5 s, found none"
    unlimited = Study("slow", "solve.py:solve", parameters={"x": [1], "sleep_s": [0, 30]})
    assert ids_of(unlimited) == ids_of(study)
    needs_program()
    fit = {"what": "fit", "size": "16,16,16", "volume": True, "groups": "kinds", "timeout_s": 0.3}
    with concurrent.futures.ThreadPoolExecutor(1) as threads:  # the command is ended there, too
        for engine in ("local", threads):
            report = Study("fit", fit).run(place / "fit", engine, retry_failed=True)
            assert "timeout_s" in next(iter(report.failed.values()))


def check_whole(out):
    """Every item that is there has all of its files."""
    for manifest in out.glob("items/*/*/manifest.json"):
        files = json.loads(manifest.read_text())["files"]
        found = {p.name: p.stat().st_size for p in manifest.parent.iterdir() if p != manifest}
        assert found == {name: f["bytes"] for name, f in files.items()}
    assert all((p / "manifest.json").exists() for p in out.glob("items/*/*"))


def test_a_full_disk_leaves_whole_items(place):
    disk = place / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "pliant-test", str(disk)]
    if os.geteuid() or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("needs the right to mount")
    try:
        study = Study("large", "solve.py:large", parameters={"n": {"count": 24}})
        report = study.run(disk / "out", workers=2)
        assert not report.is_complete
        assert os.strerror(errno.ENOSPC) in report.stopped
        assert "\n" not in report.stopped
        assert not report.failed
        check_whole(disk / "out")
        subprocess.run(["mount", "-o", "remount,size=32m", str(disk)], check=True)
        assert study.run(disk / "out", workers=2).is_complete
        study.run(place / "quiet", workers=2)
        assert study.merge(disk / "out") == study.merge(place / "quiet")
        check_whole(disk / "out")
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=True)


def test_a_vanished_folder_stops_the_run(place, rng):
    study = small_study(parameters={"x": [1], "n": {"count": 200}, "sleep_s": [0.03]})
    out, away = place / "out", place / "away"
    study.run(place / "quiet", workers=2)
    timer = threading.Timer(rng.uniform(0.5, 1.0), lambda: out.rename(away))
    timer.start()
    report = study.run(out, workers=2)
    timer.join()
    # The folder, or the file in it that was written at that moment.
    assert report.stopped.startswith(f"{out}: ") or report.stopped.startswith(f"{out}/")
    assert "the results' folder has vanished" in report.stopped or "No such" in report.stopped
    assert report.stopped.count(str(out)) == 1
    assert report.left > 0
    assert not out.exists()
    away.rename(out)
    check_whole(out)
    assert study.run(out, workers=2).is_complete
    assert study.merge(out) == study.merge(place / "quiet")


def test_a_plan_tells_what_would_run(place, capsys):
    (place / "p.toml").write_text(
        "[parameters]\nx = [1, 2]\nn = {count = 9}\n[run]\nwhat = 'python'\n"
        "function = 'solve.py:solve'\n"
    )
    assert main(["plan", "p.toml"]) == 0
    told = capsys.readouterr().out
    assert "p: 18 items" in told
    assert "0 done, 0 failed, 18 to run, 0 results of other items" in told
    assert re.search(r"[0-9a-f]{32}  to run  x = 1, n = 0\n", told)
    assert "... and 8 more" in told
    assert main(["run", "p.toml"]) == 0
    (place / "p.toml").write_text((place / "p.toml").read_text().replace("[1, 2]", "[2, 3]"))
    capsys.readouterr()
    assert main(["plan", "p.toml", "--all"]) == 0
    told = capsys.readouterr().out
    assert "9 done, 0 failed, 9 to run, 9 results of other items" in told
    assert re.search(r"left: about 0\.0 MB, \d+ s of one process", told)
    assert len(re.findall("^[0-9a-f]{32}  ", told, re.M)) == 18


def test_an_item_can_not_run_its_study(place):
    (place / "again.py").write_text(
        "from pliant.study import Study\n\ndef solve(x):\n    return {'x': x}\n\n"
        "print(Study('again', solve, parameters={'x': [1]}).run(workers=1))\n"
    )
    done = subprocess.run(
        [sys.executable, "again.py"], capture_output=True, text=True, timeout=60, check=False
    )
    assert "1 failed" in done.stdout
    log = next((place / "again-results" / "log").iterdir()).read_text()
    assert "__main__" in json.loads(log.splitlines()[0])["error"]
    guarded = 'if __name__ == "__main__":\n    print('
    text = (place / "again.py").read_text().replace("print(", guarded)
    (place / "again.py").write_text(text)
    done = subprocess.run(
        [sys.executable, "again.py"], capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stdout.startswith("1 items done;"), done.stderr


@pytest.mark.parametrize("source", ["once.py", "once"])
def test_workers_that_go_on_see_a_changed_function(place, monkeypatch, source):
    monkeypatch.syspath_prepend(str(place))
    pool = LocalPool(1)
    try:
        for value in (1, 2):
            (place / "once.py").write_text(f"def solve(x):\n    return {{'y': {value} * x}}\n")
            study = Study("once", f"{source}:solve", parameters={"x": [3]})
            assert study.run(place / "out", pool).done == 1
            assert study.table(place / "out")[0]["y"] == 3 * value
    finally:
        pool.shutdown()
    study = Study("once", f"{source}:solve", parameters={"x": [4]})
    (place / "once.py").write_text("def solve(x):\n    return {'y': 0}\n")
    (line,) = study.run(place / "out").failed.values()
    assert "once" in line


def test_the_launcher_knows_studies(place, monkeypatch, capsys):
    from pliant.__main__ import main as launch

    monkeypatch.setattr(sys, "argv", ["pliant", "study", "plan", "none.toml"])
    with pytest.raises(SystemExit) as ended:
        launch()
    assert ended.value.code == 2
    assert "none.toml: No such file" in capsys.readouterr().err


def test_threads_of_one_worker_augment_apart(place, airway):
    airway.save(place / "airway.nrrd")
    run = {"what": "augment", "pushes": 2}
    study = Study("threads", run, parameters={"scan": ["airway.nrrd"], "copy": {"count": 12}})
    with concurrent.futures.ThreadPoolExecutor(4) as threads:
        assert study.run(place / "threads", threads).is_complete
    study.run(place / "quiet", workers=1)
    assert study.merge(place / "threads") == study.merge(place / "quiet")


class FarMachine(concurrent.futures.Executor):
    """Processes with another cache, on which the study's files are not there."""

    def __init__(self, cache):
        os.environ["PLIANT_STUDY_CACHE"] = str(cache)
        self.pool = LocalPool(2)
        for call in [self.pool.submit(time.sleep, 0.2) for _ in range(2)]:
            call.result()

    def submit(self, fn, job, items, sent):
        def moved(value):
            if isinstance(value, Input):
                return dataclasses.replace(value, path=f"/elsewhere/{value.path}")
            if isinstance(value, dict):
                return {k: moved(v) for k, v in value.items()}
            return value

        job = dataclasses.replace(job, run=moved(job.run))
        items = [dataclasses.replace(i, parameters=moved(i.parameters)) for i in items]
        return self.pool.submit(fn, job, items, sent)


def test_files_go_to_machines_that_lack_them(place, airway, monkeypatch):
    airway.save(place / "a.nrrd")
    (place / "b.dat").write_bytes(b"b" * 1000)
    study = Study("far", "solve.py:size_of", parameters={"path": {"scans": "a.nrrd"}})
    files = Study("files", "solve.py:size_of", parameters={"path": {"files": "b.dat"}})
    monkeypatch.setenv("PLIANT_STUDY_CACHE", str(place / "far"))
    far = FarMachine(place / "far")
    monkeypatch.setenv("PLIANT_STUDY_CACHE", str(place / "cache"))
    try:
        for one in (study, files):
            assert one.run(place / f"{one.name}-far", far).is_complete
            assert one.run(place / f"{one.name}-near").is_complete
            assert one.merge(place / f"{one.name}-far") == one.merge(place / f"{one.name}-near")
    finally:
        far.pool.shutdown()
    copies = list((place / "far" / "scans").iterdir())
    assert len(copies) == 1
    again = pliant.read_volume(copies[0])
    assert (again.array == airway.array).all()
    assert b"encoding: raw" in copies[0].read_bytes()[:2000]
    assert files.table(place / "files-far")[0]["bytes"] == 1000


def needs_program():
    try:
        pliant.program()
    except pliant.Error:
        pytest.skip("the program isn't there")


def test_augmentations_are_those_of_their_seeds(place, airway):
    airway.save(place / "airway.nrrd")
    run = {"what": "augment", "pushes": [1, 2], "push_mm": 5}
    study = Study("augment", run, parameters={"scan": ["airway.nrrd"], "copy": {"count": 3}})
    assert study.run().is_complete
    motions = pliant.augment.TissueMotions(pushes=(1, 2), push_mm=5)
    for item in study.items:
        folder = place / "augment-results" / "items" / item.id[:2] / item.id
        plan = motions.sample(airway, numpy.random.default_rng(item.seed))
        moved = pliant.read_volume(folder / "moved.nrrd")
        assert (moved.array == motions.apply(airway, plan).image.array).all()
        assert pliant.augment.Plan.load(folder / "plan.json") == plan


def test_commands_of_the_program_run_as_items(place, airway):
    needs_program()
    airway.save(place / "airway.nrrd")
    (place / "tissue.toml").write_text("[material]\noffset = 0.2\n")
    deform = Study(
        "deform",
        {
            "what": "deform",
            "scan": "airway.nrrd",
            "config": "tissue.toml",
            "push": "2.5,-1,-9:{by},0,0",
            "tool": "sphere:3",
        },
        parameters={"by": [2.0, 4.0], "config.material.offset": [0.1, 0.3]},
        keep={"files": ["displacement.nrrd"], "results": ["moved_elements", "pushes.0.push_mm.0"]},
    )
    truth = Study(
        "truth",
        {"what": "truth", "motions": 2, "kinds": "slide,contact"},
        parameters={"scan": {"scans": "*.nrrd"}, "case": {"count": 2}},
    )
    fit = Study(
        "fit",
        {"what": "fit", "size": "4,4,4", "load": ["+z:0,0,-1"], "method": ["closed-form"]},
        parameters={"young": [1000.0, 2000.0]},
    )
    for study in (deform, truth, fit):
        hashes = set()
        for threads in (1, 2):
            report = study.run(place / f"{study.name}{threads}", threads=threads, workers=2)
            assert report.is_complete, report
            hashes.add(study.merge(place / f"{study.name}{threads}"))
        assert len(hashes) == 1
    rows = deform.table(place / "deform1")
    assert {row["pushes.0.push_mm.0"] for row in rows} == {2.0, 4.0}
    moved = {(row["by"], row["config.material.offset"]): row["moved_elements"] for row in rows}
    assert moved[4.0, 0.1] > moved[4.0, 0.3] > moved[2.0, 0.3]
    files = {p.name for p in (place / "deform1" / "items").rglob("*") if p.is_file()}
    assert files == {"displacement.nrrd", "manifest.json"}
    item = truth.items[0]
    case = pliant.truth.make_case(airway, seed=item.seed, kinds="slide,contact", motions=2)
    folder = place / "truth1" / "items" / item.id[:2] / item.id
    assert json.loads((folder / "case.json").read_text())["hash"] == f"{case.hash:016x}"
    values = sorted(row["closed-form.values.links"] for row in fit.table(place / "fit1"))
    assert values[1] == pytest.approx(2 * values[0])
    wrong = Study("wrong", {"what": "fit", "size": "4,4"})
    report = wrong.run()
    (line,) = report.failed.values()
    assert "size" in line
    assert "\n" not in line


def test_studies_sweep_settings_of_the_elastic_scan(place, airway):
    needs_program()
    airway.save(place / "airway.nrrd")
    swept = [0.2, 0.45]
    push = {"push": "2.5,-1,-9:3,0,0", "tool": "sphere:5", "steps": 3}
    cases = {
        "deform": ({"what": "deform", **push, "config": {"elastic": {"window_cells": 32}}},
                   "config.elastic.poisson_ratio"),
        "option": ({"what": "deform", **push}, "poisson_ratio"),
        "augment": ({"what": "augment", "pushes": 1, "push_mm": 4, "tissue": {}},
                    "tissue.poisson_ratio"),
        "truth": ({"what": "truth", "kinds": "contact", "motions": 1, "config": {"elastic": {}}},
                  "config.elastic.poisson_ratio"),
        "endoscope": ({"what": "endoscope", "max_steps": 3}, "poisson_ratio"),
    }  # fmt: skip
    tables = {}
    for name, (run, parameter) in cases.items():
        if name == "endoscope":
            pytest.importorskip("gymnasium")
        study = Study(
            name, {"scan": "airway.nrrd", "model": "elastic", **run}, parameters={parameter: swept}
        )
        report = study.run(workers=2)
        assert report.is_complete, report
        tables[name] = sorted(study.table(), key=lambda row: row[parameter])
        assert [row[parameter] for row in tables[name]] == swept
    forces = [
        numpy.linalg.norm([row[f"elastic.force_n.{axis}"] for axis in range(3)])
        for row in tables["deform"]
    ]
    assert forces[0] > 0 and forces[0] != pytest.approx(forces[1], rel=1e-3)
    tissue = pliant.make_elastic(airway, poisson_ratio=0.2, window_cells=32)
    tissue.push((2.5, -1, -9), (3, 0, 0), 5.0)
    tissue.advance(max_steps=3)
    assert forces[0] == pytest.approx(numpy.linalg.norm(tissue.force_n(1)), rel=1e-6)
    assert tables["option"][0]["elastic.force_n.0"] != tables["option"][1]["elastic.force_n.0"]
    assert {row["model"] for row in tables["truth"]} == {"elastic"}
    assert all(row["smallest_jacobian"] > 0 for row in tables["augment"])
    wrong = Study("wrong", {"what": "truth", "scan": "airway.nrrd", "model": "elastic"})
    (line,) = wrong.run().failed.values()
    assert "--kinds: expected contact, slide or breathing" in line


def test_vessels_and_endoscopes_run_as_items(place, airway):
    needs_program()
    pytest.importorskip("gymnasium")
    airway.save(place / "airway.nrrd")
    scenes = pathlib.Path(__file__).resolve().parents[2] / "scenes"
    text = (scenes / "vessel_soft.toml").read_text()
    text = text.replace("until_way_mm = 120", "until_way_mm = 6")
    text = text.replace("for_s = 0.3", "for_s = 0.01")
    (place / "scene.toml").write_text(text)
    vessel = Study(
        "vessel",
        {"what": "vessel", "scene": "scene.toml"},
        parameters={"scene.catheter.length_mm": [150, 160]},
    )
    assert vessel.run().is_complete
    assert len({row["hash"] for row in vessel.table()}) == 2
    flights = Study(
        "flights",
        {"what": "endoscope", "max_steps": 10},
        parameters={"scan": ["airway.nrrd"], "policy": ["guide"], "episode": {"count": 2}},
    )
    assert flights.run().is_complete
    assert all(row["steps"] == 10 for row in flights.table())


def test_the_document_runs(place, airway, capsys):
    needs_program()
    text = (pathlib.Path(__file__).resolve().parents[2] / "docs/howto/study.md").read_text()
    (place / "scans").mkdir()
    airway.save(place / "scans" / "airway.nrrd")
    files = re.findall(r"^```toml\n# (\S+)\n(.*?)^```", text, re.M | re.S)
    assert sorted(name for name, _ in files) == [
        "breathing.toml", "identify.toml", "springs.toml", "stiffness.toml"
    ]  # fmt: skip
    for name, study in files:
        (place / name).write_text(study)
    marked = r"test_study.py runs these commands -->\n```bash\n(.*?)^```"
    (commands,) = re.findall(marked, text, re.M | re.S)
    for command in commands.splitlines():
        words = command.split()
        assert words[:2] == ["pliant", "study"]
        assert main(words[2:]) == 0, capsys.readouterr()
    assert "10 done, 0 failed, 0 left" in capsys.readouterr().out
    assert main(["run", "identify.toml"]) == 0
    assert main(["run", "stiffness.toml"]) == 0
    assert "4 items done" in capsys.readouterr().out
    block, springs = re.findall(r"^```python\n(.*?)^```", text, re.M | re.S)
    exec(compile(block, "study.md", "exec"), {})
    (place / "springs.py").write_text(springs)
    assert main(["search", "springs.toml"]) == 0
    assert (place / "springs-results" / "best.json").exists()


def test_pages_have_a_plot_for_each_pair(place):
    study = small_study(parameters={"x": [1, 2, 3], "n": {"count": 3}})
    study.run(place / "out")
    page = pathlib.Path(study.report(place / "out")).read_text()
    assert page.count("<svg") == 1  # y over x; n only repeats
    assert page.count("<circle") == 9
    assert "9 items: 9 done, 0 failed, 0 left" in page


def test_public_names_have_docstrings():
    bare = []
    for name in study_module.__all__:
        public = getattr(study_module, name)
        bare += [] if (public.__doc__ or "").strip() else [name]
        bare += [
            f"{name}.{title}"
            for title, member in inspect.getmembers(public)
            if not title.startswith("_")
            and (inspect.isroutine(member) or isinstance(member, property))
            and not (member.__doc__ or "").strip()
        ]
    assert bare == []


def test_importing_needs_no_optional_package():
    code = (
        "import sys, pliant.study.__main__; "
        "print({'distributed', 'mpi4py', 'fsspec', 'zarr', 'gymnasium'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
