# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""One item at work: its arguments, its folder, and whether this thread is at one."""

from __future__ import annotations

import contextlib
import dataclasses
import fnmatch
import os
import threading
from collections.abc import Iterator
from typing import Any

from pliant._error import Error
from pliant.study._keys import one_line

Results = dict[str, Any]
_here = threading.local()


@contextlib.contextmanager
def at_work() -> Iterator[None]:
    """Marks this thread as at work on items."""
    _here.is_working = True
    try:
        yield
    finally:
        _here.is_working = False


def refuse_in_items() -> None:
    """Raises an error if this thread is at work on an item."""
    if getattr(_here, "is_working", False):
        raise Error(
            "study: expected a file whose items don't make the study again; put it below "
            'if __name__ == "__main__":'
        )


@dataclasses.dataclass(frozen=True)
class Work:
    """One item at work.

    Attributes:
        arguments: Those of [run], with the parameters.
        seed: Of the item.
        folder: Where files go.
        threads: That the item may use.
        keep: Patterns of files that are kept; None: the kind's own.
        timeout_s: After which a command is ended; 0: no limit.
    """

    arguments: dict[str, Any]
    seed: int
    folder: str
    threads: int
    keep: list[str] | None
    timeout_s: float = 0.0

    def path(self, name: str) -> str:
        """A file in the folder."""
        return os.path.join(self.folder, name)

    def wants(self, name: str, by_itself: bool = False) -> bool:
        """Whether a file is kept."""
        if self.keep is None:
            return by_itself
        return any(fnmatch.fnmatchcase(name, pattern) for pattern in self.keep)


def too_long(seconds: float) -> Error:
    """The error of an item that has taken too long."""
    line = f"run.timeout_s: expected an end within {seconds:g} s, found none"
    return Error(line, "limit_exceeded")


def line_of(error: BaseException) -> str:
    """An exception in one line."""
    if isinstance(error, OSError) and error.strerror:
        where = f"{error.filename}: " if error.filename else ""
        return one_line(f"{where}{error.strerror}")
    name, text = type(error).__name__, one_line(error)
    if name == "Error":
        return text
    return f"{name}: {text}" if text else name
