# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Exchange of scans and fields with SimpleITK, NiBabel, NumPy, pickle and DLPack."""

from __future__ import annotations

import importlib
from typing import Any

import numpy
import numpy.typing

from pliant._core import Field, TetMesh, Volume

_RAS = numpy.diag([-1.0, -1.0, 1.0])


def _grid_of(item: Volume | Field) -> dict[str, Any]:
    return {
        "spacing_mm": item.spacing_mm,
        "origin_mm": item.origin_mm,
        "direction": numpy.array(item.direction),
    }


class _ViewOfImage(numpy.ndarray[Any, Any]):
    """SimpleITK's views don't keep their images alive."""

    image: Any = None


def volume_from_sitk(image: Any) -> Volume:
    """A scan of a SimpleITK image; its memory is viewed if it has int16 or float32."""
    sitk: Any = importlib.import_module("SimpleITK")

    view = sitk.GetArrayViewFromImage(image).view(_ViewOfImage)
    view.image = image
    return Volume(
        view,
        image.GetSpacing(),
        image.GetOrigin(),
        image.GetDirection(),
    )


def volume_to_sitk(volume: Volume) -> Any:
    """A SimpleITK image with a copy of the values, which SimpleITK's images own."""
    sitk: Any = importlib.import_module("SimpleITK")

    image = sitk.GetImageFromArray(volume.array)
    image.SetSpacing(volume.spacing_mm)
    image.SetOrigin(volume.origin_mm)
    image.SetDirection(numpy.ravel(volume.direction).tolist())
    return image


def volume_from_nibabel(image: Any) -> Volume:
    """A scan of a NiBabel image; its RAS coordinates become LPS.

    Raises:
        pliant.Error: The axes aren't perpendicular.
    """
    affine = _RAS @ image.affine[:3, :3]
    spacing = numpy.linalg.norm(affine, axis=0)
    values = numpy.asanyarray(image.dataobj)
    return Volume(
        values.T, spacing.tolist(), (_RAS @ image.affine[:3, 3]).tolist(), affine / spacing
    )


def volume_to_nibabel(volume: Volume) -> Any:
    """A NiBabel image that views the values; LPS becomes RAS."""
    nibabel: Any = importlib.import_module("nibabel")

    affine = numpy.eye(4)
    affine[:3, :3] = _RAS @ numpy.array(volume.direction) @ numpy.diag(volume.spacing_mm)
    affine[:3, 3] = _RAS @ numpy.array(volume.origin_mm)
    return nibabel.Nifti1Image(volume.array.T, affine)


def field_to_sitk_transform(field: Field) -> Any:
    """A SimpleITK transform of the same map of points: resample with it if it is an inverse."""
    sitk: Any = importlib.import_module("SimpleITK")

    image = sitk.GetImageFromArray(field.array.astype(numpy.float64), isVector=True)
    image.SetSpacing(field.spacing_mm)
    image.SetOrigin(field.origin_mm)
    image.SetDirection(numpy.ravel(field.direction).tolist())
    return sitk.DisplacementFieldTransform(image)


def array_of(
    volume: Volume, dtype: Any = None, copy: bool | None = None
) -> numpy.typing.NDArray[Any]:
    """NumPy's protocol: the read-only view, or a copy in another type."""
    array = volume.array
    if copy is False and dtype is not None and array.dtype != dtype:
        raise ValueError(f"expected {array.dtype} without a copy, found {numpy.dtype(dtype)}")
    return array.astype(dtype or array.dtype, copy=bool(copy))


def dlpack_of(volume: Volume, options: dict[str, Any]) -> Any:
    """DLPack's protocol: the values without a copy, where the other side takes read-only ones."""
    return volume.array.__dlpack__(**options)


def _remade_volume(array: Any, grid: dict[str, Any], background: float) -> Volume:
    return Volume(array, **grid, background=background)


def _remade_field(array: Any, grid: dict[str, Any], kind: str) -> Field:
    return Field(array, **grid, kind=kind)


def reduced_volume(volume: Volume) -> tuple[Any, ...]:
    """For pickle and copy.deepcopy: a copy of the values."""
    return _remade_volume, (numpy.array(volume.array), _grid_of(volume), volume.background)


def reduced_field(field: Field) -> tuple[Any, ...]:
    """For pickle and copy.deepcopy."""
    return _remade_field, (numpy.array(field.array), _grid_of(field), field.kind)


def reduced_mesh(mesh: TetMesh) -> tuple[Any, ...]:
    """For pickle and copy.deepcopy."""
    return TetMesh, (numpy.array(mesh.nodes_mm), numpy.array(mesh.cells))
