# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""An indented gel: the tool is fitted, and finite elements and ChainMail predict the beads.

The gel is a block on glass, and the tool is a sphere without friction. Tool, thickness, Poisson's
ratio and the decrease of the modulus with height are fitted to a random half of the beads by linear
finite elements; the tables are of the other half. Micrometres are Pliant's millimetres, which
changes nothing but the unit of forces.

    pip install numpy scipy matplotlib       # and Pliant's own package
    python gel.py DATA --picture section.png # the tables of README.md; links.npz is kept
    python gel.py DATA --fit                 # after a fit; otherwise with the one in this file
    python gel.py DATA --fine                # with smaller cells as well
    python gel.py DATA --variants            # and refits with other assumptions

DATA holds `beads_before.csv.gz` and `beads_after.csv.gz`.
"""

import argparse
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
import pliant
from scipy.interpolate import RegularGridInterpolator
from scipy.optimize import minimize
from scipy.spatial import cKDTree

from beads import link_beads, predict, read_beads, stage_drift

SEED = 49
IMAGE_UM = np.array([408.6, 408.6, 121.4])  # the imaged box
MIDDLE_UM = IMAGE_UM[:2] / 2
RIM_UM = 30.0  # beads nearer to the image's sides may leave it: no nearest bead is searched
LAYERS = np.append(np.arange(0, 120, 15), 122)  # height above the glass, before [um]
COUNT = len(LAYERS) - 1
AIR = -1000


@dataclass(frozen=True)
class Gel:
    """The block, the tool and the discretisation. Lengths in um; heights are above the glass.

    The defaults are the fit that --fit repeats, rounded.
    """

    thickness: float = 136.3
    softening: float = 5.19  # ln of the modulus at the glass over that at the image's top
    power: float = 1.285  # of the height, in the modulus' exponent
    poisson: float = 0.4904
    radius: float = 397.0  # of the sphere, or of a ring's tube
    lowest: float = 87.44  # of the tool's points
    ring: float = 0.0  # radius of the tube's axis; 0: a sphere
    centre: tuple = (206.6, 201.1)
    sticks: bool = False  # contact without sliding
    sides: bool = True  # held, at the margin's end
    margin: float = 160.0  # beyond the image
    cell: float = 20.0  # along x and y
    cell_z: float = 7.0


FREE = ("thickness", "softening", "power", "poisson", "radius", "lowest")
SCALE = {"thickness": 10.0, "radius": 100.0, "lowest": 10.0, "ring": 100.0}
STEP = {
    "thickness": 6.0,
    "softening": 0.6,
    "power": 0.4,
    "poisson": -0.06,
    "radius": 60.0,
    "lowest": -4.0,
    "ring": 30.0,
}
START = Gel(140.0, 4.0, 1.0, 0.44, 450.0, 98.0, centre=(208.0, 200.0))  # of the fit


def grid_of(gel):
    """Nodes along x, y and z, and their spacing."""
    wide = IMAGE_UM[0] + 2 * gel.margin
    across, layers = round(wide / gel.cell) + 1, round(gel.thickness / gel.cell_z) + 1
    spacing = np.array([wide / (across - 1)] * 2 + [gel.thickness / (layers - 1)])
    return np.array([across, across, layers]), spacing


def modulus_pa(gel, z):
    """Young's modulus at a height; the scale is arbitrary."""
    return 1e4 * np.exp(-gel.softening * (z / IMAGE_UM[2]) ** gel.power)


def tool_height(gel, xy):
    """Height of the tool's lower surface, which is over the block's middle."""
    off = np.abs(np.linalg.norm(xy - MIDDLE_UM, axis=1) - gel.ring)
    under = off < gel.radius
    rise = gel.radius - np.sqrt(np.where(under, gel.radius**2 - off**2, 0))
    return np.where(under, gel.lowest + rise, np.inf)


def linear(gel, rounds=14):
    """Linear finite elements (`pliant.ElasticSolver`): displacement as a function of points.

    Nodes of the top below the tool are moved to its surface along z. In each round the surface is
    taken where the node is now, nodes that are pulled are let go, and nodes above the surface are
    added.
    """
    size, spacing = grid_of(gel)
    axes = [np.arange(n) * h for n, h in zip(size, spacing, strict=True)]
    axes[0], axes[1] = axes[0] - gel.margin, axes[1] - gel.margin
    z, y, x = np.meshgrid(axes[2], axes[1], axes[0], indexing="ij")
    nodes = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    low, high = axes[0][0], axes[0][-1]
    beside = ((nodes[:, :2] == low) | (nodes[:, :2] == high)).any(axis=1)
    fixed = np.flatnonzero((nodes[:, 2] == 0) | (beside & gel.sides))
    top = np.flatnonzero((nodes[:, 2] == axes[2][-1]) & ~(beside & gel.sides))
    middles = (axes[2][1:] + axes[2][:-1]) / 2
    materials = [
        pliant.ElasticMaterial(young_modulus_pa=float(e), poisson_ratio=gel.poisson)
        for e in modulus_pa(gel, middles)
    ]
    material_of = np.repeat(np.arange(size[2] - 1), (size[0] - 1) ** 2)
    lattice = pliant.HexLattice(
        size=size.tolist(), spacing_mm=spacing.tolist(), origin_mm=(-gel.margin, -gel.margin, 0)
    )
    u, touching, solver = np.zeros_like(nodes), None, None
    for _ in range(rounds):
        surface = tool_height(gel, (nodes[top] + u[top])[:, :2]) - gel.thickness
        if touching is None:
            new = surface < 0
        else:
            new = np.where(touching, solution.reaction_n[top, 2] <= 0, u[top, 2] > surface + 0.02)
        held = np.r_[fixed, top[new]]
        along = np.ones((len(held), 3), bool)
        along[len(fixed) :, :2] = gel.sticks
        moves = np.zeros((len(held), 3))
        moves[len(fixed) :, 2] = surface[new]
        if solver is None:
            solver = pliant.ElasticSolver(
                lattice, materials, held, along, moves, material_of, 1, tolerance=1e-4
            )
        else:
            solver = solver.with_supports(held, along, moves)
        solution = solver.solve(initial_displacement_mm=u)
        change = np.abs(solution.displacement_mm - u).max()
        u = np.array(solution.displacement_mm)
        if touching is not None and change < 0.2:
            break
        touching = new
    field = RegularGridInterpolator(
        axes[::-1], u.reshape(*size[::-1], 3), bounds_error=False, fill_value=0.0
    )
    return lambda points: field(points[:, ::-1])


def block_of(gel, air_um):
    """A scan: value 10 k in layer k of the gel, air above."""
    size, spacing = grid_of(gel)
    values = np.full((size[2] + round(air_um / spacing[2]), size[1], size[0]), AIR, np.int16)
    values[: size[2]] = 10 * np.arange(size[2])[:, None, None]
    return pliant.Volume(values, spacing, (-gel.margin, -gel.margin, 0), background=AIR)


def slide(tissue, gel, sweeps):
    """Lowers the sphere over the middle of the block; displacement as a function of points."""
    start = (*MIDDLE_UM, gel.thickness + gel.radius + 0.01)
    way = (0, 0, gel.lowest + gel.radius - start[2])
    tissue.slide(start, way, gel.radius, -500.0)
    tissue.advance(max_steps=sweeps)
    field = tissue.displacement_field()
    return lambda points: field.apply_to_points(points) - points


def elastic_scan(gel, sweeps=40):
    """The elastic scan with the same block and sphere."""
    size, spacing = grid_of(gel)
    kpa = 1e-3 * modulus_pa(gel, np.arange(size[2]) * spacing[2])
    table = [(AIR, 0.0), (-1.0, 0.0)] + [(10.0 * k, float(e)) for k, e in enumerate(kpa)]
    scan = block_of(gel, 25.0)
    tissue = pliant.make_elastic(
        scan,
        threads=1,
        moduli_kpa=table,
        poisson_ratio=gel.poisson,
        held_above_hu=30000,
        held_sides=["-z"] + ["-x", "+x", "-y", "+y"] * gel.sides,
        window_cells=512,
    )
    return slide(tissue, gel, sweeps)


def chainmail(gel, offset):
    """ChainMail with the same sphere; the lowest layer is bone."""
    scan = block_of(gel, gel.radius + 2 * gel.cell_z)  # up to the sphere's centre
    values = np.where(scan.array == AIR, AIR, 0).astype(np.int16)
    values[0] = 3000
    scan = pliant.Volume(values, scan.spacing_mm, scan.origin_mm, background=AIR)
    tissue = pliant.make_chainmail(scan, 1, offset=offset, max_movement_mm=200, range=(0, 3000))
    return slide(tissue, gel, 100)


class Beads:
    """The beads with their links, without the stage's drift, and the halves."""

    def __init__(self, folder, cache):
        self.before, after = read_beads(folder)
        self.drift = stage_drift(self.before, after)
        self.after = after - self.drift
        if not cache.exists():
            np.savez_compressed(cache, link=link_beads(self.before, after, self.drift))
        self.link = np.load(cache)["link"]
        self.linked = self.link >= 0
        self.u = np.where(self.linked[:, None], self.after[self.link] - self.before, np.nan)
        self.layer = np.digitize(self.before[:, 2], LAYERS[1:-1])
        self.fit = np.random.default_rng(SEED).random(len(self.before)) < 0.5
        xy = self.before[:, :2]
        self.inner = ((xy > RIM_UM) & (xy < IMAGE_UM[0] - RIM_UM)).all(axis=1)
        self.tree = cKDTree(self.after)

    def errors(self, move, centre, chosen):
        """Means over the layers of the mean distances from the linked and the nearest bead [um]."""
        u = moved(move, centre, self.before[chosen])
        off = np.linalg.norm(u - self.u[chosen], axis=1)
        near = self.tree.query(self.before[chosen] + u)[0]
        layer, linked, inner = self.layer[chosen], self.linked[chosen], self.inner[chosen]
        return (
            np.mean([off[linked & (layer == k)].mean() for k in range(COUNT)]),
            np.mean([near[inner & (layer == k)].mean() for k in range(COUNT)]),
        )


def moved(move, centre, points):
    """Displacement of points by a tool over `centre` instead of the block's middle."""
    return move(points - np.append(np.array(centre) - MIDDLE_UM, 0))


def fit(beads, start, chosen, free=FREE, evaluations=160):
    """Downhill simplex over the free parameters, and over the centre for each of them."""
    best = [np.inf, start]

    def cost(x):
        changes = {n: float(v * SCALE.get(n, 1.0)) for n, v in zip(free, x, strict=True)}
        gel = replace(start, **changes)
        in_range = 0 <= gel.poisson <= 0.494 and 122 <= gel.thickness <= 300
        in_range &= -1 <= gel.softening <= 9 and 0.3 < gel.power < 6 and 0 <= gel.ring < 200
        if not (in_range and 20 <= gel.radius <= 2000 and 30 < gel.lowest < gel.thickness - 3):
            return 20.0
        move = linear(gel)
        centre = np.array(best[1].centre)
        found = minimize(
            lambda c: sum(beads.errors(move, c, chosen)),
            centre,
            method="Nelder-Mead",
            options={
                "xatol": 0.5,
                "fatol": 0.005,
                "maxiter": 30,
                "initial_simplex": centre + np.array([[0, 0], [4, 0], [0, 4]]),
            },
        )
        if found.fun < best[0]:
            best[:] = [found.fun, replace(gel, centre=tuple(float(c) for c in found.x))]
        return found.fun

    x = np.array([getattr(start, n) / SCALE.get(n, 1.0) for n in free])
    steps = np.diag([STEP[n] / SCALE.get(n, 1.0) for n in free])
    simplex = x + np.vstack([np.zeros(len(x)), steps])
    options = {"maxfev": evaluations, "xatol": 0.02, "fatol": 0.002, "initial_simplex": simplex}
    minimize(cost, x, method="Nelder-Mead", options=options)
    return best[1]


def table(beads, predictions, chosen):
    """Prints medians by layer: distance from the nearest bead, and from the linked bead."""
    rng = np.random.default_rng(SEED)
    linked = np.flatnonzero(beads.linked)
    rows = []
    for k in range(COUNT):
        here = np.flatnonzero(chosen & beads.inner & (beads.layer == k))
        points, known = beads.before[here], beads.linked[here]
        motion = beads.u[here[known]]
        low, high = points.min(axis=0), points.max(axis=0)
        chance = np.median(beads.tree.query(rng.uniform(low, high, (20000, 3)))[0])
        fields = list(predictions.values())
        near = [np.median(beads.tree.query(points + u[here])[0]) for u in fields]
        match = [np.median(np.linalg.norm(u[here[known]] - motion, axis=1)) for u in fields]
        # The floor: maps through the linked neighbours predict each linked bead.
        own = predict(points[known], beads.before[linked], beads.u[linked], skip_self=True)[0]
        near.append(np.median(beads.tree.query(points[known] + own)[0]))
        match.append(np.median(np.linalg.norm(own - motion, axis=1)))
        size = np.median(np.linalg.norm(motion, axis=1))
        head = f"| {LAYERS[k]}-{LAYERS[k + 1]} | {len(here)} | {size:.1f} |"
        rows.append((f"{head} {chance:.1f} |", near, f"{head} {known.mean():.0%} |", match))
    names = " | ".join([*predictions, "floor"])
    print(f"nearest bead\n| layer | beads | motion | chance | {names} |")
    for head, near, _, _ in rows:
        print(head, " | ".join(f"{v:.2f}" for v in near), "|")
    print(f"linked bead\n| layer | beads | motion | linked | {names} |")
    for _, _, head, match in rows:
        print(head, " | ".join(f"{v:.2f}" for v in match), "|")


def variants(beads, best, chosen, test):
    """Refits with other assumptions; prints the errors of the other half."""

    def without(*names):
        return tuple(n for n in FREE if n not in names)

    others = {
        "uniform modulus": (replace(best, softening=0.0), without("softening", "power")),
        "sticks": (replace(best, sticks=True), FREE),
        "ring": (replace(best, ring=30.0), (*FREE, "ring")),
        "Poisson's ratio 0.45": (replace(best, poisson=0.45), without("poisson")),
        "Poisson's ratio 0.3": (replace(best, poisson=0.3), without("poisson")),
        "thickness 122": (replace(best, thickness=122.0), without("thickness")),
        "sides free, no margin": (replace(best, sides=False, margin=0.0), FREE),
        "exponential modulus": (replace(best, power=1.0), without("power")),
    }
    print("| refit | linked | nearest |", " | ".join((*FREE, "ring")), "|")
    for name, (start, free) in others.items():
        gel = fit(beads, start, chosen, free, evaluations=40)
        off, near = beads.errors(linear(gel), gel.centre, test)
        shown = " | ".join(f"{getattr(gel, n):.3g}" for n in (*FREE, "ring"))
        print(f"| {name} | {off:.2f} | {near:.2f} | {shown} |", flush=True)
    left = beads.before[:, 0] < MIDDLE_UM[0]
    for name, side in (("left", left), ("right", ~left)):
        gel = fit(beads, best, np.flatnonzero(side)[::4], evaluations=60)
        off, near = beads.errors(linear(gel), gel.centre, np.flatnonzero(~side))
        print(f"fitted to the {name} half: {off:.2f}, {near:.2f} um on the other", flush=True)


def picture(beads, u, path):
    """Draws the motion of a slice of the beads, measured and predicted."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(2, 1, figsize=(8, 5.2), sharex=True)
    slab = beads.linked & (np.abs(beads.before[:, 1] - 201) < 12)
    for panel, name, v in zip(panels, ("measured (linked beads)", "predicted"), (beads.u, u)):
        x, z = beads.before[slab][:, 0], beads.before[slab][:, 2]
        arrows = dict(angles="xy", scale_units="xy", scale=1, width=0.0015)
        panel.quiver(x, z, v[slab, 0], v[slab, 2], color="tab:blue", **arrows)
        panel.set(title=name, ylabel="z [µm]", aspect="equal", ylim=(0, 125))
    panels[1].set(xlabel="x [µm], section at y = 189 … 213 µm")
    figure.tight_layout()
    figure.savefig(path, dpi=90)


def main():
    """Fits, and prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--fit", action="store_true")
    parser.add_argument("--fine", action="store_true")
    parser.add_argument("--variants", action="store_true")
    parser.add_argument("--picture", type=Path)
    parser.add_argument("--links", type=Path, default=Path("links.npz"))
    options = parser.parse_args()

    beads = Beads(options.data, options.links)
    print(f"seed {SEED}; drift {beads.drift.round(3)} um; linked {beads.linked.mean():.1%}")
    chosen, test = np.flatnonzero(beads.fit)[::4], np.flatnonzero(~beads.fit)
    best = Gel()
    if options.fit:
        begin = time.perf_counter()
        best = fit(beads, START, chosen)
        print(f"fit, {time.perf_counter() - begin:.0f} s: {asdict(best)}")
    moves = {"nothing moves": np.zeros_like, "finite elements": linear(best)}
    for offset in (0.02, 0.05, 0.1, 0.2, 0.3, 0.5):
        moves[f"ChainMail {offset}"] = chainmail(best, offset)
    moves["elastic scan"] = elastic_scan(best)
    if options.fine:
        fine = replace(best, cell=10.0, cell_z=5.0)
        moves["finite elements, fine"] = linear(fine)
        moves["elastic scan, fine"] = elastic_scan(fine)
    for name, move in moves.items():
        off, near = beads.errors(move, best.centre, test)
        print(f"{name}: {off:.2f} um from the linked bead, {near:.2f} from the nearest", flush=True)
    chains = [name for name in moves if name.startswith("ChainMail")]
    chain = min(chains, key=lambda name: sum(beads.errors(moves[name], best.centre, chosen)))
    shown = ("nothing moves", chain, "elastic scan", "finite elements")
    fields = {name: moved(moves[name], best.centre, beads.before) for name in shown}
    table(beads, fields, ~beads.fit)
    if options.picture:
        picture(beads, fields["finite elements"], options.picture)
    if options.variants:
        variants(beads, best, chosen, test)


if __name__ == "__main__":
    main()
