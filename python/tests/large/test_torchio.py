# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""RandomTissueMotion in TorchIO's own machinery."""

import copy
import pickle

import numpy
import pytest

from augment_case import case, ramps, skip_without

skip_without("torch", "torchio")

import torch
import torchio

from pliant.augment.torchio import RandomTissueMotion, TissueMotion


def subject_of(case):
    return torchio.Subject(
        ct=torchio.ScalarImage(tensor=case.xyz[None].astype(numpy.float32), affine=case.affine),
        ramp=torchio.ScalarImage(tensor=ramps(case.xyz.shape), affine=case.affine),
        organs=torchio.LabelMap(tensor=case.labels[None], affine=case.affine),
        landmarks=case.points,
        name="airway",
    )


def transform_of(**settings):
    return RandomTissueMotion(
        **{"scan": "ct", "points": ("landmarks",), "pushes": 3, "at": "wall", **settings}
    )


def test_image_label_and_points_move_together(case):
    subject = subject_of(case)
    torch.manual_seed(3)
    moved = transform_of()(subject)
    assert moved["name"] == "airway"
    assert (moved.ct.data != subject.ct.data).any()
    assert (subject["landmarks"] == case.points).all()
    assert moved.organs.data.dtype == subject.organs.data.dtype
    source = moved.ramp.data.numpy()
    kept = (numpy.abs(source % 1 - 0.5) > 1e-3).all(0) & (source > 0.5).all(0)
    kept &= (source < numpy.array(case.xyz.shape)[:, None, None, None] - 1.5).all(0)
    i, j, k = numpy.rint(source[:, kept]).astype(int)
    assert (case.labels[i, j, k] == moved.organs.data[0].numpy()[kept]).all()
    to = case.voxels_of(moved["landmarks"])
    assert numpy.abs(to - case.voxels).max() > 0.1


def test_history_repeats_the_sample(case):
    subject = subject_of(case)
    moved = transform_of()(subject)
    (applied,) = moved.get_applied_transforms()
    assert isinstance(applied, TissueMotion)
    assert "plan=" in repr(applied)
    again = moved.get_composed_history()(subject_of(case))
    for name in ("ct", "organs", "ramp"):
        assert (again[name].data == moved[name].data).all()
    assert (again["landmarks"] == moved["landmarks"]).all()
    # The plan alone gives the same bits.
    only_plan = TissueMotion(applied.plan, scan="ct", points=("landmarks",))(subject_of(case))
    assert (only_plan.ct.data == moved.ct.data).all()


def test_the_inverse_is_exact(case):
    moved = torchio.Compose([transform_of(), torchio.RandomFlip(axes=(0,), flip_probability=1)])(
        subject_of(case)
    )
    inverse = moved.get_inverse_transform(warn=False)
    back = inverse(moved)
    ramp = ramps(case.xyz.shape)
    inner = (slice(None), *(slice(6, -6),) * 3)
    difference = numpy.abs(back.ramp.data.numpy() - ramp)[inner]
    assert numpy.median(difference) < 1e-4
    assert numpy.quantile(difference, 0.99) < 0.5
    assert (back.organs.data[0].numpy() == case.labels).mean() > 0.98
    assert numpy.abs(case.voxels_of(back["landmarks"]) - case.voxels).max() < 1e-6
    nearest = moved.apply_inverse_transform(warn=False, image_interpolation="nearest")
    assert set(numpy.unique(nearest.ct.data)) <= set(numpy.unique(moved.ct.data))
    assert nearest.get_applied_transforms() == []


def test_seeds_probability_and_choice_of_images(case):
    results = []
    for seed in (5, 5, 6):
        torch.manual_seed(seed)
        results.append(transform_of()(subject_of(case)).ct.data)
    assert (results[0] == results[1]).all()
    assert (results[0] != results[2]).any()
    assert (transform_of(p=0)(subject_of(case)).ct.data.numpy() == case.xyz[None]).all()
    only = transform_of(include=["ct"], points=())(subject_of(case))
    assert (only.ct.data.numpy() != case.xyz[None]).any()
    assert (only.organs.data.numpy() == case.labels[None]).all()
    at_label = RandomTissueMotion(scan="ct", labels="organs", at=1, pushes=2)(subject_of(case))
    assert (at_label.ct.data.numpy() != case.xyz[None]).any()


def test_other_inputs_pickle_and_copies(case):
    tensor = torch.as_tensor(case.xyz[None]).float()
    torch.manual_seed(1)
    moved = RandomTissueMotion(pushes=3)(tensor)
    assert moved.shape == tensor.shape
    assert (moved != tensor).any()
    transform = transform_of()
    for again in (pickle.loads(pickle.dumps(transform)), copy.deepcopy(transform)):
        torch.manual_seed(2)
        first = transform(subject_of(case)).ct.data
        torch.manual_seed(2)
        assert (again(subject_of(case)).ct.data == first).all()


@pytest.mark.parametrize("workers", [0, 2])
def test_loaders(case, workers):
    dataset = torchio.SubjectsDataset([subject_of(case) for _ in range(4)], transform_of())
    loader = torchio.SubjectsLoader(dataset, batch_size=2, num_workers=workers)
    shapes = [batch["ct"][torchio.DATA].shape for batch in loader]
    assert shapes == [(2, 1, *case.xyz.shape)] * 2
