# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Writes pliant/_settings.pyi from pliant/_core.pyi: settings that functions of Python pass on.

    settings_stub.py _core.pyi _settings.pyi

A class for each is a TypedDict of a function's keyword arguments, for `**settings: Unpack[...]`.
"""

import ast
import pathlib
import sys

# Functions with their settings, without the arguments that the passing functions set themselves.
ARENA = {"count", "size", "control_hz", "pictures", "labels", "threads"}
CLASSES = {
    "WallSettings": ("wall_around_surface", {"ends", "threads"}),
    "CatheterSettings": ("CatheterScene.__init__", {"entry", "inwards", "threads"}),
    "TruthSettings": ("TruthMaker.__init__", {"materials", "model", "threads"}),
    "EndoscopeSettings": ("EndoscopeArena.__init__", {*ARENA, "wall", "iso_hu", "polarity"}),
    "SequenceSettings": ("EndoscopeArena.__init__", ARENA),
}


def settings_of(function: ast.FunctionDef, left_out: set[str]) -> list[ast.arg]:
    """Arguments with defaults."""
    given = function.args
    found = [*given.args[len(given.args) - len(given.defaults) :], *given.kwonlyargs]
    return [one for one in found if one.arg not in left_out]


def functions_in(tree: ast.Module) -> dict[str, ast.FunctionDef]:
    """Functions by name, methods as CLASS.NAME."""
    found = {}
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            found[node.name] = node
        elif isinstance(node, ast.ClassDef):
            methods = [n for n in node.body if isinstance(n, ast.FunctionDef)]
            found.update({f"{node.name}.{method.name}": method for method in methods})
    return found


def main(core: str, out: str) -> None:
    tree = ast.parse(pathlib.Path(core).read_text(encoding="utf-8"))
    functions = functions_in(tree)
    imports = [n for n in tree.body if isinstance(n, (ast.Import, ast.ImportFrom))]
    lines = [*(ast.unparse(n) for n in imports), "from typing import TypedDict", ""]
    for name, (function, left_out) in CLASSES.items():
        lines += ["", f"class {name}(TypedDict, total=False):"]
        for one in settings_of(functions[function], left_out):
            assert one.annotation is not None
            lines.append(f"    {one.arg}: {ast.unparse(one.annotation)}")
    pathlib.Path(out).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
