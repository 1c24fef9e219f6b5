# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Where results are: a folder here, or any file system of fsspec (_objects.py, _zarr.py).

    study.json             the study's name, and a token that tells whether two machines see the
                           same store
    items/3f/3fa9…/        an item, named by its id: its files and manifest.json
    log/….jsonl            one file for each process that ran the study, a line for each attempt
    merged/, report.html   made by merge and report
    damaged/               items that were damaged; a run has moved them there, and repeated them
    tmp/                   items and files that are being made

A folder's item is renamed as a whole. Object stores have no renaming: there the manifest is written
last. In both an item exists if and only if its manifest does.
"""

from __future__ import annotations

import contextlib
import errno
import json
import os
import pathlib
import re
import secrets
import shutil
import socket
import stat
from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO, Protocol

from pliant._error import Error
from pliant.study._keys import canonical, digest_of_path, files_below, open_file, read_file
from pliant.study._manifest import (
    LARGEST_MANIFEST,
    MANIFEST,
    Damaged,
    Manifest,
    is_id,
    parse_manifest,
)

_LONGEST_LINE = 1 << 20  # of a log; longer ones are no records
KNOWN = {"study.json", "items", "log", "merged", "report.html", "best.json", "damaged", "tmp"}
Record = dict[str, Any]
"""A line of the log: id, status, seconds, hash, version, host, pid, error."""


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

    def commit(self, item: str, staged: str, manifest: Manifest) -> None:
        """Makes the item exist, if it doesn't yet; the staged folder is gone afterwards."""

    def items(self) -> set[str]:
        """Ids of all items that are there, whole or damaged."""

    def strays(self) -> list[str]:
        """Names of entries that are no part of a study's results."""

    def manifest(self, item: str) -> Manifest:
        """An item's manifest. Raises Damaged."""

    def check_files(self, item: str, manifest: Manifest, *, is_full: bool) -> list[str]:
        """Compares an item's files with its manifest; returns names of further ones.

        Args:
            is_full: Compares all bytes; else sizes, and bytes of files that have changed since.

        Raises:
            Damaged: A file differs.
        """

    def set_aside(self, item: str) -> str:
        """Moves a damaged item to a place of its own; returns that."""

    def log(self, lines: list[str]) -> None:
        """Appends lines to this process's log."""

    def logs(self) -> Iterator[tuple[str, Record | None]]:
        """Names of logs with their records; None for a line that is none.

        An unfinished last line of a killed process is left out.
        """

    def write(self, files: Mapping[str, bytes]) -> None:
        """Writes files beside the items: all or, where the store can rename, none."""

    def path(self, name: str) -> str:
        """The path of a file beside the items."""

    def tidy(self) -> None:
        """Removes the staged files of processes that were killed on this machine."""


def record_of(line: bytes) -> Record | None:
    """A line of a log; None if it is none."""
    try:
        found = json.loads(line)
    except (ValueError, RecursionError):
        return None
    if not isinstance(found, dict) or not isinstance(found.get("id"), str):
        return None
    started = found.get("started", 0)
    is_time = type(started) in (int, float) and abs(started) < 1e300
    return found if is_time and isinstance(found.get("status"), str) else None


def records_in(stream: BinaryIO) -> Iterator[Record | None]:
    """The records of a log; None for a line that is none."""
    while line := stream.readline(_LONGEST_LINE):
        found = record_of(line)
        if found is not None or line.endswith(b"\n") or len(line) == _LONGEST_LINE:
            yield found


def log_name() -> str:
    """A name for this process's log, which no other process has."""
    return f"{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(4)}.jsonl"


def own_name(item: str) -> str:
    """A new name that tells whose it is."""
    return f"{item}~{socket.gethostname()}~{os.getpid()}~{secrets.token_hex(4)}"


def token_in(data: bytes, marker: str) -> str:
    """The token in study.json.

    Raises:
        pliant.Error: It is another file.
    """
    try:
        return str(json.loads(data)["token"])
    except (ValueError, KeyError, TypeError, RecursionError):
        raise Error(
            f"{marker}: expected a study's results, found another file; remove it, and run the "
            "study again",
            "unreadable",
        ) from None


def remove_left(folder: pathlib.Path) -> None:
    """Removes the leftovers of killed processes from a folder of staged files."""
    host = socket.gethostname()
    with contextlib.suppress(OSError):
        for staged in folder.iterdir():
            parts = staged.name.split("~")
            if len(parts) == 4 and parts[1] == host and not os.path.exists(f"/proc/{parts[2]}"):
                if staged.is_dir():
                    shutil.rmtree(staged, ignore_errors=True)
                else:
                    staged.unlink(missing_ok=True)


def _sync(path: pathlib.Path) -> None:
    with open(path, "rb") as stream:
        os.fsync(stream.fileno())


def _entries(folder: pathlib.Path) -> list[os.DirEntry[str]]:
    """The entries of a folder, sorted; none if it isn't there."""
    try:
        with os.scandir(folder) as entries:
            return sorted(entries, key=lambda e: e.name)
    except FileNotFoundError:
        return []
    except NotADirectoryError:
        found = folder if os.path.lexists(folder) else folder.parent
        raise Error(f"{found}: expected a folder, found a file; move it away") from None


def unwritable(spec: str, error: Exception) -> Error:
    """The error of a store that can't be written."""
    if isinstance(error, OSError) and error.strerror:
        return Error(f"{error.filename or spec}: can't be written ({error.strerror})", "unwritable")
    return Error(f"{spec}: can't be written ({error})", "unwritable")


class FolderStore:
    """A folder, of this machine or one that all machines share."""

    def __init__(self, spec: str) -> None:
        self.spec = os.path.abspath(os.path.expanduser(spec))
        self._root = pathlib.Path(self.spec)
        self._log: Any = None

    def _place(self, item: str) -> str:
        return f"{self.spec}/items/{item[:2]}/{item}"

    def prepare(self, name: str) -> str:
        marker = self._root / "study.json"
        try:
            self._root.mkdir(parents=True, exist_ok=True)
            for place in ("items", "log", "tmp"):
                _entries(self._root / place)
                (self._root / place).mkdir(exist_ok=True)
            if not os.path.lexists(marker):
                token = {"name": name, "token": secrets.token_hex(16)}
                self.write({"study.json": canonical(token)})
            self.tidy()
        except OSError as error:
            raise unwritable(self.spec, error) from None
        return token_in(self._marker(), str(marker))

    def _marker(self) -> bytes:
        try:
            return read_file(self._root / "study.json", _LONGEST_LINE)
        except OSError as error:
            raise Error(f"{self.path('study.json')}: {error.strerror}", "unreadable") from None

    def tidy(self) -> None:
        remove_left(self._root / "tmp")

    def check(self, token: str) -> None:
        host = socket.gethostname()
        try:
            found = token_in(self._marker(), self.path("study.json"))
        except Error:
            raise StoreError(
                f"the results' folder has vanished, or {host} doesn't see it; expected one that "
                "all machines share, or a URL of an object store"
            ) from None
        if found != token:
            raise StoreError(
                f"{host} sees another folder than the study; expected one that all machines "
                "share, or a URL of an object store"
            )

    def staging(self, item: str) -> str:
        path = self._root / "tmp" / own_name(item)
        path.mkdir()
        return str(path)

    def commit(self, item: str, staged: str, manifest: Manifest) -> None:
        folder, place = pathlib.Path(staged), pathlib.Path(self._place(item))
        (folder / MANIFEST).write_bytes(canonical(manifest))
        for _, path in files_below(folder):
            _sync(path)
        try:
            try:
                os.replace(folder, place)
            except FileNotFoundError:
                place.parent.mkdir(exist_ok=True)
                os.replace(folder, place)
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST, errno.ENOTDIR):
                raise
            try:
                self.manifest(item)
                shutil.rmtree(folder, ignore_errors=True)  # another process was first
            except Damaged:
                self.set_aside(item)
                os.replace(folder, place)

    def _scan(self) -> tuple[set[str], list[str]]:
        """Ids of items, and names of other entries beside them."""
        found, strays = set[str](), list[str]()
        for shard in _entries(self._root / "items"):
            if not re.fullmatch("[0-9a-f]{2}", shard.name):
                strays.append(f"items/{shard.name}")
                continue
            for entry in _entries(pathlib.Path(shard.path)):
                if is_id(entry.name) and entry.name.startswith(shard.name):
                    found.add(entry.name)
                else:
                    strays.append(f"items/{shard.name}/{entry.name}")
        return found, strays

    def items(self) -> set[str]:
        return self._scan()[0]

    def strays(self) -> list[str]:
        found = [e.name for e in _entries(self._root) if e.name not in KNOWN]
        found += [
            f"log/{e.name}"
            for e in _entries(self._root / "log")
            if not e.name.endswith(".jsonl") or not e.is_file()
        ]
        return found + self._scan()[1]

    def manifest(self, item: str) -> Manifest:
        try:
            data = read_file(f"{self._place(item)}/{MANIFEST}", LARGEST_MANIFEST)
        except (FileNotFoundError, NotADirectoryError):
            raise Damaged(f"{MANIFEST}: expected a file, found none") from None
        except OSError as error:
            if error.errno in (errno.EINVAL, errno.ELOOP, errno.ENXIO):
                raise Damaged(f"{MANIFEST}: {error.strerror}") from None
            raise
        return parse_manifest(item, data)

    def check_files(self, item: str, manifest: Manifest, *, is_full: bool) -> list[str]:
        place = self._place(item)
        # A manifest is written after the files. Times of status changes can't be set back.
        written = os.stat(f"{place}/{MANIFEST}").st_ctime_ns
        for name, known in manifest["files"].items():
            try:
                path = f"{place}/{name}"
                found = os.stat(path)
                if not stat.S_ISREG(found.st_mode):
                    open_file(path).close()  # says which kind it is
                if found.st_size != known["bytes"]:
                    raise Damaged(f"{name}: expected {known['bytes']} B, found {found.st_size} B")
                if not is_full and found.st_ctime_ns < written:
                    continue
                if digest_of_path(path) != known["hash"]:
                    raise Damaged(f"{name}: its bytes differ from the manifest's hash")
            except (FileNotFoundError, NotADirectoryError):
                raise Damaged(f"{name}: expected a file, found none") from None
            except OSError as error:
                if error.errno in (errno.EINVAL, errno.ELOOP, errno.ENXIO):
                    raise Damaged(f"{name}: {error.strerror}") from None
                raise
        own = {MANIFEST, *(name.split("/")[0] for name in manifest["files"])}
        return [f"items/{item[:2]}/{item}/{n}" for n in os.listdir(place) if n not in own]

    def set_aside(self, item: str) -> str:
        target = self._root / "damaged" / own_name(item)
        try:
            target.parent.mkdir(exist_ok=True)
            self.move(self._place(item), str(target))
        except OSError as error:
            raise unwritable(self.spec, error) from None
        return str(target)

    def move(self, source: str, target: str) -> None:
        """Moves a folder or file, if it is there."""
        with contextlib.suppress(FileNotFoundError):
            os.replace(source, target)

    def log(self, lines: list[str]) -> None:
        if self._log is None:
            self._log = open(self._root / "log" / log_name(), "a", encoding="utf-8")  # noqa: SIM115
        self._log.write("".join(line + "\n" for line in lines))
        self._log.flush()

    def logs(self) -> Iterator[tuple[str, Record | None]]:
        for entry in _entries(self._root / "log"):
            if entry.name.endswith(".jsonl") and entry.is_file():
                with open_file(entry.path) as stream:
                    for record in records_in(stream):
                        yield f"log/{entry.name}", record

    def path(self, name: str) -> str:
        return str(self._root / name)

    def write(self, files: Mapping[str, bytes]) -> None:
        staged = dict[pathlib.Path, pathlib.Path]()
        try:
            (self._root / "tmp").mkdir(parents=True, exist_ok=True)
            for name, data in files.items():
                path = self._root / name
                path.parent.mkdir(exist_ok=True)
                if path.is_dir():
                    raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
                staged[path] = self._root / "tmp" / own_name(path.name)
                staged[path].write_bytes(data)
                _sync(staged[path])
            for path, made in staged.items():
                os.replace(made, path)
        except OSError as error:
            for made in staged.values():
                with contextlib.suppress(OSError):
                    made.unlink(missing_ok=True)
            raise unwritable(self.spec, error) from None
