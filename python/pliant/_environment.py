# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Environments of instruments on their ways to the ends of branches, one or many in an arena.

A kind of instrument is a subclass of Ways; ArenaEnv and ArenaVectorEnv are the same for all.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Sequence
from typing import Any, Concatenate, Generic, ParamSpec, TypeVar

import gymnasium
import numpy
import numpy.typing
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from pliant._core import CatheterArena, EndoscopeArena
from pliant._error import Error
from pliant._lumen_tree import LumenEnd

Array = numpy.typing.NDArray[Any]
Observation = dict[str, Array]
Reward = Callable[[dict[str, Any], dict[str, Any], Array], float]
_P = ParamSpec("_P")
_Arena = TypeVar("_Arena", bound=EndoscopeArena | CatheterArena)

_AHEAD_MM = 8  # of the guide's next point
_WINDOW = 12  # points of the path around the last nearest one that are looked at
_PER_STEP = 0.02  # reward for a step, for a newton, and for success
_PER_NEWTON = 1.0
_FOR_SUCCESS = 20.0
_PICTURES = ("rgb", "depth", "normals", "flow", "fluoro")  # have their bounds already
UNIT, MOST_N = 1.0 + 1e-6, 100.0  # bounds of directions and of forces [N] in observations
_FOR_LOSS = 10.0  # penalty for a force above max_force_n, and for a tip that is lost


def item_of(values: dict[str, Array], n: int) -> dict[str, Any]:
    """Those of one instrument, as Python's numbers or arrays."""
    return {k: v[n].copy() if v.ndim > 1 else v[n].item() for k, v in values.items()}


def symmetric_box(bounds: Sequence[float]) -> gymnasium.spaces.Box:
    """Numbers from -bound to bound."""
    high = numpy.array(bounds, numpy.float32)
    return gymnasium.spaces.Box(-high, high, dtype=numpy.float32)


class Ways(Generic[_Arena]):
    """Several instruments on their ways: all that single and vector environments share."""

    observations: tuple[str, ...] = ()
    displacement: int  # column of arena.states: the largest one [mm]
    arena: _Arena

    def _set_out(
        self,
        ends: Sequence[LumenEnd],
        success_mm: Array,
        targets: Sequence[int],
        count: int,
        obs: Sequence[str],
        max_steps: int,
        max_force_n: float | None,
        reward: str | Reward,
        render_mode: str | None,
        render_size: tuple[int, int],
    ) -> None:
        self._ends = ends
        self.targets = [self._known(n) for n in targets]
        self.obs, self.max_steps = tuple(obs), max_steps
        self.max_force_n = numpy.inf if max_force_n is None else max_force_n
        self.reward = reward
        self.render_mode, self._render_size = render_mode, render_size
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
        self._success_mm = success_mm
        self.target = numpy.zeros(count, int)
        self.at = numpy.zeros(count, int)
        self.left_mm = numpy.zeros(count)
        self.is_success = numpy.zeros(count, bool)
        self.states: Array = self.arena.states

    # Of a kind of instrument:
    def _spaces(self) -> dict[str, gymnasium.Space[Any]]:
        """Of all observations."""
        raise NotImplementedError

    def action_space(self) -> gymnasium.spaces.Box:
        """Of one instrument."""
        raise NotImplementedError

    def reset(self, n: int, rng: numpy.random.Generator, options: dict[str, Any]) -> None:
        """Places an instrument at the beginning of a way."""
        raise NotImplementedError

    def _move(self, actions: Array, moves: Array | None) -> None:
        raise NotImplementedError

    def _force_n(self) -> Array:
        raise NotImplementedError

    def _is_lost(self) -> Array:
        """Whether a tip has left the lumen."""
        return numpy.zeros(len(self.target), bool)

    def _observed(self, name: str) -> Array:
        raise NotImplementedError

    def _own_infos(self) -> dict[str, Array]:
        """Infos that other kinds don't have."""
        raise NotImplementedError

    # Of all:
    def _check(self, obs: Sequence[str], reward: str | Reward, mode: AutoresetMode) -> None:
        """Raises pliant.Error for unknown names. mode: of a vector."""
        for name in obs:
            if name not in self.observations:
                known = ", ".join(self.observations)
                raise Error(f"obs: expected some of {known}, found {name}", field="obs")
        if not callable(reward) and reward != "path":
            raise Error(f"reward: expected path or a function, found {reward}", field="reward")
        if mode == AutoresetMode.SAME_STEP:
            raise Error("autoreset_mode: expected NEXT_STEP or DISABLED, found SAME_STEP")
        self.autoreset_mode = mode

    def space(self) -> gymnasium.spaces.Dict:
        """Of the chosen observations."""
        spaces = self._spaces()
        return gymnasium.spaces.Dict({name: spaces[name] for name in self.obs})

    @functools.cached_property
    def _boxes(self) -> dict[str, gymnasium.spaces.Box]:
        """Bounds of observations that are lengths, forces and directions."""
        spaces = self._spaces()
        return {
            name: space
            for name in self.obs
            if name not in _PICTURES and isinstance(space := spaces[name], gymnasium.spaces.Box)
        }

    def _tips(self) -> Array:
        """Positions, directions and upward directions (n, 9)."""
        return self.states[:, :9]

    def infos(self) -> dict[str, Array]:
        """Of all instruments, as vector environments give them."""
        return {
            "tip_lps_mm": self.states[:, :3].copy(),
            "wall_force_n": self._force_n().copy(),
            "displacement_max_mm": self.states[:, self.displacement].copy(),
            "left_mm": self.left_mm.copy(),
            "is_success": self.is_success.copy(),
            "target": self.target.copy(),
            **self._own_infos(),
        }

    def _known(self, target: int) -> int:
        if not 0 <= int(target) < len(self._ends):
            raise Error(
                f"target: expected 0 to {len(self._ends) - 1}, found {target}", field="target"
            )
        return int(target)

    @staticmethod
    def _check_options(options: dict[str, Any], known: set[str]) -> None:
        if unknown := set(options) - known:
            raise Error(f"options: expected {sorted(known)}, found {sorted(unknown)}")

    def _begin_at(self, n: int, target: int, tip_mm: Array) -> None:
        self.target[n] = target
        path = self._paths[target][: self._last[target] + 1]
        self.at[n] = int(numpy.argmin(numpy.linalg.norm(path - tip_mm, axis=1)))

    def look(self) -> None:
        """Makes observations of instruments that were placed or loaded."""
        self.arena.look()
        self._measure()

    def _measure(self) -> None:
        """Follows each tip along its path."""
        self.states = self.arena.states
        tips = self._tips()[:, :3]
        window = self.at[:, None] + numpy.arange(-_WINDOW, _WINDOW + 1)
        window = numpy.clip(window, 0, self._last[self.target][:, None])
        rows = self.target[:, None]
        far = numpy.linalg.norm(self._paths[rows, window] - tips[:, None], axis=2)
        nearest = far.argmin(axis=1)
        each = numpy.arange(len(nearest))
        self.at = window[each, nearest]
        aside = numpy.maximum(far[each, nearest] - self._radii[self.target, self.at], 0)
        self.left_mm = self._ahead[self.target, self.at] + aside
        self.to_target_mm = self._paths[self.target, self._last[self.target]] - tips
        to_target = numpy.linalg.norm(self.to_target_mm, axis=1)
        self.is_success = to_target <= self._success_mm[self.target]

    def step(self, actions: Array, moves: Array | None = None) -> tuple[Array, Array]:
        """Returns rewards, and whether the ways have ended: at the target, by force, or outside."""
        before, infos = self.left_mm.copy(), self.infos() if callable(self.reward) else {}
        self._move(actions, moves)
        self._measure()
        force = self._force_n()
        is_lost = (force > self.max_force_n) | self._is_lost()
        is_over = self.is_success | is_lost
        if callable(self.reward):
            after = self.infos()
            rewards = [
                self.reward(item_of(infos, n), item_of(after, n), actions[n])
                for n in range(len(before))
            ]
            return numpy.array(rewards, float), is_over
        reward = before - self.left_mm - _PER_STEP - _PER_NEWTON * force
        reward = reward - _FOR_LOSS * (is_lost & ~self.is_success)
        return reward + _FOR_SUCCESS * self.is_success, is_over

    def observation(self) -> Observation:
        """Copies, with the instruments as first axis."""
        observed = {name: self._observed(name) for name in self.obs}
        for name, box in self._boxes.items():
            observed[name] = numpy.clip(observed[name], box.low, box.high)
        return observed

    def _guide(self) -> Array:
        tips = self._tips()
        look, up = tips[:, 3:6], tips[:, 6:9]
        right = numpy.cross(look, up)
        index = numpy.minimum(self.at + _AHEAD_MM, self._last[self.target])
        next_mm = self._paths[self.target, index] - tips[:, :3]
        columns = []
        for v in (next_mm, self.to_target_mm):
            columns += [(v * right).sum(1), -(v * up).sum(1), (v * look).sum(1)]
        return numpy.stack([*columns, self.left_mm], axis=1).astype(numpy.float32)

    def info(self, n: int) -> dict[str, Any]:
        """Of one instrument."""
        return item_of(self.infos(), n)

    def picture(self, n: int) -> Array:
        """Of render_size, for people."""
        picture: Array = self.arena.picture(n, self._render_size)
        return picture


def _signed(init: Any, ways: Callable[..., Any], *left_out: str) -> Any:
    whole = inspect.signature(ways)
    self = inspect.Parameter("self", inspect.Parameter.POSITIONAL_ONLY)
    kept = [p for name, p in whole.parameters.items() if name not in left_out]
    init.__signature__ = whole.replace(parameters=[self, *kept])
    return init


def arguments_of(
    ways: Callable[_P, Any],
) -> Callable[[Callable[..., None]], Callable[Concatenate[Any, _P], None]]:
    """The signature of a constructor that hands its arguments to a subclass of Ways."""
    return lambda init: _signed(init, ways)


def arguments_of_one(
    ways: Callable[Concatenate[int, _P], Any],
) -> Callable[[Callable[..., None]], Callable[Concatenate[Any, _P], None]]:
    """Likewise, without the arguments of several environments."""
    return lambda init: _signed(init, ways, "num_envs", "autoreset_mode")


class ArenaEnv(gymnasium.Env[Observation, Array], Generic[_Arena]):
    """One instrument in an arena of its own. A subclass names its kind, and has a constructor."""

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 20}
    _kind: type[Any]  # of Ways[_Arena]

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        if "autoreset_mode" in settings:
            raise Error("autoreset_mode: expected with several environments")
        self._flights: Ways[_Arena] = self._kind(1, *arguments, **settings)
        ways = self._flights
        self.render_mode = ways.render_mode
        self.observation_space: Any = ways.space()
        self.action_space = ways.action_space()
        self._steps = 0

    @property
    def arena(self) -> _Arena:
        """The arena, with this instrument alone."""
        return self._flights.arena

    def _observation(self) -> Observation:
        return {name: value[0] for name, value in self._flights.observation().items()}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins a way."""
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
            "arena": f.arena.save_state(0),
            "target": int(f.target[0]),
            "at": int(f.at[0]),
            "steps": self._steps,
        }

    def load_state(self, state: dict[str, Any]) -> tuple[Observation, dict[str, Any]]:
        """Returns the observation and info, as reset does."""
        f = self._flights
        f.arena.load_state(0, state["arena"])
        f.target[0], f.at[0], self._steps = state["target"], state["at"], state["steps"]
        f.look()
        return self._observation(), f.info(0)


class ArenaVectorEnv(gymnasium.vector.VectorEnv[Observation, Array, Array], Generic[_Arena]):
    """Several instruments in one arena.

    One whose way has ended begins a new one in the next step (AutoresetMode.NEXT_STEP), or when
    reset(options={"reset_mask": …}) says so (DISABLED).
    """

    metadata: dict[str, Any] = {
        **ArenaEnv.metadata,
        "autoreset_mode": AutoresetMode.NEXT_STEP,
    }
    _kind: type[Any]  # of Ways[_Arena]

    def __init__(self, *arguments: Any, **settings: Any) -> None:
        given = inspect.signature(self._kind).bind(*arguments, **settings)
        if given.arguments.get("threads") is None:
            given.arguments["threads"] = 0
        self._flights: Ways[_Arena] = self._kind(*given.args, **given.kwargs)
        ways = self._flights
        self.metadata = {**self.metadata, "autoreset_mode": ways.autoreset_mode}
        self._is_autoreset = ways.autoreset_mode == AutoresetMode.NEXT_STEP
        self.render_mode = ways.render_mode
        self.num_envs = num_envs = len(ways.target)
        self.single_observation_space = ways.space()
        self.single_action_space = ways.action_space()
        self.observation_space: Any = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._steps = numpy.zeros(num_envs, int)
        self._is_over = numpy.zeros(num_envs, bool)
        self._rngs = [numpy.random.default_rng() for _ in range(num_envs)]

    @property
    def arena(self) -> _Arena:
        """The arena, with all instruments."""
        return self._flights.arena

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Begins ways. A seed s gives number n the random numbers of a single one with s + n.

        Options: as of a single one; "reset_mask": flags (n,) of those that begin anew, all without
        it.
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
        """Moves all for 1 / control_hz seconds."""
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
        """Pictures (h, w, 3) of all."""
        if self.render_mode != "rgb_array":
            return None
        return tuple(self._flights.picture(n) for n in range(self.num_envs))
