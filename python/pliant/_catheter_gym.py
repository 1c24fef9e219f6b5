# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Environments with catheters in vessels; public in pliant.gym."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy
from gymnasium.vector import AutoresetMode

from pliant._core import CatheterArena, Fluoroscopy, VesselWall, Volume
from pliant._environment import (
    MOST_N,
    UNIT,
    ArenaEnv,
    ArenaVectorEnv,
    Array,
    Reward,
    Ways,
    arguments_of,
    arguments_of_one,
    symmetric_box,
)
from pliant._error import Error
from pliant._vessels import Vessel, vessel_from

if TYPE_CHECKING:
    from typing import Unpack

    from pliant._settings import CatheterSettings

OBSERVATIONS = ("fluoro", "tracking2d", "target2d", "state", "guide")
INSERT_MM_S, ROTATE_RAD_S, BEND_RAD_S = 50.0, 3.14, 1.5  # bounds of an action

_SUCCESS_MM = 5.0  # distance from the target that counts as reached, in wide vessels more:
_SUCCESS_RADII = 1.2
_BEHIND_MM = 60.0  # length of a catheter beyond the longest path
_MARGIN = 1.15  # of the picture around the vessel
_FORCE, _DEPTH, _LEFT = 13, 14, 16  # of arena.states

# A guidewire, and steps as long as it and the wall allow.
_SETTINGS: dict[str, Any] = {
    "segment_mm": 4.0, "mass_g_mm": 0.01, "tip_mm": 24.0, "young_modulus_pa": 3e5,
    "density_g_mm3": 0.05, "box_mm": 6.0, "reach_mm": 1.0,
}  # fmt: skip
_STEPS: dict[str, dict[str, Any]] = {
    "deforming": {"time_step_s": 4e-3, "sub_steps": 3},
    "rigid": {"time_step_s": 8e-3, "sub_steps": 6, "wall_model": "rigid"},
}


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


class _Wires(Ways[CatheterArena]):
    """Several catheters on their ways."""

    observations = OBSERVATIONS
    displacement = 15

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
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
        **settings: Unpack[CatheterSettings],
    ) -> None:
        self._check(obs, reward, autoreset_mode)
        if wall not in _STEPS:
            raise Error(f"wall: expected one of deforming, rigid, found {wall}", field="wall")
        self.vessel = vessel_from(scene)
        self.size, self.steerable, self._points = size, steerable, points
        longest = max(end.length_mm for end in self.vessel.ends)
        chosen = {
            "length_mm": longest + _BEHIND_MM, **_SETTINGS, **_STEPS[wall], **self.vessel.settings,
            **settings,
        }  # fmt: skip
        if wall == "rigid":
            chosen["wall_model"] = "rigid"  # a file's model is that of the deforming wall
        bend = float(numpy.radians(tip_bend_deg))
        self.arena = CatheterArena(
            self.vessel.wall, self.vessel.scan, self.vessel.entry, count=num_envs, size=size,
            control_hz=control_hz,
            view=_view_of(self.vessel.wall, size, look) if view is None else view,
            has_pictures="fluoro" in obs, points=points, points_mm=points_mm,
            bend_rad=0.0 if steerable else bend, max_bend_rad=abs(bend),
            threads=1 if threads is None else threads, **chosen,
        )  # fmt: skip
        nodes = self.vessel.wall.mesh.nodes_mm
        self._far_mm = 2 * float(numpy.abs(nodes).max() + numpy.ptp(nodes, axis=0).sum() + longest)
        self._control_hz = control_hz
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

    def _spaces(self) -> dict[str, gymnasium.Space[Any]]:
        width, height = self.size
        box, far = gymnasium.spaces.Box, self._far_mm
        turned = numpy.pi + ROTATE_RAD_S * self.max_steps / self._control_hz
        state = [far] * 3 + [UNIT] * 6 + [far, turned, numpy.pi, MOST_N, MOST_N, far, far]
        return {
            "fluoro": box(0, 255, (height, width), numpy.uint8),
            "tracking2d": box(-far, far, (self._points, 2), numpy.float32),
            "target2d": box(-far, far, (2,), numpy.float32),
            "state": symmetric_box(state),
            "guide": symmetric_box([far] * 7),
        }

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

    def _own_infos(self) -> dict[str, Array]:
        hashes = [self.arena.hash(n) for n in range(len(self.target))]
        return {
            "depth_mm": self.states[:, _DEPTH].copy(),
            "has_left": self._is_lost(),
            "hash": numpy.array(hashes, numpy.uint64).view(numpy.int64),  # Gymnasium's
        }


class CatheterEnv(ArenaEnv[CatheterArena]):
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
        settings: Of the catheter, as of pliant.CatheterScene.
    """

    metadata: dict[str, Any] = {**ArenaEnv.metadata, "render_fps": 8}
    _kind = _Wires

    @arguments_of_one(_Wires)
    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)

    @property
    def vessel(self) -> Vessel:
        """The vessel, with its targets."""
        assert isinstance(self._flights, _Wires)
        return self._flights.vessel


class CatheterVectorEnv(ArenaVectorEnv[CatheterArena]):
    """Several catheters in one arena, each in a vessel of its own, for gymnasium.make_vec.

    Arguments are the number num_envs, those of CatheterEnv, and autoreset_mode. An action is an
    array (n, 1, 2), or (n, 1, 3) of steerable ones.
    """

    metadata: dict[str, Any] = {**ArenaVectorEnv.metadata, "render_fps": 8}
    _kind = _Wires

    @arguments_of(_Wires)
    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
