# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Run in an empty folder by a Python that has a wheel alone: the program, a push, materials."""

import subprocess
import sys

import pliant


def run(*arguments):
    command = [sys.executable, "-m", "pliant", *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


version = ".".join(map(str, sys.version_info[:3]))
print(f"Python {version}, pliant {run('--version').strip()}", end=", ")
run("phantom", "airway", "--size", "64", "--out", "airway.nrrd")
tissue = pliant.make_chainmail(pliant.read_volume("airway.nrrd"))
report = tissue.push((2.5, -1, -9), (6, 0, 0), sphere_radius_mm=3)
assert report.moved_elements > 1000, report
tissue.volume().save("pushed.nrrd")
assert "64 × 64 × 64 voxels" in run("info", "pushed.nrrd")
assert len(pliant.materials()) > 5
print(f"{report.moved_elements} voxels moved, {len(pliant.materials())} materials")
