# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Endoscopy data with exact scene flow of moving tissue.

Example:
    >>> import pliant.scene_flow
    >>> sequence = pliant.scene_flow.EndoscopeSequence(scan, seed=1, frames=100)
    >>> pliant.scene_flow.write_sequence("airway_1", sequence)

An endoscope flies along a way in a lumen, a little beside it, and touches walls; other tools push
tissue in its view. Each frame has colour, depth, normals and labels, and the flow to the next
frame: the motion of the very tissue that each pixel shows, by the map that deforms the scan.
docs/howto/gym.md has the formats.
"""

from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import struct
import zlib
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

import numpy
import numpy.typing

from pliant._core import EndoscopeArena, Volume, find_endoscope, version
from pliant._error import Error
from pliant._lumen_tree import LumenEnd, find_lumen_ends

if TYPE_CHECKING:
    from typing import Unpack

    from pliant._settings import SequenceSettings

Array = numpy.typing.NDArray[Any]

DEPTH_UNITS_PER_MM = 100  # of a depth picture; 655.35 mm at most

_SPEED_MM_S = 12.0
_ASIDE_MM = 3.0  # of a way's points
_PUSH_EVERY = 6  # frames


@dataclasses.dataclass(frozen=True)
class Frame:
    """A picture of a sequence, with the flow to the next one.

    Attributes:
        number: From 0.
        rgb: sRGB (h, w, 3) uint8.
        depth_mm: Along the optical axis (h, w) float32; 0: no wall.
        normals: (h, w, 3) float32, in the camera's axes: right, down, ahead; 0: no wall.
        labels: Of the tissue behind the wall (h, w) int16; None without a label volume.
        flow: Pixels to the right and down (h, w, 2) float32, to where the tissue is in the next
            picture.
        visibility: (h, w) uint8: 0 no wall, and no flow; 1 seen in the next picture; 2 hidden
            there by other tissue; 3 outside of it.
        scene_flow_mm: Motion of the tissue to the next picture (h, w, 3) float32, LPS.
        camera: Pose and optics: "world_from_camera" (4 x 4, axes right, down, ahead, LPS mm),
            "field_of_view_deg" (of the height), "barrel_distortion"; and the pose of the next
            picture, "next_world_from_camera".
    """

    number: int
    rgb: Array
    depth_mm: Array
    normals: Array
    labels: Array | None
    flow: Array
    visibility: Array
    scene_flow_mm: Array
    camera: dict[str, Any]


def _pose_matrix(state: Array) -> Array:
    eye, look, up = state[0:3], state[3:6], state[6:9]
    matrix = numpy.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2] = numpy.cross(look, up), -up, look
    matrix[:3, 3] = eye
    return matrix


class EndoscopeSequence:
    """Frames of a flight, one after the other; the same bytes from the same seed.

    Args:
        scan: The scan.
        seed: Of the way and the pushes.
        frames: Their number.
        size: Width and height of pictures.
        frame_hz: Frames per second.
        ends: Where flights may lead (find_lumen_ends, or Lumen.ends); None: found, in seconds.
        labels: Label volume on the scan's grid.
        push_mm: Length of other tools' pushes, at most; 0: none.
        settings: Further arguments of pliant.EndoscopeArena: wall, is_smooth, field_stop, …

    Raises:
        pliant.Error: There is no lumen.
    """

    def __init__(
        self,
        scan: Volume,
        seed: int = 0,
        frames: int = 100,
        size: tuple[int, int] = (640, 480),
        frame_hz: float = 20.0,
        ends: Iterable[LumenEnd] | None = None,
        labels: Volume | None = None,
        push_mm: float = 3.0,
        threads: int = 0,
        **settings: Unpack[SequenceSettings],
    ) -> None:
        if frames < 1:
            raise Error(f"frames: expected 1 or more, found {frames}", field="frames")
        self.seed, self.frames, self.size, self.frame_hz = seed, frames, size, frame_hz
        self.push_mm = push_mm
        self._optics = {
            "field_of_view_deg": settings.setdefault("field_of_view_deg", 80.0),
            "barrel_distortion": settings.setdefault("barrel_distortion", 0.15),
        }
        if ends is None:
            iso_hu = settings.get("iso_hu", -500.0)
            view = find_endoscope(scan, iso_hu)
            if view is None:
                raise Error("scan: expected a lumen, found none", field="scan")
            ends = find_lumen_ends(scan, view.eye_mm, iso_hu, threads=threads)
        self._ends = list(ends)
        if not self._ends:
            raise Error("ends: expected some, found none", field="ends")
        self._arena = EndoscopeArena(
            scan, 1, size, frame_hz, pictures=("rgb", "depth", "normals", "flow"),
            labels=labels, threads=threads, **settings,
        )  # fmt: skip

    def __len__(self) -> int:
        return self.frames

    def __iter__(self) -> Iterator[Frame]:
        rng = numpy.random.default_rng(self.seed)
        arena = self._arena
        way = self._way(rng)
        ahead = way[4] - way[0]
        arena.place(0, way[0], ahead, rng.normal(0, 1, 3))
        arena.look()
        at = 0
        for number in range(self.frames):
            seen = {
                "rgb": arena.colour[0].copy(),
                "depth_mm": arena.depth_mm[0].copy(),
                "normals": arena.normals[0].copy(),
                "labels": None if arena.labels is None else arena.labels[0].copy(),
            }
            before = arena.states[0]
            if self.push_mm > 0 and number % _PUSH_EVERY == 0:
                self._push(rng, before, seen["depth_mm"])
            action, at = self._steer(rng, way, at, before)
            arena.step(action[None])
            camera = {
                "world_from_camera": _pose_matrix(before),
                "next_world_from_camera": _pose_matrix(arena.states[0]),
                **self._optics,
            }
            yield Frame(
                number, **seen, flow=arena.flow[0].copy(), visibility=arena.visibility[0].copy(),
                scene_flow_mm=arena.scene_flow_mm[0].copy(), camera=camera,
            )  # fmt: skip
            if at >= len(way) - 2:  # back to where it came from
                way, at = way[::-1], 0

    def _way(self, rng: numpy.random.Generator) -> Array:
        """A path, with smooth random offsets towards the walls."""
        end = self._ends[int(rng.integers(len(self._ends)))]
        path, room = end.path_mm, numpy.minimum(end.radius_mm, _ASIDE_MM)
        knots = rng.normal(0, 0.7, (len(path) // 8 + 3, 3))
        at = numpy.linspace(0, len(knots) - 1, len(path))
        aside = numpy.stack([numpy.interp(at, range(len(knots)), knots[:, a]) for a in range(3)], 1)
        aside[:2] = 0
        return numpy.asarray(path + numpy.clip(aside, -1, 1) * room[:, None])

    def _steer(
        self, rng: numpy.random.Generator, way: Array, at: int, state: Array
    ) -> tuple[Array, int]:
        eye, look, up = state[0:3], state[3:6], state[6:9]
        near = numpy.linalg.norm(way[at : at + 12] - eye, axis=1)
        at += int(numpy.argmin(near))
        aim = way[min(at + 6, len(way) - 1)] - eye
        aim = aim / max(float(numpy.linalg.norm(aim)), 1e-9)
        right = numpy.cross(look, up)
        turn = 3.0 * numpy.array([aim @ up, aim @ right])
        if aim @ look < 0:
            turn = numpy.array([0.0, 2.0])
        roll = rng.normal(0, 0.3)
        speed = _SPEED_MM_S * max(float(aim @ look), 0.0) ** 2
        return numpy.array([speed, roll, *numpy.clip(turn, -2, 2)]), at

    def _push(self, rng: numpy.random.Generator, state: Array, depth: Array) -> None:
        """Another tool pushes the wall in the middle of the picture outwards, or sideways."""
        eye, look = state[0:3], state[3:6]
        height, width = depth.shape
        far = float(depth[height // 2, width // 2])
        way = rng.normal(0, 1, 3) + 0.5 * look
        way *= self.push_mm * rng.uniform(0.3, 1) / max(float(numpy.linalg.norm(way)), 1e-9)
        radius = rng.uniform(2, 5)
        if not 0 < far < 40:
            return
        try:
            self._arena.push(0, eye + far * look, way, radius)
        except Error:
            pass  # bone, or onto the eye


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(
        ">I", zlib.crc32(kind + data)
    )  # fmt: skip


def write_picture(path: str | os.PathLike[str], values: Array) -> None:
    """Writes a PNG: (h, w, 3) uint8 in colour, (h, w) uint8 or uint16 in grey. The same bytes for
    the same values and zlib."""
    colour = values.ndim == 3
    deep = values.dtype == numpy.uint16
    if not deep and values.dtype != numpy.uint8:
        raise Error(f"values: expected uint8 or uint16, found {values.dtype}", field="values")
    height, width = values.shape[:2]
    rows = values.astype(">u2" if deep else "u1").reshape(height, -1).view(numpy.uint8)
    rows = numpy.concatenate([numpy.zeros((height, 1), numpy.uint8), rows], axis=1)
    header = struct.pack(">IIBBBBB", width, height, 16 if deep else 8, 2 if colour else 0, 0, 0, 0)
    pathlib.Path(path).write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + _chunk(b"IHDR", header)
        + _chunk(b"IDAT", zlib.compress(rows.tobytes(), 1))
        + _chunk(b"IEND", b"")
    )


def write_flow(path: str | os.PathLike[str], flow: Array) -> None:
    """Writes Middlebury's .flo: 32-bit floats, u and v by turns."""
    height, width = flow.shape[:2]
    head = b"PIEH" + struct.pack("<ii", width, height)
    pathlib.Path(path).write_bytes(head + flow.astype("<f4").tobytes())


def read_flow(path: str | os.PathLike[str]) -> Array:
    """Reads Middlebury's .flo.

    Raises:
        pliant.Error: It is something else.
    """
    data = pathlib.Path(path).read_bytes()
    width, height = struct.unpack("<ii", data[4:12]) if len(data) >= 12 else (0, 0)
    if data[:4] != b"PIEH" or len(data) != 12 + 8 * width * height:
        raise Error(f"{path}: expected a .flo file", "unreadable")
    return numpy.frombuffer(data, "<f4", offset=12).reshape(height, width, 2)


def write_sequence(folder: str | os.PathLike[str], sequence: EndoscopeSequence) -> None:
    """Writes the frames into a folder, which is made: rgb/, depth/, normals/, flow/, visibility/,
    scene_flow/, labels/, cameras.json. docs/howto/gym.md has the formats."""
    root = pathlib.Path(folder)
    kinds = ["rgb", "depth", "normals", "flow", "visibility", "scene_flow"]
    for kind in kinds:
        (root / kind).mkdir(parents=True, exist_ok=True)
    cameras = []
    for frame in sequence:
        name = f"{frame.number:06d}"
        write_picture(root / f"rgb/{name}.png", frame.rgb)
        units = numpy.rint(frame.depth_mm.astype(float) * DEPTH_UNITS_PER_MM)
        write_picture(
            root / f"depth/{name}.png", numpy.minimum(units, 65535).astype(numpy.uint16)
        )
        numpy.save(root / f"normals/{name}.npy", frame.normals.astype(numpy.float16))
        write_flow(root / f"flow/{name}.flo", frame.flow)
        write_picture(root / f"visibility/{name}.png", frame.visibility)
        numpy.save(root / f"scene_flow/{name}.npy", frame.scene_flow_mm)
        if frame.labels is not None:
            (root / "labels").mkdir(exist_ok=True)
            write_picture(root / f"labels/{name}.png", frame.labels.astype(numpy.uint16))
        cameras.append(
            {
                k: v.round(9).tolist() if isinstance(v, numpy.ndarray) else v
                for k, v in frame.camera.items()
            }
        )
    (root / "cameras.json").write_text(
        json.dumps(
            {
                "pliant": version,
                "seed": sequence.seed,
                "size": list(sequence.size),
                "frame_hz": sequence.frame_hz,
                "depth_units_per_mm": DEPTH_UNITS_PER_MM,
                "frames": cameras,
            },
            indent=1,
        )
        + "\n"
    )
