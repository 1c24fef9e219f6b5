# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Organs: scenes of files, bodies that push each other, meshes as arrays."""

import copy
import gc
import pickle

import numpy
import pytest

import pliant
from test_springs import cube

TWO = """
[organs]
tetrahedra = 2000

[[body]]
name = "left"
mesh = "left.vtu"
held_mm = [[-1, -1, -1], [1, 21, 21]]

[[body]]
name = "right"
mesh = "right.stl"
young_modulus_pa = 30000
held_mm = [[39, -1, -1], [42, 21, 21]]
"""


@pytest.fixture
def two(tmp_path):
    """Two blocks of 20 mm, half a millimetre apart, each held at its far side."""
    left = pliant.fill_surface(
        pliant.boundary_triangles(cube((0, 0, 0), 20)), tetrahedra=2000
    )
    left.save(tmp_path / "left.vtu")
    pliant.boundary_triangles(cube((20.5, 0, 0), 20)).save(tmp_path / "right.stl")
    (tmp_path / "two.toml").write_text(TWO)
    return tmp_path / "two.toml"


def volume_of(mesh):
    edges = mesh.nodes_mm[mesh.cells[:, 1:]] - mesh.nodes_mm[mesh.cells[:, :1]]
    return numpy.linalg.det(edges) / 6


def test_a_scene_file_has_names_meshes_and_settings(two):
    organs = pliant.make_organs(two)
    assert [organ.name for organ in organs.organs] == ["left", "right"]
    left, right = organs.organs
    assert right.settings["young_modulus_pa"] == 30000
    assert left.settings["young_modulus_pa"] == 15000
    assert volume_of(left.mesh).sum() == pytest.approx(8000, rel=0.05)
    assert volume_of(right.mesh).sum() == pytest.approx(8000, rel=0.05)
    assert right.mesh.nodes_mm.min(axis=0) == pytest.approx((20.5, 0, 0), abs=0.1)
    assert organs.labels is None
    assert organs.settings["sub_steps"] == 10
    assert pliant.make_organs(two, sub_steps=20).settings["sub_steps"] == 20
    inside = organs.scan.voxel_from_world((10, 10, 10))
    assert organs.scan.array[tuple(numpy.rint(inside).astype(int)[::-1])] > -500
    nodes = left.mesh.nodes_mm
    shape = nodes.copy()
    del organs, left, right
    gc.collect()
    assert (nodes == shape).all()


def test_a_pushed_body_pushes_the_other(two):
    organs = pliant.make_organs(two)
    hashes = set()
    for threads in (1, 2):
        tissue = organs.make_tissue(threads=threads)
        rest = organs.meshes(tissue)
        for mesh, organ in zip(rest, organs.organs, strict=True):
            assert mesh.nodes_mm == pytest.approx(organ.mesh.nodes_mm, abs=1e-5)
        report = tissue.push((17, 10, 10), (3, 0, 0), sphere_radius_mm=5)
        assert report.status in ("applied", "limited")
        tissue.advance(max_steps=20)
        hashes.add(tissue.hash())
        left, right = organs.meshes(tissue)
        assert (left.nodes_mm - rest[0].nodes_mm)[:, 0].max() > 1.5
        moved = (right.nodes_mm - rest[1].nodes_mm)[:, 0]
        assert moved.max() > 0.5
        assert (volume_of(left) > 0).all()
        force = tissue.force_n()
        assert force is not None
        assert force[0] < 0
    assert len(hashes) == 1
    positions = tissue.positions_mm()
    assert (positions == numpy.concatenate([left.nodes_mm, right.nodes_mm])).all()
    assert (tissue.volume().array != organs.scan.array).any()
    del organs
    gc.collect()
    tissue.reset()
    assert tissue.positions_mm() == pytest.approx(rest_positions(rest), abs=1e-5)
    assert tissue.scan.size[0] > 10


def rest_positions(meshes):
    return numpy.concatenate([mesh.nodes_mm for mesh in meshes])


def test_bodies_are_cut(two):
    organs = pliant.make_organs(two)
    tissue = organs.make_tissue()
    assert tissue.cut_mesh() is None
    count = len(tissue.positions_mm())
    report = tissue.cut([(10, -5, 25), (10, 25, 25)], (0, 0, -15))
    assert report.cut_links > 0
    mesh = tissue.cut_mesh()
    assert len(mesh.nodes_mm) > count
    assert (mesh.nodes_mm == tissue.positions_mm()).all()
    assert len(organs.meshes(tissue)) == 2


def test_one_mesh_lies_on_its_back(tmp_path):
    pliant.boundary_triangles(cube((0, 0, 0), 20)).save(tmp_path / "block.stl")
    organs = pliant.make_organs(tmp_path / "block.stl", tetrahedra=1000)
    assert len(organs.organs) == 1
    tissue = organs.make_tissue()
    tissue.push((10, 4, 10), (0, 0, 3), sphere_radius_mm=5)
    tissue.advance(max_steps=30)
    moved = tissue.positions_mm() - organs.organs[0].mesh.nodes_mm
    back = organs.organs[0].mesh.nodes_mm[:, 1] > 19
    assert back.any()
    assert numpy.abs(moved[back]).max() < 1e-5  # floats
    assert numpy.abs(moved).max() > 1


def test_labels_become_bodies(tmp_path):
    k, j, i = numpy.meshgrid(*(numpy.arange(40),) * 3, indexing="ij")
    values = numpy.full((40, 40, 40), 20, numpy.int16)
    labels = numpy.zeros((40, 40, 40), numpy.int16)
    ball = (i - 20) ** 2 + (j - 20) ** 2 + (k - 20) ** 2 < 100
    values[ball] = 80
    labels[ball] = 5
    grid = {"spacing_mm": (2, 2, 2)}
    pliant.Volume(values, **grid).save(tmp_path / "ct.nrrd")
    pliant.Volume(labels, **grid).save(tmp_path / "labels.nrrd")
    (tmp_path / "labels.json").write_text('{"5": "liver"}')
    files = (tmp_path / "ct.nrrd", tmp_path / "labels.nrrd")
    organs = pliant.make_organs_of_labels(*files, [5], tetrahedra=3000)
    assert organs.organs[0].name == "liver"
    assert len(organs.organs) == 2  # and the tissue around it
    assert volume_of(organs.organs[0].mesh).sum() == pytest.approx(8 * ball.sum(), rel=0.1)
    assert (organs.labels.array == labels).all()
    again = pickle.loads(pickle.dumps(organs))
    assert (again.labels.array == organs.labels.array).all()
    assert again.make_tissue().hash() == organs.make_tissue().hash()
    alone = pliant.make_organs_of_labels(*files, [5], tetrahedra=3000, surroundings=False)
    assert len(alone.organs) == 1
    with pytest.raises(pliant.Error, match="9"):
        pliant.make_organs_of_labels(*files, [9])


def test_bad_files_are_named(two, airway):
    with pytest.raises(pliant.Error, match="missing.toml"):
        pliant.make_organs("missing.toml")
    with pytest.raises(pliant.Error, match="sub_stepz"):
        pliant.make_organs(two, sub_stepz=1)
    two.write_text(TWO.replace("left.vtu", "gone.vtu"))
    with pytest.raises(pliant.Error, match="gone.vtu"):
        pliant.make_organs(two)
    with pytest.raises(pliant.Error, match="nodes of a mesh") as raised:
        pliant.make_chainmail(airway).positions_mm()
    assert raised.value.code == "unsupported"


def test_organs_and_their_tissues_are_pickled(two):
    organs = pliant.make_organs(two, sub_steps=7)
    again = pickle.loads(pickle.dumps(organs))
    assert again.hash() == organs.hash()
    assert again.settings == organs.settings
    assert (again.scan.array == organs.scan.array).all()
    assert again.labels is None
    for one, other in zip(again.organs, organs.organs, strict=True):
        assert (one.name, one.settings) == (other.name, other.settings)
        assert (one.mesh.nodes_mm == other.mesh.nodes_mm).all()
        assert (one.mesh.cells == other.mesh.cells).all()
    tissue = organs.make_tissue(threads=1)
    tissue.push((10, 10, 20), (0, 0, -3), sphere_radius_mm=4)
    for same in (pickle.loads(pickle.dumps(tissue)), copy.deepcopy(tissue)):
        assert same.hash() == tissue.hash()
        assert (same.positions_mm() == tissue.positions_mm()).all()
        assert len(organs.meshes(same)) == 2
