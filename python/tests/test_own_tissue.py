# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A tissue of one's own in everything that the module does with a tissue."""

from __future__ import annotations

import copy
import gc
import pathlib
import pickle
from typing import Any

import numpy
import pytest

import pliant
from jelly import Jelly

CARINA, AHEAD = (-0.2, -1.0, -5.0), (4.0, 0.0, 0.0)


@pytest.fixture
def jelly() -> Jelly:
    return Jelly(pliant.make_phantom("airway", (48, 48, 48)))


def test_is_pushed_and_resampled_by_its_own_law(jelly: Jelly) -> None:
    report = jelly.push(CARINA, AHEAD)
    assert report.status == "applied" and report.step_fraction == 1
    field = jelly.displacement_field().array
    ijk = numpy.argwhere(numpy.ones(field.shape[:3]))[:, ::-1]
    direction = numpy.array(jelly.scan.direction) * jelly.scan.spacing_mm
    x = numpy.array(jelly.scan.origin_mm) + ijk @ direction.T
    d = x - CARINA
    expected = numpy.exp(-(d**2).sum(1) / 72)[:, None] * AHEAD
    near = numpy.abs(d).max(1) < 17
    got = field.reshape(-1, 3)
    assert numpy.abs(got[near] - expected[near]).max() < 1e-5
    assert (got[numpy.abs(d).max(1) > 23] == 0).all()
    deformed = jelly.volume()
    assert (deformed.array != jelly.scan.array).any()
    moved = jelly.displacement_field().apply_to_points([CARINA])
    back = jelly.inverse_field().apply_to_points(moved)
    assert numpy.abs(numpy.array(back) - CARINA).max() < 0.1
    assert jelly.jacobian().array.min() > 0


def test_history_and_files_are_the_library_s(jelly: Jelly, tmp_path: pathlib.Path) -> None:
    rest = jelly.hash()
    jelly.begin_group("push")
    jelly.push(CARINA, AHEAD)
    jelly.end_group()
    pushed = jelly.hash()
    jelly.save_state(tmp_path / "state")
    jelly.undo()
    assert jelly.hash() == rest and jelly.undo_steps == 0
    jelly.redo()
    assert jelly.hash() == pushed
    jelly.reset()
    assert jelly.hash() == rest
    jelly.load_state(tmp_path / "state")
    assert jelly.hash() == pushed
    with pytest.raises(pliant.Error, match="redo: expected a step"):
        jelly.redo()


def test_advance_sweeps_until_it_rests(jelly: Jelly) -> None:
    rest = jelly.hash()
    jelly.push(CARINA, AHEAD)
    assert jelly.force_n() == pytest.approx((-0.8, 0, 0))
    assert jelly.advance().settled and jelly.hash() != rest
    jelly.release()
    assert jelly.advance(max_steps=1).settled is False
    assert jelly.shift[0] == pytest.approx(3.6)
    report = jelly.advance()
    assert report.settled and jelly.hash() == rest
    assert jelly.model == "jelly"


def test_errors_of_methods_are_errors_of_calls(jelly: Jelly, tmp_path: pathlib.Path) -> None:
    class Broken(Jelly):
        def sweep(self) -> bool:
            raise ZeroDivisionError("by nought")

        def state(self) -> Any:
            return "no numbers"

    broken = Broken(jelly.scan)
    with pytest.raises(pliant.Error, match="sweep: ZeroDivisionError: by nought"):
        broken.advance()
    for call in (lambda: broken.begin_group("x"), lambda: broken.save_state(tmp_path / "s")):
        with pytest.raises(pliant.Error, match="state: "):
            call()
    assert not (tmp_path / "s").exists()

    class Empty(pliant.Tissue):
        pass

    empty = Empty(jelly.scan)
    assert empty.model == "Empty" and empty.advance().settled
    with pytest.raises(pliant.Error, match="push: expected Empty to have this method"):
        empty.push(CARINA, AHEAD)
    with pytest.raises(pliant.Error, match="expected a class of your own"):
        pliant.Tissue(jelly.scan)
    with pytest.raises(pliant.Error, match="scan: expected a Volume"):
        Empty("scan")  # type: ignore[arg-type]
    with pytest.raises(pliant.Error, match=r"array \(k, j, i, 3\)"):
        jelly.displace(numpy.zeros((3, 3)))
    with pytest.raises(pliant.Error, match="expected a tissue of a class of your own"):
        pliant.make_chainmail(jelly.scan).displace(numpy.zeros((1, 1, 1, 3)))


def test_nothing_changes_if_a_displacement_is_not_finite(jelly: Jelly) -> None:
    jelly.push(CARINA, AHEAD)
    before = jelly.hash()
    with pytest.raises(pliant.Error):
        jelly.displace(numpy.full((2, 2, 2, 3), numpy.nan))
    assert jelly.hash() == before


def tissues() -> dict[str, Any]:
    scan = pliant.make_phantom("airway", (48, 48, 48))
    return {
        "own": Jelly(scan),
        "chainmail": pliant.make_chainmail(scan, threads=1, offset=0.15),
        "springs": pliant.make_springs(scan, threads=1, cell_mm=20),
    }


@pytest.mark.parametrize("kind", ["own", "chainmail", "springs"])
@pytest.mark.parametrize("copied", ["pickle", "deepcopy"])
def test_copies_go_on_alike(kind: str, copied: str, tmp_path: pathlib.Path) -> None:
    tissue = tissues()[kind]
    tissue.push(CARINA, AHEAD, sphere_radius_mm=4)
    tissue.release()
    if kind == "springs":
        tissue.configure(depth=3)
        tissue.save_state(tmp_path / "state")  # files have no speeds
        tissue.load_state(tmp_path / "state")
    twin = pickle.loads(pickle.dumps(tissue)) if copied == "pickle" else copy.deepcopy(tissue)
    assert type(twin) is type(tissue) and twin.model == tissue.model
    assert twin.hash() == tissue.hash() and twin.settings == tissue.settings
    assert (twin.volume().array == tissue.volume().array).all()
    before = tissue.hash()
    twin.push(CARINA, (0, 2, 0), sphere_radius_mm=4)
    assert tissue.hash() == before != twin.hash()
    tissue.push(CARINA, (0, 2, 0), sphere_radius_mm=4)
    assert twin.hash() == tissue.hash()


def test_lives_as_long_as_it_is_used() -> None:
    jelly = Jelly(pliant.make_phantom("airway", (32, 32, 32)))
    jelly.push(CARINA, AHEAD)
    field, volume = jelly.displacement_field().array, jelly.volume().array
    kept = field.copy(), volume.copy()
    del jelly
    gc.collect()
    assert (field == kept[0]).all() and (volume == kept[1]).all()
