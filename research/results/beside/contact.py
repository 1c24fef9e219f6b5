# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A rigid ball of radius 15 mm, without friction, pressed 3 mm deep into the block of block.py.

    python contact.py        # with its reference; writes contact.json

E = 5 kPa, nu = 0.3; the block is 60 x 60 x 30 mm and held at its bottom. The reference is felupe's:
a quarter of the block with 27-node hexahedra, and the contact with a sphere of its documentation.
"""

import os

from common import (  # sets the number of threads
    Clock,
    Variant,
    compare,
    lattice,
    relative,
    sample,
    table,
    to_lattice,
)

import felupe as fem
import numpy as np
from block import SAMPLES, SIZE_MM, YOUNG_PA, cells_of
from pypardiso import spsolve

NU, RADIUS_MM, DEPTH_MM = 0.3, 15.0, 3.0
MIDDLE = np.array([*SIZE_MM[:2] / 2, SIZE_MM[2]])


class Sphere(fem.mechanics.ContactRigidBase):
    """Contact of points with a rigid sphere, by penalty."""

    def __init__(self, field, points, centerpoint, **kwargs):
        super().__init__(field, points, centerpoint, **kwargs)

    def _kinematics(self, dx):
        distance = np.linalg.norm(dx, axis=1)
        normal = dx / distance[:, None]
        curvature = np.eye(3) - normal[:, :, None] * normal[:, None, :]
        return distance - RADIUS_MM, normal, curvature / distance[:, None, None]


def pressed(mesh, region, centre, steps, quarter, tol):
    """Prepares; returns a function that solves and returns the displacement."""
    count = len(mesh.points)
    mesh.add_points([*centre[:2], centre[2] + RADIUS_MM])
    field = fem.FieldContainer([fem.Field(region(mesh), dim=3)])
    mu = YOUNG_PA / (2 * (1 + NU))
    law = fem.NeoHookeCompressible(mu=mu, lmbda=2 * mu * NU / (1 - 2 * NU))
    solid = fem.SolidBody(law, field)
    x = mesh.points[:count]
    near = np.linalg.norm(x[:, :2] - centre[:2], axis=1) < 11
    top = np.flatnonzero(np.isclose(x[:, 2], SIZE_MM[2]) & near)
    contact = Sphere(field, top, -1, multiplier=10.0, items=[solid])
    is_centre = np.arange(count + 1) == count
    fixed = {
        "bottom": fem.Boundary(field[0], fz=0),
        "centre": fem.Boundary(field[0], mask=is_centre, skip=(0, 0, 1)),
        "down": fem.Boundary(field[0], mask=is_centre, skip=(1, 1, 0)),
    }
    if quarter:
        fixed["x"] = fem.Boundary(field[0], fx=0, skip=(0, 1, 1))
        fixed["y"] = fem.Boundary(field[0], fy=0, skip=(1, 0, 1))

    def solve():
        ramp = {fixed["down"]: fem.math.linsteps([0, -DEPTH_MM], num=steps)[1:]}
        step = fem.Step([solid, contact], ramp=ramp, boundaries=fixed)
        fem.Job([step]).evaluate(verbose=0, tol=tol, solver=spsolve)
        return field[0].values[:count]

    return solve


def reference():
    """Displacements at the samples [mm]; prints the difference of two meshes."""
    from reference import Interpolation, box_of

    at = SAMPLES - [*MIDDLE[:2], 0]
    sign = np.where(at < 0, -1.0, 1.0) * [1, 1, 0] + [0, 0, 1]
    found = []
    for x, z in (
        ([0, 2.5, 5, 7.5, 10, 14, 20, 30], [0, 10, 18, 24, 27.5, 30]),
        ([0, 1.25, 2.5, 3.75, 5, 6.25, 7.5, 10, 14, 20, 30], [0, 9, 16, 21, 25, 28, 30]),
    ):
        x, z = np.array(x, float), np.array(z, float)
        mesh = box_of(x, x, z)
        points = mesh.points.copy()
        region = fem.RegionTriQuadraticHexahedron
        u = pressed(mesh, region, np.array([0, 0, SIZE_MM[2]]), 7, True, 1e-4)()
        found.append(Interpolation(x, x, z, points, u)(np.abs(at)) * sign)
        below = u[np.argmin(np.linalg.norm(points - [0, 0, SIZE_MM[2]], axis=1)), 2]
        print(f"{len(points)} nodes: the point below the ball moves by {below:.4f} mm", flush=True)
    print(f"meshes differ by {relative(*found):.3f} %")
    return found[1]


def error(ref, u, cells):
    """Of nodal displacements on a lattice [%]."""
    return relative(sample(u, SIZE_MM, cells, SAMPLES), ref)


def felupe_ball(ref, across, kind, steps):
    """Newton's method with a direct solver, on the whole block."""
    cells = cells_of(across)

    def run():
        clock = Clock()
        mesh, grid, region = fem.Cube(b=tuple(SIZE_MM), n=tuple(cells + 1)), cells, None
        if kind == "quadratic":
            mesh = fem.mesh.add_midpoints_edges(mesh)
            mesh = fem.mesh.add_midpoints_faces(mesh)
            mesh, grid = fem.mesh.add_midpoints_volumes(mesh), 2 * cells
            region = fem.RegionTriQuadraticHexahedron
        points = mesh.points.copy()
        solve = pressed(mesh, region or fem.RegionHexahedron, MIDDLE, steps, False, 1e-2)
        setup = clock.stop()
        timer = Clock()
        u = solve()
        c, w = timer.stop()
        return setup, [(c, w, error(ref, to_lattice(points, u, SIZE_MM, grid), grid))]

    return Variant("felupe", f"{across} {kind} hexahedra across, {steps - 1} load steps", run)


# Corners of graded meshes of a quarter: from the ball's middle, and from the bottom.
GRADED = {
    "5 x 5 x 4": ([0, 3, 6, 9, 15, 30], [0, 12, 22, 27, 30]),
    "7 x 7 x 5": ([0, 2.5, 5, 7.5, 10, 14, 20, 30], [0, 10, 18, 24, 27.5, 30]),
}


def felupe_quarter(ref, name):
    """A quarter of the block, quadratic, with smaller cells below the ball."""
    from reference import Interpolation, box_of

    x, z = (np.array(lines, float) for lines in GRADED[name])

    def run():
        clock = Clock()
        mesh = box_of(x, x, z)
        points = mesh.points.copy()
        at = np.array([0, 0, SIZE_MM[2]])
        solve = pressed(mesh, fem.RegionTriQuadraticHexahedron, at, 4, True, 1e-2)
        setup = clock.stop()
        timer = Clock()
        u = solve()
        c, w = timer.stop()
        at = SAMPLES - [*MIDDLE[:2], 0]
        sign = np.where(at < 0, -1.0, 1.0) * [1, 1, 0] + [0, 0, 1]
        return setup, [(c, w, relative(Interpolation(x, x, z, points, u)(np.abs(at)) * sign, ref))]

    return Variant("felupe, graded quarter", f"{name} quadratic hexahedra, 3 load steps", run)


def pliant_scan(ref, across, sweeps):
    """The elastic scan with a sphere that slides; air lies above."""
    import pliant

    cells = cells_of(across)

    def run():
        clock = Clock()
        h = SIZE_MM / cells
        air = int(np.ceil(6 / h[2]))
        values = np.full((cells[2] + 1 + air, cells[1] + 1, cells[0] + 1), -1000, np.int16)
        values[: cells[2] + 1] = 40
        scan = pliant.Volume(values, h, background=-1000)
        tissue = pliant.make_elastic(
            scan, threads=1, moduli_kpa=[(-1000.0, 0.0), (-501.0, 0.0), (40.0, YOUNG_PA / 1000)],
            poisson_ratio=NU, held_above_hu=500, held_sides=["-z"], window_cells=512,
        )
        nodes = lattice(SIZE_MM, cells)
        setup = clock.stop()
        solve, points = Clock(), []

        def note():
            c, w = solve.stop()
            u = tissue.displacement_field().apply_to_points(nodes) - nodes
            points.append((c, w, error(ref, u, cells)))
            solve.start()

        start = MIDDLE + [0, 0, RADIUS_MM + 0.01]
        tissue.slide(tuple(start), (0, 0, -DEPTH_MM - 0.01), RADIUS_MM, -500.0)
        note()
        for _ in range(sweeps):
            rest = tissue.advance(max_steps=1).settled
            note()
            if rest:
                break
        return setup, points

    return Variant("Pliant, elastic scan", f"{across} cells across, {sweeps} sweeps at most", run)


def mujoco_ball(ref, across, dof, dt, steps, ramp, hard, damping=0.02):
    """A flex and a ball that is moved as a mocap body."""
    import mujoco

    cells = cells_of(across)
    solimp = "0.999 0.9999 0.0001" if hard else ".95 .99 .0001"

    def run():
        clock = Clock()
        count, text = cells + 1, "{} {} {}".format
        grid = "" if dof == "full" else 'cellcount="{} {} {}"'.format(*cells)
        xml = f"""<mujoco>
          <option timestep="{dt}" integrator="discrete" solver="Newton" tolerance="1e-6"
                  iterations="1000" gravity="0 0 0"/>
          <size memory="2G"/>
          <worldbody>
            <body name="ball" mocap="true" pos="0 0 9"><geom type="sphere" size="{RADIUS_MM / 1000}"
              condim="1" solref="{max(0.01, 2 * dt)} 1" solimp="{solimp}" priority="1"/></body>
            <flexcomp name="b" type="grid" dim="3" dof="{dof}" {grid} count="{text(*count)}"
                spacing="{text(*SIZE_MM / cells / 1000)}" pos="{text(*SIZE_MM / 2000)}" radius="0"
                mass="0.108">
              <contact selfcollide="none" condim="1"/>
              <elasticity young="{YOUNG_PA}" poisson="{NU}" damping="{damping}"/>
              <pin gridrange="0 0 0 {cells[0]} {cells[1]} 0"/>
            </flexcomp>
          </worldbody></mujoco>"""
        model = mujoco.MjModel.from_xml_string(xml)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        rest = 1000 * data.xpos[model.jnt_bodyid[::3]]
        index = np.rint(rest / SIZE_MM * cells).astype(int)
        place = index[:, 0] + (cells[0] + 1) * (index[:, 1] + (cells[1] + 1) * index[:, 2])
        setup = clock.stop()
        solve, points = Clock(), []
        for step in range(steps):
            solve.start()
            down = DEPTH_MM * min(1, (step + 1) / ramp)
            data.mocap_pos[0] = (MIDDLE + [0, 0, RADIUS_MM - down]) / 1000
            mujoco.mj_step(model, data)
            c, w = solve.stop()
            if step % max(1, steps // 12) == 0 or step == steps - 1:
                u = np.zeros((np.prod(cells + 1), 3))
                u[place] = 1000 * data.qpos.reshape(-1, 3)
                points.append((c, w, error(ref, u, cells)))
        return setup, points

    words = f"dof {dof}, {across} cells across, {steps} steps of {dt} s, solimp {solimp}"
    return Variant("MuJoCo, flex", words, run)


def variants(ref):
    """All programs with their settings."""
    out = [pliant_scan(ref, n, 12) for n in (12, 20, 30, 40)]
    for n, dof in ((6, "trilinear"), (12, "trilinear"), (12, "full")):
        out.append(mujoco_ball(ref, n, dof, 0.004, 48, 20, False))
        out.append(mujoco_ball(ref, n, dof, 0.02, 24, 10, True))
    out.append(felupe_ball(ref, 12, "linear", 4))
    out.append(felupe_ball(ref, 6, "quadratic", 4))
    out += [felupe_quarter(ref, name) for name in GRADED]
    return out


def main():
    """Prints the table."""
    if not os.path.exists("reference-contact.npy"):
        np.save("reference-contact.npy", reference())
    ref = np.load("reference-contact.npy")
    levels = (15.0, 10.0, 5.0, 2.0)
    print(table(compare(variants(ref), out="contact.json", levels=levels), levels))


if __name__ == "__main__":
    main()
