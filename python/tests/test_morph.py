# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Motion of an organ between two phases, against NumPy."""

import numpy
import pytest

import pliant


def ball(centre, radius=40.0, size=48, spacing=3.0):
    """A label map around the origin."""
    axis = (numpy.arange(size) - (size - 1) / 2) * spacing
    z, y, x = numpy.meshgrid(axis, axis, axis, indexing="ij")
    inside = (x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2 <= radius**2
    return pliant.Volume(inside.astype(numpy.int16), [spacing] * 3, [axis[0]] * 3)


def spline(x, u, at, softness):
    """The thin plate spline, by one dense system."""
    kernel = -numpy.linalg.norm(x[:, None] - x[None], axis=2) + softness * numpy.eye(len(x))
    affine = numpy.c_[numpy.ones(len(x)), x]
    system = numpy.block([[kernel, affine], [affine.T, numpy.zeros((4, 4))]])
    solved = numpy.linalg.solve(system, numpy.r_[u, numpy.zeros((4, 3))])
    distance = numpy.linalg.norm(at[:, None] - x[None], axis=2)
    return -distance @ solved[: len(x)] + numpy.c_[numpy.ones(len(at)), at] @ solved[len(x) :]


def test_points_alone_are_the_thin_plate_spline(rng):
    x = rng.uniform(-60, 60, (40, 3))
    u = 4 * numpy.sin(x[:, [1, 2, 0]] / 30) + rng.normal(scale=0.2, size=(40, 3))
    motion = pliant.morph(from_mm=x, to_mm=x + u)
    at = rng.uniform(-50, 50, (200, 3))
    expected = at + spline(x, u, at, 1.0)
    off = numpy.linalg.norm(motion.forward(at) - expected, axis=1)
    assert off.mean() < 0.02  # u is trilinear between nodes
    assert off.max() < 0.2
    assert motion.inverse(motion.forward(at)) == pytest.approx(at, abs=1e-5)
    assert motion.report["points"] == 40
    assert motion.report["least_volume"] > 0.05


def test_shapes_give_fields_that_move_the_scan():
    shift = (6, -3, 3)
    first, second = ball((0, 0, 0)), ball(shift)
    motion = pliant.morph(first, second)
    assert motion.report["parts"] == 1
    assert motion.report["prior"] == "none"
    assert motion.forward([[10, 0, 5]]) == pytest.approx(numpy.array([[16, -3, 8]]), abs=0.5)
    forward, back = motion.forward_field(first), motion.inverse_field(second)
    assert (forward.kind, back.kind) == ("modeling", "resampling")
    points = numpy.array([[5.0, 4, 3], [-20, 10, 0]])
    assert forward.apply_to_points(points) == pytest.approx(motion.forward(points), abs=1e-4)
    moved = back.apply_to_volume(first).array > 0
    assert (moved != (second.array > 0)).mean() < 0.02
    assert motion.forward_field().size == motion.inverse_field().size


def test_points_and_shapes_go_together():
    known = numpy.array([[0.0, 0, 0], [10, 5, 0], [0, 15, -10], [-12, 0, 9]])
    motion = pliant.morph(
        ball((0, 0, 0)), ball((6, 0, 0)), from_mm=known, to_mm=known + (6, 0, 0), threads=1
    )
    assert motion.report["points"] == 4
    assert motion.forward(known) == pytest.approx(known + (6, 0, 0), abs=0.5)
    assert "4 points, 1 parts" in repr(motion)


def test_bad_input_is_named():
    first = ball((0, 0, 0))
    with pytest.raises(pliant.Error, match="to: expected label maps of both phases|to_labels"):
        pliant.morph(first)
    with pytest.raises(pliant.Error, match="to_mm: expected 2 points, as of from_mm, found 1"):
        pliant.morph(from_mm=[[0, 0, 0], [1, 2, 3]], to_mm=[[0, 0, 0]])
    with pytest.raises(pliant.Error, match="from_labels: expected a Volume"):
        pliant.morph(3, first)
    with pytest.raises(pliant.Error, match="prior"):
        pliant.morph(first, first, prior="standing")
    with pytest.raises(pliant.Error, match="from_mm"):
        pliant.morph()
