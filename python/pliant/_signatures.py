# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Signatures of the library's functions for inspect, and errors of arguments that don't fit."""

from __future__ import annotations

import ast
import functools
import inspect
import os
import re
from collections.abc import Callable, Sequence
from typing import Any

from pliant._error import Error, expected_error

_THREE = "collections.abc.Sequence[float] | numpy.typing.NDArray[typing.Any]"


@functools.cache
def _parsed(function: Any) -> inspect.Signature:
    text, _, defaults = function.__nb_signature__[0]
    tree = ast.parse(re.sub(r"\\(\d+)", r"_given[\1]", text) + ": ...").body[0]
    assert isinstance(tree, ast.FunctionDef)

    def default_of(node: ast.expr | None) -> Any:
        if node is None:
            return inspect.Parameter.empty
        if isinstance(node, ast.Subscript):
            assert isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, int)
            return defaults[node.slice.value]
        return ast.literal_eval(node)

    def parameter(
        argument: ast.arg, kind: Any, default: ast.expr | None = None
    ) -> inspect.Parameter:
        annotation = argument.annotation
        return inspect.Parameter(
            argument.arg,
            kind,
            default=default_of(default),
            annotation=inspect.Parameter.empty if annotation is None else ast.unparse(annotation),
        )

    a, kinds = tree.args, inspect.Parameter
    positional = [*a.posonlyargs, *a.args]
    bare = len(positional) - len(a.defaults)
    parameters = [
        parameter(
            one,
            kinds.POSITIONAL_ONLY if n < len(a.posonlyargs) else kinds.POSITIONAL_OR_KEYWORD,
            a.defaults[n - bare] if n >= bare else None,
        )
        for n, one in enumerate(positional)
    ]
    if a.vararg:
        parameters.append(parameter(a.vararg, kinds.VAR_POSITIONAL))
    parameters += [
        parameter(one, kinds.KEYWORD_ONLY, default)
        for one, default in zip(a.kwonlyargs, a.kw_defaults, strict=True)
    ]
    if a.kwarg:
        parameters.append(parameter(a.kwarg, kinds.VAR_KEYWORD))
    returned = kinds.empty if tree.returns is None else ast.unparse(tree.returns)
    return inspect.Signature(parameters, return_annotation=returned)


def signature_of(function: Any) -> inspect.Signature:
    """The signature of a function, as the stubs have it; of a bound method without self."""
    bound = getattr(function, "__func__", None)
    if bound is None:
        return _parsed(function)
    whole = _parsed(bound)
    return whole.replace(parameters=list(whole.parameters.values())[1:])


def _is_number(value: Any) -> bool:
    return hasattr(value, "__float__") and getattr(value, "ndim", 0) == 0


def _is_whole(value: Any) -> bool:
    return hasattr(value, "__index__") and getattr(value, "ndim", 0) == 0


def _is_sequence(value: Any) -> bool:
    return not isinstance(value, (str, bytes)) and hasattr(value, "__len__")


def _is_three(value: Any) -> bool:
    return _is_sequence(value) and len(value) == 3 and all(map(_is_number, value))


_FITS: dict[str, Callable[[Any], bool]] = {
    "int": _is_whole,
    "float": _is_number,
    "bool": lambda v: type(v).__name__ in ("bool", "bool_"),
    "str": lambda v: isinstance(v, str),
    "os.PathLike[str]": lambda v: isinstance(v, os.PathLike),
    "None": lambda v: v is None,
    "tuple": lambda v: isinstance(v, (tuple, list)),
    "list": lambda v: isinstance(v, (tuple, list)),
    "dict": lambda v: isinstance(v, dict),
    "collections.abc.Sequence": _is_sequence,
    "collections.abc.Callable": callable,
}
_WORDS: dict[str, str] = {
    "int": "a whole number",
    "float": "a number",
    "bool": "True or False",
    "str": "a text",
    "os.PathLike[str]": "a path",
    "None": "None",
    "collections.abc.Sequence[float]": "numbers",
    "collections.abc.Sequence[int]": "whole numbers",
    "numpy.typing.ArrayLike": "an array",
}


def _parts(annotation: str) -> list[str]:
    if annotation.startswith(_THREE):
        rest = annotation.removeprefix(_THREE).removeprefix(" | ")
        return [_THREE, *_parts(rest)] if rest else [_THREE]
    return re.split(r" \| (?![^\[]*\])", annotation)


def _fits(annotation: str, value: Any) -> bool:
    for part in _parts(annotation):
        if part == _THREE:
            fits = _is_three(value)
        elif part.startswith("pliant._core.") or part[:1].isupper():
            name = part.rpartition(".")[2]
            fits = any(kind.__name__ == name for kind in type(value).__mro__)
        else:
            known = _FITS.get(part) or _FITS.get(part.partition("[")[0])
            fits = known is None or bool(known(value))
        if fits:
            return True
    return False


def _words(annotation: str) -> str:
    words = []
    for part in _parts(annotation):
        if part == _THREE:
            words.append("three numbers")
        elif part.startswith("pliant._core.") or part[:1].isupper():
            words.append(f"a {part.rpartition('.')[2]}")
        else:
            words.append(_WORDS.get(part, part))
    return " or ".join(words)


def argument_error(
    function: Any, values: Sequence[Any], names: Sequence[str], raised: BaseException
) -> BaseException:
    """The pliant.Error of arguments that don't fit a function's signature; other errors stay.

    Args:
        values: All arguments; the last ones have names.
    """
    if "incompatible function arguments" not in str(raised):
        return raised
    count = len(values) - len(names)
    try:
        bound = _parsed(function).bind(
            *values[:count], **dict(zip(names, values[count:], strict=True))
        )
    except TypeError as error:
        return Error(f"{function.__name__}: {error}", field=function.__name__)
    parameters = _parsed(function).parameters
    given = [
        (name, value, parameters[name].annotation)
        for name, value in bound.arguments.items()
        if isinstance(parameters[name].annotation, str)
    ]
    for name, value, annotation in given:
        if not _fits(annotation, value):
            return expected_error(name, _words(annotation), repr(value))
    for name, value, annotation in given:
        if "int" in _parts(annotation) and _is_whole(value):
            if not 0 <= value.__index__() < 2**31:
                return expected_error(name, "a whole number of 32 bits, mostly above 0", value)
    types = ", ".join(f"{name}: {type(value).__name__}" for name, value, _ in given)
    return Error(f"{function.__name__}: expected the types of its signature, found {types}")
