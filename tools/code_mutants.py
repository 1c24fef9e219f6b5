# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The mutants of a source: each changes one token. tools/mutate_code runs them."""

import fnmatch
import hashlib
import math
import re
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
EQUIVALENT = ROOT / "tests/equivalent_mutants.txt"

BINARY = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "==", "+": "-", "-": "+",
          "*": "/", "/": "*", "%": "*", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=",
          "&&": "||", "||": "&&", "&": "|", "|": "&", "&=": "|=", "|=": "&=", "<<": ">>",
          ">>": "<<"}
PAIRS = ["min max", "min_element max_element", "any_of all_of", "floor ceil",
         "lower_bound upper_bound", "Min Max", "Lt Le", "Gt Ge", "Eq Ne", "Add Sub", "Mul Div",
         "And Or", "MulAdd MulSub", "add sub", "mul div"]
NAMES = {a: b for pair in PAIRS for a, b in (pair.split(), reversed(pair.split()))}
OTHER = {"true": "false", "false": "true", "0": "1", "1": "0", "!": "", "-": ""}
# A pattern, and what stands in place of the text that it finds. The sources are formatted by
# clang-format: a binary operator has blanks on both sides, a bracket of a template doesn't.
RULES = [
    (r"(?<=\s)(?:%s)(?=\s)" % "|".join(map(re.escape, sorted(BINARY, key=len)[::-1])), BINARY),
    (r"(?:(?<=std::)|(?<=hn::)|(?<=Ops::))\w+(?=[(<])", NAMES),
    (r"\b(?:true|false)\b", OTHER),
    (r"(?<![\w.'])[01](?=(?:\.0)?[uUlLfF]*(?![\w.']))", OTHER),
    (r"(?<![\w)\]])!(?=[\w(])", OTHER),
    (r"(?:(?<=[({\[])|(?<=[=?:,<>*+/&|] )|(?<=return ))-(?=[\w(])", OTHER),
]
# Calls whose arguments aren't mutated: assertions, and memory that is only reserved or prefetched.
SKIPPED = (r"\b(?:PLIANT_ASSERT|static_assert|\w*reserve\w*|__builtin_prefetch|madvise|alignas|"
           r"noexcept)\(")
SKIPPED_FILES = {"ahead.h"}  # a queue of prefetches: no result depends on it
NO_CODE = re.compile(
    r"""(?P<number>\b\d[\w.']*)|//[^\n]*|/\*.*?\*/|R"(?P<end>\w*)\(.*?\)(?P=end)"|"""
    r""""(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])+'|^[ \t]*\#(?:[^\n]*\\\n)*[^\n]*|\[\[.*?\]\]""",
    re.M | re.S)


def fail(text: str):
    sys.exit(f"mutate_code: {text}")


def only_code(text: str) -> str:
    """The text with blanks in place of everything that isn't mutated."""
    def blank(part):
        return re.sub(r"[^\n]", " ", part)
    code = NO_CODE.sub(lambda m: m[0] if m["number"] else blank(m[0]), text)
    for found in re.finditer(SKIPPED, code):
        end, depth = found.end(), 1
        while depth and end < len(code):
            depth += {"(": 1, ")": -1}.get(code[end], 0)
            end += 1
        code = code[:found.end()] + blank(code[found.end():end - 1]) + code[end - 1:]
    return code


@dataclass
class Mutant:
    """One changed token of a file."""
    file: str
    line: int
    column: int
    offset: int
    old: str
    new: str
    before: str  # the line
    after: str
    key: str = ""  # the order in which mutants are drawn

    def name(self) -> str:
        return f"{self.file}:{self.line}:{self.column}: {self.old or '∅'} → {self.new or '∅'}"


def mutants_of(file: str, text: str, seed: int) -> list[Mutant]:
    code, found, seen = only_code(text), [], {}
    for pattern, change in RULES:
        for match in re.finditer(pattern, code):
            new = change.get(match[0])
            if new is None:
                continue
            start = match.start()
            begin = text.rfind("\n", 0, start) + 1
            line = text[begin:text.find("\n", start)]
            column = start - begin
            after = line[:column] + new + line[column + len(match[0]):]
            identity = (line.strip(), after.strip())
            seen[identity] = seen.get(identity, 0) + 1
            key = hashlib.sha256(repr((seed, file, identity, seen[identity])).encode()).hexdigest()
            found.append(Mutant(file, text.count("\n", 0, start) + 1, column + 1, start, match[0],
                                new, *identity, key))
    return sorted(found, key=lambda mutant: mutant.key)


def sources_of(room: str) -> list[Path]:
    folders = [f for f in ROOT.glob(f"src/*/{room}") if f.is_dir()]
    if not folders:
        fail(f"expected a room, found '{room}'")
    return sorted(f for f in folders[0].iterdir()
                  if f.suffix in (".cpp", ".h", ".inc") and f.name not in SKIPPED_FILES)


def read_equivalent(text: str) -> dict[tuple[str, str, str], str]:
    """(file, line, mutated line) and the reason, from blocks: FILE, - LINE, + LINE, reason."""
    entries = {}
    for block in re.split(r"\n\s*\n", re.sub(r"(?m)^#.*\n?", "", text).strip()):
        lines = block.splitlines()
        if len(lines) < 4 or lines[1][:2] != "- " or lines[2][:2] != "+ ":
            fail(f"{EQUIVALENT.name}: expected a file, '- LINE', '+ LINE' and a reason, found\n"
                 + block)
        entries[lines[0], lines[1][2:].strip(), lines[2][2:].strip()] = " ".join(lines[3:])
    return entries


def stale(entries: dict, text_of) -> list[str]:
    """Entries whose file has no such mutant."""
    known = {}
    for file, before, after in entries:
        if file not in known:
            known[file] = {(m.before, m.after) for m in mutants_of(file, text_of(file), 0)}
    return [f"{file}: {before}" for file, before, after in entries
            if (before, after) not in known[file]]


def equivalent() -> dict:
    def text_of(file):
        return (ROOT / file).read_text() if (ROOT / file).is_file() else ""
    entries = read_equivalent(EQUIVALENT.read_text()) if EQUIVALENT.is_file() else {}
    old = stale(entries, text_of)
    if old:
        fail(f"{EQUIVALENT.name}: no such mutant any more: " + "; ".join(old))
    return entries


def interval(killed: int, counted: int) -> tuple[float, float]:
    """Wilson's 95 % interval of a share."""
    if not counted:
        return 0.0, 1.0
    z, p = 1.959964, killed / counted
    middle = (p + z * z / (2 * counted)) / (1 + z * z / counted)
    half = z / (1 + z * z / counted) * math.sqrt(p * (1 - p) / counted + (z / (2 * counted)) ** 2)
    return max(0.0, middle - half), min(1.0, middle + half)


def covering(tests: dict[str, str], source: str) -> list[str]:
    """The tests (path: text) that cover the source ROOM/NAME, or the .cpp of a header."""
    found = []
    for path, text in tests.items():
        folder, name = Path(path).parent.name, Path(path).stem.removeprefix("test_")
        named = re.search(r"(?m)^// Covers: ((?:.*\n// )*?.*?)\.$", text)
        patterns = re.split(r",\s+(?:// )?", named[1]) if named else []
        patterns += [f"{folder}/{name}.cpp", f"{folder}/{name}_*.cpp"]
        if any(fnmatch.fnmatch(name, pattern) for pattern in patterns
               for name in (source, str(Path(source).with_suffix(".cpp")))):
            found.append(path)
    return found
