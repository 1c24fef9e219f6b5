#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Calls the functions of pliant._core at random, with good and bad arguments made from its stubs.

Each call returns, or raises pliant.Error with one bounded line, within seconds. The last line that
is printed before a crash is the call. Usage: fuzz_calls.py [--seed N] [--calls N]
"""

import argparse
import ast
import os
import pathlib
import random
import resource
import signal
import sys
import tempfile
from collections.abc import Callable
from typing import Any

import numpy

import pliant

_CALL_S = 0.5  # after which a call is interrupted, and
_GRACE_S = 5.0  # at most ends
# Protocols of Python and NumPy, with errors of their own.
_SKIPPED = {"__hash__", "__repr__", "__reduce__", "__getstate__", "__setstate__", "__eq__"} | {
    "__array__", "__dlpack__", "__deepcopy__",
}  # fmt: skip


class TimeUp(BaseException):
    """A call takes long."""


def stub() -> ast.Module:
    path = pathlib.Path(pliant.__file__).with_name("_core.pyi")
    return ast.parse(path.read_text(encoding="utf-8"))


class Pool:
    """Values for annotations, and objects of the classes."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng
        scan = pliant.make_phantom("airway", (12, 12, 12), threads=1)
        mesh = pliant.TetMesh(
            [[0, 0, 0], [20, 0, 0], [0, 20, 0], [0, 0, 20]], [[0, 1, 2, 3]]
        )
        parts = pliant.springs_of_lattice((3, 3, 3))
        tissue = pliant.make_chainmail(scan, threads=1)
        z = numpy.arange(0.0, 31, 3)
        way = numpy.stack([0 * z, 0 * z, z, 0 * z + 4], axis=-1)
        self.objects: dict[str, list[Any]] = {}
        for made in (
            scan, mesh, parts, tissue, tissue.displacement_field(),
            pliant.make_springs(scan, threads=1), pliant.SpringTissue(parts, threads=1),
            pliant.RayCaster(tissue, threads=1), pliant.Endoscope(), pliant.Section(),
            pliant.TransferFunction(), pliant.Fluoroscopy(), pliant.hex_mesh((3, 3, 3)),
            pliant.HexLattice(), pliant.ElasticMaterial(), pliant.boundary_triangles(mesh),
            pliant.swept_tube(way), pliant._core.PreparedScan(scan), pliant.PushReport(),
        ):  # fmt: skip
            self.keep(made)

    def keep(self, made: Any) -> None:
        """Keeps an object for later calls."""
        for kind in type(made).__mro__:
            kept = self.objects.setdefault(kind.__name__, [])
            if kind.__module__.startswith("pliant") and all(made is not other for other in kept):
                kept.insert(self.rng.randrange(len(kept) + 1), made)
                del kept[6:]

    def number(self) -> Any:
        return self.rng.choice(
            [0, 1, 2, 3, 0.5, 5.0, -1, -0.0, 1e-300, 1e300, float("nan"), float("inf"), 255, 257,
             2**31 - 1, 2**31, 2**63, -(2**63) - 1, 2**70, True, numpy.float32(1), numpy.int64(2)]
        )  # fmt: skip

    def array(self) -> Any:
        shape = self.rng.choice([(0,), (3,), (4, 3), (1, 4), (2, 2, 3), (3, 3, 3), (2, 2, 2, 3)])
        kinds = ["float64", "float32", "int64", "uint64", "bool", "complex128", "U3"]
        kind = self.rng.choice(kinds)
        made = numpy.full(shape, 1).astype(kind)
        if self.rng.random() < 0.2:
            made = numpy.ma.masked_array(made, mask=True)
        if self.rng.random() < 0.1:
            made = numpy.lib.stride_tricks.as_strided(made, (7,) * 3, (0,) * 3)
        return made

    def three(self) -> tuple[Any, ...]:
        return tuple(self.rng.uniform(-9, 9) for _ in range(3))

    def bad(self) -> Any:
        return self.rng.choice(
            [None, "", "x" * 5000, "\0", b"x", [], (), {}, object(), lambda: 1, [[1], [1, 2]],
             [None], ["a"], 1 + 2j, self.number(), self.array()]
        )  # fmt: skip

    def good(self, annotation: str) -> Any:
        for part in annotation.split(" | "):
            name = part.rpartition(".")[2]
            if self.objects.get(name):
                return self.rng.choice(self.objects[name])
        if annotation.startswith("typing.Literal"):
            return self.rng.choice(ast.literal_eval(annotation[len("typing.Literal") :]))
        if annotation.startswith("int"):
            return self.rng.choice([0, 1, 2, 3, 8])
        if annotation.startswith("float"):
            return self.rng.choice([0.0, 0.5, 1.0, 3.0])
        if annotation.startswith("bool"):
            return self.rng.random() < 0.5
        if annotation.startswith("str"):
            return self.rng.choice(["airway", "rising", "chainmail", "none.nrrd", "made.nrrd"])
        if "Sequence" in annotation or "ArrayLike" in annotation or "NDArray" in annotation:
            return self.rng.choice([self.three(), [self.three()], [0, 1], self.array()])
        return self.bad()

    def value(self, annotation: str) -> Any:
        if self.rng.random() < 0.15:
            return self.bad()
        if self.rng.random() < 0.1:
            return self.number()
        return self.good(annotation)


def targets(tree: ast.Module) -> list[tuple[str, str | None, ast.FunctionDef]]:
    """(name, class, definition) of all functions, methods and setters."""
    found: list[tuple[str, str | None, ast.FunctionDef]] = []
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            found.append((node.name, None, node))
        if isinstance(node, ast.ClassDef):
            found += [
                (part.name, node.name, part)
                for part in node.body
                if isinstance(part, ast.FunctionDef) and part.name not in _SKIPPED
            ]
    return found


def call_of(
    pool: Pool, name: str, kind: str | None, node: ast.FunctionDef
) -> tuple[str, Callable[[], Any]] | None:
    """A call as a text, and to be made."""
    arguments = [*node.args.posonlyargs, *node.args.args]
    decorators = [ast.unparse(d) for d in node.decorator_list]
    target: Any = pliant._core
    if kind is not None:
        target = getattr(pliant._core, kind)
        if "staticmethod" not in decorators:
            arguments = arguments[1:]
            if name != "__init__":
                known = pool.objects.get(kind)
                if not known:
                    return None
                target = pool.rng.choice(known)
    required = len(arguments) - len(node.args.defaults)
    values = {
        a.arg: pool.value(ast.unparse(a.annotation) if a.annotation else "")
        for n, a in enumerate(arguments)
        if n < required or pool.rng.random() < 0.5
    }
    for a in node.args.kwonlyargs:
        if pool.rng.random() < 1.5 / len(node.args.kwonlyargs):
            values[a.arg] = pool.value(ast.unparse(a.annotation) if a.annotation else "")
    if "threads" in values and pool.rng.random() < 0.9:
        values["threads"] = pool.rng.randint(1, 2)
    text = f"{kind or ''}.{name}({', '.join(f'{k}={v!r}'[:120] for k, v in values.items())})"
    if "property" in decorators:
        return text, lambda: getattr(target, name)
    if any(d.endswith(".setter") for d in decorators):
        return text, lambda: setattr(target, name, *values.values())
    if name == "__init__":
        return text, lambda: target(**values)
    return text, lambda: getattr(target, name)(**values)


def fault_of(call: Callable[[], Any], keep: Callable[[Any], None]) -> str | None:
    """The fault of a call's end; None: none."""
    signal.setitimer(signal.ITIMER_REAL, _CALL_S, _CALL_S)
    try:
        keep(call())
    except pliant.Error as error:
        text = str(error)
        if "\n" in text or len(text) > 2000 or not text:
            return f"a message of {len(text)} characters: {text[:300]}"
    except (TimeUp, MemoryError):
        return None
    except BufferError:  # of DLPack's protocol
        return None
    except BaseException as error:
        return f"{type(error).__name__}: {str(error)[:300]}"
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
    return None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(2**32))
    parser.add_argument("--calls", type=int, default=20000)
    chosen = parser.parse_args()
    print(f"seed {chosen.seed}", flush=True)
    rng = random.Random(chosen.seed)
    resource.setrlimit(resource.RLIMIT_AS, (8 * 2**30, 8 * 2**30))

    def stop(*_: Any) -> None:
        raise TimeUp

    signal.signal(signal.SIGALRM, stop)
    pool, known = Pool(rng), targets(stub())
    faults = 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for _ in range(chosen.calls):
            made = call_of(pool, *rng.choice(known))
            if made is None:
                continue
            print(made[0], flush=True)
            with numpy.errstate(all="ignore"):
                fault = fault_of(made[1], pool.keep)
            if fault:
                faults += 1
                print(f"FAULT {fault}", flush=True)
        os.chdir("/")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
