# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Exchange of scans and fields with SimpleITK, NiBabel, NumPy, pickle and DLPack."""

from __future__ import annotations

import importlib
import math
import operator
import pathlib
import tempfile
from typing import Any

import numpy
import numpy.typing

import pliant._core
from pliant._core import Field, SpringParts, TetMesh, Tissue, Volume
from pliant._error import Error, expected_error

Array = numpy.typing.NDArray[Any]

_RAS = numpy.diag([-1.0, -1.0, 1.0])


def array_of_argument(given: Any, name: str) -> Array:
    """numpy.asarray(given), without masked values.

    Raises:
        pliant.Error: It has some, or has rows of different lengths.
    """
    if numpy.ma.is_masked(given):
        raise expected_error(
            name, "no masked values (numpy.ma.filled gives them one)", "a masked array"
        )
    try:
        return numpy.asarray(given)
    except (TypeError, ValueError) as error:
        raise expected_error(name, "an array of numbers", error) from None


def array_in(given: Any, name: str, kind: str, must_be_finite: bool = False) -> Array:
    """An array of an argument, in C order and of a type; nothing is converted silently.

    Raises:
        pliant.Error: It isn't an array of real numbers, has masked values, or values that the type
            can't hold; if must_be_finite also NaN and infinite ones.
    """
    array = array_of_argument(given, name)
    if array.dtype.kind not in "biuf":
        raise expected_error(name, "real numbers", f"an array of {array.dtype}")
    with numpy.errstate(over="ignore", invalid="ignore"):
        made = numpy.ascontiguousarray(array, kind)
        if made.size == 0:
            return made
        # A sum in one pass is finite only if all numbers are.
        if must_be_finite and made.dtype.kind == "f" and not numpy.isfinite(made.sum()):
            if count := made.size - int(numpy.count_nonzero(numpy.isfinite(made))):
                raise expected_error(
                    name, f"finite {kind} (numpy.nan_to_num replaces others)",
                    f"{count} that are not, of {made.size}",
                )  # fmt: skip
        if array.dtype.kind in "iu" and made.dtype != array.dtype and array.dtype.itemsize > 2:
            _check_whole(array, made, name)
    return made


def _check_whole(array: Array, made: Array, name: str) -> None:
    """Raises if whole numbers have changed by their conversion."""
    low, high = int(array.min()), int(array.max())
    held = 2**24 if made.dtype == numpy.float32 else 2**53
    if made.dtype.kind in "iu":
        limits = numpy.iinfo(made.dtype)
        if low < limits.min or high > limits.max:
            raise expected_error(name, f"numbers that {made.dtype} holds", f"{low} to {high}")
    elif (low < -held or high > held) and not numpy.array_equal(made.astype(array.dtype), array):
        raise expected_error(
            name, f"whole numbers that {made.dtype} holds, such as up to {held}", f"{low} to {high}"
        )


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

    if not isinstance(image, sitk.Image):
        raise expected_error("image", "a SimpleITK image", repr(image))
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


MAX_SKEW = 1e-3  # of axes that are perpendicular up to rounding


def skew_of(affine: Array) -> float:
    """Largest cosine of the angle between two axes, the columns of (3, 3) numbers."""
    lengths = numpy.linalg.norm(affine, axis=0)
    axes = affine / numpy.where(lengths > 0, lengths, 1)
    return float(numpy.abs(numpy.triu(axes.T @ axes, 1)).max())


def volume_from_nibabel(image: Any, straighten: bool = False) -> Volume:
    """A scan of a NiBabel image; its RAS coordinates become LPS.

    Args:
        straighten: Resamples an image whose axes aren't perpendicular.

    Raises:
        pliant.Error: The axes aren't perpendicular, and straighten is False.
    """
    if not hasattr(image, "affine") or not hasattr(image, "dataobj"):
        raise expected_error("image", "a NiBabel image", repr(image))
    affine = _RAS @ image.affine[:3, :3]
    spacing = numpy.linalg.norm(affine, axis=0)
    values = numpy.asanyarray(image.dataobj)
    skew = skew_of(affine)
    if skew > MAX_SKEW and not straighten:
        raise expected_error(
            "affine",
            "perpendicular axes (straighten=True resamples sheared ones)",
            f"axes sheared by {math.degrees(math.asin(min(1.0, skew))):.2f} degrees",
        )
    make: Any = pliant._core.straightened_volume if straighten else Volume
    origin = (_RAS @ image.affine[:3, 3]).tolist()
    axes = affine / numpy.where(spacing > 0, spacing, 1)
    made: Volume = make(values.T, spacing.tolist(), origin, axes)
    return made


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
    """DLPack's protocol: a copy, since other packages write into read-only arrays."""
    if options.pop("copy", None) is False:
        raise BufferError("expected copy=None or True, found False: the scan is read-only")
    return volume.array.copy().__dlpack__(**options)


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


_PARTS = ("mass", "node_damping", "fixed", "stiffness", "link_damping", "rest_length") + (
    "branch_stiffness", "branch_time", "cell_node_count", "bulk",
)  # fmt: skip


def _remade_parts(rest: Any, links: Any, cells: Any, arrays: dict[str, Any]) -> SpringParts:
    parts = SpringParts(rest, links, cells=cells if len(cells) else None)
    for name, array in arrays.items():
        getattr(parts, name)[:] = array
    return parts


def reduced_parts(parts: SpringParts) -> tuple[Any, ...]:
    """For pickle."""
    arrays = {name: numpy.array(getattr(parts, name)) for name in _PARTS}
    rest, links, cells = (numpy.array(a) for a in (parts.rest, parts.links, parts.cells))
    return _remade_parts, (rest, links, cells, arrays)


def _state_of(tissue: Tissue) -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "state")
        tissue.save_state(path)
        return path.read_bytes()


def _take_state(tissue: Tissue, state: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder, "state")
        path.write_bytes(state)
        tissue.load_state(path)


def _remade_tissue(
    maker: tuple[str, tuple[Any, ...], dict[str, Any]], changes: list[dict[str, Any]], state: bytes
) -> Any:
    function, arguments, settings = maker
    tissue = operator.attrgetter(function)(pliant._core)(*arguments, **settings)
    for change in changes:
        tissue.configure(**change)
    _take_state(tissue, state)
    return tissue


def _remade_own_tissue(
    kind: type[Tissue], scan: Volume, threads: int, attributes: dict[str, Any], state: bytes
) -> Any:
    tissue = kind.__new__(kind)
    Tissue.__init__(tissue, scan, threads)
    tissue.__dict__.update(attributes)
    _take_state(tissue, state)
    return tissue


def reduced_tissue(
    tissue: Tissue, maker: Any, changes: list[dict[str, Any]]
) -> tuple[Any, ...]:
    """For pickle and copy.deepcopy: the scan and the state, without history; tools have let go."""
    if maker is None:
        raise Error(
            "pickle: expected a tissue of make_chainmail, make_elastic, make_springs, make_body, "
            "make_network or make_tissue, or one of your own",
            "unsupported",
        )
    return _remade_tissue, (maker, changes, _state_of(tissue))


def reduced_own_tissue(tissue: Tissue, *_: Any) -> tuple[Any, ...]:
    """Likewise, with the object's attributes."""
    attributes = dict(tissue.__dict__)
    state = _state_of(tissue)
    return _remade_own_tissue, (type(tissue), tissue.scan, tissue.threads, attributes, state)


def _remade_scene(
    wall: Any, entry: Any, threads: int, settings: dict[str, Any], state: Any,
    hand: tuple[float, float, float, float],
) -> Any:  # fmt: skip
    scene = pliant._core.CatheterScene(wall, entry, threads=threads, **settings)
    scene.restore(state)
    scene.command(*hand)
    return scene


def reduced_scene(
    scene: Any, entry: Any, settings: dict[str, Any], hand: Any
) -> tuple[Any, ...]:
    """For pickle and copy.deepcopy: wall, settings and dynamic state."""
    for name in ("place_mm", "direction"):
        settings.pop(name, None)  # the entry
    return _remade_scene, (scene.wall, entry, scene.threads, settings, scene.state(), hand)


def _remade_arena(
    kind: type[Any], made_of: tuple[tuple[Any, ...], dict[str, Any]], states: list[Any]
) -> Any:
    arguments, settings = made_of
    arena = kind(*arguments, **settings)
    for n, state in enumerate(states):
        arena.load_state(n, state)
    arena.look()
    return arena


def reduced_arena(arena: Any, made_of: tuple[Any, ...]) -> tuple[Any, ...]:
    """For pickle and copy.deepcopy: scan, settings and the state of each instrument."""
    states = [arena.save_state(n) for n in range(arena.count)]
    return _remade_arena, (type(arena), made_of, states)


def _remade_truth_maker(
    scan: Volume, threads: int, materials: Any, model: str, settings: Any
) -> Any:
    return pliant._core.TruthMaker(scan, threads, materials, model, **settings)


def _remade_truth(arguments: tuple[Any, ...], seed: int) -> Any:
    return _remade_truth_maker(*arguments).make(seed)


def reduced_truth_maker(arguments: tuple[Any, ...]) -> tuple[Any, ...]:
    """For pickle and copy.deepcopy."""
    return _remade_truth_maker, arguments


def reduced_truth(case: Any) -> tuple[Any, ...]:
    """For pickle and copy.deepcopy: scan, settings and seed, of which the same case is made."""
    return _remade_truth, case._made_of


def _remade_prepared(scan: Volume, threads: int, model: str, settings: dict[str, Any]) -> Any:
    return pliant._core.PreparedScan(scan, threads, model, **settings)


def reduced_prepared(
    scan: Volume, threads: int, model: str, settings: dict[str, Any]
) -> tuple[Any, ...]:
    """For pickle and copy.deepcopy."""
    return _remade_prepared, (scan, threads, model, dict(settings))
