# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Measured curves of the material passports beside the laws that were fitted to them.

One column for each material with a curve: tension and compression above, shear below; points are
measured, lines are the best neo-Hookean law and Ogden's. The values are those of the program.

    pip install matplotlib      # 3.10.0
    python plot_laws.py build/release/pliant docs/results/materials/laws.png
"""

import json
import subprocess
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

LAWS = (
    ("fitted", "neo-Hookean, {fitted_young_modulus_kpa:.2f} kPa", "#c1440e", "--"),
    ("ogden", "Ogden, {ogden_young_modulus_kpa:.2f} kPa, α {ogden_alpha:.1f}", "#1f5aa6", "-"),
)


def points(material, loads, key):
    """Strains and stresses of some load cases, in the order of the strains, with the origin."""
    rows = zip(material["load"], material["strain"], material[key])
    return zip(*sorted([(0.0, 0.0)] + [(x, y) for load, x, y in rows if load in loads]))


def plot(axis, material, loads):
    axis.axhline(0, color="0.8", linewidth=0.6)
    axis.axvline(0, color="0.8", linewidth=0.6)
    axis.plot(*points(material, loads, "stress_kpa"), "o", color="0.25", markersize=3)
    for key, label, colour, style in LAWS:
        error = material[f"{key}_error_percent"]
        axis.plot(
            *points(material, loads, f"{key}_stress_kpa"),
            style,
            color=colour,
            linewidth=1.4,
            label=f"{label.format(**material)}: {error:.0f} % RMS",
        )
    axis.locator_params(axis="x", nbins=5)
    axis.tick_params(labelsize=7)


def main(program, picture):
    printed = subprocess.run([program, "materials", "--json"], check=True, capture_output=True)
    materials = [m for m in json.loads(printed.stdout) if m["load"]]
    figure, axes = plt.subplots(2, len(materials), figsize=(3.6 * len(materials), 5.4))
    for column, material in zip(axes.T, materials):
        plot(column[0], material, ("tension", "compression"))
        plot(column[1], material, ("shear",))
        column[0].set_title(material["name"], fontsize=9)
        column[0].set_xlabel("strain, compression to tension", fontsize=8)
        column[1].set_xlabel("shear", fontsize=8)
        column[0].legend(fontsize=6.5, loc="lower right", frameon=False)
    for axis in axes[:, 0]:
        axis.set_ylabel("nominal stress [kPa]", fontsize=8)
    figure.tight_layout()
    figure.savefig(picture, dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main(*sys.argv[1:])
