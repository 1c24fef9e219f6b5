# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Engines: any concurrent.futures.Executor, with the additions for Dask and MPI."""

from __future__ import annotations

import concurrent.futures
import contextlib
import importlib
import logging
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

from pliant._core import version
from pliant._error import Error
from pliant.study._inputs import Input
from pliant.study._local import LocalPool, WorkerLost
from pliant.study._worker import receive

_WAIT_S = 600.0  # for a scheduler that comes back
Future = concurrent.futures.Future[Any]


class SchedulerLost(Exception):
    """The engine's scheduler has gone, and all calls with it; no call is at fault.

    Args:
        connection: Number of the connection that is lost.
    """

    def __init__(self, connection: int) -> None:
        super().__init__(connection)
        self.connection = connection


class Engine:
    """An executor, and how a study uses it.

    Args:
        executor: Runs calls.
        window: Calls that are submitted and not yet done.
    """

    def __init__(self, executor: concurrent.futures.Executor, window: int) -> None:
        self.executor, self._window = executor, window

    @property
    def window(self) -> int:
        """Calls that should be submitted and not yet done."""
        return self._window

    def submit(self, fn: Callable[..., Any], *args: Any) -> Future:
        """Runs a call somewhere."""
        return self.executor.submit(fn, *args)

    def send(self, worker: str | None, found: Input, data: bytes) -> Future | None:
        """Brings a file to a worker's machine; None: it goes with the next call instead."""
        return None

    def reconnect(self, lost: SchedulerLost, tell: Callable[[str], None]) -> None:
        """Waits for a scheduler that has gone; does nothing if that was done for another call.

        Raises:
            pliant.Error: It doesn't come back.
        """
        raise Error("engine: expected its scheduler, which has gone", "not_found")


def version_here() -> str:
    """Pliant's version of a worker."""
    return str(version)


def _optional(module: str, field: str) -> Any:
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise Error(
            f"{field}: expected the packages of pip install 'pliant[study]', found {error}",
            "unsupported",
            field,
        ) from None


class DaskEngine(Engine):
    """Dask Distributed. Calls of lost workers fail; a scheduler may be started anew."""

    def __init__(self, address: str) -> None:
        self._dask = _optional("distributed", "engine")
        self._address, self._number, self._connection = address, 0, 0
        for name in ("distributed", "distributed.client", "distributed.core"):
            logging.getLogger(name).setLevel(logging.CRITICAL)  # errors are told here
        self._lock, self._running = threading.Lock(), dict[str, tuple[Any, Future, int]]()
        self._client = self._connect(10)
        self._check_versions()

    def _connect(self, timeout_s: float) -> Any:
        try:
            return self._dask.Client(self._address, timeout=timeout_s, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise Error(
                f"engine: expected a Dask scheduler at {self._address}, found none "
                f"({type(error).__name__}); start one with: dask scheduler",
                "not_found",
                "engine",
            ) from None

    def _check_versions(self) -> None:
        try:
            found = self._client.run(version_here)
        except ImportError as error:
            raise Error(
                f"engine: expected pliant {version} on all workers of {self._address}, found "
                f"{' '.join(str(error).split())}",
                "unsupported",
                "engine",
            ) from None
        except Exception:
            return  # a worker was lost just now
        for worker, other in found.items():
            if other != version:
                raise Error(
                    f"engine: expected pliant {version} on worker {worker}, found {other}",
                    "unsupported",
                    "engine",
                )

    @property
    def window(self) -> int:
        """Enough for an adaptive cluster to see that more workers are needed."""
        with contextlib.suppress(Exception):
            info = self._client.scheduler_info(n_workers=-1)
            threads: int = sum(w.get("nthreads", 1) for w in info.get("workers", {}).values())
            return max(200, 3 * threads)
        return 200

    def submit(self, fn: Callable[..., Any], *args: Any) -> Future:
        """Runs a call on any worker."""
        return self._submit(fn, *args)

    def _submit(self, fn: Callable[..., Any], *args: Any, **options: Any) -> Future:
        made: Future = concurrent.futures.Future()
        with self._lock:
            self._number += 1
            key = f"pliant-study-{id(self):x}-{self._number}"
        if self._client.status != "running":
            made.set_exception(SchedulerLost(self._connection))
            return made
        future = self._client.submit(fn, *args, key=key, pure=False, **options)
        with self._lock:
            self._running[key] = future, made, self._connection
        future.add_done_callback(self._done)
        return made

    def _done(self, future: Any) -> None:
        with self._lock:
            _, made, connection = self._running.pop(future.key, (None, None, 0))
        if made is None:
            return
        try:
            if future.status == "finished":
                made.set_result(future.result(timeout=60))
            elif future.status == "error":
                made.set_exception(WorkerLost(_reason(future.exception(timeout=60))))
            else:
                made.set_exception(SchedulerLost(connection))
        except concurrent.futures.InvalidStateError:
            return  # cancelled
        except Exception:
            made.set_exception(SchedulerLost(connection))

    def send(self, worker: str | None, found: Input, data: bytes) -> Future | None:
        """Sends the file to one worker of the machine."""
        if worker is None:
            return None
        moved = self._client.scatter(data, workers=[worker], hash=False)
        return self._submit(receive, found, moved, workers=[worker], allow_other_workers=False)

    def reconnect(self, lost: SchedulerLost, tell: Callable[[str], None]) -> None:
        """Tries for ten minutes."""
        if lost.connection != self._connection:
            return
        with self._lock:
            gone, self._running = self._running, {}
        for _, made, connection in gone.values():
            with contextlib.suppress(concurrent.futures.InvalidStateError):
                made.set_exception(SchedulerLost(connection))
        self._connection += 1
        with contextlib.suppress(Exception):
            self._client.close(timeout=2)
        tell(f"waiting for the Dask scheduler at {self._address}")
        deadline = time.monotonic() + _WAIT_S
        while True:
            try:
                self._client = self._connect(5)
                return
            except Error:
                if time.monotonic() > deadline:
                    raise
                time.sleep(1)

    def close(self) -> None:
        """Ends the connection."""
        with contextlib.suppress(Exception):
            self._client.close(timeout=5)


def _reason(error: BaseException | None) -> str:
    if type(error).__name__ == "KilledWorker":
        return "the workers that it ran on were lost"
    return f"{type(error).__name__}: {' '.join(str(error).split())}"


@contextlib.contextmanager
def open_engine(
    engine: str | concurrent.futures.Executor, workers: int, threads: int
) -> Iterator[Engine | None]:
    """The engine of a name; None in MPI's ranks that have served the first one.

    Raises:
        pliant.Error: The name is unknown, a package is missing, or there is no scheduler.
    """
    if isinstance(engine, concurrent.futures.Executor):
        yield Engine(engine, 2 * int(getattr(engine, "_max_workers", 0) or workers or 16))
    elif engine == "local":
        pool = LocalPool(workers, threads)
        try:
            yield Engine(pool, 2 * pool.workers)
        finally:
            pool.shutdown(cancel_futures=True)
    elif engine == "mpi":
        world = _optional("mpi4py.MPI", "engine").COMM_WORLD
        futures = _optional("mpi4py.futures", "engine")
        with futures.MPICommExecutor(world, root=0) as executor:
            ranks = max(world.Get_size() - 1, 1)
            yield None if executor is None else Engine(executor, 2 * ranks)
    elif isinstance(engine, str) and engine.startswith("dask://"):
        dask = DaskEngine("tcp://" + engine.removeprefix("dask://"))
        try:
            yield dask
        finally:
            dask.close()
    else:
        raise Error(
            f"engine: expected local, dask://HOST:PORT, mpi or an Executor, found {engine}",
            field="engine",
        )
