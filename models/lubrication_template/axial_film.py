"""Example of your own lubrication FMU: change `advance`; README.md explains build and run."""

from typing import NamedTuple

import numpy as np

from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import constant, input_variable, output_variable, parameter


class AxialFilmState(NamedTuple):
    film: np.ndarray  # film thickness at the end of the last step [m], shape of the grid


class AxialFilm(FieldSlave):
    """Film with axial flow only.

    Eq. (U8):  dq/dy + dh/dt = 0,   q = -h^3/(12 mu) dp/dy - U h/2,   p = 0 at both edges
    """

    name, description, state_type = "axial_film", "Film with axial flow only", AxialFilmState

    @staticmethod
    def variables(options):
        grid = tuple(options["grid"])
        return [
            constant("n_circumferential", grid[0], "Cells around the skirt"),
            constant("n_axial", grid[1], "Cells along the skirt"),
            constant("contract_version", 2, "Version of the lubrication contract"),
            parameter("viscosity", "Pa.s", "Viscosity of the oil", 0.012, 1e-5, 1e3),
            parameter("bore_radius", "m", "Radius of the bore", 28.25e-3, 1e-3, 1.0),
            parameter("skirt_length", "m", "Length of the skirt", 27e-3, 1e-3, 2.0),
            input_variable("film_thickness", "m", "Film thickness", 2e-5, 1e-5, grid),
            input_variable("sliding_velocity", "m/s", "Velocity of the skirt", 0.0, 1.0, grid),
            output_variable("nodal_pressure_force", "N", "Pressure times cell area", 1.0, grid),
            output_variable("nodal_friction_force", "N", "Axial force on the skirt", 0.1, grid),
            output_variable("pressure", "Pa", "Pressure, gauge", 1e6, grid),
            output_variable("minimum_film_thickness", "m", "Minimum film thickness", 1e-5),
            output_variable("maximum_pressure", "Pa", "Maximum pressure, gauge", 1e6),
        ]

    def start(self, values):
        return self.advance(AxialFilmState(values["film_thickness"]), values, 0.0, 1.0)

    def advance(self, state, values, time, step):
        film = values["film_thickness"]
        gap, speed = film.clip(min=1e-6), values["sliding_velocity"]
        dy = values["skirt_length"] / film.shape[1]
        area = dy * 2 * np.pi * values["bore_radius"] / film.shape[0]
        resistance = 12 * values["viscosity"] / gap**3
        wedge = np.cumsum((film - state.film) / step, axis=1) * dy - speed * gap / 2
        inflow = np.average(wedge, axis=1, weights=resistance, keepdims=True)
        rise = resistance * (wedge - inflow) * dy  # over a cell, Eq. (U8)
        pressure = np.maximum(np.cumsum(rise, axis=1) - rise / 2, 0.0)  # cut off (Gumbel)
        shear = gap / 2 * rise / dy * (pressure > 0)
        shear -= values["viscosity"] * speed / gap  # Eq. (F1)
        nodal = {"nodal_pressure_force": pressure * area, "nodal_friction_force": shear * area}
        extremes = {"maximum_pressure": pressure.max(), "minimum_film_thickness": film.min()}
        return AxialFilmState(film), nodal | extremes | {"pressure": pressure}
