# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""batchgeneratorsv2, which nnU-Net v2 uses: a transform that moves soft tissue.

Example:
    >>> from batchgeneratorsv2.transforms.utils.random import RandomTransform
    >>> from pliant.augment.batchgeneratorsv2 import TissueMotionTransform
    >>> transforms.append(RandomTransform(
    ...     TissueMotionTransform(spacing_mm=(3, 0.8, 0.8), hu_from_value=(std, mean)), 0.2))

nnU-Net normalises CT before: hu_from_value has the standard deviation and the mean of its plans.
"""

from typing import Any

import numpy
import torch
from batchgeneratorsv2.transforms.base.basic_transform import BasicTransform

from pliant._core import Warp
from pliant.augment import _frames
from pliant.augment._motions import TissueMotions

__all__ = ["TissueMotionTransform"]


class TissueMotionTransform(BasicTransform):
    """Moves soft tissue in 'image', 'segmentation', 'regression_target' and 'keypoints'.

    Random numbers come from numpy's global generator, as those of SpatialTransform.

    Args:
        spacing_mm: Of the three axes, in the order of the arrays.
        hu_from_value: HU = first * value + second, of channel `scan_channel`.
        scan_channel: The CT among the channels.
        mode_seg: "nearest" or "majority".
        padding_value_image: Value outside of the patch; None: the image's smallest.
        padding_value_seg: Label there.
        motions: Settings of pliant.augment.TissueMotions. Motions at labels use the segmentation's
            first channel.
    """

    def __init__(
        self,
        spacing_mm: tuple[float, float, float] = (1.0, 1.0, 1.0),
        hu_from_value: tuple[float, float] = (1.0, 0.0),
        scan_channel: int = 0,
        mode_seg: str = "nearest",
        padding_value_image: float | None = None,
        padding_value_seg: float = 0,
        **motions: Any,
    ) -> None:
        super().__init__()
        self.affine = _frames.affine_of_spacing(spacing_mm)
        self.hu_from_value = (float(hu_from_value[0]), float(hu_from_value[1]))
        self.scan_channel = scan_channel
        self.mode_seg = _frames.check_mode(mode_seg)
        self.padding_value_image = padding_value_image
        self.padding_value_seg = padding_value_seg
        self.motions = TissueMotions(**motions)

    def get_parameters(self, **data_dict: Any) -> dict[str, Any]:
        channel = data_dict["image"][self.scan_channel].numpy()
        labels = None
        if not isinstance(self.motions.at, str):
            labels = data_dict["segmentation"][0].numpy()
        seed = int(numpy.random.randint(2**32, dtype=numpy.uint32))
        scan = _frames.scan_of(channel, self.affine, self.hu_from_value)
        warp, plan = _frames.drawn_warp(self.motions, scan, seed, labels)
        return {"warp": warp, "plan": plan}

    def _apply_to_image(self, img: torch.Tensor, **params: Any) -> torch.Tensor:
        return _moved(params["warp"], img, "bilinear", self.padding_value_image)

    def _apply_to_regr_target(self, regression_target: Any, **params: Any) -> torch.Tensor:
        return self._apply_to_image(regression_target, **params)

    def _apply_to_segmentation(self, segmentation: torch.Tensor, **params: Any) -> torch.Tensor:
        return _moved(params["warp"], segmentation, self.mode_seg, self.padding_value_seg)

    def _apply_to_keypoints(self, keypoints: Any, **params: Any) -> Any:
        """Keypoints (..., 3) in voxels, in the order of the axes."""
        is_tensor = isinstance(keypoints, torch.Tensor)
        array = keypoints.numpy() if is_tensor else numpy.asarray(keypoints)
        made = _frames.moved_points(params["warp"], array, "voxel", self.affine)
        return torch.from_numpy(made) if is_tensor else made

    def _apply_to_bbox(self, bbox: Any, **params: Any) -> Any:
        raise NotImplementedError("TissueMotionTransform: bounding boxes follow from labels")


def _moved(warp: Warp, tensor: torch.Tensor, mode: str, beyond: float | None) -> torch.Tensor:
    return torch.from_numpy(_frames.moved_array(warp, tensor.numpy(), mode, beyond))
