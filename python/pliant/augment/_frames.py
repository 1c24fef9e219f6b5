# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Arrays of other packages: axes (x, y, z) with z last in memory, and affines in RAS.

Such an array is a scan whose i axis is z: nothing is copied or turned.
"""

from typing import Any

import numpy
import numpy.typing

from pliant._core import Volume, Warp
from pliant._error import Error
from pliant.augment._motions import TissueMotions

Array = numpy.typing.NDArray[Any]

# (x, y, z) of RAS to LPS and back.
_TURN = numpy.diag([-1.0, -1.0, 1.0, 1.0])


def scan_of(
    array: Array, affine_ras: Any, hu_from_value: tuple[float, float] = (1.0, 0.0)
) -> Volume:
    """A scan of one channel (x, y, z).

    Args:
        affine_ras: 4 x 4, from voxel (x, y, z) to RAS millimetres.
        hu_from_value: HU = first * value + second.
    """
    if array.ndim != 3:
        raise Error(
            f"scan: expected three spatial axes, found {array.ndim}",
            field="scan",
            expected="three spatial axes",
            found=str(array.ndim),
        )
    affine = _TURN @ numpy.asarray(affine_ras, float)
    axes = affine[:3, 2::-1]
    spacing = numpy.linalg.norm(axes, axis=0)
    if not (spacing > 0).all():
        raise Error("affine: expected three axes, found a zero one", field="affine")
    if hu_from_value != (1.0, 0.0):
        array = numpy.float32(hu_from_value[0]) * array + numpy.float32(hu_from_value[1])
    elif array.dtype.kind != "f" and array.dtype != numpy.int16:
        array = array.astype(numpy.float32)  # without a search for its range
    return Volume(array, tuple(spacing), tuple(affine[:3, 3]), axes / spacing, background=-1000.0)


def affine_of_spacing(spacing_mm: Any) -> Array:
    """An affine of axes along the world's, for arrays that only have a spacing."""
    spacing = numpy.asarray(spacing_mm, float)
    if spacing.shape != (3,):
        raise Error(
            f"spacing_mm: expected three numbers, found {spacing_mm}",
            field="spacing_mm",
            expected="three numbers",
            found=str(spacing_mm),
        )
    return numpy.diag([*spacing, 1.0])


def drawn_warp(
    motions: TissueMotions, scan: Volume, seed: int, labels: Any = None
) -> tuple[Warp, str]:
    """The warp of a sample, and its plan as JSON."""
    prepared = motions.prepare(scan)
    plan = motions.sample(prepared, numpy.random.default_rng(seed), labels)
    return motions.apply(prepared, plan).warp, plan.to_json()


def check_mode(mode: str) -> str:
    """A mode of interpolation."""
    if mode not in ("bilinear", "nearest", "majority"):
        expected = "bilinear, nearest or majority"
        raise Error(
            f"mode: expected {expected}, found {mode}",
            field="mode",
            expected=expected,
            found=str(mode),
        )
    return mode


def moved_array(
    warp: Warp, array: Array, mode: str, beyond: float | None = None, back: bool = False
) -> Array:
    """An array (..., x, y, z), moved or taken back, of the same type.

    Args:
        mode: "bilinear" (trilinear, as others call it), "nearest" or "majority".
        beyond: Value outside of the grid; None: the array's smallest for images, 0 for labels.
    """
    given = array.dtype
    if given == bool:
        array = array.view(numpy.uint8)
    elif given.kind == "f" and given.itemsize < 4:
        array = array.astype(numpy.float32)
    if mode == "bilinear":
        value = float(array.min()) if beyond is None else beyond
        made = warp.unwarp_image(array, value) if back else warp.warp_image(array, value)
    else:
        value = 0.0 if beyond is None else beyond
        work = warp.unwarp_labels if back else warp.warp_labels
        made = work(array, mode, value)
    if given == bool:
        return made.view(bool)
    return made if made.dtype == given else made.astype(given)


def moved_points(
    warp: Warp, points: Array, space: str, affine_ras: Any, back: bool = False
) -> Array:
    """Points (..., 3) in a space: "ras", "lps" or "voxel" (x, y, z)."""
    if space not in ("ras", "lps", "voxel"):
        raise Error(
            f"point_space: expected ras, lps or voxel, found {space}",
            field="point_space",
            expected="ras, lps or voxel",
            found=str(space),
        )
    flat = points.reshape(-1, 3).astype(float)
    affine = _TURN if space == "ras" else numpy.eye(4)
    if space == "voxel":
        affine = _TURN @ numpy.asarray(affine_ras, float)
    lps = flat @ affine[:3, :3].T + affine[:3, 3]
    moved = warp.unwarp_points(lps) if back else warp.warp_points(lps)
    inverse = numpy.linalg.inv(affine)
    there = moved @ inverse[:3, :3].T + inverse[:3, 3]
    made: Array = there.reshape(points.shape)
    return made.astype(points.dtype) if points.dtype.kind == "f" else made
