# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""docs/references.bib as a page of the site."""

import re

CITATION = re.compile(r"\[([A-Z][A-Za-z]*(?:19|20)\d\d[a-z]?(?:[;,] [^\[\]]*)?)\](?!\()")
ENTRY = re.compile(r"^@(\w+)\{(\w+),\n(.*?)^\}", re.DOTALL | re.MULTILINE)
FIELD = re.compile(r"^\s*(\w+)\s*=\s*\{(.*?)\},?\s*$", re.MULTILINE)
ACCENTS = {
    '\\"a': "ä",
    '\\"o': "ö",
    '\\"u': "ü",
    "\\'e": "é",
    "\\'a": "á",
    "\\'o": "ó",
    "\\`e": "è",
    "\\c{c}": "ç",
    "\\v{s}": "š",
    "\\o": "ø",
    "\\aa": "å",
    "\\ss": "ß",
    "--": "–",
    "\\&": "&",
}


def keys_of(file):
    return {key for _, key, _ in ENTRY.findall(file.read_text(encoding="utf-8"))}


def plain(text):
    text = re.sub(r"\{(\\[^{}]+)\}", r"\1", text)
    for tex, letter in ACCENTS.items():
        text = text.replace(tex, letter)
    return text.replace("{", "").replace("}", "")


def bibliography_page(file):
    lines = ["# References", ""]
    for _, key, body in sorted(ENTRY.findall(file.read_text(encoding="utf-8")), key=lambda e: e[1]):
        fields = {name.lower(): plain(value) for name, value in FIELD.findall(body)}
        where = [
            fields[name]
            for name in ("journal", "booktitle", "publisher", "organization", "school")
            if name in fields
        ]
        more = [
            f"{name} {fields[name]}" for name in ("volume", "number", "pages") if name in fields
        ]
        doi = f" [doi:{fields['doi']}](https://doi.org/{fields['doi']})" if "doi" in fields else ""
        authors = fields.get("author", "").replace(" and ", "; ")
        lines += [
            f'<a id="{key.lower()}"></a>**{key}** — {authors}: *{fields.get("title", "")}*. '
            + ", ".join([*where, *more, fields.get("year", "")])
            + "."
            + doi,
            "",
        ]
    return "\n".join(lines)
