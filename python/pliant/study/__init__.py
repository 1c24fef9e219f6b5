# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Studies: thousands of independent items, on one machine or many, that nothing stops.

Example:
    >>> from pliant.study import Study
    >>> study = Study("fit", "solve.py:solve", parameters={"young_pa": [5e3, 1e4, 2e4]})
    >>> report = study.run()            # or engine="dask://HOST:8786", "mpi", or an Executor
    >>> study.merge()                   # fit-results/merged/table.csv
    >>> study.table()[0]["id"]

Ids and seeds depend on the study alone. A result exists as a whole or not at all, and a second run
does the rest. docs/howto/study.md has the TOML file, the commands and the figures.
"""

from pliant.study._inputs import Input
from pliant.study._item import Item
from pliant.study._local import LocalPool, WorkerLost
from pliant.study._run import RunReport
from pliant.study._search import Search, SearchResult
from pliant.study._study import Study
from pliant.study._verify import Status

__all__ = ["Input", "Item", "LocalPool", "RunReport", "Search", "SearchResult", "Status", "Study",
           "WorkerLost"]  # fmt: skip
