# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Pushes and cuts a volume, live: a user interface of `pliant serve`."""

import contextlib
import functools
import subprocess

import ctk
import numpy
import qt
import slicer
import vtk
from slicer.ScriptedLoadableModule import (
    ScriptedLoadableModule,
    ScriptedLoadableModuleLogic,
    ScriptedLoadableModuleWidget,
)
from vtk.util.numpy_support import numpy_to_vtk

from PliantLib.client import PliantError
from PliantLib.logic import Session, TrackedTool
from PliantLib.server import find_program

PROGRAM_SETTING = "Pliant/Program"
MODELS = ("auto", "chainmail", "elastic", "springs")
UPDATE_MS = 33


class Pliant(ScriptedLoadableModule):
    """The module's entry in Slicer's list."""

    def __init__(self, parent):
        ScriptedLoadableModule.__init__(self, parent)
        self.parent.title = "Pliant"
        self.parent.categories = ["Simulation"]
        self.parent.dependencies = []
        self.parent.contributors = ["The Pliant authors"]
        self.parent.helpText = (
            "Pushes and cuts the tissue of a volume; the slice views follow live. The deformation "
            "becomes a volume and grid transforms. Not for clinical use."
        )
        self.parent.acknowledgementText = "Licence: Apache-2.0."


class PliantLogic(ScriptedLoadableModuleLogic):
    """One volume in one server. Methods raise PliantError with one line for the user."""

    def __init__(self):
        ScriptedLoadableModuleLogic.__init__(self)
        self.session = self.original = self.deformed = None
        self._tool = self._tracked = self._observation = None
        self._strokes = 0

    def start(self, volume, program="", model="auto"):
        """Serves a copy of a volume, which the slice views then show."""
        self.stop()
        if volume is None or volume.GetImageData() is None:
            raise PliantError("Choose a volume that has voxels.")
        if volume.GetParentTransformNode() is not None:
            raise PliantError(
                f"{volume.GetName()} is under a transform: harden it, or take it out, first."
            )
        matrix = vtk.vtkMatrix4x4()
        volume.GetIJKToRASMatrix(matrix)
        environment = slicer.util.startupEnvironment()  # without Slicer's own libraries
        self.session = Session(
            find_program(program, environment.get("PATH")),
            slicer.util.arrayFromVolume(volume),
            slicer.util.arrayFromVTKMatrix(matrix),
            model,
            environment,
        )
        self.original = volume
        name = slicer.mrmlScene.GenerateUniqueName(volume.GetName() + " deformed")
        volumes = slicer.modules.volumes.logic()
        self.deformed = volumes.CloneVolume(slicer.mrmlScene, volume, name)
        slicer.util.setSliceViewerLayers(background=self.deformed)

    def stop(self):
        """Ends the session; the deformed volume stays as it is."""
        self._forget_tool()
        session, self.session = self.session, None
        if session:
            session.stop()

    def need(self):
        """The session. Raises PliantError without one."""
        if self.session is None:
            raise PliantError("Press Start first.")
        return self.session

    def update(self):
        """Shows changes; the answers since the last call. Ends a session that has trouble."""
        session = self.need()
        if self.original.GetScene() is None or self.deformed.GetScene() is None:
            self.stop()
            raise PliantError("The volume has left the scene; the server has ended.")
        original = slicer.util.arrayFromVolume(self.original)
        target = slicer.util.arrayFromVolume(self.deformed)
        if session.update(original, target):
            slicer.util.arrayFromVolumeModified(self.deformed)
        answers = session.client.take_answers()
        trouble = session.trouble()
        if trouble:
            self.stop()
            raise PliantError(trouble)
        for answer in answers:
            if self._tool:
                self._tool.take(answer)
        return answers

    def push(self, line, radius_mm):
        """Moves the tissue around the line's first point to its second."""
        points = self._points(line, "push: a markups line with two points")
        if len(points) != 2:
            raise PliantError(f"push: expected a line with two points, found {len(points)}")
        return self.need().push(points[0], points[1], radius_mm)

    def cut(self, curve, slice_node, depth_mm):
        """Cuts along a line or curve, depth_mm along the normal of a slice view."""
        matrix = slicer.util.arrayFromVTKMatrix(slice_node.GetSliceToRAS())
        points = self._points(curve, "cut: a markups line or curve")
        return self.need().cut(points, matrix[:3, 2], depth_mm)

    def command(self, do):
        """undo, redo or reset."""
        return self.need().send(do)

    def _points(self, markups, expected):
        if markups is None:
            raise PliantError(f"{expected}: choose one.")
        if markups.IsA("vtkMRMLMarkupsCurveNode"):
            return slicer.util.arrayFromMarkupsCurvePoints(markups, world=True)
        return slicer.util.arrayFromMarkupsControlPoints(markups, world=True)

    def track(self, transform, radius_mm=0.0):
        """Pushes with each motion of a transform's origin; None ends it."""
        if self._tool and self.session and self.session.client.ended is None:
            self._tool.stop()
        self._forget_tool()
        if transform is None:
            return
        self._strokes += 1
        self._tool = TrackedTool(self.need(), radius_mm, self._strokes)
        self._tracked = transform
        self._observation = transform.AddObserver(
            slicer.vtkMRMLTransformNode.TransformModifiedEvent, self._on_motion
        )
        self._on_motion(transform)

    def _forget_tool(self):
        if self._tracked is not None:
            self._tracked.RemoveObserver(self._observation)
        self._tool = self._tracked = self._observation = None

    def _on_motion(self, transform, _event=None):
        matrix = vtk.vtkMatrix4x4()
        transform.GetMatrixTransformToWorld(matrix)
        try:
            self._tool.move([matrix.GetElement(row, 3) for row in range(3)])
        except PliantError:
            self._forget_tool()  # update() says why

    def exact(self):
        """Gives the deformed volume the values of `pliant deform`."""
        original, target = map(slicer.util.arrayFromVolume, (self.original, self.deformed))
        self.need().exact(original, target)
        slicer.util.arrayFromVolumeModified(self.deformed)

    def transforms(self):
        """Two grid transforms of the present deformation: for images, and for points.

        Slicer resamples an image with a transform from its parent, and moves points and models
        with one to its parent. VTK can invert either, by iterations that may fail where the field
        is steep. So each node has its own field of Pliant: the inverse and the forward one.
        """
        session, name = self.need(), self.deformed.GetName()
        images = self._grid_node(name + " transform (images)")
        images.SetAndObserveTransformFromParent(oriented_grid(session.inverse_field()))
        points = self._grid_node(name + " transform (points)")
        points.SetAndObserveTransformToParent(oriented_grid(session.forward_field()))
        return images, points

    def _grid_node(self, name):
        name = slicer.mrmlScene.GenerateUniqueName(name)
        return slicer.mrmlScene.AddNewNodeByClass("vtkMRMLGridTransformNode", name)


def oriented_grid(grid):
    """Slicer's grid transform of a Grid, which has doubles: Slicer writes no others."""
    image = vtk.vtkImageData()
    image.SetDimensions(*grid.vectors.shape[2::-1])
    image.SetOrigin(*grid.origin)
    image.SetSpacing(*grid.spacing)
    rows = numpy.ascontiguousarray(grid.vectors, numpy.float64).reshape(-1, 3)
    image.GetPointData().SetScalars(numpy_to_vtk(rows, deep=True))
    directions = vtk.vtkMatrix4x4()
    for row in range(3):
        for column in range(3):
            directions.SetElement(row, column, grid.directions[row, column])
    transform = slicer.vtkOrientedGridTransform()
    transform.SetDisplacementGridData(image)
    transform.SetGridDirectionMatrix(directions)
    transform.SetInterpolationModeToLinear()
    return transform


class PliantWidget(ScriptedLoadableModuleWidget):
    """The module's panel."""

    def setup(self):
        ScriptedLoadableModuleWidget.setup(self)
        self.logic = PliantLogic()
        self._program_section()
        self._volume_section()
        self._push_section()
        self._cut_section()
        self._result_section()
        self.status = qt.QLabel("Choose a volume, and press Start.")
        self.status.wordWrap = True
        self.layout.addWidget(self.status)
        self.layout.addStretch(1)
        self.timer = qt.QTimer()
        self.timer.setInterval(UPDATE_MS)
        self.timer.connect("timeout()", self.on_timer)
        slicer.app.connect("aboutToQuit()", self.on_stop)

    def cleanup(self):
        self.on_stop()

    def _section(self, title, collapsed=False):
        section = ctk.ctkCollapsibleButton()
        section.text, section.collapsed = title, collapsed
        self.layout.addWidget(section)
        return qt.QFormLayout(section)

    def _button(self, form, text, tip, action):
        button = qt.QPushButton(text)
        button.toolTip = tip
        button.connect("clicked()", functools.partial(self.attempt, action))
        form.addRow(button)
        return button

    def _selector(self, form, label, *types):
        selector = slicer.qMRMLNodeComboBox()
        selector.nodeTypes = list(types)
        selector.addEnabled = selector.removeEnabled = False
        selector.noneEnabled = True
        selector.setMRMLScene(slicer.mrmlScene)
        form.addRow(label, selector)
        return selector

    def _millimetres(self, form, label, value, largest):
        box = ctk.ctkDoubleSpinBox()
        box.minimum, box.maximum, box.value, box.suffix = 0.5, largest, value, " mm"
        form.addRow(label, box)
        return box

    def _program_section(self):
        form = self._section("Program", collapsed=True)
        self.program = ctk.ctkPathLineEdit()
        self.program.filters = ctk.ctkPathLineEdit.Files
        self.program.currentPath = slicer.util.settingsValue(PROGRAM_SETTING, "")
        self.program.toolTip = "The program pliant. Empty: an installed wheel's, or one of PATH."
        form.addRow("pliant:", self.program)
        tip = "Installs a wheel of Pliant, which holds the program, into Slicer's Python."
        self._button(form, "Install a wheel…", tip, self.on_install)

    def _volume_section(self):
        form = self._section("Volume")
        self.volume = self._selector(form, "Volume:", "vtkMRMLScalarVolumeNode")
        self.model = qt.QComboBox()
        self.model.addItems(list(MODELS))
        self.model.toolTip = "auto: elastic if this machine is fast enough for it, else chainmail."
        form.addRow("Tissue:", self.model)
        self._button(form, "Start", "Serves a copy of the volume.", self.on_start)
        self._button(form, "Stop", "Ends the server. The deformed volume stays.", self.on_stop)

    def _push_section(self):
        form = self._section("Push")
        self.line = self._selector(form, "Line:", "vtkMRMLMarkupsLineNode")
        self.radius = self._millimetres(form, "Radius:", 4.0, 100.0)
        tip = "Moves the tissue around the first point of the line to its second point."
        self._button(form, "Push along the line", tip, self.on_push)
        self.transform = self._selector(form, "Tracked tool:", "vtkMRMLLinearTransformNode")
        tip = "The origin of the transform pushes as a sphere. One undo takes it all back."
        self._button(form, "Follow the tool", tip, self.on_track)
        self._button(form, "Let the tool go", "Ends following.", lambda: self.logic.track(None))

    def _cut_section(self):
        form = self._section("Cut", collapsed=True)
        types = "vtkMRMLMarkupsLineNode", "vtkMRMLMarkupsCurveNode"
        self.curve = self._selector(form, "Line or curve:", *types)
        self.slice = self._selector(form, "Slice view:", "vtkMRMLSliceNode")
        self.slice.toolTip = "The cut goes along the normal of this view, half on each side."
        self.depth = self._millimetres(form, "Depth:", 10.0, 500.0)
        self._button(form, "Cut", "Not with the elastic tissue.", self.on_cut)

    def _result_section(self):
        form = self._section("Result")
        for text, do in (("Undo", "undo"), ("Redo", "redo"), ("Reset", "reset")):
            self._button(form, text, "", functools.partial(self.logic.command, do))
        tip = "Live voxels are exact up to ±2048; this fetches all as pliant deform writes them."
        self._button(form, "Exact values", tip, self.logic.exact)
        tip = "One grid transform for images, one for points and models."
        self._button(form, "Grid transforms", tip, self.logic.transforms)

    def attempt(self, action):
        """Runs an action; an error is one line in the panel and in a dialog."""
        try:
            with waiting():
                action()
        except PliantError as error:
            self.tell(str(error))

    def tell(self, text):
        self.status.text = text
        slicer.util.errorDisplay(text)

    def on_install(self):
        path = qt.QFileDialog.getOpenFileName(None, "A wheel of Pliant", "", "Wheels (*.whl)")
        if not path:
            return
        try:
            slicer.util.pip_install([path])
        except subprocess.CalledProcessError as error:
            raise PliantError(f"{path}: not installed; the Python console says why") from error
        self.status.text = "Installed."

    def on_start(self):
        program = self.program.currentPath
        self.timer.stop()
        qt.QSettings().setValue(PROGRAM_SETTING, program)
        self.logic.start(self.volume.currentNode(), program, self.model.currentText)
        self.status.text = f"{self.logic.original.GetName()} is served."
        self.timer.start()

    def on_stop(self):
        self.timer.stop()
        self.logic.stop()

    def on_push(self):
        self.logic.push(self.line.currentNode(), self.radius.value)

    def on_track(self):
        if self.transform.currentNode() is None:
            raise PliantError("Choose the transform of a tracked tool.")
        self.logic.track(self.transform.currentNode(), self.radius.value)

    def on_cut(self):
        if self.slice.currentNode() is None:
            raise PliantError("cut: choose a slice view.")
        self.logic.cut(self.curve.currentNode(), self.slice.currentNode(), self.depth.value)

    def on_timer(self):
        """Shows changes and answers; the end of the server is told once."""
        try:
            answers = self.logic.update()
        except PliantError as error:
            self.timer.stop()
            self.tell(str(error))
            return
        for answer in answers:
            text = line_of(answer)
            if text:
                self.status.text = text


def line_of(answer):
    """One line on an answer of the server; empty if there is nothing to say."""
    if answer["t"] == "error":
        return answer["message"]
    if answer["t"] != "done":
        return ""
    parts = [answer["do"], answer.get("status", "done")]
    if answer.get("limited_by", "none") != "none":
        parts.append(f"by {answer['limited_by']} at {100 * answer['step_fraction']:.0f} %")
    if answer.get("message"):
        parts.append(answer["message"])
    return ": ".join(parts[:1] + [" ".join(parts[1:])])


@contextlib.contextmanager
def waiting():
    """A wait cursor."""
    qt.QApplication.setOverrideCursor(qt.Qt.WaitCursor)
    try:
        yield
    finally:
        qt.QApplication.restoreOverrideCursor()
