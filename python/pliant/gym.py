# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Gymnasium environments in the lumina of scans. Needs the package gymnasium.

Example:
    >>> import gymnasium
    >>> import pliant.gym  # registers; or gymnasium.make("pliant.gym:pliant/Endoscope-v0")
    >>> env = gymnasium.make("pliant/Endoscope-v0", obs=("depth", "guide"))
    >>> observation, info = env.reset(seed=1)
    >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

The tip of an endoscope starts in a wide lumen, and has to reach the end of a branch; a catheter
(pliant/Catheter-v0) starts in a guide at an open end of a vessel. Walls deform, or are rigid.
docs/howto/gym.md has observations, actions, rewards and figures.
"""

from __future__ import annotations

import dataclasses
import functools
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy
from gymnasium.vector import AutoresetMode

from pliant._catheter_gym import CatheterEnv, CatheterVectorEnv
from pliant._core import EndoscopeArena, Volume, find_endoscope, make_phantom, read_volume
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
from pliant._lumen_tree import LumenEnd, find_lumen_ends
from pliant._vessels import Vessel, find_vessel

if TYPE_CHECKING:
    from typing import Unpack

    from pliant._settings import EndoscopeSettings

OBSERVATIONS = ("rgb", "depth", "normals", "flow", "state", "guide")
ADVANCE_MM_S = 20.0  # bounds of an action
TURN_RAD_S = 1.5
SUCCESS_MM = 3.0  # distance from the target that counts as reached

_AHEAD_MM = 8  # that flights look ahead at first
_FORCE, _TOUCHING = slice(9, 12), 13  # of arena.states


@dataclasses.dataclass(frozen=True)
class Lumen:
    """A scan with a start and targets.

    Attributes:
        start_mm, look, up: Where flights begin, LPS.
        ends: The ends of the lumen's branches.
    """

    scan: Volume
    start_mm: tuple[float, float, float]
    look: tuple[float, float, float]
    up: tuple[float, float, float]
    ends: tuple[LumenEnd, ...]
    iso_hu: float = -500.0
    polarity: str = "rising"

    def targets(self, generation: int | None = None, split: str = "all") -> list[int]:
        """Numbers of ends.

        Args:
            generation: Of the branch; None: all. A trachea has 0.
            split: "train", "test" (every third end of each generation) or "all".

        Raises:
            pliant.Error: There are none.
        """
        if split not in ("train", "test", "all"):
            raise Error(f"split: expected train, test or all, found {split}", field="split")
        chosen, seen = [], dict[int, int]()
        for n, end in enumerate(self.ends):
            seen[end.generation] = seen.get(end.generation, 0) + 1
            is_test = seen[end.generation] % 3 == 0
            if generation is not None and end.generation != generation:
                continue
            if split == "all" or is_test == (split == "test"):
                chosen.append(n)
        if not chosen:
            found = sorted({end.generation for end in self.ends})
            raise Error(
                f"generation: expected one with {split} targets, found {generation}; the lumen's "
                f"ends have {found}",
                field="generation",
            )
        return chosen


def find_lumen(
    scan: Volume,
    start_mm: Sequence[float] | None = None,
    iso_hu: float = -500.0,
    polarity: str = "rising",
    threads: int = 0,
) -> Lumen:
    """Finds where flights in a scan can begin and end. Takes seconds.

    Args:
        start_mm: In a wide lumen, LPS; None: found.

    Raises:
        pliant.Error: There is no lumen, or the start is not in one.
    """
    view = find_endoscope(scan, iso_hu, polarity, threads)
    if view is None:
        raise Error(f"scan: expected a lumen at {iso_hu} HU, found none", field="scan")
    eye = view.eye_mm if start_mm is None else (start_mm[0], start_mm[1], start_mm[2])
    ends = find_lumen_ends(scan, eye, iso_hu, polarity, threads=threads)
    if not ends:
        raise Error("scan: expected a lumen with branches, found none", field="scan")
    return Lumen(scan, eye, view.look, view.up, tuple(ends), iso_hu, polarity)


@functools.lru_cache(maxsize=4)
def _lumen_of_phantom(name: str, size: int) -> Lumen:
    return find_lumen(make_phantom(name, (size, size, size)))


def _lumen_from(scan: str | os.PathLike[str] | Volume | Lumen) -> Lumen:
    if isinstance(scan, Lumen):
        return scan
    if isinstance(scan, Volume):
        return find_lumen(scan)
    if isinstance(scan, str) and scan == "airway":
        return _lumen_of_phantom(scan, 128)
    return find_lumen(read_volume(scan))


class _Flights(Ways[EndoscopeArena]):
    """Several endoscopes on their ways."""

    observations = OBSERVATIONS
    displacement = 12

    def __init__(
        self,
        num_envs: int = 1,
        scan: str | os.PathLike[str] | Volume | Lumen = "airway",
        obs: Sequence[str] = ("depth", "state", "guide"),
        size: tuple[int, int] = (64, 64),
        wall: str = "deforming",
        control_hz: float = 20.0,
        max_steps: int = 600,
        generation: int | None = None,
        split: str = "all",
        targets: Sequence[int] | None = None,
        max_force_n: float | None = None,
        reward: str | Reward = "path",
        render_mode: str | None = None,
        render_size: tuple[int, int] = (256, 256),
        threads: int | None = None,
        autoreset_mode: AutoresetMode = AutoresetMode.NEXT_STEP,
        **settings: Unpack[EndoscopeSettings],
    ) -> None:
        self._check(obs, reward, autoreset_mode)
        self.lumen = _lumen_from(scan)
        if targets is None:
            targets = self.lumen.targets(generation, split)
        pictures = [name for name in ("rgb", "depth", "normals", "flow") if name in obs]
        self.arena = EndoscopeArena(
            self.lumen.scan, num_envs, size, control_hz, wall, iso_hu=self.lumen.iso_hu,
            polarity=self.lumen.polarity, pictures=pictures,
            threads=1 if threads is None else threads, **settings,
        )  # fmt: skip
        success_mm = numpy.full(len(self.lumen.ends), SUCCESS_MM)
        self._set_out(
            self.lumen.ends, success_mm, targets, num_envs, obs, max_steps, max_force_n, reward,
            render_mode, render_size,
        )  # fmt: skip
        self.size = size
        extent = numpy.array(self.lumen.scan.size) * numpy.array(self.lumen.scan.spacing_mm)
        self._far_mm = float(numpy.linalg.norm(extent))

    def action_space(self) -> gymnasium.spaces.Box:
        bound = numpy.array([ADVANCE_MM_S, TURN_RAD_S, TURN_RAD_S, TURN_RAD_S], numpy.float32)
        return gymnasium.spaces.Box(-bound, bound, dtype=numpy.float32)

    def _spaces(self) -> dict[str, gymnasium.Space[Any]]:
        width, height = self.size
        box = gymnasium.spaces.Box
        far, jump = self._far_mm, 4.0 * max(self.size)
        wide = float(numpy.abs(self.lumen.scan.origin_mm).max() + 2 * far + self._ahead.max())
        state = [wide] * 3 + [UNIT] * 6 + [MOST_N] * 3 + [far, 1.0, 1.0]
        return {
            "rgb": box(0, 255, (height, width, 3), numpy.uint8),
            "depth": box(0, far, (height, width), numpy.float32),
            "normals": box(-1, 1, (height, width, 3), numpy.float32),
            "flow": box(-jump, jump, (height, width, 2), numpy.float32),
            "state": symmetric_box(state),
            "guide": symmetric_box([wide] * 7),
        }

    def reset(self, n: int, rng: numpy.random.Generator, options: dict[str, Any]) -> None:
        """Places an endoscope at the beginning of a way, or where the options say."""
        self._check_options(options, {"target", "eye_mm", "look", "up"})
        target = options.get("target")
        chosen = int(self.targets[rng.integers(len(self.targets))])
        offset_mm, turn, roll = rng.uniform(0, 6), rng.normal(0, 0.1, 3), rng.uniform(-0.5, 0.5)
        chosen = chosen if target is None else self._known(target)
        path = self._paths[chosen]
        first = int(offset_mm)
        eye = numpy.asarray(options.get("eye_mm", path[first]), float)
        ahead = path[min(first + _AHEAD_MM, len(path) - 1)] - path[first]
        look = ahead / max(float(numpy.linalg.norm(ahead)), 1e-9) + turn
        up = numpy.array(self.lumen.up) + roll * numpy.cross(look, self.lumen.up)
        self.target[n] = chosen
        self.arena.place(n, eye, options.get("look", look), options.get("up", up))
        self._begin_at(n, chosen, eye)

    def _move(self, actions: Array, moves: Array | None) -> None:
        self.arena.step(actions, moves)

    def _force_n(self) -> Array:
        force: Array = numpy.linalg.norm(self.states[:, _FORCE], axis=1)
        return force

    def _observed(self, name: str) -> Array:
        if name == "rgb":
            return self.arena.colour.copy()
        if name == "depth":
            return numpy.minimum(self.arena.depth_mm, numpy.float32(self._far_mm))
        if name == "normals":
            return numpy.clip(self.arena.normals, -1, 1)
        if name == "flow":
            jump = numpy.float32(4 * max(self.size))
            return numpy.clip(self.arena.flow, -jump, jump)
        if name == "state":
            return self.states[:, :15].astype(numpy.float32)
        return self._guide()

    def _own_infos(self) -> dict[str, Array]:
        return {"is_touching": self.states[:, _TOUCHING] > 0}


class EndoscopeEnv(ArenaEnv[EndoscopeArena]):
    """An endoscope that is to reach the end of a lumen's branch.

    An action is (advance mm/s, roll, pitch, yaw rad/s). Observations are a dictionary of the names
    in `obs`. It ends when the tip is within 3 mm of the target, and is truncated after max_steps.

    Options of reset: "target", a number; "eye_mm", "look", "up", LPS.

    Args:
        scan: "airway" (the phantom), a file, a Volume, or a Lumen (find_lumen).
        obs: Of "rgb", "depth", "normals", "flow", "state", "guide".
        size: Width and height of pictures.
        wall: "deforming" or "rigid".
        generation: Of the targets' branches; None: all. A trachea has 0.
        split: "train", "test" or "all" targets.
        targets: Numbers of ends instead of these two.
        max_force_n: A larger force of the wall ends the way, with a penalty; None: no limit.
        reward: "path": progress along the path [mm], less force and time; or a function of the
            infos before and after a step and the action.
        render_mode: "rgb_array" or None; render_size: width and height of these pictures.
        threads: 0: one for each core; None: 1, and 0 of a vector.
        settings: Further arguments of pliant.EndoscopeArena.
    """

    _kind = _Flights

    @arguments_of_one(_Flights)
    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)

    @property
    def lumen(self) -> Lumen:
        """The scan, with its targets."""
        assert isinstance(self._flights, _Flights)
        return self._flights.lumen


class EndoscopeVectorEnv(ArenaVectorEnv[EndoscopeArena]):
    """Several endoscopes in one arena, for gymnasium.make_vec.

    Arguments are the number num_envs, those of EndoscopeEnv, and autoreset_mode.

    An endoscope whose way has ended begins a new one in the next step
    (AutoresetMode.NEXT_STEP), or when reset(options={"reset_mask": …}) says so (DISABLED).
    """

    _kind = _Flights

    @arguments_of(_Flights)
    def __init__(self, *arguments: Any, **settings: Any) -> None:
        super().__init__(*arguments, **settings)


def register() -> None:
    """Registers the environments with Gymnasium, once; importing this module does."""
    for name in ("Endoscope", "Catheter"):
        if f"pliant/{name}-v0" not in gymnasium.registry:
            gymnasium.register(
                id=f"pliant/{name}-v0",
                entry_point=f"pliant.gym:{name}Env",
                vector_entry_point=f"pliant.gym:{name}VectorEnv",
            )


register()

__all__ = [
    "ADVANCE_MM_S",
    "OBSERVATIONS",
    "SUCCESS_MM",
    "TURN_RAD_S",
    "CatheterEnv",
    "CatheterVectorEnv",
    "EndoscopeEnv",
    "EndoscopeVectorEnv",
    "Lumen",
    "LumenEnd",
    "Reward",
    "Vessel",
    "find_lumen",
    "find_vessel",
    "register",
]
