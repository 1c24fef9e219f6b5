# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The branches of a lumen: its ends, and the paths that lead to them.

The lumen around the root is flooded. The voxel that is farthest from the root, and not near a path
yet, is the next end; find_lumen_path leads there [Sato2000, TEASAR, with centred paths]. A path's
branch points are where other paths leave it; the generation of its end is their number, so a
trachea has generation 0 and main bronchi have 1.
"""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy
import numpy.typing

from pliant._core import Volume, find_lumen_path
from pliant._error import Error

Points = numpy.typing.NDArray[numpy.float64]

_STEP_MM = 1.0  # of a path's points
_APART = 0.6  # of the radius: paths that are farther apart have parted
_APART_MM = 1.5
_ONE_BRANCH_MM = 4.0  # branch points that are closer to each other are one
_BACK = 0.6  # of the root's radius: a wider branch leads back out of the lumen
_TIP = 0.7  # of a branch's radius: its last point with that is the end
_TIP_MM = 15.0


@dataclasses.dataclass(frozen=True)
class LumenEnd:
    """An end of a lumen's branch.

    Attributes:
        point_mm: The end, LPS.
        generation: Number of branch points on the way.
        path_mm: Points (n, 3) from the root to the end, 1 mm apart.
        radius_mm: Distance of each to the wall.
        branches_mm: Branch points, by their distance from the root along the path.
    """

    point_mm: tuple[float, float, float]
    generation: int
    path_mm: Points
    radius_mm: Points
    branches_mm: tuple[float, ...]

    @property
    def length_mm(self) -> float:
        """Length of the path."""
        return float(_lengths(self.path_mm)[-1])


def _lengths(points: Points) -> Points:
    steps = numpy.linalg.norm(numpy.diff(points, axis=0), axis=1)
    return numpy.concatenate([[0.0], numpy.cumsum(steps)])


def _resampled(points: Points, radii: Points) -> tuple[Points, Points]:
    length = _lengths(points)
    at = numpy.linspace(0, length[-1], max(2, int(round(length[-1] / _STEP_MM)) + 1))
    even = numpy.stack([numpy.interp(at, length, points[:, a]) for a in range(3)], axis=1)
    return even, numpy.interp(at, length, radii)


class _Flood:
    """The lumen's voxels around a root, with their distance from it in steps."""

    def __init__(
        self, scan: Volume, root_mm: tuple[float, float, float], iso_hu: float, polarity: str
    ) -> None:
        values = scan.array
        lumen = values < iso_hu if polarity == "rising" else values >= iso_hu
        padded = numpy.zeros(numpy.array(lumen.shape) + 2, bool)
        padded[1:-1, 1:-1, 1:-1] = lumen
        nz, ny, nx = padded.shape
        flat = padded.ravel()
        root = numpy.round(scan.voxel_from_world(root_mm)).astype(int)
        frontier = numpy.array([((root[2] + 1) * ny + root[1] + 1) * nx + root[0] + 1])
        inside = all(0 <= root[a] < scan.size[a] for a in range(3))
        if not inside or not flat[frontier[0]]:
            raise Error(
                f"start_mm: expected a position in a lumen, found {tuple(root_mm)}",
                field="start_mm",
            )
        steps = numpy.full(flat.size, -1, numpy.int32)
        steps[frontier] = 0
        neighbours = numpy.array([1, -1, nx, -nx, nx * ny, -nx * ny])
        count = 0
        while frontier.size:
            count += 1
            near = numpy.unique((frontier[:, None] + neighbours).ravel())
            frontier = near[flat[near] & (steps[near] < 0)]
            steps[frontier] = count
        found = numpy.flatnonzero(steps >= 0)
        k, rest = numpy.divmod(found, nx * ny)
        j, i = numpy.divmod(rest, nx)
        voxels = numpy.stack([i, j, k], axis=1) - 1
        axes = numpy.array(scan.direction) * numpy.array(scan.spacing_mm)
        self.steps = steps[found]
        self.points_mm: Points = voxels @ axes.T + numpy.array(scan.origin_mm)
        self.is_covered = numpy.zeros(found.size, bool)

    def cover(self, path_mm: Points, radius_mm: Points, beside_mm: float) -> None:
        """Marks the voxels near a path."""
        for point, radius in zip(path_mm, radius_mm):
            left = numpy.flatnonzero(~self.is_covered)
            near = self.points_mm[left] - point
            within = 1.4 * radius + beside_mm
            self.is_covered[left[(near * near).sum(axis=1) <= within * within]] = True


def _parting(path: Points, radius: Points, other: Points) -> int | None:
    """Index of the point where a path leaves another; None if it doesn't."""
    far = numpy.linalg.norm(path[:, None] - other[None], axis=2).min(axis=1)
    apart = numpy.flatnonzero(far > numpy.maximum(_APART_MM, _APART * radius))
    return int(apart[0]) if apart.size else None


def _without_tip(path: Points, radius: Points) -> tuple[Points, Points]:
    """Leaves out the last millimetres, between the walls of a blind end."""
    wide = numpy.flatnonzero(radius >= _TIP * numpy.median(radius[-int(_TIP_MM / _STEP_MM) :]))
    return path[: wide[-1] + 1], radius[: wide[-1] + 1]


def _leads_back(radius: Points) -> bool:
    return bool(numpy.median(radius[-int(_TIP_MM / _STEP_MM) :]) > _BACK * radius[:5].max())


def find_lumen_ends(
    scan: Volume,
    root_mm: tuple[float, float, float],
    iso_hu: float = -500.0,
    polarity: str = "rising",
    min_length_mm: float = 6.0,
    max_ends: int = 64,
    threads: int = 0,
) -> list[LumenEnd]:
    """Finds the ends of a lumen's branches that can be reached from a root.

    Args:
        root_mm: In the lumen, LPS. Branches that are nearly as wide lead back out of it, and
            have no end.
        min_length_mm: Shorter branches are none.

    Returns:
        The ends, sorted by generation, then by position.

    Raises:
        pliant.Error: The root is not in a lumen.
    """
    flood = _Flood(scan, root_mm, iso_hu, polarity)
    beside_mm = 1.5 * max(scan.spacing_mm)
    paths: list[tuple[Points, Points]] = []
    while len(paths) < max_ends and not flood.is_covered.all():
        left = numpy.flatnonzero(~flood.is_covered)
        far = left[numpy.argmax(flood.steps[left])]
        try:
            path, radius = path_to(
                scan, root_mm, tuple(flood.points_mm[far]), iso_hu, polarity, beside_mm, threads
            )
        except Error:
            flood.is_covered[far] = True
            continue
        parts = [p for p in (_parting(path, radius, other) for other, _ in paths)]
        new = 0 if not paths else max((len(path) if p is None else p) for p in parts)
        flood.cover(path[new:], radius[new:], beside_mm)
        flood.is_covered[far] = True
        if (len(path) - new) * _STEP_MM >= min_length_mm:
            paths.append(_without_tip(path, radius))
    return ends_of_paths([p for p in paths if not _leads_back(p[1])])


def path_to(
    scan: Volume,
    root_mm: tuple[float, float, float],
    end_mm: tuple[float, float, float],
    iso_hu: float,
    polarity: str,
    reach_mm: float,
    threads: int = 0,
) -> tuple[Points, Points]:
    """A path along the middle of a lumen, and its radii, in points 1 mm apart."""
    found = find_lumen_path(
        scan, root_mm, end_mm, iso_hu, polarity, reach_mm=reach_mm, spacing_mm=_STEP_MM,
        threads=threads,
    )  # fmt: skip
    return _resampled(found.points_mm, found.radius_mm)


def ends_of_paths(paths: list[tuple[Points, Points]]) -> list[LumenEnd]:
    """The ends of paths from one root, each with its radii; sorted as find_lumen_ends."""
    ends = []
    for n, (path, radius) in enumerate(paths):
        parts = [_parting(path, radius, other) for m, (other, _) in enumerate(paths) if m != n]
        lengths = _lengths(path)
        branches: list[float] = []
        for at in sorted(lengths[p] for p in parts if p is not None):
            if not branches or at - branches[-1] > _ONE_BRANCH_MM:
                branches.append(float(at))
        point = (float(path[-1, 0]), float(path[-1, 1]), float(path[-1, 2]))
        ends.append(LumenEnd(point, len(branches), path, radius, tuple(branches)))
    return sorted(ends, key=lambda end: (end.generation, end.point_mm))


__all__: list[Any] = ["LumenEnd", "ends_of_paths", "find_lumen_ends", "path_to"]
