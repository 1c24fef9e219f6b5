# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Tissues: results, threads, interruption, processes."""

import multiprocessing
import pickle
import signal
import threading
import time

import numpy
import pytest

import pliant

POINT = (-23, -3, 1)


def pushed(scan, threads=1):
    tissue = pliant.make_chainmail(scan, threads=threads)
    report = tissue.push(POINT, (4, 0, 0), sphere_radius_mm=4)
    assert report.status == "applied"
    assert report.moved_elements > 1000
    return tissue


def test_the_result_does_not_depend_on_threads(airway):
    one, two = pushed(airway, 1), pushed(airway, 2)
    assert one.hash() == two.hash()
    assert (one.volume().array == two.volume().array).all()
    assert one.threads == 1
    assert two.threads == 2


def test_field_inverse_and_volume_belong_together(airway):
    tissue = pushed(airway)
    forward, inverse = tissue.displacement_field(), tissue.inverse_field()
    assert forward.kind == "modeling"
    assert inverse.kind == "resampling"
    assert (inverse.apply_to_volume(airway).array == tissue.volume().array).all()
    assert (tissue.volume().array != airway.array).any()
    assert forward.apply_to_points([POINT])[0] == pytest.approx((-19, -3, 1), abs=1.5)
    assert tissue.jacobian().array.min() > 0
    assert tissue.strain().array.max() > 0


def test_history_and_state(airway, tmp_path):
    tissue = pushed(airway)
    after = tissue.hash()
    tissue.save_state(tmp_path / "state")
    tissue.undo()
    assert tissue.hash() == pliant.make_chainmail(airway).hash()
    tissue.redo()
    assert tissue.hash() == after
    tissue.reset()
    tissue.load_state(tmp_path / "state")
    assert tissue.hash() == after


def test_springs_and_bodies_move_by_themselves(airway):
    springs = pliant.make_springs(airway, cell_mm=8, depth=5)
    springs.push(POINT, (3, 0, 0))
    springs.release()
    assert springs.advance(max_steps=3).steps == 3
    tetrahedra = pliant.TetMesh(
        [[0, 0, 0], [40, 0, 0], [0, 40, 0], [0, 0, 40], [40, 40, 40]], [[0, 1, 2, 3], [1, 2, 3, 4]]
    )
    if numpy.linalg.det(tetrahedra.nodes_mm[[2, 3, 4]] - tetrahedra.nodes_mm[1]) < 0:
        tetrahedra = pliant.TetMesh(tetrahedra.nodes_mm, [[0, 1, 2, 3], [2, 1, 3, 4]])
    body = pliant.make_body(airway, tetrahedra, fixed_hu=3000)
    assert body.push((8, 8, 8), (2, 0, 0)).grabbed_elements == 4
    assert body.force_n() is not None


def test_the_elastic_scan_pushes_back_and_returns(airway):
    tissue = pliant.make_elastic(airway, threads=1)
    report = tissue.push(POINT, (2, 0, 0), sphere_radius_mm=4)
    assert report.status == "applied"
    assert tissue.advance(max_steps=200).settled
    force = tissue.force_n()
    assert force[0] < 0
    stiff = pliant.make_elastic(
        airway,
        threads=2,
        moduli_kpa=[(-950, 0), (-900, 15), (300, 200)],
        poisson_ratio=0.4,
        held_sides=["-x", "+z"],
    )
    stiff.push(POINT, (2, 0, 0), sphere_radius_mm=4)
    stiff.advance(max_steps=200)
    assert stiff.force_n()[0] < 2 * force[0]
    assert stiff.hash() != tissue.hash()
    tissue.release()
    tissue.advance(max_steps=1000)
    assert tissue.hash() == pliant.make_elastic(airway).hash()


def test_moduli_are_pairs_and_sides_texts(airway):
    table = numpy.array([[-950, 0], [40, 8.0]])
    given = pliant.make_elastic(airway, 1, moduli_kpa=table, held_sides=[])
    same = pliant.make_elastic(airway, 1, moduli_kpa=[[-950, 0], (40, 8)], held_sides=())
    for tissue in (given, same):
        tissue.push(POINT, (1, 0, 0), sphere_radius_mm=4)
    assert given.hash() == same.hash()
    assert pickle.loads(pickle.dumps(given)).hash() == given.hash()
    for name, wrong in (
        ("moduli_kpa", [1, 2]),
        ("moduli_kpa", [(1, 2, 3)]),
        ("moduli_kpa", [(1, 2), 3]),
        ("moduli_kpa", [(2, 1), (1, 1)]),
        ("held_sides", "-x"),
        ("held_sides", ["left"]),
        ("poisson_ratio", 0.5),
    ):
        with pytest.raises(pliant.Error, match=name):
            pliant.make_elastic(airway, 1, **{name: wrong})


def test_settings_are_the_headers(airway):
    names = [row["name"] for row in pliant.settings_of("chainmail")]
    assert "offset" in names
    tissue = pliant.make_chainmail(airway, offset=0.1, factor=(1, 1, 2))
    assert tissue.settings["offset"] == 0.1
    tissue.configure(offset=0.3)
    assert tissue.settings["offset"] == 0.3
    for wrong in ({"offsett": 1}, {"offset": "x"}, {"offset": -1}, {"offset": [1, 2]}):
        with pytest.raises(pliant.Error) as raised:
            pliant.make_chainmail(airway, **wrong)
        assert next(iter(wrong)) in str(raised.value)
    with pytest.raises(pliant.Error, match="model"):
        pliant.settings_of("jelly")


def test_a_failed_call_changes_nothing(airway):
    tissue = pushed(airway)
    before = tissue.hash()
    for wrong in (
        lambda: tissue.push((1e4, 0, 0), (1, 0, 0)),
        lambda: tissue.push(POINT, (float("nan"), 0, 0)),
        lambda: tissue.cut([(0, 0, 0)], (1, 0, 0)),
        lambda: tissue.load_state("missing"),
    ):
        with pytest.raises(pliant.Error):
            wrong()
    assert tissue.hash() == before
    with pytest.raises(pliant.Error, match="point_mm: expected three numbers, found .1, 2."):
        tissue.push((1, 2), (1, 0, 0))


def test_other_threads_run_during_a_solve(airway):
    tissue = pliant.make_springs(airway, cell_mm=4, depth=20, threads=1)
    tissue.push(POINT, (6, 0, 0))
    ticks = []
    done = threading.Event()

    def tick():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    tissue.advance(max_ms=300)
    end = time.perf_counter()
    done.set()
    thread.join()
    assert sum(begin < t < end for t in ticks) > 10


@pytest.mark.parametrize("threads", [1, 2])
def test_an_interruption_leaves_the_tissue_as_it_was(threads):
    scan = pliant.make_phantom("layers", (192, 192, 192))
    tissue = pliant.make_chainmail(scan, threads=threads, offset=0.02, max_movement_mm=200)
    middle = scan.world_from_voxel((96, 96, 96))
    before = tissue.hash()
    begin = time.perf_counter()
    tissue.push(middle, (0, 0, 10))
    uninterrupted = time.perf_counter() - begin
    tissue.undo()
    delay = min(0.02, uninterrupted / 4)
    sent = []

    def interrupt():
        time.sleep(delay)
        sent.append(time.perf_counter())
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    begin = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        thread.start()
        while time.perf_counter() - begin < 30:
            tissue.push(middle, (0, 0, 10))
            tissue.undo()
    print(f"stopped {1000 * (time.perf_counter() - sent[0]):.0f} ms after the signal")
    thread.join()
    while tissue.undo_steps:
        tissue.undo()
    assert tissue.hash() == before
    tissue.push(middle, (0, 0, 10))


def hash_in_a_child(scan, results):
    results.put(pushed(scan, threads=1).hash())


def test_one_thread_works_after_a_fork(airway):
    here = pushed(airway, threads=2).hash()  # oneTBB has threads now, which a child lacks
    context = multiprocessing.get_context("fork")
    results = context.Queue()
    child = context.Process(target=hash_in_a_child, args=(airway, results))
    child.start()
    assert results.get(timeout=60) == here
    child.join(60)
    assert child.exitcode == 0


def test_tissue_keeps_its_scan():
    tissue = pushed(pliant.make_phantom("airway", (64, 64, 64)))
    volume = tissue.volume()
    assert tissue.scan.size == (64, 64, 64)
    del tissue
    assert volume.array.min() < -900
