# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Two equal elastic spheres that are pressed together: converged solutions by felupe.

    python spheres.py

Radius 10 mm, E = 1 MPa, nu = 0.3, the law of Pliant's bodies, no friction. By symmetry a hemisphere
against a rigid plane: its flat face is held whole, as by a plate, and nears the plane by a given
way. Quadratic cells with axial symmetry; nodes touch the plane where it bears a pressure. Found
with felupe 11.3.0 (../beside/requirements.txt) and 8, 16 and 32 cells: 0.1563, 0.1540 and 0.1542 N
for 0.1 mm, where Hertz has 0.1465; 18.12, 18.09 and 18.05 N for 2 mm.
"""

from laws import body_law, lattice

import felupe as fem
import numpy as np
from pypardiso import spsolve

RADIUS_MM, YOUNG_MPA, NU = 10.0, 1.0, 0.3
WAYS_MM = (0.1, 0.2, 0.5, 1.0, 1.5, 2.0)


def hertz(way):
    """Force [N]."""
    return 4 / 3 * YOUNG_MPA / (1 - NU**2) * RADIUS_MM**0.5 * way**1.5


def forces(count, ways):
    """Force [N] for each way, with count cells along the axis."""
    line = np.linspace(0, 1, count + 1) ** 1.7
    # A rectangle, bent to a quarter of a disc: the axis along x, the radius along y, the pole at
    # x = -1 with the smallest cells.
    mesh = lattice(line - 1, line)
    u, v = mesh.points.T.copy()
    most = np.maximum(np.abs(u), np.abs(v))
    norm = np.hypot(u, v)
    scale = np.where(norm > 0, most / np.where(norm > 0, norm, 1), 1) * RADIUS_MM
    mesh.points[:] = np.c_[u * scale, v * scale]
    region = fem.RegionBiQuadraticQuad(mesh)
    field = fem.FieldContainer([fem.FieldAxisymmetric(region, dim=2)])
    solid = fem.SolidBody(body_law(YOUNG_MPA, NU), field)
    x = mesh.points
    surface = np.flatnonzero(np.isclose(most, 1) & (x[:, 0] < -0.3 * RADIUS_MM))
    pole = surface[np.argmin(x[surface, 1])]
    found = []
    touching = {int(pole)}
    for way in ways:
        plane = -RADIUS_MM + way
        for _ in range(60):
            nodes = np.array(sorted(touching))
            is_node = np.isin(np.arange(len(x)), nodes)
            held = fem.Boundary(field[0], mask=is_node, skip=(0, 1))
            fixed = {
                "plate": fem.Boundary(field[0], mask=np.isclose(x[:, 0], 0)),
                "axis": fem.Boundary(field[0], mask=np.isclose(x[:, 1], 0), skip=(1, 0)),
                "touch": held,
            }
            order = held.points
            fixed["touch"].value = plane - x[order, 0]
            dof0, dof1 = fem.dof.partition(field, fixed)
            ext0 = fem.dof.apply(field, fixed, dof0)
            result = fem.newtonraphson(
                items=[solid], dof0=dof0, dof1=dof1, ext0=ext0, verbose=0, tol=1e-6, solver=spsolve
            )
            assert result.success
            force = solid.results.force.toarray().reshape(-1, 2)[:, 0]
            inside = surface[x[surface, 0] + field[0].values[surface, 0] < plane - 1e-9]
            pulls = {int(n) for n in nodes if force[n] < 0 and n != pole}
            new = (touching | {int(n) for n in inside}) - pulls
            if new == touching:
                break
            touching = new
        else:
            print("the touching nodes alternate")
        touch = max(x[n, 1] + field[0].values[n, 1] for n in touching)
        found.append((force[np.array(sorted(touching))].sum(), touch))
    return found


if __name__ == "__main__":
    for count in (8, 16, 32):
        for way, (force, touch) in zip(WAYS_MM, forces(count, WAYS_MM)):
            print(
                f"{count} cells, {way} mm: {force:.6f} N, contact radius {touch:.3f} mm, "
                f"Hertz {hertz(way):.6f} N",
                flush=True,
            )
