# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A user's program, for mypy alone."""

import numpy
import numpy.typing

import pliant


def moved(path: str) -> numpy.typing.NDArray[numpy.float64]:
    scan = pliant.read_volume(path)
    tissue = pliant.make_chainmail(scan, threads=1, offset=0.2)
    report = tissue.push(scan.world_from_voxel((1, 2, 3)), numpy.array([1.0, 0, 0]))
    if report.status != "applied":
        raise pliant.Error(report.message)
    tissue.volume().save("pushed.nrrd")
    return tissue.displacement_field().apply_to_points([scan.origin_mm])
