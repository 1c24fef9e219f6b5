# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Runs `results_beside`, the program of the bodies and rods; RESULTS_BESIDE names it."""

import json
import os
import subprocess

import numpy as np


def run_program(kind, **numbers):
    """Returns the set-up time, the nodes at rest, and (cpu, wall, nodes) of each checkpoint."""
    words = [f"{name}={value}" for name, value in numbers.items()]
    done = subprocess.run(
        [os.environ["RESULTS_BESIDE"], kind, *words], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    lines = [json.loads(line) for line in done.stdout.splitlines()]
    nodes = [np.array(line["x"]).reshape(-1, 3) for line in lines]
    points = [(a["cpu"], a["wall"], x) for a, x in zip(lines[1:], nodes[1:], strict=True)]
    return (lines[0]["cpu"], lines[0]["wall"]), nodes[0], points
