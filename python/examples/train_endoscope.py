# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A baseline: PPO steers an endoscope to the ends of the airway phantom's branches.

    pip install build/dist/pliant-*.whl gymnasium==1.4.0 stable-baselines3==2.9.2
    python train_endoscope.py --minutes 10 --out endoscope

It trains on targets below the fifth generation, and is tested on those in the fifth, which it has
never seen. It sees a coarse depth picture, and the guide: the path's next point, the target, and
the way that is left. Writes policy.zip, curve.csv, test.json, and flight.webp if Pillow is there.
"""

from __future__ import annotations

import argparse
import json
import pathlib
import time
from typing import Any

import gymnasium
import numpy
import stable_baselines3
import torch
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.vec_env import VecEnv

import pliant.gym

GUIDE_SCALE = numpy.array([10, 10, 10, 50, 50, 50, 100], numpy.float32)
DEPTH_MM = 60.0
FLIGHT: dict[str, Any] = {"max_steps": 400, "max_force_n": 0.2}
SIZE = (12, 12)


class EndoscopeVecEnv(VecEnv):
    """stable-baselines3's interface to an EndoscopeVectorEnv: numbers around −1…1 both ways."""

    def __init__(self, count: int, **arguments: Any) -> None:
        self.flights = pliant.gym.EndoscopeVectorEnv(
            count, obs=("depth", "guide"), size=SIZE,
            autoreset_mode=gymnasium.vector.AutoresetMode.DISABLED, **arguments,
        )  # fmt: skip
        self.scale = self.flights.single_action_space.high
        length = SIZE[0] * SIZE[1] + len(GUIDE_SCALE)
        super().__init__(
            count,
            gymnasium.spaces.Box(-10, 10, (length,), numpy.float32),
            gymnasium.spaces.Box(-1, 1, (4,), numpy.float32),
        )
        self.actions = numpy.zeros((count, 4), numpy.float32)
        self.returns = numpy.zeros(count)
        self.lengths = numpy.zeros(count, int)

    @staticmethod
    def features(observed: dict[str, Any]) -> Any:
        depth = numpy.minimum(observed["depth"], DEPTH_MM).reshape(len(observed["depth"]), -1)
        guide = observed["guide"] / GUIDE_SCALE
        return numpy.clip(numpy.concatenate([depth / DEPTH_MM, guide], axis=1), -10, 10)

    def reset(self) -> Any:
        seeds = [s for s in self._seeds]
        self._reset_seeds()
        observed, _ = self.flights.reset(seed=seeds)
        self.returns[:], self.lengths[:] = 0, 0
        return self.features(observed)

    def step_async(self, actions: Any) -> None:
        self.actions = actions

    def step_wait(self) -> Any:
        observed, rewards, terminated, truncated, info = self.flights.step(
            self.actions * self.scale
        )
        features = self.features(observed)
        rewards = rewards / 10
        done = terminated | truncated
        self.returns += rewards
        self.lengths += 1
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for n in numpy.flatnonzero(done):
            infos[n] = {
                "terminal_observation": features[n],
                "TimeLimit.truncated": bool(truncated[n] and not terminated[n]),
                "is_success": bool(info["is_success"][n]),
                "target": int(info["target"][n]),
                "episode": {"r": float(self.returns[n]), "l": int(self.lengths[n]), "t": 0.0},
            }
        if done.any():
            observed, _ = self.flights.reset(options={"reset_mask": done})
            features = self.features(observed)
            self.returns[done], self.lengths[done] = 0, 0
        return features, rewards.astype(numpy.float32), done, infos

    def close(self) -> None:
        self.flights.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        return [getattr(self.flights, attr_name, None)] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        raise NotImplementedError

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> Any:
        raise NotImplementedError

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        return [False] * self.num_envs


class Clock:
    def __init__(self, limit_minutes: float) -> None:
        self.limit_minutes = limit_minutes
        self.start = time.monotonic()

    def minutes(self) -> float:
        return (time.monotonic() - self.start) / 60

    def share_left(self) -> float:
        return 1 - self.minutes() / self.limit_minutes


class Curve(BaseCallback):
    """Writes the share of ways that succeed, and stops when the time is over."""

    def __init__(self, clock: Clock, path: pathlib.Path) -> None:
        super().__init__()
        self.clock = clock
        self.path = path
        self.rows = ["minutes,steps,ways,success,mean_reward"]
        self.last: list[tuple[bool, float]] = []

    def _on_step(self) -> bool:
        for info in self.locals["infos"]:
            if "episode" in info:
                self.last.append((info["is_success"], 10 * info["episode"]["r"]))
        return self.clock.share_left() > 0

    def _on_rollout_end(self) -> None:
        if not self.last:
            return
        success, reward = numpy.mean(numpy.array(self.last, float), axis=0)
        count, minutes = len(self.last), self.clock.minutes()
        row = f"{minutes:.2f},{self.num_timesteps},{count},{success:.3f},{reward:.1f}"
        self.rows.append(row)
        print(row, flush=True)
        self.path.write_text("\n".join(self.rows) + "\n")
        self.last = []


def evaluate(model: Any, lumen: Any, targets: list[int], ways: int, seed: int) -> dict[str, Any]:
    """Flies `ways` ways to each target, without exploration."""
    result: dict[str, Any] = {}
    for target in targets:
        env = EndoscopeVecEnv(ways, scan=lumen, targets=[target], **FLIGHT)
        env.seed(seed)
        features = env.reset()
        success, over = numpy.zeros(ways, bool), numpy.zeros(ways, bool)
        force = numpy.zeros(ways)
        for _ in range(400):
            actions, _ = model.predict(features, deterministic=True)
            features, _, done, infos = env.step(actions)
            now = numpy.linalg.norm(env.flights.arena.states[:, 9:12], axis=1)
            force = numpy.where(over, force, numpy.maximum(force, now))
            for n in numpy.flatnonzero(done & ~over):
                success[n] = infos[n]["is_success"]
            over |= done
            if over.all():
                break
        end = lumen.ends[target]
        result[str(target)] = {
            "generation": end.generation,
            "ways": ways,
            "reached": int(success.sum()),
            "median_of_largest_force_n": float(numpy.median(force)),
        }
    return result


def film(model: Any, lumen: Any, target: int, path: pathlib.Path) -> None:
    """A flight to a target as an animated picture."""
    try:
        from PIL import Image
    except ImportError:
        print("no film: Pillow is not installed")
        return
    env = EndoscopeVecEnv(1, scan=lumen, targets=[target], field_stop="round", **FLIGHT)
    env.seed(0)
    features = env.reset()
    frames = []
    for step in range(400):
        if step % 2 == 0:
            frames.append(Image.fromarray(env.flights.arena.picture(0, (240, 240))))
        actions, _ = model.predict(features, deterministic=True)
        features, _, done, _ = env.step(actions)
        if done[0]:
            break
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=100, loop=0, quality=70)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10)
    parser.add_argument("--envs", type=int, default=16)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--ways", type=int, default=50, help="for each target of the test")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("endoscope"))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    torch.set_num_threads(2)
    lumen = pliant.gym.find_lumen(pliant.make_phantom("airway"))
    held_out = lumen.targets(generation=5)
    trained = [n for n in lumen.targets() if n not in held_out]
    env = EndoscopeVecEnv(options.envs, scan=lumen, targets=trained, **FLIGHT)
    env.seed(options.seed)
    clock = Clock(options.minutes)
    model = stable_baselines3.PPO(
        "MlpPolicy", env, n_steps=256, batch_size=512, n_epochs=5, gamma=0.99, gae_lambda=0.95,
        learning_rate=lambda _: 1e-3 * max(0.1, clock.share_left()), ent_coef=0.0,
        seed=options.seed, device="cpu",
        policy_kwargs={"net_arch": [64, 64], "log_std_init": -0.5},
    )  # fmt: skip
    model.learn(10**9, callback=Curve(clock, options.out / "curve.csv"))
    trained_for = {"minutes": clock.minutes(), "processor_minutes": time.process_time() / 60}
    model.save(options.out / "policy.zip")
    test = {
        "steps": model.num_timesteps,
        **trained_for,
        "held_out": evaluate(model, lumen, held_out, options.ways, 1000),
        "trained": evaluate(model, lumen, trained, max(1, options.ways // 5), 2000),
    }
    (options.out / "test.json").write_text(json.dumps(test, indent=1) + "\n")
    print(json.dumps(test, indent=1))
    film(model, lumen, held_out[0], options.out / "flight.webp")


if __name__ == "__main__":
    main()
