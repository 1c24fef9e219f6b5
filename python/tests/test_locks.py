# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The interpreter's lock is free during solves: other threads run meanwhile."""

import threading
import time

import numpy
import pytest

import pliant
from test_vessels import scene_in, straight


def catheter():
    scene = scene_in(pliant.swept_tube(straight()), local=False)
    scene.command(insert_mm_s=10)
    return lambda: scene.step(20)


def network():
    parts = pliant.springs_of_lattice((20, 20, 20), bulk=1.0, node_damping=1)
    parts.fixed[:400] = True
    tissue = pliant.SpringTissue(parts, depth=40, threads=1)
    tissue.load([7999], [(0, 0, 1e-3)])
    return lambda: tissue.step(20)


def equilibrium():
    parts = pliant.springs_of_lattice((12, 12, 12))
    parts.fixed[:144] = True
    tissue = pliant.SpringTissue(parts, depth=40, threads=1)
    tissue.load([1727], [(0, 0, 1e-2)])
    return lambda: (tissue.reset(), tissue.find_equilibrium())


def elastic():
    mesh = pliant.hex_mesh((9, 9, 9))
    material = pliant.ElasticMaterial(young_modulus_pa=1e4, poisson_ratio=0.3)
    bottom = numpy.arange(9 * 9)
    return lambda: pliant.ElasticSolver(mesh, material, bottom, threads=1)


def picture():
    caster = pliant.RayCaster(pliant.make_phantom("airway", (64, 64, 64)), threads=1)
    endoscope = pliant.Endoscope()
    return lambda: caster.endoscope_view(endoscope, 400, 400)


@pytest.mark.parametrize("made", [catheter, network, equilibrium, elastic, picture])
def test_other_threads_run_during(made):
    call = made()
    ticks = []
    done = threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.0005)

    thread = threading.Thread(target=tick)
    thread.start()
    seen = longest = 0
    try:
        # A call that is over before another thread wakes up shows nothing.
        for _ in range(50):
            begin = time.perf_counter()
            call()
            end = time.perf_counter()
            longest = max(longest, end - begin)
            margin = (end - begin) / 4
            seen += sum(begin + margin < t < end - margin for t in ticks)
            if seen > 3:
                break
    finally:
        done.set()
        thread.join()
    print(f"longest call {1000 * longest:.1f} ms")
    assert seen > 3
