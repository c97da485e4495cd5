"""Inclined pad with an oil that shear thins: generalised-Newtonian solution, and the film model."""

from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from piston_cosim.fmu_ehd.laws.oil import Oil, thinning
from piston_cosim.fmu_ehd.parameters import Parameters

from .motored import film_after

LENGTH, INLET, OUTLET = 10e-3, 4e-6, 2e-6  # [m]
TEMPERATURE = 373.15  # [K]
NODES, WEIGHTS = (np.polynomial.legendre.leggauss(16) + np.array([[1.0], [0.0]])) / 2.0


def viscosity(oil: Oil, rate: np.ndarray) -> np.ndarray:
    """Return the viscosity at a shear rate [Pa s]."""
    return oil.viscosity * thinning(oil.thinning, np.abs(rate), TEMPERATURE)[0]


def load_of(gradient: Callable[[float], np.ndarray], x: np.ndarray, speed: float) -> float:
    """Return the load [N/m] of the flow whose pressure gradient carries no pressure to the exit."""
    bounds = 0.5 * speed * OUTLET, 0.5 * speed * INLET
    rise = gradient(brentq(lambda q: np.trapezoid(gradient(q), x), *bounds))
    pressure = np.append(0.0, np.cumsum((rise[1:] + rise[:-1]) / 2.0 * np.diff(x)))
    return np.trapezoid(pressure, x) * LENGTH**2


def isotropic_load(oil: Oil, speed: float, cells: int = 200) -> float:
    """Return the load with one viscosity, that of the shear rate speed / h [N/m]."""
    x = np.linspace(0.0, 1.0, cells + 1)
    h = INLET + (OUTLET - INLET) * x
    mu = viscosity(oil, speed / h)
    return load_of(lambda q: 12.0 * mu * (speed * h / 2.0 - q) / h**3, x, speed)


def generalised_newtonian_load(oil: Oil, speed: float, cells: int = 200) -> float:
    """Return the load with mu(u') u' = tau + p' z at each section [N/m].

    Newton's method solves for p' and tau at all sections: the speed of the moving surface, at
    z = h/2, and the flow. Gauss quadrature integrates across the film.
    """
    x = np.linspace(0.0, 1.0, cells + 1)
    h = INLET + (OUTLET - INLET) * x
    stress = viscosity(oil, speed / h) * speed / h
    table = np.append(0.0, np.geomspace(1e-4, 1e3, 20001)) * speed / OUTLET
    stresses = viscosity(oil, table) * table
    z = NODES[:, None] - 0.5

    def surplus(slope, mean, flow):
        local = stress * (mean + slope * z)
        rate = np.sign(local) * np.interp(np.abs(local), stresses, table)
        passed = 0.5 * speed * h - h**2 * (WEIGHTS[:, None] * z * rate).sum(axis=0)
        moved = h * (WEIGHTS[:, None] * rate).sum(axis=0)
        return np.array([moved / speed - 1.0, (passed - flow) / (speed * h)])

    def gradient(flow):
        slope, mean, small = np.zeros(cells + 1), np.ones(cells + 1), 1e-5
        for _ in range(30):
            now = surplus(slope, mean, flow)
            by_slope = (surplus(slope + small, mean, flow) - now) / small
            by_mean = (surplus(slope, mean + small, flow) - now) / small
            jacobian = np.stack([by_slope, by_mean], axis=-1).transpose(1, 0, 2)
            change = np.linalg.solve(jacobian, -now.T[:, :, None])[:, :, 0]
            slope, mean = slope + change[:, 0], mean + change[:, 1]
            if np.abs(change).max() < 1e-9:
                return slope * stress / h
        raise RuntimeError("no pressure gradient after 30 iterations")

    return load_of(gradient, x, speed)


def model_load(oil: Oil, speed: float, cells: int = 200) -> float:
    """Return the load of the film model [N/m]."""
    parameters = Parameters((2, cells), oil=oil, bore_radius=0.5 / np.pi, skirt_length=LENGTH)
    film = INLET + (OUTLET - INLET) * (np.arange(cells) + 0.5) / cells
    return film_after(parameters, [film] * 2, -speed, 1e-3).outputs["nodal_pressure_force"].sum()
