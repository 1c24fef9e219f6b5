# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A lattice's finite elements on the ranks of MPI.

    mpirun -n 2 python python/benchmarks/elastic_ranks.py [--nodes 70] [--repeat 5]

One JSON object: seconds to create the solver and to solve (medians), rank 0's share of a solve in
messages, and a hash of the solution, which is the same for any number of ranks.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import statistics
import time
from typing import Any

import numpy
from mpi4py import MPI

import pliant


class Timed:
    """A communicator that adds up the time in its calls."""

    def __init__(self, comm: Any) -> None:
        self.comm, self.seconds, self.calls, self.bytes = comm, 0.0, 0, 0

    def __getattr__(self, name: str) -> Any:
        function = getattr(self.comm, name)

        def timed(sent: Any, *rest: Any, **named: Any) -> Any:
            start = time.perf_counter()
            result = function(sent, *rest, **named)
            self.seconds += time.perf_counter() - start
            self.calls += 1
            self.bytes += 0 if name == "Recv" else sent.nbytes
            return result

        return function if name.startswith("Get") else timed


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--nodes", type=int, default=70, help="along each axis")
    parser.add_argument("--repeat", type=int, default=5)
    options = parser.parse_args()
    n = options.nodes
    world = MPI.COMM_WORLD
    comm = Timed(world)
    elastin = pliant.ElasticMaterial(young_modulus_pa=6e5, poisson_ratio=0.45)
    soft = elastin.replaced(young_modulus_pa=2e5)
    laws = (numpy.random.default_rng(0).random((n - 1) ** 3) < 0.3).astype(numpy.int32)
    lattice = pliant.HexLattice(size=(n, n, n))
    created, solved, waited = [], [], []
    for _ in range(options.repeat):
        world.Barrier()
        start = time.perf_counter()
        solver = pliant.ElasticSolver(
            lattice, [elastin, soft], numpy.arange(n * n), material_of=laws, threads=1,
            comm=comm if world.size > 1 else None,
        )  # fmt: skip
        created.append(time.perf_counter() - start)
        comm.seconds, comm.calls, comm.bytes = 0.0, 0, 0
        world.Barrier()
        start = time.perf_counter()
        solution = solver.solve(nodes=[n**3 - 1], forces_n=[(0.01, 0, -0.02)])
        world.Barrier()
        solved.append(time.perf_counter() - start)
        waited.append(comm.seconds)
    bits = hashlib.sha256(solution.displacement_mm.tobytes()).hexdigest()[:16]
    if len(set(world.allgather(bits))) > 1:
        raise SystemExit("the ranks' solutions differ")
    if world.rank == 0:
        print(
            json.dumps(
                {
                    "ranks": world.size,
                    "unknowns": 3 * n**3,
                    "create_s": round(statistics.median(created), 3),
                    "solve_s": round(statistics.median(solved), 3),
                    "messages_s": round(statistics.median(waited), 3),
                    "iterations": solution.iterations,
                    "calls": comm.calls,
                    "sent_mb": round(comm.bytes / 1e6, 2),
                    "solution": bits,
                }
            )
        )


if __name__ == "__main__":
    main()
