# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""TorchIO: soft tissue and landmarks move; the history repeats and inverts the sample."""

import torch
import torchio

import pliant
from pliant.augment.torchio import RandomTissueMotion

scan = pliant.make_phantom("airway", (96, 96, 96))
image = torch.as_tensor(scan.array.copy())[None].float()
subject = torchio.Subject(
    ct=torchio.ScalarImage(tensor=image),
    wall=torchio.LabelMap(tensor=(image > -300).to(torch.uint8)),
    landmarks=torch.tensor([[40.0, 50.0, 48.0], [60.0, 45.0, 30.0]], dtype=torch.float64),
)
transform = torchio.Compose(
    [
        RandomTissueMotion(pushes=(1, 3), at="wall", points=("landmarks",)),
        torchio.RandomFlip(axes=(0,)),
    ]
)
torch.manual_seed(7)
moved = transform(subject)
print(moved.get_applied_transforms())

back = moved.get_inverse_transform(warn=False)(moved)
apart = (back["landmarks"] - subject["landmarks"]).abs().max().item()
print(f"landmarks after the way there and back: {apart:.1e} mm apart")
assert apart < 1e-6
