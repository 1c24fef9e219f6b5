# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Items in a Zarr store: a group for each, with arrays. Needs the package zarr."""

from __future__ import annotations

import contextlib
import importlib
import io
import pathlib
import tempfile
from collections.abc import Iterator, Mapping
from typing import Any

import numpy

from pliant._core import Field, Volume, read_field, read_volume
from pliant._error import Error
from pliant.study._inputs import is_url
from pliant.study._keys import canonical, digest, files_below, one_line
from pliant.study._manifest import Damaged, Manifest
from pliant.study._objects import UrlStore
from pliant.study._store import FolderStore, Record


def _grid_of(item: Volume | Field) -> dict[str, Any]:
    return {
        "spacing_mm": list(item.spacing_mm),
        "origin_mm": list(item.origin_mm),
        "direction": numpy.ravel(item.direction).tolist(),
    }


def _array_of(name: str, path: pathlib.Path) -> tuple[Any, dict[str, Any]]:
    """A file as an array with attributes: .npy, scans and fields; others as their bytes."""
    if name.endswith(".npy"):
        return numpy.load(path, allow_pickle=False), {"pliant_file": "npy"}
    if name.endswith(".nrrd"):
        with contextlib.suppress(Error):
            scan = read_volume(path)
            return scan.array, {"pliant_file": "scan", **_grid_of(scan)}
        with contextlib.suppress(Error):
            field = read_field(path)
            attributes = {"pliant_file": "field", "kind": field.kind, **_grid_of(field)}
            return field.array, attributes
    return numpy.frombuffer(path.read_bytes(), numpy.uint8), {"pliant_file": "bytes"}


def _hash_of(array: Any, attributes: Mapping[str, Any]) -> str:
    """The hash of an array and its other attributes: chunks have none."""
    known = {k: v for k, v in attributes.items() if k != "hash"}
    values = numpy.ascontiguousarray(array, array.dtype.newbyteorder("<"))
    head = canonical([known, values.dtype.str, list(array.shape)])
    return digest(head + digest(values.reshape(-1).view(numpy.uint8).data).encode())


class ZarrStore:
    """Arrays of items in a store of Zarr's format 3.

    Manifests, logs and tables are beside it, in NAME.zarr.study. The manifest is written last.
    """

    def __init__(self, spec: str) -> None:
        try:
            self._zarr: Any = importlib.import_module("zarr")
        except ImportError as error:
            raise Error(
                f"{spec}: expected the packages of pip install 'pliant[study]', found {error}",
                "unsupported",
            ) from None
        spec = spec.rstrip("/")
        kind = UrlStore if is_url(spec) else FolderStore
        self._beside: UrlStore | FolderStore = kind(f"{spec}.study")
        self.spec = self._beside.spec.removesuffix(".study")

    def prepare(self, name: str) -> str:
        token = self._beside.prepare(name)
        self._zarr.open_group(self.spec, mode="a").require_group("items")
        return token

    def check(self, token: str) -> None:
        self._beside.check(token)

    def staging(self, item: str) -> str:
        return self._beside.staging(item)

    def commit(self, item: str, staged: str, manifest: Manifest) -> None:
        root = self._zarr.open_group(self.spec, mode="r+")
        group = root.require_group(f"items/{item[:2]}/{item}")
        for name, path in list(files_below(staged)):
            array, attributes = _array_of(name, path)
            attributes["hash"] = _hash_of(array, attributes)
            group.create_array(name, data=array, attributes=attributes, overwrite=True)
            path.unlink()
        group.attrs["pliant_item"] = {k: manifest[k] for k in ("parameters", "results", "hash")}
        self._beside.commit(item, staged, manifest)

    def items(self) -> set[str]:
        return self._beside.items()

    def strays(self) -> list[str]:
        return self._beside.strays()

    def manifest(self, item: str) -> Manifest:
        return self._beside.manifest(item)

    def check_files(self, item: str, manifest: Manifest, *, is_full: bool) -> list[str]:
        """Arrays that were written before they had hashes are only read."""
        if not is_full or not manifest["files"]:
            return []
        try:
            group = self._zarr.open_group(self.spec, path=f"items/{item[:2]}/{item}", mode="r")
        except (FileNotFoundError, KeyError, ValueError):
            raise Damaged(f"{self.spec}: expected its arrays, found none") from None
        for name in manifest["files"]:
            try:
                array = group[name]
                attributes = dict(array.attrs)
                if attributes.get("hash", "") in ("", _hash_of(array[...], attributes)):
                    continue
            except PermissionError:
                raise
            except Exception as error:  # codecs have exceptions of their own
                raise Damaged(f"{name}: can't be read ({one_line(error)})") from None
            raise Damaged(f"{name}: its values differ from their hash")
        return []

    def set_aside(self, item: str) -> str:
        aside = self._beside.set_aside(item)
        self._beside.move(f"{self.spec}/items/{item[:2]}/{item}", f"{aside}~arrays")
        return aside

    def read(self, item: str, name: str) -> bytes:
        found = self._zarr.open_group(self.spec, mode="r")[f"items/{item[:2]}/{item}/{name}"]
        array, attributes = found[...], dict(found.attrs)
        if attributes["pliant_file"] == "bytes":
            return bytes(array.tobytes())
        if attributes["pliant_file"] == "npy":
            stream = io.BytesIO()
            numpy.save(stream, array, allow_pickle=False)
            return stream.getvalue()
        grid = {key: attributes[key] for key in ("spacing_mm", "origin_mm", "direction")}
        made: Any = Volume(array, **grid)
        if attributes["pliant_file"] == "field":
            made = Field(array, **grid, kind=attributes["kind"])
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "item.nrrd"
            made.save(path)
            return path.read_bytes()

    def log(self, lines: list[str]) -> None:
        self._beside.log(lines)

    def logs(self) -> Iterator[tuple[str, Record | None]]:
        return self._beside.logs()

    def tidy(self) -> None:
        self._beside.tidy()

    def write(self, files: Mapping[str, bytes]) -> None:
        self._beside.write(files)

    def path(self, name: str) -> str:
        return self._beside.path(name)
