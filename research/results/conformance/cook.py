# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Cook's membrane with hyperelastic laws: converged solutions by felupe.

    python cook.py

The panel's corners are (0, 0), (48, 44), (48, 60), (0, 44) mm; mu = 0.4225 MPa, nu = 0.3. The end
at x = 0 is held whole. The end at x = 48 is drawn up by 62.5 kPa of its area at rest, a dead load.
Prints the way of the corner (48, 60): in plane strain by the isochoric law and by that of Pliant's
bodies, and by the latter 8 mm thick with free faces, where it is the corner's at half of the
thickness. Found with felupe 11.3.0 (../beside/requirements.txt): 13.78, 13.59 and, with 4, 6, 9 and
12 cells along each edge, 14.114, 14.154, 14.165 and 14.167 mm.
"""

from laws import body_law, graded, isochoric_law, lattice, shares

import felupe as fem
import numpy as np
from pypardiso import spsolve

NU, TRACTION_MPA, THICK_MM = 0.3, 0.0625, 8.0
YOUNG_MPA = 2 * 0.4225 * (1 + NU)


def moved(law, cells, half_thickness=None):
    """Way of the corner [mm]."""
    along, across = graded(cells[0], 1.5), np.linspace(0, 1, cells[1] + 1)
    across = 0.5 - 0.5 * np.cos(np.pi * across)
    lines = [along, across]
    if half_thickness:  # denser at the free face
        lines.append(half_thickness * (1 - graded(cells[2], 1.5)[::-1]))
    mesh = lattice(*lines)
    u, v = mesh.points[:, 0].copy(), mesh.points[:, 1].copy()
    mesh.points[:, 0] = 48 * u
    mesh.points[:, 1] = 44 * u * (1 - v) + (44 + 16 * u) * v
    if half_thickness:
        field = fem.FieldContainer([fem.Field(fem.RegionTriQuadraticHexahedron(mesh), dim=3)])
    else:
        field = fem.FieldContainer([fem.FieldPlaneStrain(fem.RegionBiQuadraticQuad(mesh), dim=2)])
    end = np.flatnonzero(u > 1 - 1e-9)
    heights = np.unique(np.round(mesh.points[end, 1], 9))
    weights = shares(heights)[np.searchsorted(heights, np.round(mesh.points[end, 1], 9))]
    if half_thickness:
        depths = np.unique(np.round(mesh.points[end, 2], 9))
        weights *= shares(depths)[np.searchsorted(depths, np.round(mesh.points[end, 2], 9))]
    load = fem.PointLoad(field, end)
    fixed = {"clamp": fem.Boundary(field[0], fx=0)}
    if half_thickness:
        fixed["middle"] = fem.Boundary(field[0], fz=0, skip=(1, 1, 0))
    forces = np.zeros((len(end), mesh.dim))
    forces[:, 1] = TRACTION_MPA * weights
    steps = [forces * n / 8 for n in range(1, 9)]
    step = fem.Step([fem.SolidBody(law, field), load], ramp={load: steps}, boundaries=fixed)
    fem.Job([step]).evaluate(verbose=0, tol=1e-6, solver=spsolve)
    at = np.argmin(np.linalg.norm(mesh.points - np.array([48, 60, 0])[: mesh.dim], axis=1))
    return field[0].values[at, 1]


if __name__ == "__main__":
    for name, law in (("isochoric", isochoric_law), ("bodies", body_law)):
        for n in (8, 16, 32):
            way = moved(law(YOUNG_MPA, NU), (n, n))
            print(f"plane strain, {name}, {n} x {n}: {way:.4f} mm", flush=True)
    for n in (4, 6, 9, 12):
        cells = (n, n, max(2, n // 3))
        way = moved(body_law(YOUNG_MPA, NU), cells, THICK_MM / 2)
        print(f"8 mm thick, bodies, {cells[0]} x {cells[1]} x {cells[2]}: {way:.4f} mm", flush=True)
