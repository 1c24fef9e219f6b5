# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""An item's manifest: its results, and sizes and hashes of its files.

The manifest's own hash is that of the results and of the list of files. So a manifest proves
itself and the files.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from pliant._core import version
from pliant._error import Error
from pliant.study._item import Item, shown
from pliant.study._keys import canonical, digest, digest_of_path, files_below, one_line

MANIFEST = "manifest.json"
LARGEST_MANIFEST = 256 << 20
_ID = re.compile("[0-9a-f]{32}")

Manifest = dict[str, Any]


class Damaged(Exception):
    """An item differs from the written one: one line, which begins with the file's name."""


def is_id(name: str) -> bool:
    """Whether a name is that of an item."""
    return _ID.fullmatch(name) is not None


def _hash_of(results: Any, files: Any) -> str:
    return digest(canonical({"results": results, "files": files}))


def make_manifest(
    item: Item, staged: str, results: dict[str, Any], made: dict[str, Any]
) -> Manifest:
    """The manifest of an item whose files are staged.

    Args:
        made: host, pid, started, seconds.
    """
    files = {
        name: {"bytes": path.stat().st_size, "hash": digest_of_path(path)}
        for name, path in files_below(staged)
    }
    manifest = {
        "id": item.id,
        "version": version,
        "parameters": {name: shown(value) for name, value in item.parameters.items()},
        "results": results,
        "files": files,
        "hash": _hash_of(results, files),
        "made": made,
    }
    if len(canonical(manifest)) > LARGEST_MANIFEST:
        raise Error(
            f"results: expected at most {LARGEST_MANIFEST} bytes, found more; return arrays, which "
            "become files",
            "limit_exceeded",
            "results",
        )
    return manifest


def parse_manifest(item: str, data: bytes) -> Manifest:
    """The manifest of an item, checked.

    Raises:
        Damaged: It isn't the one that was written.
    """
    try:
        found = json.loads(data)
        if not _is_manifest(found) or found["id"] != item:
            raise Damaged(f"{MANIFEST}: expected this item's manifest, found another content")
        if found["hash"] != _hash_of(found["results"], found["files"]):
            raise Damaged(f"{MANIFEST}: its results differ from its hash")
    except RecursionError:
        raise Damaged(f"{MANIFEST}: expected JSON, found too many levels") from None
    except ValueError as error:
        raise Damaged(f"{MANIFEST}: expected JSON, {one_line(error)}") from None
    return dict(found)


def _is_manifest(found: Any) -> bool:
    if not isinstance(found, Mapping):
        return False
    tables = [found.get(name) for name in ("parameters", "results", "files", "made")]
    if not all(isinstance(table, Mapping) for table in tables):
        return False
    files, made = found["files"], found["made"]
    return (
        found.get("version") == version
        and isinstance(made.get("host"), str)
        and all(type(made.get(name)) in (int, float) for name in ("started", "seconds"))
        and all(
            isinstance(known, Mapping)
            and type(known.get("bytes")) is int
            and isinstance(known.get("hash"), str)
            for known in files.values()
        )
        and not any(part in ("", ".", "..") for name in files for part in name.split("/"))
    )
