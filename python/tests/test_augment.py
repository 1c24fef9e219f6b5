# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Augmentation: plans, common motion, bad input. Large counts: augment_samples.py."""

import json
import multiprocessing
import os
import pickle
import subprocess
import sys
import warnings

import numpy
import pytest

import pliant
from augment_samples import check, random_scan, worst_of
from conftest import random_direction
from pliant.augment import Plan, TissueMotions, Warp, _frames


def moved_airway(airway, rng, **settings):
    motions = TissueMotions(**{"pushes": 2, "slides": 1, "at": "wall", **settings})
    return motions, motions.sample(airway, rng)


def test_random_samples_neither_fold_nor_move_bone(rng):
    count = int(os.environ.get("PLIANT_AUGMENT_SAMPLES", "12"))
    worst = worst_of(count, rng, 40)
    print(worst)
    assert worst["motions"] > 0
    assert worst["smallest_jacobian"] > 0
    assert worst["above_bound"] > -1e-5
    assert worst["bone_mm"] == 0
    assert worst["landmarks_voxel"] <= 1e-3
    assert worst["inverse_voxel"] <= 1e-3
    assert worst["wrong_labels"] == 0
    assert worst["median_largest_mm"] > 0.5


def test_a_plan_gives_the_same_bits_again(airway, rng, tmp_path):
    motions, plan = moved_airway(airway, rng)
    plan.save(tmp_path / "plan.json")
    again = Plan.load(tmp_path / "plan.json")
    assert again == plan
    assert json.loads(plan.to_json())["pliant_plan"] == 1
    first, second = motions.apply(airway, plan), TissueMotions(threads=2).apply(airway, again)
    assert (first.image.array == second.image.array).all()
    assert (first.image.array != airway.array).any()
    assert first.report == second.report
    prepared = motions.prepare(airway)
    for _ in range(2):
        third = motions.apply(prepared, plan)
        assert (first.image.array == third.image.array).all()
        assert (first.forward.array == third.forward.array).all()


def test_the_same_generator_gives_the_same_plan(airway, rng):
    seed = int(rng.integers(2**32))
    motions = TissueMotions(pushes=(1, 3), pulls=(0, 2), slides=(0, 1), at="wall")
    plans = [motions.sample(airway, numpy.random.default_rng(seed)) for _ in range(2)]
    assert plans[0] == plans[1]
    assert plans[0] != motions.sample(airway, numpy.random.default_rng(seed + 1))


def test_image_labels_and_points_are_those_of_the_fields(airway, rng):
    motions, plan = moved_airway(airway, rng)
    points = [airway.world_from_voxel(p) for p in rng.uniform(0, 63, (50, 3))]
    labels = (airway.array > -300).astype(numpy.uint8)
    moved = motions.apply(
        airway,
        plan,
        labels={"wall": labels, "mask": labels > 0},
        images=[labels * 1.0],
        points=points,
    )
    resampled = moved.inverse.apply_to_volume(airway).array
    assert numpy.abs(resampled.astype(int) - moved.image.array).max() <= 1
    assert moved.points == pytest.approx(moved.forward.apply_to_points(points), abs=1e-5)
    assert moved.labels["wall"].dtype == numpy.uint8
    assert moved.labels["mask"].dtype == bool
    assert (moved.labels["mask"] == moved.labels["wall"]).all()
    clear = numpy.abs(moved.images[0] - 0.5) > 0.45
    assert (moved.images[0].round() == moved.labels["wall"])[clear].all()
    assert moved.warp.unwarp_points(moved.points) == pytest.approx(numpy.array(points), abs=1e-6)


def test_the_order_of_axes_and_the_direction_do_not_matter(airway, rng):
    direction = random_direction(rng)
    scan = pliant.Volume(airway.array, (1, 1, 1), (0, 0, 0), direction, background=-1000)
    turned = pliant.Volume(
        airway.array.T, (1, 1, 1), (0, 0, 0), direction[:, ::-1], background=-1000
    )
    motions = TissueMotions(pushes=2)
    plan = motions.sample(scan, rng)
    first, second = motions.apply(scan, plan), motions.apply(turned, plan)
    assert numpy.abs(first.image.array.T.astype(int) - second.image.array).max() <= 1
    point = [scan.world_from_voxel((31.3, 30.2, 33.1))]
    assert first.warp.warp_points(point) == pytest.approx(second.warp.warp_points(point), abs=1e-5)


def slice_of(rng, axis):
    """A slice with bone and air, on an oblique grid."""
    shape = [40, 44, 48]
    shape[axis] = 1
    values = rng.uniform(-100, 100, shape).astype("float32")
    values[:6, :6] = 1000
    direction = random_direction(rng)
    return pliant.Volume(values, (0.8, 1.0, 1.2), (3, 4, 5), direction, background=-1000)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_scan_of_one_slice_moves_in_its_plane(axis, rng):
    scan = slice_of(rng, axis)
    motions = TissueMotions(pushes=2, swellings=1, breathing=1, waves=1)
    plan = motions.sample(scan, rng)
    assert [m["kind"] for m in plan.motions] == ["push", "push"]
    points = [scan.world_from_voxel(p) for p in rng.uniform(0, numpy.array(scan.size) - 1, (9, 3))]
    labels = (scan.array > 0).astype(numpy.uint8)
    moved = motions.apply(scan, plan, labels=labels, images=scan.array, points=points)
    assert moved.image.array.shape == labels.shape == moved.labels.shape
    assert moved.image.size == moved.warp.size == moved.forward.size == scan.size
    assert moved.image.background == scan.background
    assert (moved.image.array != scan.array).any()
    assert moved.smallest_jacobian > 0
    normal = numpy.array(scan.direction)[:, 2 - axis]
    assert numpy.abs(moved.forward.array @ normal).max() < 1e-6
    assert numpy.abs(moved.forward.array[scan.array > 300]).max() == 0
    assert moved.warp.unwarp_points(moved.points) == pytest.approx(numpy.array(points), abs=1e-6)
    again = pickle.loads(pickle.dumps(moved.warp))
    assert (again.warp_labels(labels) == moved.labels).all()
    # The same by the field, resampled by NumPy's own arithmetic.
    resampled = moved.inverse.apply_to_volume(scan).array
    inner = numpy.abs(resampled) < 150  # no bone, no background
    assert numpy.abs(resampled - moved.image.array)[inner].max() < 1


def test_motions_never_fail_on_a_slice(rng):
    scan = slice_of(rng, 0)
    motions = TissueMotions(pushes=(1, 3), pulls=1, slides=1)
    for _ in range(20):
        motions(scan, rng)


@pytest.mark.parametrize("axes", [2, 3])
def test_arrays_of_other_packages_may_be_flat_or_sheared(axes, rng):
    array = rng.uniform(-100, 100, (24, 26, 20)[:axes]).astype("float32")
    affine = numpy.eye(4)
    affine[:3, :3] = random_direction(rng) @ numpy.diag([1, 1, 3]) @ random_direction(rng)
    affine[:3, 3] = rng.uniform(-50, 50, 3)
    if axes == 2:
        affine = _frames.affine_of_spacing((0.8, 1.2))
    scan = _frames.scan_of(array, affine)
    assert scan.array.shape == (*array.shape, 1)[:3]
    lengths = numpy.linalg.norm(affine[:3, :3], axis=0)
    assert scan.spacing_mm == pytest.approx(tuple(lengths[::-1]))
    warp, _ = _frames.drawn_warp(TissueMotions(pushes=3, push_mm=6), scan, 5)
    assert warp.smallest_jacobian > 0 and warp.moved_voxels > 0
    moved = _frames.moved_array(warp, array[None], "bilinear")
    assert moved.shape == (1, *array.shape) and (moved[0] != array).any()
    # A point and the voxel in which it lies move alike, in each space.
    ijk = rng.uniform(2, 17, (20, axes))
    to = _frames.moved_points(warp, ijk, "voxel", affine)
    assert numpy.abs(to - ijk).max() > 0.01
    assert _frames.moved_points(warp, to, "voxel", affine, True) == pytest.approx(ijk, abs=1e-5)
    if axes == 3:
        ras = ijk @ affine[:3, :3].T + affine[:3, 3]
        moved_ras = _frames.moved_points(warp, ras, "ras", affine)
        assert moved_ras == pytest.approx(to @ affine[:3, :3].T + affine[:3, 3], abs=1e-6)


def test_a_push_moves_a_ball():
    """The moved region is as wide along diagonals as along axes."""
    scan = pliant.Volume(numpy.zeros((64, 64, 64), numpy.int16))
    plan = Plan(
        ({"kind": "push", "point_mm": [32, 32, 32], "by_mm": [3, 0, 0], "radius_mm": 4},),
        TissueMotions().tissue_settings,
    )
    moved = numpy.linalg.norm(TissueMotions().apply(scan, plan).forward.array, axis=-1) > 1.0
    k, j, i = numpy.nonzero(moved)
    offsets = numpy.stack([i, j, k], -1) - 32
    along = numpy.abs(offsets).max()
    diagonal = (offsets @ numpy.array([1, 1, 0])).max() / 2**0.5
    assert diagonal > 0.85 * along  # 0.7 of an octahedron


def test_elastic_moves_most_of_the_scan_smoothly(rng):
    values = numpy.zeros((64, 64, 64), numpy.int16)
    values[:, 30:34, :8] = 700
    scan = pliant.Volume(values, (1.5, 1.5, 1.5))
    motions = TissueMotions(preset="elastic")
    plan = motions.sample(scan, rng)
    assert {m["kind"] for m in plan.motions} == {"wave"}
    moved = motions.apply(scan, plan)
    field = moved.forward.array
    lengths = numpy.linalg.norm(field, axis=-1)
    assert (lengths > 0.1).mean() > 0.8
    assert moved.smallest_jacobian > 0.2
    assert lengths[values > 300].max() == 0
    # Smooth: second differences are a small part of the first ones; of noise, they are larger.
    interior = field[16:-16, 16:-16, 16:-16]
    first, second = (numpy.abs(numpy.diff(interior, n, axis=0)).mean() for n in (1, 2))
    assert second < 0.35 * first
    assert Plan.from_json(plan.to_json()) == plan


def made_by_hand(scan, plan, sweeps):
    """Displacements of a plan's pushes by make_elastic()."""
    tissue = pliant.make_elastic(scan, 1, **plan.tissue)
    for number, motion in enumerate(plan.motions, 1):
        assert motion["kind"] in ("push", "pull")
        report = tissue.push(motion["point_mm"], motion["by_mm"], motion["radius_mm"], number)
        if report.step_fraction == 0:
            tissue.release(number)
        if report.limited_by != "none":
            tissue.advance(max_steps=1)
    tissue.advance(max_steps=sweeps)
    return tissue.displacement_field().array


def test_the_elastic_scan_moves_as_the_tissue_by_itself(airway, rng):
    # Without voids, the moduli are those of the tissue.
    tissue = {"moduli_kpa": [(-950, 2.0), (40, 8.0)], "poisson_ratio": 0.4}
    motions = TissueMotions(model="elastic", pushes=2, pulls=1, push_mm=(2, 6), tissue=tissue)
    plan = motions.sample(airway, rng)
    assert plan.model == "elastic" and plan.tissue == {"held_above_hu": 300.0, **tissue}
    moved = motions.apply(airway, plan)
    expected = made_by_hand(airway, plan, sweeps=5)
    assert numpy.abs(expected).max() > 0.5
    parts = [step["fraction"] for step in moved.report]
    if moved.smallest_jacobian > 0.05 or min(parts) == 1:  # nothing was taken back
        assert numpy.abs(moved.forward.array - expected).max() < 1e-5


def test_samples_of_the_elastic_scan_neither_fold_nor_move_bone(rng):
    for at in ("soft", "wall", "soft", "wall"):
        scan = random_scan(rng, 32)
        motions = TissueMotions(model="elastic", pushes=(1, 2), pulls=(0, 1), slides=(0, 1), at=at)
        found = check(scan, motions, rng)
        print(found)
        assert found["smallest_jacobian"] > 0
        assert found["bone_mm"] == 0
        assert found["landmarks_voxel"] <= 1e-3
        assert found["inverse_voxel"] <= 1e-3
        assert found["wrong_labels"] == 0


def test_a_plan_of_the_elastic_scan_gives_the_same_bits_again(airway, rng, tmp_path):
    motions = TissueMotions(model="elastic", pushes=1, slides=1, at="wall", push_mm=4)
    plan = motions.sample(airway, rng)
    plan.save(tmp_path / "plan.json")
    again = Plan.load(tmp_path / "plan.json")
    assert again == plan and again.model == "elastic"
    first, second = motions.apply(airway, plan), TissueMotions(threads=2).apply(airway, again)
    assert (first.image.array == second.image.array).all()
    assert (first.image.array != airway.array).any()
    assert first.report == second.report
    prepared = pickle.loads(pickle.dumps(motions.prepare(airway)))
    assert prepared.model == "elastic"
    for _ in range(2):
        third = motions.apply(prepared, plan)
        assert (first.forward.array == third.forward.array).all()
    with pytest.raises(pliant.Error, match="plan: expected the tissue of the prepared scan"):
        motions.apply(TissueMotions().prepare(airway), plan)


def test_what_would_fold_is_reduced():
    """Two tools that wring the tissue between them."""
    scan = pliant.Volume(numpy.full((32, 32, 32), 40, numpy.int16), (2, 2, 2))
    motions = TissueMotions(model="elastic", tissue={"window_cells": 8})
    pushes = [((20, 32, 32), (24, 0, 0)), ((40, 30, 32), (-24, 6, 0)), ((30, 40, 32), (0, -20, 8))]
    plan = Plan(
        tuple(
            {"kind": "push", "point_mm": list(at), "by_mm": list(by), "radius_mm": 9}
            for at, by in pushes
        ),
        motions.tissue_settings,
        "elastic",
    )
    moved = motions.apply(scan, plan)
    print(moved.report, moved.smallest_jacobian)
    assert moved.smallest_jacobian > 0
    assert numpy.abs(moved.forward.array).max() > 0.5


def test_a_scan_that_is_not_in_hu_is_named(rng):
    scan = pliant.Volume(rng.random((16, 16, 16)).astype("float32"))
    with pytest.warns(UserWarning, match="expected HU, found values from .* to .*: no bone"):
        TissueMotions().prepare(scan)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        TissueMotions(bone_hu=None).prepare(scan)
        TissueMotions().prepare(pliant.Volume(numpy.zeros((8, 8, 8), "float32")))


def test_motions_begin_at_a_label(airway, rng):
    labels = numpy.zeros(airway.array.shape, numpy.uint8)
    soft = numpy.argwhere((airway.array > 0) & (airway.array < 200))
    chosen = soft[rng.integers(len(soft), size=3)]
    labels[tuple(chosen.T)] = 5
    motions = TissueMotions(at=5, pushes=1)
    for _ in range(5):
        (motion,) = motions.sample(airway, rng, labels).motions
        kji = numpy.rint(airway.voxel_from_world(motion["point_mm"]))[::-1]
        assert (kji == chosen).all(1).any()
    assert motions.sample(airway, rng, labels * 0).motions == ()
    with pytest.raises(pliant.Error, match="labels"):
        motions.sample(airway, rng)


def test_labels_by_majority_have_no_ragged_edges(airway, rng):
    motions, plan = moved_airway(airway, rng, label_sampling="majority")
    labels = (airway.array > -300).astype(numpy.uint8)
    moved = motions.apply(airway, plan, labels=labels, images=labels.astype(numpy.float32))
    clear = numpy.abs(moved.images - 0.5) > 1e-3
    assert ((moved.images > 0.5) == moved.labels)[clear].all()


def test_warps_and_motions_are_pickled(airway, rng):
    motions, plan = moved_airway(airway, rng)
    again = pickle.loads(pickle.dumps(motions))
    assert repr(again) == repr(motions)
    warp = motions.apply(airway, plan).warp
    other = pickle.loads(pickle.dumps(warp))
    labels = (airway.array > -300).astype(numpy.int32)
    assert (warp.warp_labels(labels) == other.warp_labels(labels)).all()
    assert other.smallest_jacobian == warp.smallest_jacobian
    half = Warp((*warp.state[:-1], False))
    assert (half.unwarp_labels(labels) == warp.unwarp_labels(labels)).all()
    with pytest.raises(pliant.Error, match="inverse"):
        half.warp_labels(labels)


def image_in_a_child(motions, scan, plan, results):
    results.put(motions.apply(scan, plan).image.array.sum())


def test_forked_workers_apply_plans(airway, rng):
    motions, plan = moved_airway(airway, rng)
    here = motions.apply(airway, plan).image.array.sum()
    context = multiprocessing.get_context("fork")
    results = context.Queue()
    child = context.Process(target=image_in_a_child, args=(motions, airway, plan, results))
    child.start()
    assert results.get(timeout=60) == here
    child.join(60)


@pytest.mark.parametrize(
    ("settings", "field"),
    [
        ({"pushes": (3, 1)}, "pushes"),
        ({"pushes": 1.5}, "pushes"),
        ({"push_mm": (-1, 2)}, "push_mm"),
        ({"offset": 0.34}, "offset"),
        ({"at": "hard"}, "at"),
        ({"breathing": 2}, "breathing"),
        ({"label_sampling": "linear"}, "label_sampling"),
        ({"threads": -1}, "threads"),
        ({"preset": "rubber"}, "preset"),
        ({"model": "springs"}, "model"),
        ({"model": "elastic", "preset": "elastic"}, "preset"),
        ({"model": "elastic", "waves": (0, 2)}, "waves"),
        ({"model": "elastic", "swellings": 1}, "swellings"),
        ({"model": "elastic", "breathing": 0.5}, "breathing"),
    ],
)
def test_bad_settings_are_named(settings, field):
    with pytest.raises(pliant.Error, match=field) as raised:
        TissueMotions(**settings)
    assert raised.value.field == field
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"pliant_plan": 2}, "version 1"),
        ({"motions": [{"kind": "jump"}]}, "kind"),
        (
            {"motions": [{"kind": "push", "point_mm": [1, 2], "by_mm": [0, 0, 1], "radius_mm": 3}]},
            "point_mm",
        ),
        ({"motions": [{"kind": "push"}]}, "point_mm"),
        ({"tissue": 3}, "tissue"),
        ({"model": "springs"}, "model: expected chainmail or elastic"),
    ],
)
def test_bad_plans_are_named(change, text):
    with pytest.raises(pliant.Error, match=text):
        Plan.from_dict({"pliant_plan": 1, "motions": [], "tissue": {}, **change})


def test_other_bad_input(airway, rng, tmp_path):
    motions, plan = moved_airway(airway, rng)
    with pytest.raises(pliant.Error, match="fold"):
        TissueMotions(tissue={"air_enabled": True}).prepare(airway)
    with pytest.raises(pliant.Error, match="axes"):
        motions.apply(airway, plan, labels=numpy.zeros((3, 4, 5), numpy.uint8))
    with pytest.raises(pliant.Error, match="another type"):
        motions.apply(airway, plan, labels=numpy.zeros(airway.array.shape, complex))
    with pytest.raises(pliant.Error, match="plan"):
        motions.apply(TissueMotions(offset=0.1).prepare(airway), plan)
    with pytest.raises(pliant.Error, match="JSON"):
        Plan.from_json("{")
    with pytest.raises(pliant.Error, match="missing"):
        Plan.load(tmp_path / "missing.json")
    with pytest.raises(pliant.Error, match="state"):
        Warp(())
    with pytest.raises(pliant.Error, match="rng: expected a numpy.random.Generator, found 7"):
        motions.sample(airway, 7)
    (tmp_path / "latin.json").write_bytes(b"\xff")
    with pytest.raises(pliant.Error, match="expected a plan in JSON"):
        Plan.load(tmp_path / "latin.json")
    assert motions.apply(airway, plan, labels=[]).labels == []
    nothing = pliant.Volume(numpy.full((8, 8, 8), -1000, numpy.int16))
    assert motions.sample(nothing, rng).motions == ()
    still = motions.apply(nothing, Plan((), motions.tissue_settings), points=[(1, 2, 3)])
    assert still.smallest_jacobian == 1
    assert (still.image.array == -1000).all()


def test_bad_input_of_the_elastic_scan(airway):
    motions = TissueMotions(model="elastic")
    wave = {"kind": "wave", "by_mm": [1, 0, 0], "vector_per_mm": [0, 0, 0.1], "phase": 0}
    with pytest.raises(pliant.Error, match="motions: expected pushes, pulls and slides"):
        motions.apply(airway, Plan((wave,), motions.tissue_settings, "elastic"))
    with pytest.raises(pliant.Error, match="offset"):
        TissueMotions(model="elastic", tissue={"offset": 0.2}).prepare(airway)
    with pytest.raises(pliant.Error, match="2 voxels or more along each axis"):
        motions.prepare(pliant.Volume(numpy.zeros((1, 16, 16), numpy.int16)))


def test_pliant_imports_no_other_package():
    code = (
        "import sys, pliant, pliant.augment; "
        "print([m for m in ('torch', 'monai', 'torchio', 'batchgenerators') if m in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"
