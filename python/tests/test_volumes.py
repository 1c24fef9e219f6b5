# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Scans: exchange with NumPy, SimpleITK, NiBabel, DLPack and pickle; bad input."""

import copy
import gc
import pickle
import weakref

import numpy
import pytest

import pliant
from conftest import random_direction


@pytest.mark.parametrize("dtype", [numpy.int16, numpy.float32])
def test_an_array_is_viewed_both_ways(dtype, rng):
    array = rng.integers(-1000, 1000, (4, 5, 6)).astype(dtype)
    volume = pliant.Volume(array, spacing_mm=(1, 2, 3))
    assert numpy.shares_memory(volume.array, array)
    assert volume.size == (6, 5, 4)
    assert not volume.array.flags.writeable
    assert numpy.shares_memory(numpy.asarray(volume), array)
    taken = numpy.from_dlpack(volume)
    assert (taken == array).all() and not numpy.shares_memory(taken, array)
    with pytest.raises(BufferError, match="read-only"):
        numpy.from_dlpack(volume, copy=False)


def test_memory_lives_as_long_as_its_views():
    class Kept(numpy.ndarray):
        pass

    array = numpy.arange(60, dtype=numpy.int16).reshape(3, 4, 5).view(Kept)
    gone = weakref.ref(array)
    view = pliant.Volume(array).array
    del array
    gc.collect()
    assert view[2, 3, 4] == 59
    assert gone() is not None
    del view
    gc.collect()
    assert gone() is None


@pytest.mark.parametrize(
    ("values", "dtype"),
    [
        (numpy.zeros((2, 3, 4)), numpy.float32),
        (numpy.zeros((2, 3, 4), numpy.uint8), numpy.int16),
        (numpy.full((2, 3, 4), 32767, numpy.uint16), numpy.int16),
        (numpy.full((2, 3, 4), 32768, numpy.uint16), numpy.float32),
        (numpy.full((2, 3, 4), -32769, numpy.int64), numpy.float32),
        (numpy.zeros((4, 3, 2), numpy.int16).T, numpy.int16),
        (numpy.zeros((2, 3, 4), ">i2"), numpy.int16),
    ],
)
def test_other_types_are_converted(values, dtype):
    volume = pliant.Volume(values)
    assert volume.array.dtype == dtype
    assert (volume.array == values).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"array": numpy.zeros((2, 3))}, "three axes"),
        ({"array": numpy.zeros((2, 3, 4), complex)}, "real numbers"),
        ({"array": numpy.zeros((0, 3, 4))}, "array"),
        ({"array": numpy.zeros((2, 3, 4)), "spacing_mm": (1, 0, 1)}, "spacing"),
        ({"array": numpy.zeros((2, 3, 4)), "direction": numpy.ones((3, 3))}, "direction"),
        ({"array": numpy.zeros((2, 3, 4)), "direction": [1, 2]}, "nine numbers"),
    ],
)
def test_bad_input_is_named(arguments, message):
    with pytest.raises(pliant.Error, match=message) as raised:
        pliant.Volume(**arguments)
    assert raised.value.code == "invalid_argument"
    assert "\n" not in str(raised.value)


def test_a_missing_file_is_named():
    with pytest.raises(pliant.Error, match="no such file") as raised:
        pliant.read_volume("missing.nrrd")
    assert raised.value.code == "not_found"
    assert pickle.loads(pickle.dumps(raised.value)).code == "not_found"


def test_points_and_voxels(rng):
    direction = random_direction(rng)
    spacing, origin = rng.uniform(0.5, 3, 3), rng.normal(size=3)
    volume = pliant.Volume(numpy.zeros((3, 4, 5)), spacing, origin, direction)
    ijk = rng.uniform(0, 2, 3)
    point = origin + direction @ (spacing * ijk)
    assert volume.world_from_voxel(ijk) == pytest.approx(point)
    assert volume.voxel_from_world(point) == pytest.approx(ijk)
    assert numpy.allclose(volume.direction, direction)


def test_simpleitk_agrees(rng):
    sitk = pytest.importorskip("SimpleITK")
    volume = pliant.Volume(
        rng.integers(-1000, 1000, (4, 5, 6)).astype(numpy.int16),
        (1, 2, 3),
        (4, 5, 6),
        random_direction(rng),
    )
    image = volume.to_sitk()
    assert image.GetPixelID() == sitk.sitkInt16
    point = volume.world_from_voxel((3, 2, 1))
    assert image.TransformIndexToPhysicalPoint((3, 2, 1)) == pytest.approx(point)
    assert image.GetPixel(3, 2, 1) == volume.array[1, 2, 3]
    back = pliant.Volume.from_sitk(image)
    del image
    gc.collect()
    assert (back.array == volume.array).all()
    assert not back.array.flags.owndata
    assert numpy.allclose(back.direction, volume.direction)


def test_nibabel_agrees(rng, tmp_path):
    nibabel = pytest.importorskip("nibabel")
    volume = pliant.Volume(
        rng.integers(-1000, 1000, (4, 5, 6)).astype(numpy.int16),
        (1, 2, 3),
        (4, 5, 6),
        random_direction(rng),
    )
    image = volume.to_nibabel()
    point = numpy.array(volume.world_from_voxel((3, 2, 1))) * (-1, -1, 1)
    assert image.affine @ (3, 2, 1, 1) == pytest.approx([*point, 1])
    back = pliant.Volume.from_nibabel(image)
    assert numpy.shares_memory(back.array, volume.array)
    assert back.origin_mm == pytest.approx(volume.origin_mm)
    volume.save(tmp_path / "scan.nii.gz")
    read = nibabel.load(tmp_path / "scan.nii.gz")
    assert numpy.allclose(read.affine, image.affine, atol=1e-5)
    assert (numpy.asarray(read.dataobj) == numpy.asarray(image.dataobj)).all()


def test_sheared_images_of_nibabel_are_straightened_as_files_are(rng, tmp_path):
    nibabel = pytest.importorskip("nibabel")
    affine = numpy.eye(4)
    affine[:3, :3] = random_direction(rng) @ [[1.5, 0, 0.4], [0, 0.7, 0], [0, 0, 2]]
    affine[:3, 3] = (5, -7, 11)
    values = rng.integers(-1000, 1000, (6, 5, 4)).astype(numpy.int16)
    image = nibabel.Nifti1Image(values, affine)
    with pytest.raises(pliant.Error) as caught:
        pliant.Volume.from_nibabel(image)
    assert str(caught.value) == (
        "affine: expected perpendicular axes (straighten=True resamples sheared ones), found axes "
        "sheared by 11.31 degrees"
    )
    nibabel.save(image, tmp_path / "sheared.nii")
    read = pliant.read_volume(tmp_path / "sheared.nii", straighten=True)
    found = pliant.Volume.from_nibabel(nibabel.load(tmp_path / "sheared.nii"), straighten=True)
    assert found.size == read.size != (6, 5, 4)
    assert numpy.allclose(found.direction, read.direction, atol=1e-6)
    assert found.origin_mm == pytest.approx(read.origin_mm, abs=1e-5)
    assert (numpy.abs(found.array.astype(float) - read.array) <= 1).all()  # rounding to whole ones
    straight = nibabel.Nifti1Image(values, numpy.diag([1, 2, 3, 1]))
    assert (pliant.Volume.from_nibabel(straight, straighten=True).array == values.T).all()


def test_series_of_a_folder_are_a_table(rng, tmp_path):
    sitk = pytest.importorskip("SimpleITK")
    for number, name, depth in ((2, "Lung 1.0 \xe4", 3), (7, "Bone", 5)):
        for k in range(depth):
            image = sitk.GetImageFromArray(rng.integers(0, 99, (1, 5, 4)).astype(numpy.int16))
            for tag, value in {
                "0008|0005": "ISO_IR 100", "0008|0060": "CT", "0008|103e": name,
                "0020|000d": "1.2.3", "0020|000e": f"1.2.3.{number}", "0020|0011": str(number),
                "0020|0013": str(k), "0008|0018": f"1.2.3.{number}.{k}",
            }.items():  # fmt: skip
                image.SetMetaData(tag, value)
            image.SetSpacing((0.25, 0.5, 2))
            image.SetOrigin((0, 0, 2 * k))
            writer = sitk.ImageFileWriter()
            writer.KeepOriginalImageUIDOn()
            writer.SetFileName(str(tmp_path / f"{number}_{k}.dcm"))
            writer.Execute(image)
    lung, bone = pliant.list_series(tmp_path)
    assert bone == {
        "number": "7", "description": "Bone", "modality": "CT", "slices": 5, "volumes": 1,
        "size": (4, 5, 5), "spacing_mm": (0.25, 0.5, 2.0), "uid": "1.2.3.7",
    }  # fmt: skip
    assert (lung["number"], lung["slices"]) == ("2", 3)
    assert lung["description"].startswith("Lung 1.0 ")
    assert pliant.read_volume(tmp_path, series_uid="7").size == bone["size"]
    with pytest.raises(pliant.Error, match="no_such"):
        pliant.list_series(tmp_path / "no_such")


def random_nifti_direction(rng):
    """No half turn nearly: within a float's rounding, readers differ in what they call one."""
    while True:
        direction = random_direction(rng)
        rotation = direction * [1, 1, numpy.linalg.det(direction)]
        if numpy.trace(rotation) > -0.999:
            return direction


def random_nifti(rng, kind, has_sform, has_qform):
    """An image whose sform and qform differ."""
    image = kind(rng.integers(-1000, 1000, (6, 5, 4)).astype(numpy.int16), None)
    for place, has in ((image.set_sform, has_sform), (image.set_qform, has_qform)):
        affine = numpy.eye(4)
        affine[:3, :3] = random_nifti_direction(rng) * numpy.exp(rng.uniform(-2, 2, 3))
        affine[:3, 3] = rng.normal(size=3) * 10.0 ** rng.integers(0, 4)
        place(affine, code=int(rng.integers(1, 5)) if has else 0)
    return image


@pytest.mark.parametrize("has_qform", [False, True])
@pytest.mark.parametrize("has_sform", [False, True])
@pytest.mark.parametrize("kind", ["Nifti1Image", "Nifti2Image"])
def test_nifti_is_placed_as_by_nibabel(kind, has_sform, has_qform, rng, tmp_path):
    nibabel = pytest.importorskip("nibabel")
    for _ in range(30):
        image = random_nifti(rng, getattr(nibabel, kind), has_sform, has_qform)
        nibabel.save(image, tmp_path / "scan.nii")
        read = nibabel.load(tmp_path / "scan.nii")
        found = pliant.read_volume(tmp_path / "scan.nii").to_nibabel()
        expected = read.affine
        if not (has_sform or has_qform):  # L, P and S from the first voxel; NiBabel centres it
            expected = numpy.diag([*read.header.get_zooms(), 1]) * [[-1], [-1], [1], [1]]
        assert found.affine == pytest.approx(expected, rel=1e-6, abs=1e-9)
        assert (numpy.asarray(found.dataobj) == numpy.asarray(read.dataobj)).all()


def test_files_and_copies_are_equal(airway, tmp_path):
    airway.save(tmp_path / "airway.nrrd")
    for other in (
        pliant.read_volume(tmp_path / "airway.nrrd"),
        pickle.loads(pickle.dumps(airway)),
        copy.deepcopy(airway),
    ):
        assert (other.array == airway.array).all()
        assert other.spacing_mm == airway.spacing_mm
        assert other.background == airway.background
        assert not numpy.shares_memory(other.array, airway.array)
