# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Wrong files of studies, and wrong commands: one line with the file, the field and the value."""

import os

import pytest

from pliant.study.__main__ import main

SIZE_OF = """
import os

def size_of(path):
    return {"bytes": os.path.getsize(path)}
"""


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    monkeypatch.setenv("PLIANT_STUDY_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "solve.py").write_text(SIZE_OF)
    return tmp_path


BAD = {
    "no.toml": (None, "no.toml: No such file"),
    "syntax.toml": ("[study", "syntax.toml: expected TOML"),
    "table.toml": ("study = 3\n[run]\nwhat = 'fit'", "study: expected a table, found 3"),
    "unknown.toml": ("[stydy]\n", ".stydy: expected one of study, parameters"),
    "run.toml": ("[study]\nseed = 1", "run: expected a table with what, found none"),
    "what.toml": ("[run]\nwhat = 'bend'", "run.what: expected one of deform, augment"),
    "seed.toml": ("[study]\nseed = -1\n[run]\nwhat = 'fit'", "study.seed: expected a whole number"),
    "name.toml": ("[study]\nname = 'a/b'\n[run]\nwhat = 'fit'", "study.name: expected letters"),
    "empty.toml": ("[parameters]\nx = []\n[run]\nwhat = 'fit'", "parameters.x: expected a list"),
    "span.toml": (
        "[parameters]\nx = {low = 2, high = 1}\n[sample]\ncount = 2\n[run]\nwhat = 'fit'",
        "parameters.x.high: expected more than 2",
    ),
    "count.toml": (
        "[parameters]\nx = {low = 1, high = 2}\n[run]\nwhat = 'fit'",
        "sample.count: expected the number of samples of x, found none",
    ),
    "method.toml": (
        "[parameters]\nx = {low = 1, high = 2}\n[sample]\nmethod = 'sobol'\ncount = 2\n"
        "[run]\nwhat = 'fit'",
        "sample.method: expected random or latin-hypercube, found sobol",
    ),
    "glob.toml": (
        "[parameters]\nscan = {scans = 'no*.nrrd'}\n[run]\nwhat = 'truth'",
        "parameters.scan.scans: expected files, found none that match no*.nrrd",
    ),
    "scan.toml": ("[run]\nwhat = 'deform'", "run.scan: expected it here or as a parameter"),
    "file.toml": ("[run]\nwhat = 'deform'\nscan = 'no.nrrd'", "no.nrrd: No such file"),
    "function.toml": (
        "[run]\nwhat = 'python'\nfunction = 'solve'",
        "run.function: expected module:function or path.py:function, found solve",
    ),
    "module.toml": (
        "[run]\nwhat = 'python'\nfunction = 'no_such_module:f'",
        "run.function: expected a module on Python's path",
    ),
    "braces.toml": (
        "[run]\nwhat = 'fit'\nload = '{force}'",
        "run: expected names of parameters in braces, found {force}",
    ),
    "timeout.toml": ("[run]\nwhat = 'fit'\ntimeout_s = 'long'", "run.timeout_s: expected seconds"),
    "levels.toml": (
        f"[run]\nwhat = 'fit'\nload = {'[' * 3000}{']' * 3000}",
        "expected TOML, found too many levels",
    ),
    "dots.toml": (
        f"[run]\nwhat = 'fit'\na{'.a' * 1200} = 1",
        "run: expected at most 100 levels of lists and tables, found more",
    ),
    "glob_levels.toml": (
        f"[parameters]\nscan.files{'.a' * 1200} = 1\n[run]\nwhat = 'deform'",
        "expected tables, found too many levels",
    ),
    "digits.toml": (f"[study]\nseed = {'9' * 5000}\n[run]\nwhat = 'fit'", "expected TOML, Exceeds"),
    "long.toml": (
        f"[study]\nname = '{'a' * 50000}/{'b' * 50000}'\n[run]\nwhat = 'fit'",
        f"study.name: expected letters, digits, -, _ and ., found {'a' * 30} ... {'b' * 30}",
    ),
    "product.toml": (
        "[parameters]\n" + "".join(f"p{n} = {{count = 1000}}\n" for n in range(12))
        + "[run]\nwhat = 'fit'",
        f"expected at most 2000000 items; make several studies of them, found 1{'0' * 36}",
    ),
    "product_of_samples.toml": (
        "[parameters]\nx = {low = 1, high = 2}\nn = {count = 2000}\n[sample]\ncount = 1001\n"
        "[run]\nwhat = 'fit'",
        "expected at most 2000000 items; make several studies of them, found 2002000",
    ),
    "many.toml": (
        "[parameters]\nx = {count = 1000000000000}\n[run]\nwhat = 'fit'",
        "parameters.x.count: expected at most 2000000, found 1000000000000",
    ),
    "steps.toml": (
        "[parameters]\nx = {low = 1, high = 2, steps = 9999999999}\n[run]\nwhat = 'fit'",
        "parameters.x.steps: expected at most 2000000, found 9999999999",
    ),
    "samples.toml": (
        "[parameters]\nx = {low = 1, high = 2}\n[sample]\ncount = 9999999999\n"
        "[run]\nwhat = 'fit'",
        "sample.count: expected at most 2000000, found 9999999999",
    ),
    "infinite.toml": (
        "[parameters]\nx = {low = 1, high = inf}\n[sample]\ncount = 2\n[run]\nwhat = 'fit'",
        "parameters.x.high: expected a number of at most 1e+300, found inf",
    ),
    "keep.toml": ("[run]\nwhat = 'fit'\n[keep]\nfiles = 'a'", "keep.files: expected a list"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_wrong_study_is_told_in_one_line(place, capsys, name):
    text, expected = BAD[name]
    if text is not None:
        (place / name).write_text(text)
    for command in ("plan", "run"):
        assert main([command, name]) == 2
        told = capsys.readouterr()
        assert told.err.count("\n") == 1
        assert len(told.err) < 700
        assert told.err.startswith(f"pliant study: {name}: ")
        assert expected in told.err
        assert not told.out
    assert not list(place.glob("*-results"))


def test_a_file_that_would_be_waited_for_is_refused(place, capsys):
    os.mkfifo(place / "pipe")
    (place / "folder").mkdir()
    (place / "files.toml").write_text(
        "[parameters]\npath = {files = 'pipe'}\n[run]\nwhat = 'python'\n"
        "function = 'solve.py:size_of'\n"
    )
    for name, expected in (
        ("pipe", "pipe: expected a file, found a pipe"),
        ("folder", "folder: expected a file, found a folder"),
        ("/dev/zero", "/dev/zero: expected a file, found a device"),
        ("files.toml", f"files.toml: {place}/pipe: expected a file, found a pipe"),
    ):
        assert main(["plan", name]) == 2
        assert capsys.readouterr().err == f"pliant study: {expected}\n"


def test_wrong_commands_are_told_in_one_line(place, capsys):
    (place / "fit.toml").write_text("[run]\nwhat = 'fit'\n")
    for words, expected in (
        (["bend", "fit.toml"], "invalid choice"),
        (["run", "fit.toml", "--engine", "slurm"], "engine: expected local, dask://HOST:PORT, mpi"),
        (["run", "fit.toml", "--workers", "-1"], "--workers"),
        (["run", "fit.toml", "--out", "fit.toml/x"], "can't be written"),
        (["run", "fit.toml", "--out", "nosuch://a/b"], "nosuch://a/b"),
    ):
        assert main(words) == 2, words
        told = capsys.readouterr()
        assert told.err.count("\n") == 1
        assert expected in told.err
