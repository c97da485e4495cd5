"""Contact without oil as in multibody programs: spring, damper and Coulomb friction.

To compare it with a lubricated run:

piston-cosim fmu build models/lubrication_template/dry_contact.py:DryContact --output dry.fmu
"""

from dataclasses import dataclass

import numpy as np

from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import constant, input_variable, output_variable, parameter


@dataclass(frozen=True)
class DryContactState:
    film: np.ndarray  # gap at the end of the last step [m]


class DryContact(FieldSlave):
    """Contact of skirt and bore without oil.

    Eq. (U9):  p = k d + c max(dd/dt, 0) where d = max(h0 - h, 0) > 0,   f = -mu p tanh(U / U0)

    h: gap, h0: gap at which the surfaces touch, d: overlap, k, c: stiffness and damping per
    area, U0: rounding velocity.
    """

    name, description, state_type = "dry_contact", "Skirt contact without oil", DryContactState

    @staticmethod
    def variables(options):
        grid = tuple(options["grid"])
        return [
            constant("n_circumferential", grid[0], "Cells around the skirt"),
            constant("n_axial", grid[1], "Cells along the skirt"),
            constant("contract_version", 2, "Version of the lubrication contract"),
            parameter("stiffness", "Pa/m", "Contact pressure per overlap", 1e12, 1e6, 1e16),
            parameter("damping_time", "s", "c / k", 1e-4, 0.0, 1.0),
            parameter("touching_gap", "m", "Gap at which the surfaces touch", 1e-6, 0.0, 1e-3),
            parameter("friction_coefficient", "1", "Coulomb's", 0.1, 0.0, 2.0),
            parameter("rounding_velocity", "m/s", "U0", 0.01, 1e-6, 10.0),
            parameter("bore_radius", "m", "Radius of the bore", 28.25e-3, 1e-3, 1.0),
            parameter("skirt_length", "m", "Length of the skirt", 27e-3, 1e-3, 2.0),
            input_variable("film_thickness", "m", "Film thickness", 2e-5, 1e-5, grid),
            input_variable("sliding_velocity", "m/s", "Velocity of the skirt", 0.0, 1.0, grid),
            output_variable("nodal_pressure_force", "N", "Contact force", 1.0, grid),
            output_variable("nodal_friction_force", "N", "Friction force on the skirt", 0.1, grid),
            output_variable("asperity_pressure", "Pa", "Contact pressure", 1e6, grid),
            output_variable("minimum_film_thickness", "m", "Minimum film thickness", 1e-5),
            output_variable("friction_power", "W", "Friction power", 100.0),
        ]

    def start(self, values):
        return self.advance(DryContactState(values["film_thickness"]), values, 0.0, 1.0)

    def advance(self, state, values, time, step):
        film = values["film_thickness"]
        speed = values["sliding_velocity"]
        strip = values["skirt_length"] / film.shape[1]
        area = strip * 2 * np.pi * values["bore_radius"] / film.shape[0]
        overlap = np.maximum(values["touching_gap"] - film, 0.0)
        closing = np.where(overlap > 0, np.maximum((state.film - film) / step, 0.0), 0.0)
        pressure = values["stiffness"] * (overlap + values["damping_time"] * closing)  # Eq. (U9)
        rounded = np.tanh(speed / values["rounding_velocity"])
        friction = -values["friction_coefficient"] * pressure * rounded * area
        return DryContactState(film), {
            "nodal_pressure_force": pressure * area,
            "nodal_friction_force": friction,
            "asperity_pressure": pressure,
            "minimum_film_thickness": film.min(),
            "friction_power": -float(np.sum(friction * speed)),
        }
