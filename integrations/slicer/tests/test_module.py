# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""The module beside a real VTK and a real `pliant serve`, and stand-ins of Slicer."""

import os
import time

import numpy
import pytest
import vtk
from PliantLib import logic
from scans import END, RADIUS_MM, START, deform, program, scan, wait_until
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy

import stand_ins

slicer = stand_ins.install(os.environ)
import Pliant  # noqa: E402


@pytest.fixture
def panel():
    """The module's panel with a volume, and its end."""
    slicer.mrmlScene.nodes.clear()
    stand_ins.told.clear()
    widget = Pliant.PliantWidget()
    widget.setup()
    voxels, matrix = scan()
    widget.volume.node = slicer.mrmlScene.add(stand_ins.Volume("CT", voxels, matrix))
    widget.program.currentPath = program()
    widget.model.currentText = "chainmail"
    widget.line.node = stand_ins.Markups("vtkMRMLMarkupsLineNode", [START, END])
    widget.radius.value, widget.depth.value = RADIUS_MM, 12.0
    yield widget
    widget.cleanup()


def press(text):
    stand_ins.made[text].emit("clicked()")


def press_and_show(panel, text):
    """The deformed volume's voxels after a button and the timer."""
    step = panel.logic.session.client.step
    press(text)
    wait_until(lambda: panel.logic.session.client.step > step)
    panel.timer.emit("timeout()")
    return stand_ins.array_from_volume(panel.logic.deformed)


def start(panel):
    press("Start")
    assert stand_ins.told == []
    client = panel.logic.session.client
    client.wait_for(client.send("materials", limits="rounded"))  # as pliant deform's


def moved(transform, points):
    """Points moved by a transform of VTK."""
    data, out = vtk.vtkPoints(), vtk.vtkPoints()
    data.SetData(numpy_to_vtk(numpy.ascontiguousarray(points), deep=True))
    transform.TransformPoints(data, out)
    return vtk_to_numpy(out.GetData())


def test_a_push_along_a_line_is_shown_in_a_copy_and_undone(panel, tmp_path):
    voxels, matrix = scan()
    expected = logic.read_nrrd(deform(tmp_path, voxels, matrix)[0])[1]
    start(panel)
    deformed = panel.logic.deformed
    assert deformed.name == "CT deformed" and stand_ins.settings["background"] is deformed
    assert panel.timer.running and deformed.shown == 0
    assert numpy.array_equal(press_and_show(panel, "Push along the line"), expected)
    assert deformed.shown == 1 and "push" in panel.status.text
    panel.timer.emit("timeout()")
    assert deformed.shown == 1  # nothing new
    assert numpy.array_equal(press_and_show(panel, "Undo"), voxels)
    assert numpy.array_equal(press_and_show(panel, "Redo"), expected)
    press("Exact values")
    assert numpy.array_equal(stand_ins.array_from_volume(deformed), expected)
    assert numpy.array_equal(press_and_show(panel, "Reset"), voxels)
    assert numpy.array_equal(stand_ins.array_from_volume(panel.volume.node), voxels)
    press("Undo")
    press("Undo")
    press("Stop")
    assert panel.logic.session is None and not panel.timer.running and stand_ins.told == []


def test_grid_transforms_move_points_and_images_as_the_fields_of_pliant(panel, tmp_path):
    voxels, matrix = scan()
    _, displacement, _ = deform(tmp_path, voxels, matrix)
    field = logic.read_nrrd(displacement)[1].reshape(-1, 3)
    start(panel)
    deformed = press_and_show(panel, "Push along the line")
    images, points = panel.logic.transforms()
    ijk = numpy.stack(numpy.meshgrid(*map(numpy.arange, voxels.shape), indexing="ij"), axis=-1)
    rest = ijk.reshape(-1, 3)[:, ::-1] @ matrix[:3, :3].T + matrix[:3, 3]  # RAS
    # Points at rest go where the displacement of `pliant deform`, which is LPS, has them.
    ahead = moved(points.to_parent, rest)
    assert numpy.linalg.norm(field, axis=1).max() > 2.0
    assert numpy.abs(ahead - (rest + field * [-1, -1, 1])).max() < 1e-5
    # Each voxel of the deformed scan is the original's at the point that the other one gives.
    source = moved(images.to_parent.GetInverse(), rest)
    at = (source - matrix[:3, 3]) @ numpy.linalg.inv(matrix[:3, :3]).T
    difference = numpy.abs(trilinear(voxels, at) - deformed.reshape(-1))
    still = numpy.abs(voxels - deformed.astype(float)).reshape(-1)
    assert numpy.quantile(difference, 0.99) <= 1.0 and still.max() > 50.0
    # There and back: the two fields are samples of one map and of its inverse.
    back = numpy.linalg.norm(moved(images.to_parent.GetInverse(), ahead) - rest, axis=1)
    by_vtk = numpy.linalg.norm(moved(images.to_parent, rest) - ahead, axis=1)
    print(f"largest difference, there and back: {back.max():.2f} mm")
    print(f"largest difference, field inverted by VTK: {by_vtk.max():.2f} mm")
    assert numpy.quantile(back, 0.95) < 0.1


def trilinear(voxels, ijk):
    """Values at continuous indices, the border's beyond it."""
    ijk = numpy.clip(ijk[:, ::-1], 0, numpy.array(voxels.shape) - 1)
    first = numpy.minimum(ijk.astype(int), numpy.array(voxels.shape) - 2)
    part, total = ijk - first, 0.0
    for corner in numpy.ndindex(2, 2, 2):
        weight = numpy.prod(numpy.where(corner, part, 1 - part), axis=1)
        total = total + weight * voxels[tuple((first + corner).T)]
    return total


def test_a_tracked_transform_pushes_with_each_motion(panel):
    voxels, matrix = scan()
    start(panel)
    tool = panel.transform.node = stand_ins.Transform("vtkMRMLLinearTransformNode", "tip")
    into = -matrix[:3, 1] / numpy.linalg.norm(matrix[:3, 1])
    hole = START + matrix[:3, :3] @ [1, 8, 0]
    tool.move(hole)
    press("Follow the tool")
    assert tool.HasObserver(stand_ins.Transform.TransformModifiedEvent)
    steps = []
    for depth in range(2, 7):
        before = panel.logic.session.client.step
        tool.move(hole + 3.0 * depth * into)
        end = time.monotonic() + 20
        while panel.logic.session.client.step == before and time.monotonic() < end:
            panel.timer.emit("timeout()")
            time.sleep(0.01)
        steps.append(panel.logic.session.client.step - before)
    assert all(steps)
    press("Let the tool go")
    step = panel.logic.session.client.step
    tool.move(hole)
    time.sleep(0.1)
    assert panel.logic.session.client.step == step
    assert not tool.HasObserver(stand_ins.Transform.TransformModifiedEvent)
    assert (stand_ins.array_from_volume(panel.logic.deformed) != voxels).sum() > 100
    assert numpy.array_equal(press_and_show(panel, "Undo"), voxels)


def test_a_cut_follows_the_curve_and_the_normal_of_a_slice_view(panel):
    start(panel)
    voxels, matrix = scan()
    points = [START - matrix[:3, 0] * 4, START + matrix[:3, 0] * 4]
    panel.curve.node = stand_ins.Markups("vtkMRMLMarkupsCurveNode", points)
    press("Cut")
    assert stand_ins.told.pop() == "cut: choose a slice view."
    panel.slice.node = stand_ins.SliceView(matrix / numpy.linalg.norm(matrix, axis=0))
    press("Cut")
    wait_until(lambda: panel.timer.emit("timeout()") or "cut" in panel.status.text)
    answer = panel.logic.session.client.wait_for(2)  # the second command
    assert answer["do"] == "cut" and answer["cut_links"] > 10


def test_the_end_of_the_server_is_told_once_and_the_volume_keeps_its_state(panel):
    start(panel)
    last = press_and_show(panel, "Push along the line").copy()
    server = panel.logic.session.server
    server.process.kill()
    wait_until(lambda: panel.logic.session.client.ended)
    panel.timer.emit("timeout()")
    line = "pliant serve has ended by signal 9. The volume keeps its last state."
    assert stand_ins.told == [line] and panel.status.text == line
    assert not panel.timer.running
    assert numpy.array_equal(stand_ins.array_from_volume(panel.logic.deformed), last)
    press("Push along the line")
    assert stand_ins.told[1:] == ["Press Start first."]
    press("Start")  # again, with the original
    assert panel.logic.session and panel.logic.deformed.name == "CT deformed_1"


def test_wrong_choices_are_one_line_each(panel):
    press("Undo")
    panel.program.currentPath = "/nowhere/pliant"
    press("Start")
    panel.program.currentPath = program()
    panel.volume.node.parent = stand_ins.Transform("vtkMRMLLinearTransformNode", "parent")
    press("Start")
    panel.volume.node = None
    press("Start")
    press("Follow the tool")
    assert stand_ins.told == [
        "Press Start first.",
        "/nowhere/pliant: expected the program pliant: No such file or directory",
        "CT is under a transform: harden it, or take it out, first.",
        "Choose a volume that has voxels.",
        "Choose the transform of a tracked tool.",
    ]
    assert panel.logic.session is None and not panel.timer.running


def test_a_volume_that_leaves_the_scene_ends_the_server(panel):
    start(panel)
    process = panel.logic.session.server.process
    slicer.mrmlScene.RemoveNode(panel.logic.deformed)
    panel.timer.emit("timeout()")
    assert stand_ins.told == ["The volume has left the scene; the server has ended."]
    assert process.poll() is not None and not panel.timer.running


def test_a_wheel_is_installed_only_on_a_click(panel):
    stand_ins.settings.pop("wheel", None)
    press("Install a wheel…")
    assert stand_ins.installed == []
    stand_ins.settings["wheel"] = "/a folder/pliant.whl"
    press("Install a wheel…")
    assert stand_ins.installed == [["/a folder/pliant.whl"]]
