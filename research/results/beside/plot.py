# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Draws the error over the processor time of the runs that the scripts wrote.

    python plot.py FOLDER beside.png
"""

import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

SETUPS = {
    "block-0.3-3.0": "block, pressed by a patch, 10 %",
    "contact": "block, pressed by a ball",
    "beam": "cantilever under its weight",
    "rod-bent": "rod bent by a force",
    "rod-laid": "rod laid on a floor",
}
COLOURS = {"Pliant": "tab:blue", "MuJoCo": "tab:orange", "felupe": "tab:green"}
COLOURS |= {"PyElastica": "tab:red", "Newton": "tab:purple"}
STYLES = {"Pliant, elastic scan": "s", "Pliant, linear elements": "^"}
STYLES |= {"felupe, graded quarter": "s"}


def main():
    """One panel for each set-up, with the smallest errors of each program by time."""
    folder = Path(sys.argv[1])
    found = [name for name in SETUPS if (folder / f"{name}.json").exists()]
    figure, panels = plt.subplots(1, len(found), figsize=(3.6 * len(found), 3.8), squeeze=False)
    curves = {}
    for panel, name in zip(panels[0], found, strict=True):
        files = sorted(folder.glob(f"{name}*.json"))
        rows = [r for f in files for r in json.loads(f.read_text(encoding="utf-8"))["rows"]]
        for row in rows:
            states = sorted((p[0], p[2]) for run in row["curve"] for p in run["points"])
            front, best = [], 101.0
            for seconds, error in states:
                if error < best:
                    best = error
                    front.append((seconds, error))
            colour = COLOURS[row["program"].split(",")[0]]
            style = STYLES.get(row["program"], "o")
            curves[row["program"]], = panel.plot(
                *zip(*front), "-" + style, color=colour, markersize=3
            )
        for level in (5, 2, 1):
            panel.axhline(level, color="grey", linewidth=0.5)
        panel.set(xscale="log", yscale="log", title=SETUPS[name], xlabel="processor time [s]")
        panel.set(ylabel="error, L2 [%]", ylim=(0.1, 120))
    figure.legend(curves.values(), curves, loc="lower center", ncols=len(curves), fontsize=8)
    figure.tight_layout(rect=(0, 0.07, 1, 1))
    figure.savefig(sys.argv[2], dpi=80)


if __name__ == "__main__":
    main()
