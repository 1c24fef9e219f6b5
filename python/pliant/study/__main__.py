# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The command `pliant study`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from typing import NoReturn

from pliant._error import Error
from pliant.study._engines import open_engine
from pliant.study._item import shown
from pliant.study._merge import manifests_of
from pliant.study._run import run_on
from pliant.study._search import Search
from pliant.study._stores import open_store
from pliant.study._study import Study

_SHOWN = 10


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise Error(f"{message} (see {self.prog} --help)")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="pliant study",
        description="Run thousands of independent items, on one machine or many "
        "(docs/howto/study.md)",
    )
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    texts = {
        "plan": "list the items, and which of them are done",
        "run": "run the items that have no result yet",
        "search": "find the parameters with the smallest result (the table search)",
        "status": "count the items that are done, failed and left",
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


def _plan(study: Study, out: str, is_all: bool) -> int:
    status = study.status(out)
    done = {item.id for item in status.done}
    print(f"{study.name}: {len(study.items)} items")
    if study.duplicates:
        print(f"{study.duplicates} more have the same parameters and contents as another")
    print(
        f"{out}: {len(done)} done, {len(status.failed)} failed, {len(status.left)} to run, "
        f"{status.others} results of other items"
    )
    known = [item for item in study.items if item.id in done][:: max(1, len(done) // 100)]
    if known and status.left:
        store = open_store(out)
        made = [store.manifest(item.id) for item in known]
        size = sum(f["bytes"] for m in made for f in m["files"].values()) / len(made)
        seconds = sum(m["made"]["seconds"] for m in made) / len(made)
        rest = len(status.left)
        print(f"left: about {rest * size / 1e6:.1f} MB, {rest * seconds:.0f} s of one process")
    for item in study.items if is_all else study.items[:_SHOWN]:
        state = "done" if item.id in done else "failed" if item.id in status.failed else "to run"
        values = ", ".join(f"{name} = {shown(v)}" for name, v in item.parameters.items())
        print(f"{item.id}  {state:6}  {values}")
    if not is_all and len(study.items) > _SHOWN:
        print(f"... and {len(study.items) - _SHOWN} more (--all)")
    return 0


def _status(study: Study, out: str) -> int:
    status = study.status(out)
    print(f"{len(status.done)} done, {len(status.failed)} failed, {len(status.left)} left")
    for item, record in list(status.failed.items())[:_SHOWN]:
        print(f"{item}  {record.get('error', '')}")
    if len(status.failed) > _SHOWN:
        print(f"... and {len(status.failed) - _SHOWN} more")
    return 0 if not status.failed and not status.left else 1


def _merge(study: Study, out: str) -> int:
    found = study.merge(out)
    count = len(manifests_of(study, open_store(out)))
    print(f"{out}/merged/table.csv: {count} of {len(study.items)} items, hash {found}")
    return 0 if count == len(study.items) else 1


def _run(options: argparse.Namespace) -> int:
    with open_engine(options.engine, options.workers, options.threads) as engine:
        if engine is None:
            return 0
        study = Study.load(options.study)
        out = options.out or f"{study.name}-results"
        report = run_on(study, out, engine, options.threads, options.retry_failed, True)
    for item, error in list(report.failed.items())[:_SHOWN]:
        print(f"{item}  {error}", file=sys.stderr)
    if len(report.failed) > _SHOWN:
        print(f"... and {len(report.failed) - _SHOWN} more", file=sys.stderr)
    print(report)
    return 0 if report.is_complete else 1


def _search(options: argparse.Namespace) -> int:
    search = Search.load(options.study)
    out = options.out or f"{search.name}-results"
    found = search.run(
        out, options.engine, workers=options.workers, threads=options.threads, progress=True
    )
    if found is None:
        return 0
    values = ", ".join(f"{name} = {value}" for name, value in found.parameters.items())
    print(f"{search.minimise} = {found.value:g} at {values}")
    print(
        f"{found.generations} generations, {found.evaluations} items, "
        f"{'' if found.is_converged else 'not '}converged; {out}/best.json, {out}/report.html"
    )
    return 0 if found.is_converged else 1


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit status: 0 all items are done, 1 some are not, 2 the study is wrong."""
    try:
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
        if options.command == "status":
            return _status(study, out)
        if options.command == "merge":
            return _merge(study, out)
        print(study.report(out))
        return 0
    except Error as error:
        print(f"pliant study: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main())
