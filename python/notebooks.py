# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Runs the notebooks of docs/notebooks and writes their results into them.

Usage:
    python notebooks.py [NAME…]
"""

from __future__ import annotations

import pathlib
import sys
import tempfile
from typing import Any

FOLDER = pathlib.Path(__file__).parents[1] / "docs" / "notebooks"
CELL_S = 600


def run(path: pathlib.Path) -> Any:
    """The notebook with the results of its cells; an exception in a cell is raised."""
    import nbclient
    import nbformat

    notebook = nbformat.read(path, as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        nbclient.NotebookClient(
            notebook, timeout=CELL_S, resources={"metadata": {"path": folder}}
        ).execute()
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)  # times
    return notebook


def main(names: list[str]) -> None:
    import nbformat

    for path in sorted(FOLDER.glob("*.ipynb")):
        if names and path.stem not in names:
            continue
        nbformat.write(run(path), path)
        print(path.name, path.stat().st_size >> 10, "KiB", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
