# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Studies whose results are damaged: no command hangs, each says so in a line, a run repeats them.

An undisturbed run is copied, damaged in one place, and given to all commands. The table has to be
that of the undisturbed run in the end.
"""

import concurrent.futures
import errno
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import textwrap
import warnings

import numpy
import pytest

import pliant
from pliant.study import Study
from pliant.study.__main__ import main

SOLVE = """
def solve(x, *, rng):
    return {"y": x * x + rng.normal(), "field": rng.normal(size=(5, 5))}
"""
TOML = """
[parameters]
x = [1, 2, 3]
[run]
what = "python"
function = "solve.py:solve"
"""
OK = {"plan": 0, "status": 0, "verify": 0, "report": 0, "merge": 0}
ITEM = {"plan": 0, "status": 1, "verify": 1, "report": 0, "merge": 1}
ALL = dict.fromkeys(OK, 2)


@pytest.fixture(scope="module")
def quiet(tmp_path_factory):
    """A folder with a study and its results."""
    folder = tmp_path_factory.mktemp("quiet")
    (folder / "solve.py").write_text(SOLVE)
    (folder / "s.toml").write_text(TOML)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLIANT_STUDY_CACHE", str(folder / "cache"))
        with concurrent.futures.ThreadPoolExecutor(1) as threads:
            study = Study.load(folder / "s.toml")
            assert study.run(folder / "s-results", threads).is_complete
        study.merge(folder / "s-results")
    return folder


@pytest.fixture
def place(quiet, tmp_path, monkeypatch):
    monkeypatch.setenv("PLIANT_STUDY_CACHE", str(tmp_path / "cache"))
    for name in ("solve.py", "s.toml"):
        shutil.copy(quiet / name, tmp_path)
    shutil.copytree(quiet / "s-results", tmp_path / "s-results")
    monkeypatch.chdir(tmp_path)
    signal.alarm(60)  # a command that waits for a pipe ends the tests
    yield tmp_path
    signal.alarm(0)


def run(out="s-results"):
    with concurrent.futures.ThreadPoolExecutor(1) as threads:
        return Study.load("s.toml").run(out, threads)


def tables(folder):
    found = folder / "s-results" / "merged"
    return [(found / name).read_bytes() for name in ("table.csv", "manifest.json")]


def told(capsys, command):
    """Status, output and errors of a command; none may be an exception's name."""
    status = main([command, "s.toml"])
    said = capsys.readouterr()
    assert not re.search(r"\b[A-Z]\w*(Error|Exception)\b", said.err + said.out), said
    assert all(len(line) < 900 for line in (said.err + said.out).splitlines())
    return status, said.out, said.err


class Results:
    """The results' folder, and the parts of one item, to damage."""

    def __init__(self, folder):
        self.root = folder / "s-results"
        self.id = Study.load("s.toml").items[1].id
        self.shard = self.root / "items" / self.id[:2]
        self.item = self.shard / self.id
        self.manifest = self.item / "manifest.json"
        self.array = self.item / "field.npy"
        (self.log,) = (self.root / "log").iterdir()

    def other_manifest(self):
        return next(p for p in self.root.glob("items/*/*/manifest.json") if p != self.manifest)

    def change(self, **entries):
        known = json.loads(self.manifest.read_bytes())
        self.manifest.write_text(json.dumps({**known, **entries}))

    def replace(self, path, make):
        """Another thing instead of a file or folder."""
        shutil.rmtree(path) if path.is_dir() else path.unlink()
        make(path)


def rewritten(data):
    return lambda r: r.manifest.write_bytes(data)


def changed(**entries):
    """Other entries of the manifest."""
    return lambda r: r.change(**entries)


def becomes(part, make):
    """Another thing instead of a part of Results, or of a path in its folder."""
    return lambda r: r.replace(getattr(r, part, r.root / part), make)


def flipped(path):
    data = bytearray(path.read_bytes())
    data[-1] ^= 1
    path.write_bytes(data)


def flipped_in_secret(path):
    times = path.stat().st_atime_ns, path.stat().st_mtime_ns
    flipped(path)
    os.utime(path, ns=times)


def grown(path):
    with path.open("ab") as stream:
        stream.truncate(1 << 33)


def link_to(target):
    return lambda path: path.symlink_to(target)


NO_MANIFEST = "manifest.json: expected a file, found none"
OTHER = "manifest.json: expected this item's manifest, found another content"
NO_JSON = "manifest.json: expected JSON"
DAMAGED_ITEMS = {
    "manifest missing": (lambda r: r.manifest.unlink(), NO_MANIFEST),
    "manifest empty": (rewritten(b""), NO_JSON),
    "manifest cut": (lambda r: os.truncate(r.manifest, 100), NO_JSON),
    "manifest a number": (rewritten(b"5"), OTHER),
    "manifest a list": (rewritten(b"[]"), OTHER),
    "manifest null": (rewritten(b"null"), OTHER),
    "manifest without entries": (rewritten(b"{}"), OTHER),
    "manifest of zeros": (rewritten(bytes(300)), NO_JSON),
    "manifest no text": (rewritten(b"\xff\xfe\x00"), NO_JSON),
    "manifest nested": (rewritten(b"[" * 100000), "manifest.json: expected JSON, found too many"),
    "manifest of digits": (rewritten(b"9" * 5000), NO_JSON),
    "manifest endless": (
        lambda r: grown(r.manifest),
        "manifest.json: expected at most 268435456 B, found 8589934592 B",
    ),
    "manifest of another": (lambda r: shutil.copy(r.other_manifest(), r.manifest), OTHER),
    "manifest a folder": (
        becomes("manifest", pathlib.Path.mkdir),
        "manifest.json: expected a file, found a folder",
    ),
    "manifest a pipe": (
        becomes("manifest", os.mkfifo),
        "manifest.json: expected a file, found a pipe",
    ),
    "manifest a device": (
        becomes("manifest", link_to("/dev/zero")),
        "manifest.json: expected a file, found a device",
    ),
    "manifest a loop": (
        becomes("manifest", link_to("manifest.json")),
        f"manifest.json: {os.strerror(errno.ELOOP)}",
    ),
    "manifest a dead link": (becomes("manifest", link_to("no")), NO_MANIFEST),
    "result changed": (
        changed(results={"y": 1.0}),
        "manifest.json: its results differ from its hash",
    ),
    "result not a number": (changed(results={"y": float("nan")}), NO_JSON),
    "hash changed": (changed(hash="0" * 32), "manifest.json: its results differ"),
    "hash a list": (changed(hash=[]), "manifest.json: its results differ"),
    "version changed": (changed(version="0.0.0"), OTHER),
    "files a list": (changed(files=[]), OTHER),
    "files outside": (
        changed(files={"../../../x": {"bytes": 0, "hash": ""}}),
        OTHER,
    ),
    "files none": (changed(files={}), "manifest.json: its results differ"),
    "times missing": (changed(made={}), OTHER),
    "times a text": (
        changed(made={"host": "a", "started": "b", "seconds": "c"}),
        OTHER,
    ),
    "array missing": (lambda r: r.array.unlink(), "field.npy: expected a file, found none"),
    "array empty": (lambda r: r.array.write_bytes(b""), "field.npy: expected 328 B, found 0 B"),
    "array cut": (lambda r: os.truncate(r.array, 327), "field.npy: expected 328 B, found 327 B"),
    "array longer": (lambda r: grown(r.array), "field.npy: expected 328 B, found 8589934592 B"),
    "array changed": (lambda r: flipped(r.array), "field.npy: its bytes differ"),
    "array changed, time kept": (lambda r: flipped_in_secret(r.array), "field.npy: its bytes"),
    "array a folder": (
        becomes("array", pathlib.Path.mkdir),
        "field.npy: expected a file, found a folder",
    ),
    "array a pipe": (
        becomes("array", os.mkfifo),
        "field.npy: expected a file, found a pipe",
    ),
    "array a dead link": (
        becomes("array", link_to("no")),
        "field.npy: expected a file, found none",
    ),
    "item an empty folder": (becomes("item", pathlib.Path.mkdir), NO_MANIFEST),
    "item a file": (becomes("item", pathlib.Path.touch), NO_MANIFEST),
    "item a pipe": (becomes("item", os.mkfifo), NO_MANIFEST),
    "item a dead link": (becomes("item", link_to("no")), NO_MANIFEST),
}


EACH_KIND = (
    "manifest missing",
    "manifest cut",
    "manifest null",
    "manifest a pipe",
    "result changed",
    "array changed, time kept",
    "array a folder",
    "item an empty folder",
)


@pytest.mark.parametrize("name", EACH_KIND)
def test_damaged_items_are_told_set_aside_and_repeated(quiet, place, capsys, name):
    check_damaged_item(quiet, place, capsys, name)


@pytest.mark.parametrize("name", [name for name in DAMAGED_ITEMS if name not in EACH_KIND])
def test_further_damaged_items_are_repeated(quiet, place, capsys, name):
    check_damaged_item(quiet, place, capsys, name)


def check_damaged_item(quiet, place, capsys, name):
    damage, expected = DAMAGED_ITEMS[name]
    results = Results(place)
    damage(results)
    for command, status in ITEM.items():
        found, out, err = told(capsys, command)
        assert found == status, (command, out, err)
        assert command in ("report", "merge") or "1 damaged" in out
        if command in ("status", "verify"):
            assert f"{results.id}  {expected}" in out
        if command == "merge":
            assert f"{results.id}  {expected}" in err
            assert "2 of 3 items" in out
    assert "1 damaged" in (results.root / "report.html").read_text()
    report = run()
    (aside,) = report.damaged.values()
    assert os.path.lexists(aside)
    assert (report.done, report.known, report.is_complete) == (1, 2, True)
    assert f"{results.id}: {expected}" in capsys.readouterr().err
    for command, status in OK.items():
        assert told(capsys, command)[0] == status
    assert tables(place) == tables(quiet)


def lines(*added):
    def damage(results):
        with results.log.open("ab") as stream:
            stream.write(b"".join(added))

    return damage


STRAYS = {
    "items/.DS_Store": lambda r: (r.root / "items/.DS_Store").touch(),
    "items/pipe": lambda r: os.mkfifo(r.root / "items/pipe"),
    "items/AB": lambda r: (r.root / "items/AB").mkdir(),
    "a file of a shard": lambda r: (r.shard / ".DS_Store").touch(),
    "a copy of an item": lambda r: shutil.copytree(r.item, r.shard / f"{r.id} (copy)"),
    "an item in another shard": lambda r: shutil.copytree(r.item, r.root / f"items/zz/{r.id}"),
    "a file of an item": lambda r: (r.item / ".DS_Store").touch(),
    "a folder of an item": lambda r: (r.item / "more").mkdir(),
    "notes.txt": lambda r: (r.root / "notes.txt").touch(),
    "a name in two lines": lambda r: (r.root / "a\n\x1b[31mb").touch(),
    "a name that is no text": lambda r: (r.root / os.fsdecode(b"\xff")).touch(),
    "log/.DS_Store": lambda r: (r.root / "log/.DS_Store").touch(),
    "log/a.jsonl": lambda r: os.mkfifo(r.root / "log/a.jsonl"),
    "log/b.jsonl": lambda r: (r.root / "log/b.jsonl").mkdir(),
    "(4 lines)": lines(b"5\n[]\nnull\n", b'"text"\n'),
    "(3 lines)": lines(b'{"id": 5, "status": "failed"}\n{"id": "a", "status": []}\n{}\n'),
    "(2 lines)": lines(
        b'{"id": "a", "status": "failed", "started": "noon"}\n',
        b'{"id": "a", "status": "failed", "started": 1%s}\n' % (b"0" * 400),
    ),
    "(1 lines)": lines(b"[" * 100000 + b"\n"),
    "(9 lines)": lines(*([b"\xff\xfe\n"] * 9)),
}


FEW_STRAYS = ("items/.DS_Store", "a file of an item", "log/a.jsonl", "(4 lines)")


@pytest.mark.parametrize("name", FEW_STRAYS)
def test_strays_are_ignored_with_a_note(quiet, place, capsys, name):
    check_stray(quiet, place, capsys, name)


@pytest.mark.parametrize("name", [name for name in STRAYS if name not in FEW_STRAYS])
def test_further_strays_are_ignored(quiet, place, capsys, name):
    check_stray(quiet, place, capsys, name)


def check_stray(quiet, place, capsys, name):
    STRAYS[name](Results(place))
    for command, status in OK.items():
        found, out, err = told(capsys, command)
        assert found == status, (command, out, err)
        if command in ("plan", "status", "verify"):
            assert err.startswith("pliant study: note: no part of the results, and ignored: ")
            assert err.count("\n") == 1
            assert name in err or not re.search(r"[/(]", name)
    report = run()
    assert (report.done, report.known, report.damaged) == (0, 3, {})
    assert "note: " in capsys.readouterr().err
    assert tables(place) == tables(quiet)


def test_an_unfinished_line_of_a_log_is_no_stray(place, capsys):
    lines(b'{"id": "a", "stat')(Results(place))
    assert told(capsys, "status") == (0, "3 done, 0 failed, 0 left\n", "")


NO_FOLDER = "expected a folder, found a file; move it away"
NO_STUDY = "study.json: expected a study's results, found another file; remove it, and run"
FAULTS = {  # the damage, and the commands that report it with status 2
    "items a file": (
        becomes("items", pathlib.Path.touch), {**ALL, "run": 2}, NO_FOLDER
    ),
    "a shard a file": (
        becomes("shard", pathlib.Path.touch), {**ALL, "run": 2}, NO_FOLDER
    ),
    "a shard a pipe": (becomes("shard", os.mkfifo), {**ALL, "run": 2}, NO_FOLDER),
    "log a file": (
        lambda r: r.replace(r.root / "log", pathlib.Path.touch),
        {"plan": 2, "status": 2, "verify": 2, "report": 2, "merge": 0, "run": 2},
        NO_FOLDER,
    ),
    "the folder a file": (
        becomes("root", pathlib.Path.touch),
        {**ALL, "run": 2},
        "s-results",
    ),
    "study.json empty": (lambda r: os.truncate(r.root / "study.json", 0), {"run": 2}, NO_STUDY),
    "study.json cut": (lambda r: os.truncate(r.root / "study.json", 9), {"run": 2}, NO_STUDY),
    "study.json a list": (
        lambda r: (r.root / "study.json").write_text("[]"), {"run": 2}, NO_STUDY
    ),
    "study.json a pipe": (
        becomes("study.json", os.mkfifo),
        {"run": 2},
        "study.json: expected a file, found a pipe",
    ),
    "study.json a folder": (
        becomes("study.json", pathlib.Path.mkdir),
        {"run": 2},
        "study.json: expected a file, found a folder",
    ),
    "tmp a file": (
        becomes("tmp", pathlib.Path.touch),
        {"report": 2, "merge": 2, "run": 2},
        "/tmp: ",
    ),
    "merged a file": (
        becomes("merged", pathlib.Path.touch),
        {"merge": 2},
        "merged: can't be written (",
    ),
    "a table a folder": (
        becomes("merged/table.csv", pathlib.Path.mkdir),
        {"merge": 2},
        "merged/table.csv: can't be written (Is a directory)",
    ),
    "its manifest a folder": (
        becomes("merged/manifest.json", pathlib.Path.mkdir),
        {"merge": 2},
        "merged/manifest.json: can't be written (Is a directory)",
    ),
    "the report a folder": (
        lambda r: (r.root / "report.html").mkdir(),
        {"report": 2},
        "report.html: can't be written (Is a directory)",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_of_the_folder_are_one_line(quiet, place, capsys, name):
    damage, statuses, expected = FAULTS[name]
    damage(Results(place))
    for command in (*OK, "run"):
        status, out, err = told(capsys, command)
        assert status == statuses.get(command, 0), (command, out, err)
        if status:
            assert err.startswith("pliant study: "), err
            assert err.count("\n") == 1
            assert expected in err
            assert not out
    results = place / "s-results"
    assert not results.is_dir() or not list(results.rglob("*~*"))


def test_a_changed_byte_that_no_time_tells_is_found_by_verify(quiet, place, capsys):
    """As a disk's fault: the file is not newer than its manifest."""
    results = Results(place)
    flipped(results.array)
    os.utime(results.manifest)
    while results.manifest.stat().st_ctime_ns <= results.array.stat().st_ctime_ns:
        os.utime(results.manifest)
    assert told(capsys, "status")[0] == 0
    assert told(capsys, "verify")[0] == 1
    assert told(capsys, "status")[0] == 1, "the log knows"
    report = run()
    assert list(report.damaged) == [results.id]
    for command, status in OK.items():
        assert told(capsys, command)[0] == status
    assert tables(place) == tables(quiet)


def test_tables_of_python_warn_of_damaged_items(place):
    results = Results(place)
    results.manifest.write_bytes(b"")
    study = Study.load("s.toml")
    for make in (study.merge, study.table):
        with pytest.warns(UserWarning, match=f"1 damaged items are left out.*{results.id}: manif"):
            make("s-results")
    assert list(study.verify("s-results").damaged) == [results.id]
    run()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert len(study.table("s-results")) == 3


def test_an_item_that_appears_damaged_during_a_run_is_set_aside(place):
    from pliant.study._store import FolderStore

    results = Results(place)
    store = FolderStore(str(results.root))
    manifest = store.manifest(results.id)
    results.manifest.unlink()
    staged = store.staging(results.id)
    numpy.save(f"{staged}/field.npy", numpy.zeros(3))
    store.commit(results.id, staged, manifest)
    assert store.manifest(results.id) == manifest
    assert len(list((results.root / "damaged").iterdir())) == 1
    again = store.staging(results.id)
    store.commit(results.id, again, {**manifest, "results": {}})
    assert store.manifest(results.id) == manifest, "the first one counts"
    assert not list((results.root / "tmp").iterdir())


def test_full_and_read_only_disks_are_one_line(place, capsys):
    disk = place / "s-results"
    away = disk.rename(place / "away")
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=1m", "pliant-test", str(disk)]
    if os.geteuid() or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("needs the right to mount")
    try:
        shutil.copytree(away, disk, dirs_exist_ok=True)
        before = tables(place)
        with pytest.raises(OSError, match="No space left"):
            (disk / "fill").write_bytes(bytes(1 << 20))
        for command in ("merge", "report"):
            status, out, err = told(capsys, command)
            assert (status, out) == (2, "")
            assert re.fullmatch(r"pliant study: \S+: can't be written \(No space left.*\)\n", err)
        assert told(capsys, "verify")[0] == 0
        (disk / "fill").unlink()
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        for command in ("merge", "report"):
            status, out, err = told(capsys, command)
            assert (status, out) == (2, "")
            assert re.fullmatch(r"pliant study: \S+: can't be written \(Read-only .*\)\n", err)
        for command in ("plan", "status", "verify", "run"):
            assert told(capsys, command)[0] == 0
        assert tables(place) == before
        assert not list(disk.rglob("*~*"))
    finally:
        subprocess.run(["umount", "-l", str(disk)], check=True)


def test_an_output_that_fails_is_one_line(place):
    for words in (["status", "s.toml"], ["plan", "s.toml"]):
        with open("/dev/full", "w") as full:
            done = subprocess.run(
                [sys.executable, "-m", "pliant.study", *words],
                stdout=full,
                stderr=subprocess.PIPE,
                env={**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
                text=True,
                check=False,
            )
        expected = f"pliant study: standard output: {os.strerror(errno.ENOSPC)}\n"
        assert (done.returncode, done.stderr) == (2, expected)


def test_the_help_has_a_study(place, capsys):
    assert main(["--help"]) == 0
    text = capsys.readouterr().out
    (study,) = re.findall(r"^a study, press.toml:\n(.*?)\n\n", text, re.M | re.S)
    (place / "press.toml").write_text(textwrap.dedent(study))
    (place / "press.py").write_text("def press(young_pa, depth_mm, copy):\n    return {}\n")
    assert len(Study.load("press.toml").items) == 140
    commands = re.findall(r"^  pliant study (\w+) press.toml", text, re.M)
    assert commands == ["plan", "run", "run", "status", "verify", "merge"]
    for command in ("plan", "status"):
        assert main([command, "press.toml"]) == (command == "status")


def test_unexpected_errors_are_one_line(place, capsys, monkeypatch):
    for error, expected in (
        (KeyError("x"), "KeyError: 'x'"),
        (MemoryError(), "out of memory"),
        (RecursionError(), "expected fewer levels of lists and tables, found too many"),
        (OSError(errno.EIO, "Input/output error", "a.json"), "a.json: Input/output error"),
        (pliant.Error("a\nb" + "c" * 10**6), f"a b{'c' * 197} ... {'c' * 199}…"),
    ):

        def fail(*_, error=error, **__):
            raise error

        monkeypatch.setattr(Study, "status", fail)
        assert main(["status", "s.toml"]) == 2
        assert capsys.readouterr().err == f"pliant study: {expected}\n"


@pytest.fixture
def inputs(tmp_path, monkeypatch):
    monkeypatch.setenv("PLIANT_STUDY_CACHE", str(tmp_path / "cache"))
    from pliant.study import _inputs

    return _inputs


def test_a_damaged_copy_of_an_input_is_sent_again(inputs, tmp_path):
    (tmp_path / "a.txt").write_text("right")
    found = inputs.input_of(str(tmp_path), "a.txt", is_scan=False)
    (tmp_path / "a.txt").unlink()
    for _ in range(2):
        with pytest.raises(inputs.Missing):
            inputs.local(found)
        inputs.keep_copy(found, b"right")
        copy = pathlib.Path(inputs.local(found))
        assert copy.read_text() == "right" and tmp_path / "cache" in copy.parents
        copy.write_text("wrong")


def test_a_url_that_has_changed_is_refused(inputs, tmp_path):
    memory = pytest.importorskip("fsspec").filesystem("memory")
    memory.pipe_file("/pliant/a.txt", b"right")
    found = inputs.input_of(str(tmp_path), "memory://pliant/a.txt", is_scan=False)
    memory.pipe_file("/pliant/a.txt", b"wrong")
    with pytest.raises(pliant.Error, match=r"memory://pliant/a\.txt: has changed since the study"):
        inputs.local(found)
    memory.pipe_file("/pliant/a.txt", b"right")
    assert pathlib.Path(inputs.local(found)).read_text() == "right"
