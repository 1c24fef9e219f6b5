# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Names the packages that the tests ran against."""

import importlib.metadata

PACKAGES = (
    "pliant", "numpy", "torch", "monai", "torchio", "batchgenerators", "batchgeneratorsv2",
    "gymnasium", "stable-baselines3", "matplotlib", "pyvista",
)  # fmt: skip


def pytest_report_header() -> str:
    found = []
    for name in PACKAGES:
        try:
            found.append(f"{name} {importlib.metadata.version(name)}")
        except importlib.metadata.PackageNotFoundError:
            found.append(f"no {name}")
    return "packages: " + ", ".join(found)
