# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""RandTissueMotiond in MONAI's own machinery."""

import pickle

import numpy
import pytest

from augment_case import case, ramps, skip_without

skip_without("torch", "monai")

import torch
from monai.data import DataLoader, Dataset, MetaTensor, decollate_batch, list_data_collate
from monai.transforms import Compose, Flipd, Invertd, RandFlipd

import pliant
from pliant.augment.monai import RandTissueMotiond

SETTINGS = {"pushes": 3, "at": "wall", "prob": 1.0}


def item_of(case):
    return {
        "image": MetaTensor(
            torch.as_tensor(case.xyz[None]).float(), affine=torch.tensor(case.affine)
        ),
        "label": MetaTensor(torch.as_tensor(case.labels[None]), affine=torch.tensor(case.affine)),
        "ramp": MetaTensor(
            torch.as_tensor(ramps(case.xyz.shape)), affine=torch.tensor(case.affine)
        ),
        "points": torch.as_tensor(case.points),
        "name": "airway",
    }


def transform_of(**settings):
    return RandTissueMotiond(
        ["image", "label", "ramp"],
        mode=("bilinear", "nearest", "bilinear"),
        point_keys="points",
        **{**SETTINGS, **settings},
    )


def test_image_label_and_points_move_together(case):
    item = item_of(case)
    moved = transform_of().set_random_state(3)(item)
    assert moved["name"] == "airway"
    assert (moved["image"] != item["image"]).any()
    for key in ("image", "label", "ramp"):
        assert isinstance(moved[key], MetaTensor)
        assert moved[key].dtype == item[key].dtype
        assert (moved[key].affine == item[key].affine).all()
        assert moved[key].applied_operations[-1]["class"] == "RandTissueMotiond"
    assert set(numpy.unique(moved["label"])) <= {0, 1, 2}
    # The moved ramp says where each voxel was: at a moved point, where the point was.
    to = case.voxels_of(moved["points"].numpy())
    source = moved["ramp"].numpy()
    at = numpy.rint(to).astype(int)
    inside = (at > 0).all(1) & (at < numpy.array(case.xyz.shape) - 1).all(1)
    near = source[(slice(None), *at[inside].T)].T
    assert numpy.abs(near - case.voxels[inside]).max() < 2.5
    assert numpy.abs(to - case.voxels).max() > 0.1
    # Labels are the nearest of the same inverse.
    kept = (numpy.abs(source % 1 - 0.5) > 1e-3).all(0) & (source > 0.5).all(0)
    kept &= (source < numpy.array(case.xyz.shape)[:, None, None, None] - 1.5).all(0)
    i, j, k = numpy.rint(source[:, kept]).astype(int)
    assert (case.labels[i, j, k] == moved["label"][0].numpy()[kept]).all()


def test_the_state_decides_and_the_data_stay(case):
    item = item_of(case)
    before = item["image"].clone()
    first = transform_of().set_random_state(7)(item)
    second = transform_of().set_random_state(7)(item)
    third = transform_of().set_random_state(8)(item)
    assert (first["image"] == second["image"]).all()
    assert (first["image"] != third["image"]).any()
    assert (item["image"] == before).all()
    never = transform_of(prob=0.0)(item)
    assert (never["image"] == before).all()
    assert isinstance(never["image"], MetaTensor)


def test_invertd_takes_predictions_back(case):
    pipeline = Compose(
        [
            RandFlipd(["image", "label", "ramp"], prob=1.0, spatial_axis=1),
            RandTissueMotiond(
                ["image", "label", "ramp"], mode=("bilinear", "nearest", "bilinear"), **SETTINGS
            ),
            Flipd(["image", "label", "ramp"], spatial_axis=0),
        ]
    ).set_random_state(5)
    item = item_of(case)
    moved = pipeline(item)
    moved["prediction"] = moved["ramp"].clone()
    back = Invertd("prediction", pipeline, orig_keys="ramp", nearest_interp=False)(moved)
    found = back["prediction"].numpy()
    ramp = ramps(case.xyz.shape)
    inner = (slice(None), *(slice(6, -6),) * 3)
    # Positions are exact; a ramp that was resampled twice has small errors at kinks of the field.
    difference = numpy.abs(found - ramp)[inner]
    assert numpy.median(difference) < 1e-4
    assert numpy.quantile(difference, 0.99) < 0.5
    assert back["prediction"].applied_operations == []
    nearest = Invertd("prediction", pipeline, orig_keys="label", nearest_interp=True)(
        {**moved, "prediction": moved["label"].clone()}
    )
    agree = (nearest["prediction"][0].numpy() == case.labels).mean()
    assert agree > 0.98
    assert nearest["prediction"].dtype == torch.uint8


def test_the_inverse_of_points_is_exact(case):
    transform = transform_of().set_random_state(2)
    item = item_of(case)
    back = transform.inverse(transform(item))
    apart = case.voxels_of(back["points"].numpy()) - case.voxels
    assert numpy.abs(apart).max() < 1e-6
    assert back["image"].applied_operations == []


@pytest.mark.parametrize("workers", [0, 2])
def test_data_loaders_collate_and_decollate(case, workers):
    items = [{k: v for k, v in item_of(case).items() if k != "points"} for _ in range(4)]
    transform = RandTissueMotiond(
        ["image", "label", "ramp"],
        mode=("bilinear", "nearest", "bilinear"),
        **{**SETTINGS, "prob": 0.5},
    )
    transform.set_random_state(1)
    loader = DataLoader(
        Dataset(items, transform), batch_size=2, num_workers=workers, collate_fn=list_data_collate
    )
    count = 0
    for batch in loader:
        assert batch["image"].shape == (2, 1, *case.xyz.shape)
        for one in decollate_batch(batch):
            inverted = transform.inverse(one) if workers == 0 else one
            assert inverted["image"].shape == (1, *case.xyz.shape)
            count += 1
    assert count == 4


def test_normalised_values_other_types_and_lps(case):
    plain = transform_of(hu_from_value=(1000.0, -200.0)).set_random_state(4)
    item = item_of(case)
    expected = transform_of().set_random_state(4)(item)
    item["image"] = (item["image"] + 200) / 1000
    found = plain(item)
    assert (found["label"] == expected["label"]).all()
    assert torch.allclose(found["image"] * 1000 - 200, expected["image"], atol=0.01)
    half = {"image": item["image"].to(torch.float16)}
    half_moved = RandTissueMotiond("image", hu_from_value=(1000.0, -200.0), **SETTINGS)(half)
    assert half_moved["image"].dtype == torch.float16
    lps = item_of(case)
    turn = torch.diag(torch.tensor([-1.0, -1.0, 1.0, 1.0], dtype=torch.float64))
    for key in ("image", "label", "ramp"):
        lps[key].affine = turn @ lps[key].affine
        lps[key].meta["space"] = "LPS"
    again = transform_of().set_random_state(4)(lps)
    assert numpy.abs(again["points"].numpy() - expected["points"].numpy()).max() < 1e-6


def test_missing_keys_pickle_and_bad_settings(case):
    item = {"image": item_of(case)["image"]}
    with pytest.raises(KeyError):
        transform_of()(item)
    moved = transform_of(allow_missing_keys=True)(item)
    assert "label" not in moved
    again = pickle.loads(pickle.dumps(transform_of().set_random_state(9)))
    assert (
        again(item_of(case))["image"] == transform_of().set_random_state(9)(item_of(case))["image"]
    ).all()
    with pytest.raises(pliant.Error, match="mode"):
        RandTissueMotiond("image", mode="bicubic")
    with pytest.raises(TypeError, match="pushs"):
        RandTissueMotiond("image", pushs=3)
