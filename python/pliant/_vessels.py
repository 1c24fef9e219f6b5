# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Vessels with a guide and targets, for environments with catheters; public in pliant.gym."""

from __future__ import annotations

import dataclasses
import functools
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy

from pliant._core import (
    VesselEnd,
    VesselWall,
    Volume,
    lumen_of_region,
    make_vessel,
    phantom_centreline,
    read_surface,
    scan_of_vessel,
    swept_tube,
    wall_around_centreline,
    wall_around_surface,
)
from pliant._error import Error
from pliant._lumen_tree import LumenEnd, ends_of_paths, path_to

if TYPE_CHECKING:
    from typing import Unpack

    from pliant._settings import WallSettings

Vector = tuple[float, float, float]

_PHANTOMS = ("aorta", "bend", "arch")
_CONTRAST_HU = 200.0  # threshold of scan_of_vessel

# A wall that is quick: one layer of cells. Its thickness includes the tissue around the vessel.
_WALL: dict[str, Any] = {"thickness_mm": 2.5, "layers": 1, "cell_mm": 1.8}
_TUBE: dict[str, Any] = {"thickness_mm": 1.5, "layers": 1}


@dataclasses.dataclass(frozen=True)
class Vessel:
    """A vessel with a guide and targets.

    Attributes:
        wall: Its wall.
        scan: Seen in the pictures.
        entry: Where the guide ends [mm, LPS], and its direction.
        ends: The ends of its branches.
        settings: Of its catheter, changes of the defaults (settings_of("catheter")).
    """

    wall: VesselWall
    scan: Volume
    entry: tuple[Vector, Vector]
    ends: tuple[LumenEnd, ...]
    settings: dict[str, Any] = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True)
class _Made:
    """A wall with the other parts of its scene: a scan, a guide, settings of a catheter."""

    wall: VesselWall
    scan: Volume | None = None
    entry: int | None = None
    place: tuple[Vector, Vector] | None = None
    settings: dict[str, Any] = dataclasses.field(default_factory=dict)


def _at_end(end: VesselEnd, radii: float) -> tuple[Vector, Vector]:
    centre, outward = numpy.array(end.centre_mm), numpy.array(end.outward)
    x, y, z = (centre - radii * end.radius_mm * outward).tolist()
    u, v, w = (-outward).tolist()
    return (x, y, z), (u, v, w)


def _nearest(ends: Sequence[VesselEnd], point: Any) -> int:
    return int(numpy.argmin([numpy.linalg.norm(numpy.array(e.centre_mm) - point) for e in ends]))


def _phantom_wall(name: str, threads: int, wall: WallSettings) -> _Made:
    branches = phantom_centreline(name)
    if len(branches) == 1:
        made = swept_tube(branches[0], **{**_TUBE, **wall})
    else:
        made = wall_around_centreline(list(branches), threads, **{**_WALL, **wall})
    return _Made(made, entry=_nearest(made.ends, branches[0][0, :3]))


def _wall_of_file(path: str | os.PathLike[str], threads: int) -> _Made:
    made = make_vessel(path, threads)
    settings = dict(made.settings)
    x, y, z = settings.pop("place_mm")
    u, v, w = settings.pop("direction")
    return _Made(made.wall, made.scan, place=((x, y, z), (u, v, w)), settings=settings)


def _paths(made: VesselWall, contrast: Volume, start: Vector, entry: int, threads: int) -> Any:
    """Paths and radii from the guide to each other open end."""
    return [
        path_to(
            contrast, start, _at_end(end, 1.0)[0], _CONTRAST_HU, "falling", end.radius_mm, threads
        )
        for n, end in enumerate(made.ends)
        if n != entry
    ]


def find_vessel(
    scene: str | os.PathLike[str] | VesselWall | Volume = "aorta",
    entry: int | None = None,
    ends: Sequence[VesselEnd] = (),
    seed_mm: Sequence[float] | None = None,
    window_hu: tuple[float, float] | None = None,
    max_ml: float = 500.0,
    threads: int = 0,
    **wall: Unpack[WallSettings],
) -> Vessel:
    """Makes a vessel, and finds the paths from its guide to its other ends. Takes seconds.

    Args:
        scene: "aorta", "bend" or "arch" (phantoms); a scene file (.toml, docs/howto/vessel.md); a
            file of the lumen's surface, open at its ends; a wall; or a scan with contrast agent.
        entry: Number of the open end with the guide, of wall.ends; None: the phantom's or the
            file's, else the widest.
        ends: Cuts that open a closed surface, or a lumen that ends within a scan.
        seed_mm, window_hu, max_ml: Of a scan: a point in the lumen (LPS), the lumen's lowest and
            highest value, and the size from which it counts as a leak.
        wall: Of the wall, as of wall_around_surface.

    Raises:
        pliant.Error: There is no vessel, or it has fewer than two open ends.
    """
    if isinstance(scene, VesselWall):
        made = _Made(scene)
    elif isinstance(scene, Volume):
        if seed_mm is None or window_hu is None:
            raise Error("seed_mm: expected a point and a window_hu beside a scan", field="seed_mm")
        lumen = lumen_of_region(
            scene, seed_mm, window_hu[0], window_hu[1], max_ml=max_ml, threads=threads
        )
        cuts = [*lumen.ends, *ends]
        around = wall_around_surface(lumen.surface, cuts, threads, **{**_TUBE, **wall})
        made = _Made(around, scene)
    elif scene in _PHANTOMS:
        made = _phantom_wall(str(scene), threads, wall)
    elif os.fspath(scene).endswith(".toml"):
        made = _wall_of_file(scene, threads)
    else:
        made = _Made(wall_around_surface(read_surface(scene), ends, threads, **{**_TUBE, **wall}))
    openings = made.wall.ends
    if len(openings) < 2:
        raise Error(
            f"scene: expected a vessel with two open ends, found {len(openings)}; ends cut it open",
            field="scene",
        )
    place, at = made.place, made.entry if entry is None else entry
    if entry is not None or place is None:
        at = int(numpy.argmax([end.radius_mm for end in openings])) if at is None else at
        if not 0 <= at < len(openings):
            raise Error(f"entry: expected 0 to {len(openings) - 1}, found {at}", field="entry")
        place = _at_end(openings[at], 0.5)
    elif at is None:
        at = _nearest(openings, numpy.array(place[0]))
    contrast = scan_of_vessel(made.wall, threads)
    paths = _paths(made.wall, contrast, place[0], at, threads)
    seen = contrast if made.scan is None else made.scan
    return Vessel(made.wall, seen, place, tuple(ends_of_paths(paths)), made.settings)


@functools.lru_cache(maxsize=4)
def _phantom(name: str) -> Vessel:
    return find_vessel(name)


def vessel_from(scene: str | os.PathLike[str] | VesselWall | Volume | Vessel) -> Vessel:
    """The vessel of an environment's scene."""
    if isinstance(scene, Vessel):
        return scene
    if isinstance(scene, str) and scene in _PHANTOMS:
        return _phantom(scene)
    return find_vessel(scene)
