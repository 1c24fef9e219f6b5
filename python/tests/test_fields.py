# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Displacement fields, against SimpleITK."""

import pathlib

import numpy
import pytest

import pliant
from conftest import random_direction

SHARED = pathlib.Path(__file__).resolve().parents[3] / "shared/data"


def smooth_field(rng, kind="resampling"):
    shape = (9, 10, 11)
    k, j, i = numpy.meshgrid(*(numpy.linspace(0, 3, n) for n in shape), indexing="ij")
    vectors = numpy.stack(
        [numpy.sin(i + a) * numpy.cos(j) + 0.3 * k for a in rng.normal(size=3)], axis=-1
    )
    return pliant.Field(
        vectors, rng.uniform(1, 2, 3), rng.normal(size=3), random_direction(rng), kind
    )


def test_points_move_as_simpleitk_moves_them(rng):
    pytest.importorskip("SimpleITK")
    field = smooth_field(rng)
    transform = field.to_sitk_transform()
    ijk = rng.uniform(0, 1, (200, 3)) * (numpy.array(field.size) - 1)
    points = numpy.array([field.world_from_voxel(p) for p in ijk])
    expected = numpy.array([transform.TransformPoint(p) for p in points])
    assert field.apply_to_points(points) == pytest.approx(expected, abs=1e-5)
    far = [[1e4, 0, 0]]
    assert (field.apply_to_points(far) == far).all()


def test_volumes_are_resampled_as_simpleitk_does(rng):
    sitk = pytest.importorskip("SimpleITK")
    field = smooth_field(rng)
    volume = pliant.Volume(
        rng.normal(size=(9, 10, 11)).astype(numpy.float32),
        field.spacing_mm,
        field.origin_mm,
        field.direction,
        background=7,
    )
    expected = sitk.GetArrayFromImage(
        sitk.Resample(volume.to_sitk(), field.to_sitk_transform(), sitk.sitkLinear, 7.0)
    )
    found = field.apply_to_volume(volume, threads=2).array
    # The two treat the border's last half voxel differently.
    inside = sitk.GetArrayFromImage(
        sitk.Resample(
            pliant.Volume(
                numpy.pad(numpy.ones((7, 8, 9), numpy.float32), 1),
                field.spacing_mm,
                field.origin_mm,
                field.direction,
            ).to_sitk(),
            field.to_sitk_transform(),
            sitk.sitkLinear,
            0.0,
        )
    )
    assert (inside > 0.999).sum() > 100
    assert found[inside > 0.999] == pytest.approx(expected[inside > 0.999], abs=1e-4)
    assert (found == field.apply_to_volume(volume, threads=1).array).all()


def expect_files_reproduce_the_deformation(folder, scan, pushes, least):
    """Another resampler makes the deformed scan of the files that a user writes.

    Args:
        pushes: Point, motion and radius [mm] of each.
        least: Voxels that have to change.
    """
    sitk = pytest.importorskip("SimpleITK")
    tissue = pliant.make_chainmail(scan)
    for point, motion, radius in pushes:
        tissue.push(point, motion, sphere_radius_mm=radius)
    scan.save(folder / "original.nrrd")
    tissue.inverse_field().save(folder / "transform.nrrd")
    image = sitk.ReadImage(folder / "original.nrrd", sitk.sitkFloat32)
    transform = sitk.DisplacementFieldTransform(
        sitk.ReadImage(folder / "transform.nrrd", sitk.sitkVectorFloat64)
    )
    expected = sitk.GetArrayFromImage(sitk.Resample(image, transform, sitk.sitkLinear, -1000.0))
    found = tissue.volume().array
    changed = found != scan.array
    assert changed.sum() > least
    assert (numpy.abs(found - expected)[changed] <= 3).mean() >= 0.99


def test_the_files_of_an_oblique_left_handed_phantom_reproduce_it(tmp_path, rng):
    phantom = pliant.make_phantom("airway", (64, 60, 56))
    direction = random_direction(rng)
    direction[:, 0] *= -numpy.sign(numpy.linalg.det(direction))
    scan = pliant.Volume(phantom.array, phantom.spacing_mm, (10, -20, 30), direction)
    carina = phantom.key_values["landmark carina"].removeprefix("push ").split(":")[0]
    carina = [float(x) for x in carina.split(",")]
    point = scan.world_from_voxel(phantom.voxel_from_world(carina))
    pushes = [(point, direction @ (6, 0, 0), 5), (point, direction @ (3, 2, 0), 0)]
    expect_files_reproduce_the_deformation(tmp_path, scan, pushes, 500)


def test_the_files_of_a_thorax_reproduce_it(tmp_path):
    file = SHARED / "thorax_ct_airways_crop.nrrd"
    if not file.exists():
        pytest.skip(f"{file} is missing")
    carina = [((-22.5, 172.3, -493), (0, 0, -6), 4)]
    expect_files_reproduce_the_deformation(tmp_path, pliant.read_volume(file), carina, 50000)


def test_jacobian_is_that_of_simpleitk(rng):
    sitk = pytest.importorskip("SimpleITK")
    field = smooth_field(rng)
    image = sitk.GetImageFromArray(field.array, isVector=True)
    image.SetSpacing(field.spacing_mm)
    # ITK takes derivatives along the grid's axes, so vectors have to be in those.
    local = field.array @ numpy.array(field.direction)
    image = sitk.GetImageFromArray(local.astype(numpy.float64), isVector=True)
    image.SetSpacing(field.spacing_mm)
    expected = sitk.GetArrayFromImage(sitk.DisplacementFieldJacobianDeterminant(image))
    inner = (slice(1, -1),) * 3
    assert field.jacobian().array[inner] == pytest.approx(expected[inner], abs=1e-4)


def test_modeling_fields_do_not_resample(rng, airway):
    with pytest.raises(pliant.Error, match="resampling"):
        smooth_field(rng, "modeling").apply_to_volume(airway)
    with pytest.raises(pliant.Error, match="kind"):
        pliant.Field(numpy.zeros((2, 3, 4, 3)), kind="backward")
    with pytest.raises(pliant.Error, match="axes"):
        pliant.Field(numpy.zeros((2, 3, 4)))


def test_files(rng, tmp_path):
    field = smooth_field(rng)
    field.save(tmp_path / "field.nrrd")
    read = pliant.read_field(tmp_path / "field.nrrd")
    assert (read.array == field.array).all()
    assert read.kind == field.kind
