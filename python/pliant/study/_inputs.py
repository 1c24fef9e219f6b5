# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Files that items read, by their contents, and this machine's copies of them.

    path on this machine, right hash  ------------------------------>  file
    URL of fsspec, or sent by the engine  -> cache/files/HASH/NAME  ->  file
    scan whose voxels are packed          -> cache/scans/HASH.nrrd  ->  scan

A scan is given to items as a file whose voxels are mapped, so that all workers of a machine share
one copy in memory. Copies are made once for each machine: by the first process that locks the hash.
"""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import functools
import glob
import importlib
import json
import os
import pathlib
import shutil
import tempfile
import time
from collections.abc import Iterator
from typing import Any

from pliant._core import read_volume
from pliant._error import Error
from pliant.study._keys import canonical, digest, digest_of_path, digest_of_stream, open_file

_FRESH_S = 2.0  # a file may change again within the resolution of its time
_USED_S = 3600.0  # copies that were used so recently are not removed
_GB = float(os.environ.get("PLIANT_STUDY_CACHE_GB", "50"))


@dataclasses.dataclass(frozen=True)
class Input:
    """A file or folder that an item reads.

    Attributes:
        path: On the machine of the study, or a URL of fsspec.
        name: As the study names it.
        hash: Of the contents.
        is_scan: Items get a file with mapped voxels.
    """

    path: str
    name: str
    hash: str
    is_scan: bool = False

    def __str__(self) -> str:
        return self.name


class Missing(Exception):
    """This machine has no copy of an input, and can't get one by itself."""


def is_url(path: str) -> bool:
    """Whether a path belongs to fsspec."""
    return "://" in path


def filesystem(url: str) -> tuple[Any, str]:
    """The file system of a URL, and the path there."""
    try:
        fsspec: Any = importlib.import_module("fsspec")
        system, path = fsspec.core.url_to_fs(url)
    except ImportError as error:
        raise Error(
            f"{url}: expected the packages of pip install 'pliant[study]', found {error}",
            "unsupported",
        ) from None
    except ValueError as error:
        raise Error(f"{url}: {error}", "unsupported") from None
    return system, path


def cache() -> pathlib.Path:
    """This machine's folder of copies: PLIANT_STUDY_CACHE, or one below the temporary folder."""
    chosen = os.environ.get("PLIANT_STUDY_CACHE")
    own = os.path.join(tempfile.gettempdir(), f"pliant-study-{os.getuid()}")
    return _made(chosen or own)


@functools.lru_cache(maxsize=4)
def _made(path: str) -> pathlib.Path:
    folder = pathlib.Path(path)
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        if folder.stat().st_uid != os.getuid():
            raise Error(f"{folder}: expected a folder of this user, found another's", "unwritable")
        for name in ("files", "scans", "hashes", "locks", "staging"):
            (folder / name).mkdir(exist_ok=True)
    except OSError as error:
        raise Error(
            f"{folder}: can't be written ({error.strerror}); PLIANT_STUDY_CACHE names another",
            "unwritable",
        ) from None
    return folder


@contextlib.contextmanager
def _locked(name: str) -> Iterator[None]:
    with open(cache() / "locks" / name, "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _stamps(path: str) -> list[tuple[str, int, int, int]]:
    """Names, sizes and times of a file, or of all files in a folder."""
    paths = [path]
    if os.path.isdir(path):
        paths = [os.path.join(root, name) for root, _, names in os.walk(path) for name in names]
    found = [(p, os.stat(p)) for p in sorted(paths)]
    return [(p, s.st_size, s.st_mtime_ns, s.st_ino) for p, s in found]


def _remembered(name: str, stamps: Any) -> tuple[pathlib.Path, str | None]:
    record = cache() / "hashes" / digest(name.encode())
    with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
        with open_file(record) as stream:
            known = json.load(stream)
        if known["stamps"] == digest(canonical(stamps)):
            return record, str(known["hash"])
    return record, None


def _remember(record: pathlib.Path, stamps: Any, found: str) -> None:
    with contextlib.suppress(OSError):
        _write(record, canonical({"stamps": digest(canonical(stamps)), "hash": found}))


def _write(path: pathlib.Path, data: bytes) -> None:
    staged = path.with_name(f".{path.name}.{os.getpid()}")
    staged.write_bytes(data)
    os.replace(staged, path)


def hash_of(path: str) -> str:
    """The digest of a file, folder or URL; remembered while size and time stay."""
    if is_url(path):
        system, there = filesystem(path)
        try:
            stamps: Any = [str(system.ukey(there))]
            record, found = _remembered(path, stamps)
            if found is None:
                with system.open(there, "rb") as stream:
                    found = digest_of_stream(stream)
                _remember(record, stamps, found)
        except OSError as error:
            raise Error(f"{path}: {error}", "not_found") from None
        return found
    path = os.path.abspath(path)
    try:
        files = _stamps(path)
        record, found = _remembered(path, files)
        if found is None:
            found = digest_of_path(path)
            if time.time_ns() - max((f[2] for f in files), default=0) > _FRESH_S * 1e9:
                _remember(record, files, found)
    except OSError as error:
        raise Error(f"{path}: {error.strerror}", "not_found") from None
    return found


def input_of(folder: str, name: str, *, is_scan: bool) -> Input:
    """The input of a name in a study, relative to the study's folder."""
    path = name if is_url(name) else os.path.join(folder, os.path.expanduser(name))
    return Input(path, name, hash_of(path), is_scan)


def inputs_of(folder: str, field: str, pattern: str, *, is_scan: bool) -> list[Input]:
    """The inputs of a pattern with *, ? and **, sorted by name."""
    if is_url(pattern):
        system, there = filesystem(pattern)
        scheme = pattern.split("://", 1)[0]
        names = [f"{scheme}://{p}" for p in sorted(system.glob(there))]
    else:
        names = sorted(glob.glob(os.path.expanduser(pattern), root_dir=folder, recursive=True))
    if not names:
        raise Error(f"{field}: expected files, found none that match {pattern}", "not_found", field)
    return [input_of(folder, name, is_scan=is_scan) for name in names]


def _prune() -> None:
    """Removes the copies that were not used for longest, above the size of the cache."""
    copies = [p for place in ("files", "scans") for p in (cache() / place).iterdir()]
    sizes = []
    for copy in copies:
        with contextlib.suppress(OSError):
            stamps = copy.stat()
            inside = copy.iterdir() if copy.is_dir() else [copy]
            sizes.append((stamps.st_mtime, sum(p.stat().st_size for p in inside), copy))
    total = sum(size for _, size, _ in sizes)
    for used, size, copy in sorted(sizes, key=lambda s: s[0]):
        if total <= _GB * 1e9 or time.time() - used < _USED_S:
            return
        shutil.rmtree(copy, ignore_errors=True) if copy.is_dir() else copy.unlink(missing_ok=True)
        total -= size


def keep_copy(found: Input, data: bytes) -> None:
    """Puts a file that was sent into this machine's cache, unless it is there."""
    folder = cache() / "files" / found.hash
    with _locked(found.hash):
        if not folder.exists():
            _prune()
            staged = pathlib.Path(tempfile.mkdtemp(prefix=".", dir=folder.parent))
            (staged / _base(found)).write_bytes(data)
            os.replace(staged, folder)


def _base(found: Input) -> str:
    return os.path.basename(found.path.rstrip("/")) or "file"


def contents(found: Input) -> tuple[Input, bytes]:
    """An input as it is sent to another machine: a folder of a scan as one file."""
    path = _file(found)
    if not os.path.isdir(path):
        return found, pathlib.Path(path).read_bytes()
    with tempfile.TemporaryDirectory() as folder:
        copy = os.path.join(folder, "scan.nrrd")
        read_volume(path).save(copy)
        return dataclasses.replace(found, path="scan.nrrd"), pathlib.Path(copy).read_bytes()


def _file(found: Input) -> str:
    """The file itself, on this machine."""
    folder = cache() / "files" / found.hash
    if not is_url(found.path) and os.path.exists(found.path) and hash_of(found.path) == found.hash:
        return found.path
    if not _is_kept(folder, found):
        if not is_url(found.path):
            raise Missing(found.hash)
        system, there = filesystem(found.path)
        data = system.cat_file(there)
        if digest(data) != found.hash:
            raise Error(f"{found.path}: has changed since the study was planned", "unreadable")
        keep_copy(found, data)
    os.utime(folder)
    return str(next(folder.iterdir()))


def _is_kept(folder: pathlib.Path, found: Input) -> bool:
    """Whether the cache has a file; a damaged copy is removed. (Of a folder it has a scan.)"""
    copy = folder / _base(found)
    if copy.is_file() and hash_of(str(copy)) != found.hash:
        with _locked(found.hash):
            if copy.is_file() and digest_of_path(copy) != found.hash:
                shutil.rmtree(folder)
    return folder.exists()


def _is_mapped(path: str) -> bool:
    """Whether a scan's voxels are mapped from its file."""
    if not path.endswith(".nrrd"):
        return False
    with open(path, "rb") as stream:
        header = stream.read(1 << 16).split(b"\n\n", 1)[0]
    return b"\nencoding: raw" in header


def local(found: Input) -> str:
    """The path of an input on this machine; of a scan, a file whose voxels are mapped.

    Raises:
        Missing: It has to be sent.
        pliant.Error: It can't be read.
    """
    copy = cache() / "scans" / f"{found.hash}.nrrd"
    if found.is_scan and copy.exists():
        os.utime(copy)
        return str(copy)
    path = _file(found)
    if not found.is_scan or _is_mapped(path):
        return path
    with _locked(found.hash):
        if not copy.exists():
            _prune()
            staged = copy.with_name(f"{found.hash}.{os.getpid()}.nrrd")
            try:
                read_volume(path).save(staged, compress=False)
                os.replace(staged, copy)
            finally:
                staged.unlink(missing_ok=True)
    return str(copy)
