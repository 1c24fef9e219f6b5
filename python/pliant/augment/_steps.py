# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Makes the motions of a plan, one after the other."""

from __future__ import annotations

from typing import Any

from pliant._core import PreparedScan
from pliant.augment._plan import Plan


def _status(fraction: float) -> str:
    return "applied" if fraction == 1 else "limited" if fraction > 0 else "rejected"


def _step(status: str, limited_by: str, fraction: float, moved: int | None) -> dict[str, Any]:
    return {
        "status": status,
        "limited_by": limited_by,
        "fraction": fraction,
        "moved_voxels": moved,
    }


def _follow(prepared: PreparedScan, plan: Plan) -> dict[str, Any]:
    """Makes the swellings, breaths and waves, which come first, as one motion."""
    swellings = [
        (m["point_mm"], m["by_mm"], m["radius_mm"]) for m in plan.motions if m["kind"] == "swelling"
    ]
    breaths = [
        (m["point_mm"], m["by_mm"], m["above_mm"], m["below_mm"], m["depth_mm"])
        for m in plan.motions
        if m["kind"] == "breath"
    ]
    waves = [
        (m["by_mm"], m["vector_per_mm"], m["phase"]) for m in plan.motions if m["kind"] == "wave"
    ]
    if not swellings and not breaths and not waves:
        return {}
    followed = prepared.follow(swellings, breaths, waves)
    done = followed.fraction
    by = "none" if done == 1 else "fold"
    return _step(_status(done), by, done, followed.moved_elements)


def _made(prepared: PreparedScan, motion: dict[str, Any]) -> dict[str, Any]:
    point, by, radius = motion["point_mm"], motion["by_mm"], motion["radius_mm"]
    if motion["kind"] == "slide":
        slid = prepared.slide(point, by, radius)
        return _step(_status(slid.way_fraction), slid.limited_by, slid.way_fraction, None)
    pushed = prepared.push(point, by, radius)
    return _step(pushed.status, pushed.limited_by, pushed.step_fraction, pushed.moved_elements)


def reduced(step: dict[str, Any], part: float) -> dict[str, Any]:
    """A step of which a part is left, since more would fold."""
    if part == 1:
        return step
    return {**step, **_step("limited", "fold", part * step["fraction"], step["moved_voxels"])}


def report_of(prepared: PreparedScan, plan: Plan) -> list[dict[str, Any]]:
    """Moves a scan at rest; returns a step for each motion."""
    followed = _follow(prepared, plan)
    steps = [
        followed if motion["kind"] in ("swelling", "breath", "wave") else _made(prepared, motion)
        for motion in plan.motions
    ]
    return [
        {"kind": motion["kind"], **step} for motion, step in zip(plan.motions, steps, strict=True)
    ]
