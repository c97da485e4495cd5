"""Contradictions between parameters that are each in range, and the oil supply of a film.

An edge below the cavitation pressure contains no liquid. An edge that is only partly filled must be
at the cavitation pressure, because the model has no gas at another pressure inside the film. A
higher pressure would press oil in as if the edge were flooded. If the oil comes from the bore, an
edge is at the cavitation pressure, and its film fraction follows from the layer. The layer on the
bore exists only for a skirt that slides along its bore. A sector has its supply at both ends, and
no openings between them.
"""

from typing import Any, NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable
from ..master.fmi.symmetry import THRUST_PLANE
from .common.faults import FAULT, refuse
from .common.grid import (
    FIRST,
    LAST,
    LOWER,
    OPENINGS,
    UPPER,
    Array,
    Edges,
    Entrainment,
    Flags,
    unlimited_supply,
)
from .laws.cavitation import CAVITATION, Cavitation
from .laws.oil import VISCOSITY_LAWS
from .laws.piezoviscosity import PressureLaw, reduced_at_edges
from .laws.roughness import FLOW_FACTORS

OIL_SUPPLIES = ("edges", "bore", "bore_and_ring")
OPENING_SUPPLIES = ("lower_edge", "own")
FULL_TURN = 2.0 * np.pi
FROM_EDGES = 1 + OIL_SUPPLIES.index("edges")
FROM_BORE_AND_RING = 1 + OIL_SUPPLIES.index("bore_and_ring")
OWN_SUPPLY = 1 + OPENING_SUPPLIES.index("own")
PATIR_CHENG_1978 = 1 + FLOW_FACTORS.index("patir_cheng_1978")
"""Numbers of choices as in `parameters.Chosen`."""
MODELS = tuple(CAVITATION.values())


class AmbientPressures(NamedTuple):
    """Pressures around a film [Pa].

    The cavitation pressure p_c, and the pressures above it at lower edge, upper edge and openings.
    """

    cavitation: float
    lower: float
    upper: float
    opening: float


@compilable
def cavitation_of(x: Any, chosen: Any) -> Cavitation:
    """Return the cavitation model of a film."""
    conserving, switching, clipping, _ = MODELS[int(chosen.cavitation_model) - 1]
    return Cavitation(conserving, switching, clipping, x.cavitation_rounding)


@compilable
def outside_of(x: Any, chosen: Any) -> AmbientPressures:
    """Return the pressures around a film from `parameters.Numbers` and `Chosen`."""
    least = x.cavitation_pressure
    lower = x.pressure_lower_edge - least
    opening = x.pressure_openings - least if chosen.opening_supply == OWN_SUPPLY else lower
    return AmbientPressures(least, lower, x.pressure_upper_edge - least, opening)


@compilable
def edges_of(
    x: Any, chosen: Any, outside: AmbientPressures, law: PressureLaw, shape: tuple[int, int]
) -> Edges:
    """Return the edges of a grid with unlimited oil; both ends of a sector are openings."""
    below = x.film_fraction_lower_edge
    own = chosen.opening_supply == OWN_SUPPLY
    pressure = np.full(5, outside.opening)
    fraction = np.full(5, x.film_fraction_openings if own else below)
    pressure[LOWER] = outside.lower
    fraction[LOWER] = below
    pressure[UPPER] = outside.upper
    fraction[UPPER] = x.film_fraction_upper_edge
    return Edges(reduced_at_edges(law, pressure), fraction, unlimited_supply(shape))


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
    least: float, pressure: float, fraction: float, fault: float, follows: float, faults: Array
) -> None:
    """Note the faults of an edge whose oil comes from the bore."""
    if pressure != least:
        refuse(faults, fault, 0, 0, pressure, least, 0.0)
    if fraction != 1.0:
        refuse(faults, follows, 0, 0, fraction, 0.0, 0.0)


@compilable
def check_supply(x: Any, chosen: Any, faults: Array) -> None:
    """Note what is wrong with the oil supply at the edges and in openings."""
    least = x.cavitation_pressure
    lower, below = x.pressure_lower_edge, x.film_fraction_lower_edge
    upper, above = x.pressure_upper_edge, x.film_fraction_upper_edge
    opening, fraction = x.pressure_openings, x.film_fraction_openings
    own = chosen.opening_supply == OWN_SUPPLY
    _check_edge(
        least, lower, below, FAULT.lower_below_cavitation, FAULT.lower_partly_filled, faults
    )
    _check_edge(
        least, upper, above, FAULT.upper_below_cavitation, FAULT.upper_partly_filled, faults
    )
    if own:
        too_low = FAULT.openings_below_cavitation
        _check_edge(least, opening, fraction, too_low, FAULT.openings_partly_filled, faults)
    elif fraction != 1.0 or opening != 0.0:
        refuse(faults, FAULT.openings_without_effect, 0, 0, fraction, opening, 0.0)
    if chosen.oil_supply == FROM_EDGES:
        return
    fault = FAULT.lower_not_at_cavitation
    _check_edge_on_bore(least, lower, below, fault, FAULT.lower_fraction_follows, faults)
    fault = FAULT.upper_not_at_cavitation
    _check_edge_on_bore(least, upper, above, fault, FAULT.upper_fraction_follows, faults)
    if own:
        refuse(faults, FAULT.openings_follow, 0, 0, 0.0, 0.0, 0.0)
    if not cavitation_of(x, chosen).conserving:
        refuse(faults, FAULT.from_bore_not_conserving, 0, 0, 0.0, 0.0, 0.0)


@compilable
def check_parameters(
    x: Any, chosen: Any, bearing: bool, cut_outs: bool, has_image: bool, faults: Array
) -> None:
    """Note contradictions between parameters, except those of the oil x.

    `bearing`, `cut_outs` and `has_image` state whether the film is that of a bearing, has openings,
    and has cells that are their own mirror image.
    """
    if chosen.film_symmetry == THRUST_PLANE and not has_image:
        refuse(faults, FAULT.cells_without_image, 0, 0, 0.0, 0.0, 0.0)
    sector = x.sector_angle
    part = sector < FULL_TURN
    rough = chosen.flow_factors == PATIR_CHENG_1978
    if part and not bearing:
        refuse(faults, FAULT.sector_of_a_skirt, 0, 0, sector, 0.0, 0.0)
    if bearing and chosen.oil_supply != FROM_EDGES:
        refuse(faults, FAULT.oil_on_a_bearing, 0, 0, 0.0, 0.0, 0.0)
    if bearing and part and cut_outs:
        refuse(faults, FAULT.cut_outs_in_a_sector, 0, 0, sector, FULL_TURN, 0.0)
    if chosen.viscosity_law - 1 == VISCOSITY_LAWS.two_point and x.viscosity_40 <= x.viscosity_100:
        refuse(faults, FAULT.viscosities_reversed, 0, 0, x.viscosity_40, x.viscosity_100, 0.0)
    if rough and x.roughness_rms <= 0.0:
        refuse(faults, FAULT.factors_without_roughness, 0, 0, 0.0, 0.0, 0.0)
    rounding = x.cavitation_rounding
    if rounding > 0.0 and (x.coating_thickness > 0.0 or not cavitation_of(x, chosen).conserving):
        refuse(faults, FAULT.rounding_without_jfo, 0, 0, rounding, 0.0, 0.0)


def is_fed(edges: Edges, entrainment: Entrainment, open_cells: Flags, ring: bool) -> bool:
    """Return whether oil enters a film from an edge or an opening.

    Oil enters if the pressure there is above cavitation, or if oil there moves into the film. A
    steady film that conserves oil without any of both has drained.

    Parameters
    ----------
    edges : grid.Edges
    entrainment : grid.Entrainment
        [m/s].
    open_cells : ndarray of bool, shape (n_c, n_a)
        Cells without a film.
    ring : bool
        False for a sector.
    """
    around, along = entrainment
    film = ~open_cells
    row, column = np.indices(film.shape)
    ends = (
        (LOWER, column == 0, along > 0.0),
        (UPPER, column == film.shape[1] - 1, along < 0.0),
        (FIRST, (row == 0) & (not ring), around > 0.0),
        (LAST, (row == film.shape[0] - 1) & (not ring), around < 0.0),
        (OPENINGS, np.roll(open_cells, 1, 0), around > 0.0),
        (OPENINGS, np.roll(open_cells, -1, 0), around < 0.0),
        (OPENINGS, np.roll(open_cells, 1, 1) & (column > 0), along > 0.0),
        (OPENINGS, np.roll(open_cells, -1, 1) & (column < film.shape[1] - 1), along < 0.0),
    )
    return any(
        bool(
            (
                film
                & next_to_edge
                & ((edges.pressure[k] > 0.0) | inward & (edges.film_fraction[k] > 0.0))
            ).any()
        )
        for k, next_to_edge, inward in ends
    )
