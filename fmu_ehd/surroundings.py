"""What holds around and in the oil during a step: edges, temperature, viscosity."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from .balance.grid import Array, Edges
from .contradictions import Outside, edges_of, outside_of
from .laws.cavitation import NotConverged
from .laws.piezoviscosity import PressureLaw
from .parameters import CONDITION_NAMES, Parameters, supply_faults, supply_of


class Surroundings(NamedTuple):
    """Conditions around and in the oil during a step.

    edges : grid.Edges, with reduced pressures, Eq. (O6); outside : contradictions.Outside;
    temperature, viscosity : ndarray, shape (n_c, n_a), T [K], low-shear mu_0 [Pa s];
    pressure_law : piezoviscosity.PressureLaw;
    ring_layer, splash : oil that the ring leaves above the skirt [m], and that is thrown below it
    [m/s].
    """

    edges: Edges
    outside: Outside
    temperature: Array
    viscosity: Array
    pressure_law: PressureLaw
    ring_layer: float
    splash: float


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
        If the oil supply at an edge is impossible, `contradictions`.
    """
    p = parameters
    given = {name: conditions.get(name, getattr(p, name)) for name in CONDITION_NAMES}
    if sentences := supply_faults(p, given):
        raise NotConverged("; ".join(sentences))
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
    supply = supply_of(p, given)
    outside = outside_of(supply)
    return Surroundings(
        edges_of(supply, outside, law, p.shape),
        outside,
        np.ascontiguousarray(temperature),
        viscosity,
        law,
        given["oil_ring_layer"],
        given["oil_splash"],
    )
