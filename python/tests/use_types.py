# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A user's program, for mypy alone."""

import numpy
import numpy.typing

import pliant
from pliant import gym, truth


def moved(path: str) -> numpy.typing.NDArray[numpy.float64]:
    scan = pliant.read_volume(path)
    tissue = pliant.make_chainmail(scan, threads=1, offset=0.2)
    report = tissue.push(scan.world_from_voxel((1, 2, 3)), numpy.array([1.0, 0, 0]))
    if report.status != "applied":
        raise pliant.Error(report.message)
    tissue.volume().save("pushed.nrrd")
    return tissue.displacement_field().apply_to_points([scan.origin_mm])


def scored(path: str) -> float:
    case = truth.make_case(pliant.read_volume(path), seed=7, threads=1, kinds="slide")
    points: numpy.typing.NDArray[numpy.float64] = case.moving_from_fixed([(0, 0, 0)])
    assert points.shape == (1, 3)
    return float(truth.score(case, case.forward)["moved"]["mean_mm"])


def seen(scan: pliant.Volume) -> numpy.typing.NDArray[numpy.uint8]:
    endoscope = pliant.find_endoscope(scan) or pliant.view_of_whole(scan)
    endoscope.style = "real"
    endoscope.eye_mm = numpy.array(endoscope.eye_mm) + 1
    path = pliant.find_lumen_path(scan, endoscope.eye_mm, (0, 0, 0))
    caster = pliant.RayCaster(scan, threads=1)
    _, depth, _, _ = caster.endoscope_frame(endoscope.replaced(iso_hu=-400), 64, 64)
    if not numpy.isfinite(depth).any() or path.length_mm > 100:
        return pliant.section_view(scan, pliant.Section(point_mm=endoscope.eye_mm))
    return caster.endoscope_view(endoscope)


def pushed_by_a_wire(way: numpy.typing.NDArray[numpy.float64]) -> float:
    scene = pliant.CatheterScene(pliant.wall_around_centreline([way]), entry=0, length_mm=90)
    scene.command(insert_mm_s=20, bend_first_deg=10)
    scene.step(10)
    return scene.measures().force_n + float(scene.wire_positions[-1, 2])


def fitted(mesh: pliant.TetMesh) -> pliant.SpringParts:
    load = pliant.FitMeshLoad([1], (0, 0, -1))
    made = pliant.fit_mesh(mesh, [0, 2, 3], [load], [pliant.FitRegion(name="all")])
    return made.network(pliant.fit(made.problem)).parts


def with_settings(scan: pliant.Volume, mesh: pliant.TriangleMesh) -> None:
    pliant.make_chainmail(scan, 1, offset=1, limits="rounded", factor=[1, 1, 2], range_percent=None)
    pliant.make_chainmail(scan, ofset=0.1)  # type: ignore[call-arg]
    pliant.make_chainmail(scan, offset="0.1")  # type: ignore[arg-type]
    pliant.make_chainmail(scan, limits="round")  # type: ignore[arg-type]
    pliant.make_springs(scan).configure(depth=2)
    pliant.make_elastic(scan, moduli_kpa=[(0, 3)], held_sides=["-x"], poisson_ratio=0.4)
    pliant.make_elastic(scan, held_sides=["left"])  # type: ignore[list-item]
    pliant.wall_around_surface(mesh, layers=2.5)  # type: ignore[arg-type]
    pliant.gym.find_vessel("bend", thickness_mm=2)
    pliant.gym.find_vessel("bend", thickness=2)  # type: ignore[call-arg]
    gym.CatheterEnv("bend", friction=0.1)
    gym.CatheterEnv("bend", friction="rough")  # type: ignore[arg-type]
    gym.CatheterVectorEnv(2, "bend", threads=1, friction=0.1)
    gym.EndoscopeEnv(offset=0.1, style="plain").arena.push(0, (0, 0, 0), (1, 0, 0), 2)
    gym.EndoscopeEnv(offsets=0.1)  # type: ignore[call-arg]
    truth.make_case(scan, kinds="slide", kind="slide")  # type: ignore[call-arg]


def breathed(exhale: pliant.Volume, inhale: pliant.Volume) -> pliant.Volume:
    motion = pliant.morph(exhale, inhale, from_mm=[(0, 0, 0)], to_mm=[(1, 2, 3)], prior="none")
    assert motion.forward([(1, 1, 1)]).shape == (1, 3)
    return motion.inverse_field(inhale, threads=1).apply_to_volume(exhale)
