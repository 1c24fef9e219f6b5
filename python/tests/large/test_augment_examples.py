# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The examples of the augmentation's skins run."""

import importlib.util
import pathlib
import subprocess
import sys

import pytest

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples"


@pytest.mark.parametrize(
    ("name", "package"),
    [("monai", "monai"), ("torchio", "torchio"), ("nnunet", "batchgeneratorsv2")],
)
def test_its_example_runs(name, package):
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed")
    path = EXAMPLES / f"augment_{name}.py"
    run = subprocess.run([sys.executable, path], capture_output=True, text=True, timeout=600)
    assert run.returncode == 0, run.stderr
    print(run.stdout)
