# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Studies that are interrupted or terminated end in silence, in their imports too."""

import os
import signal
import subprocess
import sys
import time

import pytest

from pliant.study import LocalPool, _local

HOOK = """
import os, signal, sys

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == os.environ["PLIANT_TEST_INTERRUPTED"]:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Interrupt())
"""


@pytest.fixture
def hook(tmp_path, monkeypatch):
    """Interrupts other processes when they import a module."""
    (tmp_path / "sitecustomize.py").write_text(HOOK)
    path = os.pathsep.join([str(tmp_path), *(p for p in sys.path if p)])
    monkeypatch.setenv("PYTHONPATH", path)
    monkeypatch.setenv("PLIANT_STUDY_CACHE", str(tmp_path / "cache"))
    return lambda module: monkeypatch.setenv("PLIANT_TEST_INTERRUPTED", module)


def test_an_interrupted_import_of_the_command_is_silent(hook):
    hook("pliant.study._plan")
    done = subprocess.run(
        [sys.executable, "-m", "pliant.study", "plan", "none.toml"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGINT, "", "")


def test_an_interrupted_import_elsewhere_is_an_exception(hook):
    hook("pliant._core")
    code = "try:\n    import pliant\nexcept KeyboardInterrupt:\n    print('caught')\n"
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "caught\n", "")


def test_workers_are_not_interrupted_in_their_imports(hook):
    hook("pliant.study._local")
    pool = LocalPool(1)
    try:
        assert pool.submit(len, "abc").result() == 3
    finally:
        pool.shutdown()


@pytest.mark.parametrize("moment", ["imports", "works"])
def test_workers_whose_caller_is_gone_end_in_silence(capfd, moment):
    worker = _local._Process(1)
    if moment != "imports":
        assert worker.is_ready()
    if moment == "works":
        worker.connection.send((time.sleep, (0.2,)))
    worker.connection.close()
    assert worker.process.wait(60) == 0
    assert capfd.readouterr().err == ""
