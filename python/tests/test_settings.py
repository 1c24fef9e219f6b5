# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Settings are typed keyword arguments: the stubs have the rows of settings_of()."""

import ast
import keyword
import pathlib
import re

import pytest

import pliant

# Functions by the tables of their settings.
TABLES = {
    "make_chainmail": ["chainmail"],
    "PreparedScan.__init__": ["chainmail", "elastic_scan"],
    "EndoscopeArena.__init__": ["chainmail", "elastic_scan"],
    "make_elastic": ["elastic_scan"],
    "make_springs": ["springs"],
    "make_body": ["body"],
    "make_network": ["network"],
    "CatheterScene.__init__": ["catheter"],
    "CatheterArena.__init__": ["catheter"],
    "MadeVessel.scene": ["catheter"],
    "wide_reach_mm": ["catheter"],
    "wall_around_centreline": ["wall"],
    "wall_around_surface": ["wall"],
    "SpringTissue.__init__": ["spring_solver"],
    "find_depth": ["spring_solver"],
    "ElasticSolver.__init__": ["elastic"],
    "FitProblem.__init__": ["fit"],
    "fit_box": ["fit"],
    "fit_mesh": ["fit"],
    "fit": ["gauss_newton", "annealing"],
    "make_organs": ["organs"],
    "make_organs_of_labels": ["organs"],
    "TruthMaker.__init__": ["truth"],
    "morph": ["morph"],
}
# No rows: dictionaries and numbers beside a table; the guide, which `entry` says.
BESIDE = {"run", "seed"}
GUIDE = {"place_mm", "direction"}
# Functions whose defaults come from a file, or settings without one default.
OF_A_FILE = {"MadeVessel.scene", "make_organs", "make_organs_of_labels"}
WITHOUT_DEFAULT = {
    ("ElasticSolver.__init__", "method"),
    ("make_elastic", "held_above_hu"),
    ("PreparedScan.__init__", "held_above_hu"),
    ("EndoscopeArena.__init__", "held_above_hu"),
}

FOLDER = pathlib.Path(pliant.__file__).parent


def definitions(path):
    """Functions of a stub by name, methods as CLASS.NAME; classes with their fields."""
    functions, classes = {}, {}
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef):
            functions[node.name] = node
        elif isinstance(node, ast.ClassDef):
            fields = [n for n in node.body if isinstance(n, ast.AnnAssign)]
            classes[node.name] = {n.target.id: ast.unparse(n.annotation) for n in fields}
            methods = [n for n in node.body if isinstance(n, ast.FunctionDef)]
            functions.update({f"{node.name}.{method.name}": method for method in methods})
    return functions, classes


@pytest.fixture(scope="module")
def functions():
    return definitions(FOLDER / "_core.pyi")[0]


def keywords_of(function):
    given = function.args
    return {
        one.arg.removesuffix("_"): (ast.unparse(one.annotation), ast.literal_eval(default))
        for one, default in zip(given.kwonlyargs, given.kw_defaults, strict=True)
    }


def types_in(annotation):
    """The types of a union."""
    node, found = ast.parse(annotation, mode="eval").body, []
    while isinstance(node, ast.BinOp):
        found.append(ast.unparse(node.right))
        node = node.left
    return [ast.unparse(node), *found[::-1]]


def is_type_of(annotation, row):
    """Whether an annotation has the kinds that a row takes."""
    types, default = types_in(annotation), row["default"]
    choices = re.findall(r'"([^"]*)"', row["range"])
    if choices:
        if row["range"].startswith("a list of "):
            types = [t.removeprefix("Sequence[").removesuffix("]") for t in types]
        (literal,) = (t for t in types if t.startswith("Literal"))
        return list(ast.literal_eval(literal.removeprefix("Literal"))) == choices
    if default is None:
        return types[-1] == "None" and len(types) > 1
    if isinstance(default, list):
        return any(t.startswith("Sequence[") for t in types)
    return types == [type(default).__name__]


@pytest.mark.parametrize("name", TABLES)
def test_keyword_arguments_are_those_of_the_rows(functions, name):
    keywords = keywords_of(functions[name])
    by_position = {one.arg for one in functions[name].args.args}
    rows = [row for table in TABLES[name] for row in pliant.settings_of(table)]
    names = {row["name"] for row in rows}
    left_out = GUIDE if name.startswith("Catheter") or name == "wide_reach_mm" else set()
    assert set(keywords) - BESIDE == names - by_position - left_out
    for row in rows:
        if row["name"] not in keywords:
            continue
        annotation, default = keywords[row["name"]]
        assert is_type_of(annotation, row), (row, annotation)
        if name in OF_A_FILE or (name, row["name"]) in WITHOUT_DEFAULT:
            assert default is ...
        else:
            assert default == row["default"] and type(default) is type(row["default"]), row


def test_no_function_takes_untyped_settings(functions):
    untyped = [name for name, f in functions.items() if f.args.kwarg is not None]
    assert untyped == ["Volume.__dlpack__"]
    structs = {name.removesuffix(".replaced") for name in functions if name.endswith(".replaced")}
    others = {f"{name}.{method}" for name in structs for method in ("__init__", "replaced")}
    typed = {name for name, function in functions.items() if function.args.kwonlyargs}
    assert typed == {*TABLES, *others, "Tissue.configure"}


def test_docstrings_explain_all_settings():
    for name in ("make_chainmail", "make_elastic", "make_body", "wall_around_surface", "fit_mesh"):
        lines = getattr(pliant, name).__doc__.splitlines()
        for row in pliant.settings_of(TABLES[name][0]):
            name = row["name"] + "_" * keyword.iskeyword(row["name"])
            (line,) = (x for x in lines if x.startswith(f"    {name}: "))
            assert row["text"] in line and row["unit"] in line


def test_functions_of_python_pass_on_the_same_settings():
    _, classes = definitions(FOLDER / "_settings.pyi")
    names = {
        table: {row["name"].replace("yield", "yield_") for row in pliant.settings_of(table)}
        for table in ("wall", "catheter", "truth", "chainmail")
    }
    assert set(classes["WallSettings"]) == names["wall"]
    assert set(classes["CatheterSettings"]) == names["catheter"] - GUIDE
    assert set(classes["TruthSettings"]) == names["truth"]
    assert set(classes["EndoscopeSettings"]) > names["chainmail"]
    assert set(classes["SequenceSettings"]) > set(classes["EndoscopeSettings"])
    assert classes["WallSettings"]["thickness_mm"] == "float"


def test_a_word_of_python_is_given_with_an_underscore(airway):
    pliant.make_chainmail(airway, 1, yield_=0.5)
    with pytest.raises(pliant.Error, match="yield: expected 0 to 1, found 2"):
        pliant.make_chainmail(airway, 1, yield_=2)
    with pytest.raises(pliant.Error, match="offset_"):
        pliant.make_chainmail(airway, 1, offset_=0.1)


def test_other_types_and_defaults_are_found():
    row = {"name": "a", "default": 2.0, "range": "0 to 1"}
    assert is_type_of("float", row)
    assert not is_type_of("int", row)
    assert not is_type_of("float | None", row)
    row = {"name": "a", "default": "x", "range": '"x" or "y"'}
    assert is_type_of("Literal['x', 'y']", row)
    assert not is_type_of("Literal['x']", row)
    assert not is_type_of("float", {"name": "a", "default": None, "range": ""})
