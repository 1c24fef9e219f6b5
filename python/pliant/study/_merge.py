# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""One table of a study's results. The same results are the same bytes, in any order of runs."""

from __future__ import annotations

import csv
import dataclasses
import fnmatch
import io
import warnings
from collections.abc import Iterator, Mapping
from typing import Any

from pliant.study._item import Item, shown
from pliant.study._keys import canonical, digest
from pliant.study._manifest import Manifest
from pliant.study._plan import Plan
from pliant.study._store import Store
from pliant.study._stores import open_store
from pliant.study._verify import examine, log_damage


def flat(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """The numbers and texts of a tree, with names as "values.links"."""
    if isinstance(value, Mapping):
        for key, v in value.items():
            yield from flat(v, f"{name}.{key}" if name else key)
    elif isinstance(value, list):
        for n, v in enumerate(value):
            yield from flat(v, f"{name}.{n}")
    elif value is not None:
        yield name, value


def manifests_of(
    plan: Plan, store: Store, *, is_full: bool = False
) -> tuple[list[tuple[Item, Manifest]], dict[str, str]]:
    """The items that are done, sorted by id, with their manifests; and the damage, by id."""
    there = store.items()
    items = sorted((item for item in plan.items if item.id in there), key=lambda item: item.id)
    found, damaged = list[tuple[Item, Manifest]](), dict[str, str]()
    for seen in examine(store, items, is_full=is_full):
        if seen.manifest is None:
            damaged[seen.item.id] = seen.damage
        else:
            found.append((seen.item, seen.manifest))
    return found, damaged


def results_of(plan: Plan, manifest: Mapping[str, Any]) -> dict[str, Any]:
    """The columns of an item's results."""
    patterns = plan.keep["results"]
    return {
        name: value
        for name, value in flat(manifest["results"])
        if patterns is None or any(fnmatch.fnmatchcase(name, p) for p in patterns)
    }


def _row(plan: Plan, item: Item, manifest: Mapping[str, Any]) -> dict[str, Any]:
    row: dict[str, Any] = {"id": item.id, "seed": item.seed}
    row.update({name: shown(value) for name, value in item.parameters.items()})
    for name, value in results_of(plan, manifest).items():
        row[f"result.{name}" if name in row else name] = value
    return {**row, "hash": manifest["hash"]}


def rows_of(plan: Plan, out: str) -> list[dict[str, Any]]:
    """A row for each item that is done: Study.table."""
    found, damaged = manifests_of(plan, open_store(out))
    warn_of(damaged)
    return [_row(plan, *one) for one in found]


def warn_of(damaged: dict[str, str]) -> None:
    """Warns of damaged items, which a table lacks."""
    for item, damage in list(damaged.items())[:1]:
        line = f"{len(damaged)} damaged items are left out, run() repeats them; {item}: {damage}"
        warnings.warn(line, stacklevel=4)


def columns_of(plan: Plan, rows: list[dict[str, Any]]) -> list[str]:
    """Columns of a table: parameters in the study's order, results by their names."""
    first = ["id", "seed", *(plan.items[0].parameters if plan.items else ())]
    rest = sorted({name for row in rows for name in row} - {*first, "hash"})
    return [*first, *rest, "hash"]


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, dict)):
        return canonical(value).decode()
    return repr(value) if isinstance(value, float) else str(value)


@dataclasses.dataclass(frozen=True)
class Merged:
    """A table: the hash of its bytes and its manifest's, its path, its rows, damaged items."""

    hash: str
    path: str
    count: int
    damaged: dict[str, str]


def merge_study(plan: Plan, out: str) -> Merged:
    """Reads all results, and writes the table and the manifest: Study.merge."""
    store = open_store(out)
    found, damaged = manifests_of(plan, store, is_full=True)
    log_damage(store, damaged)
    rows = [_row(plan, *one) for one in found]
    columns = columns_of(plan, rows)
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([_cell(row[c]) if c in row else "" for c in columns] for row in rows)
    table = text.getvalue().encode()
    items = {
        item.id: {key: manifest[key] for key in ("hash", "version", "files")}
        for item, manifest in found
    }
    manifest = canonical(
        {"study": plan.name, "planned": len(plan.items), "table": digest(table), "items": items}
    )
    store.write({"merged/table.csv": table, "merged/manifest.json": manifest + b"\n"})
    where = store.path("merged/table.csv")
    return Merged(digest(table + manifest), where, len(rows), damaged)
