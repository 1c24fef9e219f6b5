# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A user's program, for mypy alone."""

import numpy
import numpy.typing

import pliant
from pliant import truth


def moved(path: str) -> numpy.typing.NDArray[numpy.float64]:
    scan = pliant.read_volume(path)
    tissue = pliant.make_chainmail(scan, threads=1, offset=0.2)
    report = tissue.push(scan.world_from_voxel((1, 2, 3)), numpy.array([1.0, 0, 0]))
    if report.status != "applied":
        raise pliant.Error(report.message)
    tissue.volume().save("pushed.nrrd")
    return tissue.displacement_field().apply_to_points([scan.origin_mm])


def scored(path: str) -> float:
    case = truth.make_case(pliant.read_volume(path), seed=7, threads=1, kinds="slide")
    points: numpy.typing.NDArray[numpy.float64] = case.moving_from_fixed([(0, 0, 0)])
    assert points.shape == (1, 3)
    return float(truth.score(case, case.forward)["moved"]["mean_mm"])
