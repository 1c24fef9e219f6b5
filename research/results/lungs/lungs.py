#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The table of docs/howto/morph.md: `pliant morph` on landmark pairs of measured lungs.

The outermost 30 % of the landmarks (by the distance from the centre, each axis in standard
deviations) are known. The error is the mean distance [mm] of the inner 70 %.

    python3 lungs.py DATA --program build/release/pliant              # prints the table
    python3 lungs.py DATA --program … --write docs/howto/morph.md     # puts it in the page

DATA holds `4dct_caseNN_landmarks.csv`, `copd_caseNN_landmarks.csv` and
`copd_caseNN_{exhale,inhale}_mask.nii.gz`. Only Python itself is needed.
"""

import argparse
import csv
import json
import math
import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

BEGIN, END = "<!-- lungs.py -->\n", "<!-- end -->\n"
FROM = [f"from_{axis}_mm" for axis in "xyz"]
TO = [f"to_{axis}_mm" for axis in "xyz"]
ROWS = (  # kind, name, known points, masks, options
    ("4dct", "4DCT, points", True, False, []),
    ("copd", "COPD, points", True, False, []),
    ("copd", "COPD, points and masks", True, True, []),
    ("copd", "COPD, masks", False, True, []),
    ("copd", "COPD, masks, `--prior none`", False, True, ["--prior", "none"]),
)


def read_landmarks(path):
    """Pairs of points, those that are far from the centre first."""
    with path.open(newline="") as file:
        rows = [[float(x) for x in row[:6]] for row in list(csv.reader(file))[1:]]
    axes = list(zip(*rows))[:3]
    middle = [statistics.fmean(axis) for axis in axes]
    spread = [statistics.pstdev(axis) for axis in axes]
    return sorted(
        rows, key=lambda row: -sum(((row[a] - middle[a]) / spread[a]) ** 2 for a in range(3))
    )


def write_table(path, names, rows):
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([names, *rows])


def processor_seconds():
    """Of all commands so far. Other work on the machine hardly changes it."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_case(options, folder, kind, number, row):
    """Mean error with and without the motion [mm], report, processor time of the command [s]."""
    _, _, with_points, with_masks, more = row
    name = f"{kind}_case{number:02d}"
    pairs = read_landmarks(options.data / f"{name}_landmarks.csv")
    count = round(0.3 * len(pairs))
    write_table(folder / "known.csv", FROM + TO, pairs[:count])
    write_table(folder / "query.csv", FROM, [pair[:3] for pair in pairs[count:]])
    command = [options.program, "morph"]
    if with_masks:
        command += [options.data / f"{name}_{phase}_mask.nii.gz" for phase in ("exhale", "inhale")]
    if with_points:
        command += ["--points", "known.csv"]
    command += ["--predict", "query.csv", "--out", "out.csv", "--report", "report.json", *more]
    before = processor_seconds()
    subprocess.run([str(part) for part in command], cwd=folder, check=True, capture_output=True)
    seconds = processor_seconds() - before
    with (folder / "out.csv").open(newline="") as file:
        found = [[float(row[name]) for name in TO] for row in csv.DictReader(file)]
    asked = pairs[count:]
    error = statistics.fmean(math.dist(p, pair[3:]) for p, pair in zip(found, asked))
    still = statistics.fmean(math.dist(pair[:3], pair[3:]) for pair in asked)
    report = json.loads((folder / "report.json").read_text())
    return error, still, report, seconds


def table(options):
    lines = [
        "| mean distance [mm], cases 1 … 5 | 1 | 2 | 3 | 4 | 5 | mean | share of the motion "
        "| least volume left | processor time |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in ROWS:
        with tempfile.TemporaryDirectory() as folder:
            cases = [run_case(options, Path(folder), row[0], n, row) for n in range(1, 6)]
        errors, stills = [case[0] for case in cases], [case[1] for case in cases]
        name = row[1].split(",")[0] + ", nothing moves"
        if not any(name in line for line in lines):
            cells = " | ".join(f"{still:.2f}" for still in [*stills, statistics.fmean(stills)])
            lines.append(f"| {name} | {cells} | | | |")
        mean = statistics.fmean(errors)
        lines.append(
            f"| {row[1]} | "
            + " | ".join(f"{error:.2f}" for error in errors)
            + f" | **{mean:.2f}** | {100 * mean / statistics.fmean(stills):.0f} % "
            f"| {min(case[2]['least_volume'] for case in cases):.2f} "
            f"| {max(case[3] for case in cases):.2f} s |"
        )
        print(lines[-1], file=sys.stderr)
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--program", type=Path, default=Path("build/release/pliant"))
    parser.add_argument("--write", type=Path, help="page with the table's place")
    options = parser.parse_args()
    options.data, options.program = options.data.resolve(), options.program.resolve()
    text = table(options)
    if not options.write:
        print(text, end="")
        return
    page = options.write.read_text()
    head, rest = page.split(BEGIN)
    options.write.write_text(head + BEGIN + "\n" + text + "\n" + END + rest.split(END, 1)[1])


if __name__ == "__main__":
    main()
