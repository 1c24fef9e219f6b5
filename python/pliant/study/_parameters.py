# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Parameters: lists and ranges whose combinations are taken, and drawn numbers.

A drawn number is a function of the study's seed, the parameter's name and the sample's number: a
larger count keeps the samples before. In a Latin hypercube [McKay1979] each of `count` equal parts
of a parameter's range has one sample, so all of them depend on the count.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from pliant._error import Error
from pliant.study._keys import number_of, one_line, plain, uniform

_FORMS = (
    "a list, {files = GLOB}, {scans = GLOB}, {count = N}, {low, high, steps} or {low, high}, "
    "which is drawn"
)
_METHODS = ("random", "latin-hypercube")
MOST_ITEMS = 2_000_000  # a plan takes 17 µs and 0.5 kB of memory for each
_LARGEST = 1e300


def expected(field: str, text: str, found: object) -> Error:
    """The error of a field."""
    told = one_line(found, 60)
    return Error(f"{field}: expected {text}, found {told}", field=field, expected=text, found=told)


def known(field: str, given: Mapping[str, Any], names: tuple[str, ...]) -> None:
    """Refuses names that a table doesn't have."""
    for name in given:
        if name not in names:
            where = f"{field}.{one_line(name, 60)}"
            raise expected(where, f"one of {', '.join(names)}", "this name")


def whole(field: str, value: object, low: int, high: int | None = None) -> int:
    """A checked count."""
    if isinstance(value, bool) or not isinstance(value, int) or value < low:
        raise expected(field, f"a whole number from {low} upwards", value)
    if high is not None and value > high:
        raise expected(field, f"at most {high}", value)
    return value


class Span:
    """Numbers from low to high, evenly or by their logarithms."""

    def __init__(self, field: str, spec: Mapping[str, Any]) -> None:
        known(field, spec, ("low", "high", "steps", "scale", "whole"))
        self.low, self.high = (self._number(field, spec, name) for name in ("low", "high"))
        self.is_log = spec.get("scale", "linear") == "log"
        self.is_whole = bool(spec.get("whole", False))
        if spec.get("scale", "linear") not in ("linear", "log"):
            raise expected(f"{field}.scale", "linear or log", spec["scale"])
        if not self.low < self.high:
            raise expected(f"{field}.high", f"more than {self.low:g}", self.high)
        if self.is_log and not self.low > 0:
            raise expected(f"{field}.low", "above 0 for scale log", self.low)

    @staticmethod
    def _number(field: str, spec: Mapping[str, Any], name: str) -> float:
        value = spec.get(name)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise expected(f"{field}.{name}", "a number", value)
        if not abs(value) <= _LARGEST:
            raise expected(f"{field}.{name}", f"a number of at most {_LARGEST:g}", value)
        return float(value)

    def at(self, share: float) -> float | int:
        """The number at a share 0...1; rounded to 12 digits, which all machines agree on."""
        if self.is_whole and not self.is_log:
            found = self.low + math.floor(share * (self.high - self.low + 1))
            return int(min(found, self.high))
        low, high = (math.log(v) if self.is_log else v for v in (self.low, self.high))
        value = low + share * (high - low)
        value = float(f"{math.exp(value) if self.is_log else value:.12g}")
        return round(value) if self.is_whole else value


def _axis(
    field: str, spec: Any, files_of: Callable[[str, str, Any], list[Any]]
) -> list[Any] | Span:
    """The values of a parameter, or the span that it is drawn from."""
    if isinstance(spec, (list, tuple)):
        if not spec:
            raise expected(field, "a list with values", "an empty one")
        return [plain(v, field) for v in spec]
    if not isinstance(spec, Mapping):
        return [plain(spec, field)]
    for form in ("files", "scans"):
        if form in spec:
            known(field, spec, (form,))
            return files_of(field, form, spec[form])
    if "count" in spec:
        known(field, spec, ("count",))
        return list(range(whole(f"{field}.count", spec["count"], 1, MOST_ITEMS)))
    if not {"low", "high"} <= set(spec):
        raise expected(field, _FORMS, dict(spec))
    span = Span(field, spec)
    if "steps" not in spec:
        return span
    steps = whole(f"{field}.steps", spec["steps"], 2, MOST_ITEMS)
    return [span.at(n / (steps - 1)) for n in range(steps)]


def shares(seed: int, name: str, method: str, count: int) -> list[float]:
    """The samples of one parameter, in 0...1."""
    each = [uniform(seed, name, n) for n in range(count)]
    if method == "random":
        return each
    order = sorted(range(count), key=lambda n: number_of(seed, name, n, "part"))
    parts = [0] * count
    for part, n in enumerate(order):
        parts[n] = part
    return [(part + u) / count for part, u in zip(parts, each, strict=True)]


def combinations(
    tables: Sequence[Mapping[str, Any]],
    sample: Mapping[str, Any],
    seed: int,
    files_of: Callable[[str, str, Any], list[Any]],
) -> Iterator[dict[str, Any]]:
    """All items' parameters: every combination of the lists with every sample.

    Args:
        tables: Parameters, one table after the other.
        files_of: Finds the files of {files = …} and {scans = …}: (field, form, given).

    Raises:
        pliant.Error: A field is wrong, or there are too many items; before any is made.
    """
    known("sample", sample, ("method", "count"))
    method = sample.get("method", "random")
    if method not in _METHODS:
        raise expected("sample.method", " or ".join(_METHODS), method)
    all_axes = [
        {name: _axis(f"parameters.{name}", v, files_of) for name, v in table.items()}
        for table in tables
    ]
    counts = [_count(axes, sample) for axes in all_axes]
    if sum(counts) > MOST_ITEMS:
        raise expected(
            "parameters", f"at most {MOST_ITEMS} items; make several studies of them", sum(counts)
        )
    for axes in all_axes:
        yield from _products(axes, sample.get("count", 1), seed, method)


def _count(axes: Mapping[str, list[Any] | Span], sample: Mapping[str, Any]) -> int:
    """The number of a table's items."""
    drawn = [name for name, axis in axes.items() if isinstance(axis, Span)]
    if drawn and "count" not in sample:
        raise expected("sample.count", f"the number of samples of {', '.join(drawn)}", "none")
    if sample and not drawn:
        raise expected("sample", "parameters with {low, high}", "none")
    samples = whole("sample.count", sample["count"], 1, MOST_ITEMS) if drawn else 1
    return samples * math.prod(len(a) for a in axes.values() if not isinstance(a, Span))


def _products(
    axes: Mapping[str, list[Any] | Span], count: int, seed: int, method: str
) -> Iterator[dict[str, Any]]:
    lists = {name: axis for name, axis in axes.items() if not isinstance(axis, Span)}
    drawn = {
        name: [axis.at(u) for u in shares(seed, name, method, count)]
        for name, axis in axes.items()
        if isinstance(axis, Span)
    }
    for values in itertools.product(*lists.values()):
        for n in range(count):
            chosen = dict(zip(lists, values, strict=True))
            chosen.update({name: column[n] for name, column in drawn.items()})
            yield {name: chosen[name] for name in axes}
