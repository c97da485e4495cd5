"""What holds around and in the oil during a step: edges, temperature, viscosity."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .cavitation import NotConverged
from .grid import Array, Edges, in_plenty
from .parameters import CONDITION_NAMES, Parameters, bore_faults, edge_faults
from .piezoviscosity import PressureLaw, reduced_at_edges


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
    pressure_law : piezoviscosity.PressureLaw
    ring_layer, splash : float
        Oil that the ring leaves above the skirt [m], and that is thrown below it [m/s].
    opening : float
        Pressure in openings, and at both ends of a sector, above cavitation pressure [Pa].
    """

    edges: Edges
    lower: float
    upper: float
    temperature: Array
    viscosity: Array
    pressure_law: PressureLaw
    ring_layer: float
    splash: float
    opening: float


def surroundings(parameters: Parameters, conditions: Mapping[str, Any]) -> Surroundings:
    """Edges, temperature and viscosity of a step.

    Parameters
    ----------
    parameters : parameters.Parameters
    conditions : mapping
        Any of `parameters.CONDITION_NAMES` in place of the parameter of that name, and
        `oil_temperature` [K], float or ndarray of shape (n_c, n_a), in place of both edge
        temperatures.

    Returns
    -------
    Surroundings

    Raises
    ------
    cavitation.NotConverged
        If the oil supply at an edge is impossible, `parameters.edge_faults`.
    """
    p = parameters
    given = {name: conditions.get(name, getattr(p, name)) for name in CONDITION_NAMES}
    sentences = edge_faults(p, given)
    if p.oil_supply != "edges":
        sentences += bore_faults(p, given)
    if sentences:
        raise NotConverged("; ".join(sentences))
    lower = given["pressure_lower_edge"] - p.cavitation_pressure
    upper = given["pressure_upper_edge"] - p.cavitation_pressure
    _, n_axial = p.shape
    along = (np.arange(n_axial) + 0.5) / n_axial
    profile = (
        given["oil_temperature_lower_edge"] * (1.0 - along)
        + given["oil_temperature_upper_edge"] * along
    )
    temperature = np.broadcast_to(
        np.asarray(conditions.get("oil_temperature", profile), dtype=float), p.shape
    )
    viscosity = np.ascontiguousarray(p.oil.low_shear_viscosity(temperature))
    law = p.oil.pressure_law(viscosity)
    below = given["film_fraction_lower_edge"]
    opening, entering = lower, below
    if p.opening_supply == "own":
        opening = given["pressure_openings"] - p.cavitation_pressure
        entering = given["film_fraction_openings"]
    # both ends of a sector are openings
    pressure = np.array([lower, upper, opening, opening, opening])
    fraction = np.array([below, given["film_fraction_upper_edge"], entering, entering, entering])
    edges = Edges(reduced_at_edges(law, pressure), fraction, in_plenty(p.shape))
    return Surroundings(
        edges,
        lower,
        upper,
        temperature,
        viscosity,
        law,
        given["oil_ring_layer"],
        given["oil_splash"],
        opening,
    )
