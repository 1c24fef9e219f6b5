# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Shared by tests of the augmentation's skins. They skip without the large packages."""

import importlib.metadata

import numpy
import pytest

import pliant


def skip_without(*names: str) -> None:
    """Skips the module if a package is missing."""
    for name in names:
        try:
            importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            pytest.skip(f"{name} is not installed", allow_module_level=True)


class Case:
    """A scan with landmarks, a label map, and arrays (x, y, z) with an affine in RAS."""

    def __init__(self, seed: int) -> None:
        rng = numpy.random.default_rng(seed)
        phantom = pliant.make_phantom("airway", (48, 40, 44), (2.0, 2.5, 2.2))
        self.xyz = numpy.ascontiguousarray(phantom.array.T)
        self.labels = (self.xyz > -300).astype(numpy.uint8) + (self.xyz > 250)
        turn, _ = numpy.linalg.qr(rng.normal(size=(3, 3)))
        self.affine = numpy.eye(4)
        self.affine[:3, :3] = turn * (2.0, 2.5, 2.2)
        self.affine[:3, 3] = rng.normal(size=3) * 30
        self.voxels = rng.uniform(2, numpy.array(self.xyz.shape) - 3, (50, 3))
        self.points = self.voxels @ self.affine[:3, :3].T + self.affine[:3, 3]  # RAS

    def voxels_of(self, points_ras: numpy.ndarray) -> numpy.ndarray:
        return (points_ras - self.affine[:3, 3]) @ numpy.linalg.inv(self.affine[:3, :3]).T


@pytest.fixture
def case() -> Case:
    seed = int(numpy.random.SeedSequence().entropy % 2**32)
    print(f"seed {seed}")
    return Case(seed)


def ramps(shape: tuple[int, ...]) -> numpy.ndarray:
    """The index x, y, z of each voxel: an image of three channels."""
    axes = [numpy.arange(n, dtype=numpy.float32) for n in shape]
    return numpy.stack(numpy.meshgrid(*axes, indexing="ij"))
