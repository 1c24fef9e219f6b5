# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A scan and the program, for both files of tests."""

import os
import pathlib
import shutil
import subprocess
import time

import numpy
from PliantLib import logic

HERE = pathlib.Path(__file__).resolve().parent
MODULE = HERE.parent / "Pliant"
START = numpy.array([4.0, -6.0, 9.0])  # RAS, in tissue
END = START + [3.0, 2.0, -1.0]
RADIUS_MM = 5.0


def program():
    """PLIANT_PROGRAM, else this tree's build, else that of PATH."""
    built = HERE.parents[2] / "build" / "gcc" / "pliant"
    found = os.environ.get("PLIANT_PROGRAM") or (str(built) if built.exists() else None)
    found = found or shutil.which("pliant")
    assert found, "expected the program pliant: set PLIANT_PROGRAM"
    return found


def scan(dtype="int16"):
    """Soft tissue with an air-filled hole and waves in it, on an oblique left-handed grid.

    The array (k, j, i), and RAS from ijk.
    """
    k, j, i = numpy.meshgrid(*(numpy.arange(n) for n in (26, 28, 30)), indexing="ij")
    waves = 40 + 30 * numpy.sin(0.9 * i) * numpy.cos(0.7 * j) * numpy.sin(0.8 * k)
    hole = (i - 15) ** 2 + (j - 20) ** 2 < 16
    voxels = numpy.rint(numpy.where(hole, -1000, waves)).astype(dtype)
    a, b = 0.3, -0.2
    turn = numpy.array([[numpy.cos(a), -numpy.sin(a), 0], [numpy.sin(a), numpy.cos(a), 0],
                        [0, 0, 1]])  # fmt: skip
    tilt = numpy.array([[1, 0, 0], [0, numpy.cos(b), -numpy.sin(b)],
                        [0, numpy.sin(b), numpy.cos(b)]])  # fmt: skip
    matrix = numpy.eye(4)
    matrix[:3, :3] = turn @ tilt @ numpy.diag([-2.0, 2.5, 3.0])
    matrix[:3, 3] = START - matrix[:3, :3] @ [14, 12, 13]
    return voxels, matrix


def deform(folder, voxels, matrix):
    """`pliant deform` by the push of the tests: the volume, the displacement, the transform."""
    logic.write_nrrd(folder / "rest.nrrd", voxels, matrix)
    point, vector = (",".join(repr(v) for v in logic.lps(p)) for p in (START, END - START))
    names = [folder / name for name in ("out.nrrd", "displacement.nrrd", "transform.nrrd")]
    subprocess.run(
        [program(), "deform", folder / "rest.nrrd", "--push", f"{point}:{vector}", "--tool",
         f"sphere:{RADIUS_MM}", "--out", names[0], "--displacement", names[1], "--transform",
         names[2]], check=True, capture_output=True)  # fmt: skip
    return [name.read_bytes() for name in names]


def wait_until(happened, timeout_s=30.0):
    """Repeats a check until it is true."""
    end = time.monotonic() + timeout_s
    while not happened():
        assert time.monotonic() < end, "expected a change"
        time.sleep(0.01)
