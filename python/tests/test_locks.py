# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The interpreter's lock is free during solves, other threads run meanwhile; Ctrl-C ends them."""

import os
import pathlib
import signal
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


PICTURES = ("endoscope", "blended", "fluoroscopy")


def long_equilibrium():
    parts = pliant.springs_of_lattice((36, 36, 36))
    parts.fixed[: 36 * 36] = True
    tissue = pliant.SpringTissue(parts, depth=100, threads=1)
    tissue.load([36**3 - 1], [(0, 0, 0.5)])
    tissue.step(3)
    return tissue.find_equilibrium, lambda: tissue.displacements


def long_fit(method, threads, **settings):
    parts = pliant.springs_of_lattice((12, 12, 12), stiffness=100)
    parts.fixed[: 12 * 12] = True
    groups = [
        pliant.FitGroup(f"group {n}", 1, 0.1, 10, links=links)
        for n, links in enumerate(numpy.array_split(numpy.arange(len(parts.links)), 4))
    ]
    moved = numpy.random.default_rng(1).normal(size=(12**3, 3))
    case = pliant.FitCase([12**3 - 1], [(0.0, 0.0, -1.0)], 0.01 * moved)
    problem = pliant.FitProblem(parts, groups, [case], **settings)
    return lambda: pliant.fit(problem, method, threads=threads), None


def long_picture(name, threads):
    scan = pliant.make_phantom("airway", (96, 96, 96))
    endoscope = pliant.find_endoscope(scan)
    caster = pliant.RayCaster(scan, threads=threads)
    if name == "fluoroscopy":
        settings = pliant.Fluoroscopy(centre_mm=scan.world_from_voxel((48, 48, 48)))
        return lambda: pliant.fluoroscopy_view(scan, settings, 4000, 4000, threads=threads), None
    if name == "blended":
        transfer = pliant.TransferFunction()
        return lambda: caster.blended_view(endoscope, transfer, 4000, 4000), None
    return lambda: caster.endoscope_view(endoscope, 4000, 4000), None



def long_save(kind, name, folder):
    path = pathlib.Path(folder, name)
    noise = numpy.random.default_rng(1).normal(0, 99, (96, 96, 96, 3)).astype("float32")
    made = pliant.Field(noise) if kind == "field" else pliant.Volume(noise.reshape(96, 96, -1))
    return lambda: made.save(path), lambda: numpy.array(os.listdir(folder) == [])


@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_ends_phantoms(threads):
    def processor_s(work):
        before = time.process_time()
        work()
        return time.process_time() - before

    def make(size):
        return pliant.make_phantom("airway", (size, size, size), threads=threads)

    def interrupted():
        test_ctrl_c_ends(lambda: (lambda: make(512), None), ())

    whole_s = 8**3 * processor_s(lambda: make(64))
    assert processor_s(interrupted) < whole_s / 4


@pytest.mark.parametrize(
    ("kind", "name"), [("volume", f"a.{ending}") for ending in ("nrrd", "mha", "nii.gz")]
    + [("field", "a.nrrd"), ("field", "a.nii.gz")],
)  # fmt: skip
def test_ctrl_c_ends_writing_and_leaves_no_file(kind, name, tmp_path):
    test_ctrl_c_ends(long_save, (kind, name, tmp_path))
    assert not os.listdir(tmp_path)


@pytest.mark.parametrize(
    ("make", "arguments"),
    [(long_equilibrium, ())]
    + [(long_fit, (method, 1)) for method in ("gauss_newton", "annealing")]
    + [(long_fit, ("annealing", 2))]
    + [(long_picture, (name, n)) for name in PICTURES for n in (1, 2)],
)
def test_ctrl_c_ends(make, arguments):
    call, state = make(*arguments)
    before = state() if state else None
    sent = []

    def send():
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    timer = threading.Timer(0.1, send)
    with pytest.raises(KeyboardInterrupt):
        timer.start()
        call()
    print(f"ended after {1000 * (time.perf_counter() - sent[0]):.0f} ms")
    timer.join()
    if state:
        assert (state() == before).all()


def test_ctrl_c_ends_fits_that_move_tissue():
    for settings in ({"motion": "equilibrium"}, {"motion": "run", "duration": 5.0}):
        test_ctrl_c_ends(lambda s=settings: long_fit("gauss_newton", 1, **s), ())
