# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""pliant.augment beside TorchIO, MONAI and elasticdeform: a scan of 128 x 128 x 128, its label map,
50 landmarks; one thread; medians of interleaved runs, as wall-clock time and as processor time.

    python augment.py --rounds 15

The others are set to the mean motion of the preset "elastic"; Pliant's pushes move about a tenth of
the voxels. The others move no landmarks. Packages that are missing are left out.
"""

import argparse
import dataclasses
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
MARGIN = 24  # voxels at the border where the motion of others can't be seen


def ramps() -> Any:
    """The indices k, j, i of each voxel, as images that show a motion."""
    return numpy.stack(numpy.meshgrid(*[numpy.arange(N, dtype=numpy.float32)] * 3, indexing="ij"))


def motion_of(moved: Any) -> Any:
    """Length of the motion at each voxel [mm], of moved ramps."""
    inside = (slice(MARGIN, -MARGIN),) * 3
    return numpy.linalg.norm(numpy.asarray(moved) - ramps(), axis=0)[inside]


def motion_of_warp(warp: Any) -> Any:
    inside = (slice(MARGIN, -MARGIN),) * 3
    return numpy.linalg.norm(warp.forward_field().array, axis=3)[inside]


@dataclasses.dataclass
class Case:
    run: Callable[[], object]
    motion: Callable[[], Any] | None = None  # lengths [mm] of a sample


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


def pliant_cases(scan: pliant.Volume, labels: Any, points: Any, rng: Any) -> dict[str, Case]:
    numbers = iter(range(10**9))

    def case(motions: TissueMotions, plans: list[Plan], target: Any) -> Case:
        def applied() -> Any:
            plan = plans[next(numbers) % len(plans)]
            return motions.apply(target, plan, labels=labels, points=points)

        return Case(applied, lambda: motion_of_warp(applied().warp))

    elastic = TissueMotions(preset="elastic")
    # Two pushes of large tools, of tissue whose motion reaches far: balls, and octahedra.
    large: dict[str, Any] = {"pushes": 2, "tool_mm": (12, 20), "push_mm": (4, 8), "offset": 0.2}
    pushes = TissueMotions(**large)
    plans = plans_of(pushes, scan, rng, 0.1)
    octahedra = [dataclasses.replace(p, tissue={**p.tissue, "limits": "box"}) for p in plans]
    prepared = pushes.prepare(scan)
    # The same tools in the elastic scan, which has no such limits.
    del large["offset"]
    solved = TissueMotions(model="elastic", **large)
    solved_plans = [solved.sample(scan, rng) for _ in range(8)]

    def drawn() -> None:
        pushes.sample(scan, numpy.random.default_rng(next(numbers)))

    waves = [elastic.sample(scan, rng) for _ in range(8)]
    return {
        "pliant, preset elastic": case(elastic, waves, scan),
        "pliant, two pushes": case(pushes, plans, scan),
        "pliant, two pushes, scan prepared before": case(pushes, plans, prepared),
        "pliant, two pushes, limits = box": case(pushes, octahedra, scan),
        "pliant, two pushes, elastic scan": case(solved, solved_plans, scan),
        "pliant, drawing a plan of pushes alone": Case(drawn),
    }


def monai_skin(scan: pliant.Volume, labels: Any, wanted_mm: float) -> dict[str, Case]:
    """The way of most users: MONAI's dictionary transform, with drawing and preparation."""
    import torch
    from monai.data import MetaTensor

    from pliant.augment.monai import RandTissueMotiond

    motion = RandTissueMotiond(
        ["image", "label"], mode=("bilinear", "nearest"), prob=1.0, preset="elastic"
    ).set_random_state(1)
    item = {
        "image": MetaTensor(torch.as_tensor(scan.array[None].astype(numpy.float32))),
        "label": MetaTensor(torch.as_tensor(labels[None])),
    }
    return {"pliant's RandTissueMotiond, elastic": Case(lambda: motion(item))}


def torchio_case(scan: pliant.Volume, labels: Any, wanted_mm: float) -> dict[str, Case]:
    import torch
    import torchio

    torch.set_num_threads(1)
    image = torch.as_tensor(scan.array[None].astype(numpy.float32))
    subject = torchio.Subject(
        ct=torchio.ScalarImage(tensor=image), organs=torchio.LabelMap(tensor=labels[None])
    )
    axes = torchio.Subject(
        {name: torchio.ScalarImage(tensor=ramp[None]) for name, ramp in zip("kji", ramps())}
    )

    def case(scale: float) -> Case:
        elastic = torchio.RandomElasticDeformation(max_displacement=7.5 * scale, copy=False)

        def motion() -> Any:
            moved = torchio.RandomElasticDeformation(max_displacement=7.5 * scale)(axes)
            return motion_of([moved[name].data[0].numpy() for name in "kji"])

        return Case(lambda: elastic(subject), motion)

    return {"TorchIO RandomElasticDeformation": scaled(case, wanted_mm)}


def monai_case(scan: pliant.Volume, labels: Any, wanted_mm: float) -> dict[str, Case]:
    import torch
    from monai.transforms import Rand3DElastic, Rand3DElasticd

    torch.set_num_threads(1)
    item = {
        "image": torch.as_tensor(scan.array[None].astype(numpy.float32)),
        "label": torch.as_tensor(labels[None]).float(),
    }

    def case(scale: float) -> Case:
        size = ((6.5, 6.5), (200 * scale, 200 * scale))
        elastic = Rand3DElasticd(["image", "label"], *size, prob=1.0, mode=("bilinear", "nearest"))
        return Case(
            lambda: elastic(item),
            lambda: motion_of(Rand3DElastic(*size, prob=1.0, padding_mode="border")(ramps())),
        )

    return {"MONAI Rand3DElasticd": scaled(case, wanted_mm)}


def elasticdeform_case(scan: pliant.Volume, labels: Any, wanted_mm: float) -> dict[str, Case]:
    import elasticdeform

    image = scan.array.astype(numpy.float32)

    def case(scale: float) -> Case:
        def deformed(images: Any, order: Any) -> Any:
            return elasticdeform.deform_random_grid(
                images, sigma=3 * scale, points=5, order=order, mode="nearest"
            )

        return Case(
            lambda: deformed([image, labels], [1, 0]),
            lambda: motion_of(deformed(list(ramps()), [1, 1, 1])),
        )

    return {"elasticdeform": scaled(case, wanted_mm)}


def scaled(case: Callable[[float], Case], wanted_mm: float) -> Case:
    """A case whose mean motion is that of Pliant's preset. The motion is linear in the scale."""
    motion = case(1).motion
    assert motion is not None
    found = numpy.mean([motion().mean() for _ in range(4)])
    return case(float(wanted_mm / found))


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
    cases = pliant_cases(scan, labels, points, rng)
    # mean, 95 % and maximum of the motion, and the share of the voxels that move by 0.1 mm
    motions: dict[str, tuple[float, ...]] = {}

    def measure(name: str) -> None:
        motion = cases[name].motion
        if motion is None:
            return
        all_of = numpy.concatenate([motion().ravel() for _ in range(4)])
        motions[name] = (
            float(all_of.mean()), float(numpy.percentile(all_of, 95)), float(all_of.max()),
            float((all_of > 0.1).mean()),
        )  # fmt: skip

    for name in cases:
        measure(name)
    wanted_mm = motions["pliant, preset elastic"][0]
    for make in (monai_skin, torchio_case, monai_case, elasticdeform_case):
        try:
            added = make(scan, labels, wanted_mm)
        except ImportError as error:
            print(f"left out: {error}")
            continue
        cases |= added
        for name in added:
            measure(name)
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
            case.run()
            end, end_processor = time.perf_counter(), time.process_time()
            if turn > 0:  # the first warms up
                wall[name].append(1e3 * (end - begin))
                processor[name].append(1e3 * (end_processor - begin_processor))
    medians = {
        name: (statistics.median(wall[name]), statistics.median(processor[name])) for name in cases
    }
    if given.json:
        print(json.dumps({"ms": medians, "motion_mm": motions}))
        return
    base = medians["pliant, preset elastic"][1]
    print("load", *(f"{one:.1f}" for one in os.getloadavg()))
    print("median wall-clock and processor time [ms], ratio of the latter; motion [mm]: mean,")
    print("95 %, maximum; voxels that move by 0.1 mm")
    for name, (median, used) in medians.items():
        moved = motions.get(name)
        text = "%5.2f %5.2f %5.2f %3.0f %%" % (*moved[:3], 100 * moved[3]) if moved else ""
        print(f"{name:42} {median:8.1f} {used:8.1f} {used / base:6.1f} x  {text}")


if __name__ == "__main__":
    main()
