# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""MONAI: soft tissue moves in a training pipeline, and a prediction goes back."""

import torch
from monai.data import MetaTensor
from monai.transforms import Compose, Invertd, ScaleIntensityRanged

import pliant
from pliant.augment.monai import RandTissueMotiond

scan = pliant.make_phantom("airway", (96, 96, 96))
image = torch.as_tensor(scan.array.copy())[None].float()
train = Compose(
    [
        # Before the intensities change: bone is found by HU.
        RandTissueMotiond(
            ["image", "label"], mode=("bilinear", "nearest"), prob=1.0, pushes=(1, 3), at="wall"
        ),
        ScaleIntensityRanged("image", -1000, 1000, 0, 1),
    ]
).set_random_state(seed=7)
item = {"image": MetaTensor(image), "label": MetaTensor((image > -300).to(torch.uint8))}
moved = train(item)

# A network's segmentation of the moved image, taken back to the scan.
moved["prediction"] = moved["label"].clone()
back = Invertd("prediction", train, orig_keys="label")(moved)
agreement = (back["prediction"] == item["label"]).float().mean().item()
print(f"voxels that agree after the way there and back: {100 * agreement:.2f} %")
assert agreement > 0.99
