# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Large rotation of a cantilever, by felupe: the constants of tests/elastic/test_truth.cpp.

A bar of 96 x 12 x 12 mm of neo-Hookean material, W = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2,
E = 10 kPa, is clamped at x = 0. The middle row of its end, x = 96 and z = 6, is moved along z in
steps; its nodes are free along x, and along y but for the symmetry. Printed are the force of the
row on the bar, the displacement of the row's middle along x and z, and the rotation of the end
there, for two meshes of hexahedra with 27 nodes, which are smaller near the bar's ends.

    pip install felupe      # 11.3.0
    python cantilever.py
"""

import math

import felupe as fem
import numpy as np

LENGTH, WIDTH, MOVED = 96.0, 12.0, 32.0  # [mm]
YOUNG_MODULUS = 1e4  # [Pa]: forces in uN


# Nodes along the bar [mm].
ALONG = [0, 0.5, 1.5, 3, 5.5, 9, 14, 22, 34, 50, 66, 78, 86, 91, 94, 96]


def bend(nu, cells):
    """Bends half of the bar: y = 0 is its plane of symmetry."""
    mu = YOUNG_MODULUS / (2 * (1 + nu))
    lam = YOUNG_MODULUS * nu / ((1 + nu) * (1 - 2 * nu))
    mesh = fem.Cube(
        b=(len(ALONG) - 1, WIDTH / 2, WIDTH), n=(len(ALONG), cells // 2 + 1, cells + 1)
    )
    mesh.points[:, 0] = np.interp(mesh.points[:, 0], range(len(ALONG)), ALONG)
    mesh = fem.mesh.add_midpoints_edges(mesh)
    mesh = fem.mesh.add_midpoints_faces(mesh)
    mesh = fem.mesh.add_midpoints_volumes(mesh)
    region = fem.RegionTriQuadraticHexahedron(mesh)
    field = fem.FieldContainer([fem.Field(region, dim=3)])
    solid = fem.SolidBody(fem.NeoHookeCompressible(mu=mu, lmbda=lam), field)
    x, y, z = mesh.points.T
    row = np.isclose(x, LENGTH) & np.isclose(z, WIDTH / 2)
    fixed = {
        "base": fem.Boundary(field[0], fx=0),
        "symmetry": fem.Boundary(field[0], fy=0, skip=(1, 0, 1)),
        "row": fem.Boundary(field[0], mask=row, skip=(1, 1, 0)),
    }
    move = fem.math.linsteps([0, -MOVED], num=4)
    step = fem.Step([solid], ramp={fixed["row"]: move}, boundaries=fixed)
    fem.Job([step]).evaluate(verbose=0, tol=1e-9)
    u = field[0].values
    force = 2 * solid.assemble.vector(field).toarray().reshape(-1, 3)[row, 2].sum()
    middle = int(np.flatnonzero(row & np.isclose(y, 0))[0])
    top, low = (
        int(np.flatnonzero(np.isclose(x, LENGTH) & np.isclose(y, 0) & np.isclose(z, at))[0])
        for at in (WIDTH, 0)
    )
    side = u[top] - u[low]
    turn = math.degrees(math.atan2(side[0], WIDTH + side[2]))
    return force, u[middle], turn


def main():
    """Prints a line for each Poisson's ratio and mesh."""
    for nu in (0.3, 0.45):
        for cells in (4, 6):
            force, moved, turn = bend(nu, cells)
            print(
                f"nu {nu}, {cells} cells across: force {force:.2f} uN, "
                f"tip ({moved[0]:.4f}, {moved[2]:.4f}) mm, rotation {turn:.2f} degrees"
            )


if __name__ == "__main__":
    main()
