# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Lattices, errors, times and tables that the set-ups have in common.

A variant is a program with a mesh and settings. `run()` of a variant returns its set-up time and a
list of points (seconds, error): one for a direct solution, one for each checkpoint of an iteration.
Times exclude the computation of errors. All are processor times of one thread, with the wall time
beside them.
"""

import json
import os
import statistics
import time

for _name in ("OMP", "MKL", "OPENBLAS", "NUMBA"):  # before numpy is imported
    os.environ[_name + "_NUM_THREADS"] = "1"

import numpy as np  # noqa: E402
from scipy.ndimage import map_coordinates  # noqa: E402

LEVELS = (5.0, 2.0, 1.0)  # [%]
LONG_S = 6.0


class Clock:
    """Processor and wall time, which can be paused."""

    def __init__(self):
        self.cpu = self.wall = 0.0
        self.start()

    def start(self):
        """Goes on."""
        self._cpu, self._wall = time.process_time(), time.perf_counter()

    def stop(self):
        """Pauses; returns the times so far."""
        self.cpu += time.process_time() - self._cpu
        self.wall += time.perf_counter() - self._wall
        return self.cpu, self.wall


def lattice(size, cells):
    """Nodes (n, 3) of a lattice over a box at the origin, x fastest."""
    axes = [np.linspace(0, s, n + 1) for s, n in zip(size, cells, strict=True)]
    z, y, x = np.meshgrid(*axes[::-1], indexing="ij")
    return np.stack([x, y, z], axis=-1).reshape(-1, 3)


def sample(values, size, cells, points):
    """Trilinear interpolation of nodal vectors, x fastest, at points."""
    grid = np.asarray(values, float).reshape(*(n + 1 for n in cells[::-1]), 3)
    at = (points / size * cells).T[::-1]
    return np.stack([map_coordinates(grid[..., a], at, order=1) for a in range(3)], axis=-1)


def to_lattice(rest, values, size, cells):
    """Reorders nodal vectors by rest positions into the lattice's order."""
    index = np.rint(rest / size * cells).astype(int)
    out = np.full((np.prod(np.array(cells) + 1), 3), np.nan)
    nx, ny = cells[0] + 1, cells[1] + 1
    out[index[:, 0] + nx * (index[:, 1] + ny * index[:, 2])] = values
    assert np.isfinite(out).all()
    return out


def relative(u, reference):
    """L2 norm of the difference over that of the reference [%]."""
    return 100 * np.linalg.norm(u - reference) / np.linalg.norm(reference)


def time_to(points, level):
    """First time from which on the error stays below the level, or None."""
    best = None
    for point in points:
        if point[2] <= level:
            best = best or point
        else:
            best = None
    return best


class Variant:
    """A program, its settings in words, and a function that runs it."""

    def __init__(self, program, settings, run):
        self.program, self.settings, self.run = program, settings, run


def compare(variants, repeats=5, out=None, log=print, levels=LEVELS):
    """Runs all variants once, then those that are fastest to a level again, interleaved.

    Runs of more than LONG_S seconds are not repeated. Returns rows: program, and for each level
    (settings, processor and wall time, set-up) or None; the smallest error of the program.
    """
    first = {}
    for v in variants:
        try:
            setup, points = v.run()
        except Exception as fault:  # noqa: BLE001  (another program's, reported)
            log(f"{v.program}, {v.settings}: {type(fault).__name__}: {str(fault)[:300]}")
            continue
        first[v] = [(setup, points)]
        ends = ", ".join(f"{p[0]:.3g} s {p[2]:.2f} %" for p in points[-1:])
        log(f"{v.program}, {v.settings}: set-up {setup[0]:.3g} s, {ends}", flush=True)
    chosen = {}
    for program in dict.fromkeys(v.program for v in first):
        for level in levels:
            fits = [
                (time_to(first[v][0][1], level)[0], i, v)
                for i, v in enumerate(first)
                if v.program == program and time_to(first[v][0][1], level)
            ]
            if fits:
                chosen[program, level] = min(fits)[2]
    again = list(dict.fromkeys(chosen.values()))
    again = [v for v in again if first[v][0][1][-1][0] < LONG_S]
    for _ in range(repeats - 1):
        for v in again:
            first[v].append(v.run())
    rows = []
    for program in dict.fromkeys(v.program for v in first):
        row = {"program": program, "levels": {}}
        mine = [v for v in first if v.program == program]
        row["best"] = min((first[v][0][1][-1][2], v.settings) for v in mine)
        for level in levels:
            v = chosen.get((program, level))
            if v is None:
                row["levels"][level] = None
                continue
            hits = [time_to(points, level) for _, points in first[v]]
            hits = [h for h in hits if h]
            row["levels"][level] = {
                "settings": v.settings,
                "cpu": statistics.median(h[0] for h in hits),
                "wall": statistics.median(h[1] for h in hits),
                "setup": statistics.median(s[0] for s, _ in first[v]),
                "runs": len(hits),
            }
        row["curve"] = [
            {"settings": v.settings, "setup": first[v][0][0], "points": first[v][0][1]}
            for v in mine
        ]
        rows.append(row)
    if out:
        with open(out, "w", encoding="utf-8") as file:
            json.dump({"load": os.getloadavg(), "rows": rows}, file)
    return rows


def milliseconds(seconds):
    """A time in words."""
    return f"{1000 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def table(rows, levels=LEVELS, base="Pliant"):
    """A Markdown table; the ratio is to the fastest row whose program begins with `base`."""
    heads = " | ".join(f"{level:.0f} %" for level in levels)
    lines = [f"| program | {heads} | smallest error |", "|---|" + "---:|" * (len(levels) + 1)]
    for row in rows:
        cells = []
        for level in levels:
            hit = row["levels"][level]
            own = [
                r["levels"][level]["cpu"]
                for r in rows
                if r["program"].startswith(base) and r["levels"][level]
            ]
            if hit is None:
                cells.append("not reached")
            else:
                ratio = f", {hit['cpu'] / min(own):.2g}×" if own else ""
                cells.append(f"{milliseconds(hit['cpu'])} ({milliseconds(hit['setup'])}){ratio}")
        best = f"{row['best'][0]:.2g} %"
        lines.append(f"| {row['program']} | {' | '.join(cells)} | {best} |")
    lines += ["", "Fastest settings, with the wall time and the number of runs:", ""]
    for row in rows:
        for level in levels:
            hit = row["levels"][level]
            if hit:
                wall, runs = milliseconds(hit["wall"]), hit["runs"]
                what = f"{row['program']}, {level:.0f} %: {hit['settings']}"
                lines.append(f"* {what}; wall {wall}; {runs} runs")
    return "\n".join(lines)
