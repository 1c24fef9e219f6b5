# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Entry point of gymnasium's plug-ins: `import gymnasium` calls register()."""

from __future__ import annotations


def register() -> None:
    """Registers pliant/Endoscope-v0, without importing its module."""
    import gymnasium

    # Gymnasium adds the entry point's name as namespace.
    gymnasium.register(
        id="Endoscope-v0",
        entry_point="pliant.gym:EndoscopeEnv",
        vector_entry_point="pliant.gym:EndoscopeVectorEnv",
    )
