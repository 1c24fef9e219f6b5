#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Writes small files of each kind with the program of an earlier release.

tests/data/make_files.py PROGRAM SOURCES FOLDER

PROGRAM is the release's own `pliant`, SOURCES its source tree, FOLDER the result. Sessions are
recorded through the server by the client of the extension for 3D Slicer; plans and keyframes are
written by the release's own Python and TypeScript (node and viewer/node_modules are needed).
`expected.json` has what the release says of its own files. The script fits release 0.2: see
README.md there for what a later one needs.
"""

import gzip
import http.client
import importlib.util
import json
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import time
import types
import urllib.parse

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "integrations/slicer/Pliant"))
from PliantLib.client import Client  # noqa: E402
from PliantLib.server import Server  # noqa: E402

PROGRAM, SOURCES, FOLDER = (pathlib.Path(a).resolve() for a in sys.argv[1:4])
SIZE = (18, 16, 22)  # voxels of 2 mm, the first at -1 mm
EXPECTED = {}

SETTINGS = """\
[material]
law = "draeger"
range = [-1000, 2000]
offset = 0.25
factor = [1, 0.9, 0.8]
bone_threshold_hu = 700
max_movement_mm = 12
yield = 0.5

[push]
scale = 0.9

[lattice]
brick_size = 8
bounded = true
max_elements = 1000000

[history]
max_steps = 50
max_mb = 64

[air]
enabled = true
threshold_hu = -400
compress = 0.9
stretch = 40
shear = 30
"""

ELASTIC = """\
[material]
elastic = [8, 0.4]

[lattice]
bounded = true
"""

VESSEL = """\
[vessel]
phantom = "bend"
thickness_mm = 1.2

[catheter]
length_mm = 160
radius_mm = 0.8
bend_n_mm2 = 20
tip_bend_n_mm2 = 2
tip_mm = 30

[entry]
place_mm = [0, 0, 5]
direction = [0, 0, 1]

[[script]]
follow = true
insert_mm_s = 100
for_s = 0.2

[[script]]
insert_mm_s = -100
for_s = 0.05
"""

ORGAN = """\
[organs]
scan = "scan.nrrd"
reach_mm = 12

[[body]]
name = "block"
mesh = "organ.vtk"
young_modulus_pa = 5000
held_back = 0.1
"""

IDENTIFICATION = """\
size = "4,4,4"
volume = true
groups = "kinds"
load = ["+z:0,0,-40:0.2,0.3"]
method = ["closed-form", "gauss-newton"]
"""

STUDY = """\
[study]
seed = 7
[parameters]
scan = { scans = "scan.nrrd" }
copy = { count = 2 }
[run]
what = "augment"
breathing = 1.0
pushes = 0
"""


def run(*arguments, may_abort=False):
    """Runs the program in the folder; returns its standard output.

    may_abort: 0.2 without optimisation frees a wrong pointer at the end, when all is written.
    """
    done = subprocess.run(
        [PROGRAM, *map(str, arguments)], cwd=FOLDER, capture_output=True, text=True
    )
    if done.returncode and not (may_abort and done.returncode == -signal.SIGABRT):
        sys.exit(f"{' '.join(map(str, arguments))}: {done.returncode} {done.stderr}")
    return done.stdout


def write_scan():
    """Tissue around a lumen along i, over a plate of bone."""
    values = []
    for k in range(SIZE[2]):
        for j in range(SIZE[1]):
            for i in range(SIZE[0]):
                inside = (j - 8) ** 2 + (k - 12) ** 2 < 8
                tissue = 40 + (3 * i + 5 * j + 7 * k) % 40
                values.append(-1000 if inside else 900 if k < 2 else tissue)
    head = (
        "NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\n"
        f"sizes: {SIZE[0]} {SIZE[1]} {SIZE[2]}\n"
        "space directions: (2,0,0) (0,2,0) (0,0,2)\nkinds: domain domain domain\n"
        "endian: little\nencoding: gzip\nspace origin: (-1,-1,-1)\n\n"
    )
    data = gzip.compress(struct.pack(f"<{len(values)}h", *values), 9, mtime=0)
    (FOLDER / "scan.nrrd").write_bytes(head.encode() + data)


def write_organ():
    """A block of 30 x 30 x 40 mm, five tetrahedra in each cell of 10 mm."""
    nx, ny, nz = 3, 3, 4
    number = {}
    nodes = []
    for k in range(nz + 1):
        for j in range(ny + 1):
            for i in range(nx + 1):
                number[i, j, k] = len(nodes)
                nodes.append((10 * i, 10 * j, 10 * k))
    even = ((0, 1, 2, 4), (1, 3, 2, 7), (1, 4, 5, 7), (2, 4, 7, 6), (1, 2, 4, 7))
    odd = ((0, 1, 3, 5), (0, 3, 2, 6), (0, 4, 5, 6), (3, 5, 7, 6), (0, 3, 5, 6))
    cells = []
    for k in range(nz):
        for j in range(ny):
            for i in range(nx):
                corner = [number[i + (n & 1), j + (n >> 1 & 1), k + (n >> 2)] for n in range(8)]
                for tetrahedron in odd if (i + j + k) % 2 else even:
                    a, b, c, d = (corner[n] for n in tetrahedron)
                    u, v, w = ([nodes[p][x] - nodes[a][x] for x in range(3)] for p in (b, c, d))
                    volume = sum(
                        u[x] * (v[x - 2] * w[x - 1] - v[x - 1] * w[x - 2]) for x in range(3)
                    )
                    cells.append((a, b, c, d) if volume > 0 else (a, c, b, d))
    lines = ["# vtk DataFile Version 3.0", "block", "ASCII", "DATASET UNSTRUCTURED_GRID"]
    lines.append(f"POINTS {len(nodes)} float")
    lines += [" ".join(map(str, node)) for node in nodes]
    lines.append(f"CELLS {len(cells)} {5 * len(cells)}")
    lines += ["4 " + " ".join(map(str, cell)) for cell in cells]
    lines.append(f"CELL_TYPES {len(cells)}")
    lines += ["10"] * len(cells)
    (FOLDER / "organ.vtk").write_text("\n".join(lines) + "\n")


def keep_report(name, path):
    report = json.loads((FOLDER / path).read_text())
    EXPECTED[name] = {key: report[key] for key in ("hash", "status", "moved_elements")}
    (FOLDER / path).unlink()


def states():
    """A state of each model, the deformed scan of each, and ChainMail's fields."""
    (FOLDER / "settings.toml").write_text(SETTINGS)
    (FOLDER / "elastic.toml").write_text(ELASTIC)
    push = ["--push", "15,7,23:1,3,1", "--tool", "sphere:4"]
    run(
        *["deform", "scan.nrrd", "--config", "settings.toml", *push],
        *["--cut", "5,20,30;25,20,30:0,6,0", "--carve", "24,24,12:2"],
        *["--relax-sweeps", "3", "--save-state", "chainmail.plst"],
        *["--out", "chainmail.nrrd", "--displacement", "displacement.nrrd"],
        *["--transform", "transform.nrrd", "--report", "r.json"],
    )
    keep_report("chainmail", "r.json")
    run(
        *["deform", "scan.nrrd", "--config", "elastic.toml", *push],
        *["--save-state", "elastic.plst", "--out", "x.nrrd", "--report", "r.json"],
    )
    keep_report("elastic", "r.json")
    (FOLDER / "x.nrrd").unlink()
    models = {
        "springs": ["--model", "springs", "--cell-mm", "6"],
        "body": ["--model", "body", "--mesh", "organ.vtk"],
        "network": ["--model", "springs", "--network", "network.json"],
    }
    for name, options in models.items():
        run(
            *["deform", "scan.nrrd", *options, *push, "--steps", "4", "--release"],
            *["--save-state", f"{name}.plst", "--out", f"{name}.nrrd", "--report", "r.json"],
            may_abort=name == "network",
        )
        keep_report(name, "r.json")


def identified():
    (FOLDER / "identification.toml").write_text(IDENTIFICATION)
    places = ["--hold", "-1,-1,-1:31,31,1", "--load", "9,9,39:21,21,41:0,0,-0.4"]
    places += ["--load", "29,-1,15:31,31,35:0.2,0.1,0"]
    network = ["--young", "9000", "--volume", "--network-out", "network.json"]
    for name, options in (
        ("box", ["identification.toml"]),
        ("identified", ["--mesh", "organ.vtk", *places, *network]),
    ):
        run("fit", *options, "--report", "r.json")
        report = json.loads((FOLDER / "r.json").read_text())
        EXPECTED[name] = report["methods"][-1]["values"]
    (FOLDER / "r.json").unlink()


def vessel():
    (FOLDER / "vessel.toml").write_text(VESSEL)
    run("vessel", "vessel.toml", "--record", "hand.log", "--report", "r.json")
    report = json.loads((FOLDER / "r.json").read_text())
    EXPECTED["vessel"] = report
    (FOLDER / "r.json").unlink()
    (FOLDER / "organ.toml").write_text(ORGAN)


def upload(link, name):
    """Opens a scan as the page does: a session then names it without its folder."""
    parts = urllib.parse.urlsplit(link)
    token = urllib.parse.parse_qs(parts.fragment)["token"][0]
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=600)
    query = urllib.parse.urlencode({"token": token, "name": name})
    connection.request("POST", f"/open?{query}", (FOLDER / name).read_bytes())
    answer = connection.getresponse()
    text = answer.read().decode()
    if answer.status != 200:
        sys.exit(f"open: {answer.status} {text}")


def session():
    """Records commands, and the hashes of the last state by the release's own replay."""
    tool = {"point": [15, 7, 23], "push": [1, 3, 1], "radius": 4}
    commands = [
        ("materials", {"offset": 0.3, "bone_threshold_hu": 700}),
        ("push", tool),
        ("release", {}),
        ("wait", 1.5),  # a checkpoint
        ("cut", {"line": [[5, 20, 30], [25, 20, 30]], "depth": [0, 6, 0]}),
        ("carve", {"from": [24, 24, 12], "to": [24, 24, 14], "radius": 2}),
        ("undo", {}),
        ("grab", {"point": [15, 23, 23], "radius": 3}),
        ("drag", {"offset": [0, 1, 2]}),
        ("let_go", {}),
        ("slide", {"point": [2, 15, 23], "push": [10, 3, 0], "radius": 2}),
        ("relax", {"on": True}),
        ("wait", 0.3),
        ("relax", {"on": False}),
        ("release", {}),
        ("iso", {"iso_hu": -450}),
        ("wait", 1.5),
    ]
    server = Server(str(PROGRAM), ["--session", "session.pls", "--checkpoint", "1"])
    upload(server.link, "scan.nrrd")
    client = Client(server.link, "files")
    for do, fields in commands:
        if do == "wait":
            time.sleep(fields)
            continue
        answer = client.wait_for(client.send(do, **fields))
        if answer.get("t") == "error":
            sys.exit(f"{do}: {answer}")
    client.close()
    server.stop()
    (FOLDER / "session.pls.links").unlink(missing_ok=True)  # secrets of the server's links
    run("replay", "session.pls", "--json", "--out", "session.nrrd")
    EXPECTED["session"] = json.loads(run("replay", "session.pls", "--json"))


def plan():
    """By the release's own module, which needs none of its compiled code."""
    package = types.ModuleType("pliant")
    package.__path__ = [str(SOURCES / "python/pliant")]
    sys.modules["pliant"] = package
    spec = importlib.util.spec_from_file_location(
        "pliant_plan", SOURCES / "python/pliant/augment/_plan.py"
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules["pliant_plan"] = module
    spec.loader.exec_module(module)
    point = {"point_mm": [15.0, 7.0, 23.0], "radius_mm": 4.0}
    breath = {"point_mm": [15.0, 15.0, 0.0], "by_mm": [0.0, 0.0, -3.0]}
    module.Plan(
        (
            {"kind": "push", **point, "by_mm": [0.5, 2.0, 0.5]},
            {"kind": "pull", **point, "by_mm": [0.0, -1.0, 0.0]},
            {"kind": "swelling", "point_mm": [25.0, 24.0, 30.0], "by_mm": 1.0, "radius_mm": 6.0},
            {"kind": "breath", **breath, "above_mm": 20.0, "below_mm": 5.0, "depth_mm": 10.0},
        ),
        # TissueMotions(offset=0.25, bone_hu=700, tissue={"yield": 0}).tissue_settings
        {
            "offset": 0.25,
            "bone_threshold_hu": 700.0,
            "max_movement_mm": 500.0,
            "air_enabled": False,
            "air_threshold_hu": -500.0,
            "yield": 0,
        },
    ).save(FOLDER / "plan.json")
    (FOLDER / "study.toml").write_text(STUDY)


def keyframes():
    """By the release's own page, of which the part that writes them is bundled alone."""
    shots = [
        {
            "seconds": seconds,
            "camera": {"eye": eye, "look": [0, 0, 1], "up": [0, -1, 0]},
            "fieldOfView": 70 + seconds,
            "iso": -450,
            "window": 1200,
            "level": -100,
        }
        for seconds, eye in ((0, [3, 15, 23]), (1.5, [12, 15, 23]), (2, [28, 16, 23]))
    ]
    script = f"""
        import {{ build }} from 'esbuild';
        const made = await build({{
            entryPoints: ['{SOURCES}/viewer/src/maths/keyframes.ts'],
            bundle: true, format: 'esm', write: false,
        }});
        const code = Buffer.from(made.outputFiles[0].contents).toString('base64');
        const {{ writeKeyframes }} = await import('data:text/javascript;base64,' + code);
        process.stdout.write(writeKeyframes({json.dumps(shots)}));
    """
    done = subprocess.run(
        ["node", "--input-type=module", "--eval", script],
        cwd=ROOT / "viewer",
        capture_output=True,
        check=True,
    )
    (FOLDER / "keyframes.json").write_bytes(done.stdout)


def main():
    shutil.rmtree(FOLDER, ignore_errors=True)
    FOLDER.mkdir(parents=True)
    os.chdir(FOLDER)
    write_scan()
    write_organ()
    identified()
    states()
    vessel()
    session()
    plan()
    keyframes()
    text = json.dumps(EXPECTED, indent=1, sort_keys=True)
    (FOLDER / "expected.json").write_text(text + "\n")
    run("--version")


if __name__ == "__main__":
    main()
