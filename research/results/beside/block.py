# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A soft block that is held at its bottom and pressed by a square patch at its top.

    python reference.py block 0.3 && RESULTS_BESIDE=…/results_beside python block.py

60 x 60 x 30 mm, E = 5 kPa; a patch of 20 x 20 mm is moved down and does not slide.
"""

import argparse
import itertools

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

import numpy as np

SIZE_MM = np.array([60.0, 60.0, 30.0])
PATCH_MM = 20.0
YOUNG_PA = 5000.0
POISSON = (0.3, 0.45)
DEPTHS_MM = (0.3, 3.0)  # 1 and 10 % of the height

LEVELS = (15.0, 10.0, 5.0, 2.0)  # of the error [%]; the reference's own is up to 1 %
# Middles of the cells of 2.5 mm.
SAMPLES = np.stack(
    np.meshgrid(*(np.arange(1.25, s, 2.5) for s in SIZE_MM), indexing="ij"), axis=-1
).reshape(-1, 3)


class Case:
    """A Poisson's ratio and a depth, with the converged displacement at the samples."""

    def __init__(self, nu, depth):
        self.nu, self.depth = nu, depth
        self.reference = np.load(f"reference-block-{nu}.npz")[str(depth)]

    def error(self, u, cells):
        """Of nodal displacements [mm] on a lattice [%]."""
        return relative(sample(u, SIZE_MM, cells, SAMPLES), self.reference)


def cells_of(across):
    """Cubes."""
    return np.array([across, across, across // 2])


def patch_of(nodes):
    """The nodes of the patch."""
    on = np.isclose(nodes[:, 2], SIZE_MM[2])
    return on & (np.abs(nodes[:, :2] - SIZE_MM[:2] / 2) <= PATCH_MM / 2 + 1e-6).all(axis=1)


def pliant_linear(case, across, tolerance):
    """Linear elements on a lattice, conjugate gradients with multigrid."""
    import pliant

    cells = cells_of(across)

    def run():
        clock = Clock()
        nodes = lattice(SIZE_MM, cells)
        patch, bottom = np.flatnonzero(patch_of(nodes)), np.flatnonzero(nodes[:, 2] == 0)
        held, down = np.r_[bottom, patch], np.zeros((len(bottom) + len(patch), 3))
        down[len(bottom) :, 2] = -case.depth
        box = pliant.HexLattice(size=(cells + 1).tolist(), spacing_mm=(SIZE_MM / cells).tolist())
        solver = pliant.ElasticSolver(
            box, pliant.ElasticMaterial(young_modulus_pa=YOUNG_PA, poisson_ratio=case.nu), held,
            displacement_mm=down, threads=1, tolerance=tolerance,
        )
        setup = clock.stop()
        solve = Clock()
        u = solver.solve().displacement_mm
        c, w = solve.stop()
        return setup, [(c, w, case.error(u, cells))]

    return Variant("Pliant, linear elements", f"{across} cells across, residual {tolerance}", run)


def pliant_scan(case, across, pushes, sweeps):
    """The elastic scan. The patch is bone; the bottom is pushed up, which is the same motion."""
    import pliant

    cells = cells_of(across)

    def run():
        clock = Clock()
        nodes = lattice(SIZE_MM, cells)
        values = np.where(patch_of(nodes), 1000, 40).astype(np.int16)
        scan = pliant.Volume(values.reshape(*(cells[::-1] + 1)), SIZE_MM / cells, background=-1000)
        tissue = pliant.make_elastic(
            scan, threads=1, moduli_kpa=[(-1000.0, 0.0), (-500.0, YOUNG_PA / 1000)],
            poisson_ratio=case.nu, held_above_hu=500, held_sides=[], window_cells=512,
        )
        setup = clock.stop()
        solve, points = Clock(), []

        def note():
            c, w = solve.stop()
            at = tissue.displacement_field().apply_to_points(nodes) - nodes
            points.append((c, w, case.error(at - [0, 0, case.depth], cells)))
            solve.start()

        radius = 1e5
        for n in range(pushes):
            at = (*SIZE_MM[:2] / 2, 0.01 - radius + case.depth * n / pushes)
            tissue.push(at, (0, 0, case.depth / pushes), radius)
        note()
        for _ in range(sweeps):
            rest = tissue.advance(max_steps=1).settled
            note()
            if rest:
                break
        return setup, points

    return Variant("Pliant, elastic scan", f"{across} cells across, {pushes} pushes", run)


def pliant_body(case, across, dt, steps, ramp, damping=20, waves=1):
    """Neo-Hookean tetrahedra, position-based dynamics with warm starts."""
    from pliant_side import run_program

    cells = cells_of(across)

    def run():
        nx, ny, nz = cells
        lx, ly, lz = SIZE_MM / 1000
        setup, rest, points = run_program(
            "block", nx=nx, ny=ny, nz=nz, lx=lx, ly=ly, lz=lz, patch=PATCH_MM / 1000,
            young=YOUNG_PA, nu=case.nu, depth=case.depth / 1000, dt=dt, steps=steps, ramp=ramp,
            damping=damping, waves=waves,
        )
        return setup, [(c, w, case.error(1000 * (x - rest), cells)) for c, w, x in points]

    words = f"{across} cells across, {steps} steps of {dt:.3g} s, pressed in {ramp}, "
    words += f"damping {damping}/s, {waves} times a wave's sub-steps"
    return Variant("Pliant, bodies", words, run)


def felupe_block(case, across, kind, ramp):
    """Newton's method with a direct solver, as its documentation recommends (PyPardiso)."""
    import felupe as fem
    from pypardiso import spsolve

    cells = cells_of(across)

    def run():
        clock = Clock()
        mesh = fem.Cube(b=tuple(SIZE_MM), n=tuple(cells + 1))
        grid = cells
        if kind == "quadratic":
            mesh = fem.mesh.add_midpoints_edges(mesh)
            mesh = fem.mesh.add_midpoints_faces(mesh)
            mesh = fem.mesh.add_midpoints_volumes(mesh)
            region, grid = fem.RegionTriQuadraticHexahedron(mesh), 2 * cells
        else:
            region = fem.RegionHexahedron(mesh)
        field = fem.FieldContainer([fem.Field(region, dim=3)])
        mu = YOUNG_PA / (2 * (1 + case.nu))
        lam = 2 * mu * case.nu / (1 - 2 * case.nu)
        solid = fem.SolidBody(fem.NeoHookeCompressible(mu=mu, lmbda=lam), field)
        patch = patch_of(mesh.points)
        fixed = {
            "bottom": fem.Boundary(field[0], fz=0),
            "patch": fem.Boundary(field[0], mask=patch, skip=(0, 0, 1)),
            "down": fem.Boundary(field[0], mask=patch, skip=(1, 1, 0)),
        }
        setup = clock.stop()
        solve = Clock()
        down = fem.math.linsteps([0, -case.depth], num=ramp)[1:]
        step = fem.Step([solid], ramp={fixed["down"]: down}, boundaries=fixed)
        fem.Job([step]).evaluate(verbose=0, tol=1e-2, solver=spsolve)
        c, w = solve.stop()
        u = to_lattice(mesh.points, field[0].values, SIZE_MM, grid)
        return setup, [(c, w, case.error(u, grid))]

    words = f"{across} {kind} hexahedra across, {ramp - 1} load steps, residual 1e-2"
    return Variant("felupe", words, run)


# Corners of graded meshes of a quarter: from the patch's middle, and from the bottom.
GRADED = {
    "4 x 4 x 3": ([0, 8.5, 10, 13, 30], [0, 18, 27, 30]),
    "6 x 6 x 5": ([0, 5, 9, 10, 11.5, 17, 30], [0, 10, 19, 25.5, 29, 30]),
    "7 x 7 x 6": ([0, 5, 8.75, 10, 11.25, 15, 22, 30], [0, 8, 16, 22, 26, 28.75, 30]),
}


def felupe_quarter(case, name):
    """A quarter of the block, quadratic, with smaller cells at the patch's edge."""
    from reference import Interpolation, pressed

    x, z = (np.array(lines, float) for lines in GRADED[name])

    def run():
        solve = Clock()
        points, found = pressed(case.nu, [case.depth], x, z)
        c, w = solve.stop()
        at = SAMPLES - [*SIZE_MM[:2] / 2, 0]
        sign = np.where(at < 0, -1.0, 1.0) * [1, 1, 0] + [0, 0, 1]
        u = Interpolation(x, x, z, points, found[0])(np.abs(at)) * sign
        return (0.0, 0.0), [(c, w, relative(u, case.reference))]

    return Variant("felupe, graded quarter", f"{name} quadratic hexahedra, 6 load steps", run)


def mujoco_block(case, across, dof, dt, steps, ramp, damping=0.002, solver="Newton"):
    """A flex under the integrator "discrete", whose patch nodes are too heavy to move by force."""
    import mujoco

    cells = cells_of(across)

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
          <option timestep="{dt}" integrator="discrete" solver="{solver}" tolerance="1e-6"
                  iterations="1000" gravity="0 0 0"/>
          <size memory="2G"/>
          <worldbody>
            <flexcomp name="b" type="grid" dim="3" dof="{dof}" {grid} count="{text(*count)}"
                spacing="{text(*spacing)}" pos="{text(*SIZE_MM / 2000)}" radius="0" mass="0.108">
              <contact selfcollide="none" contype="0" conaffinity="0"/>
              <elasticity young="{YOUNG_PA}" poisson="{case.nu}" damping="{damping}"/>
              <pin gridrange="0 0 0 {nodes[0]} {nodes[1]} 0"/>
            </flexcomp>
          </worldbody></mujoco>"""
        model = mujoco.MjModel.from_xml_string(xml)
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        body = model.jnt_bodyid[::3]
        rest = 1000 * data.xpos[body]
        patch = np.flatnonzero(patch_of(rest))
        model.body_mass[body[patch]], model.body_inertia[body[patch]] = 1e6, 1e3
        mujoco.mj_setConst(model, data)
        setup = clock.stop()
        solve, points = Clock(), []
        everywhere = lattice(SIZE_MM, nodes)
        for step in range(steps):
            solve.start()
            data.qpos[3 * patch + 2] = -case.depth / 1000 * min(1, (step + 1) / ramp)
            mujoco.mj_step(model, data)
            c, w = solve.stop()
            if step % max(1, steps // 16) == 0 or step == steps - 1:
                u = np.zeros_like(everywhere)
                index = np.rint(rest / SIZE_MM * nodes).astype(int)
                n = nodes + 1
                u[index[:, 0] + n[0] * (index[:, 1] + n[1] * index[:, 2])] = (
                    1000 * data.qpos.reshape(-1, 3)
                )
                points.append((c, w, case.error(u, nodes)))
        return setup, points

    return Variant(
        "MuJoCo, flex", f"dof {dof}, {across} cells across, {steps} steps of {dt} s, {solver}, "
        f"pressed in {ramp}, damping {damping} s", run,
    )  # fmt: skip


def newton_block(case, across, dt, iterations, steps, ramp, damping=1.0):
    """Vertex block descent on the processor."""
    import newton
    import warp as wp

    cells = cells_of(across)

    def run():
        clock = Clock()
        wp.config.quiet = True
        with wp.ScopedDevice("cpu"):
            builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
            mu = YOUNG_PA / (2 * (1 + case.nu))
            side = [float(s) for s in SIZE_MM / cells / 1000]
            builder.add_soft_grid(
                pos=wp.vec3(0.0, 0.0, 0.0), rot=wp.quat_identity(), vel=wp.vec3(0.0, 0.0, 0.0),
                dim_x=int(cells[0]), dim_y=int(cells[1]), dim_z=int(cells[2]), cell_x=side[0],
                cell_y=side[1], cell_z=side[2], density=1000.0, k_mu=mu,
                k_lambda=2 * mu * case.nu / (1 - 2 * case.nu), k_damp=damping,
            )
            rest = 1000 * np.array(builder.particle_q, dtype=float)
            patch = patch_of(rest)
            for n in np.flatnonzero(patch | np.isclose(rest[:, 2], 0, atol=1e-4)):
                builder.particle_mass[n] = 0.0
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
                if step < ramp:
                    q = now.particle_q.numpy()
                    q[patch, 2] = (rest[patch, 2] - case.depth * (step + 1) / ramp) / 1000
                    now.particle_q.assign(q)
                    then.particle_q.assign(q)
                solver.step(now, then, control, None, dt)
                now, then = then, now
                c, w = solve.stop()
                if step % max(1, steps // 16) == 0 or step == steps - 1:
                    u = 1000 * now.particle_q.numpy() - rest
                    points.append((c, w, case.error(to_lattice(rest, u, SIZE_MM, cells), cells)))
        return setup, points

    return Variant(
        "Newton, VBD", f"{across} cells across, {steps} steps of {dt:.3g} s, {iterations} "
        f"iterations, pressed in {ramp}", run,
    )  # fmt: skip


def variants(case):
    """All programs with their settings."""
    ramp = {0.3: 1, 3.0: 4}[case.depth]
    out = []
    for n, tolerance in ((6, 1e-1), (12, 1e-1), (24, 1e-1), (24, 1e-2), (48, 1e-2)):
        out.append(pliant_linear(case, n, tolerance))
    for n in (12, 24, 48):
        for pushes in (1, 4):
            out.append(pliant_scan(case, n, pushes, 3))
    for n in (6, 12):
        out.append(pliant_body(case, n, 1 / 60, 48, max(ramp, 4)))
        out.append(pliant_body(case, n, 1 / 60, 48, max(ramp, 4), waves=4))
    for n in (6, 12):
        out.append(felupe_block(case, n, "linear", 1 + ramp))
    out.append(felupe_block(case, 6, "quadratic", 1 + ramp))
    for n, dof in ((6, "trilinear"), (12, "trilinear"), (12, "full"), (6, "quadratic")):
        out.append(mujoco_block(case, n, dof, 0.1, 16, ramp))
        out.append(mujoco_block(case, n, dof, 0.1, 16, ramp, solver="CG"))
    for n, dof in ((12, "trilinear"), (6, "quadratic"), (24, "trilinear")):
        out.append(mujoco_block(case, n, dof, 0.004, 40, 10, 0.02, solver="CG"))
    out.append(pliant_body(case, 24, 1 / 60, 48, max(ramp, 4)))
    out += [felupe_quarter(case, name) for name in GRADED]
    return out


def main():
    """Prints a table for each case."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--nu", type=float, nargs="*", default=POISSON)
    parser.add_argument("--depth", type=float, nargs="*", default=DEPTHS_MM)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--only", default="", help="a part of the programs' names")
    options = parser.parse_args()
    for nu, depth in itertools.product(options.nu, options.depth):
        chosen = [v for v in variants(Case(nu, depth)) if options.only in v.program]
        name = f"block-{nu}-{depth}{options.only}.json"
        rows = compare(chosen, options.repeats, name, levels=LEVELS)
        print(f"\nnu {nu}, {depth} mm\n\n{table(rows, LEVELS)}\n", flush=True)


if __name__ == "__main__":
    main()
