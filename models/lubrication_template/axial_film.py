"""A lubrication FMU of your own: change `pressure` and build it with

piston-cosim pack models/lubrication_template/axial_film.py:AxialFilm --grid 40x40 --output film.fmu
piston-cosim run numerical_example --lubrication film.fmu
"""

from dataclasses import dataclass

import numpy as np
from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import Variable, constant


@dataclass(frozen=True)
class State:
    film: np.ndarray  # film thickness at the end of the last step [m], shape of the grid


class AxialFilm(FieldSlave):
    """Oil that flows along the skirt only, strip by strip, with negative pressures cut off
    (Gumbel).

    Eq. (U8):  dq/dy + dh/dt = 0,   q = -h^3/(12 mu) dp/dy - U h/2,   p = 0 at both edges
    Eq. (U12):  tau = -(mu V/h - h/2 dp/dy), the opposite of the shear on the bore,   V = 2 U
    """

    name, description, state_type = "axial_film", "Film with axial flow only", State

    @staticmethod
    def variables(options):
        grid = tuple(options["grid"])
        return [
            constant("n_circumferential", grid[0], "Cells around the skirt"),
            constant("n_axial", grid[1], "Cells along it"),
            constant("contract_version", 2, "Version of the lubrication contract"),
            Variable(
                "viscosity",
                "Pa.s",
                "parameter",
                "Viscosity of the oil",
                0.012,
                minimum=1e-5,
                maximum=1e3,
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
                "film_thickness", "m", "input", "Bore minus skirt", 2e-5, nominal=1e-5, shape=grid
            ),
            Variable(
                "sliding_velocity", "m/s", "input", "Skirt minus bore", 0.0, nominal=1.0, shape=grid
            ),
            Variable(
                "nodal_pressure_force",
                "N",
                "output",
                "Pressure x cell area",
                nominal=1.0,
                shape=grid,
            ),
            Variable(
                "nodal_friction_force",
                "N",
                "output",
                "Axial force of the film on the skirt; its opposite acts on the bore",
                nominal=0.1,
                shape=grid,
            ),
            Variable("pressure", "Pa", "output", "Pressure, gauge", nominal=1e6, shape=grid),
            Variable("minimum_film_thickness", "m", "output", "Thinnest film", nominal=1e-5),
            Variable("maximum_pressure", "Pa", "output", "Highest pressure, gauge", nominal=1e6),
        ]

    def start(self, values):
        return self.advance(State(values["film_thickness"]), values, 0.0, 1.0)

    def advance(self, state, values, time, step):
        film, speed, viscosity = (
            values["film_thickness"].clip(min=1e-6),
            values["sliding_velocity"],
            values["viscosity"],
        )
        dy = values["skirt_length"] / film.shape[1]
        area = dy * 2 * np.pi * values["bore_radius"] / film.shape[0]
        resistance = 12 * viscosity / film**3
        wedge = (
            np.cumsum((values["film_thickness"] - state.film) / step, axis=1) * dy
            - speed * film / 2
        )
        inflow = (resistance * wedge).sum(axis=1, keepdims=True) / resistance.sum(
            axis=1, keepdims=True
        )
        rise = resistance * (wedge - inflow) * dy  # over a cell, Eq. (U8)
        pressure = np.maximum(np.cumsum(rise, axis=1) - rise / 2, 0.0)
        gradient = np.where(pressure > 0.0, rise / dy, 0.0)
        return State(values["film_thickness"]), {
            "nodal_pressure_force": pressure * area,
            # Eq. (U12)
            "nodal_friction_force": -(viscosity * speed / film - film / 2 * gradient) * area,
            "pressure": pressure,
            "maximum_pressure": pressure.max(),
            "minimum_film_thickness": values["film_thickness"].min(),
        }
