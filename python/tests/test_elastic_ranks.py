# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Finite elements of a lattice, alone and on ranks that are threads. tests/large has mpirun."""

import queue
import threading

import numpy
import pytest

import pliant

SOFT = pliant.ElasticMaterial(young_modulus_pa=1e4, poisson_ratio=0.4, density_kg_per_m3=1000)
HARD = SOFT.replaced(young_modulus_pa=5e4)


class Comm:
    """The functions of mpi4py's communicators that are needed, between threads."""

    def __init__(self, rank, shared):
        self.rank, self.shared = rank, shared

    def Get_rank(self):
        return self.rank

    def Get_size(self):
        return len(self.shared["all"])

    def Send(self, sent, dest):
        self.shared["mail"][self.rank, dest].put(numpy.array(sent))

    def Recv(self, received, source):
        received[:] = self.shared["mail"][source, self.rank].get(timeout=60)

    def Sendrecv(self, sent, dest, recvbuf, source):
        self.Send(sent, dest)
        self.Recv(recvbuf, source)

    def Allgatherv(self, mine, received):
        everything, counts = received
        assert len(mine) == counts[self.rank]
        self.shared["all"][self.rank] = numpy.array(mine)
        self.shared["barrier"].wait(60)
        everything[:] = numpy.concatenate(self.shared["all"])
        self.shared["barrier"].wait(60)


def comms(count):
    shared = {
        "mail": {(a, b): queue.Queue() for a in range(count) for b in range(count)},
        "all": [None] * count,
        "barrier": threading.Barrier(count),
    }
    return [Comm(rank, shared) for rank in range(count)]


def solved(size, comm=None):
    lattice = pliant.HexLattice(size=size, spacing_mm=(1, 1.5, 1))
    cells = (size[0] - 1) * (size[1] - 1) * (size[2] - 1)
    hard = (numpy.arange(cells) % 7 == 0).astype(numpy.int32)
    solver = pliant.ElasticSolver(
        lattice, [SOFT, HARD], numpy.arange(size[0] * size[1]), material_of=hard, comm=comm,
        threads=1,
    )  # fmt: skip
    return solver.solve(gravity_m_per_s2=(1, 0, -9.81))


def test_a_lattice_is_its_mesh():
    size = (5, 4, 6)
    mesh = pliant.hex_mesh(size, (1, 1.5, 1))
    hard = (numpy.arange(4 * 3 * 5) % 7 == 0).astype(numpy.int32)
    expected = pliant.ElasticSolver(
        mesh, [SOFT, HARD], numpy.arange(20), material_of=hard
    ).solve(gravity_m_per_s2=(1, 0, -9.81))
    found = solved(size)
    assert found.iterations > 0
    scale = numpy.abs(expected.displacement_mm).max()
    assert numpy.abs(found.displacement_mm - expected.displacement_mm).max() < 1e-6 * scale


def test_ranks_give_the_bits_of_one_process():
    size = (16, 17, 40)
    expected = solved(size)
    for count in (2, 3):
        found = [None] * count
        group = comms(count)
        sent = []

        def send(numbers, dest, rank_0=group[0]):
            sent.append(len(numbers))
            Comm.Send(rank_0, numbers, dest)

        group[0].Send = send

        def work(rank):
            found[rank] = solved(size, group[rank])

        threads = [threading.Thread(target=work, args=(n,)) for n in range(count)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for one in found:
            assert (one.displacement_mm == expected.displacement_mm).all()
            assert (one.reaction_n == expected.reaction_n).all()
            assert one.strain_energy_j == expected.strain_energy_j
            assert one.iterations == expected.iterations
        assert 3 * 16 * 17 in sent or count > 2, "planes were exchanged"


def test_an_error_of_the_communicator_is_raised():
    class Lost(Comm):
        def Recv(self, received, source):
            raise ConnectionError("rank 1 is gone")

    with pytest.raises(ConnectionError, match="rank 1 is gone"):
        solved((16, 17, 40), Lost(0, comms(2)[0].shared))


def test_other_objects_and_meshes_are_refused():
    with pytest.raises(pliant.Error, match="comm: expected a communicator of mpi4py"):
        solved((4, 4, 4), "world")
    with pytest.raises(pliant.Error, match="comm: expected with a HexLattice only"):
        pliant.ElasticSolver(pliant.hex_mesh((3, 3, 3)), SOFT, [0, 1, 2, 3], comm=comms(1)[0])
    with pytest.raises(pliant.Error, match="mesh: expected a HexMesh or a HexLattice"):
        pliant.ElasticSolver(3, SOFT, [0, 1, 2, 3])
    with pytest.raises(pliant.Error, match="method: a lattice"):
        pliant.ElasticSolver(
            pliant.HexLattice(size=(3, 3, 3)), SOFT, numpy.arange(9), method="cholesky"
        )
