# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Plans and studies of release 0.2 (tests/data/0.2) are read by this one."""

import pathlib
import shutil

import numpy
import pliant
from pliant.augment import Plan, TissueMotions
from pliant.study import Study

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "tests/data/0.2"


def test_a_plan_has_its_motions_and_moves_its_scan():
    plan = Plan.load(FOLDER / "plan.json")
    assert [motion["kind"] for motion in plan.motions] == ["push", "pull", "swelling", "breath"]
    assert plan.motions[0]["by_mm"] == [0.5, 2.0, 0.5]
    assert plan.motions[3]["above_mm"] == 20.0
    assert plan.tissue["offset"] == 0.25
    assert plan.model == "chainmail"
    scan = pliant.read_volume(FOLDER / "scan.nrrd")
    moved = TissueMotions(threads=1).apply(scan, plan)
    lengths = numpy.linalg.norm(moved.forward.array, axis=-1)
    assert 1.5 < lengths.max() < 8
    assert moved.smallest_jacobian > 0


def test_a_study_has_its_items(tmp_path):
    for name in ("study.toml", "scan.nrrd"):
        shutil.copy(FOLDER / name, tmp_path / name)
    study = Study.load(tmp_path / "study.toml")
    assert len(study.items) == 2
