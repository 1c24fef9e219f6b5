# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Searches by populations, and studies of listed combinations."""

import json
import pathlib

import pytest

import pliant
from pliant.study import LocalPool, Search, Study
from pliant.study.__main__ import main

VALLEY = '''
def valley(x, y):
    """Rosenbrock's valley [Rosenbrock1960], with its minimum 0 at (1, 1)."""
    if x > 2.9:
        raise ValueError("outside")
    return {"cost": 100 * (y - x * x) ** 2 + (1 - x) ** 2}
'''
RANGES = {"x": {"low": -2, "high": 3}, "y": {"low": -1, "high": 3}}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    (tmp_path / "valley.py").write_text(VALLEY)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def search(**changes):
    fields = {"minimise": "cost", "population": 20, "generations": 60, "tolerance": 1e-4}
    return Search(
        "valley", "valley.py:valley", parameters=RANGES, search={**fields, **changes}, seed=3
    )


def test_a_search_finds_the_minimum_and_is_the_same_on_one_and_three_workers(folder):
    one = search().run("one", workers=1)
    assert one.value < 1e-3
    assert one.parameters["x"] == pytest.approx(1, abs=0.1)
    assert one.parameters["y"] == pytest.approx(1, abs=0.2)
    assert one.evaluations <= 20 * (one.generations + 1)
    three = search().run("three", workers=3)
    assert three == one
    for name in ("best.json", "merged/table.csv", "merged/manifest.json"):
        assert (folder / "one" / name).read_bytes() == (folder / "three" / name).read_bytes()
    assert json.loads((folder / "one/best.json").read_text())["cost"] == one.value
    table = (folder / "one/merged/table.csv").read_text().splitlines()
    assert len(table) - 1 <= one.evaluations, "without those that failed"
    assert "<svg" in (folder / "one/report.html").read_text()


def test_a_search_goes_on_where_it_ended(folder):
    short = search(generations=3).run("out", workers=2)
    assert not short.is_converged and short.generations == 3

    class Counted(LocalPool):
        calls = 0

        def submit(self, fn, *args):
            Counted.calls += len(args[1])
            return super().submit(fn, *args)

    with Counted(2) as pool:
        longer = search(generations=5).run("out", pool)
    assert Counted.calls <= 40, "two generations more"
    assert longer == search(generations=5).run("new", workers=2)


def test_whole_numbers_and_fixed_values(folder):
    (folder / "steps.py").write_text(
        "def steps(n, base):\n    return {'off': {'by': abs(n - 17) + base}}\n"
    )
    found = Search(
        "steps",
        "steps.py:steps",
        parameters={"n": {"low": 0, "high": 40, "whole": True}, "base": 2},
        search={"minimise": "off.by", "population": 8, "generations": 40},
    ).run("out", workers=2)
    assert found.parameters == {"n": 17, "base": 2}
    assert found.value == 2
    assert found.evaluations <= 41


def test_bad_searches_are_named(folder):
    for changes, message in (
        ({"minimise": 3}, "search.minimise: expected a column"),
        ({"population": 3}, "search.population"),
        ({"population": 10**5}, "search.population: expected at most 10000, found 100000"),
        ({"generations": 10**9}, "search.generations: expected at most 99999, found 1000000000"),
        ({"tolerance": -1}, "search.tolerance: expected a number"),
        ({"crossover": 1}, "search"),
    ):
        with pytest.raises(pliant.Error, match=message):
            search(**changes)
    with pytest.raises(pliant.Error, match="parameters: expected a range"):
        Search("v", "valley.py:valley", parameters={"x": 1, "y": 2}, search={"minimise": "cost"})
    with pytest.raises(pliant.Error, match="parameters.x: expected a range"):
        Search("v", "valley.py:valley", parameters={"x": [1, 2]}, search={"minimise": "cost"})
    with pytest.raises(pliant.Error, match="search.minimise: .* none named price"):
        search(minimise="price", generations=1, population=4).run("out", workers=2)


def test_the_command(folder, capsys):
    text = f"""
    [study]
    seed = 3
    [parameters]
    x = {{ low = -2, high = 3 }}
    y = {{ low = -1, high = 3 }}
    [search]
    minimise = "cost"
    population = 20
    generations = 60
    tolerance = 1e-4
    [run]
    what = "python"
    function = "valley.py:valley"
    """
    pathlib.Path("valley.toml").write_text(text)
    assert main(["search", "valley.toml", "--workers", "2"]) in (0, 1)
    out = capsys.readouterr().out
    assert "cost = " in out and "generations" in out
    best = json.loads((folder / "valley-results/best.json").read_text())
    assert best["cost"] == search().run("out", workers=2).value
    assert main(["run", "valley.toml"]) == 2
    assert "pliant study search" in capsys.readouterr().err
    pathlib.Path("empty.toml").write_text('[run]\nwhat = "python"\nfunction = "valley.py:valley"\n')
    assert main(["search", "empty.toml"]) == 2
    assert "parameters: expected a table" in capsys.readouterr().err


def test_a_study_of_listed_combinations(folder):
    rows = [{"x": 1, "y": 1}, {"x": 0, "y": [0, 2]}]
    study = Study("listed", "valley.py:valley", parameters=rows)
    assert [item.parameters for item in study.items] == [
        {"x": 1, "y": 1},
        {"x": 0, "y": 0},
        {"x": 0, "y": 2},
    ]
    one = Study("one", "valley.py:valley", parameters=rows[0])
    assert one.items[0].id == study.items[0].id, "its id depends on its own parameters"
    assert study.run("out", workers=1).is_complete
    assert sorted(row["cost"] for row in study.table("out")) == [0, 1, 401]
    with pytest.raises(pliant.Error, match="the same names in each table"):
        Study("bad", "valley.py:valley", parameters=[{"x": 1, "y": 1}, {"x": 1}])
    with pytest.raises(pliant.Error, match="a table, or a list of tables"):
        Study("bad", "valley.py:valley", parameters=[1])




SPRINGS = '''
import functools
import pliant

@functools.cache
def problem(size):
    """Springs of a box, of two kinds, and a box of finite elements."""
    box = pliant.FitBox(size=(size,) * 3, groups="kinds")
    return pliant.fit_box(box, [pliant.FitBoxLoad(force_n=(0, 0, -40))], threads=1).problem

def misfit(edges, diagonals, size=4):
    at = problem(size).evaluate([edges, diagonals])
    return {"cost": at.cost, "average_percent": at.cases[0].average_percent}
'''


def test_springs_are_fitted_to_finite_elements(folder):
    (folder / "springs.py").write_text(SPRINGS)
    stiffness = {"low": 500, "high": 50000, "scale": "log"}
    found = Search(
        "springs",
        "springs.py:misfit",
        parameters={"edges": stiffness, "diagonals": stiffness, "size": 4},
        search={"minimise": "cost", "population": 16, "generations": 60, "tolerance": 1e-4},
    ).run("out", workers=2)
    assert found.is_converged
    box = pliant.FitBox(size=(4, 4, 4), groups="kinds")
    problem = pliant.fit_box(box, [pliant.FitBoxLoad(force_n=(0, 0, -40))]).problem
    annealed = pliant.fit(problem, "annealing")
    assert found.value <= annealed.at.cost, "the method of one machine finds no better"
    best = pliant.fit(problem, "gauss_newton")
    assert found.value <= 1.001 * best.at.cost
    values = [found.parameters["edges"], found.parameters["diagonals"]]
    assert problem.evaluate(values).cost == found.value
