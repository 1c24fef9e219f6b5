# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A page about a study, without other files: counts, plots, failures, machines."""

from __future__ import annotations

import collections
import html
import math
from collections.abc import Mapping, Sequence
from typing import Any

from pliant._core import version
from pliant.study._item import shown
from pliant.study._merge import manifests_of, results_of
from pliant.study._plan import Plan
from pliant.study._stores import open_store
from pliant.study._verify import failures

_WIDTH, _HEIGHT, _LEFT, _BOTTOM = 300, 190, 56, 34
_PARAMETERS, _RESULTS, _POINTS, _FAILURES = 6, 8, 2000, 200
_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em }
table { border-collapse: collapse; margin: .5em 0 } td, th { padding: .2em .7em; text-align: left }
tr + tr td { border-top: 1px solid #ddd } td.n { text-align: right } code { font-size: 90% }
svg { margin: 0 1em 1em 0 } svg text { font: 11px system-ui, sans-serif; fill: #444 }
summary { cursor: pointer } pre { font-size: 85%; overflow: auto }
"""


def _number(value: Any) -> float | None:
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return None
    return float(value)


def _short(value: float) -> str:
    return f"{value:.4g}"


def _scale(values: Sequence[float]) -> tuple[float, float, bool]:
    """Ends of an axis, and whether it is logarithmic."""
    low, high = min(values), max(values)
    if low > 0 and high / low > 50:
        return math.log10(low), math.log10(high), True
    if low == high:
        return low - 0.5, high + 0.5, False
    return low, high, False


def _axis(values: Sequence[float]) -> Any:
    low, high, is_log = _scale(values)
    span = high - low
    ends = [10**low, 10**high] if is_log else [low, high]
    return lambda v: ((math.log10(v) if is_log else v) - low) / span, ends, is_log


def scatter(x: Sequence[float], y: Sequence[float], x_name: str, y_name: str) -> str:
    """An SVG of points; axes are logarithmic where values span more than a factor of 50."""
    at_x, x_ends, is_x_log = _axis(x)
    at_y, y_ends, is_y_log = _axis(y)
    x_name, y_name = x_name[-40:] + " (log)" * is_x_log, y_name[-40:] + " (log)" * is_y_log
    wide, high = _WIDTH - _LEFT - 8, _HEIGHT - _BOTTOM - 20
    points = "".join(
        f'<circle cx="{_LEFT + wide * at_x(a):.1f}" cy="{20 + high * (1 - at_y(b)):.1f}" r="2.2"/>'
        for a, b in zip(x, y, strict=True)
    )
    bottom = 20 + high
    return (
        f'<svg width="{_WIDTH}" height="{_HEIGHT}" role="img" '
        f'aria-label="{html.escape(y_name)} against {html.escape(x_name)}">'
        f'<path d="M{_LEFT} 20V{bottom}H{_WIDTH - 8}" fill="none" stroke="#999"/>'
        f'<g fill="#1a6fb0" fill-opacity=".55">{points}</g>'
        f'<text x="4" y="12">{html.escape(y_name)}</text>'
        f'<text x="{_LEFT - 4}" y="28" text-anchor="end">{_short(y_ends[1])}</text>'
        f'<text x="{_LEFT - 4}" y="{bottom}" text-anchor="end">{_short(y_ends[0])}</text>'
        f'<text x="{_LEFT}" y="{bottom + 14}">{_short(x_ends[0])}</text>'
        f'<text x="{_WIDTH - 8}" y="{bottom + 14}" text-anchor="end">{_short(x_ends[1])}</text>'
        f'<text x="{(_LEFT + _WIDTH) / 2}" y="{_HEIGHT - 4}" text-anchor="middle">'
        f"{html.escape(x_name)}</text></svg>"
    )


def _columns(rows: list[dict[str, Any]]) -> dict[str, list[float | None]]:
    """Columns with different numbers."""
    names = dict.fromkeys(name for row in rows for name in row)
    found = {}
    for name in names:
        column = [_number(row.get(name)) for row in rows]
        if len({v for v in column if v is not None and math.isfinite(v)}) > 1:
            found[name] = column
    return found


def _plots(parameters: list[dict[str, Any]], results: list[dict[str, Any]]) -> str:
    step = max(1, len(results) // _POINTS)
    x_columns, y_columns = _columns(parameters[::step]), _columns(results[::step])
    if not x_columns:
        x_columns = {"item": [float(n) for n in range(0, len(results), step)]}
    drawn = []
    for y_name, ys in list(y_columns.items())[:_RESULTS]:
        for x_name, xs in list(x_columns.items())[:_PARAMETERS]:
            both = [(a, b) for a, b in zip(xs, ys, strict=True) if a is not None and b is not None]
            if len(both) > 1:
                x, y = zip(*both, strict=True)
                drawn.append(scatter(x, y, x_name, y_name))
    more = ""
    if len(y_columns) > _RESULTS or len(x_columns) > _PARAMETERS:
        more = (
            f"<p>The first {min(_PARAMETERS, len(x_columns))} of {len(x_columns)} parameters and "
            f"{min(_RESULTS, len(y_columns))} of {len(y_columns)} results; [keep] results chooses "
            "others.</p>"
        )
    return "".join(drawn) + more or "<p>No numbers that differ.</p>"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f"<th>{html.escape(h)}</th>" for h in head)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f"<table><tr>{top}</tr>{body}</table>"


def _given(parameters: dict[str, Any]) -> str:
    return html.escape(", ".join(f"{name} = {shown(v)}" for name, v in parameters.items()))


def _failures(plan: Plan, failed: dict[str, dict[str, Any]]) -> str:
    rows = list[list[str]]()
    for item in plan.items:
        if item.id in failed and len(rows) < _FAILURES:
            record = failed[item.id]
            error = html.escape(str(record.get("error", "")))
            trace = html.escape(str(record.get("trace", "")))
            if trace:
                error = f"<details><summary>{error}</summary><pre>{trace}</pre></details>"
            where = f"{record.get('host', '')} {record.get('pid', '')}"
            rows.append([f"<code>{item.id}</code>", _given(item.parameters), error, where])
    if not rows:
        return "<p>None.</p>"
    more = len(failed) - len(rows)
    rest = f"<p>And {more} more; log/ has all.</p>" if more > 0 else ""
    return _table(("item", "parameters", "error", "host, process"), rows) + rest


def _hosts(manifests: list[dict[str, Any]]) -> str:
    seconds: dict[str, list[float]] = collections.defaultdict(list)
    for manifest in manifests:
        seconds[manifest["made"]["host"]].append(manifest["made"]["seconds"])
    rows = [
        [html.escape(host), str(len(s)), f"{sum(s):.1f}", _short(sum(s) / len(s)), _short(max(s))]
        for host, s in sorted(seconds.items())
    ]
    return _table(("host", "items", "seconds", "mean", "longest"), rows)


def report_study(plan: Plan, out: str) -> str:
    """Writes the page: Study.report."""
    store = open_store(out)
    found, damaged = manifests_of(plan, store)
    there = {item.id for item, _ in found} | set(damaged)
    failed = {k: v for k, v in failures(store).items() if k not in there}
    failed = {item.id: failed[item.id] for item in plan.items if item.id in failed}
    left = len(plan.items) - len(there) - len(failed)
    given = [pair for table in plan.parameters for pair in table.items()]
    counts = {n for n, v in given if isinstance(v, Mapping) and "count" in v}
    parameters = [
        {n: shown(v) for n, v in item.parameters.items() if n not in counts} for item, _ in found
    ]
    results = [results_of(plan, manifest) for _, manifest in found]
    title = html.escape(f"Study {plan.name}")
    more = f", {len(damaged)} damaged" if damaged else ""
    page = (
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title>'
        f'<meta name="viewport" content="width=device-width"><style>{_STYLE}</style>'
        f"<h1>{title}</h1><p>{len(plan.items)} items: {len(found)} done, {len(failed)} failed, "
        f"{left} left{more}. Seed {plan.seed}, {html.escape(plan.run_table['what'])}, "
        f"Pliant {version}.</p><h2>Results</h2>{_plots(parameters, results)}"
        f"<h2>Failures</h2>{_failures(plan, failed)}"
        f"<h2>Machines</h2>{_hosts([manifest for _, manifest in found])}"
    )
    store.write({"report.html": page.encode(errors="replace")})
    return store.path("report.html")
