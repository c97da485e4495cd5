"""Constants of a film during a run, from its parameters."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable, compiled
from ..master.fmi.odd_cells import first_odd
from ..master.fmi.symmetry import half_grid
from . import step_parts as parts
from .balance import oil_layer, openings
from .balance.film_step import Domain
from .balance.flow_film import FilmLaws
from .balance.oil_layer import Bore
from .common.faults import refuse
from .common.grid import Array, Cells, Field, Flags, images, keep
from .contradictions import (
    FROM_BORE_AND_RING,
    FROM_EDGES,
    FULL_TURN,
    PATIR_CHENG_1978,
    cavitation_of,
)
from .laws import cavitation, coating, friction, roughness
from .laws.asperity import CONTACT_LAWS, contact_constants, contact_table
from .laws.oil import thinning_law
from .summary import Halves, halves

# ratio of the entrainment velocity to the sliding velocity, in the frame of the grid, which is
# fixed to the skirt or to the shell of a bearing
SHARE_OF_A_SKIRT = -0.5
SHARE_OF_A_BEARING = 0.5

BY_FILM_FRACTION = 1 + friction.CAVITY_SHEAR.index("film_fraction")  # as in `parameters.Chosen`


class FilmConstants(NamedTuple):
    """Constants of a film during a run.

    domain : film_step.Domain; surfaces : step_parts.Surfaces; laws : flow_film.FilmLaws;
    share : of the sliding velocity that is entrainment [-]; radius : of the bore [m];
    bore : oil_layer.Bore.
    """

    domain: Domain
    surfaces: parts.Surfaces
    laws: FilmLaws
    share: float
    radius: float
    bore: Bore


class Tables(NamedTuple):
    """Arrays of a film that depend on its build options, and two that `fill` sets.

    bearing : whether it is a bearing's; open_cells : cells without a film; contact : of
    `asperity.contact_table` by law; halves : summary.Halves; faces : of `oil_layer.Bore`;
    rows : row of the grid for each row of the film, which are more if the grid is mirrored;
    nearest_cell : of `openings.nearest`; factors : of `roughness.factor_table`.
    """

    bearing: bool
    open_cells: Annotated[Flags, "n_c, n_a"]
    contact: Annotated[Array, "2, 513, 6"]
    halves: Halves
    faces: Annotated[Array, "n_e, n_c"]
    rows: Annotated[Array, "n_f"]
    nearest_cell: Field
    factors: Annotated[Array, f"{roughness.TABLE[0]}, {roughness.TABLE[1]}"]


def tables_of(open_cells: Flags, bearing: bool, mirrored: bool = False) -> Tables:
    """Return the tables of a film. `fill` sets the empty ones.

    Parameters
    ----------
    open_cells : ndarray of bool, shape (n_f, n_a)
        Cells of the whole grid that have no film.
    bearing : bool
    mirrored : bool
        Whether the grid is one half of the film, `parameters.has_image`. Its first row is on the
        thrust line and its last one on the anti-thrust line.
    """
    whole = len(open_cells)
    first, last, rows = half_grid(whole) if mirrored else (0, whole, np.arange(whole))
    cells = np.ascontiguousarray(open_cells[first:last])
    return Tables(
        bearing=bearing,
        open_cells=cells,
        contact=np.array([contact_table(law) for law in CONTACT_LAWS]),
        halves=Halves(*(each[first:last] for each in halves(whole))),
        faces=oil_layer.skirt_edges(cells),
        rows=rows.astype(float),
        nearest_cell=np.zeros(cells.shape),
        factors=np.zeros(roughness.TABLE),
    )


@compilable
def is_mirrored(tables: Tables) -> bool:
    """Return whether the grid is one half of the film."""
    return len(tables.rows) > len(tables.open_cells)


@compilable
def first_row(tables: Tables) -> int:
    """Return the row of the film that is the first one of the grid."""
    return len(tables.rows) // 4 if is_mirrored(tables) else 0


@compilable
def images_of(tables: Tables) -> Array:
    """Return the number of cells of the film that each cell represents, 0 in openings."""
    n_c, n_a = tables.open_cells.shape
    number = np.zeros((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            if not tables.open_cells[i, j]:
                number[i, j] = images(is_mirrored(tables), i, n_c)  # Eq. (E19)
    return number


@compilable
def cells_of(x: Any, tables: Tables) -> Cells:
    """Return the size of the cells."""
    width = x.sector_angle * x.bore_radius
    mirrored = is_mirrored(tables)
    ring = x.sector_angle == FULL_TURN and not mirrored
    n_a = tables.open_cells.shape[1]
    return Cells(width / len(tables.rows), x.skirt_length / n_a, ring, mirrored)


@compilable
def fill(x: Any, chosen: Any, tables: Tables) -> None:
    """Set the tables that depend on parameters."""
    cells = cells_of(x, tables)
    keep(tables.nearest_cell, openings.nearest(tables.open_cells, cells))
    if chosen.flow_factors == PATIR_CHENG_1978:
        skirt, bore = x.peklenik_number_skirt, x.peklenik_number_bore
        share = x.roughness_share_skirt
        keep(tables.factors, roughness.factor_table(share, skirt, bore, tables.bearing))


@compiled
def _even_part(rows: Array, n_c: int, fields: Array):
    """Return the even part of fields of a film, (m, n_f, n_a), Eq. (I14), on n_c rows."""
    m, n_f, n_a = fields.shape
    even = np.zeros((m, n_c, n_a))
    for q in range(m):
        for k in range(n_f):
            i = int(rows[k])
            for j in range(n_a):
                even[q, i, j] += fields[q, k, j] / images(True, i, n_c)  # Eq. (I14)
    return even


@compilable
def on_grid(tables: Tables, has_openings: bool, fields: Array) -> Array:
    """Return fields of a film, shape (m, n_f, n_a), on its grid, shape (m, n_c, n_a).

    Those on a mirrored grid are the even part. Cut-outs show the nearest cell with a film.
    """
    if is_mirrored(tables):
        fields = _even_part(tables.rows, len(tables.open_cells), fields)
    return openings.with_nearest_values(tables.nearest_cell, fields) if has_openings else fields


@compilable
def check_even(tables: Tables, field: Array, fault: float, faults: Array) -> None:
    """Note a fault at the first cell where an input is not that of its mirror image.

    Parameters
    ----------
    tables : Tables
    field : ndarray, shape (n_f, n_a)
    fault : float
        Number of its sentence.
    faults : ndarray
    """
    if is_mirrored(tables):
        i, j, k = first_odd(field, tables.open_cells)
        if i >= 0:  # as all noted rows, from the first one of the grid
            refuse(faults, fault, i - first_row(tables), j, field[i, j], field[k, j], 0.0)


@compiled
def _unfolded(rows: Array, fields: Array, is_shared: bool):
    """Return the fields on a mirrored grid, (m, n_c, n_a), on the whole film."""
    m, n_c, n_a = fields.shape
    n_f = len(rows)
    whole = np.empty((m, n_f, n_a))
    for q in range(m):
        for k in range(n_f):
            i = int(rows[k])
            share = images(is_shared, i, n_c)
            for j in range(n_a):
                whole[q, k, j] = fields[q, i, j] / share
    return whole


@compilable
def on_film(tables: Tables, fields: Array, is_shared: bool) -> Array:
    """Return fields on a grid, shape (m, n_c, n_a), on the whole film, shape (m, n_f, n_a).

    is_shared : whether a value on the grid is the sum over all images, as of forces.
    """
    return _unfolded(tables.rows, fields, is_shared) if is_mirrored(tables) else fields


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
    model = cavitation_of(x, chosen)
    domain = Domain(
        cells=cells,
        open_cells=tables.open_cells,
        has_openings=bool(tables.open_cells.any()),
        model=model,
        together=cavitation.at_once(n_c, n_a),
        bearing=tables.bearing,
        is_lifted=model.rounding == 0.0,
    )
    factors = np.zeros((0, 0))
    if chosen.flow_factors == PATIR_CHENG_1978:
        factors = tables.factors
    surfaces = parts.Surfaces(
        area=images_of(tables) * (cells.dx * cells.dy),
        contact=contact_constants(x, tables.contact[int(chosen.contact_law) - 1]),
        halves=tables.halves,
        compliance=coating.compliance(x.coating_thickness, x.coating_modulus, x.coating_poisson),
        coating_thickness=x.coating_thickness,
        cavitation_pressure=x.cavitation_pressure,
        rounding_velocity=x.friction_rounding_velocity,
        by_oil=chosen.cavity_shear == BY_FILM_FRACTION,
    )
    thinning = thinning_law(int(chosen.shear_thinning_law) - 1, x)
    supply = oil_layer.Supply(
        followed=on_bore and chosen.oil_supply != FROM_EDGES,
        ring=chosen.oil_supply == FROM_BORE_AND_RING,
        initial_layer=x.initial_oil_layer,
        stroke=x.stroke,
        chamfer_capacity=x.chamfer_capacity,
        largest_layer=x.largest_oil_layer,
    )
    return FilmConstants(
        domain=domain,
        surfaces=surfaces,
        laws=FilmLaws(x.minimum_flow_film, x.roughness_rms, factors, thinning),
        share=SHARE_OF_A_BEARING if tables.bearing else SHARE_OF_A_SKIRT,
        radius=x.bore_radius,
        bore=oil_layer.bore_of(supply, tables.faces, cells, n_a),
    )
