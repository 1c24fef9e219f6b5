# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The part of a study that workers run: one call makes a few items, and returns their records."""

from __future__ import annotations

import contextlib
import dataclasses
import errno
import fnmatch
import functools
import os
import shutil
import signal
import socket
import sys
import threading
import time
import traceback
from collections.abc import Iterator, Mapping
from typing import Any

from pliant._core import version
from pliant.study._inputs import Input, Missing, keep_copy, local
from pliant.study._item import Item, arguments_of
from pliant.study._keys import files_below, plain
from pliant.study._kinds import KINDS
from pliant.study._manifest import make_manifest
from pliant.study._store import Record, Store, StoreError
from pliant.study._stores import open_store
from pliant.study._work import Work, at_work, line_of, too_long


@dataclasses.dataclass(frozen=True)
class Job:
    """Values that all items of a run share."""

    store: str
    token: str
    run: dict[str, Any]
    keep: list[str] | None
    threads: int
    timeout_s: float = 0.0


_FULL_BYTES = 1 << 20


@functools.lru_cache(maxsize=4)
def _store(spec: str) -> Store:
    return open_store(spec)


def _address() -> str | None:
    """This worker's address, if it is one of Dask's."""
    if "distributed" not in sys.modules:
        return None
    try:
        return str(sys.modules["distributed"].get_worker().address)
    except ValueError:
        return None


def local_values(value: Any) -> Any:
    """Arguments with inputs as paths on this machine."""
    if isinstance(value, Input):
        return local(value)
    if isinstance(value, Mapping):
        return {name: local_values(v) for name, v in value.items()}
    if isinstance(value, list):
        return [local_values(v) for v in value]
    return value


def _inputs_in(value: Any) -> list[Input]:
    if isinstance(value, Input):
        return [value]
    if isinstance(value, Mapping):
        return [found for v in value.values() for found in _inputs_in(v)]
    if isinstance(value, list):
        return [found for v in value for found in _inputs_in(v)]
    return []


def inputs_of_item(job: Job, item: Item) -> dict[str, Input]:
    """All files of an item by their hashes."""
    found = _inputs_in(arguments_of(job.run, item.parameters))
    return {one.hash: one for one in found}


def run_items(
    job: Job, items: list[Item], sent: list[tuple[Input, bytes]] | None = None
) -> list[Record]:
    """Makes items one after the other; never raises."""
    for found, data in sent or []:
        keep_copy(found, data)
    with at_work():
        return [_attempt(job, item) for item in items]


def receive(found: Input, data: bytes) -> None:
    """Keeps a file on this machine."""
    keep_copy(found, data)


def _attempt(job: Job, item: Item) -> Record:
    begun = time.time()
    record: Record = {
        "id": item.id,
        "status": "failed",
        "started": round(begun, 3),
        "version": version,
        "host": socket.gethostname(),
        "pid": os.getpid(),
    }
    staged = None
    try:
        store = _store(job.store)
        try:
            store.check(job.token)
            staged = store.staging(item.id)
        except OSError as error:
            raise StoreError(line_of(error)) from error
        results = _make(job, item, staged)
        made = {name: record[name] for name in ("host", "pid", "started")}
        made["seconds"] = round(time.time() - begun, 6)
        manifest = make_manifest(item, staged, results, made)
        try:
            store.commit(item.id, staged, manifest)
        except Exception as error:  # object stores have exceptions of their own
            raise StoreError(line_of(error)) from error
        record.update(status="done", hash=manifest["hash"])
    except Missing as missing:
        record.update(status="missing", missing=str(missing), worker=_address())
    except StoreError as error:
        line = str(error)
        where = "" if line.startswith(job.store) else f"{job.store}: "
        record.update(status="store", error=f"{where}{line}")
    except KeyboardInterrupt:
        raise
    except BaseException as error:  # a function may even call sys.exit
        why = _store_error(error, staged)
        record.update(
            status="store" if why else "failed",
            error=f"{line_of(error)}{why}".strip(),
            trace=_trace(error),
        )
    finally:
        if staged is not None:
            shutil.rmtree(staged, ignore_errors=True)
    record["seconds"] = round(time.time() - begun, 6)
    return record


def _store_error(error: BaseException, staged: str | None) -> str:
    """Why an error is the store's: the disk is full, or the staged folder has vanished."""
    if staged is None or not os.path.isdir(staged):
        return " (the results' folder has vanished)"
    codes = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
    if any(os.strerror(code) in str(error) for code in codes):
        return " "
    # Some libraries tell of a short write alone.
    is_full = isinstance(error, OSError) and shutil.disk_usage(staged).free < _FULL_BYTES
    return f" ({os.strerror(errno.ENOSPC)})" if is_full else ""


@contextlib.contextmanager
def _time_limit(seconds: float) -> Iterator[None]:
    """Ends an item that takes too long; in the main thread alone, as signals do."""
    if not seconds or threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(*_: object) -> None:
        raise too_long(seconds)

    before = signal.signal(signal.SIGALRM, end)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _make(job: Job, item: Item, staged: str) -> dict[str, Any]:
    arguments = local_values(arguments_of(job.run, item.parameters))
    work = Work(arguments, item.seed, staged, job.threads, job.keep, job.timeout_s)
    with _time_limit(job.timeout_s):
        results: dict[str, Any] = plain(KINDS[job.run["what"]].run(work), "results")
    if job.keep is not None:
        for name, path in files_below(staged):
            if not any(fnmatch.fnmatchcase(name, pattern) for pattern in job.keep):
                path.unlink()
    return results



def _trace(error: BaseException) -> str:
    text = "".join(traceback.format_exception(error)[-6:])[-4000:]
    return text.encode(errors="replace").decode()
