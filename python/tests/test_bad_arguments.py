# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Arguments that fit no call: one error that names them, and no memory that isn't theirs."""

import keyword

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
        (lambda s: pliant.make_chainmail(s, range=["a", "b"]), "range: expected two numbers"),
        (lambda s: pliant.make_chainmail(s, offset=7), "^offset: expected"),
        (lambda s: pliant.Volume(s.array, spacing_mm=1.0), "spacing_mm: expected three numbers"),
        (lambda s: pliant.Volume(s.array, direction=["a"] * 9), "direction: expected real numbers"),
        (lambda s: pliant.Volume(s.array, direction=[[1], [1, 2]]), "direction: expected an array"),
        (lambda s: pliant.Volume(array=s.array, gap=1), "gap"),
        (lambda s: pliant.make_phantom(3), "name: expected a text, found 3"),
        (lambda s: pliant.make_chainmail(s).release(-1), "tool: expected a whole number of 32"),
        (lambda s: pliant.settings_of("x" * 10**6), "model: expected .* found xxx.*…$"),
        (lambda s: pliant.TetMesh(numpy.eye(4, 3), [(0, 1, 2, 2.7)]), "cells: expected"),
        (lambda s: pliant.TetMesh(numpy.eye(4, 3), [(0, 1, 2, 2**32 + 3)]), "cells: expected"),
    ],
)
def test_the_argument_is_named(scan, call, expected):
    with pytest.raises(pliant.Error, match=expected) as raised:
        call(scan)
    assert len(str(raised.value)) < 2001 and "\n" not in str(raised.value)


FLOATS = numpy.zeros((3, 4, 5), numpy.float32)


def changed(value, kind="float32"):
    array = FLOATS.astype(kind)
    array[1, 2, 3] = value
    return array


@pytest.mark.parametrize(
    ("array", "expected"),
    [
        (changed(NAN), "array: expected finite float32 .* found 1 that are not, of 60"),
        (changed(numpy.inf), "array: expected finite float32"),
        (changed(1e300, "float64"), "array: expected finite float32"),
        (changed(2**24 + 1, "int32"), "array: expected whole numbers that float32 holds"),
        (changed(2**63, "uint64"), None),
        (changed(2**63 + 1, "uint64"), "array: expected whole numbers that float32 holds"),
        (changed(1j, "complex64"), "array: expected three axes .* of complex64"),
        (numpy.ma.masked_array(FLOATS, FLOATS == 0), "array: expected no masked values"),
        (numpy.ma.masked_array(FLOATS, FLOATS > 0), None),
        (changed(2**24, "int32"), None),
        (changed(70000, "uint32"), None),
    ],
)
def test_values_that_a_scan_cannot_hold_are_refused(array, expected):
    if expected is None:
        assert (pliant.Volume(array).array == array).all()
        return
    with pytest.raises(pliant.Error, match=expected):
        pliant.Volume(array)


def test_values_that_a_field_cannot_hold_are_refused():
    vectors = numpy.zeros((3, 4, 5, 3))
    assert pliant.Field(vectors.astype("int16")).array.shape == (3, 4, 5, 3)
    for value, kind, expected in (
        (NAN, float, "finite"), (1e300, float, "finite"), (1j, complex, "real numbers"),
    ):  # fmt: skip
        wrong = vectors.astype(kind)
        wrong[0, 0, 0, 0] = value
        with pytest.raises(pliant.Error, match=f"array: expected {expected}"):
            pliant.Field(wrong)


def test_messages_are_one_line_of_bounded_length():
    error = pliant.Error("name: expected y, found " + "a\n" * 10**6, found="a\n" * 10**6)
    assert len(str(error)) <= 2000 and "\n" not in str(error)
    assert len(error.found) == 200 and error.found.endswith("…")
    assert str(pliant.Error("a: expected b, found c", found="c")) == "a: expected b, found c"


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


def test_none_is_a_setting_where_it_is_the_default(scan):
    for row in pliant.settings_of("chainmail"):
        name = row["name"]
        given = name + "_" * keyword.iskeyword(name)
        if row["default"] is None:
            assert pliant.make_chainmail(scan, threads=1, **{given: None})
            continue
        with pytest.raises(pliant.Error, match=f"^{name}: expected .*, found None$") as caught:
            pliant.make_chainmail(scan, threads=1, **{given: None})
        assert (caught.value.field, caught.value.found) == (name, "None")
        assert len(caught.value.expected) > 3
    body = pliant.make_springs(scan, threads=1)
    with pytest.raises(pliant.Error, match="depth: expected a value, found None"):
        body.configure(depth=None)
