# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Finite elements on the ranks of mpirun, by the benchmark of python/benchmarks."""

import json
import pathlib
import shutil
import subprocess
import sys

import pytest

pytest.importorskip("mpi4py")
SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "benchmarks/elastic_ranks.py"


@pytest.mark.skipif(shutil.which("mpirun") is None, reason="no mpirun")
def test_the_solution_has_the_same_bits_on_one_and_three_ranks():
    def solve(ranks):
        command = ["mpirun", "--allow-run-as-root", "--oversubscribe", "-n", str(ranks)]
        command += [sys.executable, str(SCRIPT), "--nodes", "30", "--repeat", "1"]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout.splitlines()[-1])

    one, three = solve(1), solve(3)
    assert three["ranks"] == 3 and three["calls"] > 100
    assert three["solution"] == one["solution"]
    assert three["iterations"] == one["iterations"]
