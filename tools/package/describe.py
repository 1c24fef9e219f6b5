# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Manual pages and completions of bash, zsh and fish, from what `pliant --help` says.

python describe.py PROGRAM FOLDER     FOLDER gets man/man1, bash-completion, zsh and fish below it
"""

import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

ENTRY = re.compile(r"^  (\S.*?)(?:  +(.*))?$")
CHOICES = re.compile(r":\{([^}]*)\}")


@dataclass
class Option:
    names: list  # ["-h", "--help"]
    value: str  # as shown, empty for flags
    text: str

    @property
    def choices(self):
        found = CHOICES.search(self.value)
        return found[1].split(",") if found else []


@dataclass
class Command:
    name: str  # "truth make"; empty: the program
    about: str = ""
    usage: str = ""
    positionals: list = field(default_factory=list)
    options: list = field(default_factory=list)
    subcommands: list = field(default_factory=list)  # (name, text)
    footer: list = field(default_factory=list)


def entries(lines):
    """Pairs of a left column and its text, which may stand on the next line."""
    found = []
    for line in lines:
        entry = ENTRY.match(line)
        if entry:
            found.append([entry[1], entry[2] or ""])
        elif found and line.strip():
            found[-1][1] = (found[-1][1] + " " + line.strip()).strip()
    return found


def parsed(name, text):
    command, section, sections = Command(name), "head", {"head": []}
    for line in text.rstrip().split("\n"):
        if re.match(r"^(Positionals|Options|Subcommands|\[Option Group.*\]|Examples?):$", line):
            section = line.rstrip(":")
        elif section in ("Positionals", "Options", "Subcommands") and line and line[0] != " ":
            section = "footer"
        sections.setdefault(section, []).append(line)
    command.about = sections["head"][0]
    command.usage = " ".join(line.removeprefix("Usage: ") for line in sections["head"][1:] if line)
    command.positionals = entries(sections.get("Positionals", [])[1:])
    command.subcommands = [
        (left.split()[0], text) for left, text in entries(sections.get("Subcommands", [])[1:])
    ]
    for left, about in entries(sections.get("Options", [])[1:]):
        names, _, value = left.partition(" ")
        command.options.append(Option(names.split(","), value, about))
    for title in ("Example", "Examples", "footer"):
        command.footer += sections.get(title, [])
    return command


def read(program, name=""):
    """A command and all below it."""
    text = subprocess.run(
        [program.name, *name.split(), "--help"],
        check=True,
        capture_output=True,
        text=True,
        env={"PATH": str(program.parent)},
    ).stdout
    command = parsed(name, text)
    commands = [command]
    for sub, _ in command.subcommands:
        commands += read(program, f"{name} {sub}".strip())
    return commands


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def manual_page(command, version):
    title = " ".join(["pliant", command.name]).strip().replace(" ", "-")
    lines = [
        f'.TH {title.upper()} 1 "" "Pliant {version}" "User Commands"',
        ".SH NAME",
        f"{roff(title)} \\- {roff(command.about)}",
        ".SH SYNOPSIS",
        roff(command.usage),
    ]
    if command.positionals:
        lines.append(".SH ARGUMENTS")
        for left, text in command.positionals:
            lines += [".TP", f".B {roff(left)}", roff(text)]
    lines.append(".SH OPTIONS")
    for option in command.options:
        lines += [
            ".TP",
            f".B {roff(', '.join(option.names) + ' ' + option.value)}",
            roff(option.text),
        ]
    if command.subcommands:
        lines.append(".SH COMMANDS")
        for name, text in command.subcommands:
            lines += [".TP", f".BR {roff(title + '-' + name)} (1)", roff(text)]
    if command.footer:
        lines += [".SH EXAMPLES", ".nf", *[roff(line) for line in command.footer if line], ".fi"]
    return "\n".join(lines) + "\n"


def words_after(command):
    return [name for name, _ in command.subcommands] + [n for o in command.options for n in o.names]


def bash_completion(commands):
    lines = [
        "# bash completion of pliant",
        "_pliant() {",
        "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]}",
        '    local command="" n',
        "    for ((n = 1; n < COMP_CWORD; n++)); do",
        '        case "$command ${COMP_WORDS[n]}" in',
    ]
    names = [c.name for c in commands if c.name]
    lines += [
        f'            "{" " + name if " " not in name else name}") command="{name}" ;;'
        for name in names
    ]
    lines += ["        esac", "    done", '    case "$command:$before" in']
    for command in commands:
        for option in command.options:
            for name in option.names if option.choices else []:
                lines.append(
                    f'        "{command.name}:{name}") COMPREPLY=($(compgen -W '
                    f'"{" ".join(option.choices)}" -- "$word")); return ;;'
                )
    lines += ["    esac", '    case "$command" in']
    for command in commands:
        lines.append(
            f'        "{command.name}") COMPREPLY=($(compgen -W '
            f'"{" ".join(words_after(command))}" -- "$word")) ;;'
        )
    lines += [
        "    esac",
        '    [[ $word == -* ]] || COMPREPLY+=($(compgen -f -- "$word"))',
        "}",
        "complete -o filenames -F _pliant pliant",
    ]
    return "\n".join(lines) + "\n"


def zsh_completion(bash):
    """zsh runs bash's functions."""
    return "#compdef pliant\nautoload -U +X bashcompinit && bashcompinit\n" + bash


def fish_quoted(text):
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"


def fish_completion(commands):
    lines = ["# fish completion of pliant"]
    for command in commands:
        parts = command.name.split()
        seen = [f"__fish_seen_subcommand_from {part}" for part in parts]
        if command.subcommands:
            others = " ".join(name for name, _ in command.subcommands)
            unseen = "; and ".join(seen + [f"not __fish_seen_subcommand_from {others}"])
            for name, text in command.subcommands:
                lines.append(
                    f"complete -c pliant -n {fish_quoted(unseen)} -f -a {name}"
                    f" -d {fish_quoted(text)}"
                )
        condition = f" -n {fish_quoted('; and '.join(seen))}" if seen else ""
        for option in command.options:
            flags = "".join(
                f" -l {n[2:]}" if n.startswith("--") else f" -s {n[1:]}" for n in option.names
            )
            takes = " -r" if option.value else ""
            values = f" -f -a {fish_quoted(' '.join(option.choices))}" if option.choices else ""
            lines.append(
                f"complete -c pliant{condition}{flags}{takes}{values} -d {fish_quoted(option.text)}"
            )
    return "\n".join(lines) + "\n"


def main():
    program, folder = Path(sys.argv[1]).resolve(), Path(sys.argv[2])
    version = subprocess.run(
        [program, "--version"], check=True, capture_output=True, text=True
    ).stdout.split()[-1]
    commands = read(program)
    bash = bash_completion(commands)
    files = {
        "bash-completion/completions/pliant": bash,
        "zsh/vendor-completions/_pliant": zsh_completion(bash),
        "fish/vendor_completions.d/pliant.fish": fish_completion(commands),
    }
    for command in commands:
        name = " ".join(["pliant", command.name]).strip().replace(" ", "-")
        files[f"man/man1/{name}.1"] = manual_page(command, version)
    for name, text in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
