# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Scenes and reports are pickled and copied, and go on as before."""

import copy
import pickle

import numpy
import pytest

import pliant
import pliant.augment
from pliant._core import TruthMaker
from test_vessels import scene_in, straight


def values_of(report):
    """All attributes of a report that aren't methods."""
    names = [name for name in dir(report) if name[0] != "_"]
    values = {name: getattr(report, name) for name in names}
    return {
        name: values_of(value) if type(value).__module__ == "pliant._core" else value
        for name, value in values.items()
        if not callable(value)
    }


def reports():
    scan = pliant.make_phantom("airway", (32, 32, 32))
    tissue = pliant.make_chainmail(scan, threads=1)
    yield tissue.push((0, 0, 0), (6, 0, 0), sphere_radius_mm=5)
    yield tissue.push((0, 0, 0), (400, 0, 0), sphere_radius_mm=5)
    yield tissue.slide((0, 0, 0), (0, 0, 5), 2)
    yield tissue.cut([(-5, 0, 0), (5, 0, 0)], (0, 0, 9))
    yield tissue.carve((0, 0, 0), (1, 0, 0), 3)
    yield pliant.make_springs(scan, threads=1).advance(max_steps=2)
    yield pliant.augment.PreparedScan(scan).follow([((0, 0, 0), 1.0, 5.0)], [])
    caster = pliant.RayCaster(scan, threads=1)
    yield caster.first_hit((0, 0, 0), (1, 0, 0))
    network = pliant.SpringTissue(pliant.springs_of_lattice((3, 3, 3)), threads=1)
    network.load([26], [(0, 0, 1e-3)])
    yield network.step(2)
    yield network.cut_links([0])
    network.hold([26])
    yield network.reaction([26])
    scene = scene_in(pliant.swept_tube(straight()), local=False)
    scene.command(insert_mm_s=10)
    scene.step(2)
    yield scene.measures()


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_reports_are_values(copied):
    kinds = set()
    for report in reports():
        kinds.add(type(report).__name__)
        numpy.testing.assert_equal(values_of(copied(report)), values_of(report))
        with pytest.raises(pliant.Error, match="state: expected that of"):
            type(report).__new__(type(report)).__setstate__(())
    assert len(kinds) == 11


def test_a_scene_goes_on_as_its_copy():
    scene = scene_in(pliant.swept_tube(straight()), local=False)
    scene.command(insert_mm_s=30, rotate_deg_s=90, bend_first_deg=20)
    scene.step(20)
    again = pickle.loads(pickle.dumps(scene))
    assert again.hash() == scene.hash()
    assert again.settings == scene.settings
    for one in (scene, again):
        one.step(10)
    assert again.hash() == scene.hash()
    assert again.measures().inserted_mm == scene.measures().inserted_mm


def test_what_is_made_of_a_scan_is_made_again(airway):
    settings = {"offset": 0.2, "max_movement_mm": 30.0}
    prepared = pliant.augment.PreparedScan(airway, **settings)
    again = copy.deepcopy(prepared)
    assert again.settings == settings
    for one in (prepared, again):
        one.push((2.5, -1, -9), (3, 0, 0), 4.0)
    moved = [one.finish()[1].array for one in (prepared, again)]
    assert (moved[0] == moved[1]).all() and (moved[0] != airway.array).any()
    caster = pliant.RayCaster(airway, threads=1)
    other = pickle.loads(pickle.dumps(caster))
    endoscope = pliant.Endoscope()
    pictures = [one.endoscope_view(endoscope, 40, 30) for one in (caster, other)]
    assert (pictures[0] == pictures[1]).all()
    maker = TruthMaker(airway, 1, motions=1)
    assert copy.deepcopy(maker).make(4).hash == maker.make(4).hash


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_arenas_go_on_as_their_copies(airway, copied):
    scopes = pliant.EndoscopeArena(
        airway, 2, size=(16, 12), relax_every=2, pictures=["rgb", "depth"], threads=1, offset=0.2
    )
    vessel = pliant.swept_tube(straight())
    catheters = pliant.CatheterArena(
        vessel, pliant.scan_of_vessel(vessel), 0, 0.5, 2, (16, 12),
        view=pliant.Fluoroscopy(centre_mm=(0, 0, 20)), threads=1, friction=0.2,
    )  # fmt: skip
    for arena, actions in ((scopes, [[8, 1, 0, 0.5]] * 2), (catheters, [[30, 1, 0.5]] * 2)):
        for _ in range(4):
            arena.step(actions, [True, False])
        again = copied(arena)
        assert again.threads == 1 and again.count == 2
        for _ in range(3):
            assert [again.hash(n) for n in range(2)] == [arena.hash(n) for n in range(2)]
            numpy.testing.assert_equal(again.states, arena.states)
            for name in ("colour", "depth_mm", "fluoro", "points_mm"):
                if hasattr(arena, name):
                    numpy.testing.assert_equal(getattr(again, name), getattr(arena, name))
            for one in (arena, again):
                one.step(actions)
        assert arena.hash(0) != arena.hash(1)
    assert scopes.states[0, 15] == 7
