# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""Small stand-ins of `slicer`, `qt` and `ctk` on a real VTK: the calls that the module makes.

Nodes hold VTK's objects. A grid transform is computed by VTK's vtkGridTransform, in the frame of
its own axes: Slicer's vtkOrientedGridTransform is not in VTK.
"""

import sys
import types

import numpy
import vtk
from vtk.util.numpy_support import vtk_to_numpy


class Node(vtk.vtkObject):
    """A MRML node: a name, an ID, events."""

    def __init__(self, kind, name):
        self.kind, self.name, self.scene = kind, name, None

    def GetName(self):
        return self.name

    def GetScene(self):
        return self.scene

    def IsA(self, kind):
        return kind == self.kind

    def GetParentTransformNode(self):
        return getattr(self, "parent", None)


class Volume(Node):
    def __init__(self, name, voxels, matrix):
        Node.__init__(self, "vtkMRMLScalarVolumeNode", name)
        self.image, self.matrix, self.shown = vtk.vtkImageData(), matrix, 0
        self.image.SetDimensions(*voxels.shape[::-1])
        array = vtk.util.numpy_support.numpy_to_vtk(voxels.reshape(-1), deep=True)
        self.image.GetPointData().SetScalars(array)

    def GetImageData(self):
        return self.image

    def GetIJKToRASMatrix(self, matrix):
        matrix.DeepCopy(self.matrix.flatten())


class Transform(Node):
    """A linear transform (a 4 × 4 array), or a grid in one of two directions."""

    TransformModifiedEvent = vtk.vtkCommand.UserEvent + 1

    def __init__(self, kind, name):
        Node.__init__(self, kind, name)
        self.array, self.to_parent = numpy.eye(4), None

    def GetMatrixTransformToWorld(self, matrix):
        matrix.DeepCopy(self.array.flatten())

    def move(self, position):
        self.array[:3, 3] = position
        self.InvokeEvent(self.TransformModifiedEvent)

    def SetAndObserveTransformToParent(self, grid):
        self.to_parent, self.grid = grid.transform(), grid

    def SetAndObserveTransformFromParent(self, grid):
        self.to_parent, self.grid = grid.transform().GetInverse(), grid


class Markups(Node):
    def __init__(self, kind, points):
        Node.__init__(self, kind, kind)
        self.points = numpy.array(points, float)


class SliceView(Node):
    def __init__(self, array):
        Node.__init__(self, "vtkMRMLSliceNode", "Red")
        self.matrix = vtk.vtkMatrix4x4()
        self.matrix.DeepCopy(array.flatten())

    def GetSliceToRAS(self):
        return self.matrix


class OrientedGrid:
    """vtkOrientedGridTransform: vectors are in the world's axes, the grid is turned."""

    def SetDisplacementGridData(self, image):
        self.image = image

    def SetGridDirectionMatrix(self, matrix):
        self.directions = matrix_array(matrix)[:3, :3]

    def SetInterpolationModeToLinear(self):
        self.linear = True

    def transform(self):
        turned, image = numpy.eye(4), vtk.vtkImageData()
        turned[:3, :3], turned[:3, 3] = self.directions, self.image.GetOrigin()
        image.SetDimensions(self.image.GetDimensions())
        image.SetSpacing(self.image.GetSpacing())
        vectors = vtk_to_numpy(self.image.GetPointData().GetScalars()) @ self.directions
        image.GetPointData().SetScalars(vtk.util.numpy_support.numpy_to_vtk(vectors, deep=True))
        grid, whole, world = vtk.vtkGridTransform(), vtk.vtkGeneralTransform(), vtk.vtkMatrix4x4()
        grid.SetDisplacementGridData(image)
        grid.SetInterpolationModeToLinear()
        world.DeepCopy(turned.flatten())
        whole.Concatenate(world)
        whole.Concatenate(grid)
        world.Invert()
        whole.Concatenate(world)
        return whole


class Scene:
    def __init__(self):
        self.nodes = []

    def add(self, node):
        node.scene = self
        self.nodes.append(node)
        return node

    def AddNewNodeByClass(self, kind, name):
        return self.add(Transform(kind, name))

    def GenerateUniqueName(self, name):
        taken = [node.name for node in self.nodes]
        return name if name not in taken else f"{name}_{taken.count(name)}"

    def RemoveNode(self, node):
        self.nodes.remove(node)
        node.scene = None


class Widget:
    """Any widget: attributes are kept, signals are called by emit, other calls do nothing."""

    def __init__(self, *arguments):
        self.arguments, self.slots, self.node, self.items, self.running = arguments, {}, None, [], 0
        self.currentPath, self.value = "", 0.0
        if arguments and isinstance(arguments[0], str):
            made[arguments[0]] = self

    def connect(self, signal, slot):
        self.slots[signal] = slot

    def emit(self, signal):
        self.slots[signal]()

    def currentNode(self):
        return self.node

    def addItems(self, items):
        self.currentText = items[0]

    def start(self):
        self.running = True

    def stop(self):
        self.running = False

    def __getattr__(self, name):
        if name.startswith("__") or name[0].islower() is False:
            raise AttributeError(name)
        return lambda *arguments: None


made = {}  # buttons by their text
told, installed, settings = [], [], {}


def matrix_array(matrix):
    return numpy.array([[matrix.GetElement(r, c) for c in range(4)] for r in range(4)])


def array_from_volume(node):
    scalars = node.image.GetPointData().GetScalars()
    return vtk_to_numpy(scalars).reshape(node.image.GetDimensions()[::-1])


def volume_modified(node):
    node.shown += 1
    node.image.GetPointData().GetScalars().Modified()
    node.Modified()


def clone(scene, node, name):
    return scene.add(Volume(name, array_from_volume(node), node.matrix))


class Logic:
    pass


class ModuleWidget:
    def __init__(self, parent=None):
        self.layout = Widget()

    def setup(self):
        pass


class Module:
    def __init__(self, parent):
        self.parent = parent


class Settings:
    def setValue(self, key, value):
        settings[key] = value


def install(environment):
    """Puts the stand-ins where the module imports them; the stand-in of slicer."""
    space = types.SimpleNamespace
    util = space(
        arrayFromVolume=array_from_volume,
        arrayFromVolumeModified=volume_modified,
        arrayFromVTKMatrix=matrix_array,
        arrayFromMarkupsControlPoints=lambda node, world: node.points,
        arrayFromMarkupsCurvePoints=lambda node, world: numpy.repeat(node.points, 2, axis=0),
        startupEnvironment=lambda: dict(environment),
        setSliceViewerLayers=lambda background: settings.update(background=background),
        settingsValue=lambda key, default: settings.get(key, default),
        errorDisplay=told.append,
        pip_install=installed.append,
    )
    slicer = types.ModuleType("slicer")
    slicer.util, slicer.mrmlScene, slicer.app = util, Scene(), Widget()
    slicer.modules = space(volumes=space(logic=lambda: space(CloneVolume=clone)))
    slicer.vtkMRMLTransformNode, slicer.vtkOrientedGridTransform = Transform, OrientedGrid
    slicer.qMRMLNodeComboBox = Widget
    base = types.ModuleType("slicer.ScriptedLoadableModule")
    base.ScriptedLoadableModule, base.ScriptedLoadableModuleLogic = Module, Logic
    base.ScriptedLoadableModuleWidget = ModuleWidget
    qt, ctk = types.ModuleType("qt"), types.ModuleType("ctk")
    for name in ("QLabel", "QFormLayout", "QPushButton", "QComboBox", "QTimer"):
        setattr(qt, name, Widget)
    qt.QSettings, qt.Qt, qt.QApplication = Settings, space(WaitCursor=3), Widget()
    qt.QFileDialog = space(getOpenFileName=lambda *arguments: settings.get("wheel", ""))
    ctk.ctkCollapsibleButton, ctk.ctkDoubleSpinBox = Widget, Widget
    ctk.ctkPathLineEdit = type("PathLineEdit", (Widget,), {"Files": 2})
    for module in (slicer, base, qt, ctk):
        sys.modules[module.__name__] = module
    return slicer
