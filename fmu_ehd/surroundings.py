"""Conditions of a step around and in the oil: edges, temperature, viscosity."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable, compiled
from ..master.fmi.noted import none_yet, sentences_of
from .common.faults import FAULTS, NotConverged
from .common.grid import Array, Edges
from .contradictions import AmbientPressures, check_supply, edges_of, outside_of
from .laws.oil import low_shear_viscosity
from .laws.piezoviscosity import TABLE, PressureLaw, pressure_law
from .parameters import Numbers, Parameters, chosen_of, numbers_of


class Surroundings(NamedTuple):
    """Conditions around and in the oil during a step.

    edges : grid.Edges, with reduced pressures, Eq. (O6); outside : contradictions.AmbientPressures;
    temperature, viscosity : ndarray, shape (n_c, n_a), T [K], low-shear mu_0 [Pa s];
    pressure_law : piezoviscosity.PressureLaw;
    ring_layer, splash : layer that the oil ring leaves above the skirt [m], and splash of oil below
    it [m/s].
    """

    edges: Edges
    outside: AmbientPressures
    temperature: Array
    viscosity: Array
    pressure_law: PressureLaw
    ring_layer: float
    splash: float


@compiled
def temperature_between_edges(x, shape):
    """Return the temperature [K] of every cell, linear between both edges."""
    n_c, n_a = shape
    temperature = np.empty(shape)
    for j in range(n_a):
        along = (j + 0.5) / n_a
        for i in range(n_c):
            temperature[i, j] = x.oil_temperature_lower_edge * (1.0 - along)
            temperature[i, j] += x.oil_temperature_upper_edge * along
    return temperature


@compiled
def viscosity_by_temperature(x, chosen, temperature):
    """Return the low-shear viscosity [Pa s] of every cell, Eqs. (O1) to (O3)."""
    kind = int(chosen.viscosity_law) - 1
    viscosity = np.empty(temperature.shape)
    for i in range(temperature.shape[0]):
        for j in range(temperature.shape[1]):
            viscosity[i, j] = low_shear_viscosity(kind, x, temperature[i, j])
    return viscosity


@compiled
def pressure_law_of(x, chosen, viscosity, images):
    """Return `piezoviscosity.PressureLaw` of a film."""
    kind = int(chosen.pressure_viscosity_law) - 1
    alpha = x.pressure_viscosity_coefficient
    return pressure_law(kind, alpha, viscosity, images, np.zeros(TABLE))


@compilable
def surroundings_of(x: Any, chosen: Any, temperature: Array, images: Array) -> Surroundings:
    """Return `Surroundings` from numbers, choices, temperatures and images of `pressure_law`."""
    viscosity = viscosity_by_temperature(x, chosen, temperature)
    law = pressure_law_of(x, chosen, viscosity, images)
    outside = outside_of(x, chosen)
    n_c, n_a = temperature.shape
    edges = edges_of(x, chosen, outside, law, (n_c, n_a))
    return Surroundings(
        edges=edges,
        outside=outside,
        temperature=temperature,
        viscosity=viscosity,
        pressure_law=law,
        ring_layer=x.oil_ring_layer,
        splash=x.oil_splash,
    )


def changed_numbers(
    parameters: Parameters, conditions: Mapping[str, Any]
) -> tuple[Numbers, list[str]]:
    """Return the numbers of a step, and the faults of the oil supply, `contradictions`.

    Parameters and conditions are those of `surroundings`.
    """
    numbers = {n: float(v) for n, v in conditions.items() if n != "oil_temperature"}
    x = numbers_of(parameters)._replace(**numbers)
    noted = none_yet()
    check_supply(x, chosen_of(parameters), noted)
    return x, sentences_of(noted, FAULTS)


def surroundings(
    parameters: Parameters, conditions: Mapping[str, Any], images: Array
) -> Surroundings:
    """Return edges, temperature and viscosity of a step.

    Parameters
    ----------
    parameters : parameters.Parameters
    conditions : mapping
        Any of `parameters.TUNABLE` instead of the parameter of that name, and
        `oil_temperature` [K], float or ndarray of shape (n_c, n_a), instead of both edge
        temperatures.
    images : ndarray, shape (n_c, n_a)
        As for `piezoviscosity.pressure_law`.

    Returns
    -------
    Surroundings

    Raises
    ------
    cavitation.NotConverged
        If the oil supply at an edge is impossible, `contradictions`.
    """
    x, faults = changed_numbers(parameters, conditions)
    if faults:
        raise NotConverged("; ".join(faults))
    if "oil_temperature" in conditions:
        temperature = np.full(images.shape, conditions["oil_temperature"], float)
    else:
        temperature = temperature_between_edges(x, images.shape)
    return surroundings_of(x, chosen_of(parameters), temperature, images)
