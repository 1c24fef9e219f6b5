# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Draws the module's icon: a sphere that pushes the lines of a grid. Writes Pliant.png.

    python3 make_icon.py
"""

import pathlib
import struct
import zlib

import numpy

SIZE, LINES, DEPTH, WIDTH = 128, 8, 30.0, 38.0  # pixels
TISSUE, LINE, TOOL = (226, 150, 120), (120, 50, 40), (60, 70, 90)


def picture():
    """RGBA, four samples a pixel along each axis."""
    y, x = (numpy.mgrid[: 4 * SIZE, : 4 * SIZE] + 0.5) / 4
    push = DEPTH * numpy.exp(-(((x - SIZE / 2) / WIDTH) ** 2))
    rest = y - push * numpy.clip((SIZE - y) / (SIZE - 44 - push), 0, 1)  # the row at rest
    rgba = numpy.zeros((*x.shape, 4))
    tissue = rest > 44
    rgba[tissue] = (*TISSUE, 255)
    step = SIZE / LINES
    near = (numpy.abs(rest % step - step / 2) < 1.2) | (numpy.abs(x % step - step / 2) < 1.2)
    rgba[tissue & near] = (*LINE, 255)
    rgba[(x - SIZE / 2) ** 2 + (y - 44) ** 2 < 28**2] = (*TOOL, 255)
    rgba = rgba.reshape(SIZE, 4, SIZE, 4, 4).mean((1, 3))
    cover = rgba[..., 3:] / 255
    rgba[..., :3] = rgba[..., :3] / numpy.maximum(cover, 1e-9)
    return numpy.rint(rgba).clip(0, 255).astype(numpy.uint8)


def png(rgba):
    """The bytes of a PNG file."""

    def chunk(name, data):
        check = zlib.crc32(name + data)
        return struct.pack("!I", len(data)) + name + data + struct.pack("!I", check)

    head = struct.pack("!IIBBBBB", rgba.shape[1], rgba.shape[0], 8, 6, 0, 0, 0)
    rows = b"".join(b"\0" + row.tobytes() for row in rgba)
    parts = chunk(b"IHDR", head), chunk(b"IDAT", zlib.compress(rows, 9)), chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


if __name__ == "__main__":
    folder = pathlib.Path(__file__).parent / "Pliant" / "Resources" / "Icons"
    (folder / "Pliant.png").write_bytes(png(picture()))
