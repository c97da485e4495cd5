"""Constants of a film during a run, from its parameters."""

from typing import Any, NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable
from . import step_parts as parts
from .balance import oil_layer
from .balance.film_step import Domain
from .balance.flow_film import FilmLaws
from .balance.grid import Array
from .balance.oil_layer import Bore
from .contradictions import FROM_BORE_AND_RING, FROM_EDGES
from .laws import coating, friction
from .laws.asperity import contact_constants
from .oil import thinning_law
from .summary import Halves

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
    """Arrays of a film.

    contact : of `asperity.contact_table`; halves : summary.Halves; factors : of
    `roughness.fill_factor_table`, of shape (0, 0) without flow factors; faces : of
    `oil_layer.Bore`.
    """

    contact: Array
    halves: Halves
    factors: Array
    faces: Array


@compilable
def fixed_of(
    x: Any, chosen: Any, bearing: bool, on_bore: bool, domain: Domain, tables: Tables
) -> FilmConstants:
    """Return the constants of a film.

    Parameters
    ----------
    x, chosen : parameters.Numbers, parameters.Chosen
    bearing : bool
        Whether the film is that of a bearing.
    on_bore : bool
        False omits the oil on the bore, which a tangent does not need.
    domain : film_step.Domain
    tables : Tables
    """
    cells = domain.cells
    n_c, n_a = domain.open_cells.shape
    area = np.zeros((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            if not domain.open_cells[i, j]:
                area[i, j] = cells.dx * cells.dy
    surfaces = parts.Surfaces(
        area,
        contact_constants(x, tables.contact),
        tables.halves,
        coating.compliance(x.coating_thickness, x.coating_modulus, x.coating_poisson),
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
        FilmLaws(x.minimum_flow_film, x.roughness_rms, tables.factors, thinning),
        bearing,
        SHARE_OF_A_BEARING if bearing else SHARE_OF_A_SKIRT,
        x.bore_radius,
        oil_layer.bore_of(supply, tables.faces, cells, n_a),
    )
