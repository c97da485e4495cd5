"""Constants of a film during a run, from its parameters."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable
from . import step_parts as parts
from .balance import oil_layer, openings
from .balance.film_step import Domain
from .balance.flow_film import FilmLaws
from .balance.grid import Array, Cells, Field, Flags, keep
from .balance.oil_layer import Bore
from .contradictions import (
    FROM_BORE_AND_RING,
    FROM_EDGES,
    FULL_TURN,
    PATIR_CHENG_1978,
    cavitation_of,
)
from .laws import cavitation, coating, friction, roughness
from .laws.asperity import CONTACT_LAWS, contact_constants, contact_table
from .oil import thinning_law
from .summary import Halves, halves

# entrainment velocity in the frame of the grid, which rides on the skirt or rests on the shell of a
# bearing, to the sliding velocity
SHARE_OF_A_SKIRT = -0.5
SHARE_OF_A_BEARING = 0.5

BY_FILM_FRACTION = 1 + friction.CAVITY_SHEAR.index("film_fraction")  # as in `parameters.Chosen`


class FilmConstants(NamedTuple):
    """Constants of a film during a run.

    domain : film_step.Domain; surfaces : step_parts.Surfaces; laws : flow_film.FilmLaws;
    bearing : whether it is a bearing's; share : of the sliding velocity that is entrainment [-];
    radius : of the bore [m]; bore : oil_layer.Bore.
    """

    domain: Domain
    surfaces: parts.Surfaces
    laws: FilmLaws
    bearing: bool
    share: float
    radius: float
    bore: Bore


class Tables(NamedTuple):
    """Arrays of a film that depend on its build options, and two that `fill` sets.

    bearing : whether it is a bearing's; open_cells : cells without a film; contact : of
    `asperity.contact_table` by law; halves : summary.Halves; faces : of `oil_layer.Bore`;
    beside : of `openings.nearest`; factors : of `roughness.factor_table`.
    """

    bearing: bool
    open_cells: Annotated[Flags, "n_c, n_a", "within(x, 0.0, 2.0) and n_c > 0 and n_a > 0"]
    contact: Annotated[Array, "2, 513, 6"]
    halves: Halves
    faces: Annotated[Array, "n_e, n_c", "n_e % 2 == 0 and are_edges(x, n_a)"]
    beside: Field
    factors: Annotated[Array, f"{roughness.TABLE[0]}, {roughness.TABLE[1]}"]


def tables_of(open_cells: Flags, bearing: bool) -> Tables:
    """Return the tables of a film with room for those that `fill` sets."""
    return Tables(
        bearing,
        open_cells,
        np.array([contact_table(law) for law in CONTACT_LAWS]),
        halves(len(open_cells)),
        oil_layer.skirt_edges(open_cells),
        np.zeros(open_cells.shape),
        np.zeros(roughness.TABLE),
    )


@compilable
def cells_of(x: Any, tables: Tables) -> Cells:
    """Return the size of the cells."""
    n_c, n_a = tables.open_cells.shape
    width = x.sector_angle * x.bore_radius
    return Cells(width / n_c, x.skirt_length / n_a, x.sector_angle == FULL_TURN)


@compilable
def fill(x: Any, chosen: Any, tables: Tables) -> None:
    """Set the tables that depend on parameters."""
    cells = cells_of(x, tables)
    keep(tables.beside, openings.nearest(tables.open_cells, cells.dx, cells.dy))
    if chosen.flow_factors == PATIR_CHENG_1978:
        skirt, bore = x.peklenik_number_skirt, x.peklenik_number_bore
        share = x.roughness_share_skirt
        keep(tables.factors, roughness.factor_table(share, skirt, bore, tables.bearing))


@compilable
def filled(tables: Tables, has_openings: bool, fields: Array) -> Array:
    """Return fields, shape (m, n_c, n_a), whose cut-outs show the nearest cell with a film."""
    return openings.filled(tables.beside, fields) if has_openings else fields


@compilable
def fixed_of(x: Any, chosen: Any, tables: Tables, on_bore: bool) -> FilmConstants:
    """Return the constants of a film.

    Parameters
    ----------
    x, chosen : parameters.Numbers, parameters.Chosen
    tables : Tables
        After `fill`.
    on_bore : bool
        False omits the oil on the bore, which a tangent does not need.
    """
    cells = cells_of(x, tables)
    n_c, n_a = tables.open_cells.shape
    domain = Domain(
        cells,
        tables.open_cells,
        bool(tables.open_cells.any()),
        cavitation_of(chosen),
        cavitation.at_once(n_c, n_a),
    )
    factors = np.zeros((0, 0))
    if chosen.flow_factors == PATIR_CHENG_1978:
        factors = tables.factors
    area = np.zeros((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            if not domain.open_cells[i, j]:
                area[i, j] = cells.dx * cells.dy
    surfaces = parts.Surfaces(
        area,
        contact_constants(x, tables.contact[int(chosen.contact_law) - 1]),
        tables.halves,
        coating.compliance(x.coating_thickness, x.coating_modulus, x.coating_poisson),
        x.coating_thickness,
        x.cavitation_pressure,
        x.friction_rounding_velocity,
        chosen.cavity_shear == BY_FILM_FRACTION,
    )
    thinning = thinning_law(int(chosen.shear_thinning_law) - 1, x)
    supply = oil_layer.Supply(
        on_bore and chosen.oil_supply != FROM_EDGES,
        chosen.oil_supply == FROM_BORE_AND_RING,
        x.initial_oil_layer,
        x.stroke,
        x.chamfer_capacity,
        x.largest_oil_layer,
    )
    return FilmConstants(
        domain,
        surfaces,
        FilmLaws(x.minimum_flow_film, x.roughness_rms, factors, thinning),
        tables.bearing,
        SHARE_OF_A_BEARING if tables.bearing else SHARE_OF_A_SKIRT,
        x.bore_radius,
        oil_layer.bore_of(supply, tables.faces, cells, n_a),
    )
