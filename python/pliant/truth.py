# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Registration truth: pairs of scans whose deformation is known, and scores of registrations.

Example:
    >>> from pliant import truth
    >>> case = truth.make_case(scan, seed=7, kinds="slide,breathing")
    >>> transform = my_registration(fixed=scan, moving=case.moving)
    >>> truth.score(case, transform)["moved"]["mean_mm"]
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy
import numpy.typing

from pliant._core import (
    Field,
    TruthCase,
    TruthMaker,
    Volume,
    score_truth_field,
    score_truth_points,
    settings_of,
)
from pliant._error import Error

if TYPE_CHECKING:
    from typing import Unpack

    from pliant._settings import TruthSettings

__all__ = [
    "ROWS",
    "TruthCase",
    "TruthMaker",
    "make_case",
    "over_cases",
    "score",
    "table",
    "truth_settings",
]

ROWS = ("moved", "interior", "wall", "interface", "cut", "still", "bone", "landmarks")
"""Types of points in scores, in the order of tables."""


def make_case(
    scan: Volume,
    seed: int = 1,
    *,
    threads: int = 0,
    materials: Mapping[str, Any] | None = None,
    model: str = "chainmail",
    **settings: Unpack[TruthSettings],
) -> TruthCase:
    """Makes one case; a TruthMaker makes several of a scan faster.

    Args:
        scan: The fixed image.
        seed: The case is made of the scan and this number alone.
        threads: 0: one for each core.
        materials: Settings of the tissue, as of make_chainmail or make_elastic.
        model: "chainmail", or "elastic": equilibrium after each motion, and no cuts.
        settings: As of TruthMaker: kinds, motions, contact_mm, ...
    """
    return TruthMaker(scan, threads, dict(materials or {}), model, **settings).make(seed)


def truth_settings() -> list[dict[str, Any]]:
    """Settings of a TruthMaker: name, default, unit, range and text."""
    return settings_of("truth")


def _grid_of(case: TruthCase) -> dict[str, Any]:
    forward = case.forward
    return {
        "spacing_mm": forward.spacing_mm,
        "origin_mm": forward.origin_mm,
        "direction": numpy.array(forward.direction),
    }


def _field_of_transform(case: TruthCase, transform: Any) -> Field:
    sitk: Any = importlib.import_module("SimpleITK")

    forward = case.forward
    image = sitk.TransformToDisplacementField(
        transform,
        sitk.sitkVectorFloat64,
        list(forward.size),
        list(forward.origin_mm),
        list(forward.spacing_mm),
        numpy.ravel(forward.direction).tolist(),
    )
    return Field(sitk.GetArrayViewFromImage(image), **_grid_of(case))


def score(case: TruthCase, registration: Any, *, threads: int = 0) -> dict[str, Any]:
    """Scores a registration of case.moving to the scan.

    Args:
        case: The truth.
        registration: What maps points of the fixed image to the moving one: a SimpleITK
            transform; a SimpleITK image of vectors or a Field; an array (k, j, i, 3) of
            displacements [mm, LPS] on the scan's grid; an array (n, 3) of the landmarks'
            positions in the moving image; or None, for no registration.

    Returns:
        For each type of ROWS that has points: count, mean_mm, median_mm, p95_mm and max_mm. For
        fields also folded_share and folded_voxels: tissue where the found map is folded.
    """
    if registration is None or isinstance(registration, Field):
        return score_truth_field(case, registration, threads)
    if hasattr(registration, "TransformPoint"):
        found = score_truth_field(case, _field_of_transform(case, registration), threads)
        if len(case.landmarks_fixed_mm):
            moved = [registration.TransformPoint(p.tolist()) for p in case.landmarks_fixed_mm]
            found.update(score_truth_points(case, numpy.array(moved)))
        return found
    if hasattr(registration, "GetNumberOfComponentsPerPixel"):
        sitk: Any = importlib.import_module("SimpleITK")

        field = Field(
            sitk.GetArrayViewFromImage(registration),
            registration.GetSpacing(),
            registration.GetOrigin(),
            registration.GetDirection(),
        )
        return score_truth_field(case, field, threads)
    array = numpy.asarray(registration)
    if array.ndim == 2:
        return score_truth_points(case, array)
    if array.shape != case.forward.array.shape:
        raise Error(
            f"registration: expected axes {case.forward.array.shape} or (n, 3), "
            f"found {array.shape}",
            field="registration",
        )
    return score_truth_field(case, Field(array, **_grid_of(case)), threads)


def over_cases(scores: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Joins the scores of several cases as `pliant truth score` does.

    Returns:
        For each type: the sum of the counts, means of mean, median and 95th percentile over the
        cases that have such points, and the largest maximum; the mean of folded_share.
    """
    joined: dict[str, Any] = {}
    for row in ROWS:
        some = [one[row] for one in scores if row in one]
        if not some:
            continue
        joined[row] = {"count": sum(one["count"] for one in some)}
        for name in ("mean_mm", "median_mm", "p95_mm"):
            joined[row][name] = float(numpy.mean([one[name] for one in some]))
        joined[row]["max_mm"] = max(one["max_mm"] for one in some)
    if scores and all("folded_share" in one for one in scores):
        joined["folded_share"] = float(numpy.mean([one["folded_share"] for one in scores]))
    return joined


def table(methods: Mapping[str, Sequence[Mapping[str, Any]]]) -> str:
    """A table in Markdown, over the cases.

    Args:
        methods: The scores of each method, one for each case.
    """
    lines = [
        "| method | type | points | mean | median | 95 % | max [mm] | folded |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for method, scores in methods.items():
        joined = over_cases(scores)
        folded = joined.get("folded_share")
        last = "" if folded is None else f"{100 * folded:.3f} %"
        name = method.replace("|", "\\|")
        for row in ROWS:
            if row not in joined:
                continue
            e = joined[row]
            lines.append(
                f"| {name} | {row} | {e['count']} | {e['mean_mm']:.3f} | {e['median_mm']:.3f} | "
                f"{e['p95_mm']:.3f} | {e['max_mm']:.3f} | {last} |"
            )
            name = last = ""
    return "\n".join(lines) + "\n"
