# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Real-time soft tissue on medical scans.

Example:
    >>> import pliant
    >>> scan = pliant.read_volume("ct.nrrd")
    >>> tissue = pliant.make_chainmail(scan)
    >>> tissue.push((-13.5, 116, -421), (6, 0, 0), sphere_radius_mm=5)
    >>> tissue.volume().save("pushed.nrrd")

Arrays are (k, j, i), as SimpleITK's; points and vectors are LPS millimetres.
"""

from pliant._core import (
    AdvanceReport,
    CarveReport,
    CutReport,
    EndoscopeArena,
    Field,
    PushReport,
    SlideReport,
    TetMesh,
    Tissue,
    Volume,
    find_endoscope,
    find_lumen_path,
    make_body,
    make_chainmail,
    make_phantom,
    make_springs,
    read_field,
    read_tetrahedra,
    read_volume,
    settings_of,
)
from pliant._core import version as __version__
from pliant._error import Error
from pliant._show import Page, program, show

__all__ = [
    "AdvanceReport",
    "CarveReport",
    "CutReport",
    "EndoscopeArena",
    "Error",
    "Field",
    "Page",
    "PushReport",
    "SlideReport",
    "TetMesh",
    "Tissue",
    "Volume",
    "__version__",
    "find_endoscope",
    "find_lumen_path",
    "make_body",
    "make_chainmail",
    "make_phantom",
    "make_springs",
    "program",
    "read_field",
    "read_tetrahedra",
    "read_volume",
    "settings_of",
    "show",
]
