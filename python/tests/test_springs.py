# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Mass-spring networks, against formulas and against NumPy."""

import copy
import pickle
import gc

import numpy
import pytest

import pliant


def chain(count=5, stiffness=100.0):
    rest = [(0, 0, float(n)) for n in range(count)]
    links = [(n, n + 1) for n in range(count - 1)]
    return pliant.SpringParts(rest, links, stiffness=stiffness, node_damping=2.0, fixed=[0])


def link_forces(parts, positions):
    """Forces of the links on the nodes."""
    a, b = parts.links.T
    r = positions[a] - positions[b]
    length = numpy.linalg.norm(r, axis=1)
    rest = numpy.linalg.norm(parts.rest[a] - parts.rest[b], axis=1)
    pull = (parts.stiffness * (length - rest) / length)[:, None] * r
    forces = numpy.zeros_like(positions)
    numpy.add.at(forces, a, -pull)
    numpy.add.at(forces, b, pull)
    return forces


def test_a_chain_stretches_by_the_sum_of_its_springs():
    tissue = pliant.SpringTissue(chain(), threads=1)
    tissue.load([4], [(0, 0, 10)])
    tissue.find_equilibrium()
    assert tissue.displacements[:, 2] == pytest.approx(0.1 * numpy.arange(5), abs=1e-9)
    assert tissue.elastic_energy() == pytest.approx(4 * 0.5 * 100 * 0.1**2)
    tissue.reset()
    tissue.step(5000)
    assert tissue.displacements[4, 2] == pytest.approx(0.4, abs=1e-3)
    assert tissue.kinetic_energy() < 1e-4


def test_an_equilibrium_balances_all_forces(rng):
    parts = pliant.springs_of_lattice((4, 4, 4), stiffness=(300, 200, 100), node_damping=1)
    parts.fixed[:16] = True
    tissue = pliant.SpringTissue(parts, depth=20)
    force = rng.normal(size=3) * 5
    tissue.load([63], [force])
    tissue.find_equilibrium(1e-10)
    sums = link_forces(parts, tissue.positions)
    assert sums[63] == pytest.approx(-force, abs=1e-6)
    free = numpy.arange(16, 63)
    assert numpy.abs(sums[free]).max() < 1e-6
    assert tissue.folded_cells() == 0


def test_the_reaction_is_that_of_the_links(rng):
    parts = pliant.springs_of_lattice((3, 3, 3), stiffness=100)
    parts.fixed[:9] = True
    tissue = pliant.SpringTissue(parts)
    tissue.hold([25, 26])
    shift = rng.normal(size=3) * 0.1
    tissue.shift_held(shift)
    reaction = tissue.reaction([25, 26])
    expected = link_forces(parts, tissue.positions)[[25, 26]].sum(axis=0)
    assert reaction.force == pytest.approx(tuple(expected), abs=1e-9)
    eigenvalues = numpy.linalg.eigvalsh(reaction.stiffness)
    assert (eigenvalues < 0).all()
    h = 1e-6
    for axis in range(3):
        step = numpy.eye(3)[axis] * h
        tissue.shift_held(step)
        moved = numpy.array(tissue.reaction([25, 26]).force)
        tissue.shift_held(-step)
        assert (moved - expected) / h == pytest.approx(reaction.stiffness[:, axis], abs=1e-3)
    with pytest.raises(pliant.Error, match="law: expected held or relaxed, found free"):
        tissue.reaction([25], law="free")


def test_parts_are_views():
    parts = pliant.springs_of_lattice((3, 4, 5), spacing=(1, 2, 3), bulk=7.0)
    assert parts.rest.shape == (60, 3)
    assert parts.rest[-1].tolist() == [2, 6, 12]
    assert parts.cells.shape == (24, 8)
    assert (parts.bulk == 7).all()
    assert (parts.cell_node_count == 8).all()
    parts.stiffness[:] *= 2
    assert (parts.stiffness == 2).all()
    parts.fixed[[1, 3]] = True
    assert numpy.flatnonzero(parts.fixed).tolist() == [1, 3]
    other = copy.deepcopy(parts)
    other.mass[0] = 9
    assert parts.mass[0] == 1
    # Edges and face diagonals of a box of 2 x 3 x 4 cells.
    lengths = numpy.linalg.norm(
        parts.rest[parts.links[:, 0]] - parts.rest[parts.links[:, 1]], axis=1
    )
    assert parts.rest_length == pytest.approx(lengths)
    edges = 2 * 4 * 5 + 3 * 3 * 5 + 3 * 4 * 4
    diagonals = 2 * (2 * 3 * 5 + 2 * 4 * 4 + 3 * 3 * 4)
    assert len(parts.links) == edges + diagonals
    rest = parts.rest
    del parts
    gc.collect()
    assert rest[-1].tolist() == [2, 6, 12]


def test_builders_of_meshes():
    tetrahedra = pliant.TetMesh([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 1, 2, 3]])
    parts = pliant.springs_of_tetrahedra(tetrahedra, stiffness=5, density=6.0)
    assert len(parts.links) == 6
    assert parts.mass.sum() == pytest.approx(1)  # a sixth of the unit cube
    elastic = pliant.springs_of_elastic_tetrahedra(tetrahedra, stiffness=1000)
    lengths = numpy.linalg.norm(
        parts.rest[parts.links[:, 0]] - parts.rest[parts.links[:, 1]], axis=1
    )
    assert elastic.stiffness == pytest.approx(numpy.sqrt(2) / 5 * 1000 * lengths)
    hexahedra = pliant.hex_mesh((2, 2, 2))
    assert len(pliant.springs_of_hexahedra(hexahedra).links) == 12 + 12
    assert len(pliant.springs_of_triangles(pliant.boundary_triangles(tetrahedra)).links) == 6
    assert len(pliant.springs_of_sheet(3, 2).rest) >= 6
    stiffness, bulk = pliant.closed_form(15e3, 0.45, 2)
    shear = 15e3 / 2 / 1.45
    assert stiffness == pytest.approx(2 * shear)
    assert bulk == pytest.approx(15e3 * 0.45 / 1.45 / 0.1 - shear)


def test_transmittal_is_breadth_first():
    parts = pliant.springs_of_lattice((5, 5, 5), links="edges")
    nodes, layers = pliant.transmittal_order(parts, [62], 2)
    # In the middle of a lattice of edges: 1, 6, 18 nodes.
    assert numpy.diff(layers).tolist() == [1, 6, 18]
    distance = numpy.abs(parts.rest[nodes] - parts.rest[62]).sum(axis=1)
    assert (distance == numpy.repeat([0, 1, 2], [1, 6, 18])).all()
    parts.fixed[:25] = True
    depth, changes = pliant.find_depth(parts, [112], [(0, 0, 0.5)], threshold=1e-3)
    assert depth == len(changes)
    assert changes[-1] < 1e-3
    assert (changes[:-1] >= 1e-3).all()


def test_threads_cuts_and_errors():
    parts = pliant.springs_of_lattice((6, 6, 6), stiffness=50, bulk=20.0, node_damping=1)
    parts.fixed[:36] = True
    hashes = set()
    for threads in (1, 2):
        tissue = pliant.SpringTissue(parts, threads=threads)
        tissue.load([215], [(0, 0, -5)])
        report = tissue.step(50)
        assert report.steps == 50
        hashes.add(tissue.hash())
    assert len(hashes) == 1
    cut = tissue.cut_links(numpy.flatnonzero((parts.links == 215).any(axis=1)))
    assert cut.pieces == 2
    assert cut.loose_nodes == 1
    assert cut.cut_cells == 1
    bound = parts.stable_time_step()
    with pytest.raises(pliant.Error, match="time_step"):
        pliant.SpringTissue(parts, time_step=2 * bound)
    with pytest.raises(pliant.Error):
        tissue.load([0], [(0, 0, 1)])  # fixed
    with pytest.raises(pliant.Error, match="forces"):
        tissue.load([215], [(0, 1)])
    with pytest.raises(pliant.Error, match="fixed: expected nodes below 2"):
        pliant.SpringParts([(0, 0, 0), (1, 0, 0)], [(0, 1)], fixed=[2])
    with pytest.raises(pliant.Error, match="stiffness: expected 1 numbers"):
        pliant.SpringParts([(0, 0, 0), (1, 0, 0)], [(0, 1)], stiffness=[1, 2])
    raised = copy.copy(parts)
    count, share = raised.raise_masses(2 * bound)
    assert count > 0
    assert share == pytest.approx(raised.mass.sum() / parts.mass.sum() - 1)
    assert raised.stable_time_step() >= 2 * bound * 0.99


def test_a_network_moves_a_scan(airway, tmp_path):
    box = pliant.fill_surface(
        pliant.boundary_triangles(cube((-20, -20, -20), 40)), tetrahedra=500
    )
    parts = pliant.springs_of_elastic_tetrahedra(box, stiffness=5e3, density=1e-3)
    parts.fixed[parts.rest[:, 2] < -15] = True
    tissue = pliant.make_network(airway, parts)
    assert tissue.model == "network"
    report = tissue.push((0, 0, 12), (0, 0, -3), sphere_radius_mm=6)
    assert report.grabbed_elements > 0
    assert (tissue.volume().array != airway.array).any()
    with pytest.raises(pliant.Error, match="network: expected SpringParts or a NetworkFile"):
        pliant.make_network(airway, box)
    parts.stiffness[:] = 0  # of the caller, no longer of the network
    for again in (pickle.loads(pickle.dumps(tissue)), copy.deepcopy(tissue)):
        assert again.hash() == tissue.hash()
        assert (again.positions_mm() == tissue.positions_mm()).all()
        again.push((0, 0, 12), (1, 0, -1), sphere_radius_mm=6)
        assert (again.positions_mm() != tissue.positions_mm()).any()


def test_parts_are_pickled():
    nodes = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
    parts = pliant.SpringParts(
        nodes, [(0, 1), (1, 4), (2, 3)], mass=[1, 2, 3, 4, 5], fixed=[3], cells=[[0, 1, 2, 3]]
    )
    parts.branch_stiffness[:] = (0, 7, 8)
    parts.branch_time[:] = (0, 0.5, 0.25)
    for given in (parts, pliant.springs_of_lattice((3, 3, 3), bulk=2), pliant.SpringParts([], [])):
        again = pickle.loads(pickle.dumps(given))
        names = [n for n in dir(given) if isinstance(getattr(given, n), numpy.ndarray)]
        assert len(names) == 13
        for name in names:
            assert numpy.array_equal(getattr(again, name), getattr(given, name))


def cube(begin, side):
    mesh = pliant.hex_mesh((2, 2, 2), (side,) * 3, begin)
    c = mesh.cells[0]
    around = numpy.array([1, 2, 3, 7, 4, 5])  # of the diagonal from corner 0 to corner 6
    corners = [[0, a, b, 6] for a, b in zip(around, numpy.roll(around, -1), strict=True)]
    return pliant.TetMesh(mesh.nodes_mm, c[numpy.array(corners)])
