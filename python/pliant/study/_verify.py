# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Which items have a result that is whole, by their manifests and files.

Manifests are always checked, sizes of files too where that is cheap, and bytes of files that were
written after their manifest. The other bytes are read by verify and merge. What they find is a line
of the log, so that the next run reads those items' bytes as well.
"""

from __future__ import annotations

import concurrent.futures
import contextlib
import dataclasses
import os
import socket
import time
from collections.abc import Collection, Iterator, Sequence

from pliant._core import version
from pliant.study._item import Item
from pliant.study._keys import canonical
from pliant.study._manifest import Damaged, Manifest
from pliant.study._plan import Plan
from pliant.study._store import Record, Store
from pliant.study._stores import open_store

_READERS = 16  # items that are read at a time: stores may be far away
_MOST_PER_CALL, _BATCH = 20, 100


@dataclasses.dataclass(frozen=True)
class Status:
    """Which items are done.

    Attributes:
        done, left: Items with a result, and without an attempt that failed.
        failed: The last log line of items without a result, by id.
        others: Number of results that belong to no item of the study as it is now.
        damaged: What is wrong with items whose files are not those that were written, by id.
        strays: Entries that are no part of the results, and ignored: names, and unreadable lines.
    """

    done: list[Item]
    left: list[Item]
    failed: dict[str, Record]
    others: int
    damaged: dict[str, str] = dataclasses.field(default_factory=dict)
    strays: list[str] = dataclasses.field(default_factory=list)


@dataclasses.dataclass(frozen=True)
class Seen:
    """An item that is there: its manifest, or its damage, and further names in its folder."""

    item: Item
    manifest: Manifest | None
    damage: str = ""
    strays: tuple[str, ...] = ()


def examine(
    store: Store, items: Sequence[Item], *, is_full: bool, doubted: Collection[str] = ()
) -> Iterator[Seen]:
    """Checks items that are there, in their order.

    Args:
        is_full: Reads all bytes.
        doubted: Ids of items whose bytes are read in any case.
    """

    def see(item: Item) -> Seen:
        try:
            manifest = store.manifest(item.id)
            strays = store.check_files(item.id, manifest, is_full=is_full or item.id in doubted)
            return Seen(item, manifest, "", tuple(strays))
        except Damaged as damage:
            return Seen(item, None, str(damage))

    def see_all(some: Sequence[Item]) -> list[Seen]:
        return [see(item) for item in some]

    count = max(1, min(_MOST_PER_CALL, len(items) // _READERS))
    parts = [items[n : n + count] for n in range(0, len(items), count)]
    with concurrent.futures.ThreadPoolExecutor(_READERS) as readers:
        for n in range(0, len(parts), _BATCH):
            for seen in readers.map(see_all, parts[n : n + _BATCH]):
                yield from seen


def last_records(store: Store) -> tuple[dict[str, Record], list[str]]:
    """The last attempt of each item, or the last damage; and the faults of the logs."""
    records, odd = list[Record](), dict[str, int]()
    for name, record in store.logs():
        if record is None:
            odd[name] = odd.get(name, 0) + 1
        elif record["status"] in ("done", "failed", "damaged"):
            records.append(record)
    records.sort(key=lambda r: float(r.get("started", 0)))
    strays = [f"{name} ({n} lines)" for name, n in odd.items()]
    return {record["id"]: record for record in records}, strays


def failures(store: Store) -> dict[str, Record]:
    """The last line of each item whose last attempt failed."""
    last, _ = last_records(store)
    return {item: record for item, record in last.items() if record["status"] == "failed"}


def damage_lines(damaged: dict[str, str]) -> list[str]:
    """Damaged items as lines of the log."""
    made = {"status": "damaged", "started": round(time.time(), 3), "version": version}
    made.update(host=socket.gethostname(), pid=os.getpid())
    return [canonical({**made, "id": i, "error": why}).decode() for i, why in damaged.items()]


def log_damage(store: Store, damaged: dict[str, str]) -> None:
    """Writes damaged items into the log, if it can be written."""
    if damaged:
        with contextlib.suppress(Exception):
            store.log(damage_lines(damaged))


def status_of(plan: Plan, out: str, *, is_full: bool = False) -> Status:
    """Which items of a study are done. is_full: reads all bytes."""
    store = open_store(out)
    there, (last, odd) = store.items(), last_records(store)
    doubted = {item for item, record in last.items() if record["status"] == "damaged"}
    failed = {item: record for item, record in last.items() if record["status"] == "failed"}
    done, damaged, strays = list[Item](), dict[str, str](), [*store.strays(), *odd]
    present = [item for item in plan.items if item.id in there]
    for seen in examine(store, present, is_full=is_full, doubted=doubted):
        strays += seen.strays
        if seen.manifest is None:
            damaged[seen.item.id] = seen.damage
        else:
            done.append(seen.item)
    rest = [item for item in plan.items if item.id not in there]
    return Status(
        done,
        [item for item in rest if item.id not in failed],
        {item.id: failed[item.id] for item in rest if item.id in failed},
        len(there) - len(present),
        damaged,
        strays,
    )


def verify_study(plan: Plan, out: str) -> Status:
    """Reads all results: Study.verify."""
    status = status_of(plan, out, is_full=True)
    log_damage(open_store(out), status.damaged)
    return status
