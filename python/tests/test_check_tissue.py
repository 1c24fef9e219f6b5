# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""check_tissue() accepts tissues that keep the rules, and names a broken rule."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import pytest

import pliant
from jelly import Jelly

CARINA, AHEAD = (-0.2, -1.0, -5.0), (4.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def scan() -> pliant.Volume:
    return pliant.make_phantom("airway", (48, 48, 48))


def test_accepts_tissues_of_the_library_and_of_one_s_own(scan: pliant.Volume) -> None:
    pliant.check_tissue(lambda: Jelly(scan), CARINA, AHEAD)
    threads = iter(range(1, 1000))
    pliant.check_tissue(
        lambda: pliant.make_chainmail(scan, threads=1 + next(threads) % 3),
        CARINA,
        AHEAD,
        sphere_radius_mm=3,
    )


@pytest.mark.xfail(
    strict=True, reason="a push by zero steps the network: rounding moves its nodes by 1e-14 mm"
)
def test_accepts_springs(scan: pliant.Volume) -> None:
    pliant.check_tissue(lambda: pliant.make_springs(scan, threads=1, cell_mm=6), CARINA, AHEAD)


class Forgetful(Jelly):
    def state(self) -> Sequence[float]:
        return [*self.centre, 0.0, 0.0, 0.0]


class Slipping(Jelly):
    def sweep(self) -> bool:
        self.move(self.centre, 0.9 * self.shift)
        return False


class Careless(Jelly):
    def push(self, point_mm: Any, push_mm: Any, *rest: Any) -> pliant.PushReport:
        self.move(self.centre, [1.0, 0.0, 0.0])
        return super().push(point_mm, push_mm, *rest)


class Lying(Jelly):
    def push(self, *arguments: Any) -> pliant.PushReport:
        super().push(*arguments)
        return pliant.PushReport("rejected", step_fraction=0.0)


@pytest.mark.parametrize(
    ("kind", "rule"),
    [(Forgetful, "undo"), (Slipping, "hold"), (Careless, "refused"), (Lying, "push")],
)
def test_names_the_broken_rule(
    scan: pliant.Volume, kind: Callable[[pliant.Volume], pliant.Tissue], rule: str
) -> None:
    with pytest.raises(pliant.Error, match=f"{rule}: expected .*, found ") as raised:
        pliant.check_tissue(lambda: kind(scan), CARINA, AHEAD)
    assert raised.value.field == rule


def test_names_a_maker_that_fails(scan: pliant.Volume) -> None:
    with pytest.raises(pliant.Error, match="make: expected .* to succeed, found .*IndexError"):
        pliant.check_tissue(lambda: [][7], CARINA, AHEAD)
    with pytest.raises(pliant.Error, match="expected a Tissue, found .*Volume"):
        pliant.check_tissue(lambda: scan, CARINA, AHEAD)  # type: ignore[arg-type, return-value]
