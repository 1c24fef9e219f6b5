# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Material passports: as the program prints them, and as settings of a body."""

import json
import subprocess

import numpy as np
import pytest

import pliant


def test_they_are_those_of_the_program():
    printed = subprocess.run(
        [pliant.program(), "materials", "--json"], check=True, capture_output=True, text=True
    ).stdout
    assert pliant.materials() == json.loads(printed)


def test_the_curve_and_its_error():
    cortex = {material["name"]: material for material in pliant.materials()}["cortex"]
    load = np.array(cortex["load"])
    strain, stress = np.array(cortex["strain"]), np.array(cortex["stress_kpa"])
    ratio = -stress[load == "compression"][-1] / stress[load == "tension"][-1]
    assert ratio == pytest.approx(2.77, abs=0.01)
    # The law of an incompressible body: shear µ γ, else µ (s − 1/s²).
    s = 1 + strain
    unit = np.where(load == "shear", strain, s - 1 / s**2) / 3
    modulus = unit @ stress / (unit @ unit)
    error = 100 * np.linalg.norm(modulus * unit - stress) / np.linalg.norm(stress)
    assert cortex["fitted_young_modulus_kpa"] == pytest.approx(modulus, rel=0.01)
    assert cortex["fitted_error_percent"] == pytest.approx(error, rel=0.01)


def test_ogdens_law_shows_the_asymmetry_of_brain():
    cortex = {material["name"]: material for material in pliant.materials()}["cortex"]
    load, strain = np.array(cortex["load"]), np.array(cortex["strain"])
    law, stress = np.array(cortex["ogden_stress_kpa"]), np.array(cortex["stress_kpa"])
    error = 100 * np.linalg.norm(law - stress) / np.linalg.norm(stress)
    assert cortex["ogden_error_percent"] == pytest.approx(error)
    assert error < 8
    # The law of an incompressible body, 2 µ/α (s^(α − 1) − s^(−α/2 − 1)).
    mu, alpha = cortex["ogden_young_modulus_kpa"] / 3, cortex["ogden_alpha"]
    s = 1 + strain[load != "shear"]
    closed = 2 * mu / alpha * (s ** (alpha - 1) - s ** (-alpha / 2 - 1))
    assert law[load != "shear"] == pytest.approx(closed, rel=0.03)
