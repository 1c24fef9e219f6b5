# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Pace of catheters: simulated time over real time, with observations, in ways to the aorta's ends.

    python python/benchmarks/catheter.py [--envs 8] [--ways 3]

Each way is pushed at 50 mm/s while the hand rotates at random, until it ends. Times of resets are
not in the pace. The processor's time is that of all threads.
"""

from __future__ import annotations

import argparse
import time

import numpy

import pliant.gym

_CONTROL_HZ = 7.5


def ways(env, seeds, count):
    """Seconds of simulation, of the clock, of the processor; resets' and the worst depth."""
    simulated = clock = processor = resets = 0.0
    deepest, inserted = -1.0, []
    for seed in seeds:
        rng = numpy.random.default_rng(seed)
        begin = time.perf_counter()
        env.reset(seed=seed)
        resets += time.perf_counter() - begin
        is_over = numpy.zeros(count, bool)
        for _ in range(60):
            actions = rng.uniform(-1, 1, (count, 1, 2)) * [50, 3.14]
            actions[:, 0, 0] = 50
            begin, cpu = time.perf_counter(), time.process_time()
            _, _, ended, _, infos = env.step(actions if count > 1 else actions[0])
            clock += time.perf_counter() - begin
            processor += time.process_time() - cpu
            simulated += float((~is_over).sum()) / _CONTROL_HZ
            deepest = max(deepest, float(numpy.max(infos["depth_mm"])))
            is_over |= numpy.atleast_1d(ended)
            if is_over.all():
                break
            if count > 1 and is_over.any():
                break  # the others would be alone
        inserted.append(float(env.arena.states[:, 9].max()))
    return simulated, clock, processor, resets / len(seeds), deepest, inserted


def main():
    """Prints a table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--envs", type=int, default=8)
    parser.add_argument("--ways", type=int, default=3)
    options = parser.parse_args()
    begin = time.perf_counter()
    vessel = pliant.gym.find_vessel("aorta")
    print(f"vessel found in {time.perf_counter() - begin:.1f} s")
    columns = "walls, catheters, observations, pace, of one core, a reset, deepest, inserted"
    print("| " + columns.replace(", ", " | ") + " |")
    print("|---|---|---|---|---|---|---|---|")
    seeds = range(1, options.ways + 1)
    for wall in ("rigid", "deforming"):
        for count, obs in (
            (1, ("tracking2d", "target2d", "state")),
            (1, ("fluoro", "tracking2d", "state")),
            (options.envs, ("fluoro", "tracking2d", "state")),
        ):
            if count == 1:
                env = pliant.gym.CatheterEnv(vessel, obs, wall=wall)
            else:
                env = pliant.gym.CatheterVectorEnv(count, vessel, obs, wall=wall)
            found = ways(env, seeds, count)
            simulated, clock, processor, reset, deepest, inserted = found
            print(
                f"| {wall} | {count} | {', '.join(obs)} | {simulated / clock:.1f} "
                f"| {simulated / processor:.1f} | {1e3 * reset:.0f} ms | {deepest:.3f} mm "
                f"| {numpy.mean(inserted):.0f} mm |",
                flush=True,
            )


if __name__ == "__main__":
    main()
