# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""TorchIO: a random transform that moves soft tissue, with a history and an exact inverse.

Example:
    >>> import torchio
    >>> from pliant.augment.torchio import RandomTissueMotion
    >>> transform = torchio.Compose([RandomTissueMotion(p=0.5), torchio.RandomNoise()])
    >>> moved = transform(torchio.Subject(ct=torchio.ScalarImage("ct.nii.gz"),
    ...                                   organs=torchio.LabelMap("organs.nii.gz")))
    >>> same_shape = moved.apply_inverse_transform(ignore_intensity=True)
"""

from typing import Any

import numpy
import torch
from torchio import LabelMap, ScalarImage, Subject
from torchio.transforms import SpatialTransform
from torchio.transforms.augmentation import RandomTransform

from pliant._core import Warp
from pliant._error import Error
from pliant.augment import _frames
from pliant.augment._motions import TissueMotions
from pliant.augment._plan import Plan

__all__ = ["RandomTissueMotion", "TissueMotion"]


def _scan_of(subject: Subject, images: list[Any], name: str | None) -> Any:
    """The image that tells bone from soft tissue."""
    if name is not None:
        return subject[name]
    for image in images:
        if isinstance(image, ScalarImage):
            return image
    raise Error("scan: expected a ScalarImage in the subject, found none", field="scan")


class TissueMotion(SpatialTransform):
    """Moves a subject's images, label maps and points by a plan.

    Args:
        plan: pliant.augment.Plan, or its JSON.
        scan: Name of the CT; None: the first ScalarImage.
        points: Names of the subject's landmarks (n, 3), in RAS millimetres.
        image_interpolation: "linear", or "nearest" for images as well.
        label_sampling: "nearest" or "majority".
        hu_from_value: HU = first * value + second.
        warp: The map of an earlier call, which the history keeps: it needs no scan.
    """

    def __init__(
        self,
        plan: Plan | str,
        scan: str | None = None,
        points: tuple[str, ...] = (),
        image_interpolation: str = "linear",
        label_sampling: str = "nearest",
        hu_from_value: tuple[float, float] = (1.0, 0.0),
        warp: Warp | None = None,
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self.plan = plan.to_json() if isinstance(plan, Plan) else plan
        self.scan, self.points = scan, tuple(points)
        self.image_interpolation = self.parse_interpolation(image_interpolation)
        self.label_sampling, self.hu_from_value = label_sampling, hu_from_value
        self.warp = warp
        self.invert_transform = False
        self.args_names = [
            "plan",
            "scan",
            "points",
            "image_interpolation",
            "label_sampling",
            "hu_from_value",
            "warp",
        ]

    def apply_transform(self, subject: Subject) -> Subject:
        subject.check_consistent_spatial_shape()
        images = self.get_images(subject)
        if self.warp is None:
            image = _scan_of(subject, images, self.scan)
            scan = _frames.scan_of(image.data[0].numpy(), image.affine, self.hu_from_value)
            self.warp = TissueMotions().apply(scan, Plan.from_json(self.plan)).warp
        back = bool(self.invert_transform)
        for image in images:
            mode = "nearest" if self.image_interpolation == "nearest" else "bilinear"
            if isinstance(image, LabelMap):
                mode = self.label_sampling
            moved = _frames.moved_array(self.warp, image.data.numpy(), mode, None, back)
            image.set_data(torch.as_tensor(moved))
        for name in self.points:
            given = subject[name]
            array = given.numpy() if isinstance(given, torch.Tensor) else numpy.asarray(given)
            affine = subject.get_first_image().affine
            moved = _frames.moved_points(self.warp, array, "ras", affine, back)
            subject[name] = torch.as_tensor(moved) if isinstance(given, torch.Tensor) else moved
        return subject


class RandomTissueMotion(RandomTransform, SpatialTransform):
    """Moves soft tissue by a random field that can't fold; bone stays where it is.

    Args:
        scan: Name of the CT; None: the first ScalarImage.
        labels: Name of the label map of motions at a label (`at` is a label or several).
        points: Names of the subject's landmarks (n, 3), in RAS millimetres.
        hu_from_value: HU = first * value + second.
        motions: Settings of pliant.augment.TissueMotions; p, include, exclude, ... are TorchIO's.
    """

    def __init__(
        self,
        scan: str | None = None,
        labels: str | None = None,
        points: tuple[str, ...] = (),
        hu_from_value: tuple[float, float] = (1.0, 0.0),
        **motions: Any,
    ) -> None:
        base = ("p", "copy", "include", "exclude", "keys", "keep", "parse_input", "label_keys")
        super().__init__(**{name: motions.pop(name) for name in base if name in motions})
        self.scan, self.labels, self.points = scan, labels, tuple(points)
        self.hu_from_value = (float(hu_from_value[0]), float(hu_from_value[1]))
        self.motions = TissueMotions(**motions)

    def apply_transform(self, subject: Subject) -> Subject:
        subject.check_consistent_spatial_shape()
        image = _scan_of(subject, self.get_images(subject), self.scan)
        scan = _frames.scan_of(image.data[0].numpy(), image.affine, self.hu_from_value)
        labels = None if self.labels is None else subject[self.labels].data[0].numpy()
        seed = self._get_random_seed()
        warp, plan = _frames.drawn_warp(self.motions, scan, seed, labels)
        transform = TissueMotion(
            plan=plan,
            scan=self.scan,
            points=self.points,
            label_sampling=self.motions.label_sampling,
            hu_from_value=self.hu_from_value,
            warp=warp,
            **self._get_base_args(),
        )
        return transform(subject)
