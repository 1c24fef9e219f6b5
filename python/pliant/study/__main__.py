# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The command `pliant study`."""

from __future__ import annotations

import argparse
import contextlib
import os
import sys
from collections.abc import Mapping, Sequence
from typing import NoReturn

from pliant._command import interrupts_are_exceptions
from pliant._error import Error
from pliant.study._engines import open_engine
from pliant.study._item import shown
from pliant.study._keys import one_line
from pliant.study._merge import merge_study
from pliant.study._run import BY_USER, run_on, strays_line
from pliant.study._search import Search
from pliant.study._stores import open_store
from pliant.study._study import Study
from pliant.study._verify import Status
from pliant.study._work import line_of

_SHOWN = 10
_EXAMPLES = """
a study, press.toml:
  [parameters]
  young_pa = [5000, 10000]
  depth_mm = { low = 1, high = 4, steps = 7 }
  copy = { count = 10 }
  [run]
  what = "python"
  function = "press.py:press"

examples:
  pliant study plan press.toml
  pliant study run press.toml --workers 8
  pliant study run press.toml --engine dask://HOST:8786 --out s3://bucket/press
  pliant study status press.toml
  pliant study verify press.toml
  pliant study merge press.toml

exit status: 0 all items are done, 1 some are not, 2 an error, in one line
"""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise Error(f"{message} (see {self.prog} --help)")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="pliant study",
        description="Run thousands of independent items, on one machine or many "
        "(docs/howto/study.md)",
        epilog=_EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    texts = {
        "plan": "list the items, and which of them are done",
        "run": "run the items that have no result yet",
        "search": "find the parameters with the smallest result (the table search)",
        "status": "count the items that are done, failed and left",
        "verify": "compare all bytes of all results with their hashes",
        "merge": "write one table and one manifest of all results",
        "report": "write a page with plots, failures and machines",
    }
    for name, text in texts.items():
        command = commands.add_parser(name, help=text, description=text)
        command.add_argument("study", metavar="STUDY.toml", help="the study")
        command.add_argument(
            "--out",
            help="results: a folder, a name that ends in .zarr, or a URL such as s3://bucket/name "
            "(default: NAME-results)",
        )
        if name == "plan":
            command.add_argument("--all", action="store_true", help="list all items")
        if name in ("run", "search"):
            command.add_argument(
                "--engine",
                default="local",
                metavar="ENGINE",
                help="local (processes of this machine), dask://HOST:PORT, or mpi, under mpirun "
                "(default: local)",
            )
            command.add_argument(
                "--workers", type=int, default=0, help="local processes (default: one a core)"
            )
            command.add_argument(
                "--threads", type=int, default=1, help="that an item may use (default: 1)"
            )
        if name == "run":
            command.add_argument(
                "--retry-failed", action="store_true", help="also run items that failed before"
            )
    return parser


def _say(line: object = "", *, is_end: bool = False) -> None:
    """Prints a line; the last call writes them out.

    Raises:
        pliant.Error: Standard output fails. Nothing more is written to it.
    """
    try:
        if not is_end:
            print(line)
        elif sys.stdout is not None:  # closed
            sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise Error(f"standard output: {error.strerror}", "unwritable") from None


def _list(lines: Mapping[str, str]) -> None:
    """The first lines of some items, on standard error."""
    for item, line in list(lines.items())[:_SHOWN]:
        print(f"{item}  {one_line(line)}", file=sys.stderr)
    if len(lines) > _SHOWN:
        print(f"... and {len(lines) - _SHOWN} more", file=sys.stderr)


def _note(status: Status) -> None:
    if status.strays:
        print(f"pliant study: {strays_line(status)}", file=sys.stderr)


def _damaged(status: Status) -> str:
    return f", {len(status.damaged)} damaged (run repeats them)" if status.damaged else ""


def _plan(study: Study, out: str, is_all: bool) -> int:
    status = study.status(out)
    _note(status)
    done = {item.id for item in status.done}
    _say(f"{study.name}: {len(study.items)} items")
    if study.duplicates:
        _say(f"{study.duplicates} more have the same parameters and contents as another")
    _say(
        f"{out}: {len(done)} done, {len(status.failed)} failed, {len(status.left)} to run, "
        f"{status.others} results of other items{_damaged(status)}"
    )
    known = [item for item in study.items if item.id in done][:: max(1, len(done) // 100)]
    if known and status.left:
        store = open_store(out)
        made = [store.manifest(item.id) for item in known]
        size = sum(f["bytes"] for m in made for f in m["files"].values()) / len(made)
        seconds = sum(m["made"]["seconds"] for m in made) / len(made)
        rest = len(status.left)
        _say(f"left: about {rest * size / 1e6:.1f} MB, {rest * seconds:.0f} s of one process")
    for item in study.items if is_all else study.items[:_SHOWN]:
        state = "done" if item.id in done else "failed" if item.id in status.failed else "to run"
        state = "damaged" if item.id in status.damaged else state
        values = ", ".join(f"{name} = {shown(v)}" for name, v in item.parameters.items())
        _say(f"{item.id}  {state:6}  {one_line(values)}")
    if not is_all and len(study.items) > _SHOWN:
        _say(f"... and {len(study.items) - _SHOWN} more (--all)")
    return 0


def _status(study: Study, out: str) -> int:
    status = study.status(out)
    _note(status)
    _say(
        f"{len(status.done)} done, {len(status.failed)} failed, {len(status.left)} left"
        f"{_damaged(status)}"
    )
    for item, record in list(status.failed.items())[:_SHOWN]:
        _say(f"{item}  {one_line(record.get('error', ''))}")
    if len(status.failed) > _SHOWN:
        _say(f"... and {len(status.failed) - _SHOWN} more")
    for item, damage in list(status.damaged.items())[:_SHOWN]:
        _say(f"{item}  {one_line(damage)}")
    return 1 if status.failed or status.left or status.damaged else 0


def _verify(study: Study, out: str) -> int:
    status = study.verify(out)
    _note(status)
    for item, damage in status.damaged.items():
        _say(f"{item}  {one_line(damage)}")
    rest = len(status.left) + len(status.failed)
    _say(f"{len(status.done)} whole, {rest} without a result{_damaged(status)}")
    return 1 if status.damaged else 0


def _merge(study: Study, out: str) -> int:
    merged = merge_study(study, out)
    _list(merged.damaged)
    _say(f"{merged.path}: {merged.count} of {len(study.items)} items, hash {merged.hash}")
    return 0 if merged.count == len(study.items) else 1


def _run(options: argparse.Namespace) -> int:
    with open_engine(options.engine, options.workers, options.threads) as engine:
        if engine is None:
            return 0
        study = Study.load(options.study)
        out = options.out or f"{study.name}-results"
        report = run_on(study, out, engine, options.threads, options.retry_failed, True)
    _list(report.failed)
    _say(str(report).partition("\n")[0])
    if report.stopped == BY_USER:
        raise KeyboardInterrupt
    if report.stopped:
        raise Error(report.stopped, "unwritable")
    return 0 if report.is_complete else 1


def _search(options: argparse.Namespace) -> int:
    search = Search.load(options.study)
    out = options.out or f"{search.name}-results"
    found = search.run(
        out, options.engine, workers=options.workers, threads=options.threads, progress=True
    )
    if found is None:
        return 0
    store = open_store(out)
    values = ", ".join(f"{name} = {value}" for name, value in found.parameters.items())
    _say(f"{search.minimise} = {found.value:g} at {values}")
    _say(
        f"{found.generations} generations, {found.evaluations} items, "
        f"{'' if found.is_converged else 'not '}converged; {store.path('best.json')}, "
        f"{store.path('report.html')}"
    )
    return 0 if found.is_converged else 1


def _command(arguments: Sequence[str] | None) -> int:
    options = _parser().parse_args(arguments)
    if min(getattr(options, "workers", 0), getattr(options, "threads", 0)) < 0:
        raise Error("--workers and --threads: expected 0 or more")
    if options.command == "run":
        return _run(options)
    if options.command == "search":
        return _search(options)
    study = Study.load(options.study)
    out = options.out or f"{study.name}-results"
    if options.command == "plan":
        return _plan(study, out, options.all)
    if options.command == "report":
        _say(study.report(out))
        return 0
    command = {"status": _status, "verify": _verify, "merge": _merge}[options.command]
    return command(study, out)


def _fault(line: str) -> int:
    with contextlib.suppress(OSError):
        print(f"pliant study: {line}", file=sys.stderr, flush=True)
    return 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit status: 0 all items are done, 1 some are not, 2 an error, in one line."""
    interrupts_are_exceptions()
    try:
        try:
            status = _command(arguments)
        except SystemExit as ended:  # --help
            status = int(ended.code or 0)
        _say(is_end=True)
        return status
    except Error as error:
        return _fault(one_line(error))
    except KeyboardInterrupt:
        return 130
    except RecursionError:
        return _fault("expected fewer levels of lists and tables, found too many")
    except MemoryError:
        return _fault("out of memory")
    except Exception as error:
        return _fault(line_of(error))


if __name__ == "__main__":
    sys.exit(main())
