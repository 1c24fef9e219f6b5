# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A tissue of one's own: jelly, as in examples/own_tissue.

A tool drags a Gaussian bump along; a bump without a tool decays.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy

import pliant


class Jelly(pliant.Tissue):
    model = "jelly"
    sweep_ms = 10.0

    def __init__(self, scan: pliant.Volume, threads: int = 1) -> None:
        super().__init__(scan, threads)
        self.centre = numpy.zeros(3)
        self.shift = numpy.zeros(3)
        self.tool = 0

    def push(
        self,
        point_mm: Any,
        push_mm: Any,
        sphere_radius_mm: float = 0.0,
        tool: int = 1,
    ) -> pliant.PushReport:
        goes_on = tool == self.tool
        numbers = [*point_mm, *push_mm, sphere_radius_mm]
        if sphere_radius_mm < 0 or not numpy.isfinite(numbers).all():
            raise pliant.Error("expected finite numbers, and a radius of 0 or more")
        self.move(
            self.centre if goes_on else numpy.array(point_mm),
            numpy.array(push_mm) + (self.shift if goes_on else 0),
        )
        self.tool = tool
        return pliant.PushReport(grabbed_elements=1)

    def release(self, tool: int = 1) -> None:
        self.tool = 0 if tool == self.tool else self.tool

    def force_n(self, tool: int = 1) -> tuple[float, float, float] | None:
        x, y, z = -0.2 * self.shift if tool == self.tool else (0.0, 0.0, 0.0)
        return float(x), float(y), float(z)

    def sweep(self) -> bool:
        """Returns whether it has come to rest."""
        if self.tool or not self.shift.any():
            return True
        self.move(self.centre, 0.9 * self.shift if numpy.linalg.norm(self.shift) > 0.01 else 0)
        return False

    def reset(self) -> None:
        self.move(self.centre, 0)

    def state(self) -> Sequence[float]:
        return [*self.centre, *self.shift]

    def set_state(self, numbers: Any) -> None:
        if len(numbers) != 6 or not numpy.isfinite(numbers).all():
            raise pliant.Error(f"expected six finite numbers, found {numbers}")
        self.tool = 0
        self.move(numbers[:3], numbers[3:])

    def move(self, centre: Any, shift: Any) -> None:
        centre, shift = numpy.array(centre, float), shift * numpy.ones(3)
        first, x = self.around(self.centre)
        self.displace(numpy.zeros(x.shape), first)
        first, x = self.around(centre)
        square = ((x - centre) ** 2).sum(-1, keepdims=True)
        self.displace(numpy.exp(-square / (2 * 6**2)) * shift, first)
        self.centre, self.shift = centre, shift

    def around(self, centre: Any) -> tuple[list[int], Any]:
        """First voxel, and positions [mm], of the box of 18 mm to each side of a point."""
        step = numpy.array(self.scan.direction) * self.scan.spacing_mm
        reach = 18 / numpy.array(self.scan.spacing_mm)
        first = numpy.floor(self.scan.voxel_from_world(centre) - reach).astype(int)
        k, j, i = numpy.indices((numpy.ceil(2 * reach).astype(int)[::-1] + 1).tolist())
        return first.tolist(), self.scan.origin_mm + (numpy.stack([i, j, k], -1) + first) @ step.T
