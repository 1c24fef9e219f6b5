# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A scan in the server: Slicer's RAS and arrays on one side, the protocol's LPS on the other.

Arrays are (k, j, i), positions and vectors RAS millimetres, as Slicer has them.
"""

import collections
import gzip
import os
import shutil
import tempfile

import numpy

from PliantLib.client import Client, ConnectionEnded, PliantError
from PliantLib.server import Server

FLIP = numpy.array([-1.0, -1.0, 1.0])  # RAS from LPS, and LPS from RAS
MAX_CUT_POINTS = 1000
MIN_STEP_MM = 0.05  # of a tracked tool
NRRD_TYPES = {
    "int8": "int8", "uint8": "uint8", "int16": "int16", "uint16": "uint16", "int32": "int32",
    "uint32": "uint32", "int64": "int64", "uint64": "uint64", "float32": "float",
    "float64": "double",
}  # fmt: skip
READ_TYPES = {"short": "<i2", "float": "<f4"}  # those that Pliant writes

# Vectors (k, j, i, 3) on a grid; the columns of directions are its axes i, j, k.
Grid = collections.namedtuple("Grid", "origin spacing directions vectors")


def lps(vector):
    """LPS from RAS, as the list of a message."""
    return [float(value) for value in numpy.asarray(vector, float) * FLIP]


def write_nrrd(path, voxels, ijk_to_ras):
    """Writes a scan in LPS, values to the bit. Raises PliantError."""
    kind = NRRD_TYPES.get(voxels.dtype.name)
    if kind is None or voxels.ndim != 3:
        raise PliantError(
            "expected a scalar volume of whole numbers or floats, found "
            f"{voxels.dtype.name} of shape {voxels.shape}"
        )
    matrix = numpy.asarray(ijk_to_ras, float)[:3] * FLIP[:, None]
    columns = ["(" + ",".join(repr(float(v)) for v in matrix[:, a]) + ")" for a in range(4)]
    head = (
        f"NRRD0004\ntype: {kind}\ndimension: 3\nspace: left-posterior-superior\n"
        f"sizes: {' '.join(str(n) for n in voxels.shape[::-1])}\n"
        f"space directions: {' '.join(columns[:3])}\nkinds: domain domain domain\n"
        f"endian: little\nencoding: raw\nspace origin: {columns[3]}\n\n"
    )
    try:
        with open(path, "wb") as file:
            file.write(head.encode())
            file.write(voxels.astype(voxels.dtype.newbyteorder("<"), copy=False).tobytes())
    except OSError as error:
        raise PliantError(f"{path}: {error.strerror}") from error


def read_nrrd(data):
    """The keys and the array of a file that Pliant has written: (k, j, i) or (k, j, i, 3)."""
    head, _, body = data.partition(b"\n\n")
    keys = {}
    for line in head.decode("utf-8", "replace").splitlines()[1:]:
        name, _, value = line.partition(": " if ": " in line.split(":=")[0] else ":=")
        keys[name] = value
    try:
        sizes = [int(n) for n in keys["sizes"].split()]
        raw = gzip.decompress(body) if keys["encoding"] == "gzip" else body
        return keys, numpy.frombuffer(raw, READ_TYPES[keys["type"]]).reshape(sizes[::-1])
    except (KeyError, ValueError, OSError, EOFError) as error:
        raise PliantError(f"expected a file that Pliant has written: {error}") from error


def grid_of_field(data):
    """A displacement field of Pliant (NRRD, LPS) as a grid in RAS, without still borders.

    Beyond its border a grid transform repeats the border's vectors. So the grid is cropped to the
    moved voxels and one more on each side, if the scan has one there.
    """
    keys, field = read_nrrd(data)
    axes = [
        numpy.array([float(v) for v in column.strip("()").split(",")]) * FLIP
        for column in keys["space directions"].split()[1:]
    ]
    origin = numpy.array([float(v) for v in keys["space origin"].strip("()").split(",")]) * FLIP
    spacing = numpy.array([numpy.linalg.norm(axis) for axis in axes])
    moved = field.any(axis=3)
    where = []
    for a in (2, 1, 0):  # i, j, k
        along = numpy.flatnonzero(moved.any(axis=tuple(b for b in range(3) if b != a)))
        first, last = (along[0], along[-1]) if along.size else (0, 0)
        where.append(slice(max(0, first - 1), min(field.shape[a], last + 2)))
    origin = origin + sum(where[a].start * axes[a] for a in range(3))
    vectors = field[where[2], where[1], where[0]] * FLIP
    return Grid(origin, spacing, numpy.stack(axes, axis=1) / spacing, vectors)


def as_type(values, dtype):
    """Voxels of a volume's type, rounded to whole numbers where it has these."""
    if dtype.kind == "f":
        return values.astype(dtype)
    limits = numpy.iinfo(dtype)
    return numpy.clip(numpy.rint(values.astype(float)), limits.min, limits.max).astype(dtype)


class Session:
    """One scan in a server of its own."""

    def __init__(self, program, voxels, ijk_to_ras, model="auto", environment=None):
        """Hands the scan over and connects. Raises PliantError."""
        self._folder = tempfile.mkdtemp(prefix="pliant-slicer-")  # readable by the user alone
        self.server = self.client = None
        self._ijk_from_ras = numpy.linalg.inv(numpy.asarray(ijk_to_ras, float))
        try:
            path = os.path.join(self._folder, "scan.nrrd")
            write_nrrd(path, voxels, ijk_to_ras)
            self.server = Server(program, [path, "--model", model], environment)
            self.client = Client(self.server.link)
        except BaseException:
            self.stop()
            raise

    def stop(self):
        """Ends the server and deletes the scan's file."""
        if self.client:
            self.client.close()
        if self.server:
            self.server.stop()
        shutil.rmtree(self._folder, ignore_errors=True)

    def trouble(self):
        """One line if the session has ended by itself, else None."""
        if self.client.ended is None:
            return None
        return f"{self.server.reason() or self.client.ended}. The volume keeps its last state."

    def takes(self, command):
        """Whether the present tissue takes push, slide, cut or carve."""
        return command in self.client.state.get("tissue", {}).get("takes", [])

    def send(self, do, **fields):
        """Posts a command. Raises PliantError with one line once the session has ended."""
        try:
            return self.client.send(do, **fields)
        except ConnectionEnded as error:
            raise PliantError(self.trouble() or str(error)) from error

    def push(self, start, end, radius_mm, **more):
        """Moves the tissue in the sphere around start to end; its number."""
        vector = lps(numpy.subtract(end, start))
        return self.send("push", point=lps(start), push=vector, radius=radius_mm, **more)

    def cut(self, points, normal, depth_mm):
        """Cuts along a line of points, depth_mm along the normal, half of it on each side."""
        points, normal = numpy.asarray(points, float), numpy.asarray(normal, float)
        if len(points) < 2:
            raise PliantError(f"cut: expected two points or more, found {len(points)}")
        if len(points) > MAX_CUT_POINTS:
            rows = numpy.linspace(0, len(points) - 1, MAX_CUT_POINTS).round().astype(int)
            points = points[rows]
        depth = normal / numpy.linalg.norm(normal) * depth_mm
        return self.send("cut", line=[lps(p) for p in points - depth / 2], depth=lps(depth))

    def update(self, original, target):
        """Writes the changed box into target, the volume's array; whether there was one.

        Voxels come as half floats: exact up to 2048 for whole numbers, in steps of 2 up to 4096, of
        4 up to 8192. A voxel that equals the original scan's as a half gets the original value, so
        undo and reset give the original to the bit; elsewhere the error is at most a step.
        """
        self.client.let_read()
        change = self.client.take_changes()
        if change is None:
            return False
        where, box = change
        changed = box.view(numpy.uint16) != self.client.rest[where].view(numpy.uint16)
        values = original[where].astype(target.dtype)
        values[changed] = as_type(box[changed], target.dtype)
        target[where] = values
        return True

    def exact(self, original, target):
        """Writes the deformed scan into target with the values of `pliant deform`."""
        _, voxels = read_nrrd(self.client.save("volume.nrrd"))
        if voxels.shape != target.shape:
            raise PliantError(f"expected a volume of {target.shape}, found {voxels.shape}")
        still = original.astype(voxels.dtype) == voxels
        target[...] = numpy.where(still, original, as_type(voxels, target.dtype))

    def inverse_field(self):
        """From each point of the deformed scan to the point at rest that is shown there."""
        return grid_of_field(self.client.save("transform.nrrd"))

    def forward_field(self):
        """From each point at rest to its present position."""
        return grid_of_field(self.client.save("displacement.nrrd"))

    def contains(self, position):
        """Whether the scan has this position."""
        ijk = (self._ijk_from_ras @ numpy.append(position, 1.0))[:3]
        return bool(numpy.all(ijk >= -0.5) and numpy.all(ijk <= self._last_voxel() + 0.5))

    def _last_voxel(self):
        return numpy.array(self.client.volume["size"]) - 1


class TrackedTool:
    """A sphere that follows a tracked position; one stroke, hence one step of undo.

    Tissue slides off it, or with tissues that take no slides moves with it. One command is on its
    way at a time, and the next one goes to the newest position. After a limited one the sphere is
    where the tissue has held it.
    """

    def __init__(self, session, radius_mm, stroke):
        self._session, self._radius, self._stroke = session, radius_mm, stroke
        self._at = self._aim = self._wish = self._number = None

    def move(self, position):
        """Follows to a new position."""
        self._wish = numpy.array(position, float)
        self._go_on()

    def take(self, answer):
        """Takes an answer, of any command."""
        if answer["id"] != self._number:
            return
        self._number = None
        if "end" in answer:
            self._at = numpy.array(answer["end"], float) * FLIP
        elif answer["t"] == "done":
            self._at = self._at + (self._aim - self._at) * answer.get("step_fraction", 1.0)
        else:
            self._at = None  # begins anew
        self._go_on()

    def _go_on(self):
        wish, self._wish = self._wish, None
        if wish is None or self._number is not None:
            self._wish = wish
        elif self._at is None or not self._session.contains(wish):
            self._at = wish if self._session.contains(wish) else None
        elif numpy.linalg.norm(wish - self._at) >= MIN_STEP_MM:
            self._aim = wish
            self._number = self._session.send(
                "slide" if self._session.takes("slide") else "push",
                point=lps(self._at), push=lps(wish - self._at), radius=self._radius,
                stroke=self._stroke,
            )  # fmt: skip

    def stop(self):
        """Takes the sphere away."""
        self._session.send("release")
