# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The one exception of the module."""


class Error(Exception):
    """A call that could not be carried out, and has changed nothing.

    Attributes:
        code: "invalid_argument", "not_found", "unreadable", "unsupported", "unwritable" or
            "limit_exceeded".
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
        super().__init__(message, code, field, expected, found)
        self.code, self.field, self.expected, self.found = code, field, expected, found

    def __str__(self) -> str:
        return str(self.args[0])


def expected_error(field: str, expected: str, found: object, about: str = "") -> Error:
    """The error of a wrong argument. about: the file or object whose field it is."""
    message = f"{field}: expected {expected}, found {found}"
    return Error(
        f"{about}: {message}" if about else message,
        field=field,
        expected=expected,
        found=str(found),
    )
