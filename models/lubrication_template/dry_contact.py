"""Contact without oil, as multibody programs do it: a spring and a damper between skirt and bore,
Coulomb friction.

To compare with a lubricated run:  piston-cosim pack models/lubrication_template/dry_contact.py:DryContact --output dry.fmu
"""

from dataclasses import dataclass

import numpy as np
from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import Variable, constant


@dataclass(frozen=True)
class State:
    film: np.ndarray  # gap at the end of the last step [m]


class DryContact(FieldSlave):
    """Eq. (U9):  p = k d + c max(dd/dt, 0) where d = max(h0 - h, 0) > 0,   f = -mu p tanh(U / U0)

    h: gap, h0: gap at which the surfaces touch, d: overlap, k, c: stiffness and damping per area,
    U0: rounding velocity.
    """

    name, description, state_type = "dry_contact", "Skirt contact without oil", State

    @staticmethod
    def variables(options):
        grid = tuple(options["grid"])
        return [
            constant("n_circumferential", grid[0], "Cells around the skirt"),
            constant("n_axial", grid[1], "Cells along it"),
            constant("contract_version", 2, "Version of the lubrication contract"),
            Variable(
                "stiffness",
                "Pa/m",
                "parameter",
                "Contact pressure per overlap",
                1e12,
                minimum=1e6,
                maximum=1e16,
            ),
            Variable("damping_time", "s", "parameter", "c / k", 1e-4, minimum=0.0, maximum=1.0),
            Variable(
                "touching_gap",
                "m",
                "parameter",
                "Gap at which the surfaces touch",
                1e-6,
                minimum=0.0,
                maximum=1e-3,
            ),
            Variable(
                "friction_coefficient", "1", "parameter", "Coulomb's", 0.1, minimum=0.0, maximum=2.0
            ),
            Variable(
                "rounding_velocity", "m/s", "parameter", "U0", 0.01, minimum=1e-6, maximum=10.0
            ),
            Variable(
                "bore_radius",
                "m",
                "parameter",
                "Radius of the bore",
                28.25e-3,
                minimum=1e-3,
                maximum=1.0,
            ),
            Variable(
                "skirt_length",
                "m",
                "parameter",
                "Length of the skirt",
                27e-3,
                minimum=1e-3,
                maximum=2.0,
            ),
            Variable(
                "film_thickness",
                "m",
                "input",
                "Gap, bore minus skirt",
                2e-5,
                nominal=1e-5,
                shape=grid,
            ),
            Variable(
                "sliding_velocity", "m/s", "input", "Skirt minus bore", 0.0, nominal=1.0, shape=grid
            ),
            Variable(
                "nodal_pressure_force", "N", "output", "Contact force", nominal=1.0, shape=grid
            ),
            Variable(
                "nodal_friction_force",
                "N",
                "output",
                "Axial friction on the skirt",
                nominal=0.1,
                shape=grid,
            ),
            Variable(
                "asperity_pressure", "Pa", "output", "Contact pressure", nominal=1e6, shape=grid
            ),
            Variable("minimum_film_thickness", "m", "output", "Smallest gap", nominal=1e-5),
            Variable("friction_power", "W", "output", "Power that sliding costs", nominal=100.0),
        ]

    def start(self, values):
        return self.advance(State(values["film_thickness"]), values, 0.0, 1.0)

    def advance(self, state, values, time, step):
        film, speed = values["film_thickness"], values["sliding_velocity"]
        area = (
            values["skirt_length"]
            / film.shape[1]
            * 2
            * np.pi
            * values["bore_radius"]
            / film.shape[0]
        )
        overlap = np.maximum(values["touching_gap"] - film, 0.0)
        closing = np.where(overlap > 0, np.maximum((state.film - film) / step, 0.0), 0.0)
        pressure = values["stiffness"] * (overlap + values["damping_time"] * closing)  # Eq. (U9)
        friction = (
            -values["friction_coefficient"]
            * pressure
            * np.tanh(speed / values["rounding_velocity"])
            * area
        )
        return State(film), {
            "nodal_pressure_force": pressure * area,
            "nodal_friction_force": friction,
            "asperity_pressure": pressure,
            "minimum_film_thickness": film.min(),
            "friction_power": -float(np.sum(friction * speed)),
        }
