# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Registration truth in Python."""

import pathlib
import pickle
import re
import subprocess
import sys

import numpy
import pytest
import SimpleITK as sitk

import pliant
from pliant import truth

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"


@pytest.fixture(scope="module")
def scan() -> pliant.Volume:
    return pliant.make_phantom("airway", (40, 40, 40))


@pytest.fixture(scope="module")
def case(scan):
    return truth.make_case(scan, seed=5, landmarks=40)


def centres_of(volume):
    """Voxel centres (n, 3), in the order of the array."""
    k, j, i = numpy.indices(volume.array.shape).reshape(3, -1)
    ijk = numpy.stack([i, j, k], axis=1)
    return volume.origin_mm + (ijk * volume.spacing_mm) @ numpy.array(volume.direction).T


def test_a_case_has_arrays_of_the_scan_and_exact_maps(scan, case, rng):
    shape = scan.array.shape
    for volume in (case.moving, case.labels, case.fixed_mask, case.moving_mask):
        assert volume.array.shape == shape
    assert case.forward.array.shape == (*shape, 3)
    assert (case.forward.kind, case.inverse.kind) == ("modeling", "resampling")
    assert case.inverse_error_mm < 1e-4
    assert case.motions and {m["kind"] for m in case.motions} <= set(
        "contact slide cut interface breathing".split()
    )
    exact = numpy.flatnonzero(
        (case.moving_mask.array.ravel() == 0) & (case.inverse.array.reshape(-1, 3) != 0).any(axis=1)
    )
    some = rng.choice(exact, min(500, len(exact)), replace=False)
    points = centres_of(case.moving)[some]
    sources = points + case.inverse.array.reshape(-1, 3)[some]
    assert numpy.abs(case.moving_from_fixed(sources) - points).max() < 1e-4
    assert numpy.abs(case.fixed_from_moving(points) - sources).max() < 1e-4
    assert len(case.landmarks_fixed_mm) == len(case.landmark_types) > 10
    moved = case.moving_from_fixed(case.landmarks_fixed_mm)
    assert numpy.abs(moved - case.landmarks_moving_mm).max() < 1e-9
    assert numpy.isnan(case.moving_from_fixed([(1e4, 0, 0)])).all()


def test_a_case_of_the_elastic_scan_is_its_settled_push(scan, rng):
    seed = int(rng.integers(2**32))
    settings = {"kinds": "contact", "motions": 1, "landmarks": 30}
    materials = {"poisson_ratio": 0.3}
    case = truth.make_case(scan, seed, materials=materials, model="elastic", **settings)
    assert case.inverse_error_mm < 1e-4 and len(case.landmarks_fixed_mm) > 10
    tissue = pliant.make_elastic(scan, 1, **materials)
    for number, motion in enumerate(case.motions, 1):
        tissue.push(motion["point_mm"], motion["motion_mm"], motion["radius_mm"], number)
        tissue.advance()
    if len(case.motions) == 1:
        apart = numpy.abs(case.forward.array - tissue.displacement_field().array)
        assert apart.max() < 1e-5
    back = case.fixed_from_moving(case.landmarks_moving_mm)
    assert numpy.abs(back - case.landmarks_fixed_mm).max() < 1e-6
    assert pickle.loads(pickle.dumps(case)).hash == case.hash
    with pytest.raises(pliant.Error, match="offset"):
        truth.make_case(scan, model="elastic", materials={"offset": 0.2}, kinds="contact")
    with pytest.raises(pliant.Error, match="model: expected chainmail or elastic"):
        truth.make_case(scan, model="foam")


def test_the_same_seed_makes_the_same_case(scan, case):
    again = truth.TruthMaker(scan, threads=1, landmarks=40).make(5)
    assert again.hash == case.hash
    assert (again.moving.array == case.moving.array).all()
    assert truth.make_case(scan, seed=6, landmarks=40).hash != case.hash


def test_scores_know_fields_arrays_images_transforms_and_points(scan, case):
    none = truth.score(case, None)
    assert none["moved"]["mean_mm"] >= 0.5
    zero = truth.score(case, sitk.Transform(3, sitk.sitkIdentity))
    assert zero["moved"] == none["moved"]
    assert zero["landmarks"]["mean_mm"] == pytest.approx(none["landmarks"]["mean_mm"], rel=1e-6)
    image = sitk.GetImageFromArray(case.forward.array.astype(float), isVector=True)
    image.CopyInformation(scan.to_sitk())
    for perfect in (case.forward, case.forward.array, image, case.forward.to_sitk_transform()):
        found = truth.score(case, perfect)
        assert found["moved"]["max_mm"] < 1e-5
        assert found["still"]["max_mm"] < 1e-5
    shifted = truth.score(case, sitk.TranslationTransform(3, (0, 3, 4)))
    assert shifted["bone"]["mean_mm"] == pytest.approx(5, abs=1e-5)
    assert shifted["folded_share"] == 0
    points = truth.score(case, case.landmarks_moving_mm + [0, 0.3, 0.4])
    assert set(points) == {"landmarks"}
    assert points["landmarks"]["mean_mm"] == pytest.approx(0.5, abs=1e-6)


def test_a_field_of_nifti_has_the_grid_of_the_scan(tmp_path):
    oblique = [0.96, 0.28, 0.0, -0.28, 0.96, 0.0, 0.0, 0.0, 1.0]
    airway = pliant.make_phantom("airway", (32, 32, 32))
    scan = pliant.Volume(airway.array, (1.03, 0.97, 1.1), (-31.7, 18.123, -207.3), oblique)
    case = truth.make_case(scan, 3, motions=1)
    field = sitk.GetImageFromArray(numpy.ones(case.forward.array.shape), isVector=True)
    field.SetSpacing(scan.spacing_mm)
    field.SetOrigin(scan.origin_mm)
    field.SetDirection(oblique)
    found = {}
    for ending in ("mha", "nii.gz"):
        sitk.WriteImage(field, str(tmp_path / f"field.{ending}"))
        found[ending] = truth.score(case, sitk.ReadImage(str(tmp_path / f"field.{ending}")))
    assert found["mha"]["bone"]["max_mm"] == pytest.approx(3**0.5, abs=1e-5)
    for row, errors in found["mha"].items():
        assert found["nii.gz"][row] == pytest.approx(errors, abs=1e-4), row


def test_a_case_is_pickled_as_its_seed(case):
    again = pickle.loads(pickle.dumps(case))
    assert again.hash == case.hash and again.seed == case.seed
    assert (again.forward.array == case.forward.array).all()


def test_errors_name_the_argument(scan, case):
    with pytest.raises(pliant.Error, match="kinds"):
        truth.make_case(scan, kinds="push")
    count = len(case.landmarks_fixed_mm)
    with pytest.raises(pliant.Error, match=f"expected {count} points.*found 2"):
        truth.score(case, numpy.zeros((2, 3)))
    with pytest.raises(pliant.Error, match="registration"):
        truth.score(case, numpy.zeros((4, 4, 4, 3)))
    with pytest.raises(pliant.Error, match="scan"):
        truth.TruthMaker(scan.array)
    names = {setting["name"] for setting in truth.truth_settings()}
    assert {"kinds", "motions", "landmarks"} <= names


def test_the_table_joins_cases(case):
    none, perfect = truth.score(case, None), truth.score(case, case.forward)
    joined = truth.over_cases([none, none])
    assert joined["moved"]["count"] == 2 * none["moved"]["count"]
    assert joined["moved"]["mean_mm"] == pytest.approx(none["moved"]["mean_mm"])
    text = truth.table({"none": [none], "a|b": [perfect]})
    assert text.count("\n") == 2 + sum(r in none for r in truth.ROWS) * 2
    assert "a\\|b" in text


def test_importing_pliant_imports_no_optional_package():
    code = "import sys, pliant, pliant.truth; print('SimpleITK' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_the_example_registers_a_phantom():
    done = subprocess.run(
        [sys.executable, str(EXAMPLES / "score_registration.py"), "--check"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "demons" in done.stdout


def test_the_example_of_the_document_runs(scan, tmp_path, monkeypatch):
    document = (EXAMPLES.parents[1] / "docs/howto/truth.md").read_text()
    (block,) = re.findall(r"^```python\n(.*?)^```", document, re.M | re.S)
    monkeypatch.chdir(tmp_path)
    scan.save("airway.nrrd")
    names: dict = {}
    exec(compile(block, "truth.md", "exec"), names)
    made = truth.make_case(scan, seed=7, kinds="slide,breathing", motions=2)
    assert names["case"].hash == made.hash
    assert 0 < truth.score(made, names["transform"])["moved"]["mean_mm"] < 10
