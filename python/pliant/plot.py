# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures: matplotlib for sections, PyVista for surfaces and meshes.

Both packages are optional and imported by the call that needs them.

Example:
    >>> figure = pliant.plot.sections(tissue.volume(), point, field=tissue.displacement_field())
    >>> pliant.plot.to_pyvista(scan).contour([-500]).plot()
"""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from typing import Any

import numpy

from pliant._core import Field, TetMesh, Volume
from pliant._error import Error

_NAMES = {0: "sagittal", 1: "coronal", 2: "axial"}
_LETTERS = ("L", "P", "S")


def _package(name: str) -> Any:
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.split(".")[0]
        raise Error(f"{package}: expected to be installed: pip install {package}") from error


class _Slice:
    """The slice of a grid across one of its axes, drawn in millimetres from its corner's centre.

    Left of the picture is the patient's right, or anterior; above is superior, or anterior.
    """

    def __init__(self, volume: Volume, across: int, index: int) -> None:
        self.volume, self.across, self.index = volume, across, index
        direction = numpy.array(volume.direction)
        self.nearest = numpy.abs(direction).argmax(0)  # LPS axis of each grid axis
        # The vertical axis is the one nearest to S, or in an axial slice to P.
        one, other = (a for a in range(3) if a != across)
        upright = self.nearest[one] == 2 or (self.nearest[across] == 2 and self.nearest[one] == 1)
        self.down, self.right = (one, other) if upright else (other, one)
        self.spacing = numpy.array(volume.spacing_mm)
        self.sizes = numpy.array(volume.size)
        self.flips = tuple(
            direction[self.nearest[a], a] < 0 for a in (self.right, self.down)
        )

    @property
    def title(self) -> str:
        return f"{_NAMES[int(self.nearest[self.across])]}, {'ijk'[self.across]} = {self.index}"

    def label(self, axis: int) -> str:
        positive = numpy.array(self.volume.direction)[self.nearest[axis], axis] > 0
        letter = _LETTERS[self.nearest[axis]]
        opposite = {"L": "R", "P": "A", "S": "I"}[letter]
        return f"to {letter if positive else opposite} [mm]"

    def values(self, array: Any) -> Any:
        taken = numpy.take(array, self.index, axis=2 - self.across)
        return taken if self.down > self.right else taken.T

    def limits(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Of the picture: left and right, bottom and top."""
        width, height = (
            float(self.sizes[a] * self.spacing[a]) for a in (self.right, self.down)
        )
        half_x, half_y = self.spacing[self.right] / 2, self.spacing[self.down] / 2
        x = (-half_x, width - half_x)
        y = (-half_y, height - half_y)
        superior_up = self.nearest[self.down] == 2
        if superior_up == self.flips[1]:
            y = (y[1], y[0])
        return (x[1], x[0]) if self.flips[0] else x, y

    def extent(self) -> tuple[float, float, float, float]:
        sx, sy = self.spacing[self.right], self.spacing[self.down]
        return (
            -sx / 2,
            (self.sizes[self.right] - 0.5) * sx,
            -sy / 2,
            (self.sizes[self.down] - 0.5) * sy,
        )

    def place(self, point_mm: Any) -> tuple[float, float]:
        ijk = self.volume.voxel_from_world(point_mm)
        return ijk[self.right] * self.spacing[self.right], ijk[self.down] * self.spacing[self.down]

    def net(self, field: Field, every_mm: float) -> list[Any]:
        """Lines of a net at rest in this slice, where the field takes them."""
        lines = []
        for along, across in ((self.right, self.down), (self.down, self.right)):
            fine = numpy.arange(0, self.sizes[along], 0.5)
            for at in numpy.arange(0, self.sizes[across] - 1, every_mm / self.spacing[across]):
                ijk = numpy.zeros((len(fine), 3))
                ijk[:, self.across] = self.index
                ijk[:, along] = numpy.minimum(fine, self.sizes[along] - 1)
                ijk[:, across] = at
                step = numpy.array(self.volume.direction) * self.spacing
                moved = field.apply_to_points(self.volume.origin_mm + ijk @ step.T)
                back = (moved - self.volume.origin_mm) @ numpy.linalg.inv(step).T * self.spacing
                lines.append(back[:, [self.right, self.down]])
        return lines


def sections(
    volume: Volume,
    point_mm: Sequence[float] | None = None,
    *,
    window: float | None = None,
    level: float | None = None,
    labels: Volume | None = None,
    field: Field | None = None,
    net_mm: float = 10.0,
    points_mm: Any = None,
    axes: Any = None,
) -> Any:
    """Draws the three sections of a scan through a point.

    Args:
        volume: A scan.
        point_mm: Point [mm, LPS]; default: the middle.
        window, level: Of grey values; default: from the 1st to the 99th percentile.
        labels: Label map on the scan's grid, drawn in colours.
        field: Forward field: a net is drawn where it takes it, if the field stays in the slice.
        net_mm: Distance of the net's lines at rest [mm].
        points_mm: Points (n, 3) [mm, LPS]; those within half a voxel of a slice are drawn.
        axes: Three axes of matplotlib; default: a new figure.

    Returns:
        The figure.
    """
    if axes is None:
        pyplot = _package("matplotlib.pyplot")
        figure, axes = pyplot.subplots(1, 3, figsize=(12, 4.2), constrained_layout=True)
    else:
        figure = axes[0].figure
    if point_mm is None:
        point_mm = volume.world_from_voxel([(n - 1) / 2 for n in volume.size])
    middle = volume.voxel_from_world(point_mm)
    low, high = numpy.percentile(volume.array, [1, 99]).tolist()
    if window is not None or level is not None:
        wide = high - low if window is None else window
        centre = (low + high) / 2 if level is None else level
        low, high = centre - wide / 2, centre + wide / 2
    order = sorted(range(3), key=lambda a: -int(numpy.abs(volume.direction)[:, a].argmax()))
    for ax, across in zip(axes, order, strict=True):
        index = min(max(round(middle[across]), 0), volume.size[across] - 1)
        part = _Slice(volume, across, index)
        shown = {"extent": part.extent(), "origin": "lower", "interpolation": "nearest"}
        ax.imshow(part.values(volume.array), cmap="gray", vmin=low, vmax=high, **shown)
        if labels is not None:
            values = part.values(labels.array).astype(float)
            ax.imshow(
                numpy.where(values == 0, numpy.nan, values % 20), cmap="tab20", vmin=0, vmax=19,
                alpha=0.4, **shown,
            )
        if field is not None:
            for line in part.net(field, net_mm):
                ax.plot(*line.T, color="tab:orange", linewidth=0.6)
        if points_mm is not None:
            ijk = numpy.array([volume.voxel_from_world(p) for p in numpy.asarray(points_mm)])
            near = ijk[numpy.abs(ijk[:, across] - index) <= 0.5] * part.spacing
            ax.plot(near[:, part.right], near[:, part.down], "+", color="tab:cyan")
        ax.plot(*part.place(point_mm), "x", color="tab:red", markersize=6)
        x, y = part.limits()
        ax.set(title=part.title, xlabel=part.label(part.right), ylabel=part.label(part.down),
               xlim=x, ylim=y)
    return figure


def to_pyvista(item: Volume | Field | TetMesh) -> Any:
    """A PyVista data set of the same values.

    Args:
        item: A scan becomes an image with point data "values", a field one with vectors
            "displacement_mm", tetrahedra an unstructured grid. Positions are LPS millimetres.
    """
    pyvista = _package("pyvista")
    if isinstance(item, TetMesh):
        cells = numpy.array(item.cells)
        return pyvista.UnstructuredGrid({pyvista.CellType.TETRA: cells}, numpy.array(item.nodes_mm))
    image = pyvista.ImageData(
        dimensions=item.size,
        spacing=item.spacing_mm,
        origin=item.origin_mm,
        direction_matrix=numpy.array(item.direction),
    )
    if isinstance(item, Field):
        image.point_data["displacement_mm"] = numpy.array(item.array).reshape(-1, 3)
    else:
        image.point_data["values"] = numpy.array(item.array).ravel()
    return image
