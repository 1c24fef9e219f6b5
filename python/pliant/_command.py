# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C while the command `pliant` or `python -m pliant…` imports: it ends, without a traceback.

Imported first by the package. Main programs that import the package keep their own handler.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import sys


def _is_command() -> bool:
    name = sys.argv[0] if sys.argv else ""
    if name == "-m":  # until the module is found; its packages are imported before
        return re.search(r"-m pliant\b|-mpliant\b", " ".join(sys.orig_argv)) is not None
    return os.path.basename(name) == "pliant"


if _is_command() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
    with contextlib.suppress(ValueError):  # in a thread
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def interrupts_are_exceptions() -> None:
    """Ends the above, once the imports are done."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_DFL:
        with contextlib.suppress(ValueError):
            signal.signal(signal.SIGINT, signal.default_int_handler)
