# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""MONAI: a dictionary transform that moves soft tissue, and is inverted exactly.

Example:
    >>> from monai.transforms import Compose, LoadImaged
    >>> from pliant.augment.monai import RandTissueMotiond
    >>> train = Compose([
    ...     LoadImaged(["image", "label"], ensure_channel_first=True),
    ...     RandTissueMotiond(["image", "label"], mode=("bilinear", "nearest"), prob=0.5),
    ... ])

It belongs before transforms that change intensities, since bone is found by HU; or hu_from_value
tells how HU follow from the values.
"""

from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import numpy
import torch
from monai.config import KeysCollection
from monai.data.meta_obj import get_track_meta
from monai.data.meta_tensor import MetaTensor
from monai.transforms import InvertibleTransform, MapTransform, RandomizableTransform
from monai.utils import TransformBackends, convert_to_tensor, ensure_tuple, ensure_tuple_rep
from monai.utils.enums import TraceKeys

from pliant._core import Warp
from pliant.augment import _frames
from pliant.augment._motions import TissueMotions

__all__ = ["RandTissueMotionD", "RandTissueMotionDict", "RandTissueMotiond"]

_LPS_TO_RAS = numpy.diag([-1.0, -1.0, 1.0, 1.0])


def _affine_of(item: Any) -> numpy.typing.NDArray[Any]:
    """Voxels to RAS."""
    if not isinstance(item, MetaTensor):
        return numpy.eye(4)
    affine = item.affine.detach().cpu().numpy().astype(float)
    return _LPS_TO_RAS @ affine if str(item.meta.get("space", "RAS")) == "LPS" else affine


class RandTissueMotiond(RandomizableTransform, MapTransform, InvertibleTransform):
    """Moves soft tissue in images and label maps by one random field that can't fold.

    Args:
        keys: Images and label maps (C, x, y, z) on one grid.
        mode: "bilinear" for images, "nearest" or "majority" for label maps; one for each key.
        prob: Probability of a motion.
        scan_key: The CT, whose first channel tells bone, soft tissue and air; the first key.
        label_key: Label map of motions at a label (`at` is a label or several).
        point_keys: Landmarks (..., 3), which move along.
        point_space: "ras", "lps" (world coordinates) or "voxel".
        padding_value: Value outside of the grid, one for each key; None: an image's smallest value,
            and 0 for label maps.
        hu_from_value: HU = first * value + second.
        allow_missing_keys: Don't raise if a key is missing.
        motions: Settings of pliant.augment.TissueMotions.
    """

    backend = [TransformBackends.NUMPY]

    def __init__(
        self,
        keys: KeysCollection,
        mode: str | Sequence[str] = "bilinear",
        prob: float = 0.1,
        scan_key: Hashable | None = None,
        label_key: Hashable | None = None,
        point_keys: KeysCollection = (),
        point_space: str = "ras",
        padding_value: float | Sequence[float | None] | None = None,
        hu_from_value: tuple[float, float] = (1.0, 0.0),
        allow_missing_keys: bool = False,
        **motions: Any,
    ) -> None:
        images, points = ensure_tuple(keys), ensure_tuple(point_keys)
        MapTransform.__init__(self, (*images, *points), allow_missing_keys)
        RandomizableTransform.__init__(self, prob)
        modes = ensure_tuple_rep(mode, len(images))
        self.mode = (*map(_frames.check_mode, modes), *("points" for _ in points))
        self.padding_value = (
            *ensure_tuple_rep(padding_value, len(images)),
            *(None for _ in points),
        )
        self.scan_key = images[0] if scan_key is None else scan_key
        self.label_key = label_key
        self.point_space = point_space
        self.hu_from_value = (float(hu_from_value[0]), float(hu_from_value[1]))
        self.motions = TissueMotions(**motions)

    def randomize(self, data: Any = None) -> None:
        super().randomize(None)
        self._seed = int(self.R.randint(2**32, dtype=numpy.uint32))

    def __call__(self, data: Mapping[Hashable, Any]) -> dict[Hashable, Any]:
        d = dict(data)
        self.randomize()
        warp, plan = None, ""
        affine = _affine_of(d.get(self.scan_key))
        if self._do_transform:
            scan = _frames.scan_of(self._array(d[self.scan_key])[0], affine, self.hu_from_value)
            labels = None
            if self.label_key is not None:
                labels = self._array(d[self.label_key])[0]
            warp, plan = _frames.drawn_warp(self.motions, scan, self._seed, labels)
        # The same keys in both cases; arrays that a loader may collate.
        state = () if warp is None else warp.state
        for key, mode, beyond in self.key_iterator(d, self.mode, self.padding_value):
            item = convert_to_tensor(d[key], track_meta=get_track_meta())
            if warp is not None:
                item = self._moved(item, warp, mode, beyond, affine, False)
            extra = {
                "mode": mode,
                "plan": plan,
                "warp": state,
                "affine": affine,
                "padding_value": TraceKeys.NONE if beyond is None else beyond,
            }
            self.push_transform(item, extra_info=extra)
            d[key] = item
        return d

    def inverse(self, data: Mapping[Hashable, Any]) -> dict[Hashable, Any]:
        d = dict(data)
        for key in self.key_iterator(d):
            info = self.pop_transform(d[key])
            if not info[TraceKeys.DO_TRANSFORM]:
                continue
            extra = info[TraceKeys.EXTRA_INFO]
            warp = Warp((*extra["warp"][:-1], False))
            beyond = extra["padding_value"]
            d[key] = self._moved(
                convert_to_tensor(d[key], track_meta=get_track_meta()),
                warp,
                extra["mode"],
                None if isinstance(beyond, str) else float(beyond),
                extra["affine"],
                True,
            )
        return d

    @staticmethod
    def _array(item: Any) -> numpy.typing.NDArray[Any]:
        if isinstance(item, torch.Tensor):
            return item.detach().cpu().numpy()
        return numpy.asarray(item)

    def _moved(
        self, item: Any, warp: Warp, mode: str, beyond: float | None, affine: Any, back: bool
    ) -> Any:
        given = item.dtype
        tensor = item.detach().cpu()
        if given == torch.bfloat16:
            tensor = tensor.float()
        array = numpy.asarray(tensor.numpy())
        if mode == "points":
            made = _frames.moved_points(warp, array, self.point_space, affine, back)
        else:
            made = _frames.moved_array(warp, array, mode, beyond, back)
        out = torch.as_tensor(made).to(device=item.device, dtype=given)
        return MetaTensor(out).copy_meta_from(item) if isinstance(item, MetaTensor) else out


RandTissueMotionD = RandTissueMotionDict = RandTissueMotiond
