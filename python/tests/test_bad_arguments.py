# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Arguments that fit no call: one error that names them, and no memory that isn't theirs."""

import numpy
import pytest

import pliant
import pliant.augment

NAN = float("nan")


@pytest.fixture(scope="module")
def scan():
    return pliant.make_phantom("airway", (24, 24, 24))


@pytest.fixture(scope="module")
def prepared(scan):
    return pliant.augment.PreparedScan(scan)


@pytest.fixture(scope="module")
def warp(prepared):
    prepared.push((0, 0, 0), (1, 1, 1), 3.0)
    return prepared.finish()[0]


PARTS = pliant.springs_of_lattice((3, 3, 3))


@pytest.mark.parametrize(
    ("call", "expected"),
    [
        (lambda s: pliant.make_chainmail(3), "scan: expected a Volume, found "),
        (lambda s: pliant.make_network("x", PARTS), "scan: expected a Volume, found 'x'"),
        (lambda s: pliant.make_body(s, 3), "mesh: expected a TetMesh, found 3"),
        (lambda s: pliant.augment.PreparedScan(3), "scan: expected a Volume, found "),
        (lambda s: pliant.EndoscopeArena(3), "scan: expected a Volume, found "),
        (lambda s: pliant.EndoscopeArena(s, labels=3), "labels: expected a Volume, found 3"),
        (lambda s: pliant.make_chainmail(s, brick_size=2**70), "brick_size: expected a whole"),
        (lambda s: pliant.make_chainmail(s, brick_size=numpy.array([8, 9])), "brick_size"),
        (lambda s: pliant.TetMesh(numpy.eye(4, 3), [(0, 1, 2, 2.7)]), "cells: expected"),
        (lambda s: pliant.TetMesh(numpy.eye(4, 3), [(0, 1, 2, 2**32 + 3)]), "cells: expected"),
    ],
)
def test_the_argument_is_named(scan, call, expected):
    with pytest.raises(pliant.Error, match=expected):
        call(scan)


def test_an_array_without_axes_is_a_number(scan):
    assert pliant.make_chainmail(scan, brick_size=numpy.array(8)).model == "chainmail"


def test_no_directions_have_no_distances(scan):
    caster = pliant.RayCaster(scan, threads=1)
    for none in ([], numpy.zeros((0, 3)), numpy.zeros((5, 0)), numpy.zeros((0, 7, 3))):
        assert caster.first_hits((0, 0, 0), none).shape == (0,)


def test_points_of_an_augmentation_are_finite(prepared):
    with pytest.raises(pliant.Error, match="point_mm: expected finite numbers"):
        prepared.bone_distance_mm((NAN, 0, 0))
    with pytest.raises(pliant.Error, match="centre_mm: expected finite numbers"):
        prepared.follow([((NAN, 0, 0), 1.0, 2.0)], [])


def test_values_beyond_a_warp_fit_the_array(scan, warp):
    with pytest.raises(pliant.Error, match="beyond: expected a number, found nan"):
        warp.warp_image(scan.array, NAN)
    assert numpy.isfinite(warp.warp_image(scan.array.astype(float), NAN)).any()
    for kind in (numpy.int64, numpy.uint64, numpy.int8):
        for beyond in (-1e30, 1e30):
            warp.warp_image(numpy.zeros(scan.array.shape, kind), beyond)


@pytest.mark.parametrize(
    "change",
    [
        lambda s: s[:1],
        lambda s: (s[0], None, *s[2:]),
        lambda s: (*s[:7], "x"),
        lambda s: (*s[:4], (0, 0, 0, 90000, 90000, 90000), *s[5:]),
        lambda s: (*s[:4], (-(2**31), 0, 0, 2**31 - 1, 9, 9), *s[5:]),
    ],
)
def test_the_state_of_a_warp_is_checked(warp, change):
    with pytest.raises(pliant.Error, match="warp: expected the state of another warp"):
        pliant.augment.Warp(change(warp.state))
    assert pliant.augment.Warp(warp.state).moved_voxels == warp.moved_voxels


class Still(pliant.Tissue):
    """A tissue that takes pushes, and does nothing."""

    def push(self, point_mm, push_mm, radius_mm, tool):
        return None

    def state(self):
        return []

    def set_state(self, numbers):
        pass


def test_displaced_elements_have_whole_numbers(scan):
    tissue = Still(scan)
    for first in ((NAN, 0, 0), (0.5, 0, 0), (1e30, 0, 0)):
        with pytest.raises(pliant.Error, match="first: expected three whole numbers"):
            tissue.displace(numpy.zeros((1, 1, 1, 3)), first)
    tissue.displace(numpy.ones((1, 1, 1, 3)), (-1, 2, 3))
