# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Augmentation that cannot fold: soft tissue moves, bone stays where it is.

Example:
    >>> import numpy, pliant
    >>> from pliant.augment import TissueMotions
    >>> scan = pliant.read_volume("ct.nrrd")
    >>> motions = TissueMotions(pushes=(1, 3), push_mm=(2, 12))
    >>> plan = motions.sample(scan, numpy.random.default_rng(7))
    >>> moved = motions.apply(scan, plan, labels=labels, points=landmarks)
    >>> moved.image, moved.labels, moved.points, moved.smallest_jacobian

Image, labels and points move by one field with its exact inverse, in LPS millimetres. A plan can be
saved, and gives the same bits again.

Skins of other packages are in modules of their own, which import them: pliant.augment.monai,
.torchio, .batchgenerators and .batchgeneratorsv2.
"""

from pliant._core import PreparedScan, Warp
from pliant.augment._motions import Applied, TissueMotions
from pliant.augment._plan import Plan

__all__ = ["Applied", "Plan", "PreparedScan", "TissueMotions", "Warp"]
