# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""An executor of local processes, each of which may be killed at any time.

concurrent.futures.ProcessPoolExecutor ends all of its processes when one is killed, and doesn't say
which call was lost. Here each thread of a thread pool has one process: a killed process loses its
own call, with its signal, and the thread starts another one. Processes begin as new interpreters
and not as copies of the caller's main module, so programs need no guard for them.
"""

from __future__ import annotations

import concurrent.futures
import contextlib
import json
import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection, Pipe
from typing import Any

_STARTS = 20  # of a process, until one lives
_START = "import sys, json; sys.path[:] = json.loads(sys.argv[2])\n" + (
    "from pliant.study._local import serve; serve(int(sys.argv[1]))"
)


class WorkerLost(Exception):
    """The process that ran a call has ended."""


def serve(descriptor: int) -> None:
    """Runs calls until the other end of the connection is closed, or its process has ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a Ctrl-C in the terminal is for the caller
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    connection = Connection(descriptor)
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        connection.send(None)  # ready
        while True:
            _answer(connection, *connection.recv())


def _answer(connection: Any, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
    try:
        answer: tuple[bool, Any] = True, function(*arguments)
    except Exception as error:
        answer = False, error
    try:
        connection.send(answer)
    except (TypeError, AttributeError, pickle.PicklingError) as error:
        connection.send((False, RuntimeError(f"the result can't be sent: {error}")))


class _Process:
    def __init__(self, threads: int) -> None:
        count = str(threads) if threads > 0 else str(os.cpu_count() or 1)
        names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
        self.connection, theirs = Pipe()
        # Blocked until it is ignored: a Ctrl-C ends no import.
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            self.process = subprocess.Popen(
                [sys.executable, "-c", _START, str(theirs.fileno()), json.dumps(sys.path)],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                env={**os.environ, **dict.fromkeys(names, count)},
            )
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        theirs.close()

    def is_ready(self) -> bool:
        """Waits until the process has begun; whether it lives."""
        try:
            self.connection.recv()
        except (EOFError, OSError):
            self.connection.close()
            self.process.wait()
            return False
        return True

    def call(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        try:
            self.connection.send((function, arguments))
            is_good, answer = self.connection.recv()
        except (EOFError, OSError):
            self.connection.close()
            raise WorkerLost(f"its process {_ending(self.process.wait())}") from None
        if not is_good:
            raise answer
        return answer

    def close(self) -> None:
        self.connection.close()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def _ending(code: int) -> str:
    if code >= 0:
        return f"ended with status {code}"
    try:
        return f"was killed by {signal.Signals(-code).name}"
    except ValueError:
        return f"was killed by signal {-code}"


class LocalPool(concurrent.futures.Executor):
    """Local processes; a lost call raises WorkerLost.

    Args:
        workers: Number of processes; 0: one for each core.
        threads: That each may use.
    """

    def __init__(self, workers: int = 0, threads: int = 1) -> None:
        self.workers = self._max_workers = workers or len(os.sched_getaffinity(0))
        self._per_process = threads
        self._threads = concurrent.futures.ThreadPoolExecutor(self.workers, "pliant-study")
        self._own = threading.local()
        self._all: list[_Process] = []

    @property
    def pids(self) -> list[int]:
        """The processes at work."""
        return [p.process.pid for p in self._all if p.process.returncode is None]

    def submit(
        self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any
    ) -> concurrent.futures.Future[Any]:
        """Runs a function of positional arguments in one of the processes."""
        if kwargs:
            raise TypeError("LocalPool.submit: expected positional arguments alone")
        return self._threads.submit(self._call, fn, args)

    def _call(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        process: _Process | None = getattr(self._own, "process", None)
        if process is None or process.process.poll() is not None:
            process = self._own.process = self._begin(process)
        return process.call(function, arguments)

    def _begin(self, before: _Process | None) -> _Process:
        """Another process. One that is killed before it has a call loses none."""
        self._own.process, ending = None, ""
        if before is not None:
            before.connection.close()
            self._all.remove(before)
        for _ in range(_STARTS):
            process = _Process(self._per_process)
            self._all.append(process)
            if process.is_ready():
                return process
            self._all.remove(process)
            ending = _ending(process.process.returncode)
        raise WorkerLost(f"{_STARTS} processes {ending} at their start")

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Ends the processes: after their present calls, or at once if calls are cancelled."""
        for process in self._all if cancel_futures else ():
            process.process.kill()
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        for process in self._all:
            process.close()
        self._all.clear()
