# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A large push in a block, by felupe: the constants of tests/elastic/test_truth.cpp.

The block has 25 x 25 x 17 nodes, 1 mm apart, and is held at z = 0. The nodes in a sphere of 3.9 mm
around (12, 12, 11) are moved by (2.4, 1.2, -2.8) mm: by its radius. A node within 4 mm of
(19, 12, 8) has 50 kPa, others have 10 kPa, and a cell has the mean of its nodes. Cells have one
pressure and one dilatation each (Simo, Taylor and Pister 1985), with
W = mu/2 (tr C' - 3) + K/2 (J - 1)^2. Printed are the force of the sphere's nodes on the block and
the displacement of some nodes.

    pip install felupe      # 11.3.0
    python pushed_block.py
"""

import felupe as fem
import numpy as np

NODES = (25, 25, 17)
CENTRE, RADIUS, PUSH = (12, 12, 11), 3.9, (2.4, 1.2, -2.8)  # [mm]
STIFF, STIFF_RADIUS = (19, 12, 8), 4.0  # [mm]
PROBES = [(12, 12, 16), (17, 12, 11), (12, 12, 6), (19, 12, 8), (12, 18, 12), (7, 12, 11),
          (12, 5, 14), (16, 16, 14), (22, 12, 12), (12, 12, 3)]  # fmt: skip


def push(nu):
    """Pushes the block; returns the force [uN] and a function from a node to its displacement."""
    mesh = fem.Cube(b=tuple(n - 1 for n in NODES), n=NODES)
    field = fem.FieldContainer([fem.Field(fem.RegionHexahedron(mesh), dim=3)])
    x = mesh.points
    kpa = np.where(np.linalg.norm(x - STIFF, axis=1) <= STIFF_RADIUS, 50.0, 10.0)
    young_modulus = 1e3 * kpa[mesh.cells].mean(axis=1)
    mu = young_modulus / (2 * (1 + nu))
    law = fem.NeoHooke(mu=mu[None, :])
    law.chunksize = None  # all cells at once: each has its modulus
    solid = fem.SolidBodyNearlyIncompressible(law, field, bulk=young_modulus / (3 * (1 - 2 * nu)))
    ball = np.linalg.norm(x - CENTRE, axis=1) <= RADIUS
    fixed = {"base": fem.Boundary(field[0], fz=0)}
    for axis, name in enumerate("xyz"):
        skip = tuple(int(a != axis) for a in range(3))
        fixed[name] = fem.Boundary(field[0], mask=ball, skip=skip)
    ramp = {
        fixed[name]: fem.math.linsteps([0, PUSH[axis]], num=4) for axis, name in enumerate("xyz")
    }
    fem.Job([fem.Step([solid], ramp=ramp, boundaries=fixed)]).evaluate(verbose=0, tol=1e-7)
    u = field[0].values
    force = solid.assemble.vector(field).toarray().reshape(-1, 3)[ball].sum(axis=0)
    return force, lambda node: u[np.flatnonzero(np.all(np.isclose(x, node), axis=1))[0]]


def main():
    """Prints the constants for each Poisson's ratio."""
    for nu in (0.3, 0.45, 0.49):
        force, moved = push(nu)
        print(f"nu {nu}: force ({force[0]:.0f}, {force[1]:.0f}, {force[2]:.0f}) uN")
        for node in PROBES:
            print(f"  {node}: ({', '.join(f'{v:.4f}' for v in moved(node))})")


if __name__ == "__main__":
    main()
