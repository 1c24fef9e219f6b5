# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""pliant.augment beside TorchIO, MONAI and elasticdeform: a scan of 128 x 128 x 128, its label map,
50 landmarks; one thread; medians of interleaved runs, as wall-clock time and as processor time.

    python augment.py --rounds 15

The preset "elastic" moves as much as the others do; Pliant's pushes move about a tenth of the
voxels. The others move no landmarks. Packages that are missing are left out.
"""

import argparse
import importlib.metadata
import json
import os
import statistics
import time
from collections.abc import Callable
from typing import Any

for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "ITK_GLOBAL_DEFAULT_NUMBER_OF_THREADS"):
    os.environ[name] = "1"

import numpy

import pliant
from pliant.augment import Plan, TissueMotions

N = 128


def plans_of(
    motions: TissueMotions, scan: pliant.Volume, rng: numpy.random.Generator, share: float
) -> list[Plan]:
    """Plans that move about this share of the voxels."""
    prepared = motions.prepare(scan)
    plans: list[Plan] = []
    while len(plans) < 8:
        plan = motions.sample(prepared, rng)
        moved = motions.apply(prepared, plan).warp.moved_voxels / scan.array.size
        if 0.85 * share < moved < 1.15 * share:
            plans.append(plan)
    return plans


def pliant_cases(scan: pliant.Volume, labels: Any, points: Any, rng: Any) -> dict[str, Any]:
    # Two pushes of large tools, of tissue whose motion reaches far.
    motions = TissueMotions(pushes=2, tool_mm=(12, 20), push_mm=(4, 8), offset=0.2)
    plans = plans_of(motions, scan, rng, 0.1)
    prepared = motions.prepare(scan)
    shares = [motions.apply(prepared, p).warp.moved_voxels / scan.array.size for p in plans]
    print(f"share of moved voxels: {min(shares):.3f}...{max(shares):.3f}")
    numbers = iter(range(10**9))

    def applied(target: Any) -> None:
        motions.apply(target, plans[next(numbers) % len(plans)], labels=labels, points=points)

    def drawn() -> None:
        motions.sample(scan, numpy.random.default_rng(next(numbers)))

    elastic = TissueMotions(preset="elastic")
    waves = [elastic.sample(scan, rng) for _ in range(4)]
    shares = [elastic.apply(scan, p).warp.moved_voxels / scan.array.size for p in waves]
    print(f"share of moved voxels, elastic: {min(shares):.3f}...{max(shares):.3f}")

    def stretched() -> None:
        plan = waves[next(numbers) % len(waves)]
        elastic.apply(scan, plan, labels=labels, points=points)

    return {
        "pliant, preset elastic, with preparation": stretched,
        "pliant, scan prepared before": lambda: applied(prepared),
        "pliant, with preparation": lambda: applied(scan),
        "pliant, drawing a plan alone": drawn,
    }


def monai_skin(scan: pliant.Volume, labels: Any, points: Any, rng: Any) -> dict[str, Any]:
    """The way of most users: MONAI's dictionary transform, with drawing and preparation."""
    import torch
    from monai.data import MetaTensor

    from pliant.augment.monai import RandTissueMotiond

    motion = RandTissueMotiond(
        ["image", "label"],
        mode=("bilinear", "nearest"),
        prob=1.0,
        pushes=2,
        tool_mm=(12, 20),
        push_mm=(4, 8),
        offset=0.2,
    ).set_random_state(1)
    item = {
        "image": MetaTensor(torch.as_tensor(scan.array[None].astype(numpy.float32))),
        "label": MetaTensor(torch.as_tensor(labels[None])),
    }
    return {"pliant's RandTissueMotiond, whole": lambda: motion(item)}


def torchio_case(scan: pliant.Volume, labels: Any, points: Any, rng: Any) -> dict[str, Any]:
    import torch
    import torchio

    torch.set_num_threads(1)
    image = torch.as_tensor(scan.array[None].astype(numpy.float32))
    subject = torchio.Subject(
        ct=torchio.ScalarImage(tensor=image), organs=torchio.LabelMap(tensor=labels[None])
    )
    elastic = torchio.RandomElasticDeformation(copy=False)
    return {"TorchIO RandomElasticDeformation": lambda: elastic(subject)}


def monai_case(scan: pliant.Volume, labels: Any, points: Any, rng: Any) -> dict[str, Any]:
    import torch
    from monai.transforms import Rand3DElasticd

    torch.set_num_threads(1)
    item = {
        "image": torch.as_tensor(scan.array[None].astype(numpy.float32)),
        "label": torch.as_tensor(labels[None]).float(),
    }
    elastic = Rand3DElasticd(
        ["image", "label"], (5, 8), (100, 300), prob=1.0, mode=("bilinear", "nearest")
    )
    return {"MONAI Rand3DElasticd": lambda: elastic(item)}


def elasticdeform_case(scan: pliant.Volume, labels: Any, points: Any, rng: Any) -> dict[str, Any]:
    import elasticdeform

    image = scan.array.astype(numpy.float32)

    def deformed() -> None:
        elasticdeform.deform_random_grid([image, labels], sigma=3, points=5, order=[1, 0])

    return {"elasticdeform": deformed}


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    rng = numpy.random.default_rng(given.seed)
    scan = pliant.make_phantom("knee", (N, N, N), (1, 1, 1), threads=1)
    labels = (scan.array > -300).astype(numpy.uint8) + (scan.array > 250)
    points = [scan.world_from_voxel(p) for p in rng.uniform(0, N - 1, (50, 3))]
    cases: dict[str, Callable[[], Any]] = {}
    for make in (pliant_cases, monai_skin, torchio_case, monai_case, elasticdeform_case):
        try:
            cases |= make(scan, labels, points, rng)
        except ImportError as error:
            print(f"left out: {error}")
    for package in ("pliant", "torchio", "monai", "elasticdeform", "torch"):
        try:
            print(package, importlib.metadata.version(package))
        except importlib.metadata.PackageNotFoundError:
            print(package, "without metadata")
    wall: dict[str, list[float]] = {name: [] for name in cases}
    processor: dict[str, list[float]] = {name: [] for name in cases}
    for turn in range(given.rounds + 1):
        for name, case in cases.items():
            begin, begin_processor = time.perf_counter(), time.process_time()
            case()
            end, end_processor = time.perf_counter(), time.process_time()
            if turn > 0:  # the first warms up
                wall[name].append(1e3 * (end - begin))
                processor[name].append(1e3 * (end_processor - begin_processor))
    medians = {
        name: (statistics.median(wall[name]), statistics.median(processor[name])) for name in cases
    }
    if given.json:
        print(json.dumps(medians))
        return
    base = medians["pliant, with preparation"][1]
    print("median wall-clock time, its range, median processor time, ratio of the latter")
    for name, (median, used) in medians.items():
        low, high = min(wall[name]), max(wall[name])
        print(
            f"{name:36} {median:8.1f} ms ({low:.1f}...{high:.1f}) {used:8.1f} {used / base:6.1f} x"
        )


if __name__ == "__main__":
    main()
