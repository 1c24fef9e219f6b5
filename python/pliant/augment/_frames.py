# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Arrays of other packages: axes (x, y, z) with z last in memory, and affines in RAS.

Such an array is a scan whose i axis is z: nothing is copied or turned.
"""

from typing import Any

import numpy
import numpy.typing

from pliant._core import Volume, Warp
from pliant._error import Error, expected_error
from pliant._exchange import MAX_SKEW, skew_of
from pliant.augment._motions import TissueMotions

Array = numpy.typing.NDArray[Any]

# (x, y, z) of RAS to LPS and back.
_TURN = numpy.diag([-1.0, -1.0, 1.0, 1.0])


def _whole_affine(affine_ras: Any) -> Array:
    """4 x 4, of one of two axes too: the third is perpendicular, with voxels of 1 mm."""
    given = numpy.asarray(affine_ras, float)
    if given.shape == (4, 4):
        return given
    if given.shape != (3, 3):
        raise expected_error("affine", "4 x 4 or 3 x 3 numbers", given.shape)
    whole = numpy.eye(4)
    whole[:2, :2], whole[:2, 3] = given[:2, :2], given[:2, 2]
    return whole


def _is_sheared(affine: Array) -> bool:
    """Whether axes aren't perpendicular, as after a rotation of voxels that aren't cubes."""
    return skew_of(affine[:3, :3]) > MAX_SKEW


def scan_of(
    array: Array, affine_ras: Any, hu_from_value: tuple[float, float] = (1.0, 0.0)
) -> Volume:
    """A scan of one channel (x, y, z) or (x, y), which is one slice.

    Args:
        affine_ras: 4 x 4, from voxel (x, y, z) to RAS millimetres. Of a sheared one, the scan has
            the nearest perpendicular axes and the same spacings: motions are sheared with the
            voxels, and nothing is interpolated.
        hu_from_value: HU = first * value + second.
    """
    if array.ndim == 2:
        array = array[..., None]
    if array.ndim != 3:
        raise expected_error("scan", "two or three spatial axes", array.ndim)
    affine = _TURN @ _whole_affine(affine_ras)
    axes = affine[:3, 2::-1]
    spacing = numpy.linalg.norm(axes, axis=0)
    if not (spacing > 0).all():
        raise Error("affine: expected three axes, found a zero one", field="affine")
    directions = axes / spacing
    if _is_sheared(affine):
        left, _, right = numpy.linalg.svd(directions)
        directions = left @ right
    if hu_from_value != (1.0, 0.0):
        array = numpy.float32(hu_from_value[0]) * array + numpy.float32(hu_from_value[1])
    elif array.dtype.kind != "f" and array.dtype != numpy.int16:
        array = array.astype(numpy.float32)  # without a search for its range
    return Volume(array, tuple(spacing), tuple(affine[:3, 3]), directions, background=-1000.0)


def affine_of_spacing(spacing_mm: Any) -> Array:
    """An affine of axes along the world's, for arrays that only have a spacing."""
    spacing = numpy.asarray(spacing_mm, float)
    if spacing.shape not in ((2,), (3,)):
        raise expected_error("spacing_mm", "three numbers, or two of a slice", spacing_mm)
    return numpy.diag([*spacing, 1.0, 1.0][:3] + [1.0])


def drawn_warp(
    motions: TissueMotions, scan: Volume, seed: int, labels: Any = None
) -> tuple[Warp, str]:
    """The warp of a sample, and its plan as JSON."""
    prepared = motions.prepare(scan)
    if labels is not None and labels.ndim == 2:
        labels = labels[..., None]
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


def _is_flat(warp: Warp, array: Array) -> bool:
    """Whether an array (..., x, y) belongs to a warp of one slice."""
    shape = warp.size[::-1]
    return shape[2] == 1 and array.shape[-3:] != shape and array.shape[-2:] == shape[:2]


def moved_array(
    warp: Warp, array: Array, mode: str, beyond: float | None = None, back: bool = False
) -> Array:
    """An array (..., x, y, z), moved or taken back, of the same type.

    Args:
        mode: "bilinear" (trilinear, as others call it), "nearest" or "majority".
        beyond: Value outside of the grid; None: the array's smallest for images, 0 for labels.
    """
    if _is_flat(warp, array):
        return moved_array(warp, array[..., None], mode, beyond, back)[..., 0]
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
    """Points (..., 3) in a space: "ras", "lps" or "voxel" (x, y, z); (..., 2) of one slice.

    Args:
        affine_ras: Of the scan, as scan_of() got it.
    """
    if space not in ("ras", "lps", "voxel"):
        raise Error(
            f"point_space: expected ras, lps or voxel, found {space}",
            field="point_space",
            expected="ras, lps or voxel",
            found=str(space),
        )
    if points.shape[-1:] == (2,) and warp.size[0] == 1:
        whole = numpy.concatenate([points, numpy.zeros_like(points[..., :1])], axis=-1)
        return moved_points(warp, whole, space, affine_ras, back)[..., :2]
    flat = points.reshape(-1, 3).astype(float)
    affine = _TURN if space == "ras" else numpy.eye(4)
    whole_affine = _TURN @ _whole_affine(affine_ras)
    if space == "voxel":
        affine = whole_affine
    if _is_sheared(whole_affine):  # to the warp's perpendicular axes
        straight = numpy.eye(4)
        straight[:3, 2::-1] = warp.direction * warp.spacing_mm
        straight[:3, 3] = warp.origin_mm
        affine = straight @ numpy.linalg.inv(whole_affine) @ affine
    lps = flat @ affine[:3, :3].T + affine[:3, 3]
    moved = warp.unwarp_points(lps) if back else warp.warp_points(lps)
    inverse = numpy.linalg.inv(affine)
    there = moved @ inverse[:3, :3].T + inverse[:3, 3]
    made: Array = there.reshape(points.shape)
    return made.astype(points.dtype) if points.dtype.kind == "f" else made
