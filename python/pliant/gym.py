# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Gymnasium environments in the lumina of scans. Needs the package gymnasium.

Example:
    >>> import gymnasium
    >>> import pliant.gym  # registers; or gymnasium.make("pliant.gym:pliant/Endoscope-v0")
    >>> env = gymnasium.make("pliant/Endoscope-v0", obs=("depth", "guide"))
    >>> observation, info = env.reset(seed=1)
    >>> observation, reward, terminated, truncated, info = env.step(env.action_space.sample())

The tip of an endoscope starts in a wide lumen, and has to reach the end of a branch. Walls deform,
or are rigid. docs/gym.md has observations, actions, rewards and figures.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import os
from collections.abc import Callable, Sequence
from typing import Any, Concatenate, ParamSpec

import gymnasium
import numpy
import numpy.typing
from gymnasium.vector.utils import batch_space

from pliant._core import EndoscopeArena, Volume, find_endoscope, make_phantom, read_volume
from pliant._error import Error
from pliant._lumen_tree import LumenEnd, find_lumen_ends

Array = numpy.typing.NDArray[Any]
Observation = dict[str, Array]
Reward = Callable[[dict[str, Any], dict[str, Any], Array], float]
_P = ParamSpec("_P")

OBSERVATIONS = ("rgb", "depth", "normals", "flow", "state", "guide")
ADVANCE_MM_S = 20.0  # bounds of an action
TURN_RAD_S = 1.5
SUCCESS_MM = 3.0  # distance from the target that counts as reached

_AHEAD_MM = 8  # of the guide's next point
_WINDOW = 12  # points of the path around the last nearest one that are looked at
_PER_STEP = 0.02  # reward for a step, for a newton, and for success
_PER_NEWTON = 1.0
_FOR_SUCCESS = 20.0
_FOR_FORCE = 10.0  # penalty for one above max_force_n
_EYE, _LOOK, _UP, _FORCE = slice(0, 3), slice(3, 6), slice(6, 9), slice(9, 12)  # of arena.states
_DISPLACEMENT, _TOUCHING, _STOPPED = 12, 13, 14


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


class _Flights:
    """Several endoscopes on their ways: all that single and vector environments share."""

    default_threads = 1

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
        **settings: Any,
    ) -> None:
        for name in obs:
            if name not in OBSERVATIONS:
                raise Error(
                    f"obs: expected some of {', '.join(OBSERVATIONS)}, found {name}", field="obs"
                )
        if not callable(reward) and reward != "path":
            raise Error(f"reward: expected path or a function, found {reward}", field="reward")
        self.lumen = _lumen_from(scan)
        if targets is None:
            self.targets = self.lumen.targets(generation, split)
        else:
            self.targets = [self._known(n) for n in targets]
        self.obs, self.size, self.max_steps = tuple(obs), size, max_steps
        self.max_force_n = numpy.inf if max_force_n is None else max_force_n
        self.reward = reward
        self.render_mode, self._render_size = render_mode, render_size
        pictures = [name for name in ("rgb", "depth", "normals", "flow") if name in obs]
        self.arena = EndoscopeArena(
            self.lumen.scan, num_envs, size, control_hz, wall, iso_hu=self.lumen.iso_hu,
            polarity=self.lumen.polarity, pictures=pictures,
            threads=self.default_threads if threads is None else threads, **settings,
        )  # fmt: skip
        ends = self.lumen.ends
        longest = max(len(end.path_mm) for end in ends)
        self._paths = numpy.stack(
            [numpy.pad(e.path_mm, ((0, longest - len(e.path_mm)), (0, 0)), "edge") for e in ends]
        )
        self._radii = numpy.stack(
            [numpy.pad(e.radius_mm, (0, longest - len(e.path_mm)), "edge") for e in ends]
        )
        self._ahead = numpy.zeros(self._paths.shape[:2])  # length of the path that is left
        for n, e in enumerate(ends):
            steps = numpy.linalg.norm(numpy.diff(e.path_mm, axis=0), axis=1)
            self._ahead[n, : len(e.path_mm)] = numpy.append(numpy.cumsum(steps[::-1])[::-1], 0)
        self._last = numpy.array([len(e.path_mm) - 1 for e in ends])
        self.target = numpy.zeros(num_envs, int)
        self._at = numpy.zeros(num_envs, int)
        self.left_mm = numpy.zeros(num_envs)
        self.states = self.arena.states
        extent = numpy.array(self.lumen.scan.size) * numpy.array(self.lumen.scan.spacing_mm)
        self._far_mm = float(numpy.linalg.norm(extent))

    def _known(self, target: int) -> int:
        if not 0 <= int(target) < len(self.lumen.ends):
            raise Error(
                f"target: expected 0 to {len(self.lumen.ends) - 1}, found {target}", field="target"
            )
        return int(target)

    def space(self) -> gymnasium.spaces.Dict:
        width, height = self.size
        box = gymnasium.spaces.Box
        far, jump = self._far_mm, 4.0 * max(self.size)
        spaces: dict[str, gymnasium.Space[Any]] = {
            "rgb": box(0, 255, (height, width, 3), numpy.uint8),
            "depth": box(0, far, (height, width), numpy.float32),
            "normals": box(-1, 1, (height, width, 3), numpy.float32),
            "flow": box(-jump, jump, (height, width, 2), numpy.float32),
            "state": box(-numpy.inf, numpy.inf, (15,), numpy.float32),
            "guide": box(-numpy.inf, numpy.inf, (7,), numpy.float32),
        }
        return gymnasium.spaces.Dict({name: spaces[name] for name in self.obs})

    def reset(self, n: int, rng: numpy.random.Generator, options: dict[str, Any]) -> None:
        """Places an endoscope at the beginning of a way, or where the options say."""
        known = {"target", "eye_mm", "look", "up"}
        if unknown := set(options) - known:
            raise Error(f"options: expected {sorted(known)}, found {sorted(unknown)}")
        target = options.get("target")
        chosen = int(self.targets[rng.integers(len(self.targets))])
        offset_mm, turn, roll = rng.uniform(0, 6), rng.normal(0, 0.1, 3), rng.uniform(-0.5, 0.5)
        self.target[n] = chosen if target is None else self._known(target)
        path = self._paths[self.target[n]]
        first = int(offset_mm)
        eye = numpy.asarray(options.get("eye_mm", path[first]), float)
        ahead = path[min(first + _AHEAD_MM, len(path) - 1)] - path[first]
        look = ahead / max(float(numpy.linalg.norm(ahead)), 1e-9) + turn
        up = numpy.array(self.lumen.up) + roll * numpy.cross(look, self.lumen.up)
        self.arena.place(n, eye, options.get("look", look), options.get("up", up))
        distances = numpy.linalg.norm(path[: self._last[self.target[n]] + 1] - eye, axis=1)
        self._at[n] = int(numpy.argmin(distances))

    def look(self) -> None:
        self.arena.look()
        self._measure()

    def _measure(self) -> None:
        """Follows each endoscope along its path."""
        self.states = self.arena.states
        window = self._at[:, None] + numpy.arange(-_WINDOW, _WINDOW + 1)
        window = numpy.clip(window, 0, self._last[self.target][:, None])
        rows = self.target[:, None]
        far = numpy.linalg.norm(self._paths[rows, window] - self.states[:, None, _EYE], axis=2)
        nearest = far.argmin(axis=1)
        each = numpy.arange(len(nearest))
        self._at = window[each, nearest]
        aside = numpy.maximum(far[each, nearest] - self._radii[self.target, self._at], 0)
        self.left_mm = self._ahead[self.target, self._at] + aside
        self.to_target_mm = (
            self._paths[self.target, self._last[self.target]] - self.states[:, _EYE]
        )
        self.is_success = numpy.linalg.norm(self.to_target_mm, axis=1) <= SUCCESS_MM

    def step(self, actions: Array, moves: Array | None = None) -> tuple[Array, Array]:
        """Returns rewards, and whether the ways have ended, at the target or by force."""
        before = self.left_mm.copy()
        infos = [self.info(n) for n in range(len(before))] if callable(self.reward) else []
        self.arena.step(actions, moves)
        self._measure()
        force = numpy.linalg.norm(self.states[:, _FORCE], axis=1)
        is_forced = force > self.max_force_n
        is_over = self.is_success | is_forced
        if callable(self.reward):
            rewards = [
                self.reward(infos[n], self.info(n), actions[n]) for n in range(len(before))
            ]
            return numpy.array(rewards, float), is_over
        reward = before - self.left_mm - _PER_STEP - _PER_NEWTON * force
        reward = reward - _FOR_FORCE * (is_forced & ~self.is_success)
        return reward + _FOR_SUCCESS * self.is_success, is_over

    def observation(self) -> Observation:
        """Copies, with the endoscopes as first axis."""
        found: Observation = {}
        for name in self.obs:
            if name == "rgb":
                found[name] = self.arena.colour.copy()
            elif name == "depth":
                found[name] = numpy.minimum(self.arena.depth_mm, numpy.float32(self._far_mm))
            elif name == "normals":
                found[name] = numpy.clip(self.arena.normals, -1, 1)
            elif name == "flow":
                jump = numpy.float32(4 * max(self.size))
                found[name] = numpy.clip(self.arena.flow, -jump, jump)
            elif name == "state":
                found[name] = self.states[:, :15].astype(numpy.float32)
            else:
                found[name] = self._guide()
        return found

    def _guide(self) -> Array:
        look, up = self.states[:, _LOOK], self.states[:, _UP]
        right = numpy.cross(look, up)
        index = numpy.minimum(self._at + _AHEAD_MM, self._last[self.target])
        next_mm = self._paths[self.target, index] - self.states[:, _EYE]
        columns = []
        for v in (next_mm, self.to_target_mm):
            columns += [(v * right).sum(1), -(v * up).sum(1), (v * look).sum(1)]
        return numpy.stack([*columns, self.left_mm], axis=1).astype(numpy.float32)

    def picture(self, n: int) -> Array:
        return self.arena.picture(n, self._render_size)

    def info(self, n: int) -> dict[str, Any]:
        s = self.states[n]
        return {
            "tip_lps_mm": s[_EYE].copy(),
            "wall_force_n": float(numpy.linalg.norm(s[_FORCE])),
            "displacement_max_mm": float(s[_DISPLACEMENT]),
            "left_mm": float(self.left_mm[n]),
            "is_success": bool(self.is_success[n]),
            "is_touching": bool(s[_TOUCHING]),
            "target": int(self.target[n]),
        }

    def infos(self) -> dict[str, Array]:
        """Of all endoscopes, as vector environments give them."""
        s = self.states
        return {
            "tip_lps_mm": s[:, _EYE].copy(),
            "wall_force_n": numpy.linalg.norm(s[:, _FORCE], axis=1),
            "displacement_max_mm": s[:, _DISPLACEMENT].copy(),
            "left_mm": self.left_mm.copy(),
            "is_success": self.is_success.copy(),
            "is_touching": s[:, _TOUCHING] > 0,
            "target": self.target.copy(),
        }


class _ManyFlights(_Flights):
    default_threads = 0


def _signed(init: Any, flights: Callable[..., Any], left_out: str = "") -> Any:
    whole = inspect.signature(flights)
    self = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)
    kept = [p for name, p in whole.parameters.items() if name != left_out]
    init.__signature__ = whole.replace(parameters=[self, *kept])
    return init


def _arguments_of(
    flights: Callable[_P, Any],
) -> Callable[[Callable[..., None]], Callable[Concatenate[Any, _P], None]]:
    """The signature of a constructor that hands its arguments to _Flights."""
    return lambda init: _signed(init, flights)


def _arguments_of_one(
    flights: Callable[Concatenate[int, _P], Any],
) -> Callable[[Callable[..., None]], Callable[Concatenate[Any, _P], None]]:
    """Likewise, without the number of environments."""
    return lambda init: _signed(init, flights, "num_envs")


def _action_space() -> gymnasium.spaces.Box:
    bound = numpy.array([ADVANCE_MM_S, TURN_RAD_S, TURN_RAD_S, TURN_RAD_S], numpy.float32)
    return gymnasium.spaces.Box(-bound, bound, dtype=numpy.float32)


class EndoscopeEnv(gymnasium.Env[Observation, Array]):
    """An endoscope that is to reach the end of a lumen's branch.

    An action is (advance mm/s, roll, pitch, yaw rad/s). Observations are a dictionary of the names
    in `obs`. It ends when the tip is within 3 mm of the target, and is truncated after max_steps.

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

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20}

    @_arguments_of_one(_Flights)  # type: ignore[arg-type]  # num_envs has a name
    def __init__(self, *arguments: Any, **settings: Any) -> None:
        self._flights = _Flights(1, *arguments, **settings)
        self.render_mode = self._flights.render_mode
        self.observation_space: Any = self._flights.space()
        self.action_space = _action_space()
        self._steps = 0

    @property
    def arena(self) -> EndoscopeArena:
        """The arena, with this endoscope alone."""
        return self._flights.arena

    @property
    def lumen(self) -> Lumen:
        """The scan, with its targets."""
        return self._flights.lumen

    def _observation(self) -> Observation:
        return {name: value[0] for name, value in self._flights.observation().items()}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins a way. Options: "target", a number; "eye_mm", "look", "up", LPS."""
        super().reset(seed=seed)
        self._flights.reset(0, self.np_random, options or {})
        self._flights.look()
        self._steps = 0
        return self._observation(), self._flights.info(0)

    def step(self, action: Array) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Moves for 1 / control_hz seconds."""
        rewards, ends = self._flights.step(numpy.asarray(action, float)[None])
        self._steps += 1
        is_truncated = self._steps >= self._flights.max_steps
        info = self._flights.info(0)
        return self._observation(), float(rewards[0]), bool(ends[0]), is_truncated, info

    def render(self) -> Any:
        """A picture (h, w, 3) of render_size."""
        if self.render_mode != "rgb_array":
            return None
        return self._flights.picture(0)

    def save_state(self) -> dict[str, Any]:
        """All that decides about the future, but for the random numbers of the next reset."""
        f = self._flights
        return {
            "endoscope": self.arena.save_state(0),
            "target": int(f.target[0]),
            "at": int(f._at[0]),
            "steps": self._steps,
        }

    def load_state(self, state: dict[str, Any]) -> tuple[Observation, dict[str, Any]]:
        """Returns the observation and info, as reset does."""
        f = self._flights
        self.arena.load_state(0, state["endoscope"])
        f.target[0], f._at[0], self._steps = state["target"], state["at"], state["steps"]
        f.look()
        return self._observation(), f.info(0)


class EndoscopeVectorEnv(gymnasium.vector.VectorEnv[Observation, Array, Array]):
    """Several endoscopes in one arena, for gymnasium.make_vec.

    Arguments are the number num_envs, those of EndoscopeEnv, and autoreset_mode.

    An endoscope whose way has ended begins a new one in the next step
    (AutoresetMode.NEXT_STEP), or when reset(options={"reset_mask": …}) says so (DISABLED).
    """

    metadata: dict[str, Any] = {
        **EndoscopeEnv.metadata,
        "autoreset_mode": gymnasium.vector.AutoresetMode.NEXT_STEP,
    }

    @_arguments_of(_ManyFlights)
    def __init__(
        self,
        *arguments: Any,
        autoreset_mode: gymnasium.vector.AutoresetMode = gymnasium.vector.AutoresetMode.NEXT_STEP,
        **settings: Any,
    ) -> None:
        if autoreset_mode == gymnasium.vector.AutoresetMode.SAME_STEP:
            raise Error("autoreset_mode: expected NEXT_STEP or DISABLED, found SAME_STEP")
        self.metadata = {**self.metadata, "autoreset_mode": autoreset_mode}
        self._is_autoreset = autoreset_mode == gymnasium.vector.AutoresetMode.NEXT_STEP
        self._flights = _ManyFlights(*arguments, **settings)
        self.render_mode = self._flights.render_mode
        self.num_envs = num_envs = len(self._flights.target)
        self.single_observation_space = self._flights.space()
        self.single_action_space = _action_space()
        self.observation_space: Any = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._steps = numpy.zeros(num_envs, int)
        self._is_over = numpy.zeros(num_envs, bool)
        self._rngs = [numpy.random.default_rng() for _ in range(num_envs)]

    @property
    def arena(self) -> EndoscopeArena:
        """The endoscopes."""
        return self._flights.arena

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins ways. A seed s gives endoscope n the random numbers of an EndoscopeEnv with s + n.

        Options: as EndoscopeEnv; "reset_mask": flags (n,) of the endoscopes that begin anew, all
        without it.
        """
        options = dict(options or {})
        mask = numpy.asarray(options.pop("reset_mask", numpy.ones(self.num_envs, bool)), bool)
        if seed is not None:
            seeds = [seed + n for n in range(self.num_envs)] if isinstance(seed, int) else seed
            for n, s in enumerate(seeds):
                if s is not None:
                    self._rngs[n] = gymnasium.utils.seeding.np_random(s)[0]
        for n in numpy.flatnonzero(mask).tolist():
            self._flights.reset(n, self._rngs[n], options)
        self._flights.look()
        self._steps[mask] = 0
        self._is_over[mask] = False
        return self._flights.observation(), self._flights.infos()

    def step(self, actions: Array) -> tuple[Observation, Array, Array, Array, dict[str, Any]]:
        """Moves all endoscopes for 1 / control_hz seconds."""
        starts = self._is_over & self._is_autoreset
        for n in numpy.flatnonzero(starts).tolist():
            self._flights.reset(n, self._rngs[n], {})
        rewards, ends = self._flights.step(numpy.asarray(actions, float), ~starts)
        rewards = numpy.where(starts, 0.0, rewards)
        self._steps = numpy.where(starts, 0, self._steps + 1)
        terminated = ends & ~starts
        truncated = (self._steps >= self._flights.max_steps) & ~starts
        self._is_over = terminated | truncated
        observation = self._flights.observation()
        return observation, rewards, terminated, truncated, self._flights.infos()

    def render(self) -> Any:
        """Pictures (h, w, 3) of all endoscopes."""
        if self.render_mode != "rgb_array":
            return None
        return tuple(self._flights.picture(n) for n in range(self.num_envs))


def register() -> None:
    """Registers the environments with Gymnasium, once; importing this module does."""
    if "pliant/Endoscope-v0" not in gymnasium.registry:
        gymnasium.register(
            id="pliant/Endoscope-v0",
            entry_point="pliant.gym:EndoscopeEnv",
            vector_entry_point="pliant.gym:EndoscopeVectorEnv",
        )


register()
