# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Search for the parameters with the smallest result, by a population of candidates.

Differential evolution [Storn1997], best/1/bin: a trial replaces a candidate if it is not worse,

    trial = best + F (a - b) in some parameters, its own in the others,   F in 0.5...1

a and b being two other candidates. All trials of a generation are items of one study, so they run
on any engine, and a search that was killed continues where it ended. The random numbers depend on
the study alone, and a generation begins when the one before has ended, so the result is the same
for any number of workers.
"""

from __future__ import annotations

import concurrent.futures
import dataclasses
import math
import os
from collections.abc import Mapping
from typing import Any

from pliant._error import Error
from pliant.study._engines import open_engine
from pliant.study._item import key_of
from pliant.study._keys import canonical, number_of, uniform
from pliant.study._parameters import MOST_ITEMS, Span, expected, known, shares, whole
from pliant.study._plan import Function, study_file
from pliant.study._run import BY_USER, run_on
from pliant.study._stores import open_store
from pliant.study._study import Study

_MOST_POPULATION = 10_000  # a generation draws this number of numbers for each candidate
_CROSSOVER = 0.7  # share of the parameters that a trial takes from the mutant


@dataclasses.dataclass(frozen=True)
class SearchResult:
    """The best candidate of a search.

    Attributes:
        parameters: Its parameters.
        value: Its result.
        id: Its item.
        generations: Generations after the first.
        evaluations: Items of all generations; those with equal parameters are one.
        failed: Items without a result.
        is_converged: The candidates' results agree to the tolerance.
    """

    parameters: dict[str, Any]
    value: float
    id: str
    generations: int
    evaluations: int
    failed: int
    is_converged: bool


@dataclasses.dataclass
class _Candidate:
    shares: list[float]  # of each parameter's range
    value: float = math.inf
    id: str = ""


class Search:
    """A search over parameters with ranges.

    Args:
        name, run, keep, seed, folder: As for a Study.
        parameters: {"low", "high"} with "scale" and "whole", for each name; or one value.
        search: {"minimise": column of the table of results, "population" (10 for each parameter),
            "generations" (100), "tolerance" (1e-6): spread of the results relative to the best}.

    Raises:
        pliant.Error: A field is wrong.
    """

    def __init__(
        self,
        name: str,
        run: Function | str | Mapping[str, Any],
        *,
        parameters: Mapping[str, Any],
        search: Mapping[str, Any],
        keep: Mapping[str, Any] | None = None,
        seed: int = 0,
        folder: str | os.PathLike[str] = ".",
    ) -> None:
        known("search", search, ("minimise", "population", "generations", "tolerance"))
        if not isinstance(search.get("minimise"), str):
            raise expected("search.minimise", "a column of results", search.get("minimise", "none"))
        self.minimise: str = search["minimise"]
        self._spans, self._fixed = dict[str, Span](), dict[str, Any]()
        for key, spec in parameters.items():
            if isinstance(spec, Mapping):
                self._spans[key] = Span(f"parameters.{key}", spec)
            elif isinstance(spec, (list, tuple)):
                raise expected(f"parameters.{key}", "a range {low, high} or one value", spec)
            else:
                self._fixed[key] = spec
        if not self._spans:
            raise expected("parameters", "a range {low, high}", "none")
        population = search.get("population", 10 * len(self._spans))
        self.population = whole("search.population", population, 4, _MOST_POPULATION)
        self.generations = whole(
            "search.generations",
            search.get("generations", 100),
            0,
            MOST_ITEMS // self.population - 1,
        )
        tolerance = search.get("tolerance", 1e-6)
        if isinstance(tolerance, bool) or not isinstance(tolerance, (int, float)) or tolerance < 0:
            raise expected("search.tolerance", "a number, 0 or more", tolerance)
        self.tolerance = float(tolerance)
        self.name, self.seed = name, seed
        self._arguments: dict[str, Any] = {"run": run, "keep": keep, "seed": seed, "folder": folder}
        self._rows: list[dict[str, Any]] = []
        self._study([self._row(_Candidate([0.5] * len(self._spans)))])  # checks the fields

    @staticmethod
    def load(path: str | os.PathLike[str]) -> Search:
        """Reads a TOML file with the tables study, parameters, search, run and keep.

        Raises:
            pliant.Error: One line that names the file and the field.
        """
        with study_file(path, ("parameters", "search", "run", "keep")) as arguments:
            for name in ("parameters", "search"):
                if not isinstance(arguments.get(name), dict):
                    raise expected(name, "a table", arguments.get(name, "none"))
            return Search(**arguments)

    def run(
        self,
        out: str | os.PathLike[str] | None = None,
        engine: str | concurrent.futures.Executor = "local",
        *,
        workers: int = 0,
        threads: int = 1,
        progress: bool = False,
    ) -> SearchResult | None:
        """Runs the search, or the rest of it. See Study.run().

        The table and the report of all items are in the folder of results afterwards.

        Returns:
            The best candidate; None in MPI's ranks that have worked for the first one.

        Raises:
            pliant.Error: No candidate has the result; the results or the engine can't be reached.
        """
        place = f"{self.name}-results" if out is None else os.fspath(out)
        with open_engine(engine, workers, threads) as opened:
            if opened is None:
                return None

            def evaluate(candidates: list[_Candidate]) -> None:
                study = self._study([self._row(c) for c in candidates])
                report = run_on(study, place, opened, threads, False, progress)
                if report.stopped == BY_USER:
                    raise KeyboardInterrupt
                if report.stopped:
                    raise Error(f"search: stopped {report.stopped}", "failed", "search")
                self._take(study, place, candidates)

            result = self._evolve(evaluate)
        everything = self._study(self._rows)
        everything.merge(place)
        everything.report(place)
        best = {"parameters": result.parameters, self.minimise: result.value, "id": result.id}
        open_store(place).write({"best.json": canonical(best) + b"\n"})
        return result

    def _evolve(self, evaluate: Any) -> SearchResult:
        columns = [
            shares(self.seed, name, "latin-hypercube", self.population) for name in self._spans
        ]
        living = [_Candidate([c[n] for c in columns]) for n in range(self.population)]
        evaluate(living)
        generation = 0
        while not (done := self._is_converged(living)) and generation < self.generations:
            generation += 1
            best = min(range(self.population), key=lambda n: living[n].value)
            trials = [self._trial(living, best, generation, n) for n in range(self.population)]
            evaluate(trials)
            for n, trial in enumerate(trials):
                if trial.value <= living[n].value:
                    living[n] = trial
        best_one = min(living, key=lambda c: c.value)
        if math.isinf(best_one.value):
            raise Error(
                f"search.minimise: expected a column of numbers, found none named {self.minimise}; "
                "`pliant study report` has the items and their errors",
                field="search.minimise",
            )
        rows = {canonical(key_of(row)) for row in self._rows}
        return SearchResult(
            self._row(best_one), best_one.value, best_one.id, generation, len(rows),
            sum(math.isinf(c.value) for c in living), done,
        )  # fmt: skip

    def _is_converged(self, living: list[_Candidate]) -> bool:
        values = [c.value for c in living]
        best = min(values)
        return max(values) - best <= self.tolerance * max(abs(best), 1e-300)

    def _trial(self, living: list[_Candidate], best: int, generation: int, n: int) -> _Candidate:
        drawn = (self.seed, self.name, "search", generation, n)
        others = sorted(
            (k for k in range(self.population) if k not in (n, best)),
            key=lambda k: number_of(*drawn, "other", k),
        )
        a, b = living[others[0]].shares, living[others[1]].shares
        factor = 0.5 + 0.5 * uniform(*drawn, "factor")
        forced = number_of(*drawn, "forced") % len(self._spans)
        mixed = []
        for k, own in enumerate(living[n].shares):
            if k == forced or uniform(*drawn, "cross", k) < _CROSSOVER:
                own = living[best].shares[k] + factor * (a[k] - b[k])
                own = abs(own)  # reflected at the ends of the range
                own = 2 - own if own > 1 else own
            mixed.append(min(max(own, 0.0), 1.0))
        return _Candidate(mixed)

    def _row(self, candidate: _Candidate) -> dict[str, Any]:
        drawn = {
            name: span.at(share)
            for (name, span), share in zip(self._spans.items(), candidate.shares, strict=True)
        }
        return {**self._fixed, **drawn}

    def _study(self, rows: list[dict[str, Any]]) -> Study:
        return Study(self.name, parameters=rows, **self._arguments)

    def _take(self, study: Study, place: str, candidates: list[_Candidate]) -> None:
        """Gives candidates their results."""
        rows = {row["id"]: row for row in study.table(place)}
        ids = {canonical(key_of(item.parameters)): item.id for item in study.items}
        for candidate in candidates:
            parameters = self._row(candidate)
            self._rows.append(parameters)
            found = rows.get(ids[canonical(key_of(study.with_inputs(dict(parameters))))], {})
            value: Any = found.get(self.minimise)
            is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
            if is_number and math.isfinite(value):
                candidate.value, candidate.id = float(value), found["id"]
