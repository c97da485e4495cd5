"""The memory of a native slave, and how `step` is called on it.

What is done with it is the model's own text, so every number has the same bits; viscosities differ
by the last bit of exp and log where the C library does.
"""

from collections import namedtuple
from typing import Annotated, NamedTuple

import numpy as np

from ..master.fmi.block import flatten, part
from ..master.fmi.compiled import compiled, packed
from . import step
from .balance import openings
from .balance.film_step import Domain
from .balance.grid import Array, Cells, Field, keep
from .contradictions import FULL_TURN, Kind, Supply, check_kind, edges_of, outside_of
from .faults import STROKE_TOO_LONG, refuse
from .laws import cavitation
from .laws.piezoviscosity import TABLE as LAW_TABLE
from .laws.piezoviscosity import PressureLaw, pressure_law
from .laws.roughness import fill_factor_table
from .oil import TWO_POINT, low_shear_law, low_shear_viscosity, thinning_law
from .solvers.blocks import Factors
from .step import Last, Linear, Memory
from .summary import Halves
from .surroundings import Surroundings
from .variables import CONDITION_VARIABLES, OIL_VARIABLES, film_variables

# ---- what a slave is given: parameters in SI, choices by their number from 1 on

DECLARED = (*film_variables("bearing"), *CONDITION_VARIABLES, *OIL_VARIABLES)
NUMBERS = tuple(v.name for v in DECLARED if not v.choices)
CHOSEN = tuple(v.name for v in DECLARED if v.choices)
Numbers = namedtuple("Numbers", NUMBERS)
Chosen = namedtuple("Chosen", CHOSEN)
SECTOR_ANGLE = NUMBERS.index("sector_angle")
INITIAL_FILM_FRACTION = NUMBERS.index("initial_film_fraction")
_, numbers_from = packed(Numbers)
_, chosen_from = packed(Chosen)
FILM_FRACTION, _ = range(1, 3)
_, OWN = range(1, 3)
_, PATIR_CHENG_1978 = range(1, 3)
EDGES, _, BORE_AND_RING = range(1, 4)
MODELS = tuple(cavitation.CAVITATION.values())

# ---- the block

STROKES = 6  # lengths of the skirt for which there is room on the bore, both ways
ROOM_ON_BORE = 1 + 2 * STROKES

PARTS = ("given", "state", "last", "linear", "solver", "faults")
GIVEN, STATE, LAST, LINEAR, SOLVER, FAULTS_AT = range(len(PARTS))
"""Parts of the memory; rows of `Given`, `step.Memory`, `step.Last`, `step.Linear` and `Solver`."""

Vector = Annotated[Array, "n"]
Number = Annotated[Array, "1"]
"""An array of one, for what changes."""


class InputPlaces(NamedTuple):
    """Positions of the input fields."""

    film_thickness: int
    sliding_velocity: int
    circumferential_velocity: int
    oil_temperature: int


class Places(NamedTuple):
    """Positions of everything among the variables; -1 if it does not exist.

    numbers, chosen, fields, scalars : of `NUMBERS`, `CHOSEN`, `step.Fields` and `step.Scalars`;
    seeds, products : where those of all directions begin.
    """

    numbers: Vector
    chosen: Vector
    inputs: InputPlaces
    fields: Vector
    scalars: Vector
    solver_iterations: int
    seeds: int
    products: int


class Block(NamedTuple):
    """Constant part of a memory; members from `beside` on are made at the start.

    follows : 1 for each of `NUMBERS` that is an input; tables : of both contact laws; share, sine :
    of `summary.Halves`; mask : 1 where there is a film, 0 in cut-outs; faces : of
    `oil_layer.Bore`; beside : of `openings.nearest`; numbers, chosen : `NUMBERS` and `CHOSEN`;
    temperature, viscosity [K], [Pa s]; factors : of `roughness.fill_factor_table`; law : row of
    `piezoviscosity.PressureLaw`; has_last, has_linear : whether there is one of the last step.
    """

    places: Places
    follows: Vector
    bearing: bool
    tables: Annotated[Array, "2, 513, 6"]
    share: Vector
    sine: Vector
    mask: Field
    faces: Field
    beside: Field
    numbers: Vector
    chosen: Vector
    temperature: Field
    viscosity: Field
    factors: Field
    law: Vector
    has_last: Number
    has_linear: Number


class Solver(NamedTuple):
    """Room for `blocks.Factors`, its whole numbers by their bits."""

    columns: Annotated[Array, "n_a, n_c, n_c"]
    diagonals: Annotated[Array, "n_a, n_c"]
    orders: Annotated[Array, "n_a, n_c"]
    sizes: Annotated[Array, "n_a"]
    direction: Number


_, _block = flatten(Block)
put_law, law_from = flatten(PressureLaw)
put_solver, _solver = flatten(Solver)
put_memory, memory_of_state = flatten(Memory)
put_last, last_of = flatten(Last)
put_linear, linear_of = flatten(Linear)


@compiled
def block_of(memory: Array):
    """Return `Block`; writing into its arrays changes the memory."""
    return _block(part(memory, GIVEN))


@compiled
def clear_solver(memory: Array, block: Block):
    """Make room for factors."""
    n_c, n_a = block.mask.shape
    rows = np.zeros((n_a, n_c))
    room = Solver(np.zeros((n_a, n_c, n_c)), rows, rows, np.zeros(n_a), np.zeros(1))
    put_solver(part(memory, SOLVER), room)


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
    return MODELS[int(chosen_from(block.chosen).cavitation_model) - 1]


@compiled
def fixed_of(block: Block, bores: float):
    """`step.Fixed`, with one bore, or with none: for a tangent."""
    x = numbers_from(block.numbers)
    chosen = chosen_from(block.chosen)
    factors = np.zeros((0, 0))
    if chosen.flow_factors == PATIR_CHENG_1978:
        factors = block.factors
    choices = step.Choices(
        block.bearing,
        chosen.cavity_shear == FILM_FRACTION,
        bores > 0.0 and chosen.oil_supply != EDGES,
        chosen.oil_supply == BORE_AND_RING,
    )
    tables = step.Tables(
        block.tables[int(chosen.contact_law) - 1],
        Halves(block.share, block.sine),
        factors,
        block.faces,
    )
    thinning = thinning_law(int(chosen.shear_thinning_law) - 1, x)
    return step.fixed_of(x, domain_of(block), choices, tables, thinning)


@compiled
def roughen(block: Block):
    """Write the table of the flow factors into the memory."""
    x = numbers_from(block.numbers)
    if chosen_from(block.chosen).flow_factors == PATIR_CHENG_1978:
        fill_factor_table(
            x.roughness_share_skirt,
            x.peklenik_number_skirt,
            x.peklenik_number_bore,
            block.factors,
        )


@compiled
def factors_of(memory: Array):
    """`blocks.Factors` in the memory."""
    solver = _solver(part(memory, SOLVER))
    return Factors(
        solver.columns,
        solver.diagonals,
        solver.orders.view(np.int64),
        solver.sizes.view(np.int64),
        solver.direction,
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
def check_parameters(block: Block, faults: Array):
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
    check_kind(kind, faults)
    room = STROKES * x.skirt_length
    if from_bore and x.stroke > room:
        refuse(faults, STROKE_TOO_LONG, 0, 0, x.stroke, x.skirt_length, room)


@compiled
def surroundings_of(block: Block):
    """`surroundings.Surroundings`."""
    x = numbers_from(block.numbers)
    supply = supply_of(block)
    outside = outside_of(supply)
    law = law_from(block.law)
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
    number = int(chosen_from(block.chosen).viscosity_law) - 1
    return low_shear_law(number, numbers_from(block.numbers))


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
    """Set the temperature of every cell, shape (n_c, n_a) [K], and what follows from it."""
    oil = low_shear_of(block)
    for i in range(temperature.shape[0]):
        for j in range(temperature.shape[1]):
            block.temperature[i, j] = temperature[i, j]
            block.viscosity[i, j] = low_shear_viscosity(oil, temperature[i, j])
    thicken(block)


@compiled
def thicken(block: Block):
    """Write the pressure law for the viscosity of the cells into the memory."""
    kind = int(chosen_from(block.chosen).pressure_viscosity_law) - 1
    alpha = numbers_from(block.numbers).pressure_viscosity_coefficient
    put_law(block.law, pressure_law(kind, alpha, block.viscosity, np.zeros(LAW_TABLE)))
