# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Scans and random numbers of the tests."""

import random
import signal

import numpy
import pytest

import pliant


@pytest.fixture(scope="session", autouse=True)
def interruptions() -> None:
    """Python's own handler of Ctrl-C, which shells leave out for tests in the background."""
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def rng() -> numpy.random.Generator:
    """Random numbers; a failing test shows the seed."""
    seed = random.SystemRandom().randrange(2**32)
    print(f"seed {seed}")
    return numpy.random.default_rng(seed)


@pytest.fixture(scope="session")
def airway() -> pliant.Volume:
    return pliant.make_phantom("airway", (64, 64, 64))


def random_direction(rng: numpy.random.Generator) -> numpy.ndarray:
    """An oblique grid, right-handed or left-handed."""
    q, _ = numpy.linalg.qr(rng.normal(size=(3, 3)))
    return q
