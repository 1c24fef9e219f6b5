# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The classic batchgenerators: a transform of batches that moves soft tissue."""

from typing import Any

import numpy
from batchgenerators.transforms.abstract_transforms import AbstractTransform

from pliant.augment import _frames
from pliant.augment._motions import TissueMotions

__all__ = ["TissueMotionTransform"]


class TissueMotionTransform(AbstractTransform):
    """Moves soft tissue in 'data' (b, c, x, y, z) and 'seg' by a field for each sample.

    Random numbers come from numpy's global generator, as those of other transforms.

    Args:
        spacing_mm: Of the three axes, in the order of the arrays.
        hu_from_value: HU = first * value + second, of channel `scan_channel`.
        scan_channel: The CT among the channels.
        mode_seg: "nearest" or "majority".
        border_cval_data: Value outside of the patch; None: the sample's smallest.
        border_cval_seg: Label there.
        p_per_sample: Probability of a motion.
        motions: Settings of pliant.augment.TissueMotions. Motions at labels use the segmentation's
            first channel.
    """

    def __init__(
        self,
        spacing_mm: tuple[float, float, float] = (1.0, 1.0, 1.0),
        hu_from_value: tuple[float, float] = (1.0, 0.0),
        scan_channel: int = 0,
        mode_seg: str = "nearest",
        border_cval_data: float | None = None,
        border_cval_seg: float = 0,
        data_key: str = "data",
        label_key: str = "seg",
        p_per_sample: float = 1.0,
        **motions: Any,
    ) -> None:
        self.affine = _frames.affine_of_spacing(spacing_mm)
        self.hu_from_value = (float(hu_from_value[0]), float(hu_from_value[1]))
        self.scan_channel, self.mode_seg = scan_channel, _frames.check_mode(mode_seg)
        self.border_cval_data, self.border_cval_seg = border_cval_data, border_cval_seg
        self.data_key, self.label_key = data_key, label_key
        self.p_per_sample = p_per_sample
        self.motions = TissueMotions(**motions)

    def __call__(self, **data_dict: Any) -> dict[str, Any]:
        data, seg = data_dict[self.data_key], data_dict.get(self.label_key)
        moved_data = numpy.array(data)
        moved_seg = None if seg is None else numpy.array(seg)
        for b in range(len(data)):
            if not numpy.random.uniform() < self.p_per_sample:
                continue
            at_labels = None if isinstance(self.motions.at, str) or seg is None else seg[b][0]
            seed = int(numpy.random.randint(2**32, dtype=numpy.uint32))
            channel = numpy.asarray(data[b][self.scan_channel])
            scan = _frames.scan_of(channel, self.affine, self.hu_from_value)
            warp, _ = _frames.drawn_warp(self.motions, scan, seed, at_labels)
            moved_data[b] = _frames.moved_array(
                warp, moved_data[b], "bilinear", self.border_cval_data
            )
            if moved_seg is not None:
                moved_seg[b] = _frames.moved_array(
                    warp, moved_seg[b], self.mode_seg, self.border_cval_seg
                )
        data_dict[self.data_key] = moved_data
        if moved_seg is not None:
            data_dict[self.label_key] = moved_seg
        return data_dict
