# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""One table of a study's results. The same results are the same bytes, in any order of runs."""

from __future__ import annotations

import concurrent.futures
import csv
import fnmatch
import io
from collections.abc import Iterator, Mapping
from typing import Any

from pliant.study._item import Item, shown
from pliant.study._keys import canonical, digest
from pliant.study._plan import Plan
from pliant.study._store import Store
from pliant.study._stores import open_store

_READERS = 16  # files that are read at a time: stores may be far away


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


def manifests_of(plan: Plan, store: Store) -> list[tuple[Item, dict[str, Any]]]:
    """The items that are done, sorted by id, with their manifests."""
    there = store.items()
    done = sorted((item for item in plan.items if item.id in there), key=lambda item: item.id)
    with concurrent.futures.ThreadPoolExecutor(_READERS) as readers:
        return list(zip(done, readers.map(lambda i: store.manifest(i.id), done), strict=True))


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
    return [_row(plan, *found) for found in manifests_of(plan, open_store(out))]


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


def merge_study(plan: Plan, out: str) -> str:
    """Writes the table and the manifest: Study.merge."""
    store = open_store(out)
    found = manifests_of(plan, store)
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
    store.write("merged/table.csv", table)
    store.write("merged/manifest.json", manifest + b"\n")
    return digest(table + manifest)
