"""Rigid shaft that rotates in a bearing: two translations, its weight, an unbalance.

Eq. (U17):  m x'' = W + m_u r_u w^2 (cos w t, sin w t) + F,   by the trapezoidal rule
Eq. (U18):  F = sum of pressure force (-cos a, -sin a) + circumferential force (-sin a, cos a)
Eq. (U19):  h = C - x cos a - y sin a + u
Eq. (U33):  M = sum p du/da      moment of the pressure by the slope of the shell

u is the deflection of an elastic shell, an input if the build option `shell` is true. x is to
the right, y upwards, from the axis of the shell. a is the angle of a cell around the shell from
x, a = 2 pi i / n, i = 0 .. n - 1. du/da is a central difference. The shaft stays parallel to the
shell, and its speed is constant.
"""

from dataclasses import dataclass

import numpy as np

from piston_cosim.master.fmi.errors import Discard
from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import input_variable, output_variable, parameter

GRID = (60, 12)  # cells around and along, those of the film
GRAVITY = 9.80665  # [m/s2]
ANGLE = 2.0 * np.pi / GRID[0] * np.arange(GRID[0])
OUTWARD = np.array([np.cos(ANGLE), np.sin(ANGLE)])
ONWARD = np.array([-np.sin(ANGLE), np.cos(ANGLE)])
FORCES = ("nodal_pressure_force", "nodal_circumferential_force")
SHELL = "bore_deflection"
STRAIGHT = np.zeros(GRID)  # deflection of a rigid shell


@dataclass(frozen=True)
class ShaftState:
    """State of the shaft.

    position, velocity, force : ndarray, shape (2,) [m], [m/s], sum of all forces [N];
    step : length of the last step [s].
    """

    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray
    step: float


class Shaft(FieldSlave):
    """Shaft by Eqs. (U17) to (U19)."""

    name, description, state_type = "shaft", "Rigid shaft in a bearing", ShaftState
    derivative_outputs = ("film_thickness", "circumferential_velocity")

    @property
    def derivative_inputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        return (*FORCES, SHELL) if self.options.get("shell") else FORCES

    @staticmethod
    def variables(options):
        shell = [input_variable(SHELL, "m", "Outward deflection u of the shell", 0.0, 1e-5, GRID)]
        return [
            *(shell if options.get("shell") else ()),
            input_variable("nodal_pressure_force", "N", "Film pressure force", 0.0, 1.0, GRID),
            input_variable("nodal_circumferential_force", "N", "Film shear force", 0.0, 0.1, GRID),
            parameter("radius", "m", "Radius of the shaft", 25e-3, 1e-3, 1.0),
            parameter("clearance", "m", "Radial clearance C", 40e-6, 1e-6, 1e-3),
            parameter("mass", "kg", "Mass m on this bearing", 20.0, 1e-3, 1e5),
            parameter("speed", "rad/s", "Angular speed w", 314.15926535897933, -1e5, 1e5),
            parameter("unbalance", "kg.m", "Unbalance m_u r_u on this bearing", 0.0, 0.0, 10.0),
            parameter("start_x", "m", "Horizontal displacement at the start", 0.0, -1e-3, 1e-3),
            parameter("start_y", "m", "Vertical displacement at the start", 0.0, -1e-3, 1e-3),
            output_variable("film_thickness", "m", "Film thickness h", 1e-5, GRID, start=1e-5),
            output_variable("circumferential_velocity", "m/s", "Surface velocity", 1.0, GRID),
            output_variable("horizontal_displacement", "m", "Horizontal displacement x", 1e-5),
            output_variable("vertical_displacement", "m", "Vertical displacement y", 1e-5),
            output_variable("eccentricity", "1", "Displacement divided by clearance"),
            output_variable("horizontal_force", "N", "Film force on the shaft along x", 100.0),
            output_variable("vertical_force", "N", "Film force on the shaft along y", 100.0),
            output_variable("drive_torque", "N.m", "Torque that keeps the speed constant", 1.0),
        ]

    def start(self, values):
        position = np.array([values["start_x"], values["start_y"]])
        state = ShaftState(position, np.zeros(2), self._load(values, 0.0), 0.0)
        return state, self._shown(state, values)

    def advance(self, state, values, time, step):
        force = self._film(values) + self._load(values, time + step)
        change = 0.5 * step * (state.force + force) / values["mass"]  # Eq. (U17)
        velocity = state.velocity + change
        position = state.position + 0.5 * step * (state.velocity + velocity)
        if np.hypot(*position) > 5.0 * values["clearance"]:
            raise Discard(f"the shaft left its bearing: x, y = {position} m at {time + step:g} s")
        state = ShaftState(position, velocity, force, step)
        return state, self._shown(state, values)

    def directional_derivative(self, seeds):
        gain = 0.25 * self.state.step**2 / self.views["mass"].item()
        move = gain * film_force(*(seeds[name] for name in FORCES))
        thinner = -np.broadcast_to((move @ OUTWARD)[:, None], GRID)
        opened = seeds.get(SHELL, STRAIGHT)
        return dict(film_thickness=thinner + opened, circumferential_velocity=np.zeros(GRID))

    def _film(self, values):
        return film_force(values["nodal_pressure_force"], values["nodal_circumferential_force"])

    def _load(self, values, time):
        """Return weight and unbalance, Eq. (U17) [N]."""
        turned = values["speed"] * time
        thrown = values["unbalance"] * values["speed"] ** 2
        down = np.array([0.0, -values["mass"] * GRAVITY])
        return down + thrown * np.array([np.cos(turned), np.sin(turned)])

    def _shown(self, state, values):
        x, y = state.position
        horizontal, vertical = force = self._film(values)
        # about the axis of the shaft: moment about the axis of the shell less that of the force
        around = values["radius"] * values["nodal_circumferential_force"].sum()
        opened = values.get(SHELL, STRAIGHT)
        slope = (np.roll(opened, -1, axis=0) - np.roll(opened, 1, axis=0)) / (2.0 * ANGLE[1])
        # Eq. (U33)
        slanted = np.sum(values["nodal_pressure_force"] * slope)
        moment = around - (x * vertical - y * horizontal) + slanted
        film = values["clearance"] - (state.position @ OUTWARD)[:, None] + opened  # Eq. (U19)
        return dict(
            film_thickness=film,
            circumferential_velocity=np.full(GRID, values["radius"] * values["speed"]),
            horizontal_displacement=x,
            vertical_displacement=y,
            eccentricity=np.hypot(x, y) / values["clearance"],
            horizontal_force=force[0],
            vertical_force=force[1],
            drive_torque=-moment,
        )


def film_force(pressure, around):
    """Return F [N]."""
    # Eq. (U18)
    return ONWARD @ around.sum(axis=1) - OUTWARD @ pressure.sum(axis=1)
