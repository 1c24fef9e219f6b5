# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Force of a body at rest with the default sub-steps, over that with many.

A block of 60 x 60 x 30 mm and 15 kPa on a held foot, of five tetrahedra a cube; the nodes of its
top within 8 mm of its middle are pushed down by 4 mm.

    python sub_steps.py PROGRAM
"""

import itertools
import json
import subprocess
import sys
import tempfile
from pathlib import Path

SIZE_MM = (60, 60, 30)
MANY = 100
# A cube's corners as bits x, y, z: the middle tetrahedron and four around it, for even cubes.
FIVE = ((0, 3, 5, 6), (1, 0, 3, 5), (2, 0, 6, 3), (4, 0, 5, 6), (7, 3, 6, 5))


def turned_outwards(nodes, cell):
    """The cell with a positive volume."""
    edges = [[nodes[n][a] - nodes[cell[0]][a] for a in range(3)] for n in cell[1:]]
    (a, b, c), (d, e, f), (g, h, i) = edges
    volume = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    return cell if volume > 0 else (cell[0], cell[2], cell[1], cell[3])


def write_block(file, side):
    counts = [length // side for length in SIZE_MM]
    index = {p: n for n, p in enumerate(itertools.product(*(range(c + 1) for c in counts)))}
    nodes = [tuple(side * i for i in p) for p in index]
    cells = []
    for cube in itertools.product(*map(range, counts)):
        flip = sum(cube) % 2  # odd cubes are mirrored, so that faces fit
        for cell in FIVE:
            bits = [(n & 1 ^ flip, n >> 1 & 1, n >> 2) for n in cell]
            corners = [tuple(at + bit for at, bit in zip(cube, of)) for of in bits]
            cells.append(turned_outwards(nodes, tuple(index[p] for p in corners)))
    lines = ["# vtk DataFile Version 3.0", "block", "ASCII", "DATASET UNSTRUCTURED_GRID"]
    lines += [f"POINTS {len(nodes)} double"] + [" ".join(map(str, p)) for p in nodes]
    lines += [f"CELLS {len(cells)} {5 * len(cells)}"]
    lines += [" ".join(map(str, (4, *cell))) for cell in cells]
    lines += [f"CELL_TYPES {len(cells)}"] + ["10"] * len(cells)
    file.write_text("\n".join(lines) + "\n")


def force_n(program, folder, sub_steps):
    wanted = f"sub_steps = {sub_steps}\n" if sub_steps else ""
    (folder / "block.toml").write_text(
        f'[organs]\n{wanted}[[body]]\nname = "block"\nmesh = "block.vtk"\n'
        "held_mm = [[-1, -1, -1], [61, 61, 0.01]]\n"
    )
    command = [program, "body", "block.toml", "--push", "30,30,30:0,0,-4", "--tool", "sphere:8"]
    subprocess.run([*command, "--report", "report.json"], cwd=folder, check=True, stdout=2)
    return json.loads((folder / "report.json").read_text())["body"]["force_n"][2]


def main():
    program = Path(sys.argv[1]).resolve()
    for side in (5, 3):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            write_block(folder / "block.vtk", side)
            default, many = force_n(program, folder, 0), force_n(program, folder, MANY)
        print(f"cubes of {side} mm: {default:.3f} N, in {MANY} sub-steps {many:.3f} N")


if __name__ == "__main__":
    main()
