# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Scores SimpleITK's demons, and elastix where itk-elastix is installed, on cases of known truth.

    python score_registration.py SCAN [--cases 3] [--seed 1] [--table table.md]

Needs SimpleITK; elastix: pip install itk-elastix. --check makes two small cases of a phantom and
ends with 1 unless demons improves on no registration.
"""

from __future__ import annotations

import argparse
import importlib.util
import time
from collections.abc import Callable
from typing import Any

import numpy
import SimpleITK as sitk

import pliant
from pliant import truth


def demons(fixed: sitk.Image, moving: sitk.Image) -> Any:
    """Diffeomorphic demons on three levels, each of which begins with the field of the one before.

    Returns:
        A transform from fixed to moving points.
    """
    field = None
    for shrink, iterations in ((4, 100), (2, 60), (1, 20)):
        small = [sitk.Shrink(image, [shrink] * 3) for image in (fixed, moving)]
        method = sitk.DiffeomorphicDemonsRegistrationFilter()
        method.SetNumberOfIterations(iterations)
        method.SetSmoothDisplacementField(True)
        method.SetStandardDeviations(1.5)
        if field is None:
            field = method.Execute(*small)
        else:
            start = sitk.Resample(field, small[0], sitk.Transform(), sitk.sitkLinear)
            field = method.Execute(*small, start)
    assert field is not None
    return sitk.DisplacementFieldTransform(sitk.Cast(field, sitk.sitkVectorFloat64))


def elastix(fixed: sitk.Image, moving: sitk.Image) -> numpy.ndarray[Any, Any]:
    """B-splines with elastix's default parameters, 16 mm apart on the finest level.

    Returns:
        Displacements (k, j, i, 3) [mm, LPS] on the fixed image's grid.
    """
    import itk  # type: ignore[import-not-found, import-untyped, unused-ignore]

    def converted(image: sitk.Image) -> Any:
        made = itk.image_from_array(sitk.GetArrayFromImage(image).astype(numpy.float32))
        made.SetOrigin(image.GetOrigin())
        made.SetSpacing(image.GetSpacing())
        made.SetDirection(itk.matrix_from_array(numpy.reshape(image.GetDirection(), (3, 3))))
        return made

    parameters = itk.ParameterObject.New()
    parameters.AddParameterMap(parameters.GetDefaultParameterMap("bspline", 3, 16.0))
    parameters.SetParameter(0, "FinalGridSpacingInPhysicalUnits", "16")
    _, found = itk.elastix_registration_method(
        converted(fixed), converted(moving), parameter_object=parameters, log_to_console=False
    )
    field = itk.transformix_deformation_field(converted(fixed), found)
    return numpy.asarray(itk.array_from_image(field))


def methods() -> dict[str, Callable[[sitk.Image, sitk.Image], Any]]:
    chosen: dict[str, Callable[[sitk.Image, sitk.Image], Any]] = {"demons (SimpleITK)": demons}
    if importlib.util.find_spec("itk"):
        chosen["B-splines (elastix)"] = elastix
    return chosen


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scan", nargs="?", help="NRRD, NIfTI, MetaImage or DICOM")
    parser.add_argument("--cases", type=int, default=3)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kinds", default="contact,slide,cut,interface,breathing")
    parser.add_argument("--table", help="file for the table in Markdown")
    parser.add_argument("--check", action="store_true", help="small phantom, see above")
    chosen = parser.parse_args()
    if chosen.check:
        scan = pliant.make_phantom("airway", (48, 48, 48))
        chosen.cases, chosen.kinds = 2, "breathing"
    elif chosen.scan:
        scan = pliant.read_volume(chosen.scan)
    else:
        parser.error("expected a scan, or --check")
    maker = truth.TruthMaker(scan, kinds=chosen.kinds)
    fixed = sitk.Cast(scan.to_sitk(), sitk.sitkFloat32)
    scores: dict[str, list[dict[str, Any]]] = {"none": []}
    for seed in range(chosen.seed, chosen.seed + chosen.cases):
        case = maker.make(seed)
        moving = sitk.Cast(case.moving.to_sitk(), sitk.sitkFloat32)
        kinds = ", ".join(motion["kind"] for motion in case.motions)
        print(f"seed {seed}: {kinds}; maps agree to {case.inverse_error_mm:.1e} mm", flush=True)
        scores["none"].append(truth.score(case, None))
        for name, register in methods().items():
            begin = time.monotonic()
            found = register(fixed, moving)
            scores.setdefault(name, []).append(truth.score(case, found))
            print(f"  {name}: {time.monotonic() - begin:.0f} s", flush=True)
    table = truth.table(scores)
    print(table)
    if chosen.table:
        with open(chosen.table, "w", encoding="utf-8") as file:
            file.write(table)
    if not chosen.check:
        return 0
    means = {name: truth.over_cases(some)["moved"]["mean_mm"] for name, some in scores.items()}
    before, after = means["none"], means["demons (SimpleITK)"]
    return 0 if after < 0.8 * before else 1


if __name__ == "__main__":
    raise SystemExit(main())
