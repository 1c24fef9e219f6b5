# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""TissueMotionTransform of batchgeneratorsv2 (nnU-Net v2) and of the classic batchgenerators."""

import pickle

import numpy
import pytest

from augment_case import case, ramps, skip_without

skip_without("torch", "batchgenerators", "batchgeneratorsv2")

import torch
from batchgenerators.dataloading.multi_threaded_augmenter import MultiThreadedAugmenter
from batchgenerators.transforms.abstract_transforms import Compose
from batchgeneratorsv2.transforms.utils.compose import ComposeTransforms
from batchgeneratorsv2.transforms.utils.random import RandomTransform

from pliant.augment import batchgenerators as classic
from pliant.augment import batchgeneratorsv2 as second

SETTINGS = {"spacing_mm": (2.0, 2.5, 2.2), "pushes": 3, "at": "wall"}


def labels_agree(case, source, labels):
    kept = (numpy.abs(source % 1 - 0.5) > 1e-3).all(0) & (source > 0.5).all(0)
    kept &= (source < numpy.array(case.xyz.shape)[:, None, None, None] - 1.5).all(0)
    i, j, k = numpy.rint(source[:, kept]).astype(int)
    return kept.any() and (case.labels[i, j, k] == labels[kept]).all()


def sample_of(case):
    image = numpy.concatenate([case.xyz[None].astype(numpy.float32), ramps(case.xyz.shape)])
    return {
        "image": torch.from_numpy(image),
        "segmentation": torch.from_numpy(case.labels[None].astype(numpy.int16)),
        "regression_target": torch.from_numpy(image[:1].copy()),
        "keypoints": torch.from_numpy(case.voxels),
        "name": "airway",
    }


def test_v2_moves_all_parts_together(case):
    numpy.random.seed(3)
    sample = sample_of(case)
    moved = second.TissueMotionTransform(**SETTINGS)(**sample_of(case))
    assert moved["name"] == "airway"
    assert (moved["image"] != sample["image"]).any()
    assert moved["segmentation"].dtype == torch.int16
    assert labels_agree(case, moved["image"][1:].numpy(), moved["segmentation"][0].numpy())
    assert (moved["regression_target"][0] == moved["image"][0]).all()
    to = moved["keypoints"].numpy()
    assert numpy.abs(to - case.voxels).max() > 0.1
    at = numpy.rint(to).astype(int)
    inside = (at > 0).all(1) & (at < numpy.array(case.xyz.shape) - 1).all(1)
    near = moved["image"][1:].numpy()[(slice(None), *at[inside].T)].T
    assert numpy.abs(near - case.voxels[inside]).max() < 2.5


def test_v2_composes_and_follows_numpys_seed(case):
    transform = ComposeTransforms(
        [RandomTransform(second.TissueMotionTransform(**SETTINGS), apply_probability=1.0)]
    )
    images = []
    for seed in (5, 5, 6):
        numpy.random.seed(seed)
        images.append(transform(**sample_of(case))["image"])
    assert (images[0] == images[1]).all()
    assert (images[0] != images[2]).any()
    assert "TissueMotionTransform" in repr(pickle.loads(pickle.dumps(transform)))
    with pytest.raises(NotImplementedError):
        second.TissueMotionTransform(**SETTINGS)(**sample_of(case), bbox=[1, 2])


def test_v2_understands_normalised_values(case):
    mean, std = 80.0, 250.0
    sample = sample_of(case)
    numpy.random.seed(4)
    expected = second.TissueMotionTransform(**SETTINGS)(**sample_of(case))["segmentation"]
    sample["image"][0] = (sample["image"][0] - mean) / std
    numpy.random.seed(4)
    found = second.TissueMotionTransform(hu_from_value=(std, mean), **SETTINGS)(**sample)
    assert (found["segmentation"] == expected).all()


def batch_of(case):
    image = numpy.concatenate([case.xyz[None].astype(numpy.float32), ramps(case.xyz.shape)])
    return {
        "data": numpy.stack([image, image]),
        "seg": numpy.stack([case.labels[None], case.labels[None]]).astype(numpy.float32),
        "keys": ["a", "b"],
    }


def test_classic_moves_each_sample(case):
    numpy.random.seed(3)
    batch = batch_of(case)
    moved = classic.TissueMotionTransform(**SETTINGS)(**batch_of(case))
    assert moved["keys"] == ["a", "b"]
    assert (moved["data"][0] != moved["data"][1]).any()
    for b in range(2):
        assert (moved["data"][b] != batch["data"][b]).any()
        assert labels_agree(case, moved["data"][b, 1:], moved["seg"][b, 0])
    never = classic.TissueMotionTransform(p_per_sample=0, **SETTINGS)(**batch_of(case))
    assert (never["data"] == batch["data"]).all()
    no_seg = classic.TissueMotionTransform(**SETTINGS)(data=batch["data"])
    assert "seg" not in no_seg


class Endless:
    """A loader as those of batchgenerators."""

    def __init__(self, case):
        self.case = case

    def __iter__(self):
        return self

    def __next__(self):
        return batch_of(self.case)

    def set_thread_id(self, number):
        pass


def test_classic_works_in_processes(case):
    augmenter = MultiThreadedAugmenter(
        Endless(case), Compose([classic.TissueMotionTransform(**SETTINGS)]), 2, 1, seeds=[1, 2]
    )
    try:
        first, second_batch = next(augmenter), next(augmenter)
    finally:
        augmenter._finish()
    assert (first["data"] != second_batch["data"]).any()
