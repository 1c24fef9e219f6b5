# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A slice of a scan before and after an augmentation, with its labels and its lattice.

python augment_picture.py augment.png
"""

import struct
import sys
import zlib
from typing import Any

import numpy

import pliant
from pliant.augment import TissueMotions

SCALE = 3


def write_png(path: str, rgb: Any) -> None:
    rows = b"".join(b"\0" + row.tobytes() for row in rgb)
    size = struct.pack(">IIBBBBB", rgb.shape[1], rgb.shape[0], 8, 2, 0, 0, 0)

    def chunk(name: bytes, data: bytes) -> bytes:
        check = zlib.crc32(name + data)
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", check)

    parts = (b"IHDR", size), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b"")
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*part) for part in parts))


def grey(slice_hu: Any) -> Any:
    level = numpy.clip((slice_hu + 1000.0) / 1500.0, 0, 1)
    return numpy.repeat(numpy.uint8(255 * level)[..., None], 3, axis=-1)


def enlarged(image: Any) -> Any:
    return image.repeat(SCALE, 0).repeat(SCALE, 1)


def outlined(image: Any, labels: Any, colours: dict[int, tuple[int, int, int]]) -> Any:
    image, labels = enlarged(image).copy(), enlarged(labels)
    for label, colour in colours.items():
        inside = labels == label
        edge = inside & ~(
            numpy.roll(inside, 1, 0)
            & numpy.roll(inside, -1, 0)
            & numpy.roll(inside, 1, 1)
            & numpy.roll(inside, -1, 1)
        )
        image[edge] = colour
    return image


def with_lattice(image: Any, rows: Any, columns: Any) -> Any:
    """Lines where the position at rest crosses a multiple of eight voxels."""
    image = enlarged(image).copy()
    height, width = rows.shape
    y = numpy.minimum(numpy.arange(height * SCALE) / SCALE, height - 1.001)
    x = numpy.minimum(numpy.arange(width * SCALE) / SCALE, width - 1.001)
    j, i = y.astype(int), x.astype(int)
    v, u = (y - j)[:, None], (x - i)[None, :]
    for at in (rows, columns):
        fine = (1 - v) * ((1 - u) * at[j][:, i] + u * at[j][:, i + 1])
        fine += v * ((1 - u) * at[j + 1][:, i] + u * at[j + 1][:, i + 1])
        cell = numpy.floor(fine / 8)
        image[(cell != numpy.roll(cell, 1, 0)) | (cell != numpy.roll(cell, 1, 1))] = (255, 210, 80)
    return image


def main(path: str) -> None:
    scan = pliant.make_phantom("airway", (128, 128, 128))
    array = scan.array
    labels = (array > -300).astype(numpy.uint8) + (array > 250)
    motions = TissueMotions(
        pushes=4,
        push_mm=(8, 14),
        tool_mm=(5, 10),
        swellings=1,
        swelling_mm=4,
        breathing=1,
        at="wall",
    )
    moved = motions(scan, numpy.random.default_rng(6), labels=labels)
    length = numpy.linalg.norm(moved.forward.array, axis=-1)
    k = int(length.max(axis=(1, 2))[16:-16].argmax()) + 16
    back = moved.inverse.array[k] / scan.spacing_mm[0]
    j, i = numpy.mgrid[: array.shape[1], : array.shape[2]].astype(float)
    colours = {1: (90, 220, 120), 2: (255, 80, 80)}
    panels = [
        outlined(grey(array[k]), labels[k], colours),
        outlined(grey(moved.image.array[k]), moved.labels[k], colours),
        with_lattice(grey(moved.image.array[k]), j + back[..., 1], i + back[..., 0]),
    ]
    gap = numpy.full((panels[0].shape[0], 6, 3), 255, numpy.uint8)
    write_png(path, numpy.concatenate([panels[0], gap, panels[1], gap, panels[2]], axis=1))
    print(
        f"{path}: smallest Jacobian {moved.smallest_jacobian:.2f}, largest motion "
        f"{length.max():.1f} mm, bone {length[array > 300].max():.3f} mm"
    )


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else "augment.png")
