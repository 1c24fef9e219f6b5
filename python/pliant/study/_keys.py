# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Hashes that name items: of plain values in one canonical text, and of files."""

from __future__ import annotations

import errno
import hashlib
import json
import math
import os
import pathlib
import stat
from collections.abc import Iterator, Mapping
from typing import Any, BinaryIO

from pliant._error import Error

_CHUNK = 1 << 20
_MOST_LEVELS = 100
_LONGEST = 400  # as the program's
_encode = json.JSONEncoder(
    sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False
).encode
Value = Any
"""None, a bool, a number, a text, or a list or dictionary of them."""


def plain(value: Any, field: str, level: int = 0) -> Value:
    """The value in types of JSON: numpy's numbers become Python's, tuples lists.

    Numbers that are not finite become texts ("nan", "inf", "-inf"), which JSON lacks.
    """
    if level > _MOST_LEVELS:
        top = field.split(".")[0]
        raise Error(
            f"{top}: expected at most {_MOST_LEVELS} levels of lists and tables, found more",
            "limit_exceeded",
            top,
        )
    if value is None or isinstance(value, (bool, str, int)):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, Mapping):
        return {str(name): plain(v, f"{field}.{name}", level + 1) for name, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(v, f"{field}.{n}", level + 1) for n, v in enumerate(value)]
    if hasattr(value, "tolist"):
        return plain(value.tolist(), field, level + 1)
    raise Error(
        f"{field}: expected numbers, texts, lists and dictionaries, found {type(value).__name__}",
        field=field,
    )


def canonical(value: Value) -> bytes:
    """One text for each value, whatever the order of its names."""
    return _encode(value).encode()


def digest(data: bytes | memoryview) -> str:
    """A hash of 128 bits, 32 hexadecimal digits."""
    return hashlib.blake2b(data, digest_size=16).hexdigest()


def number_of(*parts: Any) -> int:
    """A uniformly distributed number of 63 bits, made of the parts alone."""
    found = hashlib.blake2b(canonical(list(parts)), digest_size=8).digest()
    return int.from_bytes(found, "big") >> 1


def uniform(*parts: Any) -> float:
    """A uniformly distributed number in 0...1, 1 excluded, made of the parts alone."""
    return (number_of(*parts) >> 10) / 2.0**53


def one_line(text: object, most: int = _LONGEST) -> str:
    """A text for messages: in one line, printable, with the middle of a long one left out."""
    words = " ".join(str(text).split())
    if len(words) > most:
        words = f"{words[: most // 2]} ... {words[-most // 2 :]}"
    return "".join(c if c.isprintable() else "?" for c in words)


_KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFSOCK: "a socket",
}


def open_file(path: str | os.PathLike[str]) -> BinaryIO:
    """Opens a regular file for reading. A pipe is refused, where open() would wait for ever.

    Raises:
        OSError: It can't be opened, or is none.
    """
    return os.fdopen(_opened(path)[0], "rb")


def read_file(path: str | os.PathLike[str], most: int) -> bytes:
    """The bytes of a regular file.

    Raises:
        OSError: It can't be read, is none, or has more than `most` bytes.
    """
    descriptor, size = _opened(path)
    try:
        if size > most:
            raise OSError(errno.EINVAL, f"expected at most {most} B, found {size} B", str(path))
        found = b""
        while piece := os.read(descriptor, max(size - len(found), 0) + 1):
            found = found + piece if found else piece
        return found
    finally:
        os.close(descriptor)


def _opened(path: str | os.PathLike[str]) -> tuple[int, int]:
    """A descriptor of a regular file, and its size."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    found = os.fstat(descriptor)
    if not stat.S_ISREG(found.st_mode):
        os.close(descriptor)
        kind = _KINDS.get(stat.S_IFMT(found.st_mode), "none")
        raise OSError(errno.EINVAL, f"expected a file, found {kind}", os.fspath(path))
    return descriptor, found.st_size


def digest_of_stream(stream: Any) -> str:
    """The digest of a file that is open in binary mode."""
    found = hashlib.blake2b(digest_size=16)
    while chunk := stream.read(_CHUNK):
        found.update(chunk)
    return found.hexdigest()


def files_below(folder: str | os.PathLike[str]) -> Iterator[tuple[str, pathlib.Path]]:
    """Names, with /, and paths of all files in a folder and its folders, sorted by name."""
    root = pathlib.Path(folder)
    paths = [p for p in root.rglob("*") if p.is_file()]
    yield from sorted((p.relative_to(root).as_posix(), p) for p in paths)


def digest_of_path(path: str | os.PathLike[str]) -> str:
    """The digest of a file; of a folder, that of its files' names and digests."""
    if os.path.isdir(path):
        names = {name: digest_of_path(p) for name, p in files_below(path)}
        return digest(canonical(names))
    descriptor, size = _opened(path)
    try:
        found = hashlib.blake2b(digest_size=16)
        while chunk := os.read(descriptor, min(size + 1, _CHUNK)):
            found.update(chunk)
        return found.hexdigest()
    finally:
        os.close(descriptor)
