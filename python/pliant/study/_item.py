# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""An item of a study: its id, its parameters, and the arguments that they make."""

from __future__ import annotations

import copy
import dataclasses
import re
from collections.abc import Mapping
from typing import Any

from pliant.study._inputs import Input

_NAME = re.compile(r"\{([A-Za-z_][\w.-]*)\}")
_NO_ARGUMENTS = ("what", "version", "repeats")


@dataclasses.dataclass(frozen=True)
class Item:
    """One piece of work.

    Attributes:
        id: 32 hexadecimal digits.
        seed: 63 bits, for random numbers.
        parameters: Values by name; files are Input.
    """

    id: str
    seed: int
    parameters: dict[str, Any]


def key_of(value: Any) -> Any:
    """A value as it counts in an id: files by their contents alone."""
    if isinstance(value, Input):
        return {"content": value.hash}
    if isinstance(value, Mapping):
        return {name: key_of(v) for name, v in value.items()}
    if isinstance(value, list):
        return [key_of(v) for v in value]
    return value


def shown(value: Any) -> Any:
    """A value as tables show it: files by their names."""
    return value.name if isinstance(value, Input) else value


def _text(value: Any) -> str:
    return repr(value) if isinstance(value, float) else str(value)


def names_in(value: Any) -> set[str]:
    """Names in braces in the texts of [run]."""
    if isinstance(value, str):
        return set(_NAME.findall(value))
    if isinstance(value, Mapping):
        return set().union(*(names_in(v) for v in value.values()))
    if isinstance(value, list):
        return set().union(*(names_in(v) for v in value))
    return set()


def _filled(value: Any, parameters: Mapping[str, Any]) -> Any:
    if isinstance(value, str):
        return _NAME.sub(
            lambda m: _text(parameters[m[1]]) if m[1] in parameters else m[0], value
        )
    if isinstance(value, Mapping):
        return {name: _filled(v, parameters) for name, v in value.items()}
    if isinstance(value, list):
        return [_filled(v, parameters) for v in value]
    return value


def arguments_of(run: Mapping[str, Any], parameters: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of an item: [run] with the parameters filled in or added.

    A parameter that [run] has in braces is filled in there. Another one is an argument of its name;
    "config.material.offset" is one in a table. {count = N} repeats an item, and is an argument of
    functions alone.
    """
    found = {k: v for k, v in run.items() if k not in _NO_ARGUMENTS}
    used = names_in(found)
    found = copy.deepcopy(_filled(found, parameters))
    for name, value in parameters.items():
        if name in used or name in run["repeats"]:
            continue
        *tables, last = name.split(".")
        table = found
        for part in tables:
            table = table.setdefault(part, {})
        table[last] = value
    return found
