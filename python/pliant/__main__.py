# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The command `pliant` of the wheel: `study` is Python, the rest is the program."""

from __future__ import annotations

import os
import pathlib
import sys


def main() -> None:
    """Runs the command of sys.argv."""
    if sys.argv[1:2] == ["study"]:
        # Here, since the program's own commands start sooner without it.
        from pliant.study.__main__ import main as study

        sys.exit(study(sys.argv[2:]))
    path = pathlib.Path(__file__).parent / "bin" / "pliant"
    os.execv(path, [str(path), *sys.argv[1:]])


if __name__ == "__main__":
    main()
