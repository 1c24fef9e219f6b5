# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A clamped rod of length 1 m and EI = 1 N m2: bent by a force, and laid on a floor by its weight.

    RESULTS_BESIDE=…/results_beside python rod.py [bent|laid]    # writes rod-….json

Bent: a vertical force of 5 N at the end, which moves down by 71 % of the length. The solution is
the inextensible elastica, integrated to 1e-12; laid: a weight of 75 N/m, and a floor without
friction 0.25 m below the clamp. The error is that of the displacement of 200 points along the rod,
in the L2 norm. The rod is round, with a radius of 10 mm, which gives EA = 4e4 N.
"""

import sys

from common import Clock, Variant, compare, relative, table  # sets the number of threads

import elastica
import mujoco
import numpy as np
from pliant_side import run_program
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

RADIUS, FORCE, WEIGHT, DROP = 0.01, 5.0, 75.0, 0.25
STRETCH = 4 / RADIUS**2  # EA [N]
SOLIMP = ("0.9 0.95 0.001", "0.999 0.9999 0.001")  # of MuJoCo's edges: the default, and hard
ARC = np.linspace(0, 1, 201)[1:]


def elastica_shape(curvature, force, weight, until=1.0):
    """Integrates angle, curvature and position; `force` is that of the clamp, upwards."""

    def slope(s, y):
        return [y[1], (force - weight * s) * -np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

    return solve_ivp(
        slope, (0, until), [0, curvature, 0, 0], rtol=1e-11, atol=1e-12, dense_output=True
    )


def exact(laid):
    """Displacement (200, 3) of the points."""
    if not laid:
        # Downwards: the angle is negative; the end has no moment.
        end = fsolve(lambda c: elastica_shape(c[0], -FORCE, 0).y[1, -1], [-3.0], xtol=1e-12)
        y = elastica_shape(end[0], -FORCE, 0).sol(ARC)
        xz = y[2:4]
    else:

        def misses(u):
            y = elastica_shape(u[0], -u[1], -WEIGHT, u[2]).y[:, -1]
            return [y[0], y[1], y[3] + DROP]

        found, _, flag, why = fsolve(misses, [-8.0, 40.0, 0.75], xtol=1e-12, full_output=True)
        assert flag == 1, why
        free = elastica_shape(found[0], -found[1], -WEIGHT, found[2])
        at = free.sol(np.minimum(ARC, found[2]))
        xz = at[2:4] + np.stack([np.maximum(ARC - found[2], 0), 0 * ARC])
        print(f"laid: touches the floor {found[2]:.4f} m along the rod")
    print(f"the end: x {xz[0, -1]:.6f}, z {xz[1, -1]:.6f} m")
    return np.stack([xz[0] - ARC, 0 * ARC, xz[1]], axis=-1)


def error(nodes, arcs, reference):
    """Of nodes with rest positions `arcs` along x, by linear interpolation [%]."""
    u = nodes - np.stack([arcs, 0 * arcs, 0 * arcs], axis=-1)
    return relative(np.stack([np.interp(ARC, arcs, c) for c in u.T], axis=-1), reference)


def pliant_rod(laid, reference, **with_):
    """Newton's method for all segments at once, in implicit steps."""

    def run():
        kind = "laid" if laid else "rod"
        setup, rest, points = run_program(
            kind, stretch=STRETCH, force=FORCE, gravity=WEIGHT * laid, drop=DROP, radius=RADIUS,
            sectors=64, **with_,
        )
        arcs = rest[:, 0]
        return setup, [(c, w, error(x, arcs, reference)) for c, w, x in points]

    words = ", ".join(f"{k} {v}" for k, v in with_.items())
    return Variant("Pliant, rod", words, run)


class Bench(elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing,
            elastica.Damping, elastica.Contact):
    """PyElastica's collection of systems."""


def pyelastica_rod(laid, reference, elements, time_step, damping, seconds, half):
    """Symplectic explicit steps with analytical linear damping, as in its examples."""

    def run():
        clock = Clock()
        bench = Bench()
        young = 4 / (np.pi * RADIUS**4)
        # Its clamp holds the first element: the rod is clamped in its middle, or at its first node.
        first = -0.5 / (elements - 0.5) if half else 0.0
        rod = elastica.CosseratRod.straight_rod(
            elements, np.array([first, 0, 0]), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]),
            1 - first, RADIUS,
            1 / (np.pi * RADIUS**2), youngs_modulus=young, shear_modulus=young / 2.6,
        )
        bench.append(rod)
        dt = time_step
        bench.constrain(rod).using(
            elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
        )
        if laid:
            bench.add_forcing_to(rod).using(
                elastica.GravityForces, acc_gravity=np.array([0, 0, -WEIGHT])
            )
            floor = elastica.Plane(np.array([0, 0, -DROP - RADIUS]), np.array([0, 0, 1.0]))
            bench.append(floor)
            bench.detect_contact_between(rod, floor).using(
                elastica.RodPlaneContact, k=1e4, nu=10.0
            )
        else:
            bench.add_forcing_to(rod).using(
                elastica.EndpointForces, np.zeros(3), np.array([0, 0, -FORCE]), ramp_up_time=0.2
            )
        bench.dampen(rod).using(
            elastica.AnalyticalLinearDamper, uniform_damping_constant=damping, time_step=dt
        )
        bench.finalize()
        stepper = elastica.PositionVerlet()
        setup = clock.stop()
        solve, points, now = Clock(), [], np.float64(0.0)
        steps = round(seconds / dt)
        for _ in range(16):
            solve.start()
            for _ in range(max(1, steps // 16)):
                now = stepper.step(bench, now, dt)
            c, w = solve.stop()
            arcs = np.linspace(first, 1, elements + 1)
            points.append((c, w, error(rod.position_collection.T, arcs, reference)))
        return setup, points

    clamp = "clamped in an element's middle" if half else "clamped at its first node"
    words = f"{elements} elements, dt {time_step} s, damping {damping}/s, {seconds} s, {clamp}"
    return Variant("PyElastica", words, run)


def mujoco_rod(laid, reference, elements, dt, steps, half, damping, solimp):
    """A flex of dimension 1 with elasticity and edge equality, integrator "discrete"."""

    def run():
        clock = Clock()
        # The first edge is clamped: the rod is clamped in its middle, or at its first vertex.
        edge = 1 / (elements - 0.5) if half else 1 / elements
        first = -edge / 2 if half else 0.0
        young = 4 / (np.pi * RADIUS**4)
        floor = f'<geom type="plane" pos="0 0 {-DROP - RADIUS}" size="9 9 1" friction="0 0 0"/>'
        xml = f"""<mujoco>
          <option timestep="{dt}" integrator="discrete" solver="Newton" tolerance="1e-6"
                  gravity="0 0 {-WEIGHT * laid}"/>
          <worldbody>
            {floor * laid}
            <flexcomp name="r" type="grid" dim="1" count="{elements + 1} 1 1"
                spacing="{edge} 1 1" pos="{first + edge * elements / 2} 0 0" radius="{RADIUS}"
                mass="{(elements + 1) / elements}">
              <contact selfcollide="none" condim="1" contype="{laid:d}" conaffinity="{laid:d}"/>
              <edge equality="true" solref="{2 * dt} 1" solimp="{solimp}"/>
              <elasticity young="{young}" poisson="0.3" damping="{damping}" section="circle"/>
              <pin id="0 1"/>
            </flexcomp>
          </worldbody></mujoco>"""
        model = mujoco.MjModel.from_xml_string(xml)
        data = mujoco.MjData(model)
        setup = clock.stop()
        solve, points = Clock(), []
        rest = first + edge * np.arange(elements + 1)
        for chunk in range(16):
            solve.start()
            for _ in range(max(1, steps // 16)):
                if not laid:
                    body = model.flex_vertbodyid[-1]
                    data.xfrc_applied[body, 2] = -FORCE * min(1, data.time / (0.2 * steps * dt))
                mujoco.mj_step(model, data)
            c, w = solve.stop()
            points.append((c, w, error(data.flexvert_xpos.copy(), rest, reference)))
            del chunk
        return setup, points

    clamp = "clamped in an edge's middle" if half else "clamped at its first vertex"
    return Variant("MuJoCo, flex of dimension 1", f"{elements} elements, dt {dt}, {steps} steps, "
                   f"damping {damping} s, edges' solimp {solimp}, {clamp}", run)  # fmt: skip


def variants(laid, reference):
    """All programs with their settings; the first of each are the recommended ones."""
    out = []
    for n in (8, 12, 20):
        if laid:
            for dt in (0.002, 0.005, 0.01):
                out.append(pliant_rod(laid, reference, segments=n, dt=dt, steps=int(1.6 / dt),
                                      damping=5, iterations=2, rounds=8))  # fmt: skip
        else:
            for dt, steps, iterations in ((0.01, 300, 2), (0.05, 60, 2), (0.1, 30, 8)):
                out.append(
                    pliant_rod(laid, reference, segments=n, dt=dt, steps=steps, ramp=steps // 4,
                               damping=5, iterations=iterations)
                )  # fmt: skip
        damping = 0.05 if laid else 0.6
        for solimp, half in zip(SOLIMP, (False, True), strict=True):
            for dt, steps in ((0.004, 640), (0.02, 192)):
                out.append(mujoco_rod(laid, reference, n, dt, steps, half, damping, solimp))
    for n, half in ((40, False), (8, True), (12, True), (20, True)):
        out.append(pyelastica_rod(laid, reference, n, 5e-5, 7.0, 2.4, half))
    return out


def main():
    """Prints the tables."""
    for laid in (False, True):
        name = "laid" if laid else "bent"
        if len(sys.argv) > 1 and name not in sys.argv[1:]:
            continue
        reference = exact(laid)
        pyelastica_rod(laid, reference, 8, 5e-5, 7.0, 0.1, True).run()  # compiles
        rows = compare(variants(laid, reference), out=f"rod-{name}.json")
        print(table(rows))


if __name__ == "__main__":
    main()
