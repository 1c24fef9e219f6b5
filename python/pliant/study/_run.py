# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The loop that gives items to an engine until each was attempted.

Results say which items are done, never the engine: a lost call is repeated for those of its items
that have no result. An item whose call was lost five times counts as failed, since it may itself
kill its worker. Calls hold several items where items are short.
"""

from __future__ import annotations

import collections
import concurrent.futures
import contextlib
import dataclasses
import queue
import sys
import time
from typing import Any

from pliant._core import version
from pliant._error import Error
from pliant.study._engines import Engine, SchedulerLost
from pliant.study._inputs import contents
from pliant.study._item import Item
from pliant.study._keys import canonical, one_line
from pliant.study._plan import Plan
from pliant.study._store import Record, Store
from pliant.study._stores import open_store
from pliant.study._verify import Status, damage_lines, status_of
from pliant.study._work import line_of
from pliant.study._worker import Job, inputs_of_item, run_items

_MOST_LOSSES = 5
_MOST_SENDS = 10  # of one item's files
_CALL_S = 0.1  # calls of short items are so long, and with many workers so long for each call that
_PER_CALL_S = 0.001  # waits or runs: schedulers need about that for one
_MOST_PER_CALL = 1000
_DRAIN_S = 10.0
_SHOWN = 5
BY_USER = "by Ctrl-C"
_LOG_S = {False: 0.5, True: 20.0}  # between writes of the log: of a folder; of a URL


@dataclasses.dataclass(frozen=True)
class RunReport:
    """Result of a run.

    Attributes:
        done: Items that got a result in this run.
        known: Items that had one before.
        failed: Lines of the items that failed, by id.
        skipped: Items that failed before, and were not tried again.
        left: Items without an attempt, because the run was stopped.
        lost: Calls whose worker was lost.
        seconds: Of the run.
        stopped: Why it was stopped, or nothing.
        damaged: Where items that were damaged are now, by id. They were repeated.
    """

    done: int
    known: int
    failed: dict[str, str]
    skipped: int
    left: int
    lost: int
    seconds: float
    stopped: str = ""
    damaged: dict[str, str] = dataclasses.field(default_factory=dict)

    @property
    def is_complete(self) -> bool:
        """Whether all items have results."""
        return not (self.failed or self.skipped or self.left)

    def __str__(self) -> str:
        parts = [f"{self.done + self.known} items done"]
        parts += [f"{self.known} of them before"] if self.known else []
        parts += [f"{len(self.failed)} failed"] if self.failed else []
        parts += [f"{self.skipped} failed before (--retry-failed)"] if self.skipped else []
        parts += [f"{self.left} left"] if self.left else []
        parts += [f"{self.lost} calls repeated"] if self.lost else []
        parts += [f"{len(self.damaged)} damaged, set aside"] if self.damaged else []
        stopped = f"\nstopped: {self.stopped}" if self.stopped else ""
        return f"{', '.join(parts)}; {self.seconds:.1f} s{stopped}"


class _Progress:
    """A line on a terminal; nothing elsewhere."""

    def __init__(self, is_shown: bool, total: int) -> None:
        self._is_shown = is_shown and sys.stderr.isatty()
        self._total, self._begun, self._last, self._width = total, time.monotonic(), 0.0, 0

    def show(self, done: int, failed: int) -> None:
        now = time.monotonic()
        if not self._is_shown or now - self._last < 0.2:
            return
        self._last, past = now, now - self._begun
        share = (done + failed) / max(self._total, 1)
        rest = f", {past / share - past:.0f} s left" if share > 0 else ""
        bar = "#" * int(30 * share)
        bad = f", {failed} failed" if failed else ""
        line = f"[{bar:<30}] {done + failed}/{self._total}{bad}{rest}"
        sys.stderr.write("\r" + line.ljust(self._width))
        sys.stderr.flush()
        self._width = len(line)

    def tell(self, line: str) -> None:
        self.end()
        sys.stderr.write(f"pliant study: {line}\n")

    def end(self) -> None:
        if self._is_shown and self._width:
            sys.stderr.write("\r" + " " * self._width + "\r")
            sys.stderr.flush()
            self._width = 0


@dataclasses.dataclass
class _Call:
    items: list[Item]
    sent: list[Any] = dataclasses.field(default_factory=list)


class _Run:
    def __init__(
        self,
        job: Job,
        store: Store,
        engine: Engine,
        items: list[Item],
        progress: _Progress,
        lines: list[str],
    ) -> None:
        self._job, self._store, self._engine, self._progress = job, store, engine, progress
        self._waiting = collections.deque(items)
        self._again = collections.deque[_Call]()
        self._running = dict[concurrent.futures.Future[Any], _Call]()
        self._finished = queue.SimpleQueue[concurrent.futures.Future[Any]]()
        self._losses, self._sends = collections.Counter[str](), collections.Counter[str]()
        self._sending = dict[tuple[str, str], concurrent.futures.Future[Any]]()
        self._held = dict[concurrent.futures.Future[Any], list[Item]]()  # until a file has come
        self._lines, self._logged = lines, time.monotonic()
        self._store_errors, self._mean_s = 0, 0.0
        self._window, self._window_known = engine.window, time.monotonic()
        self.done, self.lost, self.stopped, self.unwritten = 0, 0, "", ""
        self.failed = dict[str, str]()

    def loop(self) -> None:
        try:
            while self._is_busy() and not self.stopped:
                self._submit()
                self._collect(1.0)
                self._progress.show(self.done, len(self.failed))
        except KeyboardInterrupt:
            self.stopped = BY_USER
        for future in list(self._running):
            future.cancel()
        if self.stopped:
            self._drain()
        self._write_log(is_last=True)

    def _is_busy(self) -> bool:
        return bool(self._waiting or self._again or self._running or self._held)

    def _drain(self) -> None:
        """Waits a little for calls that run, so that their results are logged."""
        if self._running:
            self._progress.tell(f"stopping; items at work have {_DRAIN_S:.0f} s to end")
        deadline = time.monotonic() + _DRAIN_S
        with contextlib.suppress(KeyboardInterrupt):
            while self._running and time.monotonic() < deadline:
                self._collect(0.5)

    def _per_call(self) -> int:
        if not self._mean_s:
            return 1
        fair = len(self._waiting) // (2 * self._window) + 1
        call_s = max(_CALL_S, _PER_CALL_S * self._window)
        return max(1, min(_MOST_PER_CALL, int(call_s / max(self._mean_s, 1e-4)), fair))

    def _submit(self) -> None:
        if time.monotonic() - self._window_known > 5:
            self._window, self._window_known = self._engine.window, time.monotonic()
        while len(self._running) < self._window and (self._waiting or self._again):
            # Items that were lost come last, alone.
            if self._waiting:
                count = min(self._per_call(), len(self._waiting))
                call = _Call([self._waiting.popleft() for _ in range(count)])
            else:
                call = self._again.popleft()
            future = self._engine.submit(run_items, self._job, call.items, call.sent)
            self._running[future] = call
            future.add_done_callback(self._finished.put)

    def _collect(self, wait_s: float) -> None:
        try:
            future = self._finished.get(timeout=wait_s)
        except queue.Empty:
            self._write_log()
            return
        while True:
            self._take(future)
            try:
                future = self._finished.get_nowait()
            except queue.Empty:
                break
        self._write_log()

    def _take(self, future: concurrent.futures.Future[Any]) -> None:
        if future in self._held:
            self._arrived(future)
            return
        call = self._running.pop(future, None)
        if call is None or future.cancelled():
            return
        error = future.exception()
        if error is None:
            for record, item in zip(future.result(), call.items, strict=True):
                self._record(record, item)
        elif isinstance(error, SchedulerLost):
            self._repeat(call, "", is_counted=False)
            if not self.stopped:
                self._engine.reconnect(error, self._progress.tell)
        else:
            self.lost += 1
            self._repeat(call, one_line(error) or type(error).__name__, is_counted=True)

    def _repeat(self, call: _Call, why: str, *, is_counted: bool) -> None:
        """Repeats the items of a lost call that have no result. The first may be at fault."""
        is_first = is_counted
        for item in call.items:
            made = None
            with contextlib.suppress(Exception):
                made = self._store.manifest(item.id)
            if made is not None:
                self._record(_record_of(made), item)
                continue
            if is_first:
                is_first = False
                self._losses[item.id] += 1
                record: Record = {"id": item.id, "status": "lost", "error": why}
                record.update(version=version, started=round(time.time(), 3))
                if self._losses[item.id] >= _MOST_LOSSES:
                    line = f"{why}; {_MOST_LOSSES} times"
                    self._record({**record, "status": "failed", "error": line}, item)
                    continue
                self._lines.append(canonical(record).decode())
            self._again.append(_Call([item]))

    def _record(self, record: Record, item: Item) -> None:
        status, seconds = record["status"], float(record.get("seconds", 0))
        if status == "missing":
            self._send(record, item)
            return
        self._lines.append(canonical(record).decode())
        if status == "done":
            self.done, self._store_errors = self.done + 1, 0
            self._mean_s += (seconds - self._mean_s) / min(self.done, 20)
        elif status == "failed":
            self.failed[item.id] = str(record.get("error", ""))
        else:
            self._store_errors += 1
            self.unwritten = f"{record['error']}; put it right, and run the study again"
            if self._store_errors > max(3, self._window // 2):
                self.stopped = self.unwritten

    def _send(self, record: Record, item: Item) -> None:
        """Brings a file to a machine that lacks it, once, and repeats the item."""
        found = inputs_of_item(self._job, item)[record["missing"]]
        self._sends[item.id] += 1
        if self._sends[item.id] > _MOST_SENDS:
            error = f"{found.name}: can't be sent to {record['host']}"
            self._record({**record, "status": "failed", "error": error}, item)
            return
        there = record["host"], found.hash
        arrived = self._sending.get(there)
        if arrived is None:
            try:
                sent, data = contents(found)
            except Exception as error:
                line = f"{found.name}: can't be read ({line_of(error)})"
                self._record({**record, "status": "failed", "error": line}, item)
                return
            arrived = self._engine.send(record.get("worker"), sent, data)
            if arrived is None:
                self._again.append(_Call([item], [(sent, data)]))
                return
            self._sending[there] = arrived
            self._held[arrived] = []
            arrived.add_done_callback(self._finished.put)
        if arrived in self._held:
            self._held[arrived].append(item)
        else:
            self._again.append(_Call([item]))

    def _arrived(self, future: concurrent.futures.Future[Any]) -> None:
        """A file has come to its machine, or not: then it is sent again when it is missing."""
        self._again.extend(_Call([item]) for item in self._held.pop(future))
        if future.cancelled() or future.exception() is not None:
            self._sending = {k: v for k, v in self._sending.items() if v is not future}

    def _write_log(self, *, is_last: bool = False) -> None:
        now = time.monotonic()
        if not self._lines or (
            not is_last and now - self._logged < _LOG_S["://" in self._store.spec]
        ):
            return
        self._logged = now
        try:
            self._store.log(self._lines)
            self._lines = []
        except Exception as error:
            if is_last:
                self._progress.tell(f"the log can't be written ({line_of(error)})")


def strays_line(status: Status) -> str:
    """The note of entries that are ignored."""
    names = ", ".join(status.strays[:_SHOWN])
    more = f" and {len(status.strays) - _SHOWN} more" if len(status.strays) > _SHOWN else ""
    return one_line(f"note: no part of the results, and ignored: {names}{more}")


def _record_of(manifest: dict[str, Any]) -> Record:
    made = {key: manifest[key] for key in ("id", "version", "hash")}
    return {**made, **manifest["made"], "status": "done"}


def run_on(
    plan: Plan, out: str, engine: Engine, threads: int, retry_failed: bool, progress: bool
) -> RunReport:
    """Runs a plan on an engine that is open."""
    begun = time.monotonic()
    store = open_store(out)
    token = store.prepare(plan.name)
    status = status_of(plan, out)
    skipped = 0 if retry_failed else len(status.failed)
    again = {*status.damaged, *(status.failed if retry_failed else ())}
    items = status.left + [i for i in plan.items if i.id in again]
    shown = _Progress(progress, len(items))
    if status.strays:
        shown.tell(strays_line(status))
    aside = {}
    for item, damage in status.damaged.items():
        aside[item] = store.set_aside(item)
        shown.tell(f"{item}: {damage}; set aside: {aside[item]}")
    job = Job(store.spec, token, plan.run_table, plan.keep["files"], threads, plan.timeout_s)
    run = _Run(job, store, engine, items, shown, damage_lines(status.damaged))
    run.loop()
    store.tidy()
    shown.end()
    left = len(items) - run.done - len(run.failed)
    return RunReport(
        run.done, len(status.done), run.failed, skipped, left, run.lost,
        time.monotonic() - begun, run.stopped or run.unwritten, aside,
    )  # fmt: skip
