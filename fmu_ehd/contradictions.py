"""What does not go together among parameters that are each in range, and what supplies a film.

An edge below cavitation pressure holds no liquid. One that is only partly filled is a cavity at
cavitation pressure: the model knows no gas at another pressure inside the film, and a higher one
would press oil in as if the edge were flooded. With oil from the bore an edge is at cavitation
pressure, and its film fraction follows from the layer. Oil on the bore is known for a skirt that
slides along its bore alone. A sector has its supply at both ends, and no openings between.
"""

from typing import Any, NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable
from .balance.grid import LOWER, UPPER, Array, Edges, in_plenty
from .faults import (
    CUT_OUTS_IN_A_SECTOR,
    FACTORS_WITHOUT_ROUGHNESS,
    FROM_BORE_NOT_CONSERVING,
    LOWER_BELOW_CAVITATION,
    LOWER_FRACTION_FOLLOWS,
    LOWER_NOT_AT_CAVITATION,
    LOWER_PARTLY_FILLED,
    OIL_ON_A_BEARING,
    OPENINGS_BELOW_CAVITATION,
    OPENINGS_FOLLOW,
    OPENINGS_PARTLY_FILLED,
    OPENINGS_WITHOUT_EFFECT,
    SECTOR_OF_A_SKIRT,
    UPPER_BELOW_CAVITATION,
    UPPER_FRACTION_FOLLOWS,
    UPPER_NOT_AT_CAVITATION,
    UPPER_PARTLY_FILLED,
    VISCOSITIES_REVERSED,
    refuse,
)
from .laws.cavitation import CAVITATION, Cavitation
from .laws.piezoviscosity import PressureLaw, reduced_at_edges
from .laws.roughness import FLOW_FACTORS
from .oil import VISCOSITY_LAWS

OIL_SUPPLIES = ("edges", "bore", "bore_and_ring")
OPENING_SUPPLIES = ("lower_edge", "own")
FULL_TURN = 2.0 * np.pi
FROM_EDGES = 1 + OIL_SUPPLIES.index("edges")
FROM_BORE_AND_RING = 1 + OIL_SUPPLIES.index("bore_and_ring")
OWN_SUPPLY = 1 + OPENING_SUPPLIES.index("own")
PATIR_CHENG_1978 = 1 + FLOW_FACTORS.index("patir_cheng_1978")
"""Numbers of choices as in `parameters.Chosen`."""
MODELS = tuple(CAVITATION.values())


class Supply(NamedTuple):
    """Oil supply at the edges and in openings.

    Pressures are gauge [Pa], film fractions [-]; own : whether openings have a supply of their own;
    from_bore : whether oil comes from the bore; conserving : whether the cavitation model conserves
    oil.
    """

    cavitation_pressure: float
    pressure_lower_edge: float
    pressure_upper_edge: float
    pressure_openings: float
    film_fraction_lower_edge: float
    film_fraction_upper_edge: float
    film_fraction_openings: float
    own: bool
    from_bore: bool
    conserving: bool


class AmbientPressures(NamedTuple):
    """Pressures around a film [Pa].

    The cavitation pressure p_c, and the pressures above it at lower edge, upper edge and openings.
    """

    cavitation: float
    lower: float
    upper: float
    opening: float


@compilable
def supply_of(x: Any, chosen: Any) -> Supply:
    """Return the oil supply of a film from `parameters.Numbers` and `Chosen`."""
    return Supply(
        x.cavitation_pressure,
        x.pressure_lower_edge,
        x.pressure_upper_edge,
        x.pressure_openings,
        x.film_fraction_lower_edge,
        x.film_fraction_upper_edge,
        x.film_fraction_openings,
        chosen.opening_supply == OWN_SUPPLY,
        chosen.oil_supply != FROM_EDGES,
        cavitation_of(chosen).conserving,
    )


@compilable
def cavitation_of(chosen: Any) -> Cavitation:
    """Return the cavitation model of a film."""
    return MODELS[int(chosen.cavitation_model) - 1]


@compilable
def outside_of(supply: Supply) -> AmbientPressures:
    """Pressures around a film."""
    least = supply.cavitation_pressure
    lower = supply.pressure_lower_edge - least
    opening = supply.pressure_openings - least if supply.own else lower
    return AmbientPressures(least, lower, supply.pressure_upper_edge - least, opening)


@compilable
def edges_of(
    supply: Supply, outside: AmbientPressures, law: PressureLaw, shape: tuple[int, int]
) -> Edges:
    """Edges of a grid where oil is in plenty; both ends of a sector are openings."""
    below = supply.film_fraction_lower_edge
    pressure = np.full(5, outside.opening)
    fraction = np.full(5, supply.film_fraction_openings if supply.own else below)
    pressure[LOWER] = outside.lower
    fraction[LOWER] = below
    pressure[UPPER] = outside.upper
    fraction[UPPER] = supply.film_fraction_upper_edge
    return Edges(reduced_at_edges(law, pressure), fraction, in_plenty(shape))


@compilable
def _check_edge(
    least: float, pressure: float, fraction: float, below: float, partly: float, faults: Array
) -> None:
    """Note what is wrong with an edge, as fault `below` or `partly`."""
    if pressure < least:
        refuse(faults, below, 0, 0, pressure, least, fraction)
    elif fraction < 1.0 and pressure > least:
        refuse(faults, partly, 0, 0, pressure, least, fraction)


@compilable
def _check_edge_on_bore(
    least: float, pressure: float, fraction: float, apart: float, follows: float, faults: Array
) -> None:
    """Note the faults of an edge whose oil comes from the bore."""
    if pressure != least:
        refuse(faults, apart, 0, 0, pressure, least, 0.0)
    if fraction != 1.0:
        refuse(faults, follows, 0, 0, fraction, 0.0, 0.0)


@compilable
def check_supply(supply: Supply, faults: Array) -> None:
    """Note what is wrong with the oil supply at the edges and in openings."""
    least = supply.cavitation_pressure
    lower = supply.pressure_lower_edge
    filled_below = supply.film_fraction_lower_edge
    upper = supply.pressure_upper_edge
    filled_above = supply.film_fraction_upper_edge
    _check_edge(least, lower, filled_below, LOWER_BELOW_CAVITATION, LOWER_PARTLY_FILLED, faults)
    _check_edge(least, upper, filled_above, UPPER_BELOW_CAVITATION, UPPER_PARTLY_FILLED, faults)
    pressure = supply.pressure_openings
    fraction = supply.film_fraction_openings
    if supply.own:
        below = OPENINGS_BELOW_CAVITATION
        _check_edge(least, pressure, fraction, below, OPENINGS_PARTLY_FILLED, faults)
    elif fraction != 1.0 or pressure != 0.0:
        refuse(faults, OPENINGS_WITHOUT_EFFECT, 0, 0, fraction, pressure, 0.0)
    if not supply.from_bore:
        return
    apart = LOWER_NOT_AT_CAVITATION
    _check_edge_on_bore(least, lower, filled_below, apart, LOWER_FRACTION_FOLLOWS, faults)
    apart = UPPER_NOT_AT_CAVITATION
    _check_edge_on_bore(least, upper, filled_above, apart, UPPER_FRACTION_FOLLOWS, faults)
    if supply.own:
        refuse(faults, OPENINGS_FOLLOW, 0, 0, 0.0, 0.0, 0.0)
    if not supply.conserving:
        refuse(faults, FROM_BORE_NOT_CONSERVING, 0, 0, 0.0, 0.0, 0.0)


@compilable
def check_parameters(x: Any, chosen: Any, bearing: bool, cut_outs: bool, faults: Array) -> None:
    """Note contradictions between parameters, except those of the oil supply.

    `bearing` and `cut_outs` state whether the film is that of a bearing and has cut-outs.
    """
    sector = x.sector_angle
    part = sector < FULL_TURN
    rough = chosen.flow_factors == PATIR_CHENG_1978
    if part and not bearing:
        refuse(faults, SECTOR_OF_A_SKIRT, 0, 0, sector, 0.0, 0.0)
    if bearing and chosen.oil_supply != FROM_EDGES:
        refuse(faults, OIL_ON_A_BEARING, 0, 0, 0.0, 0.0, 0.0)
    if bearing and part and cut_outs:
        refuse(faults, CUT_OUTS_IN_A_SECTOR, 0, 0, sector, FULL_TURN, 0.0)
    if chosen.viscosity_law - 1 == VISCOSITY_LAWS.two_point and x.viscosity_40 <= x.viscosity_100:
        refuse(faults, VISCOSITIES_REVERSED, 0, 0, x.viscosity_40, x.viscosity_100, 0.0)
    if rough and x.roughness_rms <= 0.0:
        refuse(faults, FACTORS_WITHOUT_ROUGHNESS, 0, 0, 0.0, 0.0, 0.0)
