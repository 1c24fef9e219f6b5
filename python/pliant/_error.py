# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The one exception of the module."""


def shortened(text: str, most: int = 200) -> str:
    """A text of one line, and of so many characters at most."""
    if len(text) <= most and "\n" not in text:
        return text
    line = " ".join(text[: 4 * most].split())
    return line if len(line) <= most and len(text) <= 4 * most else line[: most - 1] + "…"


class Error(Exception):
    """A call that could not be carried out, and has changed nothing.

    Attributes:
        code: "invalid_argument", "not_found", "unreadable", "unsupported", "unwritable" or
            "limit_exceeded" or "busy": the object is in use by another call.
        field: Name of the argument or setting, if it is about one.
        expected, found: Parts of the message about a field.
    """

    def __init__(
        self,
        message: str,
        code: str = "invalid_argument",
        field: str = "",
        expected: str = "",
        found: str = "",
    ) -> None:
        short = shortened(found)
        message = shortened(message.replace(found, short) if found else message, 2000)
        field, expected, found = shortened(field), shortened(expected, 1000), short
        super().__init__(message, code, field, expected, found)
        self.code, self.field, self.expected, self.found = code, field, expected, found

    def __str__(self) -> str:
        return str(self.args[0])


def busy_error(kind: str) -> Error:
    """The error of a call of an object that serves another one."""
    return Error(f"{kind}: busy: expected one call at a time, found another one", "busy", kind)


def expected_error(field: str, expected: str, found: object, about: str = "") -> Error:
    """The error of a wrong argument. about: the file or object whose field it is."""
    shown = shortened(str(found))
    message = f"{field}: expected {expected}, found {shown}"
    return Error(
        f"{about}: {message}" if about else message,
        field=field,
        expected=expected,
        found=shown,
    )
