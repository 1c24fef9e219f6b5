# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A plan: parameters, and one item for each of their combinations.

An item's id is a hash of all that its result depends on: the study's seed, its parameters, [run],
[keep], the contents of its files, the source file of its function and Pliant's version. Its seed is
a hash of its id. So neither depends on the other items, and a change gives new ids to exactly those
items that it concerns.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import importlib.util
import inspect
import os
import pathlib
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pliant._core import version
from pliant._error import Error
from pliant.study._inputs import hash_of, input_of, inputs_of, is_url
from pliant.study._item import Item, key_of, names_in
from pliant.study._keys import canonical, digest, number_of, one_line, plain, read_file
from pliant.study._kinds import KINDS, Kind
from pliant.study._parameters import combinations, expected, known, whole
from pliant.study._work import refuse_in_items

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

if TYPE_CHECKING:
    from typing import Self

Function = Callable[..., Any]
_LARGEST_FILE = 16 << 20


def _tables_of(path: str | os.PathLike[str], about: str) -> dict[str, Any]:
    """The tables of a TOML file. about: begins the message of an error."""
    try:
        return tomllib.loads(read_file(path, _LARGEST_FILE).decode())
    except OSError as error:
        raise Error(f"{about}: {error.strerror}", "not_found") from None
    except RecursionError:
        raise Error(f"{about}: expected TOML, found too many levels", "unreadable") from None
    except ValueError as error:  # of TOML, of UTF-8, of a number's length
        raise Error(f"{about}: expected TOML, {one_line(error)}", "unreadable") from None


@contextlib.contextmanager
def study_file(path: str | os.PathLike[str], names: tuple[str, ...]) -> Iterator[dict[str, Any]]:
    """The arguments of a study in a TOML file.

    Args:
        names: The tables that it may have beside study.

    Raises:
        pliant.Error: One line that names the file and the field, also for errors in the block.
    """
    tables = _tables_of(path, os.fspath(path))
    try:
        if "search" in tables and "search" not in names:
            raise Error("search: a study with this table is for `pliant study search`", "wrong")
        known("", tables, ("study", *names))
        for name, table in tables.items():
            if not isinstance(table, dict) and name != "parameters":
                raise expected(name, "a table", table)
        head = tables.pop("study", {})
        known("study", head, ("name", "seed"))
        if "run" not in tables:
            raise expected("run", "a table with what", "none")
        yield {
            "name": head.get("name", pathlib.Path(path).stem),
            "seed": head.get("seed", 0),
            "folder": pathlib.Path(path).parent,
            **tables,
        }
    except RecursionError:
        raise Error(f"{path}: expected tables, found too many levels", "unreadable") from None
    except Error as error:
        raise Error(
            f"{path}: {error}", error.code, error.field, error.expected, error.found
        ) from None


class Plan:
    """The items of a study, without their results. Study describes arguments and attributes."""

    def __init__(
        self,
        name: str,
        run: Function | str | Mapping[str, Any],
        *,
        parameters: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
        sample: Mapping[str, Any] | None = None,
        keep: Mapping[str, Any] | None = None,
        seed: int = 0,
        folder: str | os.PathLike[str] = ".",
    ) -> None:
        if not isinstance(name, str) or not re.fullmatch(r"[\w.-]+", name):
            raise expected("study.name", "letters, digits, -, _ and .", name)
        self.name, self.seed = name, whole("study.seed", seed, 0)
        self.folder = os.path.abspath(folder)
        self.keep = self._checked_keep(keep or {})
        self.run_table = self._checked_run(run)
        self.timeout_s = self._checked_timeout()
        tables: Any = [parameters or {}] if isinstance(parameters or {}, Mapping) else parameters
        if not isinstance(tables, (list, tuple)) or not all(isinstance(t, Mapping) for t in tables):
            raise expected("parameters", "a table, or a list of tables", parameters)
        self.parameters = [dict(table) for table in tables]
        self._sample = dict(sample or {})
        self.run_table["repeats"] = [
            name
            for name, spec in self.parameters[0].items()
            if isinstance(spec, Mapping) and "count" in spec and self.run_table["what"] != "python"
        ]
        self._check_names()

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Self:
        """Reads a TOML file with the tables study, parameters, sample, run and keep.

        Raises:
            pliant.Error: One line that names the file and the field.
        """
        with study_file(path, ("parameters", "sample", "run", "keep")) as arguments:
            plan = cls(**arguments)
            plan.items  # noqa: B018  finds files and checks ranges
        return plan

    @property
    def kind(self) -> Kind:
        """The kind of work."""
        return KINDS[self.run_table["what"]]

    def _checked_keep(self, keep: Mapping[str, Any]) -> dict[str, list[str] | None]:
        known("keep", keep, ("files", "results"))
        for name, patterns in keep.items():
            if not isinstance(patterns, list) or not all(isinstance(p, str) for p in patterns):
                raise expected(f"keep.{name}", "a list of patterns", patterns)
        return {name: keep.get(name) for name in ("files", "results")}

    def _checked_run(self, given: Function | str | Mapping[str, Any]) -> dict[str, Any]:
        if isinstance(given, str):
            given = {"what": "python", "function": given}
        if not isinstance(given, Mapping):
            given = {"what": "python", "function": _name_of(given)}
        run: dict[str, Any] = plain(given, "run")
        if run.get("what") not in KINDS:
            raise expected("run.what", f"one of {', '.join(KINDS)}", run.get("what", "none"))
        kind = KINDS[run["what"]]
        for name, form in kind.files.items():
            if name in run and not (isinstance(run[name], str) and names_in(run[name])):
                run[name] = self._file(f"run.{name}", form, run[name])
        if run["what"] == "python":
            run["function"], run["source"], run["source_hash"] = self._source(
                "run.function", run.get("function")
            )
        policy = run.get("policy", "guide")
        if run["what"] == "endoscope" and policy not in ("guide", "random"):
            raise expected("run.policy", "guide or random (or what = \"python\")", policy)
        return run

    def _checked_timeout(self) -> float:
        limit = self.run_table.pop("timeout_s", 0)
        if isinstance(limit, bool) or not isinstance(limit, (int, float)) or limit < 0:
            raise expected("run.timeout_s", "seconds, or 0 for no limit", limit)
        return float(limit)

    def _source(self, field: str, spec: Any) -> tuple[str, Any, str]:
        """The name of a function, its file or module, and the hash of its source."""
        place, colon, name = spec.rpartition(":") if isinstance(spec, str) else ("", "", "")
        if not colon or not name:
            raise expected(field, "module:function or path.py:function", spec)
        if place.endswith(".py"):
            return name, input_of(self.folder, place, is_scan=False), ""
        try:
            found = importlib.util.find_spec(place)
        except (ImportError, ValueError):
            found = None
        if found is None or not found.origin:
            raise expected(field, "a module on Python's path, or path.py:function", place)
        return name, place, hash_of(found.origin) if os.path.isfile(found.origin) else ""

    def _file(self, field: str, form: str, value: Any) -> Any:
        if form == "toml" and isinstance(value, Mapping):
            return dict(value)
        if not isinstance(value, str):
            raise expected(field, "the name of a file", value)
        if form == "scan" and value == "airway" and not os.path.exists(self._path(value)):
            return value
        if form != "toml":
            return input_of(self.folder, value, is_scan=form == "scan")
        path = self._path(value)
        return _with_files(_tables_of(path, f"{field}: {value}"), os.path.dirname(path))

    def _path(self, name: str) -> str:
        return os.path.join(self.folder, os.path.expanduser(name))

    def _check_names(self) -> None:
        needed = self.kind.needed
        strange = names_in({k: v for k, v in self.run_table.items() if k != "source"})
        for table in self.parameters:
            if set(table) != set(self.parameters[0]):
                names = ", ".join(self.parameters[0])
                raise expected("parameters", f"the same names in each table ({names})", [*table])
            if needed is not None and needed not in {*self.run_table, *table}:
                raise expected(f"run.{needed}", "it here or as a parameter", "none")
            if strange - set(table):
                name = sorted(strange - set(table))[0]
                raise expected("run", "names of parameters in braces", f"{{{name}}}")

    def _files_of(self, field: str, form: str, given: Any) -> list[Any]:
        patterns = given if isinstance(given, list) else [given]
        if not all(isinstance(p, str) for p in patterns):
            raise expected(f"{field}.{form}", "patterns of names", given)
        found: list[Any] = []
        for pattern in patterns:
            found += inputs_of(self.folder, f"{field}.{form}", pattern, is_scan=form == "scans")
        return found

    def with_inputs(self, parameters: dict[str, Any]) -> dict[str, Any]:
        """Turns names of files into inputs, where the kind has such an argument."""
        for name, value in parameters.items():
            form = self.kind.files.get(name)
            if form is not None and isinstance(value, str):
                form = "file" if form == "toml" else form
                parameters[name] = self._known_file(f"parameters.{name}", form, value)
        return parameters

    @functools.cached_property
    def _known_file(self) -> Callable[[str, str, str], Any]:
        return functools.cache(self._file)

    @functools.cached_property
    def items(self) -> list[Item]:
        """All items; those with the same parameters and contents are one."""
        base = {
            "seed": self.seed,
            "run": key_of(self.run_table),
            "keep": self.keep["files"],
            "version": version,
        }
        prefix = digest(canonical(base)).encode()
        found: dict[str, Item] = {}
        self.duplicates = 0
        for values in combinations(self.parameters, self._sample, self.seed, self._files_of):
            parameters = self.with_inputs(values)
            item_id = digest(prefix + canonical(key_of(parameters)))
            if item_id in found:
                self.duplicates += 1
                continue
            found[item_id] = Item(item_id, number_of(item_id, "seed"), parameters)
        return list(found.values())


def _with_files(value: Any, folder: str) -> Any:
    """A configuration with the files that it names as inputs."""
    if isinstance(value, Mapping):
        return {name: _with_files(v, folder) for name, v in value.items()}
    if isinstance(value, list):
        return [_with_files(v, folder) for v in value]
    if isinstance(value, str) and value and not is_url(value):
        path = os.path.join(folder, value)
        if os.path.isfile(path):
            return dataclasses.replace(input_of(folder, value, is_scan=False), path=path)
    return value


def _name_of(function: Function) -> str:
    """A function as module:name, or path.py:name where the module is the program itself."""
    refuse_in_items()
    name, module = getattr(function, "__qualname__", ""), getattr(function, "__module__", "")
    if not name or "<" in name:
        raise expected("run", "a function of a module, or its name", name or function)
    if module != "__main__":
        return f"{module}:{name}"
    path = inspect.getsourcefile(function) if hasattr(sys.modules["__main__"], "__file__") else None
    if path is None:
        raise expected("run", "a function in a file (in notebooks: %%writefile)", name)
    return f"{os.path.abspath(path)}:{name}"
