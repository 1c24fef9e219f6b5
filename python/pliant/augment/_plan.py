# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Plans: motions of tissue as plain numbers."""

import functools
import json
import os
import pathlib
from dataclasses import dataclass
from typing import Any

from pliant._error import Error, expected_error

VERSION = 1
MODELS = ("chainmail", "elastic")  # of tissue

_FIELDS = {
    "push": {"point_mm": 3, "by_mm": 3, "radius_mm": 0},
    "pull": {"point_mm": 3, "by_mm": 3, "radius_mm": 0},
    "slide": {"point_mm": 3, "by_mm": 3, "radius_mm": 0},
    "swelling": {"point_mm": 3, "by_mm": 0, "radius_mm": 0},
    "breath": {"point_mm": 3, "by_mm": 3, "above_mm": 0, "below_mm": 0, "depth_mm": 0},
    "wave": {"by_mm": 3, "vector_per_mm": 3, "phase": 0},
}


_expected = functools.partial(expected_error, about="plan")


def _number(field: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise _expected(field, "a number", value)
    return float(value)


def _checked(motion: object) -> dict[str, Any]:
    if not isinstance(motion, dict):
        raise _expected("motions", "objects", motion)
    kind = motion.get("kind")
    if kind not in _FIELDS:
        raise _expected("kind", ", ".join(_FIELDS), kind)
    checked: dict[str, Any] = {"kind": kind}
    for name, count in _FIELDS[kind].items():
        value = motion.get(name)
        if count == 0:
            checked[name] = _number(name, value)
        elif isinstance(value, (list, tuple)) and len(value) == count:
            checked[name] = [_number(name, v) for v in value]
        else:
            raise _expected(name, f"{count} numbers", value)
    unknown = set(motion) - set(checked)
    if unknown:
        raise _expected("motions", f"{', '.join(checked)} of a {kind}", ", ".join(sorted(unknown)))
    return checked


@dataclass(frozen=True)
class Plan:
    """Motions of one sample, which give the same result on the same scan.

    Attributes:
        motions: Dictionaries with the kind of a motion ("push", "pull", "slide", "swelling",
            "breath", "wave") and its numbers [mm, LPS].
        tissue: Settings of the tissue: pliant.settings_of("chainmail") or "elastic_scan".
        model: Of the tissue: "chainmail" or "elastic".
    """

    motions: tuple[dict[str, Any], ...]
    tissue: dict[str, Any]
    model: str = "chainmail"

    def to_dict(self) -> dict[str, Any]:
        """Numbers, texts, lists and dictionaries."""
        return {
            "pliant_plan": VERSION,
            "model": self.model,
            "tissue": dict(self.tissue),
            "motions": [dict(motion) for motion in self.motions],
        }

    @staticmethod
    def from_dict(data: Any) -> "Plan":
        """The plan of to_dict(), checked."""
        if not isinstance(data, dict) or "pliant_plan" not in data:
            raise _expected("pliant_plan", f"a plan of version {VERSION}", "none")
        if data["pliant_plan"] != VERSION:
            raise Error(
                f"plan: pliant_plan: expected version {VERSION}, found {data['pliant_plan']}",
                code="unsupported",
                field="pliant_plan",
                expected=str(VERSION),
                found=str(data["pliant_plan"]),
            )
        tissue, motions = data.get("tissue"), data.get("motions")
        model = data.get("model", "chainmail")
        if model not in MODELS:
            raise _expected("model", " or ".join(MODELS), model)
        if not isinstance(tissue, dict):
            raise _expected("tissue", "settings", tissue)
        if not isinstance(motions, (list, tuple)):
            raise _expected("motions", "a list", motions)
        return Plan(tuple(_checked(motion) for motion in motions), dict(tissue), model)

    def to_json(self) -> str:
        """One line of JSON."""
        return json.dumps(self.to_dict())

    @staticmethod
    def from_json(text: str) -> "Plan":
        """The plan of to_json()."""
        try:
            data = json.loads(text)
        except (ValueError, TypeError, RecursionError) as error:
            raise Error(f"plan: expected JSON, {error}", code="unreadable") from None
        return Plan.from_dict(data)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes a JSON file."""
        pathlib.Path(path).write_text(self.to_json() + "\n", encoding="utf-8")

    @staticmethod
    def load(path: str | os.PathLike[str]) -> "Plan":
        """Reads a JSON file."""
        try:
            text = pathlib.Path(path).read_text(encoding="utf-8")
        except OSError as error:
            raise Error(f"{path}: {error.strerror}", code="not_found") from None
        except UnicodeDecodeError:
            raise Error(f"{path}: expected a plan in JSON, found no text", "unreadable") from None
        return Plan.from_json(text)
