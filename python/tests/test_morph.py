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


def test_surfaces_give_what_their_label_maps_give():
    def surface(centre):
        """An octahedron."""
        corners = numpy.vstack([numpy.eye(3), -numpy.eye(3)]) * 60 + centre
        above = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2]]
        cells = above + [[1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]]
        return pliant.TriangleMesh(corners, cells)

    motion = pliant.morph(surface((0, 0, 0)), surface((8, -4, 2)))
    assert motion.forward([[5, 5, 0]]) == pytest.approx(numpy.array([[13, 1, 2]]), abs=0.5)
    open_surface = pliant.TriangleMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    with pytest.raises(pliant.Error, match="from_labels: found 3 open edges"):
        pliant.morph(open_surface, surface((0, 0, 0)))


def test_a_stiff_label_is_strained_less():
    first = ball((0, 0, 0)).array.copy()
    x = (numpy.arange(48) - 23.5) * 3
    first[:, :, x > 0] *= 2  # the half of larger x has label 2
    labels = pliant.Volume(first, [3.0] * 3, [x[0]] * 3)
    grown = ball((0, 0, 0), radius=50.0)

    def strain(motion, at):
        ends = motion.forward([[at - 5, 0, 0], [at + 5, 0, 0]])
        return (ends[1, 0] - ends[0, 0]) / 10 - 1

    motion = pliant.morph(labels, grown, moduli={2: 10})
    uniform = pliant.morph(ball((0, 0, 0)), grown)
    assert strain(motion, 20) < strain(uniform, 20) - 0.03
    assert strain(motion, -20) > strain(uniform, -20) + 0.015
    with pytest.raises(pliant.Error, match="moduli: expected labels of from"):
        pliant.morph(labels, grown, moduli={3: 10})
    with pytest.raises(pliant.Error, match="moduli: expected a dict"):
        pliant.morph(labels, grown, moduli=10)
