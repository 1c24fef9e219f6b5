# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Where results are: a folder, or any file system of fsspec.

    study.json             the study's name, and a token that tells whether two machines see the
                           same store
    items/3f/3fa9…/        an item, named by its id: its files and manifest.json
    log/….jsonl            one file for each process that ran the study, a line for each attempt
    merged/, report.html   made by merge and report
    tmp/                   items that are being made

A folder's item is renamed as a whole. Object stores have no renaming: there the manifest is written
last. In both an item exists if and only if its manifest does.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import pathlib
import secrets
import shutil
import socket
from collections.abc import Iterator
from typing import Any, Protocol

from pliant._error import Error
from pliant.study._inputs import cache, filesystem, is_url
from pliant.study._keys import canonical, files_below

MANIFEST = "manifest.json"


class StoreError(Exception):
    """The store can't be written now; the item isn't at fault."""


class Store(Protocol):
    """A place for results."""

    spec: str

    def prepare(self, name: str) -> str:
        """Makes the store, unless it is there; returns its token."""

    def check(self, token: str) -> None:
        """Raises StoreError, unless this process sees the store with the token."""

    def staging(self, item: str) -> str:
        """A new folder on this machine for an item's files."""

    def commit(self, item: str, staged: str, manifest: dict[str, Any]) -> None:
        """Makes the item exist, if it doesn't yet; the staged folder is gone afterwards."""

    def items(self) -> set[str]:
        """Ids of all items that exist."""

    def manifest(self, item: str) -> dict[str, Any]:
        """An item's manifest."""

    def read(self, item: str, name: str) -> bytes:
        """A file of an item."""

    def log(self, lines: list[str]) -> None:
        """Appends lines to this process's log."""

    def logs(self) -> Iterator[dict[str, Any]]:
        """The lines of all logs; an unfinished last line of a killed process is left out."""

    def write(self, name: str, data: bytes) -> str:
        """Writes a file beside the items as a whole; returns its path."""

    def tidy(self) -> None:
        """Removes the staged files of processes that were killed on this machine."""


def _lines(text: str) -> Iterator[dict[str, Any]]:
    for line in text.splitlines():
        with contextlib.suppress(ValueError):
            yield json.loads(line)


def log_name() -> str:
    """A name for this process's log, which no other process has."""
    return f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(4)}.jsonl"


def _sync(path: pathlib.Path) -> None:
    with open(path, "rb") as stream:
        os.fsync(stream.fileno())


def _staged(folder: pathlib.Path, item: str) -> str:
    """A new folder that tells whose it is."""
    path = folder / f"{item}~{socket.gethostname()}~{os.getpid()}~{secrets.token_hex(4)}"
    path.mkdir()
    return str(path)


def _tidy(folder: pathlib.Path) -> None:
    host = socket.gethostname()
    with contextlib.suppress(OSError):
        for staged in folder.iterdir():
            parts = staged.name.split("~")
            if len(parts) == 4 and parts[1] == host and not os.path.exists(f"/proc/{parts[2]}"):
                shutil.rmtree(staged, ignore_errors=True)


class FolderStore:
    """A folder, of this machine or one that all machines share."""

    def __init__(self, spec: str) -> None:
        self.spec = os.path.abspath(os.path.expanduser(spec))
        self._root = pathlib.Path(self.spec)
        self._log: Any = None

    def _place(self, item: str) -> pathlib.Path:
        return self._root / "items" / item[:2] / item

    def prepare(self, name: str) -> str:
        marker = self._root / "study.json"
        try:
            self._root.mkdir(parents=True, exist_ok=True)
            if not marker.exists():
                token = {"name": name, "token": secrets.token_hex(16)}
                self.write("study.json", canonical(token))
            for place in ("items", "log", "tmp"):
                (self._root / place).mkdir(exist_ok=True)
            self.tidy()
            return str(json.loads(marker.read_bytes())["token"])
        except OSError as error:
            raise Error(f"{self.spec}: can't be written ({error.strerror})", "unwritable") from None
        except (ValueError, KeyError, TypeError):
            raise Error(f"{marker}: expected a study's results, found another file") from None

    def tidy(self) -> None:
        _tidy(self._root / "tmp")

    def check(self, token: str) -> None:
        try:
            found = json.loads((self._root / "study.json").read_bytes())["token"]
        except (OSError, ValueError, KeyError, TypeError):
            raise StoreError(
                f"{self.spec}: {socket.gethostname()} doesn't see the results' folder; expected "
                "one that all machines share, or a URL of an object store"
            ) from None
        if found != token:
            raise StoreError(
                f"{self.spec}: {socket.gethostname()} sees another folder than the study; expected "
                "one that all machines share, or a URL of an object store"
            )

    def staging(self, item: str) -> str:
        return _staged(self._root / "tmp", item)

    def commit(self, item: str, staged: str, manifest: dict[str, Any]) -> None:
        folder, place = pathlib.Path(staged), self._place(item)
        (folder / MANIFEST).write_bytes(canonical(manifest))
        for _, path in files_below(folder):
            _sync(path)
        try:
            os.replace(folder, place)
        except OSError as error:
            if error.errno == errno.ENOENT:
                place.parent.mkdir(exist_ok=True)
                os.replace(folder, place)
            elif error.errno in (errno.ENOTEMPTY, errno.EEXIST):
                shutil.rmtree(folder, ignore_errors=True)  # another process was first
            else:
                raise

    def items(self) -> set[str]:
        found: set[str] = set()
        with contextlib.suppress(FileNotFoundError):
            for shard in os.scandir(self._root / "items"):
                found.update(os.listdir(shard.path))
        return found

    def manifest(self, item: str) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.read(item, MANIFEST))
        return found

    def read(self, item: str, name: str) -> bytes:
        return (self._place(item) / name).read_bytes()

    def log(self, lines: list[str]) -> None:
        if self._log is None:
            self._log = open(self._root / "log" / log_name(), "a", encoding="utf-8")  # noqa: SIM115
        self._log.write("".join(line + "\n" for line in lines))
        self._log.flush()

    def logs(self) -> Iterator[dict[str, Any]]:
        for path in sorted((self._root / "log").glob("*.jsonl")):
            yield from _lines(path.read_text(encoding="utf-8", errors="replace"))

    def write(self, name: str, data: bytes) -> str:
        path = self._root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        staged = path.with_name(f".{path.name}.{os.getpid()}")
        staged.write_bytes(data)
        _sync(staged)
        os.replace(staged, path)
        return str(path)


class UrlStore:
    """An object store, or another file system of fsspec."""

    def __init__(self, spec: str) -> None:
        self.spec = spec.rstrip("/")
        self._system, self._root = filesystem(self.spec)
        self._log_name, self._log_lines = log_name(), list[str]()

    def _path(self, *parts: str) -> str:
        return "/".join([self._root, *parts])

    def _place(self, item: str) -> str:
        return self._path("items", item[:2], item)

    def prepare(self, name: str) -> str:
        marker = self._path("study.json")
        try:
            self._system.makedirs(self._root, exist_ok=True)
            if not self._system.exists(marker):
                token = {"name": name, "token": secrets.token_hex(16)}
                self._system.pipe_file(marker, canonical(token))
            return str(json.loads(self._system.cat_file(marker))["token"])
        except OSError as error:
            raise Error(f"{self.spec}: can't be written ({error})", "unwritable") from None

    def check(self, token: str) -> None:
        """Writes tell: a URL means the same on all machines."""

    def staging(self, item: str) -> str:
        return _staged(cache() / "staging", item)

    def tidy(self) -> None:
        _tidy(cache() / "staging")

    def commit(self, item: str, staged: str, manifest: dict[str, Any]) -> None:
        for name, path in files_below(staged):
            self._put(f"{self._place(item)}/{name}", path.read_bytes())
        self._put(f"{self._place(item)}/{MANIFEST}", canonical(manifest))
        shutil.rmtree(staged, ignore_errors=True)

    def _put(self, path: str, data: bytes) -> None:
        self._system.makedirs(path.rsplit("/", 1)[0], exist_ok=True)
        self._system.pipe_file(path, data)

    def items(self) -> set[str]:
        self._system.invalidate_cache()
        try:
            found = self._system.find(self._path("items"))
        except FileNotFoundError:
            return set()
        return {p.split("/")[-2] for p in found if p.endswith(f"/{MANIFEST}")}

    def manifest(self, item: str) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self.read(item, MANIFEST))
        return found

    def read(self, item: str, name: str) -> bytes:
        data: bytes = self._system.cat_file(f"{self._place(item)}/{name}")
        return data

    def log(self, lines: list[str]) -> None:
        self._log_lines += lines
        text = "".join(line + "\n" for line in self._log_lines)
        self._put(self._path("log", self._log_name), text.encode())

    def logs(self) -> Iterator[dict[str, Any]]:
        self._system.invalidate_cache()
        try:
            names = sorted(self._system.find(self._path("log")))
        except FileNotFoundError:
            return
        for name in names:
            yield from _lines(self._system.cat_file(name).decode())

    def write(self, name: str, data: bytes) -> str:
        self._put(self._path(name), data)
        return f"{self.spec}/{name}"
