# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Random motions of soft tissue: drawn as a plan, applied to a scan and all that belongs to it."""

import copy
import functools
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy
import numpy.typing

from pliant._core import Field, PreparedScan, Volume, Warp
from pliant._error import expected_error
from pliant.augment._plan import MODELS, Plan
from pliant.augment._steps import reduced, report_of

Array = numpy.typing.NDArray[Any]
Range = float | Sequence[float]

_PRESETS: dict[str, dict[str, Range]] = {
    "push": {"pushes": (1, 3), "waves": 0},
    "elastic": {"pushes": 0, "waves": (3, 6)},
}
# Motions that the elastic scan doesn't make: they follow a given field.
_FIELDS = ("swellings", "breathing", "waves")
# A scan whose values are all smaller isn't in HU; so many of its voxels are looked at.
_NO_HU, _LOOKED_AT = 20.0, 4096
# Tries to find a position, and values that are looked at in each.
_TRIES, _DRAWN = 12, 256
# A position is good if bone is so far that at least this part of the push is possible.
_GOOD_SHARE = 0.5
# Part of the distance from bone by which tissue of the elastic scan can move without folds.
_SLACK = 0.4
# The share is a guess: pushes are planned longer by this factor.
_SPARE = 1.5


def _range(name: str, given: Range, low: float = 0.0) -> tuple[float, float]:
    numbers = (given, given) if isinstance(given, (int, float)) else tuple(given)
    if len(numbers) != 2 or not low <= numbers[0] <= numbers[1] < float("inf"):
        raise expected_error(name, f"a number or two that grow, from {low:g} upwards", given)
    return float(numbers[0]), float(numbers[1])


def _count(name: str, given: Range) -> tuple[int, int]:
    low, high = _range(name, given)
    if low != int(low) or high != int(high):
        raise expected_error(name, "whole numbers", given)
    return int(low), int(high)


def _each(given: Any, work: Callable[[Any], Any]) -> Any:
    """The results for one array, or for those of a sequence or a mapping."""
    if given is None:
        return None
    if isinstance(given, Mapping):
        return {name: work(value) for name, value in given.items()}
    if isinstance(given, (list, tuple)) and not (given and numpy.isscalar(given[0])):
        return type(given)(work(value) for value in given)
    return work(given)


def _warn_unless_hu(scan: Volume) -> None:
    """Warns of normalised values, among which neither bone nor air is found."""
    if scan.array.dtype.kind != "f":
        return
    values = scan.array.ravel()[:: max(1, scan.array.size // _LOOKED_AT)]
    low, high = float(values.min()), float(values.max())
    if low < high and max(abs(low), abs(high)) <= _NO_HU:
        warnings.warn(
            f"scan: expected HU, found values from {low:g} to {high:g}: no bone is held; "
            "hu_from_value gives HU, bone_hu=None moves all",
            stacklevel=4,
        )


class Applied:
    """A sample: a scan and all that belongs to it, after the motions of a plan.

    Attributes:
        image: The moved scan.
        labels, images, points: As they were given, moved by the same field; None if not given.
        warp: The map, for more of them, and for the way back.
        report: A dictionary for each motion: kind, status ("applied", "limited", "rejected"),
            limited_by, fraction that was done, moved_voxels.
        plan: The motions.
    """

    def __init__(
        self,
        image: Volume,
        labels: Any,
        images: Any,
        points: Array | None,
        warp: Warp,
        report: list[dict[str, Any]],
        plan: Plan,
    ) -> None:
        self.image, self.labels, self.images, self.points = image, labels, images, points
        self.warp, self.report, self.plan = warp, report, plan

    @functools.cached_property
    def forward(self) -> Field:
        """Displacements [mm, LPS] at rest voxel centres."""
        return self.warp.forward_field()

    @functools.cached_property
    def inverse(self) -> Field:
        """The exact inverse, on the scan's grid."""
        return self.warp.inverse_field()

    @functools.cached_property
    def smallest_jacobian(self) -> float:
        """Smallest volume ratio at a corner of a cell; above 0: nothing is folded."""
        return self.warp.smallest_jacobian


class TissueMotions:
    """Random pushes, pulls, slides, swellings and breaths, which can't fold tissue.

    Counts and lengths are a number, or two between which they are drawn.

    Args:
        model: Of the tissue: "chainmail", or "elastic", the finite elements of
            pliant.make_elastic, in equilibrium under all tools. It makes pushes, pulls and slides.
        preset: "push", or "elastic": waves of ChainMail, which move most of the scan smoothly, and
            no pushes.
        pushes, pulls: Number of spheres that carry tissue along. From a wall (at="wall") pushes go
            into the tissue and pulls out of it; elsewhere they go anywhere. None: those of the
            preset. A push moves a ball of tissue, less towards its edge.
        push_mm: Length of a push or pull. Bone nearby shortens it.
        tool_mm: Radius of the sphere.
        slides: Number of spheres that move along a wall of air without friction.
        slide_mm, slide_tool_mm: Length of their way, and their radius.
        swellings: Number of balls that grow; none in a scan of one slice.
        swelling_mm, swelling_radius_mm: Growth of a ball's radius, and the radius.
        breathing: Probability of a breath, 0...1: in or out; none in a scan of one slice.
        breath_mm: Motion of the diaphragm. Swellings and breaths come first, fade out towards bone
            and the scan's border, and are made smaller as a whole where they could fold.
        waves: Number of plane waves that shift tissue to and fro; None: those of the preset.
        wave_mm, wave_length_mm: Their amplitude and length. They are made with swellings and
            breaths, and likewise fade out and are made smaller; none in a scan of one slice.
        at: Where motions begin: "soft" (any soft tissue), "wall" (beside air), or a label or
            several, for which sample() needs the label map.
        bone_hu: Voxels above it don't move; None: all move.
        air_hu: Voxels below it are air, which tools don't take.
        offset: Of ChainMail: largest change of a voxel's length, and its largest shear, as a
            fraction of it, above 0 and below 1/3. No volume shrinks below 1 - 3 * offset of itself.
        label_sampling: "nearest", or "majority": the label with the largest trilinear weight.
        label_beyond: Label of space outside of the scan.
        threads: 1: the caller's alone, as in data loaders' workers; 0: one for each core.
        tissue: More settings, of pliant.settings_of("chainmail") or, for the model "elastic",
            "elastic_scan". Those of ChainMail that could fold are refused.
    """

    def __init__(
        self,
        *,
        model: str = "chainmail",
        preset: str = "push",
        pushes: Range | None = None,
        pulls: Range = 0,
        push_mm: Range = (2.0, 12.0),
        tool_mm: Range = (3.0, 15.0),
        slides: Range = 0,
        slide_mm: Range = (3.0, 10.0),
        slide_tool_mm: Range = (2.0, 5.0),
        swellings: Range = 0,
        swelling_mm: Range = (1.0, 4.0),
        swelling_radius_mm: Range = (8.0, 25.0),
        breathing: float = 0.0,
        breath_mm: Range = (3.0, 12.0),
        waves: Range | None = None,
        wave_mm: Range = (2.0, 6.0),
        wave_length_mm: Range = (60.0, 160.0),
        at: str | int | Sequence[int] = "soft",
        bone_hu: float | None = 300.0,
        air_hu: float = -500.0,
        offset: float = 0.25,
        label_sampling: str = "nearest",
        label_beyond: float = 0,
        threads: int = 1,
        tissue: Mapping[str, Any] | None = None,
    ) -> None:
        if model not in MODELS:
            raise expected_error("model", " or ".join(MODELS), model)
        if preset not in _PRESETS:
            raise expected_error("preset", " or ".join(_PRESETS), preset)
        if model == preset == "elastic":
            raise expected_error("preset", "push with the model elastic, not waves", preset)
        self.model = model
        pushes = _PRESETS[preset]["pushes"] if pushes is None else pushes
        waves = _PRESETS[preset]["waves"] if waves is None else waves
        self.preset = preset
        self.waves, self.wave_mm = _count("waves", waves), _range("wave_mm", wave_mm)
        self.wave_length_mm = _range("wave_length_mm", wave_length_mm, 1.0)
        self.pushes, self.pulls = _count("pushes", pushes), _count("pulls", pulls)
        self.push_mm, self.tool_mm = _range("push_mm", push_mm), _range("tool_mm", tool_mm)
        self.slides = _count("slides", slides)
        self.slide_mm = _range("slide_mm", slide_mm)
        self.slide_tool_mm = _range("slide_tool_mm", slide_tool_mm)
        self.swellings = _count("swellings", swellings)
        self.swelling_mm = _range("swelling_mm", swelling_mm)
        self.swelling_radius_mm = _range("swelling_radius_mm", swelling_radius_mm)
        if not 0 <= breathing <= 1:
            raise expected_error("breathing", "a probability, 0...1", breathing)
        self.breathing, self.breath_mm = float(breathing), _range("breath_mm", breath_mm)
        for name in _FIELDS if model == "elastic" else ():
            if numpy.any(getattr(self, name)):
                only = "0 with the model elastic, which makes pushes, pulls and slides"
                raise expected_error(name, only, getattr(self, name))
        if isinstance(at, str):
            if at not in ("soft", "wall"):
                raise expected_error("at", "soft, wall or labels", at)
            self.at: str | tuple[int, ...] = at
        else:
            self.at = (int(at),) if isinstance(at, (int, numpy.integer)) else tuple(map(int, at))
        if not 0 < offset < 1 / 3:
            raise expected_error("offset", "above 0 and below 1/3", offset)
        if label_sampling not in ("nearest", "majority"):
            raise expected_error("label_sampling", "nearest or majority", label_sampling)
        if threads < 0:
            raise expected_error("threads", "0 (one for each core) or more", threads)
        self.bone_hu, self.air_hu, self.offset = bone_hu, float(air_hu), float(offset)
        self.label_sampling, self.label_beyond = label_sampling, label_beyond
        self.threads = int(threads)
        self.tissue = dict(tissue or {})

    def __repr__(self) -> str:
        return f"TissueMotions({', '.join(f'{k}={v!r}' for k, v in vars(self).items())})"

    @property
    def tissue_settings(self) -> dict[str, Any]:
        """The settings of a plan's tissue."""
        bone = 1e6 if self.bone_hu is None else float(self.bone_hu)
        if self.model == "elastic":
            return {"held_above_hu": bone, **self.tissue}
        return {
            "offset": self.offset,
            "bone_threshold_hu": bone,
            "max_movement_mm": 500.0,
            "air_enabled": False,
            "air_threshold_hu": self.air_hu,
            "limits": "rounded",
            **self.tissue,
        }

    def prepare(self, scan: Volume) -> PreparedScan:
        """Prepares a scan for several samples; sample() and apply() take it in place of the scan.

        The scan's voxels must not change meanwhile.
        """
        return self._prepared(scan, self.model, self.tissue_settings)

    def _prepared(self, scan: Volume, model: str, settings: Mapping[str, Any]) -> PreparedScan:
        prepared = PreparedScan(scan, self.threads, model, **settings)
        if self.bone_hu is not None:
            _warn_unless_hu(scan)
        if not prepared.fold_number < 1:
            raise expected_error(
                "tissue", "settings that can't fold (a fold number below 1)", prepared.fold_number
            )
        return prepared

    def sample(
        self, scan: Volume | PreparedScan, rng: numpy.random.Generator, labels: Any = None
    ) -> Plan:
        """Draws motions for a scan.

        Args:
            labels: The label map (k, j, i), if `at` names labels.

        Returns:
            A plan. It has fewer motions where the scan has no position for them: no soft tissue, no
            wall, no voxel of the labels.
        """
        if not isinstance(rng, numpy.random.Generator):
            raise expected_error("rng", "a numpy.random.Generator", repr(rng))
        prepared = scan if isinstance(scan, PreparedScan) else self.prepare(scan)
        return _Sampler(self, prepared, rng, labels).plan()

    def apply(
        self,
        scan: Volume | PreparedScan,
        plan: Plan,
        *,
        labels: Any = None,
        images: Any = None,
        points: numpy.typing.ArrayLike | None = None,
    ) -> Applied:
        """Moves a scan, and all that belongs to it, by a plan.

        Args:
            labels: Label map (..., k, j, i), or a list or dictionary of them.
            images: Likewise, of other images on the scan's grid; 0 outside of it.
            points: Landmarks (n, 3) [mm, LPS].
        """
        if isinstance(scan, PreparedScan):
            if (plan.model, plan.tissue) != (scan.model, scan.settings):
                found = (plan.model, plan.tissue)
                raise expected_error("plan", "the tissue of the prepared scan", found)
            prepared = scan
        else:
            prepared = self._prepared(scan, plan.model, plan.tissue)
        try:
            report = report_of(prepared, plan)
        except BaseException:
            prepared.reset()
            raise
        warp, image, part = prepared.finish()
        return Applied(
            image,
            _each(labels, lambda array: self.warp_labels(warp, array)),
            _each(images, warp.warp_image),
            None if points is None else warp.warp_points(points),
            warp,
            [reduced(motion, part) for motion in report],
            plan,
        )

    def warp_labels(self, warp: Warp, array: Any) -> Any:
        """Moves a label map as apply() does."""
        if numpy.asarray(array).dtype == bool:
            moved = warp.warp_labels(numpy.asarray(array).view(numpy.uint8), self.label_sampling)
            return moved.view(bool)
        return warp.warp_labels(array, self.label_sampling, self.label_beyond)

    def __call__(
        self,
        scan: Volume | PreparedScan,
        rng: numpy.random.Generator,
        *,
        labels: Any = None,
        images: Any = None,
        points: numpy.typing.ArrayLike | None = None,
    ) -> Applied:
        """Draws a plan and applies it."""
        at_labels = None
        if not isinstance(self.at, str):
            at_labels = labels
        plan = self.sample(scan, rng, at_labels)
        return self.apply(scan, plan, labels=labels, images=images, points=points)


class _Sampler:
    """Draws the motions of one plan."""

    def __init__(
        self,
        motions: TissueMotions,
        prepared: PreparedScan,
        rng: numpy.random.Generator,
        labels: Any,
    ) -> None:
        self.motions, self.prepared, self.rng = motions, prepared, rng
        self.scan = prepared.scan
        self.array: Array = self.scan.array
        self.size = numpy.array(self.array.shape)
        # Axes of the world along which there is one slice: nothing moves out of it.
        self.single: Array = self.scan.direction.T[self.size[::-1] == 1]
        self.labels: Array | None = None
        if not isinstance(motions.at, str):
            if labels is None:
                raise expected_error("labels", "a label map, since at names labels", "none")
            self.labels = numpy.asarray(labels)
            if self.labels.shape != self.array.shape:
                raise expected_error("labels", f"axes {self.array.shape}", self.labels.shape)
        settings = prepared.settings
        if prepared.model == "elastic":
            self.bone, self.air = settings["held_above_hu"], motions.air_hu
        else:
            self.bone, self.air = settings["bone_threshold_hu"], settings["air_threshold_hu"]

    def plan(self) -> Plan:
        m = self.motions
        drawn: list[dict[str, Any] | None] = []
        if len(self.single):
            m = copy.copy(m)
            m.breathing, m.swellings, m.waves = 0.0, (0, 0), (0, 0)  # need a surrounding
        if m.breathing > 0 and self.rng.random() < m.breathing:
            drawn.append(self.breath())
        drawn += [self.swelling() for _ in range(self.number(m.swellings))]
        if m.waves[1] > 0:
            drawn += [self.wave() for _ in range(self.number(m.waves))]
        for kind, count in (("push", m.pushes), ("pull", m.pulls)):
            drawn += [self.push(kind) for _ in range(self.number(count))]
        drawn += [self.slide() for _ in range(self.number(m.slides))]
        motions = tuple(one for one in drawn if one)
        return Plan(motions, self.prepared.settings, self.prepared.model)

    def number(self, between: tuple[int, int]) -> int:
        return int(self.rng.integers(between[0], between[1] + 1))

    def length(self, between: tuple[float, float]) -> float:
        return float(self.rng.uniform(*between))

    def direction(self) -> Array:
        while True:
            vector = self.rng.normal(size=3)
            for axis in self.single:
                vector = vector - (vector @ axis) * axis
            length = float(numpy.linalg.norm(vector))
            if length > 1e-3:
                return vector / length

    def fits(self, at: Array, is_wall: bool) -> numpy.typing.NDArray[numpy.bool_]:
        """Which of some voxels (n, 3) motions can begin at."""
        k, j, i = at.T
        values = self.array[k, j, i]
        fits: numpy.typing.NDArray[numpy.bool_] = (values >= self.air) & (values <= self.bone)
        if self.labels is not None:
            fits &= numpy.isin(self.labels[k, j, i], self.motions.at)
        if is_wall:
            beside = numpy.zeros(len(at), bool)
            for axis in range(3):
                for step in (-1, 1):
                    other = at.copy()
                    other[:, axis] = numpy.clip(at[:, axis] + step, 0, self.size[axis] - 1)
                    beside |= self.array[tuple(other.T)] < self.air
            fits &= beside
        return fits

    def voxel(self, is_wall: bool) -> Array | None:
        """A random voxel (k, j, i) that fits."""
        for _ in range(_TRIES):
            drawn = self.rng.integers(0, self.size, (_DRAWN, 3))
            fits = numpy.flatnonzero(self.fits(drawn, is_wall))
            if len(fits):
                found: Array = drawn[fits[0]]
                return found
        # Such voxels are rare: all are looked at.
        soft = (self.array >= self.air) & (self.array <= self.bone)
        if self.labels is not None:
            soft &= numpy.isin(self.labels, self.motions.at)
        drawn = numpy.argwhere(soft)
        if is_wall:
            drawn = drawn[self.fits(drawn, is_wall)]
        if len(drawn) == 0:
            return None
        rare: Array = drawn[self.rng.integers(len(drawn))]
        return rare

    def normal(self, at: Array) -> Array | None:
        """From tissue to air [LPS], from differences over two voxels."""
        slope = numpy.zeros(3)
        for axis in range(3):
            low, high = at.copy(), at.copy()
            low[axis], high[axis] = max(at[axis] - 2, 0), min(at[axis] + 2, self.size[axis] - 1)
            step = (high[axis] - low[axis]) * self.scan.spacing_mm[2 - axis]
            if step > 0:
                difference = float(self.array[tuple(high)]) - float(self.array[tuple(low)])
                slope[2 - axis] = difference / step
        outward = -(self.scan.direction @ slope)
        length = float(numpy.linalg.norm(outward))
        return outward / length if length > 0 else None

    def point(self, at: Array) -> Array:
        # A border voxel's centre may lie outside of an oblique scan by rounding.
        inside = numpy.clip(at.astype(float), 1e-6, self.size - 1 - 1e-6)
        inside[self.size == 1] = 0
        return numpy.array(self.scan.world_from_voxel(inside[::-1]))

    def is_inside(self, point: Array) -> bool:
        ijk = numpy.array(self.scan.voxel_from_world(point))
        rounding = numpy.where(self.size[::-1] == 1, 1e-6, 0)
        return bool((ijk >= -rounding).all() and (ijk <= self.size[::-1] - 1 + rounding).all())

    def push(self, kind: str) -> dict[str, Any] | None:
        best: dict[str, Any] | None = None
        best_share = -1.0
        for _ in range(_TRIES):
            at = self.voxel(self.motions.at == "wall")
            if at is None:
                return None
            radius, length = self.length(self.motions.tool_mm), self.length(self.motions.push_mm)
            way = self.direction()
            if self.motions.at == "wall" and (normal := self.normal(at)) is not None:
                way = way + 2 * (normal if kind == "pull" else -normal)
                way /= numpy.linalg.norm(way)
            point = self.point(at)
            share = self.possible_share(point, radius, length)
            if share > best_share:
                best_share = share
                length *= min(1.0, _SPARE * share)  # the rest would be computed in vain
                best = {
                    "kind": kind,
                    "point_mm": point.tolist(),
                    "by_mm": (length * way).tolist(),
                    "radius_mm": radius,
                }
            if share >= _GOOD_SHARE:
                break
        return best

    def possible_share(self, point: Array, radius: float, length: float) -> float:
        """About the part of a push that bone allows; the elastic scan's border is held as well."""
        room, slack = self.prepared.bone_distance_mm(point), self.motions.offset
        if self.prepared.model == "elastic":
            ijk = numpy.array(self.scan.voxel_from_world(point))
            to_border = numpy.minimum(ijk, self.size[::-1] - 1 - ijk) * self.scan.spacing_mm
            room, slack = min(room, float(to_border.min())), _SLACK
        return min(1.0, slack * max(room - radius, 0.0) / max(length, 1e-6))

    def swelling(self) -> dict[str, Any] | None:
        at = self.voxel(is_wall=False)
        if at is None:
            return None
        return {
            "kind": "swelling",
            "point_mm": self.point(at).tolist(),
            "by_mm": self.length(self.motions.swelling_mm),
            "radius_mm": self.length(self.motions.swelling_radius_mm),
        }

    def wave(self) -> dict[str, Any]:
        length = self.length(self.motions.wave_length_mm)
        return {
            "kind": "wave",
            "by_mm": (self.length(self.motions.wave_mm) * self.direction()).tolist(),
            "vector_per_mm": (2 * numpy.pi / length * self.direction()).tolist(),
            "phase": self.length((0.0, 2 * numpy.pi)),
        }

    def breath(self) -> dict[str, Any]:
        """The diaphragm goes down, or up, and the belly forwards, or back."""
        corners = numpy.array(
            [
                self.scan.world_from_voxel(numpy.where(ends, self.size[::-1] - 1, 0).astype(float))
                for ends in numpy.ndindex(2, 2, 2)
            ]
        )
        low, high = corners.min(0), corners.max(0)
        extent = high - low
        middle = low + extent * (0.5, 1.0, self.rng.uniform(0.35, 0.65))
        length = self.length(self.motions.breath_mm) * (1 if self.rng.random() < 0.5 else -1)
        above, below = (float(a) for a in extent[2] * self.rng.uniform(0.35, 0.65, 2))
        return {
            "kind": "breath",
            "point_mm": middle.tolist(),
            "by_mm": [0.0, -0.4 * length, -length],
            "above_mm": max(above, 1.0),
            "below_mm": max(below, 1.0),
            "depth_mm": max(float(extent[1]), 1.0),
        }

    def slide(self) -> dict[str, Any] | None:
        for _ in range(_TRIES):
            at = self.voxel(is_wall=True)
            if at is None:
                return None
            normal = self.normal(at)
            if normal is None:
                continue
            radius = self.length(self.motions.slide_tool_mm)
            start = self.point(at) + (radius + max(self.scan.spacing_mm)) * normal
            # Mostly along the wall, and into it.
            way = self.direction()
            way = way - (way @ normal) * normal
            way = way / max(float(numpy.linalg.norm(way)), 1e-6) - 0.6 * normal
            way *= self.length(self.motions.slide_mm) / numpy.linalg.norm(way)
            if not (self.is_inside(start) and self.is_inside(start + way)):
                continue
            return {
                "kind": "slide",
                "point_mm": start.tolist(),
                "by_mm": way.tolist(),
                "radius_mm": radius,
            }
        return None
