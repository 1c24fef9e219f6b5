# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The modules of the package import each other in one direction."""

import ast
import graphlib
import pathlib

import pytest

import pliant

# Modules that are imported where they are needed, each for a reason of its own.
LATE = {
    ("pliant.__main__", "pliant.study.__main__"),  # the other commands start sooner
    ("pliant.study._kinds", "pliant.gym"),  # needs gymnasium
}


def sources_of(folder):
    """The text of each module of the package, by name."""
    found = {}
    for path in folder.rglob("*.py"):
        parts = [folder.name, *path.relative_to(folder).with_suffix("").parts]
        found[".".join(parts).removesuffix(".__init__")] = path.read_text(encoding="utf-8")
    return found


def imports_of(source, modules):
    """The modules of the package that a text imports, and whether inside of a function."""
    for node, is_late in nodes_of(ast.parse(source), False):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0 and node.module
            longer = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [name if name in modules else node.module for name in longer]
        else:
            continue
        yield from ((name, is_late) for name in names if name in modules)


def nodes_of(tree, is_late):
    for node in ast.iter_child_nodes(tree):
        yield node, is_late
        inside = isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda))
        yield from nodes_of(node, is_late or inside)


def circle_in(sources):
    """A circle of imports, or nothing. Imports inside of functions and for types count, too."""
    graph = {name: {to for to, _ in imports_of(s, sources)} for name, s in sources.items()}
    try:
        graphlib.TopologicalSorter(graph).prepare()
    except graphlib.CycleError as error:
        return error.args[1]
    return []


@pytest.fixture(scope="module")
def sources():
    found = sources_of(pathlib.Path(pliant.__file__).parent)
    assert {"pliant", "pliant.gym", "pliant.study", "pliant.study._plan"} <= set(found)
    return found


def test_no_module_imports_itself_in_a_circle(sources):
    assert circle_in(sources) == []


def test_imports_inside_of_functions_have_reasons(sources):
    late = {
        (name, to)
        for name, source in sources.items()
        for to, is_late in imports_of(source, sources)
        if is_late
    }
    assert late == LATE


@pytest.mark.parametrize(
    "closing",
    [
        "from pliant.study._run import run_on",
        "def run():\n    from pliant.study import _run",
        "if TYPE_CHECKING:\n    import pliant.study._run",
    ],
)
def test_a_circle_is_found(sources, closing):
    changed = {**sources, "pliant.study._plan": f"{sources['pliant.study._plan']}\n{closing}\n"}
    assert {"pliant.study._plan", "pliant.study._run"} <= set(circle_in(changed))
