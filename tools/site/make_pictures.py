# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Pictures of docs/images that the program makes of its phantoms: `./dev pictures`.

python make_pictures.py PROGRAM ROOT FOLDER [NAME…]     all, or those of these names
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import matplotlib
import numpy
from PIL import Image, ImageDraw

import pliant
import pliant.plot

matplotlib.use("Agg")
from matplotlib import pyplot

LARGEST_BYTES = 60_000
AIRWAY_PUSH = ((12.6, -2.7, -14.8), (-2.5, -4, -3.7))
CARINA_PUSH = ((2.5, -1, -9), (6, 0, 0))
CARINA_EYE = ["--eye=0.3,-2.2,22", "--look=-0.019,0.045,-0.999"]
PICTURES = {}


def picture(make):
    PICTURES[make.__name__] = make
    return make


class Workshop:
    """A folder with the phantoms, and the program."""

    def __init__(self, program, root, folder):
        self.program, self.root, self.folder = Path(program).resolve(), Path(root).resolve(), folder

    def run(self, *arguments):
        subprocess.run(
            [self.program, *map(str, arguments)], cwd=self.folder, check=True, capture_output=True
        )

    def phantom(self, name, size=96):
        file = f"{name}{size}.nrrd"
        if not (self.folder / file).exists():
            self.run("phantom", name, "--size", size, "--out", file)
        return file

    def volume(self, name, size=96):
        return pliant.read_volume(self.folder / self.phantom(name, size))

    def image(self, file, width=None):
        image = Image.open(self.folder / file).convert("RGB")
        if width:
            image = image.resize((width, image.height * width // image.width), Image.LANCZOS)
        return image

    def renders(self, calls, side):
        """Pictures of `pliant render` side by side, each with a title."""
        row = Image.new("RGB", (len(calls) * (side + 4) - 4, side + 16), "white")
        draw = ImageDraw.Draw(row)
        for n, (title, arguments) in enumerate(calls):
            self.run("render", *arguments, "--size", f"{2 * side}x{2 * side}", "--out", "view.png")
            row.paste(self.image("view.png", side), (n * (side + 4), 16))
            draw.text((n * (side + 4) + 2, 2), title, fill="black")
        return row


def coronal_of(volume, y_mm):
    """Index of the slice across j at a position, and its extent: x to the left, z up."""
    size, spacing, origin = volume.size, volume.spacing_mm, volume.origin_mm
    index = round((y_mm - origin[1]) / spacing[1])
    low = [origin[a] - spacing[a] / 2 for a in (0, 2)]
    high = [low[n] + size[a] * spacing[a] for n, a in enumerate((0, 2))]
    return index, (low[0], high[0], low[1], high[1])


def draw_coronal(ax, volume, y_mm, window=(-1000, 500)):
    index, extent = coronal_of(volume, y_mm)
    shown = volume.array[:, index, :]
    ax.imshow(shown, cmap="gray", vmin=window[0], vmax=window[1], extent=extent, origin="lower")
    ax.set(xlabel="to L [mm]")
    return index, extent


def draw_lengths(ax, field, index, extent, levels=(0.25, 0.5, 1, 2, 3, 4, 5), named=True):
    lengths = numpy.linalg.norm(field.array[:, index, :, :], axis=-1)
    lines = ax.contour(
        lengths, levels=levels, extent=extent, cmap="plasma", linewidths=1.1, vmin=0, vmax=6
    )
    if named:
        ax.clabel(lines, fontsize=6, fmt="%g")


def of_figure(figure, dpi=90):
    figure.canvas.draw()
    figure.set_dpi(dpi)
    figure.canvas.draw()
    image = Image.fromarray(numpy.asarray(figure.canvas.buffer_rgba())[..., :3].copy())
    pyplot.close(figure)
    return image


def pushed(scan, push, radius_mm=4.0, **settings):
    tissue = pliant.make_chainmail(scan, **settings)
    tissue.push(*push, sphere_radius_mm=radius_mm)
    return tissue


@picture
def hello(w):
    w.run(
        "deform",
        w.phantom("airway", 128),
        "--push",
        "12.6,-2.7,-14.8:-2.5,-4,-3.7",
        "--tool",
        "sphere:4",
        "--out",
        "a.nrrd",
        "--png",
        "a.png",
        "--style",
        "real",
    )
    return w.image("a.png", 800)


@picture
def push_cut(w):
    w.run(
        "deform",
        w.phantom("airway"),
        "--cut",
        "-0.2,-8,-5;-0.2,8,-5:0,0,-12",
        "--push",
        "2.5,-1,-9:6,0,0",
        "--tool",
        "sphere:3",
        "--relax",
        200,
        *CARINA_EYE,
        "--style",
        "real",
        "--out",
        "a.nrrd",
        "--png",
        "a.png",
    )
    return w.image("a.png", 800)


@picture
def threshold(w):
    scan = w.phantom("airway")
    return w.renders(
        [
            (f"--iso {iso}", [scan, "--view", "endoscope", "--iso", iso, *CARINA_EYE])
            for iso in (-900, -500, -100)
        ],
        240,
    )


@picture
def kinds_of_scans(w):
    vessel = ["--iso", 160, "--polarity", "falling"]
    return w.renders(
        [
            (
                "airway, rising at -500 HU",
                [w.phantom("airway"), "--view", "endoscope", "--style", "real"],
            ),
            (
                "vessel, falling at 160 HU",
                [w.phantom("vessel", 128), *vessel, "--view", "endoscope", "--style", "real"],
            ),
            (
                "vessel, axial, window 500, level 150",
                [
                    w.phantom("vessel", 128),
                    *vessel,
                    "--view",
                    "axial",
                    "--window",
                    500,
                    "--level",
                    150,
                ],
            ),
        ],
        240,
    )


@picture
def tune_tissue(w):
    scan = w.volume("airway")
    figure, axes = pyplot.subplots(1, 4, figsize=(9.6, 2.9), constrained_layout=True, sharey=True)
    for ax, (title, settings) in zip(
        axes,
        {
            "offset = 0.4": {"offset": 0.4, "limits": "rounded"},
            "offset = 0.2 (default)": {"limits": "rounded"},
            "offset = 0.05": {"offset": 0.05, "limits": "rounded"},
            'limits = "box"': {"limits": "box"},
        }.items(),
        strict=True,
    ):
        tissue = pushed(scan, CARINA_PUSH, **settings)
        index, extent = draw_coronal(ax, tissue.volume(), -1)
        draw_lengths(
            ax, tissue.displacement_field(), index, extent, (0.5, 1, 2, 3, 4, 5), named=False
        )
        ax.set(title=title, xlim=(-30, 30), ylim=(-42, 18))
    axes[0].set(ylabel="to S [mm]")
    return of_figure(figure)


@picture
def elastic(w):
    scan = w.volume("airway")
    figure, axes = pyplot.subplots(1, 3, figsize=(8.4, 3.2), constrained_layout=True, sharey=True)
    draw_coronal(axes[0], scan, -1)
    axes[0].set(title="at rest")
    whole = pliant.make_elastic(scan)
    whole.push(*AIRWAY_PUSH, sphere_radius_mm=4)
    whole.advance()
    for ax, title, tissue in (
        (axes[1], "ChainMail, |u| [mm]", pushed(scan, AIRWAY_PUSH, limits="rounded")),
        (axes[2], "elastic scan, |u| [mm]", whole),
    ):
        index, extent = draw_coronal(ax, tissue.volume(), -3)
        draw_lengths(ax, tissue.displacement_field(), index, extent)
        ax.set(title=title)
    axes[0].set(ylabel="to S [mm]")
    return of_figure(figure)


@picture
def fields(w):
    """Arrows of both fields, on the grids on which they live."""
    scan = w.volume("airway")
    tissue = pushed(scan, AIRWAY_PUSH)
    figure, axes = pyplot.subplots(1, 2, figsize=(7.2, 3.7), constrained_layout=True, sharey=True)
    for ax, title, shown, field in (
        (axes[0], "--displacement, on the scan at rest", scan, tissue.displacement_field()),
        (axes[1], "--transform, on the pushed scan", tissue.volume(), tissue.inverse_field()),
    ):
        index, _ = draw_coronal(ax, shown, -2.7)
        u = field.array[::2, index, ::2, :]
        x, z = (
            numpy.array(scan.origin_mm)[a] + scan.spacing_mm[a] * numpy.arange(0, scan.size[a], 2)
            for a in (0, 2)
        )
        seen = numpy.linalg.norm(u, axis=-1) > 0.3
        at = numpy.meshgrid(x, z)
        ax.quiver(
            at[0][seen],
            at[1][seen],
            u[..., 0][seen],
            u[..., 2][seen],
            color="tab:orange",
            angles="xy",
            scale_units="xy",
            scale=1,
            width=0.004,
        )
        ax.set(title=title, xlim=(-5, 35), ylim=(-35, 5))
    axes[0].set(ylabel="to S [mm]")
    return of_figure(figure)


@picture
def truth(w):
    w.run(
        "truth",
        "make",
        w.phantom("airway", 64),
        "--cases",
        1,
        "--kinds",
        "contact,cut,interface",
        "--seed",
        7,
        "--out",
        "truth",
    )
    case = next(p for p in (w.folder / "truth").iterdir() if p.is_dir())
    fixed = pliant.read_volume(w.folder / "truth/fixed.nrrd")
    moving = pliant.read_volume(case / "moving.nrrd")
    labels = pliant.read_volume(case / "labels.nrrd")
    forward = pliant.read_field(case / "forward.nrrd")
    lengths = numpy.linalg.norm(forward.array, axis=-1)
    richest = (lengths * (labels.array > 0)).sum(axis=(0, 2)).argmax()
    y_mm = fixed.origin_mm[1] + fixed.spacing_mm[1] * int(richest)
    figure, axes = pyplot.subplots(1, 4, figsize=(10, 2.9), constrained_layout=True, sharey=True)
    draw_coronal(axes[0], fixed, y_mm)
    index, extent = draw_coronal(axes[1], moving, y_mm)
    seen = axes[2].imshow(lengths[:, index, :], extent=extent, origin="lower", cmap="viridis")
    figure.colorbar(seen, ax=axes[2], shrink=0.8)
    colours = matplotlib.colormaps["Set2"].resampled(6)
    kinds = axes[3].imshow(
        labels.array[:, index, :], extent=extent, origin="lower", cmap=colours, vmin=-0.5, vmax=5.5
    )
    bar = figure.colorbar(kinds, ax=axes[3], ticks=range(6), shrink=0.8)
    bar.ax.set_yticklabels(["air", "interior", "bone", "wall", "interface", "cut"], fontsize=7)
    for ax, title in zip(axes, ("fixed", "moving", "|forward| [mm]", "labels"), strict=True):
        ax.set(title=title, xlabel="to L [mm]")
    axes[0].set(ylabel="to S [mm]")
    return of_figure(figure, 80)


@picture
def morph(w):
    """The known points of docs/howto/morph.md."""
    scan = w.volume("knee", 64)
    known = [[0, 0, 0], [20, 0, 0], [0, 20, 0], [0, 0, 20], [-20, -10, 5]]
    found = [[2, 0, 0], [23, 0, 0], [2, 22, 0], [2, 0, 21], [-18, -10, 5]]
    motion = pliant.morph(from_mm=known, to_mm=found)
    field = motion.forward_field(scan)
    figure, axes = pyplot.subplots(1, 2, figsize=(7.2, 3.8), constrained_layout=True, sharey=True)
    index, extent = draw_coronal(axes[0], scan, 0, (-1000, 1500))
    u = field.array[::4, index, ::4, :]
    x, z = (numpy.linspace(extent[n], extent[n + 1], 64, endpoint=False)[::4] for n in (0, 2))
    half = (extent[1] - extent[0]) / 128
    axes[0].quiver(
        x + half,
        z + half,
        u[..., 0],
        u[..., 2],
        color="tab:orange",
        angles="xy",
        scale_units="xy",
        scale=0.4,
        width=0.004,
    )
    axes[0].plot(*numpy.array(known)[:, [0, 2]].T, "x", color="tab:cyan")
    axes[0].set(title="known points, motion × 2.5", ylabel="to S [mm]")
    moved = motion.inverse_field(scan).apply_to_volume(scan)
    draw_coronal(axes[1], moved, 0, (-1000, 1500))
    axes[1].plot(*numpy.array(found)[:, [0, 2]].T, "+", color="tab:cyan")
    axes[1].set(title="moved, and where they were found")
    return of_figure(figure, 80)


@picture
def sections(w):
    scan = w.volume("airway")
    tissue = pushed(scan, AIRWAY_PUSH)
    figure, axes = pyplot.subplots(1, 3, figsize=(9, 3.3), constrained_layout=True)
    pliant.plot.sections(
        tissue.volume(),
        AIRWAY_PUSH[0],
        field=tissue.displacement_field(),
        net_mm=4,
        window=1500,
        level=-200,
        axes=axes,
    )
    for ax in axes:  # around the point, the last that was drawn
        (x,), (y,) = ax.lines[-1].get_data()
        up = ax.get_ylim()[0] < ax.get_ylim()[1]
        ax.set(xlim=(x - 25, x + 25), ylim=(y - 25, y + 25) if up else (y + 25, y - 25))
    return of_figure(figure, 80)


def write_ball(file, centre_mm, radius_mm, count=24):
    """A sphere of triangles, as an OBJ file."""
    rings = numpy.linspace(0, numpy.pi, count + 1)[1:-1]
    turns = numpy.arange(2 * count) * numpy.pi / count
    points = [(0, 0, 1)] + [
        (numpy.sin(a) * numpy.cos(b), numpy.sin(a) * numpy.sin(b), numpy.cos(a))
        for a in rings
        for b in turns
    ]
    points.append((0, 0, -1))

    def at(ring, turn):
        return 2 + ring * 2 * count + turn % (2 * count)

    last = count - 2
    faces = [(1, at(0, t), at(0, t + 1)) for t in range(2 * count)]
    faces += [(len(points), at(last, t + 1), at(last, t)) for t in range(2 * count)]
    for r in range(last):
        for t in range(2 * count):
            faces += [
                (at(r, t), at(r + 1, t), at(r + 1, t + 1)),
                (at(r, t), at(r + 1, t + 1), at(r, t + 1)),
            ]
    lines = [
        "v {} {} {}".format(*(numpy.array(centre_mm) + radius_mm * numpy.array(p))) for p in points
    ]
    lines += ["f {} {} {}".format(*face) for face in faces]
    file.write_text("\n".join(lines) + "\n")


@picture
def organs(w):
    """Two balls as bodies; the left one is pushed into the right one."""
    write_ball(w.folder / "left.obj", (-26, 0, 0), 25)
    write_ball(w.folder / "right.obj", (26, 0, 0), 25)
    (w.folder / "two.toml").write_text(
        "[organs]\nreach_mm = 30\ntetrahedra = 3000\n"
        + "".join(
            f'[[body]]\nname = "{n}"\nmesh = "{n}.obj"\nyoung_modulus_pa = {e}\nheld_back = 0.1\n'
            for n, e in (("left", 15000), ("right", 4000))
        )
    )
    both = pliant.make_organs(w.folder / "two.toml")
    tissue = both.make_tissue()
    figure, axes = pyplot.subplots(1, 2, figsize=(8, 2.8), constrained_layout=True, sharey=True)
    draw_coronal(axes[0], both.scan, 0)
    tissue.push((-12, 0, 0), (14, 0, 0), sphere_radius_mm=10)
    tissue.advance()
    draw_coronal(axes[1], tissue.volume(), 0)
    axes[0].set(title="at rest", ylabel="to S [mm]")
    axes[1].set(title="the left one pushed by 14 mm to L")
    for ax, x_mm in zip(axes, (-12, 2), strict=True):
        ax.add_patch(pyplot.Circle((x_mm, 0), 10, fill=False, color="tab:orange"))
    return of_figure(figure)


@picture
def identified(w):
    """The commands of docs/howto/tutorial_identify.md."""
    page = (w.root / "docs/howto/tutorial_identify.md").read_text(encoding="utf-8")
    blocks = [part.split("```")[0] for part in page.split("```sh\n")[1:]]
    for block in blocks[:-1]:
        subprocess.run(
            block.replace("pliant ", f"{w.program} "),
            shell=True,
            cwd=w.folder,
            check=True,
            capture_output=True,
        )
    w.run(
        "deform",
        "scan.nrrd",
        "--model",
        "springs",
        "--network",
        "fit.json",
        "--push",
        "0,0,29:0,0,-7",
        "--tool",
        "sphere:9",
        "--out",
        "a.nrrd",
        "--png",
        "a.png",
    )
    return w.image("a.png", 800)


@picture
def lumen_path(w):
    scan = w.phantom("airway")
    w.run(
        "path", scan, "--from=0.3,-1.8,40", "--to=25,1.3,-24", "--reach", 5, "--out", "w.mrk.json"
    )
    curve = json.loads((w.folder / "w.mrk.json").read_text())["markups"][0]["controlPoints"]
    points = numpy.array([point["position"] for point in curve])
    figure, ax = pyplot.subplots(figsize=(3.1, 3.1), constrained_layout=True)
    draw_coronal(ax, pliant.read_volume(w.folder / scan), -1)
    ax.plot(points[:, 0], points[:, 2], color="tab:orange", linewidth=1.5)
    chosen = [len(points) // 6, len(points) // 2, len(points) - 4]
    views = []
    for number, at in enumerate(chosen):
        ax.plot(points[at, 0], points[at, 2], "o", color="tab:cyan")
        ax.annotate(f" {number + 1}", (points[at, 0], points[at, 2]), color="tab:cyan")
        eye, look = points[at], points[at + 2] - points[at]
        views.append(
            (
                str(number + 1),
                [
                    scan,
                    "--view",
                    "endoscope",
                    "--style",
                    "real",
                    "--eye=" + ",".join(map(str, eye)),
                    "--look=" + ",".join(map(str, look)),
                ],
            )
        )
    ax.set(ylabel="to S [mm]")
    left, right = of_figure(figure, 78), w.renders(views, 190)
    both = Image.new("RGB", (left.width + right.width + 6, left.height), "white")
    both.paste(left, (0, 0))
    both.paste(right, (left.width + 6, (left.height - right.height) // 2))
    return both


@picture
def rendering(w):
    scan = w.phantom("airway", 128)
    return w.renders(
        [
            ("endoscope, plain", [scan, "--view", "endoscope", *CARINA_EYE]),
            ("endoscope, real", [scan, "--view", "endoscope", "--style", "real", *CARINA_EYE]),
            (
                "blended",
                [scan, "--view", "blended", "--eye", "0,-260,0", "--look", "0,1,0", "--fov", "40"],
            ),
            ("fluoroscopy", [scan, "--view", "fluoroscopy", "--look", "0,1,0"]),
        ],
        200,
    )


@picture
def mesh(w):
    """An organ's tetrahedra, whole and cut open."""
    w.run(
        "mesh",
        w.phantom("layers", 64),
        "--labels",
        "0",
        "--solid",
        "--tetrahedra",
        2500,
        "--out",
        "organ.vtu",
    )
    tetrahedra = pliant.read_tetrahedra(w.folder / "organ.vtu")
    nodes, cells = numpy.array(tetrahedra.nodes_mm), numpy.array(tetrahedra.cells)
    figure = pyplot.figure(figsize=(7.2, 3.0), constrained_layout=True)
    for n, (title, kept) in enumerate(
        (
            ("surface", cells),
            ("cut open at y = 0", cells[(nodes[cells].mean(axis=1)[:, 1] > 0)]),
        )
    ):
        ax = figure.add_subplot(1, 2, n + 1, projection="3d")
        used, renumbered = numpy.unique(kept, return_inverse=True)
        part = pliant.TetMesh(nodes[used], renumbered.reshape(kept.shape))
        faces = pliant.boundary_triangles(part)
        ax.plot_trisurf(
            *numpy.array(faces.nodes_mm).T,
            triangles=numpy.array(faces.cells),
            color="lightsteelblue",
            edgecolor="dimgray",
            linewidth=0.3,
        )
        ax.set(title=title, box_aspect=numpy.ptp(nodes, axis=0), xlabel="x [mm]", ylabel="y [mm]")
        ax.view_init(elev=25, azim=-70)
    return of_figure(figure)


@picture
def vessel(w):
    """A wire in a soft bend, whose wall it displaces."""
    w.run("vessel", w.root / "scenes/vessel_soft.toml", "--png", "a.png")
    return w.image("a.png", 480)


def save(image, file):
    """As the best WebP that is small enough."""
    for quality in range(85, 20, -5):
        image.save(file, quality=quality, method=6)
        if file.stat().st_size < LARGEST_BYTES:
            return quality
    raise SystemExit(f"pictures: {file}: expected at most {LARGEST_BYTES} bytes")


def main():
    program, root, folder, *names = sys.argv[1:]
    if unknown := set(names) - set(PICTURES):
        sys.exit(f"pictures: expected {', '.join(PICTURES)}, found '{min(unknown)}'")
    for name in names or PICTURES:
        with tempfile.TemporaryDirectory() as work:
            image = PICTURES[name](Workshop(program, root, Path(work)))
        file = Path(folder) / f"{name}.webp"
        quality = save(image, file)
        print(f"{file}: {image.width} x {image.height}, {file.stat().st_size} bytes, {quality} %")


if __name__ == "__main__":
    main()
