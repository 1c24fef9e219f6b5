# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The store that a name stands for."""

from __future__ import annotations

from pliant.study._inputs import is_url
from pliant.study._objects import UrlStore
from pliant.study._store import FolderStore, Store
from pliant.study._zarr import ZarrStore


def open_store(spec: str) -> Store:
    """The store of a folder's name, a name that ends in .zarr, or a URL."""
    if spec.rstrip("/").endswith(".zarr"):
        return ZarrStore(spec)
    return UrlStore(spec) if is_url(spec) else FolderStore(spec)
