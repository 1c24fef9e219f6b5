# SPDX-FileCopyrightText: 2026 The Pliant authors
# SPDX-License-Identifier: Apache-2.0
"""A simulation for stEVE's interventions (arXiv 2410.01956), instead of its SofaBeamAdapter.

Example:
    >>> from pliant.steve import Simulation
    >>> simulation = Simulation(wall="deforming")
    >>> # intervention = eve.intervention.MonoPlaneStatic(…, simulation=simulation, …)

Works with and without the package eve: with it, the class is one of eve's simulations. SOFA isn't
needed. Lengths are mm, positions those of the vessel tree, rotations rad, durations s.
"""

from __future__ import annotations

import copy
import logging
import math
from collections.abc import Sequence
from typing import Any

import numpy
import numpy.typing

from pliant._core import (
    CatheterScene,
    VesselWall,
    read_surface,
    wall_around_surface,
)
from pliant._error import Error

try:
    from eve.intervention.simulation import (  # type: ignore[import-not-found, unused-ignore]
        Simulation as _Base,
    )
except ImportError:
    _Base = object

Array = numpy.typing.NDArray[Any]

_WALL: dict[str, Any] = {"thickness_mm": 2.5, "layers": 1, "cell_mm": 1.8}
_INSERTED_MM = 0.1  # at first
_TURNING_S = 0.2  # in which a new catheter is rotated


def settings_of_device(device: Any, young_modulus_pa: float = 1e3) -> dict[str, Any]:
    """Settings of a catheter like one of stEVE's devices (settings_of("catheter")).

    Args:
        device: With the attributes of eve's procedural shapes, or with them in `sofa_device`.
        young_modulus_pa: Unit of its moduli. Its densities are kg/mm^3, so kg, mm and s give kPa.

    Raises:
        pliant.Error: The device has the shape of a mesh.
    """
    shape = getattr(device, "sofa_device", device)
    if not getattr(shape, "is_a_procedural_shape", True):
        raise Error(
            "devices: expected a straight or J-shaped device, found one with the shape of a mesh",
            field="devices",
        )

    def stiffness(modulus: float, radius: float, inner: float) -> float:
        return modulus * young_modulus_pa * 1e-6 * math.pi / 4 * (radius**4 - inner**4)

    length = float(shape.length)
    tip = max(0.0, length - float(shape.straight_length))
    shaft = stiffness(shape.young_modulus, shape.radius, shape.inner_radius)
    settings = {
        "length_mm": length,
        "radius_mm": float(shape.radius),
        "bend_n_mm2": shaft,
        "twist_n_mm2": shaft / (1 + float(shape.poisson_ratio)),
        "mass_g_mm": 1e3 * shape.mass_density * math.pi * (shape.radius**2 - shape.inner_radius**2),
        "tip_mm": tip,
        "tip_bend_n_mm2": shaft,
    }
    if tip > 0:
        settings["tip_bend_n_mm2"] = stiffness(
            shape.young_modulus_extremity, shape.radius_extremity, shape.inner_radius_extremity
        )
    return settings


def bend_of_device(device: Any) -> float:
    """Bend of the tip of one of stEVE's devices [rad]: the length of its arc over its radius."""
    shape = getattr(device, "sofa_device", device)
    tip = max(0.0, float(shape.length) - float(shape.straight_length))
    diameter = float(shape.spire_diameter)
    return 2 * tip / diameter if diameter > 0 else 0.0


class Simulation(_Base):  # type: ignore[misc, unused-ignore]
    """One straight or J-shaped device in a vessel, with the interface of eve's simulations.

    As in SofaBeamAdapter, reset() keeps everything if vessel and insertion are the same, devices
    start rotated at random, and step() makes whole time steps.

    Args:
        friction: Coulomb's coefficient on the wall.
        dt_simulation: Time step [s].
        wall: "rigid", as stEVE's, or "deforming".
        segment_mm: Length of the device's segments.
        young_modulus_pa: Unit of the device's moduli [Pa].
        threads: 0: one for each core.
    """

    def __init__(
        self,
        friction: float = 0.1,
        dt_simulation: float = 0.006,
        wall: str = "rigid",
        segment_mm: float = 3.0,
        young_modulus_pa: float = 1e3,
        threads: int = 1,
    ) -> None:
        if wall not in ("rigid", "deforming"):
            raise Error(f"wall: expected one of deforming, rigid, found {wall}", field="wall")
        self.logger = logging.getLogger(self.__module__)
        self.friction, self.dt_simulation = friction, dt_simulation
        self.wall, self.segment_mm = wall, segment_mm
        self.young_modulus_pa, self.threads = young_modulus_pa, threads
        self.simulation_error = False
        # Window attributes of SofaBeamAdapter; unused, there is no window.
        self.root = self.camera = self.target_node = self.interim_target_node = None
        self.interim_targets: list[tuple[float, float, float]] = []
        self.init_visual_nodes = False
        self.display_size, self.target_size, self.interim_target_size = (1, 1), 1.0, 1.0
        self._rng = numpy.random.default_rng()
        self._scene: CatheterScene | None = None
        self._start = numpy.zeros(0)  # the scene's state
        self._vessel: VesselWall | None = None
        self._mesh_path: str | None = None
        self._made_for: tuple[Any, ...] = ()
        self._insertion_point = numpy.zeros(3)
        self._bend_deg = 0.0
        self._dof_positions = numpy.zeros((1, 3))
        self._inserted_lengths, self._rotations = numpy.zeros(1), numpy.zeros(1)

    @property
    def dof_positions(self) -> Array:
        """Nodes of the device (n, 3), the tip first; those not inserted are at the insertion."""
        return self._dof_positions

    @property
    def inserted_lengths(self) -> Array:
        """Of each device [mm]."""
        return self._inserted_lengths

    @property
    def rotations(self) -> Array:
        """Of each device at the insertion [rad]."""
        return self._rotations

    @property
    def scene(self) -> CatheterScene:
        """Pliant's scene, for forces and the wall.

        Raises:
            pliant.Error: Before reset().
        """
        if self._scene is None:
            raise Error("simulation: expected a call of reset() before", field="simulation")
        return self._scene

    def close(self) -> None:
        """Frees the vessel and the device; reset() makes them again."""
        self._scene, self._vessel, self._mesh_path, self._made_for = None, None, None, ()

    def reset(
        self,
        insertion_point: Sequence[float] | Array,
        insertion_direction: Sequence[float] | Array,
        mesh_path: str,
        devices: Sequence[Any],
        coords_high: tuple[float, float, float] | None = None,
        coords_low: tuple[float, float, float] | None = None,
        vessel_visual_path: str | None = None,
        seed: int | None = None,
    ) -> None:
        """Makes vessel and device, unless they are there already.

        Args:
            insertion_point: In the vessel's lumen [mm].
            insertion_direction: Of any length.
            mesh_path: The lumen's surface (OBJ, STL, VTP, ...), closed or open at its ends.
            devices: One device.
            coords_high, coords_low, vessel_visual_path: Of windows; not used.

        Raises:
            pliant.Error: There is not one device, or the insertion isn't in the lumen.
        """
        if seed is not None:
            self._rng = numpy.random.default_rng(seed)
        if len(devices) != 1:
            raise Error(f"devices: expected one, found {len(devices)}", field="devices")
        settings = settings_of_device(devices[0], self.young_modulus_pa)
        bend_deg = math.degrees(bend_of_device(devices[0]))
        point = numpy.array(insertion_point, float)
        direction = numpy.array(insertion_direction, float)
        wanted = (
            tuple(point.tolist()), tuple(direction.tolist()), str(mesh_path), bend_deg,
            tuple(settings.values()),
        )  # fmt: skip
        if self._scene is not None and wanted == self._made_for:
            return
        if self._vessel is None or self._mesh_path != mesh_path:
            self._vessel = wall_around_surface(read_surface(mesh_path), (), self.threads, **_WALL)
            self._mesh_path = mesh_path
        if self.wall == "rigid":
            settings["wall_model"] = "rigid"
        self._scene = CatheterScene(
            self._vessel, (wanted[0], wanted[1]), inserted_mm=_INSERTED_MM, threads=self.threads,
            friction=self.friction, time_step_s=self.dt_simulation, segment_mm=self.segment_mm,
            sub_steps=3, box_mm=6.0, reach_mm=1.0, density_g_mm3=0.05, **settings,
        )  # fmt: skip
        self._start = self._scene.state()
        self._made_for, self._insertion_point, self._bend_deg = wanted, point, bend_deg
        self.simulation_error = False
        self._rotate_at_random()

    def reset_devices(self) -> None:
        """Withdraws the device, returns the wall to rest, and rotates the device at random."""
        self.scene.restore(self._start)
        self._rotate_at_random()

    def _rotate_at_random(self) -> None:
        turn = self._rng.random() * 2 * numpy.pi
        count = max(1, round(_TURNING_S / self.dt_simulation))
        rate = float(numpy.degrees(turn)) / (count * self.dt_simulation)
        self.scene.command(rotate_deg_s=rate, bend_first_deg=self._bend_deg)
        self.scene.step(count)
        self._update()

    def step(self, action: Array, duration: float) -> None:
        """Moves the device.

        Args:
            action: (1, 2): speed of insertion [mm/s] and of rotation [rad/s].
            duration: [s]; the whole time steps in it are made.
        """
        moves = numpy.asarray(action, float)
        if moves.shape != (1, 2):
            raise Error(f"action: expected axes (1, 2), found {moves.shape}", field="action")
        self.scene.command(
            insert_mm_s=float(moves[0, 0]), rotate_deg_s=float(numpy.degrees(moves[0, 1])),
            bend_first_deg=self._bend_deg,
        )  # fmt: skip
        try:
            self.scene.step(int(duration / self.dt_simulation + 1e-9))
        except Error as error:
            if error.code != "limit_exceeded":
                raise
            self.logger.warning("%s; resetting devices", error)
            self.simulation_error = True
            self.reset_devices()
        self._update()

    do_steps = step
    """Its name in other versions of eve, and in its SimulationMP."""

    def _update(self) -> None:
        scene = self.scene
        nodes = scene.wire_positions.copy()
        nodes[: scene.first_inserted + 1] = self._insertion_point
        measures = scene.quick_measures()
        self._dof_positions = nodes[::-1].copy()
        self._inserted_lengths = numpy.array([measures.inserted_mm])
        self._rotations = numpy.array([numpy.radians(measures.rotated_deg)])

    def add_interim_targets(
        self, positions: Sequence[tuple[float, float, float]]
    ) -> list[tuple[float, float, float]]:
        """Keeps targets to be shown; returns them."""
        self.interim_targets = [(float(p[0]), float(p[1]), float(p[2])) for p in positions]
        return list(self.interim_targets)

    def remove_interim_target(self, interim_target: tuple[float, float, float]) -> None:
        """Removes one of add_interim_targets()."""
        self.interim_targets.remove(interim_target)

    def get_config_dict(self) -> dict[str, Any]:
        """Class and arguments, of which eve makes it again in other processes (make_mp)."""
        names = ("friction", "dt_simulation", "wall", "segment_mm", "young_modulus_pa", "threads")
        return {
            "_class": f"{Simulation.__module__}.{Simulation.__name__}",
            "_id": id(self),
            **{name: getattr(self, name) for name in names},
        }

    def get_reset_state(self) -> dict[str, Any]:
        """Positions, lengths, rotations and whether there was an error: copies."""
        names = ("dof_positions", "inserted_lengths", "rotations", "simulation_error")
        return {name: copy.deepcopy(getattr(self, name)) for name in names}

    def get_step_state(self) -> dict[str, Any]:
        """As get_reset_state()."""
        return self.get_reset_state()
