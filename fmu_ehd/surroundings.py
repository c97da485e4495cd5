"""What holds around and in the oil during a step: edges, temperature, viscosity."""

from dataclasses import dataclass

import numpy as np

from .cavitation import NotConverged
from .grid import Edges
from .parameters import CONDITIONS


@dataclass(frozen=True)
class Surroundings:
    """What holds around and in the oil during a step.

    Parameters
    ----------
    edges : grid.Edges
        With reduced pressures, Eq. (O6).
    lower, upper : float
        Edge pressures above cavitation pressure [Pa].
    temperature, viscosity : ndarray, shape (n_c, n_a)
        T [K], low-shear mu_0 [Pa s].
    thickening : object or None
        Pressure-viscosity law of `oil`.
    """

    edges: Edges
    lower: float
    upper: float
    temperature: np.ndarray
    viscosity: np.ndarray
    thickening: object


def surroundings(parameters, conditions):
    """Edges, temperature and viscosity of a step.

    Parameters
    ----------
    parameters : parameters.Parameters
    conditions : dict
        Any of `parameters.CONDITIONS` in place of the parameter of that name, and `oil_temperature`
        [K], float or ndarray of shape (n_c, n_a), in place of both edge temperatures.

    Returns
    -------
    Surroundings

    Raises
    ------
    cavitation.NotConverged
        If an edge is below cavitation pressure.
    """
    p = parameters
    given = {name: conditions.get(name, getattr(p, name)) for name in CONDITIONS}
    lower, upper = (
        given[f"pressure_{edge}_edge"] - p.cavitation_pressure for edge in ("lower", "upper")
    )
    if min(lower, upper) < 0.0:
        raise NotConverged(
            f"edge pressure {min(lower, upper):g} Pa above cavitation pressure: must not be below it"
        )
    along = (np.arange(p.shape[1]) + 0.5) / p.shape[1]
    profile = (
        given["oil_temperature_lower_edge"] * (1.0 - along)
        + given["oil_temperature_upper_edge"] * along
    )
    temperature = np.broadcast_to(
        np.asarray(conditions.get("oil_temperature", profile), dtype=float), p.shape
    )
    viscosity = np.ascontiguousarray(p.oil.low_shear_viscosity(temperature))
    law = p.oil.thickening(viscosity.mean()) if p.oil.pressure_viscosity_law != "none" else None
    pressure = np.array([lower, upper, 0.0, 0.0])
    fraction = np.array(
        [given["film_fraction_lower_edge"], given["film_fraction_upper_edge"], 1.0, 1.0]
    )
    return Surroundings(
        Edges(law.reduced(pressure) if law else pressure, fraction),
        lower,
        upper,
        temperature,
        viscosity,
        law,
    )
