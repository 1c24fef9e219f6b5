# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A study: a plan and its operations."""

from __future__ import annotations

import concurrent.futures
import os
from typing import Any

from pliant.study._engines import open_engine
from pliant.study._merge import merge_study, rows_of, warn_of
from pliant.study._plan import Plan
from pliant.study._report import report_study
from pliant.study._run import RunReport, run_on
from pliant.study._verify import Status, status_of, verify_study
from pliant.study._work import refuse_in_items


class Study(Plan):
    """A study.

    Attributes:
        name, seed, folder, parameters, keep: As they were given.
        run_table: What is run, with its files as Input.
        timeout_s: Of an item; 0: no limit. No part of ids.

    Args:
        name: Of the folder of results, and in the report.
        run: A function, or "module:function" or "path.py:function"; or a table with "what" (deform,
            augment, truth, fit, vessel, endoscope, python) and its arguments.
        parameters: For each name a list, {"files": GLOB}, {"scans": GLOB}, {"count": N}, {"low",
            "high", "steps"}, or {"low", "high"}, which is drawn. All combinations are taken. Or a
            list of such tables, one after the other.
        sample: {"method": "random" or "latin-hypercube", "count": N}, if there are drawn ones.
        keep: {"files": patterns of files that are kept, "results": patterns of columns in tables}.
        seed: Another one gives other samples, ids and seeds.
        folder: That relative names of files begin in.

    Raises:
        pliant.Error: A field is wrong, or a file is missing.
    """

    def run(
        self,
        out: str | os.PathLike[str] | None = None,
        engine: str | concurrent.futures.Executor = "local",
        *,
        workers: int = 0,
        threads: int = 1,
        retry_failed: bool = False,
        progress: bool = False,
    ) -> RunReport:
        """Runs all items that have no result yet; each is attempted.

        Items whose results are damaged are set aside, and repeated.

        Args:
            out: Folder, name ending in .zarr, or URL of fsspec; None: NAME-results.
            engine: "local", "dask://HOST:PORT", "mpi", or an Executor of one's own.
            workers: Processes of the local engine; 0: one for each core.
            threads: That an item may use.
            retry_failed: Also runs items that failed before.
            progress: Shows a line of progress.

        Raises:
            pliant.Error: The results or the engine can't be reached.
        """
        refuse_in_items()
        with open_engine(engine, workers, threads) as opened:
            if opened is None:
                return RunReport(0, 0, {}, 0, 0, 0, 0.0)
            return run_on(self, self._out(out), opened, threads, retry_failed, progress)

    def _out(self, out: str | os.PathLike[str] | None) -> str:
        return f"{self.name}-results" if out is None else os.fspath(out)

    def status(self, out: str | os.PathLike[str] | None = None) -> Status:
        """Which items are done, failed, left or damaged."""
        return status_of(self, self._out(out))

    def verify(self, out: str | os.PathLike[str] | None = None) -> Status:
        """The status after all bytes of all results were compared with their hashes.

        Damaged items are lines of the log afterwards; the next run repeats them.
        """
        return verify_study(self, self._out(out))

    def merge(self, out: str | os.PathLike[str] | None = None) -> str:
        """Writes merged/table.csv and merged/manifest.json; returns the hash of both.

        Items are sorted by id, and there are no times or hosts: equal results are equal bytes. All
        results are read as by verify(); damaged ones are left out, with a warning.
        """
        merged = merge_study(self, self._out(out))
        warn_of(merged.damaged)
        return merged.hash

    def table(self, out: str | os.PathLike[str] | None = None) -> list[dict[str, Any]]:
        """A row for each item that is done: id, seed, parameters, results, hash.

        Damaged items are left out, with a warning.
        """
        return rows_of(self, self._out(out))

    def report(self, out: str | os.PathLike[str] | None = None) -> str:
        """Writes report.html, which needs no other file; returns its path."""
        return report_study(self, self._out(out))
