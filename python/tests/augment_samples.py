# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Many random samples of pliant.augment, each checked: folds, bone, landmarks, image and label.

python augment_samples.py --count 10000 --size 48
"""

import argparse
import json
import time
from typing import Any

import numpy

import pliant
from pliant.augment import TissueMotions

ALL = {
    "pushes": (0, 3),
    "pulls": (0, 2),
    "slides": (0, 1),
    "swellings": (0, 1),
    "breathing": 0.3,
}


def ramps(scan: pliant.Volume) -> numpy.ndarray:
    """The index k, j, i of each voxel, and 1, as an image of four channels."""
    axes = [numpy.arange(n, dtype=numpy.float32) for n in scan.array.shape]
    return numpy.stack([*numpy.meshgrid(*axes, indexing="ij"), numpy.ones(scan.array.shape, "f4")])


def bone_of(scan: pliant.Volume, threshold_hu: float) -> numpy.ndarray:
    """Face-connected pieces above the threshold of at least 100 mm³, or at the scan's border."""
    above = scan.array > threshold_hu
    labels = numpy.where(above, numpy.arange(1, above.size + 1).reshape(above.shape), 0)
    before = numpy.zeros_like(labels)
    while (labels != before).any():  # the largest number of a piece spreads over it
        before = labels.copy()
        for axis in range(3):
            rows = numpy.moveaxis(labels, axis, 0)
            rows[1:] = numpy.maximum(rows[1:], rows[:-1])
            rows[:-1] = numpy.maximum(rows[:-1], rows[1:])
            labels[~above] = 0
    _, pieces = numpy.unique(labels, return_inverse=True)
    pieces = pieces.reshape(labels.shape)
    stays = numpy.bincount(pieces.ravel()) * numpy.prod(scan.spacing_mm) >= 100
    for axis in range(3):
        stays[numpy.unique(pieces.take([0, -1], axis))] = True
    stays[pieces[~above]] = False
    return stays[pieces]


def check(
    scan: pliant.Volume, motions: TissueMotions, rng: numpy.random.Generator
) -> dict[str, Any]:
    """Measures one sample; asserts nothing."""
    size = numpy.array(scan.size)
    points = numpy.array([scan.world_from_voxel(p) for p in rng.uniform(0, size - 1, (50, 3))])
    ramp = ramps(scan)
    labels = ramp[:3].astype(numpy.int16)
    moved = motions(scan, rng, labels=labels, images=ramp, points=points)
    back = moved.warp.unwarp_points(moved.points)
    voxel = numpy.array(scan.spacing_mm)
    apart = (back - points) @ numpy.array(scan.direction) / voxel
    # Voxel centres of the moved scan, through the inverse field and forward again.
    ijk = rng.integers(0, size, (200, 3))
    centres = numpy.array([scan.world_from_voxel(p) for p in ijk.astype(float)])
    sources = centres + moved.inverse.array[tuple(ijk[:, ::-1].T)]
    there = (moved.warp.warp_points(sources) - centres) @ numpy.array(scan.direction) / voxel
    # The label is the rounded ramp, except between two voxels and where the scan ends.
    found, inside = moved.images[:3], moved.images[3] > 0.999999
    clear = inside & (numpy.abs(found % 1 - 0.5) > 1e-3).all(0)
    wrong = (numpy.rint(found) != moved.labels)[:, clear]
    bone = bone_of(scan, 300 if motions.bone_hu is None else motions.bone_hu)
    forward = moved.forward.array
    return {
        "smallest_jacobian": moved.smallest_jacobian,
        "bone_mm": float(numpy.abs(forward[bone]).max()) if bone.any() else 0.0,
        "landmarks_voxel": float(numpy.abs(apart).max()),
        "inverse_voxel": float(numpy.abs(there).max()),
        "wrong_labels": int(wrong.sum()),
        "labels": int(clear.sum()) * 3,
        "moved_share": moved.warp.moved_voxels / scan.array.size,
        "largest_mm": float(numpy.linalg.norm(forward, axis=-1).max()),
        "motions": len(moved.report),
        "fractions": [one["fraction"] for one in moved.report],
    }


def random_scan(rng: numpy.random.Generator, size: int) -> pliant.Volume:
    """A phantom, or random tissue with bone and air in it, on an oblique grid."""
    names = ("airway", "sinus", "vessel", "knee", "layers", "random")
    name = names[rng.integers(len(names))]
    direction, _ = numpy.linalg.qr(rng.normal(size=(3, 3)))
    spacing = tuple(rng.uniform(0.7, 3.0, 3))
    if name != "random":
        array = pliant.make_phantom(name, (size, size, size)).array
    else:
        coarse = rng.normal(size=(size // 8 + 2,) * 3)
        at = numpy.arange(size) / 8
        low = at.astype(int)
        part = at - low
        for axis in range(3):
            shape = [1, 1, 1]
            shape[axis] = size
            w = part.reshape(shape)
            coarse = (1 - w) * coarse.take(low, axis) + w * coarse.take(low + 1, axis)
        array = (600 * coarse - 100).astype(numpy.int16)
    return pliant.Volume(array, spacing, rng.normal(size=3) * 50, direction, background=-1000)


def random_motions(rng: numpy.random.Generator) -> TissueMotions:
    settings: dict[str, Any] = dict(ALL)
    settings["at"] = ("soft", "wall")[rng.integers(2)]
    settings["offset"] = float(rng.uniform(0.1, 0.33))
    settings["slide_mm"] = (2, 6)
    return TissueMotions(**settings)


def worst_of(count: int, rng: numpy.random.Generator, size: int) -> dict[str, Any]:
    """The worst of many samples on random scans."""
    worst: dict[str, Any] = {
        "samples": count,
        "motions": 0,
        "smallest_jacobian": 1.0,
        "above_bound": float("inf"),
        "bone_mm": 0.0,
        "landmarks_voxel": 0.0,
        "inverse_voxel": 0.0,
        "wrong_labels": 0,
    }
    shares, lengths, fractions = [], [], []
    for _ in range(count):
        scan, motions = random_scan(rng, size), random_motions(rng)
        found = check(scan, motions, rng)
        worst["smallest_jacobian"] = min(worst["smallest_jacobian"], found["smallest_jacobian"])
        worst["above_bound"] = min(
            worst["above_bound"], found["smallest_jacobian"] - (1 - 3 * motions.offset)
        )
        for name in ("bone_mm", "landmarks_voxel", "inverse_voxel", "wrong_labels"):
            worst[name] = max(worst[name], found[name])
        worst["motions"] += found["motions"]
        shares.append(found["moved_share"])
        lengths.append(found["largest_mm"])
        fractions += found["fractions"]
    worst["median_moved_share"] = float(numpy.median(shares))
    worst["median_largest_mm"] = float(numpy.median(lengths))
    worst["mean_fraction"] = float(numpy.mean(fractions)) if fractions else None
    return worst


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--size", type=int, default=48, help="voxels along each axis")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    begin = time.perf_counter()
    result = worst_of(given.count, numpy.random.default_rng(given.seed), given.size)
    result |= {"size": given.size, "seed": given.seed, "seconds": time.perf_counter() - begin}
    print(json.dumps(result, indent=1))
