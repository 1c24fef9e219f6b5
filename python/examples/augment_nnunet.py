# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""batchgeneratorsv2, as in a trainer of nnU-Net v2: a transform among its training transforms.

In a trainer, override get_training_transforms(), and insert the transform after the spatial one.
"""

import numpy
import torch
from batchgeneratorsv2.transforms.utils.compose import ComposeTransforms
from batchgeneratorsv2.transforms.utils.random import RandomTransform

import pliant
from pliant.augment.batchgeneratorsv2 import TissueMotionTransform

scan = pliant.make_phantom("airway", (96, 96, 96))
hu = torch.as_tensor(scan.array.copy())[None].float()
# CTNormalization with the numbers of the plans' fingerprint.
mean, std = 97.0, 278.0
transforms = ComposeTransforms(
    [
        RandomTransform(
            TissueMotionTransform(
                spacing_mm=scan.spacing_mm[::-1], hu_from_value=(std, mean), pushes=(1, 3)
            ),
            apply_probability=1.0,
        )
    ]
)
numpy.random.seed(7)
sample = {"image": (hu - mean) / std, "segmentation": (hu > -300).to(torch.int16)}
moved = transforms(**{name: tensor.clone() for name, tensor in sample.items()})
print("voxels that changed:", int((moved["image"] != sample["image"]).sum()))
assert (moved["segmentation"] != sample["segmentation"]).any()
