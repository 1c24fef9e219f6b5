# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Objects serve one call at a time: another one is refused. The needs of a call are checked."""

import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy
import pytest

import pliant
import pliant.augment
from test_locks import long_equilibrium
from test_vessels import scene_in, straight


def chainmail():
    tissue = pliant.make_chainmail(pliant.make_phantom("airway", (48, 48, 48)), threads=1)

    def call():
        tissue.push((0, 0, 0), (9, 0, 0), sphere_radius_mm=5)
        tissue.undo()

    return call, lambda: tissue.undo_steps


def springs():
    tissue = pliant.make_springs(pliant.make_phantom("airway", (24, 24, 24)), threads=1)
    return lambda: tissue.advance(max_steps=20), tissue.hash


def network():
    parts = pliant.springs_of_lattice((16, 16, 16), bulk=1.0)
    tissue = pliant.SpringTissue(parts, depth=40, threads=1)
    tissue.load([4000], [(0, 0, 1e-3)])
    return lambda: tissue.step(20), lambda: tissue.reset()


def caster():
    tissue = pliant.make_chainmail(pliant.make_phantom("airway", (32, 32, 32)), threads=1)
    made = pliant.RayCaster(tissue, threads=1)
    endoscope = pliant.Endoscope()
    return lambda: made.endoscope_view(endoscope, 200, 200), lambda: tissue.undo_steps


def catheter():
    scene = scene_in(pliant.swept_tube(straight()), local=False)
    scene.command(insert_mm_s=10)
    return lambda: scene.step(20), scene.hash


def prepared():
    made = pliant.augment.PreparedScan(pliant.make_phantom("airway", (48, 48, 48)))

    def call():
        made.push((0, 0, 0), (9, 0, 0), 5.0)
        made.reset()

    return call, made.reset


@pytest.mark.parametrize("make", [chainmail, springs, network, caster, catheter, prepared])
def test_a_second_thread_is_refused(make):
    call, other = make()
    over = threading.Event()
    failed = []

    def work():
        while not over.is_set():
            try:
                call()
            except pliant.Error as error:
                if error.code != "busy":
                    failed.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    refused = None
    end = time.monotonic() + 20
    while refused is None and time.monotonic() < end:
        try:
            other()
        except pliant.Error as error:
            refused = error
    over.set()
    thread.join()
    assert failed == []
    assert refused is not None and refused.code == "busy"
    assert "busy: expected one call at a time" in str(refused)
    other()  # free again


def test_a_handler_of_a_signal_is_refused():
    find, displacements = long_equilibrium()
    refused = []

    def handler(*_):
        try:
            displacements()
        except pliant.Error as error:
            refused.append(error.code)
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, handler)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1)
        with pytest.raises(KeyboardInterrupt):
            find()
    finally:
        signal.signal(signal.SIGALRM, before)
    assert refused == ["busy"]


def test_a_group_that_ends_has_begun(airway):
    tetrahedron = pliant.TetMesh(5 * numpy.eye(4, 3), [(3, 0, 1, 2)])
    for tissue in (pliant.make_chainmail(airway), pliant.make_body(airway, tetrahedron)):
        with pytest.raises(pliant.Error, match="end_group: expected a group"):
            tissue.end_group()
        tissue.begin_group("outer")
        assert tissue.end_group() == 0
        with pytest.raises(pliant.Error, match="end_group: expected a group"):
            tissue.end_group()


@pytest.mark.parametrize("threads", [-1, 257, 70000, 10**9])
def test_threads_are_bounded(airway, threads):
    for call in (
        lambda: pliant.make_phantom("airway", (16, 16, 16), threads=threads),
        lambda: pliant.make_chainmail(airway, threads=threads),
        lambda: pliant.RayCaster(airway, threads=threads),
    ):
        with pytest.raises(pliant.Error, match="threads: expected 0 .one for each core. to 256"):
            call()


def test_random_calls_return_or_raise_an_error():
    script = pathlib.Path(__file__).with_name("fuzz_calls.py")
    done = subprocess.run(
        [sys.executable, script, "--calls", "250"], capture_output=True, text=True, check=False
    )
    print(done.stdout[-4000:], done.stderr[-2000:])
    assert done.returncode == 0
