# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Walls of vessels, and catheters in them, against formulas and against each other."""

import gc
import pathlib
import signal
import threading
import time

import numpy
import pytest

import pliant

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"


def straight(length=60.0, radius=4.0):
    z = numpy.arange(0, length + 1, 3.0)
    return numpy.stack([0 * z, 0 * z, z, 0 * z + radius], axis=-1)


def bend():
    angle = numpy.linspace(0, numpy.pi / 2, 13)
    x = 25 * (1 - numpy.cos(angle))
    z = 40 + 25 * numpy.sin(angle)
    turn = numpy.stack([x, 0 * x, z, 0 * x + 4], axis=-1)
    return numpy.concatenate([straight(36), turn])


@pytest.fixture(scope="module")
def tube():
    return pliant.swept_tube(straight())


def scene_in(wall, **settings):
    chosen = {"threads": 1, "length_mm": 120, "time_step_s": 2e-3, **settings}
    return pliant.CatheterScene(wall, entry=0, **chosen)


def test_a_tube_has_the_volume_of_its_formula(tube):
    assert len(tube.ends) == 2
    assert tube.lumen_mm3 == pytest.approx(numpy.pi * 16 * 60, rel=0.02)
    nodes, cells = tube.mesh.nodes_mm, tube.mesh.cells
    edges = nodes[cells[:, 1:]] - nodes[cells[:, :1]]
    volume = numpy.linalg.det(edges).sum() / 6
    assert volume == pytest.approx(numpy.pi * (5.5**2 - 4**2) * 60, rel=0.02)
    radii = numpy.hypot(*tube.ghost.nodes_mm[:, :2].T)
    assert radii == pytest.approx(4, abs=0.05)
    assert [end.radius_mm for end in tube.ends] == pytest.approx([4, 4], abs=0.1)
    tube.check(layers=2)
    with pytest.raises(pliant.Error, match="layer"):
        tube.check(layers=50)


def test_walls_of_a_centreline_a_surface_and_a_mesh_agree(tube, tmp_path):
    around = pliant.wall_around_centreline([straight()], thickness_mm=1.5)
    assert around.lumen_mm3 == pytest.approx(tube.lumen_mm3, rel=0.1)
    assert len(around.ends) == 2
    again = pliant.wall_of_mesh(around.mesh, around.ghost)
    assert again.lumen_mm3 == pytest.approx(around.lumen_mm3, rel=1e-3)
    around.ghost.save(tmp_path / "ghost.vtp")
    surface = pliant.read_surface(tmp_path / "ghost.vtp")
    assert len(surface.cells) == len(around.ghost.cells)
    with pytest.raises(pliant.Error, match="thickness"):
        pliant.wall_around_centreline([straight()], thickness_mm=-1)
    with pytest.raises(pliant.Error, match=r"branches: expected axes \(..., 4\)"):
        pliant.wall_around_centreline([straight()[:, :3]])
    ends = pliant.ends_of([straight()])
    assert sorted(round(end.centre_mm[2]) for end in ends) == [0, 60]


def test_a_lumen_is_found_in_a_scan(tube):
    scan = pliant.scan_of_vessel(tube)
    lumen = pliant.lumen_of_region(scan, (0, 0, 30), 200, 400)
    assert lumen.region_mm3 == pytest.approx(tube.lumen_mm3, rel=0.15)
    labels = pliant.Volume(
        (scan.array > 200).astype(numpy.int16), scan.spacing_mm, scan.origin_mm, scan.direction
    )
    same = pliant.lumen_of_labels(labels)
    assert same.voxels == lumen.voxels
    assert same.surface.enclosed_volume_mm3() == pytest.approx(lumen.region_mm3, rel=0.1)
    with pytest.raises(pliant.Error):
        pliant.lumen_of_region(scan, (0, 0, 30), 1000, 2000)


def test_a_catheter_advances_as_commanded(tube):
    scene = scene_in(tube)
    scene.command(insert_mm_s=100)
    before = scene.quick_measures().inserted_mm
    scene.step(100)
    measures = scene.measures()
    assert measures.time_s == pytest.approx(0.2)
    assert measures.inserted_mm - before == pytest.approx(20, abs=0.01)
    assert measures.depth_mm < 0.1
    assert measures.warnings() == []
    # Along a straight tube: the tip is on the axis, as far in as the wire.
    tip = numpy.array(scene.tip_mm)
    assert numpy.hypot(*tip[:2]) < 3.2
    assert (scene.wire_positions[-1] == tip).all()
    frame = scene.tip_frame
    assert frame @ frame.T == pytest.approx(numpy.eye(3), abs=1e-9)
    inserted = scene.wire_positions[scene.first_inserted :]
    steps = numpy.linalg.norm(numpy.diff(inserted, axis=0), axis=1)
    assert steps == pytest.approx(scene.settings["segment_mm"], rel=0.02)
    scene.command(rotate_deg_s=90)
    scene.step(50)
    assert scene.quick_measures().rotated_deg == pytest.approx(9, abs=1e-6)


def test_a_bent_tip_pushes_the_wall(tube):
    scene = scene_in(tube, local=True)
    scene.command(insert_mm_s=100, bend_first_deg=90)
    scene.step(150)
    measures = scene.measures()
    moved = scene.wall_positions - scene.wall.mesh.nodes_mm
    assert measures.wall_moved_mm == pytest.approx(
        numpy.linalg.norm(moved, axis=1).max(), rel=1e-6, abs=1e-9
    )
    assert measures.contact_n > 0
    assert measures.wall_moved_mm > 0
    assert scene.ghost_positions.shape == scene.wall.ghost.nodes_mm.shape


def test_threads_and_states_give_the_same_bits(tube):
    one, two = scene_in(tube), scene_in(tube, threads=2)
    for scene in (one, two):
        scene.command(insert_mm_s=80, bend_first_deg=60)
        scene.step(60)
    assert one.hash() == two.hash()
    assert (one.wire_positions == two.wire_positions).all()
    state = one.state()
    one.step(20)
    after = one.hash()
    two.restore(state)
    two.command(insert_mm_s=80, bend_first_deg=60)
    two.step(20)
    assert two.hash() == after
    with pytest.raises(pliant.Error):
        two.restore(state[:-1])
    assert two.hash() == after
    with pytest.raises(pliant.Error, match="state: expected one axis"):
        two.restore([[1.0]])


def test_a_scene_keeps_its_wall(tube):
    scene = pliant.CatheterScene(pliant.swept_tube(straight(30)), length_mm=60)
    nodes = scene.wall.mesh.nodes_mm
    shape = nodes.copy()
    del scene
    gc.collect()
    assert (nodes == shape).all()


def test_entries_and_settings_are_checked(tube):
    end = tube.ends[1]
    at_end = pliant.CatheterScene(tube, entry=end, length_mm=60)
    by_number = pliant.CatheterScene(tube, entry=1, length_mm=60)
    assert at_end.hash() == by_number.hash()
    given = pliant.CatheterScene(tube, entry=((0, 0, 2), (0, 0, 1)), length_mm=60)
    assert given.tip_mm[2] == pytest.approx(7, abs=1e-6)
    for wrong, message in (
        ({"entry": 2}, "entry: expected a number below 2"),
        ({"entry": ((100, 0, 0), (0, 0, 1))}, "entry"),
        ({"lenght_mm": 3}, "lenght_mm"),
        ({"radius_mm": -1}, "radius_mm"),
    ):
        with pytest.raises(pliant.Error, match=message):
            pliant.CatheterScene(tube, **wrong)
    names = [row["name"] for row in pliant.settings_of("catheter")]
    assert "young_modulus_pa" in names
    assert pliant.wide_reach_mm(tube, young_modulus_pa=1e6) > pliant.wide_reach_mm(tube)


def test_a_scene_file_is_played(tmp_path):
    vessel = pliant.make_vessel(SCENES / "vessel_phantom.toml")
    assert len(vessel.wall.ends) == 2
    scene, script = vessel.scene(threads=2), vessel.script()
    assert scene.settings["young_modulus_pa"] == vessel.settings["young_modulus_pa"]
    steps = 0
    while script.progress == 0 and script.next(scene):
        scene.step()
        steps += 1
    assert scene.quick_measures().steps == steps
    assert script.progress == pytest.approx(1 / 3)
    assert script.way_mm(scene) >= 119.9  # of the file's first act
    pilot = pliant.WayPilot(vessel.way_mm)
    assert pilot.way_mm == pytest.approx(
        numpy.linalg.norm(numpy.diff(vessel.way_mm, axis=0), axis=1).sum()
    )
    assert pilot.progress_mm(scene.tip_mm) == pytest.approx(script.way_mm(scene), abs=1e-6)
    first, second = pilot.steer(scene)
    assert numpy.hypot(first, second) <= 120.001
    scene.save(tmp_path / "wall.vtu", tmp_path / "wire.vtp")
    saved = pliant.read_tetrahedra(tmp_path / "wall.vtu")
    assert (saved.nodes_mm == scene.wall_positions).all()
    assert (tmp_path / "wire.vtp").stat().st_size > 100
    with pytest.raises(pliant.Error, match="missing.toml"):
        pliant.make_vessel(tmp_path / "missing.toml")


def test_the_scan_moves_with_the_wall(tube):
    scan = pliant.scan_of_vessel(tube)
    carried = pliant.CarriedScan(scan, tube.mesh)
    carried.update(tube.mesh.nodes_mm)
    assert (carried.volume().array == scan.array).all()
    carried.update(tube.mesh.nodes_mm + (2, 0, 0))
    field = carried.displacement_field()
    assert field.apply_to_points([(0, 0, 30)])[0] == pytest.approx((2, 0, 30), abs=0.2)
    assert (carried.volume().array != scan.array).sum() > 1000
    with pytest.raises(pliant.Error):
        carried.update([(0, 0, 0)])


def test_walls_are_drawn(tube):
    scene = scene_in(tube)
    wall = pliant.boundary_triangles(tube.mesh)
    drawn = pliant.DrawnSurface(wall.nodes_mm, wall.cells, opacity=0.4)
    wire = pliant.DrawnWire(scene.wire_positions, 1.0)
    alone = pliant.surface_view([drawn], width=200, height=150)
    both = pliant.surface_view([drawn], [wire], 200, 150, caption="tube")
    assert alone.shape == (150, 200, 3)
    assert (alone != both).sum() > 100


def test_an_interruption_ends_a_step(tube):
    scene = scene_in(tube, local=False)
    scene.command(insert_mm_s=10, bend_first_deg=50)
    sent = []

    def interrupt():
        time.sleep(0.1)
        sent.append(time.perf_counter())
        signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    with pytest.raises(KeyboardInterrupt):
        begin = time.perf_counter()
        while time.perf_counter() - begin < 60:
            scene.step(10_000)
    print(f"stopped {1000 * (time.perf_counter() - sent[0]):.0f} ms after the signal")
    thread.join()
    steps = scene.quick_measures().steps
    scene.step(2)
    assert scene.quick_measures().steps == steps + 2
