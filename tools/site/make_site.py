# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The documents as one tree of Markdown, and MkDocs' list of it: `./dev docs`.

docs/ as it is; pages elsewhere that it links to; a page for each public header, each Python module
and the bibliography, with links from citations. Links to other files become plain text.

    python make_site.py ROOT PYI FOLDER     PYI: the stub of the compiled Python module;
                                            mkdocs.yml is written beside FOLDER
"""

import ast
import posixpath
import re
import shutil
import sys
from pathlib import Path

from references import CITATION, bibliography_page, keys_of

LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
FENCE = re.compile(r"^( *)(```+)")
PICTURES = {".png", ".jpg", ".svg", ".webp"}
# Title, the beginnings of its pages' names, and its subsections.
SECTIONS = (
    ("Start here", ("index.md", "hello.md", "faq.md"), ()),
    ("How to", ("howto/", "project/integrations/"), ()),
    ("Method", ("method/",), ()),
    ("Results", ("results/", "credibility/", "project/research/"), ()),
    (
        "Reference",
        ("reference/", "references.md"),
        (("C++", ("api/cpp/", "project/examples/")), ("Python", ("api/python/",))),
    ),
    ("Developers", ("developers/", "project/"), ()),
)
SECTION = re.compile(r"^(Args|Returns|Raises|Example|Examples|Yields|Attributes|Note):$")
# Python files whose names a user imports, beside the compiled module.
PYTHON_MODULES = ("gym", "plot", "scene_flow", "steve", "truth", "augment", "study")


class Site:
    def __init__(self, root, folder):
        self.root, self.folder = root, folder
        self.keys = keys_of(root / "docs/references.bib")
        self.headers = sorted((root / "include/pliant").rglob("*.h"))
        self.pages = {}  # repository path → page in the site
        for page in sorted((root / "docs").rglob("*.md")):
            self.pages[str(page.relative_to(root))] = str(page.relative_to(root / "docs"))
        for name in (
            "README.md",
            "CHANGELOG.md",
            "CONTRIBUTING.md",
            "HACKING.md",
            "SECURITY.md",
            "THIRD_PARTY.md",
        ):
            self.pages[name] = f"project/{name.lower()}"
        self.pages["README.md"] = "project/about.md"
        for page in [
            page
            for pattern in ("research/**", "examples/*", "integrations/*")
            for page in sorted(root.glob(pattern + "/README.md"))
        ]:
            name = str(page.relative_to(root))
            self.pages[name] = "project/" + name
        for header in self.headers:
            name = str(header.relative_to(root))
            self.pages[name] = "api/cpp/" + name.removeprefix("include/pliant/")[:-2] + ".md"
        self.pages["docs/references.bib"] = "references.md"
        self.pages["include/pliant"] = "api/cpp/index.md"
        self.pages["LICENSE"] = None

    def write(self, page, text):
        file = self.folder / page
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")

    def link(self, page, source, match):
        """A link of a repository's file, for its page in the site."""
        mark, text, target = match.groups()
        if re.match(r"[a-z]+:|#", target):
            return match[0]
        path, _, anchor = target.partition("#")
        path = posixpath.normpath(posixpath.join(posixpath.dirname(source), path))
        if Path(path).suffix in PICTURES:
            place = path.removeprefix("docs/") if path.startswith("docs/") else "project/" + path
            (self.folder / place).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(self.root / path, self.folder / place)
            return f"{mark}[{text}]({relative(place, page)})"
        place = self.pages.get(path)
        if place is None and (self.root / path / "README.md").exists():
            place = self.pages.get(path + "/README.md")
        if place is None:
            return text
        return f"[{text}]({relative(place, page)}{'#' + anchor if anchor else ''})"

    def cited(self, page):
        """Replaces citations in brackets by links to the bibliography."""
        place = relative("references.md", page)

        def linked(match):
            parts = [part.strip() for part in re.split(r"([;,])", match[1])]
            shown = [f"[{p}]({place}#{p.lower()})" if p in self.keys else p for p in parts]
            return "\\[" + " ".join(shown).replace(" ;", ";").replace(" ,", ",") + "\\]"

        return lambda text: CITATION.sub(linked, text)

    def prose(self, page, text):
        """A comment, with links from citations and from the names of documents."""

        def linked(match):
            place = self.pages.get(match[0])
            return f"[{match[0]}]({relative(place, page)})" if place else match[0]

        return re.sub(r"docs/[\w/]+\.md", linked, self.cited(page)(text))

    def convert(self, page, source, text):
        """A repository's Markdown for the site. Code is left as it is."""
        cite, lines, fence = self.cited(page), [], ""
        for line in text.split("\n"):
            opened = FENCE.match(line)
            if fence or opened:
                if not fence:
                    fence = opened[2]
                elif opened and opened[2].startswith(fence):
                    fence = ""
                lines.append(line)
                continue
            parts = re.split(r"(`+[^`]*`+)", line) if "](" not in line else [line]
            line = "".join(p if p.startswith("`") else cite(p) for p in parts)
            lines.append(LINK.sub(lambda match: self.link(page, source, match), line))
        return "\n".join(lines)

    def add_documents(self):
        for source, page in self.pages.items():
            if page and source.endswith(".md"):
                text = (self.root / source).read_text(encoding="utf-8")
                self.write(page, self.convert(page, source, text))
        for file in (self.root / "docs").rglob("*"):
            if file.suffix in PICTURES:
                place = self.folder / file.relative_to(self.root / "docs")
                place.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(file, place)
        self.write("references.md", bibliography_page(self.root / "docs/references.bib"))

    def add_headers(self):
        rows = []
        for header in self.headers:
            name = str(header.relative_to(self.root))
            page = self.pages[name]
            intro, code = split_header(header.read_text(encoding="utf-8"))
            shown = name.removeprefix("include/")
            self.write(
                page,
                f"# `<{shown}>`\n\n{self.prose(page, intro)}\n\n## Declarations\n\n"
                f"```cpp\n{code}\n```\n",
            )
            first = intro.split("\n\n")[0].replace("\n", " ")
            rows.append(f"| [`<{shown}>`]({relative(page, 'api/cpp/index.md')}) | {first} |")
        self.write(
            "api/cpp/index.md",
            "# C++\n\nEach header begins with its idea and an example.\n\n"
            "| header | |\n|---|---|\n" + "\n".join(rows) + "\n",
        )

    def add_python(self, stub):
        modules = [("pliant", stub)]
        for name in PYTHON_MODULES:
            at = self.root / "python/pliant" / name
            modules.append(
                (f"pliant.{name}", at / "__init__.py" if at.is_dir() else at.with_suffix(".py"))
            )
        rows = []
        for name, file in modules:
            tree = ast.parse(file.read_text(encoding="utf-8"))
            about = (ast.get_docstring(tree) or "").split("\n\n")[0].replace("\n", " ")
            page = f"api/python/{name}.md"
            self.write(page, f"# {name}\n\n" + python_page(tree))
            rows.append(f"| [`{name}`]({name}.md) | {about} |")
        self.write(
            "api/python/index.md", "# Python\n\n| module | |\n|---|---|\n" + "\n".join(rows) + "\n"
        )

    def nav(self):
        """Sections of the site with their pages, in the order in which docs/index.md names them."""
        index = (self.root / "docs/index.md").read_text(encoding="utf-8")
        pages = [str(page.relative_to(self.folder)) for page in self.folder.rglob("*.md")]
        pages.sort(key=lambda page: (index.find(f"({page}") % (1 << 30), page))
        lines, listed = ["nav:"], set()

        def add(indent, beginnings):
            these = [p for p in pages if p.startswith(beginnings) and p not in listed]
            lines.extend(f"{indent}- {page}" for page in these)
            listed.update(these)

        for title, beginnings, parts in SECTIONS:
            lines.append(f"  - {title}:")
            add("      ", beginnings)
            for part, names in parts:
                lines.append(f"      - {part}:")
                add("          ", names)
        left = set(pages) - listed
        if left:
            sys.exit(f"site: in no section: {', '.join(sorted(left))}")
        return "\n".join(lines) + "\n"


def relative(place, page):
    return posixpath.relpath(place, posixpath.dirname(page) or ".")


def split_header(text):
    """The first comment of a header as Markdown, and its declarations."""
    head, _, code = text.partition("#pragma once")
    lines = [
        line[3:] if line.startswith("// ") else line[2:]
        for line in head.split("\n")
        if line.startswith("//") and "SPDX" not in line
    ]
    while lines and not lines[0].strip():
        lines.pop(0)
    intro, is_code = [], False
    for line in lines:
        if line.strip() in ("@code", "@endcode"):
            is_code = not is_code
            intro.append("```cpp" if is_code else "```")
        elif not is_code and line.startswith("  "):
            intro.append("    " + line)
        else:
            intro.append(line)
    code = re.sub(r"^#(include|pragma GCC).*\n", "", code, flags=re.MULTILINE)
    return "\n".join(intro).strip(), re.sub(r"\n{3,}", "\n\n", code).strip()


def docstring_text(text):
    """A docstring in Google's style as Markdown."""
    lines = []
    for line in (text or "").split("\n"):
        item = re.match(r"^    (\*{0,2}\w[\w, *]*): (.*)", line)
        if SECTION.match(line):
            lines += ["", f"**{line[:-1]}**", ""]
        elif line.strip().startswith(">>>"):
            lines.append("        " + line.strip())
        elif item:
            lines.append(f"- `{item[1]}`: {item[2]}")
        else:
            lines.append("  " + line.strip() if line.startswith("        ") else line.strip())
    return "\n".join(lines)


def signature_of(node):
    if isinstance(node, ast.ClassDef):
        bases = ", ".join(ast.unparse(base) for base in node.bases)
        return f"class {node.name}({bases})" if bases else f"class {node.name}"
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    return f"{node.name}({ast.unparse(node.args)}){returns}"


def python_page(tree):
    parts = [docstring_text(ast.get_docstring(tree))]
    kinds = (ast.ClassDef, ast.FunctionDef)

    def add(node, level, owner=""):
        if node.name.startswith("_"):
            return
        is_property = any("property" in ast.unparse(d) for d in getattr(node, "decorator_list", []))
        shown = node.name if is_property else signature_of(node)
        parts.append(
            f"{'#' * level} {owner}{node.name}\n\n```python\n{shown}\n```\n\n"
            + docstring_text(ast.get_docstring(node))
        )
        if isinstance(node, ast.ClassDef):
            for member in node.body:
                if isinstance(member, kinds) and not any(
                    "setter" in ast.unparse(d) or "overload" in ast.unparse(d)
                    for d in member.decorator_list
                ):
                    add(member, level + 1, node.name + ".")

    for node in tree.body:
        if isinstance(node, kinds):
            add(node, 2)
    return "\n\n".join(parts) + "\n"


def main():
    root, stub, folder = (Path(argument).resolve() for argument in sys.argv[1:4])
    shutil.rmtree(folder, ignore_errors=True)
    site = Site(root, folder)
    site.add_documents()
    site.add_headers()
    site.add_python(stub)
    config = root / "tools/site/mkdocs.yml"
    (folder.parent / "mkdocs.yml").write_text(f"INHERIT: {config}\n" + site.nav(), encoding="utf-8")
    print(f"site: {sum(1 for _ in folder.rglob('*.md'))} pages")


if __name__ == "__main__":
    main()
