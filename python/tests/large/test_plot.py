# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Sections lie as in a viewer: the patient's left on the right, superior or anterior above."""

from __future__ import annotations

import itertools
import sys
from typing import Any

import matplotlib
import numpy
import pytest

import pliant
import pliant.plot

matplotlib.use("Agg")


def turned_volume(order: tuple[int, ...], signs: tuple[int, ...]) -> pliant.Volume:
    direction = numpy.zeros((3, 3))
    for axis, (lps, sign) in enumerate(zip(order, signs, strict=True)):
        direction[lps, axis] = sign
    return pliant.Volume(
        numpy.zeros((9, 11, 13), numpy.int16),
        spacing_mm=(1.0, 1.5, 2.0),
        origin_mm=(5, 6, 7),
        direction=direction,
    )


def on_picture(ax: Any, line: Any) -> Any:
    """Place of a drawn point in the picture, 0…1 from its left and lower edge."""
    at = ax.transData.transform(line.get_xydata()[0])
    return ax.transAxes.inverted().transform(at)


@pytest.mark.parametrize("order", list(itertools.permutations(range(3))))
@pytest.mark.parametrize("signs", list(itertools.product((1, -1), repeat=3)))
def test_places_are_where_a_reader_expects_them(
    order: tuple[int, ...], signs: tuple[int, ...]
) -> None:
    scan = turned_volume(order, signs)
    middle = numpy.array(scan.world_from_voxel([(n - 1) / 2 for n in scan.size]))
    # Left of the middle, posterior of it, superior of it.
    moved = middle + (2, 3, 2)
    figure = pliant.plot.sections(scan, moved)
    titles = [ax.get_title().split(",")[0] for ax in figure.axes]
    assert titles == ["axial", "coronal", "sagittal"]
    axial, coronal, sagittal = (on_picture(ax, ax.lines[-1]) for ax in figure.axes)
    assert axial[0] > 0.5 and axial[1] < 0.5
    assert coronal[0] > 0.5 and coronal[1] > 0.5
    assert sagittal[0] > 0.5 and sagittal[1] > 0.5
    matplotlib.pyplot.close(figure)


def test_values_lie_under_their_places() -> None:
    array = numpy.zeros((9, 11, 13), numpy.int16)
    array[2, 7, 4] = 100
    scan = pliant.Volume(array, spacing_mm=(1.0, 1.5, 2.0))
    point = scan.world_from_voxel((4, 7, 2))
    figure = pliant.plot.sections(scan, point, window=100, level=50)
    for ax in figure.axes:
        image = ax.images[0]
        x, y = ax.lines[-1].get_xydata()[0]
        left, right, bottom, top = image.get_extent()
        rows, columns = image.get_array().shape
        column = int((x - left) / (right - left) * columns)
        row = int((y - bottom) / (top - bottom) * rows)
        assert image.get_array()[row, column] == 100
    matplotlib.pyplot.close(figure)


def test_the_net_goes_where_the_field_takes_it() -> None:
    scan = pliant.Volume(numpy.zeros((9, 11, 13), numpy.int16))
    vectors = numpy.zeros((9, 11, 13, 3), numpy.float32)
    vectors[..., 0] = 0.5
    field = pliant.Field(vectors, kind="modeling")
    figure = pliant.plot.sections(scan, field=field, net_mm=4)
    axial = figure.axes[0]
    upright = [line.get_xydata() for line in axial.lines if numpy.ptp(line.get_xydata()[:, 1]) > 1]
    assert sorted(float(line[0, 0]) for line in upright) == pytest.approx([0.5, 4.5, 8.5])
    matplotlib.pyplot.close(figure)


def test_pyvista_has_the_same_places() -> None:
    scan = turned_volume((2, 0, 1), (1, -1, 1))
    image = pliant.plot.to_pyvista(scan)
    assert image.dimensions == scan.size
    ijk = numpy.array([3, 5, 2])
    n = ijk[0] + scan.size[0] * (ijk[1] + scan.size[1] * ijk[2])
    assert image.points[n] == pytest.approx(scan.world_from_voxel(ijk.tolist()))
    assert image.point_data["values"].shape == (9 * 11 * 13,)


def test_a_missing_package_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(pliant.Error, match="pip install pyvista"):
        pliant.plot.to_pyvista(turned_volume((0, 1, 2), (1, 1, 1)))
