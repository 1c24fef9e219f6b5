# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The program `pliant`, of which some functions are."""

from __future__ import annotations

import os
import pathlib
import shutil

from pliant._error import Error


def program() -> pathlib.Path:
    """The program `pliant` that belongs to this module.

    The environment's PLIANT_PROGRAM, else that of the wheel, else that of the search path.

    Raises:
        pliant.Error: There is none.
    """
    chosen = os.environ.get("PLIANT_PROGRAM")
    packaged = pathlib.Path(__file__).parent / "bin" / "pliant"
    if chosen:
        return pathlib.Path(chosen)
    if packaged.exists():
        return packaged
    found = shutil.which("pliant")
    if not found:
        raise Error(
            "pliant: expected the program on the search path or in PLIANT_PROGRAM, found none",
            "not_found",
        )
    return pathlib.Path(found)
