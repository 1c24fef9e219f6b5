# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A cantilever of 100 x 10 x 10 mm that bends under its own weight by half of its length.

    RESULTS_BESIDE=…/results_beside python beam.py [newton]   # writes beam.json

E = 250 kPa, nu = 0.3, 1000 kg/m3, 9.81 m/s2. The reference is felupe's, half of the beam with
27-node hexahedra that are smaller near the clamp.
"""

import os
import sys

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
from pypardiso import spsolve

SIZE_MM = np.array([100.0, 10.0, 10.0])
YOUNG_PA, NU, DENSITY, GRAVITY = 250e3, 0.3, 1000.0, 9.81
FORCE = DENSITY * GRAVITY * 1e-3  # [Pa/mm]
SAMPLES = np.stack(
    np.meshgrid(*(np.arange(1.25, s, 2.5) for s in SIZE_MM), indexing="ij"), axis=-1
).reshape(-1, 3)


def law():
    """W = mu/2 (tr C - 3) - mu ln J + lambda/2 (ln J)^2."""
    mu = YOUNG_PA / (2 * (1 + NU))
    return fem.NeoHookeCompressible(mu=mu, lmbda=2 * mu * NU / (1 - 2 * NU))


def solve_felupe(mesh, region, load_steps, half=False, tol=1e-6):
    """Prepares; returns the field and a function that solves."""
    field = fem.FieldContainer([fem.Field(region(mesh), dim=3)])
    solid = fem.SolidBody(law(), field)
    weight = fem.SolidBodyForce(field)
    fixed = {"clamp": fem.Boundary(field[0], fx=0)}
    if half:
        fixed["symmetry"] = fem.Boundary(field[0], fy=0, skip=(1, 0, 1))

    def solve():
        ramp = fem.math.linsteps([0, 1], num=load_steps)[1:, None] * np.array([0, 0, -FORCE])
        step = fem.Step([solid, weight], ramp={weight: ramp}, boundaries=fixed)
        fem.Job([step]).evaluate(verbose=0, tol=tol, solver=spsolve)
        return field[0].values

    return solve


def box27(cells, size=SIZE_MM):
    """27-node hexahedra."""
    mesh = fem.Cube(b=tuple(size), n=tuple(np.array(cells) + 1))
    mesh = fem.mesh.add_midpoints_edges(mesh)
    mesh = fem.mesh.add_midpoints_faces(mesh)
    return fem.mesh.add_midpoints_volumes(mesh)


def reference():
    """Displacements at the samples [mm]; prints the difference of two meshes."""
    from reference import Interpolation

    found = []
    for lines, across in (
        ([0, 1.5, 4, 8, 14, 22, 32, 44, 58, 72, 86, 100], 4),
        ([0, 0.4, 1, 2, 3.5, 6, 9, 13, 18, 25, 33, 42, 52, 62, 72, 82, 91, 97, 100], 6),
    ):
        mesh = box27((len(lines) - 1, across // 2, across), (len(lines) - 1, 5, 10))
        mesh.points[:, 0] = np.interp(mesh.points[:, 0], range(len(lines)), lines)
        solve = solve_felupe(mesh, fem.RegionTriQuadraticHexahedron, 8, half=True)
        y, z = np.linspace(0, 5, across // 2 + 1), np.linspace(0, 10, across + 1)
        field = Interpolation(np.array(lines, float), y, z, mesh.points, solve())
        right = SAMPLES[:, 1] > 5
        at = np.where(right[:, None], SAMPLES * [1, -1, 1] + [0, 10, 0], SAMPLES)
        at = at * [1, -1, 1] + [0, 5, 0]  # from the plane of symmetry
        u = field(at)
        u[~right, 1] *= -1
        found.append(u)
        print(f"{len(lines) - 1} x {across} cells: end {field(np.array([[100, 0, 5.0]]))[0]} mm")
    print(f"meshes differ by {relative(*found):.3f} %")
    return found[1]


def felupe_beam(ref, cells, kind, load_steps, tol):
    """Newton's method with a direct solver."""

    def run():
        clock = Clock()
        if kind == "quadratic":
            mesh, region, grid = box27(cells), fem.RegionTriQuadraticHexahedron, 2 * np.array(cells)
        else:
            mesh = fem.Cube(b=tuple(SIZE_MM), n=tuple(np.array(cells) + 1))
            region, grid = fem.RegionHexahedron, np.array(cells)
        solve = solve_felupe(mesh, region, load_steps, tol=tol)
        setup = clock.stop()
        timer = Clock()
        u = solve()
        c, w = timer.stop()
        u = to_lattice(mesh.points, u, SIZE_MM, grid)
        return setup, [(c, w, relative(sample(u, SIZE_MM, grid, SAMPLES), ref))]

    words = f"{cells} {kind} hexahedra, {load_steps - 1} load steps, residual {tol:g}"
    return Variant("felupe", words, run)


def mujoco_beam(ref, cells, dof, dt, steps, damping):
    """A flex under the integrator "discrete"."""
    import mujoco

    cells = np.array(cells)

    def run():
        clock = Clock()
        nodes = 2 * cells if dof == "quadratic" else cells
        if dof == "full":
            count, grid, spacing = cells + 1, "", SIZE_MM / cells / 1000
        else:
            count, spacing = np.array([3, 3, 3]), SIZE_MM / 2000
            grid = 'cellcount="{} {} {}"'.format(*cells)
        text = "{} {} {}".format
        xml = f"""<mujoco>
          <option timestep="{dt}" integrator="discrete" solver="Newton" tolerance="1e-6"
                  iterations="1000" gravity="0 0 {-GRAVITY}"/>
          <size memory="1G"/>
          <worldbody>
            <flexcomp name="b" type="grid" dim="3" dof="{dof}" {grid} count="{text(*count)}"
                spacing="{text(*spacing)}" pos="{text(*SIZE_MM / 2000)}" radius="0" mass="0.01">
              <contact selfcollide="none" contype="0" conaffinity="0"/>
              <elasticity young="{YOUNG_PA}" poisson="{NU}" damping="{damping}"/>
              <pin gridrange="0 0 0 0 {nodes[1]} {nodes[2]}"/>
            </flexcomp>
          </worldbody></mujoco>"""
        model = mujoco.MjModel.from_xml_string(xml)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        rest = 1000 * data.xpos[model.jnt_bodyid[::3]]
        index = np.rint(rest / SIZE_MM * nodes).astype(int)
        place = index[:, 0] + (nodes[0] + 1) * (index[:, 1] + (nodes[1] + 1) * index[:, 2])
        setup = clock.stop()
        solve, points = Clock(), []
        for step in range(steps):
            solve.start()
            mujoco.mj_step(model, data)
            c, w = solve.stop()
            if step % max(1, steps // 16) == 0 or step == steps - 1:
                u = np.zeros((np.prod(nodes + 1), 3))
                u[place] = 1000 * data.qpos.reshape(-1, 3)
                points.append((c, w, relative(sample(u, SIZE_MM, nodes, SAMPLES), ref)))
        return setup, points

    words = f"dof {dof}, {tuple(int(c) for c in cells)} cells, {steps} steps of {dt} s, "
    words += f"damping {damping} s"
    return Variant("MuJoCo, flex", words, run)


def newton_beam(ref, cells, dt, iterations, steps, damping):
    """Vertex block descent on the processor."""
    import newton
    import warp as wp

    def run():
        clock = Clock()
        wp.config.quiet = True
        with wp.ScopedDevice("cpu"):
            builder = newton.ModelBuilder(gravity=(0.0, 0.0, -GRAVITY))
            mu = YOUNG_PA / (2 * (1 + NU))
            side = [float(s) for s in SIZE_MM / np.array(cells) / 1000]
            builder.add_soft_grid(
                pos=wp.vec3(0.0, 0.0, 0.0), rot=wp.quat_identity(), vel=wp.vec3(0.0, 0.0, 0.0),
                dim_x=cells[0], dim_y=cells[1], dim_z=cells[2], cell_x=side[0], cell_y=side[1],
                cell_z=side[2], density=DENSITY, k_mu=mu, k_lambda=2 * mu * NU / (1 - 2 * NU),
                k_damp=damping, fix_left=True,
            )
            rest = 1000 * np.array(builder.particle_q, dtype=float)
            builder.color()
            model = builder.finalize()
            solver = newton.solvers.SolverVBD(
                model=model, iterations=iterations, particle_enable_self_contact=False,
                particle_enable_tile_solve=False,
            )
            now, then, control = model.state(), model.state(), model.control()
            solver.step(now, then, control, None, dt)  # compiles
            now, then = model.state(), model.state()
            setup = clock.stop()
            solve, points = Clock(), []
            for step in range(steps):
                solve.start()
                solver.step(now, then, control, None, dt)
                now, then = then, now
                c, w = solve.stop()
                if step % max(1, steps // 16) == 0 or step == steps - 1:
                    u = to_lattice(rest, 1000 * now.particle_q.numpy() - rest, SIZE_MM, cells)
                    points.append((c, w, relative(sample(u, SIZE_MM, cells, SAMPLES), ref)))
        return setup, points

    words = f"{cells} cells, {steps} steps of {dt:.3g} s, {iterations} iterations, "
    words += f"damping {damping:g} Pa s"
    return Variant("Newton, VBD", words, run)


def pliant_body(ref, cells, dt, steps, damping, waves=1):
    """Neo-Hookean tetrahedra, position-based dynamics with warm starts."""
    from pliant_side import run_program

    def run():
        nx, ny, nz = cells
        lx, ly, lz = SIZE_MM / 1000
        setup, rest, points = run_program(
            "beam", nx=nx, ny=ny, nz=nz, lx=lx, ly=ly, lz=lz, young=YOUNG_PA, nu=NU, dt=dt,
            steps=steps, damping=damping, gravity=GRAVITY, waves=waves,
        )
        return setup, [
            (c, w, relative(sample(1000 * (x - rest), SIZE_MM, cells, SAMPLES), ref))
            for c, w, x in points
        ]

    words = f"{cells} cells, {steps} steps of {dt:.3g} s, damping {damping}/s, "
    words += f"{waves} times a wave's sub-steps"
    return Variant("Pliant, bodies", words, run)


def pliant_linear(ref, cells):
    """Linear hexahedra with inner modes: small displacements only."""
    import pliant

    def run():
        clock = Clock()
        cells_ = np.array(cells)
        nodes = lattice(SIZE_MM, cells_)
        mesh = pliant.hex_mesh(tuple(cells_ + 1), tuple(SIZE_MM / cells_))
        solver = pliant.ElasticSolver(
            mesh,
            pliant.ElasticMaterial(
                young_modulus_pa=YOUNG_PA, poisson_ratio=NU, density_kg_per_m3=DENSITY
            ),
            np.flatnonzero(nodes[:, 0] == 0), threads=1, element="incompatible_modes",
        )
        setup = clock.stop()
        solve = Clock()
        u = solver.solve(gravity_m_per_s2=(0, 0, -GRAVITY)).displacement_mm
        c, w = solve.stop()
        return setup, [(c, w, relative(sample(u, SIZE_MM, cells, SAMPLES), ref))]

    return Variant("Pliant, linear elements", f"{cells} cells with inner modes, Cholesky", run)


def variants(ref):
    """All programs with their settings."""
    out = [pliant_linear(ref, (20, 4, 4))]
    for cells, steps in (((20, 2, 2), 120), ((30, 3, 3), 150), ((40, 4, 4), 180)):
        out.append(pliant_body(ref, cells, 1 / 60, steps, 10))
    out.append(pliant_body(ref, (40, 4, 4), 1 / 60, 90, 10, waves=3))
    for cells in ((20, 2, 2), (40, 4, 4)):
        out.append(felupe_beam(ref, cells, "linear", 3, 1e-2))
    for cells in ((4, 1, 1), (6, 1, 1), (8, 1, 1), (12, 1, 1)):
        out.append(felupe_beam(ref, cells, "quadratic", 3, 1e-2))
    for cells, dof in (
        ((20, 2, 2), "trilinear"),
        ((20, 2, 2), "full"),
        ((4, 1, 1), "quadratic"),
        ((6, 1, 1), "quadratic"),
        ((8, 1, 1), "quadratic"),
    ):
        for dt, steps, damping in ((0.02, 96, 0.05), (0.1, 32, 0.05)):
            out.append(mujoco_beam(ref, cells, dof, dt, steps, damping))
    out.append(mujoco_beam(ref, (4, 1, 1), "quadratic", 0.004, 320, 0.05))
    out.append(mujoco_beam(ref, (8, 1, 1), "quadratic", 0.004, 320, 0.05))
    if "newton" in sys.argv:  # its kernels take minutes to compile
        out.append(newton_beam(ref, (20, 2, 2), 1 / 600, 10, 300, 1e2))
    return out


def main():
    """Prints the table."""
    if not os.path.exists("reference-beam.npy"):
        np.save("reference-beam.npy", reference())
    ref = np.load("reference-beam.npy")
    print(table(compare(variants(ref), out="beam.json")))


if __name__ == "__main__":
    main()
