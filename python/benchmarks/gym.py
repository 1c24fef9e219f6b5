# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Rates of the endoscope environments and of sequences, beside their floor.

    python python/benchmarks/gym.py [--threads 2] [--envs 16] [--steps 60]

The floor of a step is its rays, and the slide and relaxation of the tissue that the tip pushes:
it is measured in the same run, with pictures of one pixel. One JSON object for each case; cpu_ms
is the processors' time of a step (of all threads), which a busy machine changes less.
"""

from __future__ import annotations

import argparse
import json
import time
from typing import Any

import numpy

import pliant
import pliant.gym
from pliant import scene_flow

EYE, LOOK, UP = (0.3, -2.2, 22), (0, 0, -1), (0, -1, 0)  # in the phantom's trachea


def actions(step: int, count: int, touches: bool) -> Any:
    """A flight into the wall and back, or a turn in the middle."""
    made = numpy.zeros((count, 4))
    if not touches:
        made[:, 3] = 0.5
        return made
    side = numpy.where(numpy.arange(count) % 2 == 0, 1, -1)
    made[:, 0] = 10 if step % 40 < 28 else -10
    made[:, 3] = (1.5 if step < 14 else -0.45) * side
    return made


def arena_rate(lumen: Any, touches: bool, count: int, steps: int, **settings: Any) -> Any:
    """Rate of the arena by itself."""
    arena = pliant.EndoscopeArena(lumen.scan, count, **settings)
    for n in range(count):
        arena.place(n, EYE, LOOK, UP)
    arena.look()
    touched = 0.0
    wall, cpu = time.perf_counter(), time.process_time()
    for step in range(steps):
        arena.step(actions(step, count, touches))
        touched += arena.states[:, 13].mean()
    return rate(wall, cpu, count * steps, touched=round(touched / steps, 2))


def rate(wall: float, cpu: float, steps: int, **more: Any) -> dict[str, Any]:
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    return {"per_s": round(steps / wall), "cpu_ms": round(1e3 * cpu / steps, 3), **more}


def env_rate(lumen: Any, count: int, steps: int, threads: int) -> Any:
    """Rate of the vector environment, with its bookkeeping, along the guide."""
    env = pliant.gym.EndoscopeVectorEnv(count, lumen, ("depth", "guide"), threads=threads)
    observed, _ = env.reset(seed=1)
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in range(steps):
        guide = observed["guide"][:, :3]
        ahead = guide / numpy.linalg.norm(guide, axis=1, keepdims=True)
        act = numpy.zeros((count, 4))
        act[:, 0] = 20 * numpy.maximum(ahead[:, 2], 0) ** 2
        act[:, 2:] = numpy.clip(4 * numpy.stack([-ahead[:, 1], ahead[:, 0]], axis=1), -1.5, 1.5)
        observed, *_ = env.step(act)
    return rate(wall, cpu, count * steps)


def sequence_rate(lumen: Any, frames: int, threads: int, is_smooth: bool) -> Any:
    """Frames of 640 x 480 with everything."""
    made = scene_flow.EndoscopeSequence(
        lumen.scan, 1, frames, ends=lumen.ends, threads=threads, is_smooth=is_smooth
    )
    wall, cpu = time.perf_counter(), time.process_time()
    for _ in made:
        pass
    found = rate(wall, cpu, frames)
    found["per_s"] = round(found["cpu_ms"] and frames / (time.perf_counter() - wall), 2)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--envs", type=int, default=16)
    parser.add_argument("--steps", type=int, default=60)
    options = parser.parse_args()
    lumen = pliant.gym.find_lumen(pliant.make_phantom("airway"))
    count, steps, threads = options.envs, options.steps, options.threads

    def show(case: str, result: dict[str, Any]) -> None:
        print(json.dumps({"case": case, "threads": threads, **result}), flush=True)

    for touches, name in ((False, "untouched"), (True, "touched")):
        one = {"pictures": ("depth",), "threads": threads}
        show(f"{name}, tissue alone (1 pixel)",
             arena_rate(lumen, touches, count, steps, size=(1, 1), **one))  # fmt: skip
        show(f"{name}, depth 64x64", arena_rate(lumen, touches, count, steps, **one))
        show(f"{name}, depth 64x64, rigid",
             arena_rate(lumen, touches, count, steps, wall="rigid", **one))  # fmt: skip
        for pictures in (("rgb",), ("rgb", "depth", "normals", "flow")):
            show(f"{name}, {' '.join(pictures)} 64x64",
                 arena_rate(lumen, touches, count, steps, pictures=pictures,
                            threads=threads))  # fmt: skip
    show("environment, depth and guide, along the way", env_rate(lumen, count, steps, threads))
    for is_smooth in (False, True):
        show(f"sequence 640x480{', smooth' if is_smooth else ''}",
             sequence_rate(lumen, 24, threads, is_smooth))  # fmt: skip


if __name__ == "__main__":
    main()
