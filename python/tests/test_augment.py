# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Augmentation: plans, what moves together, bad input. Large counts: augment_samples.py."""

import json
import multiprocessing
import os
import pickle
import subprocess
import sys

import numpy
import pytest

import pliant
from augment_samples import worst_of
from conftest import random_direction
from pliant.augment import Plan, TissueMotions, Warp


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
        airway, plan, labels={"wall": labels, "mask": labels > 0}, images=[labels * 1.0], points=points
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
        ({"motions": [{"kind": "push", "point_mm": [1, 2], "by_mm": [0, 0, 1], "radius_mm": 3}]}, "point_mm"),
        ({"motions": [{"kind": "push"}]}, "point_mm"),
        ({"tissue": 3}, "tissue"),
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
    nothing = pliant.Volume(numpy.full((8, 8, 8), -1000, numpy.int16))
    assert motions.sample(nothing, rng).motions == ()
    still = motions.apply(nothing, Plan((), motions.tissue_settings), points=[(1, 2, 3)])
    assert still.smallest_jacobian == 1
    assert (still.image.array == -1000).all()


def test_pliant_imports_no_other_package():
    code = (
        "import sys, pliant, pliant.augment; "
        "print([m for m in ('torch', 'monai', 'torchio', 'batchgenerators') if m in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"
