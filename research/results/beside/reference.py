# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Converged solutions by felupe: a quarter of the block, 27-node hexahedra, graded meshes.

    python reference.py block NU     # writes reference-block-NU.npz

W = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2.
"""

import sys

from common import relative  # sets the number of threads

import felupe as fem
import numpy as np
from pypardiso import spsolve

import block


def box_of(x, y, z):
    """27-node hexahedra with the given corner coordinates."""
    mesh = fem.Cube(b=(len(x) - 1, len(y) - 1, len(z) - 1), n=(len(x), len(y), len(z)))
    for axis, lines in enumerate((x, y, z)):
        mesh.points[:, axis] = np.interp(mesh.points[:, axis], range(len(lines)), lines)
    mesh = fem.mesh.add_midpoints_edges(mesh)
    mesh = fem.mesh.add_midpoints_faces(mesh)
    return fem.mesh.add_midpoints_volumes(mesh)


def lame(young, nu):
    """Lame's constants."""
    return young / (2 * (1 + nu)), young * nu / ((1 + nu) * (1 - 2 * nu))


def pressed(nu, depths, x, z):
    """A quarter of the block; x and z from the patch's centre and from the bottom."""
    mesh = box_of(x, x, z)
    field = fem.FieldContainer([fem.Field(fem.RegionTriQuadraticHexahedron(mesh), dim=3)])
    mu, lam = lame(block.YOUNG_PA, nu)
    solid = fem.SolidBody(fem.NeoHookeCompressible(mu=mu, lmbda=lam), field)
    px, py, pz = mesh.points.T
    half = block.PATCH_MM / 2 + 1e-9
    top = np.isclose(pz, block.SIZE_MM[2]) & (px <= half) & (py <= half)
    fixed = {
        "bottom": fem.Boundary(field[0], fz=0),
        "x": fem.Boundary(field[0], fx=0, skip=(0, 1, 1)),
        "y": fem.Boundary(field[0], fy=0, skip=(1, 0, 1)),
        "patch": fem.Boundary(field[0], mask=top, skip=(0, 0, 1)),
        "down": fem.Boundary(field[0], mask=top, skip=(1, 1, 0)),
    }
    found = []
    ramp = np.sort(np.r_[depths, 0.6, 1, 1.5, 2, 2.5])
    step = fem.Step([solid], ramp={fixed["down"]: -ramp}, boundaries=fixed)
    for depth, _ in zip(ramp, step.generate(x0=field, verbose=0, tol=1e-4, solver=spsolve)):
        if depth in depths:
            found.append(field[0].values.copy())
    return mesh.points, found


class Interpolation:
    """Triquadratic interpolation in a graded lattice: the elements' own shape functions."""

    def __init__(self, x, y, z, points, values):
        lines = [np.sort(np.concatenate([c, (c[1:] + c[:-1]) / 2])) for c in (x, y, z)]
        index = [np.abs(p[:, None] - c).argmin(axis=1) for p, c in zip(points.T, lines)]
        self.corners = (x, y, z)
        self.grid = np.zeros([len(c) for c in lines] + [3])
        self.grid[tuple(index)] = values

    def __call__(self, at):
        weights, first = [], []
        for p, c in zip(at.T, self.corners):
            cell = np.clip(np.searchsorted(c, p) - 1, 0, len(c) - 2)
            r = 2 * (p - c[cell]) / (c[cell + 1] - c[cell]) - 1
            weights.append(np.stack([r * (r - 1) / 2, 1 - r * r, r * (r + 1) / 2]))
            first.append(2 * cell)
        out = np.zeros((len(at), 3))
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    w = weights[0][i] * weights[1][j] * weights[2][k]
                    out += w[:, None] * self.grid[first[0] + i, first[1] + j, first[2] + k]
        return out


# Corners of two meshes: from the patch's middle, and from the bottom.
BLOCK_X = ([0, 5, 8.75, 10, 11.25, 15, 22, 30], [0, 3, 6, 8.2, 9.4, 10, 10.6, 12, 15, 20, 30])
BLOCK_Z = ([0, 8, 16, 22, 26, 28.75, 30], [0, 6, 12, 18, 22.5, 26, 28.4, 29.4, 30])


def block_references():
    """Displacements at the sample points for all cases, and the difference of two meshes."""
    middle = np.array([*block.SIZE_MM[:2], 0]) / 2
    at = block.SAMPLES - middle
    sign = np.where(at < 0, -1.0, 1.0) * [1, 1, 0] + [0, 0, 1]

    def solve(nu, fine):
        x, z = np.array(BLOCK_X[fine], float), np.array(BLOCK_Z[fine], float)
        points, found = pressed(nu, block.DEPTHS_MM, x, z)
        return [Interpolation(x, x, z, points, u)(np.abs(at)) * sign for u in found]

    nu = float(sys.argv[2])
    coarse, fine = (solve(nu, f) for f in (False, True))
    out = {}
    for depth, a, b in zip(block.DEPTHS_MM, coarse, fine, strict=True):
        print(f"nu {nu}, {depth} mm: meshes differ by {relative(a, b):.3f} %", flush=True)
        out[str(depth)] = b
    np.savez(f"reference-block-{nu}.npz", **out)


if __name__ == "__main__":
    {"block": block_references}[sys.argv[1]]()
