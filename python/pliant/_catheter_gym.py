# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Environments with catheters in vessels; public in pliant.gym."""

from __future__ import annotations

import dataclasses
import functools
import os
from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy

from pliant._core import (
    CatheterArena,
    Fluoroscopy,
    VesselEnd,
    VesselWall,
    Volume,
    lumen_of_region,
    make_vessel,
    phantom_centreline,
    read_surface,
    scan_of_vessel,
    swept_tube,
    wall_around_centreline,
    wall_around_surface,
)
from pliant._environment import (
    ArenaEnv,
    ArenaVectorEnv,
    Array,
    Reward,
    Ways,
    arguments_of,
    arguments_of_one,
)
from pliant._error import Error
from pliant._lumen_tree import LumenEnd, ends_of_paths, path_to

Vector = tuple[float, float, float]

OBSERVATIONS = ("fluoro", "tracking2d", "target2d", "state", "guide")
INSERT_MM_S, ROTATE_RAD_S, BEND_RAD_S = 50.0, 3.14, 1.5  # bounds of an action

_PHANTOMS = ("aorta", "bend", "arch")
_CONTRAST_HU = 200.0  # threshold of scan_of_vessel
_SUCCESS_MM = 5.0  # distance from the target that counts as reached, in wide vessels more:
_SUCCESS_RADII = 1.2
_BEHIND_MM = 60.0  # length of a catheter beyond the longest path
_MARGIN = 1.15  # of the picture around the vessel
_TIP, _AHEAD, _BENDS_TO = slice(0, 3), slice(3, 6), slice(6, 9)  # of arena.states
_FORCE, _DEPTH, _DISPLACEMENT, _LEFT = 13, 14, 15, 16

# A wall that is quick: one layer of cells. Its thickness includes the tissue around the vessel.
_WALL = {"thickness_mm": 2.5, "layers": 1, "cell_mm": 1.8}
_TUBE = {"thickness_mm": 1.5, "layers": 1}
# A guidewire, and steps as long as it and the wall allow.
_SETTINGS: dict[str, Any] = {
    "segment_mm": 4.0, "mass_g_mm": 0.01, "tip_mm": 24.0, "young_modulus_pa": 3e5,
    "density_g_mm3": 0.05, "box_mm": 6.0, "reach_mm": 1.0,
}  # fmt: skip
_STEPS: dict[str, dict[str, Any]] = {
    "deforming": {"time_step_s": 4e-3, "sub_steps": 3},
    "rigid": {"time_step_s": 8e-3, "sub_steps": 6, "wall_model": "rigid"},
}


@dataclasses.dataclass(frozen=True)
class Vessel:
    """A vessel with a guide and targets.

    Attributes:
        wall: Its wall.
        scan: Seen in the pictures.
        entry: Where the guide ends [mm, LPS], and its direction.
        ends: The ends of its branches.
        settings: Of its catheter, changes of the defaults (settings_of("catheter")).
    """

    wall: VesselWall
    scan: Volume
    entry: tuple[Vector, Vector]
    ends: tuple[LumenEnd, ...]
    settings: dict[str, Any] = dataclasses.field(default_factory=dict)


def _at_end(end: VesselEnd, radii: float) -> tuple[Vector, Vector]:
    centre, outward = numpy.array(end.centre_mm), numpy.array(end.outward)
    x, y, z = (centre - radii * end.radius_mm * outward).tolist()
    u, v, w = (-outward).tolist()
    return (x, y, z), (u, v, w)


def _nearest(ends: list[VesselEnd], point: Array) -> int:
    return int(numpy.argmin([numpy.linalg.norm(numpy.array(e.centre_mm) - point) for e in ends]))


def find_vessel(
    scene: str | os.PathLike[str] | VesselWall | Volume = "aorta",
    entry: int | None = None,
    ends: Sequence[VesselEnd] = (),
    seed_mm: Sequence[float] | None = None,
    window_hu: tuple[float, float] | None = None,
    max_ml: float = 500.0,
    threads: int = 0,
    **wall: Any,
) -> Vessel:
    """Makes a vessel, and finds the paths from its guide to its other ends. Takes seconds.

    Args:
        scene: "aorta", "bend" or "arch" (phantoms); a scene file (.toml, docs/howto/vessel.md); a
            file of the lumen's surface, open at its ends; a wall; or a scan with contrast agent.
        entry: Number of the open end with the guide, of wall.ends; None: the phantom's or the
            file's, else the widest.
        ends: Cuts that open a closed surface, or a lumen that ends within a scan.
        seed_mm, window_hu, max_ml: Of a scan: a point in the lumen (LPS), the lumen's lowest and
            highest value, and the size from which it counts as a leak.
        wall: settings_of("wall").

    Raises:
        pliant.Error: There is no vessel, or it has fewer than two open ends.
    """
    settings: dict[str, Any] = {}
    scan, at = None, entry
    place: tuple[Vector, Vector] | None = None
    if isinstance(scene, VesselWall):
        made = scene
    elif isinstance(scene, Volume):
        if seed_mm is None or window_hu is None:
            raise Error("seed_mm: expected a point and a window_hu beside a scan", field="seed_mm")
        lumen = lumen_of_region(
            scene, seed_mm, window_hu[0], window_hu[1], max_ml=max_ml, threads=threads
        )
        cuts = [*lumen.ends, *ends]
        made = wall_around_surface(lumen.surface, cuts, threads, **{**_TUBE, **wall})
        scan = scene
    elif scene in _PHANTOMS:
        branches = phantom_centreline(str(scene))
        if len(branches) == 1:
            made = swept_tube(branches[0], **{**_TUBE, **wall})
        else:
            made = wall_around_centreline(list(branches), threads, **{**_WALL, **wall})
        at = _nearest(made.ends, branches[0][0, :3]) if at is None else at
    elif os.fspath(scene).endswith(".toml"):
        from_file = make_vessel(scene, threads)
        made, scan, settings = from_file.wall, from_file.scan, dict(from_file.settings)
        x, y, z = settings.pop("place_mm")
        u, v, w = settings.pop("direction")
        place = ((x, y, z), (u, v, w)) if at is None else None
    else:
        made = wall_around_surface(read_surface(scene), ends, threads, **{**_TUBE, **wall})
    openings = list(made.ends)
    if len(openings) < 2:
        raise Error(
            f"scene: expected a vessel with two open ends, found {len(openings)}; ends cut it open",
            field="scene",
        )
    if at is None and place is None:
        at = int(numpy.argmax([end.radius_mm for end in openings]))
    if at is not None:
        if not 0 <= at < len(openings):
            raise Error(f"entry: expected 0 to {len(openings) - 1}, found {at}", field="entry")
        place = _at_end(openings[at], 0.5)
    assert place is not None
    if at is None:
        at = _nearest(openings, numpy.array(place[0]))
    contrast = scan_of_vessel(made, threads)
    paths = [
        path_to(
            contrast, place[0], _at_end(end, 1.0)[0], _CONTRAST_HU, "falling",
            end.radius_mm, threads,
        )
        for n, end in enumerate(openings)
        if n != at
    ]  # fmt: skip
    seen = contrast if scan is None else scan
    return Vessel(made, seen, place, tuple(ends_of_paths(paths)), settings)


@functools.lru_cache(maxsize=4)
def _phantom(name: str) -> Vessel:
    return find_vessel(name)


def _vessel_from(scene: str | os.PathLike[str] | VesselWall | Volume | Vessel) -> Vessel:
    if isinstance(scene, Vessel):
        return scene
    if isinstance(scene, str) and scene in _PHANTOMS:
        return _phantom(scene)
    return find_vessel(scene)


def _view_of(wall: VesselWall, size: tuple[int, int], look: Sequence[float]) -> Fluoroscopy:
    """The whole vessel, upright."""
    nodes = wall.mesh.nodes_mm
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    ahead = numpy.array(look, float) / max(float(numpy.linalg.norm(look)), 1e-9)
    up = numpy.array([0.0, 0, 1]) if abs(ahead[2]) < 0.9 else numpy.array([0.0, -1, 0])
    right = numpy.cross(ahead, up)
    right /= numpy.linalg.norm(right)
    across = nodes @ right
    along = nodes @ numpy.cross(right, ahead)
    aspect = size[0] / size[1]
    width = _MARGIN * max(numpy.ptp(across), aspect * numpy.ptp(along))
    middle = 0.5 * (low + high)
    return Fluoroscopy(
        centre_mm=tuple(middle.tolist()), look=tuple(ahead.tolist()), up=tuple(up.tolist()),
        width_mm=float(width), contrast=3.0, border_mm=float(width),
    )  # fmt: skip


class _Wires(Ways):
    """Several catheters on their ways."""

    observations = OBSERVATIONS

    def __init__(
        self,
        num_envs: int = 1,
        scene: str | os.PathLike[str] | VesselWall | Volume | Vessel = "aorta",
        obs: Sequence[str] = ("tracking2d", "target2d", "state"),
        size: tuple[int, int] = (64, 64),
        wall: str = "deforming",
        control_hz: float = 7.5,
        max_steps: int = 200,
        steerable: bool = False,
        tip_bend_deg: float = 60.0,
        points: int = 8,
        points_mm: float = 5.0,
        view: Fluoroscopy | None = None,
        look: Sequence[float] = (0.0, 1.0, 0.0),
        targets: Sequence[int] | None = None,
        max_force_n: float | None = None,
        reward: str | Reward = "path",
        render_mode: str | None = None,
        render_size: tuple[int, int] = (256, 256),
        threads: int | None = None,
        **settings: Any,
    ) -> None:
        self.check(obs, reward)
        if wall not in _STEPS:
            raise Error(f"wall: expected one of deforming, rigid, found {wall}", field="wall")
        self.vessel = _vessel_from(scene)
        self.size, self.steerable, self._points = size, steerable, points
        longest = max(end.length_mm for end in self.vessel.ends)
        chosen = {
            "length_mm": longest + _BEHIND_MM, **_SETTINGS, **_STEPS[wall], **self.vessel.settings,
            **settings,
        }  # fmt: skip
        if wall == "rigid":
            chosen["wall_model"] = "rigid"  # a file's model is that of the deforming wall
        bend = float(numpy.radians(tip_bend_deg))
        self.arena: CatheterArena = CatheterArena(
            self.vessel.wall, self.vessel.scan, self.vessel.entry, count=num_envs, size=size,
            control_hz=control_hz,
            view=_view_of(self.vessel.wall, size, look) if view is None else view,
            has_pictures="fluoro" in obs, points=points, points_mm=points_mm,
            bend_rad=0.0 if steerable else bend, max_bend_rad=abs(bend),
            threads=self.default_threads if threads is None else threads, **chosen,
        )  # fmt: skip
        ends = self.vessel.ends
        radii = numpy.array([float(end.radius_mm[-1]) for end in ends])
        self._set_out(
            ends, numpy.maximum(_SUCCESS_MM, _SUCCESS_RADII * radii),
            range(len(ends)) if targets is None else targets, num_envs, obs, max_steps,
            max_force_n, reward, render_mode, render_size,
        )  # fmt: skip
        projected = [self.arena.project(end.point_mm) for end in ends]
        self._targets2d = numpy.array(projected, numpy.float32)

    def action_space(self) -> gymnasium.spaces.Box:
        bounds = [INSERT_MM_S, ROTATE_RAD_S, BEND_RAD_S][: 3 if self.steerable else 2]
        bound = numpy.array([bounds], numpy.float32)
        return gymnasium.spaces.Box(-bound, bound, dtype=numpy.float32)

    def space(self) -> gymnasium.spaces.Dict:
        width, height = self.size
        box, any_number = gymnasium.spaces.Box, numpy.inf
        spaces: dict[str, gymnasium.Space[Any]] = {
            "fluoro": box(0, 255, (height, width), numpy.uint8),
            "tracking2d": box(-any_number, any_number, (self._points, 2), numpy.float32),
            "target2d": box(-any_number, any_number, (2,), numpy.float32),
            "state": box(-any_number, any_number, (16,), numpy.float32),
            "guide": box(-any_number, any_number, (7,), numpy.float32),
        }
        return gymnasium.spaces.Dict({name: spaces[name] for name in self.obs})

    def reset(self, n: int, rng: numpy.random.Generator, options: dict[str, Any]) -> None:
        """Withdraws a catheter, and rotates it."""
        self._check_options(options, {"target", "rotation_rad"})
        chosen = int(self.targets[rng.integers(len(self.targets))])
        rotation = rng.uniform(-numpy.pi, numpy.pi)
        target = options.get("target")
        chosen = chosen if target is None else self._known(target)
        self.arena.place(n, float(options.get("rotation_rad", rotation)))
        self._begin_at(n, chosen, numpy.array(self.vessel.entry[0]))

    def _move(self, actions: Array, moves: Array | None) -> None:
        count, numbers = len(self.target), 3 if self.steerable else 2
        if actions.shape not in ((count, 1, numbers), (count, numbers)):
            raise Error(
                f"actions: expected axes (1, {numbers}) for each, found {actions.shape[1:]}",
                field="actions",
            )
        whole = numpy.zeros((count, 3))
        whole[:, :numbers] = actions.reshape(count, numbers)
        self.arena.step(whole, moves)

    def _tips(self) -> Array:
        return self.states[:, :9]

    def _force_n(self) -> Array:
        return self.states[:, _FORCE]

    def _is_lost(self) -> Array:
        is_out: Array = self.states[:, _LEFT] > 0
        return is_out

    def _observed(self, name: str) -> Array:
        if name == "fluoro":
            return self.arena.fluoro.copy()
        if name == "tracking2d":
            return self.arena.points_mm.copy()
        if name == "target2d":
            return self._targets2d[self.target]
        if name == "state":
            return self.states[:, :16].astype(numpy.float32)
        return self._guide()

    def infos(self) -> dict[str, Array]:
        s = self.states
        hashes = [self.arena.hash(n) for n in range(len(s))]
        return {
            "tip_lps_mm": s[:, _TIP].copy(),
            "wall_force_n": s[:, _FORCE].copy(),
            "displacement_max_mm": s[:, _DISPLACEMENT].copy(),
            "left_mm": self.left_mm.copy(),
            "is_success": self.is_success.copy(),
            "depth_mm": s[:, _DEPTH].copy(),
            "has_left": self._is_lost(),
            "target": self.target.copy(),
            "hash": numpy.array(hashes, numpy.uint64),
        }


class _ManyWires(_Wires):
    default_threads = 0


class CatheterEnv(ArenaEnv):
    """A catheter that is to reach the end of a vessel's branch.

    An action is ((insertion mm/s, rotation rad/s),), as stEVE's with one device; of a steerable
    catheter also the bending of its tip, rad/s. Observations are a dictionary of the names in
    `obs`. It ends when the tip is near the target, or has left the vessel, and is truncated after
    max_steps.

    Options of reset: "target", a number; "rotation_rad", of the catheter at first.

    Args:
        scene: "aorta", "bend" or "arch" (phantoms), a file, a wall, or a Vessel (find_vessel).
        obs: Of "fluoro", "tracking2d", "target2d", "state", "guide".
        size: Width and height of pictures.
        wall: "deforming" or "rigid".
        steerable: Whether the tip bends on command, up to tip_bend_deg either way; else it is bent
            by so much, and rotation steers it.
        points: Tracked points from the tip on; points_mm: their distance along the catheter.
        view: The fluoroscopy; None: of the whole vessel, in the direction look.
        targets: Numbers of ends; None: all.
        max_force_n: A larger force on the wall ends the way, with a penalty; None: no limit.
        reward: "path": progress along the path [mm], less force and time; or a function of the
            infos before and after a step and the action.
        render_mode: "rgb_array" or None; render_size: width and height of these pictures.
        threads: 0: one for each core; None: 1, and 0 of a vector.
        settings: settings_of("catheter").
    """

    metadata: dict[str, Any] = {**ArenaEnv.metadata, "render_fps": 8}

    @arguments_of_one(_Wires)  # type: ignore[arg-type]  # num_envs has a name
    def __init__(self, *arguments: Any, **settings: Any) -> None:
        self._begin(_Wires(1, *arguments, **settings))

    @property
    def arena(self) -> CatheterArena:
        """The arena, with this catheter alone."""
        arena: CatheterArena = self._flights.arena
        return arena

    @property
    def vessel(self) -> Vessel:
        """The vessel, with its targets."""
        assert isinstance(self._flights, _Wires)
        return self._flights.vessel


class CatheterVectorEnv(ArenaVectorEnv):
    """Several catheters in one arena, each in a vessel of its own, for gymnasium.make_vec.

    Arguments are the number num_envs, those of CatheterEnv, and autoreset_mode. An action is an
    array (n, 1, 2), or (n, 1, 3) of steerable ones.
    """

    metadata: dict[str, Any] = {**ArenaVectorEnv.metadata, "render_fps": 8}

    @arguments_of(_ManyWires)
    def __init__(
        self,
        *arguments: Any,
        autoreset_mode: gymnasium.vector.AutoresetMode = gymnasium.vector.AutoresetMode.NEXT_STEP,
        **settings: Any,
    ) -> None:
        self._check_mode(autoreset_mode)
        self._begin(_ManyWires(*arguments, **settings), autoreset_mode)

    @property
    def arena(self) -> CatheterArena:
        """The catheters."""
        arena: CatheterArena = self._flights.arena
        return arena
