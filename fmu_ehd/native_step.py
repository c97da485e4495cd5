"""What the block of a native slave holds, and how `step` is called on it.

The block is one flat piece of float64 numbers, all of a slave; `LAYOUT` says what lies in it. What
is done with it is the model's own text, so every number has the same bits; viscosities differ by
the last bit of exp and log where the C library does.
"""

from collections import namedtuple

import numpy as np

from ..master.fmi.block import flatten, room
from ..master.fmi.compiled import compiled, packed
from ..master.fmi.noted import ROOM
from . import cavitation, coating, oil_layer, openings, step
from . import step_parts as parts
from .asperity import ContactConstants, pressure_scale
from .blocks import Factors
from .contradictions import (
    FULL_TURN,
    Kind,
    Supply,
    check_kind,
    edges_of,
    outside_of,
)
from .faults import STROKE_TOO_LONG, refuse
from .film_step import Domain
from .flow_film import FilmLaws
from .grid import Array, Cells, keep
from .oil import TWO_POINT, LowShear, Thinning, low_shear_viscosity
from .piezoviscosity import TABLE as LAW_TABLE
from .piezoviscosity import PressureLaw, pressure_law
from .roughness import TABLE as FACTORS
from .roughness import fill_factor_table
from .step import Fixed, Last, Linear, Memory
from .summary import Halves
from .surroundings import Surroundings
from .variables import CONDITION_VARIABLES, OIL_VARIABLES, film_variables

# ---- what a slave is given: parameters in SI, choices by their number from 1 on

GIVEN = (*film_variables("bearing"), *CONDITION_VARIABLES, *OIL_VARIABLES)
NUMBERS = tuple(v.name for v in GIVEN if not v.choices)
CHOSEN = tuple(v.name for v in GIVEN if v.choices)
Numbers = namedtuple("Numbers", NUMBERS)
Chosen = namedtuple("Chosen", CHOSEN)
SECTOR_ANGLE = NUMBERS.index("sector_angle")
INITIAL_FILM_FRACTION = NUMBERS.index("initial_film_fraction")
_, numbers_from = packed(Numbers)
_, chosen_from = packed(Chosen)
FILM_FRACTION, _ = range(1, 3)
GREENWOOD_TRIPP_1970, _ = range(1, 3)
_, OWN = range(1, 3)
_, PATIR_CHENG_1978 = range(1, 3)
EDGES, _, BORE_AND_RING = range(1, 4)
JFO, REYNOLDS, GUMBEL, FULL_FILM = cavitation.CAVITATION.values()
_pressure_scale = compiled(pressure_scale)

# ---- the block

CONTACT_TABLE = (513, 6)  # of `asperity.contact_table`
STROKES = 6  # lengths of the skirt for which there is room on the bore, both ways
ROOM_ON_BORE = 1 + 2 * STROKES

OF_LEVEL, OF_Z, OF_LIMIT, OF_MOST = range(4)  # of `PressureLaw`, between its alpha and its table
LAW_NUMBERS = 4

HEAD = ("columns", "rows", "edges", "bearing")
"""What a block begins with: cells around and along, edges that a row has at most, 1 for the film of
a bearing, else 0."""
COLUMNS, ROWS, ROW_EDGES, BEARING = range(len(HEAD))
GIVEN_HEAD = len(HEAD)

LAYOUT = {
    "share": "n_c",
    "sine": "n_c",
    "mask": "n_c, n_a",
    "faces": "n_e, n_c",
    "beside": "n_c, n_a",
    "numbers": f"{len(NUMBERS)}",
    "chosen": f"{len(CHOSEN)}",
    "temperature": "n_c, n_a",
    "viscosity": "n_c, n_a",
    "state": room(Memory),
    "last": room(Last),
    "has_last": "1",
    "linear": room(Linear),
    "has_linear": "1",
    "columns": "n_a, n_c, n_c",
    "diagonals": "n_a, n_c",
    "orders": "n_a, n_c",
    "sizes": "n_a",
    "direction": "1",
    "factors": f"{FACTORS[0]}, {FACTORS[1]}",
    "law": f"{LAW_NUMBERS}",
    "law_table": f"{LAW_TABLE[0]}, {LAW_TABLE[1]}",
    "faults": f"{ROOM}",
}
"""Parts of a block behind the tables of both contact laws, and their shapes.

share, sine : of `summary.Halves`; mask : 1 where there is a film, 0 in cut-outs; faces : of
`oil_layer.Bore`; beside : of `openings.nearest`; numbers, chosen : `NUMBERS` and `CHOSEN`;
temperature, viscosity [K], [Pa s]; state, last, linear : rows of `step.Memory`, `step.Last` and
`step.Linear`; has_last, has_linear : whether there is one of the last step; columns to direction :
of `blocks.Factors`; factors : of `roughness.fill_factor_table`; law, law_table : of
`piezoviscosity.PressureLaw`.
"""
Block = namedtuple("Block", ("tables", "bearing", *LAYOUT))
"""Parts of the block of a slave; tables : ndarray, shape (2, 513, 6), of both contact laws."""


def laid_out(first: int):
    """Kernels that make a `Block` of a slave's memory, whose tables begin at `first`, and that put
    into an array the lengths that the entry `size` tells.
    """
    head = f"""
    n_c, n_a, n_e = int(memory[{COLUMNS}]), int(memory[{ROWS}]), int(memory[{ROW_EDGES}])
    n_b = {ROOM_ON_BORE} * n_a
    a = {first + 2 * CONTACT_TABLE[0] * CONTACT_TABLE[1]}
"""
    takes = measures = head
    for name, shape in LAYOUT.items():
        length = " * ".join(f"({one})" for one in shape.split(", "))
        takes += f"    {name} = memory[a : a + {length}].reshape(({shape},))\n    a += {length}\n"
        if name == "state":
            measures += f"    numbers[1] = a\n    numbers[2] = {length}\n"
        if name == "faults":
            measures += "    numbers[3] = a\n"
        measures += f"    a += {length}\n"
    tables = f"memory[{first} : {first} + 2 * {CONTACT_TABLE[0]} * {CONTACT_TABLE[1]}]"
    tables += f".reshape((2, {CONTACT_TABLE[0]}, {CONTACT_TABLE[1]}))"
    made = f"Block({tables}, memory[{BEARING}] != 0.0, {', '.join(LAYOUT)})"
    scope = {"Block": Block}
    exec(
        f"def block_of(memory):{takes}    return {made}\n"
        f"def measure(memory, numbers):{measures}    numbers[0] = a\n",
        scope,
    )
    return compiled(scope["block_of"]), compiled(scope["measure"])


put_memory, memory_of = flatten(Memory)
put_last, last_of = flatten(Last)
put_linear, linear_of = flatten(Linear)


# ---- what stays of a film


@compiled
def place_openings(block: Block):
    """Say for each cut-out which film is nearest."""
    domain = domain_of(block)
    keep(block.beside, openings.nearest(domain.open_cells, domain.cells.dx, domain.cells.dy))


@compiled
def filled(block: Block, fields: Array, domain: Domain):
    """Fields, shape (m, n_c, n_a), whose cut-outs show the nearest cell with a film."""
    return openings.filled(block.beside, fields) if domain.has_openings else fields


@compiled
def domain_of(block: Block):
    """`film_step.Domain`."""
    n_c, n_a = block.mask.shape
    x = numbers_from(block.numbers)
    width = x.sector_angle * x.bore_radius
    cells = Cells(width / n_c, x.skirt_length / n_a, x.sector_angle == FULL_TURN)
    open_cells = np.empty((n_c, n_a), np.bool_)
    has_openings = False
    for i in range(n_c):
        for j in range(n_a):
            open_cells[i, j] = block.mask[i, j] == 0.0
            has_openings = has_openings or open_cells[i, j]
    together = cavitation.at_once(n_c, n_a)
    return Domain(cells, open_cells, has_openings, model_of(block), together)


@compiled
def model_of(block: Block):
    """`cavitation.Cavitation`."""
    number = int(chosen_from(block.chosen).cavitation_model) - 1
    if number == 1:
        return REYNOLDS
    if number == 2:
        return GUMBEL
    return JFO if number == 0 else FULL_FILM


@compiled
def fixed_of(block: Block, bores: float):
    """`step.Fixed`, with one bore, or with none: for a tangent."""
    x = numbers_from(block.numbers)
    chosen = chosen_from(block.chosen)
    domain = domain_of(block)
    cells = domain.cells
    n_c, n_a = block.mask.shape
    area = np.zeros((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            if not domain.open_cells[i, j]:
                area[i, j] = cells.dx * cells.dy
    contact = ContactConstants(
        x.roughness_rms,
        _pressure_scale(x.asperity_product, x.asperity_slope, x.contact_modulus),
        np.pi**2 * x.asperity_product**2,
        x.boundary_friction_coefficient,
        x.boundary_shear_strength,
        block.tables[0 if chosen.contact_law == GREENWOOD_TRIPP_1970 else 1],
    )
    surfaces = parts.Surfaces(
        area,
        contact,
        Halves(block.share, block.sine),
        coating.compliance(x.coating_thickness, x.coating_modulus, x.coating_poisson),
        x.cavitation_pressure,
        x.friction_rounding_velocity,
        chosen.cavity_shear == FILM_FRACTION,
    )
    supply = oil_layer.Supply(
        bores > 0.0 and chosen.oil_supply != EDGES,
        chosen.oil_supply == BORE_AND_RING,
        x.initial_oil_layer,
        x.stroke,
        x.chamfer_capacity,
        x.largest_oil_layer,
    )
    return Fixed(
        domain,
        surfaces,
        laws_of(block),
        block.bearing,
        step.SHARE_OF_A_BEARING if block.bearing else step.SHARE_OF_A_SKIRT,
        x.bore_radius,
        oil_layer.bore_of(supply, block.faces, cells, n_a),
    )


@compiled
def laws_of(block: Block):
    """`flow_film.FilmLaws`."""
    x = numbers_from(block.numbers)
    chosen = chosen_from(block.chosen)
    factors = np.zeros((0, 0))
    if chosen.flow_factors == PATIR_CHENG_1978:
        factors = block.factors
    thinning = Thinning(
        int(chosen.shear_thinning_law) - 1,
        x.high_shear_ratio,
        x.shear_thinning_exponent,
        x.critical_shear_rate_a,
        x.critical_shear_rate_b,
    )
    return FilmLaws(x.minimum_flow_film, x.roughness_rms, factors, thinning)


@compiled
def roughen(block: Block):
    """The table of the flow factors, into the block."""
    x = numbers_from(block.numbers)
    if chosen_from(block.chosen).flow_factors == PATIR_CHENG_1978:
        fill_factor_table(
            x.roughness_share_skirt,
            x.peklenik_number_skirt,
            x.peklenik_number_bore,
            block.factors,
        )


@compiled
def factors_of(block: Block):
    """`blocks.Factors` in the block."""
    return Factors(
        block.columns,
        block.diagonals,
        block.orders.view(np.int64),
        block.sizes.view(np.int64),
        block.direction,
    )


# ---- what is around


@compiled
def supply_of(block: Block):
    """`contradictions.Supply`."""
    x = numbers_from(block.numbers)
    chosen = chosen_from(block.chosen)
    return Supply(
        x.cavitation_pressure,
        x.pressure_lower_edge,
        x.pressure_upper_edge,
        x.pressure_openings,
        x.film_fraction_lower_edge,
        x.film_fraction_upper_edge,
        x.film_fraction_openings,
        chosen.opening_supply == OWN,
        chosen.oil_supply != EDGES,
        model_of(block).conserving,
    )


@compiled
def check_parameters(block: Block):
    """Note what is wrong between the parameters at the start, but for those of `supply_of`."""
    x = numbers_from(block.numbers)
    chosen = chosen_from(block.chosen)
    domain = domain_of(block)
    from_bore = chosen.oil_supply != EDGES
    kind = Kind(
        block.bearing,
        domain.has_openings,
        from_bore,
        chosen.flow_factors == PATIR_CHENG_1978,
        int(chosen.viscosity_law) - 1 == TWO_POINT,
        x.sector_angle,
        x.roughness_rms,
        x.viscosity_40,
        x.viscosity_100,
    )
    check_kind(kind, block.faults)
    room = STROKES * x.skirt_length
    if from_bore and x.stroke > room:
        refuse(block.faults, STROKE_TOO_LONG, 0, 0, x.stroke, x.skirt_length, room)


@compiled
def surroundings_of(block: Block):
    """`surroundings.Surroundings`."""
    x = numbers_from(block.numbers)
    supply = supply_of(block)
    outside = outside_of(supply)
    law = law_of(block)
    return Surroundings(
        edges_of(supply, outside, law, block.mask.shape),
        outside,
        block.temperature,
        block.viscosity,
        law,
        x.oil_ring_layer,
        x.oil_splash,
    )


@compiled
def low_shear_of(block: Block):
    """`oil.LowShear`."""
    x = numbers_from(block.numbers)
    return LowShear(
        int(chosen_from(block.chosen).viscosity_law) - 1,
        x.viscosity,
        x.vogel_viscosity,
        x.vogel_b,
        x.vogel_c,
        x.walther_a,
        x.walther_m,
        x.density,
        x.viscosity_40,
        x.viscosity_100,
    )


@compiled
def warm_by_edges(block: Block):
    """Temperature of every cell, linear between both edges, and what follows from it."""
    x = numbers_from(block.numbers)
    n_c, n_a = block.viscosity.shape
    oil = low_shear_of(block)
    for j in range(n_a):
        along = (j + 0.5) / n_a
        temperature = x.oil_temperature_lower_edge * (1.0 - along)
        temperature += x.oil_temperature_upper_edge * along
        viscosity = low_shear_viscosity(oil, temperature)
        for i in range(n_c):
            block.temperature[i, j] = temperature
            block.viscosity[i, j] = viscosity
    thicken(block)


@compiled
def warm_by_field(block: Block, temperature: Array):
    """The same for a temperature of each, shape (n_c, n_a) [K]."""
    oil = low_shear_of(block)
    for i in range(temperature.shape[0]):
        for j in range(temperature.shape[1]):
            block.temperature[i, j] = temperature[i, j]
            block.viscosity[i, j] = low_shear_viscosity(oil, temperature[i, j])
    thicken(block)


@compiled
def thicken(block: Block):
    """The pressure law for the viscosity of the cells, into the block."""
    kind = int(chosen_from(block.chosen).pressure_viscosity_law) - 1
    alpha = numbers_from(block.numbers).pressure_viscosity_coefficient
    law = pressure_law(kind, alpha, block.viscosity, block.law_table)
    block.law[OF_LEVEL] = law.level
    block.law[OF_Z] = law.z
    block.law[OF_LIMIT] = law.limit
    block.law[OF_MOST] = law.most


@compiled
def law_of(block: Block):
    """`piezoviscosity.PressureLaw` in the block."""
    law = block.law
    return PressureLaw(
        int(chosen_from(block.chosen).pressure_viscosity_law) - 1,
        numbers_from(block.numbers).pressure_viscosity_coefficient,
        law[OF_LEVEL],
        law[OF_Z],
        law[OF_LIMIT],
        law[OF_MOST],
        block.law_table,
    )
