# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Results in an object store, or another file system of fsspec. _store.py has the names in it."""

from __future__ import annotations

import contextlib
import io
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping

from pliant.study._inputs import cache, filesystem
from pliant.study._keys import canonical, digest_of_stream, files_below
from pliant.study._manifest import MANIFEST, Damaged, Manifest, is_id, parse_manifest
from pliant.study._store import (
    KNOWN,
    Record,
    log_name,
    own_name,
    records_in,
    remove_left,
    token_in,
    unwritable,
)


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
            data = self._system.cat_file(marker)
        except Exception as error:  # object stores have exceptions of their own
            raise unwritable(self.spec, error) from None
        return token_in(data, f"{self.spec}/study.json")

    def check(self, token: str) -> None:
        """Writes tell: a URL means the same on all machines."""

    def staging(self, item: str) -> str:
        path = cache() / "staging" / own_name(item)
        path.mkdir()
        return str(path)

    def tidy(self) -> None:
        remove_left(cache() / "staging")

    def commit(self, item: str, staged: str, manifest: Manifest) -> None:
        for name, path in files_below(staged):
            self._put(f"{self._place(item)}/{name}", path.read_bytes())
        self._put(f"{self._place(item)}/{MANIFEST}", canonical(manifest))
        shutil.rmtree(staged, ignore_errors=True)

    def _put(self, path: str, data: bytes) -> None:
        self._system.makedirs(path.rsplit("/", 1)[0], exist_ok=True)
        self._system.pipe_file(path, data)

    def _found(self, *parts: str) -> list[str]:
        """Names of all objects below a place, relative to the store."""
        self._system.invalidate_cache()
        with contextlib.suppress(FileNotFoundError):
            skipped = len(self._root) + 1
            return sorted(str(path)[skipped:] for path in self._system.find(self._path(*parts)))
        return []

    def items(self) -> set[str]:
        """Ids of items with a manifest: one that was killed before has none, and is made again."""
        found = set[str]()
        for name in self._found("items"):
            parts = name.split("/")
            if len(parts) == 4 and is_id(parts[2]) and parts[3] == MANIFEST:
                found.add(parts[2])
        return found

    def strays(self) -> list[str]:
        """Not in the items: the files of unfinished ones are there as well."""
        with contextlib.suppress(FileNotFoundError):
            names = [os.path.basename(p.rstrip("/")) for p in self._system.ls(self._root, False)]
            return sorted(name for name in names if name and name not in KNOWN)
        return []

    def manifest(self, item: str) -> Manifest:
        try:
            data = self._system.cat_file(f"{self._place(item)}/{MANIFEST}")
        except (FileNotFoundError, NotADirectoryError):
            raise Damaged(f"{MANIFEST}: expected a file, found none") from None
        return parse_manifest(item, data)

    def check_files(self, item: str, manifest: Manifest, *, is_full: bool) -> list[str]:
        for name, known in manifest["files"].items() if is_full else ():
            try:
                with self._system.open(f"{self._place(item)}/{name}", "rb") as stream:
                    found = digest_of_stream(stream)
            except (FileNotFoundError, IsADirectoryError, NotADirectoryError):
                raise Damaged(f"{name}: expected a file, found none") from None
            if found != known["hash"]:
                raise Damaged(f"{name}: its bytes differ from the manifest's hash")
        return []

    def set_aside(self, item: str) -> str:
        name = f"damaged/{own_name(item)}"
        self.move(self._place(item), self._path(name))
        return f"{self.spec}/{name}"

    def move(self, source: str, target: str) -> None:
        """Moves all objects below a place, if there are any."""
        try:
            self._system.invalidate_cache()
            old, new = (str(self._system._strip_protocol(path)) for path in (source, target))
            found = self._system.find(old)
            for path in found:
                copy = new + path[len(old) :]
                self._system.makedirs(copy.rsplit("/", 1)[0], exist_ok=True)
                self._system.cp_file(path, copy)
            for path in sorted(found, key=lambda p: not p.endswith(f"/{MANIFEST}")):
                self._system.rm_file(path)  # without its manifest an item is none
        except Exception as error:
            raise unwritable(self.spec, error) from None

    def log(self, lines: list[str]) -> None:
        self._log_lines += lines
        text = "".join(line + "\n" for line in self._log_lines)
        self._put(self._path("log", self._log_name), text.encode())

    def logs(self) -> Iterator[tuple[str, Record | None]]:
        for name in self._found("log"):
            if name.endswith(".jsonl"):
                for record in records_in(io.BytesIO(self._system.cat_file(self._path(name)))):
                    yield name, record

    def path(self, name: str) -> str:
        return f"{self.spec}/{name}"

    def write(self, files: Mapping[str, bytes]) -> None:
        try:
            for name, data in files.items():
                self._put(self._path(name), data)
        except Exception as error:
            raise unwritable(self.spec, error) from None
