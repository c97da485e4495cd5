"""The memory of a native slave, and how `step` is called on it.

What is done with it is the model's own text, so every number has the same bits; viscosities differ
by the last bit of exp and log where the C library does.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ..master.fmi.block import alike, checker, flatten, given_part, is_head, parts, room, room_of
from ..master.fmi.compiled import compilable, compiled, packed
from . import constants, contradictions, surroundings
from .balance import openings
from .balance.film_step import Domain
from .balance.grid import Array, Cells, Field, keep
from .balance.oil_layer import NO_EDGE
from .contradictions import FROM_EDGES, FULL_TURN, PATIR_CHENG_1978, cavitation_of
from .faults import FAULT, refuse
from .laws import cavitation
from .laws.piezoviscosity import PressureLaw
from .laws.roughness import TABLE as FACTOR_TABLE
from .laws.roughness import fill_factor_table
from .parameters import CHOSEN, NUMBERS, Chosen, Numbers
from .solvers.blocks import Factors
from .state import Fields, LastStep, Memory, Scalars
from .step_tangent import Linearisation
from .summary import Halves

SECTOR_ANGLE = NUMBERS.index("sector_angle")
INITIAL_FILM_FRACTION = NUMBERS.index("initial_film_fraction")
_, numbers_from = packed(Numbers)
_, chosen_from = packed(Chosen)

# ---- the block

STROKES = 6  # lengths of the skirt for which there is room on the bore, both ways
ROOM_ON_BORE = 1 + 2 * STROKES

Vector = Annotated[Array, "n"]
Number = Annotated[Array, "1"]
"""An array of one, for what changes."""


ON_CELLS = "has_room(x, n_c * n_a, reals)"
ON_FACES = "has_room(x, (2 + bearing) * n_c * n_a, reals)"
"""Conditions on the position of a field, and of one of each direction."""


class InputPositions(NamedTuple):
    """Positions of the input fields."""

    film_thickness: Annotated[int, ON_CELLS]
    sliding_velocity: Annotated[int, ON_CELLS]
    circumferential_velocity: Annotated[int, f"not bearing or {ON_CELLS}"]
    oil_temperature: Annotated[int, f"x == -1 or {ON_CELLS}"]


class VariablePositions(NamedTuple):
    """Positions of everything among the variables; -1 if it does not exist.

    numbers, chosen, fields, scalars : of `NUMBERS`, `CHOSEN`, `step.Fields` and `step.Scalars`;
    seeds, products : where those of all directions begin.
    """

    numbers: Annotated[Array, f"{len(NUMBERS)}", "within(x, -1.0, reals)"]
    chosen: Annotated[Array, f"{len(CHOSEN)}", "within(x, 0.0, integers)"]
    inputs: InputPositions
    fields: Annotated[Array, f"{len(Fields._fields)}", "within(x, -1.0, reals - n_c * n_a + 1)"]
    scalars: Annotated[Array, f"{len(Scalars._fields)}", "within(x, -1.0, reals)"]
    solver_iterations: Annotated[int, "0 <= x < integers"]
    seeds: Annotated[int, ON_FACES]
    products: Annotated[int, ON_FACES]


class FilmSetup(NamedTuple):
    """Constant part of a memory; members from `beside` on are made at the start.

    follows : 1 for each of `NUMBERS` that may change; tables : of both contact laws; share, sine :
    of `summary.Halves`; mask : 1 where there is a film, 0 in cut-outs; faces : of
    `oil_layer.Bore`; beside : of `openings.nearest`; numbers, chosen : `NUMBERS` and `CHOSEN`;
    temperature, viscosity [K], [Pa s]; factors : of `roughness.fill_factor_table`; law : row of
    `piezoviscosity.PressureLaw`; has_last, has_linear : whether there is one of the last step.
    """

    places: VariablePositions
    follows: Annotated[Array, f"{len(NUMBERS)}"]
    bearing: bool
    tables: Annotated[Array, "2, 513, 6"]
    share: Annotated[Array, "n_c"]
    sine: Annotated[Array, "n_c"]
    mask: Annotated[Array, "n_c, n_a", "within(x, 0.0, 2.0) and n_c > 0 and n_a > 0"]
    faces: Annotated[Array, "n_e, n_c", "n_e % 2 == 0 and are_edges(x, n_a)"]
    beside: Field
    numbers: Annotated[Array, f"{len(NUMBERS)}"]
    chosen: Annotated[Array, f"{len(CHOSEN)}"]
    temperature: Field
    viscosity: Field
    factors: Annotated[Array, f"{FACTOR_TABLE[0]}, {FACTOR_TABLE[1]}"]
    law: Annotated[Array, f"{room(PressureLaw)}"]
    has_last: Number
    has_linear: Number


class Solver(NamedTuple):
    """Room for `blocks.Factors`, its whole numbers by their bits."""

    columns: Annotated[Array, "n_a, n_c, n_c"]
    diagonals: Annotated[Array, "n_a, n_c"]
    orders: Annotated[Array, "n_a, n_c"]
    sizes: Annotated[Array, "n_a"]
    direction: Number


class Parts(NamedTuple):
    """Parts of the memory.

    They are rows of `FilmSetup`, `step.Memory`, that at the start, `step.LastStep`,
    `step_tangent.Linearisation` and `Solver`, and the faults.
    """

    given: Vector
    state: Vector
    begun: Vector
    last: Vector
    linear: Vector
    solver: Vector
    faults: Vector


parts_of = parts(Parts)
_, _block = flatten(FilmSetup)
put_law, law_from = flatten(PressureLaw)
put_solver, _solver = flatten(Solver)
put_memory, memory_of_state = flatten(Memory)
is_memory = alike(Memory)
put_last, last_of = flatten(LastStep)
put_linear, linear_of = flatten(Linearisation)


@compilable
def are_edges(faces: Array, n_a: int):
    """Return whether `oil_layer.Bore.faces` are faces of a film, those of even rows below it."""
    for edge in range(faces.shape[0]):
        for i in range(faces.shape[1]):
            face = faces[edge, i]
            upper = edge % 2
            is_edge = upper <= face < n_a + upper and face == np.floor(face)
            if not (is_edge or face == NO_EDGE):
                return False
    return True


PARTS = float(len(Parts._fields))
_check = checker(FilmSetup, "reals, integers", are_edges=are_edges)
_room_of_memory = room_of(Memory, "n_c, n_a, n_e, n_b")
_room_of_last = room_of(LastStep, "n_c, n_a")
_room_of_linear = room_of(Linearisation, "n_c, n_a")
_room_of_solver = room_of(Solver, "n_c, n_a")


@compilable
def is_sound(real: Array, integer: Array, memory: Array):
    """Return whether a memory from a file has no position or length out of range."""
    row = given_part(memory, PARTS)
    if len(row) == 0 or _check(row, len(real), len(integer)) != len(row):
        return False
    block = _block(row)
    n_c, n_a = block.mask.shape
    state = _room_of_memory(n_c, n_a, len(block.faces), ROOM_ON_BORE * n_a)
    last, linear = _room_of_last(n_c, n_a), _room_of_linear(n_c, n_a)
    return is_head(memory, (state, state, last, linear, _room_of_solver(n_c, n_a)), 0.0, 0)


@compiled
def block_of(memory: Array):
    """Return `FilmSetup`; writing into its arrays changes the memory."""
    return _block(parts_of(memory).given)


@compiled
def clear_solver(memory: Array, block: FilmSetup):
    """Make room for factors."""
    n_c, n_a = block.mask.shape
    rows = np.zeros((n_a, n_c))
    room = Solver(np.zeros((n_a, n_c, n_c)), rows, rows, np.zeros(n_a), np.zeros(1))
    put_solver(parts_of(memory).solver, room)


# ---- what stays of a film


@compiled
def filled(block: FilmSetup, fields: Array, domain: Domain):
    """Fields, shape (m, n_c, n_a), whose cut-outs show the nearest cell with a film."""
    return openings.filled(block.beside, fields) if domain.has_openings else fields


@compiled
def domain_of(block: FilmSetup):
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
    cavitation_model = cavitation_of(chosen_from(block.chosen))
    return Domain(cells, open_cells, has_openings, cavitation_model, together)


@compiled
def fixed_of(block: FilmSetup, on_bore: bool):
    """Return `constants.FilmConstants`; a tangent needs no bore."""
    chosen = chosen_from(block.chosen)
    factors = np.zeros((0, 0))
    if chosen.flow_factors == PATIR_CHENG_1978:
        factors = block.factors
    tables = constants.Tables(
        block.tables[int(chosen.contact_law) - 1],
        Halves(block.share, block.sine),
        factors,
        block.faces,
    )
    x = numbers_from(block.numbers)
    return constants.fixed_of(x, chosen, block.bearing, on_bore, domain_of(block), tables)


@compiled
def factors_of(memory: Array):
    """`blocks.Factors` in the memory."""
    solver = _solver(parts_of(memory).solver)
    return Factors(
        solver.columns,
        solver.diagonals,
        solver.orders.view(np.int64),
        solver.sizes.view(np.int64),
        solver.direction,
    )


# ---- parameters and surroundings


@compiled
def set_up(block: FilmSetup, faults: Array):
    """Set what stays of a film, and note contradictions between parameters but for its supply."""
    x = numbers_from(block.numbers)
    chosen = chosen_from(block.chosen)
    domain = domain_of(block)
    keep(block.beside, openings.nearest(domain.open_cells, domain.cells.dx, domain.cells.dy))
    if chosen.flow_factors == PATIR_CHENG_1978:
        fill_factor_table(
            x.roughness_share_skirt,
            x.peklenik_number_skirt,
            x.peklenik_number_bore,
            block.bearing,
            block.factors,
        )
    contradictions.check_parameters(x, chosen, block.bearing, domain.has_openings, faults)
    room = STROKES * x.skirt_length
    if chosen.oil_supply != FROM_EDGES and x.stroke > room:
        refuse(faults, FAULT.stroke_too_long, 0, 0, x.stroke, x.skirt_length, room)


@compiled
def check_supply(block: FilmSetup, faults: Array):
    """Note what is wrong with the oil supply."""
    contradictions.check_supply(numbers_from(block.numbers), chosen_from(block.chosen), faults)


@compiled
def surroundings_of(block: FilmSetup):
    """Return `surroundings.Surroundings`."""
    return surroundings.surroundings_of(
        numbers_from(block.numbers),
        chosen_from(block.chosen),
        block.temperature,
        block.viscosity,
        law_from(block.law),
    )


@compiled
def warm(block: FilmSetup, temperature: Array):
    """Set temperature, viscosity and pressure law of a film.

    temperature : ndarray, shape (n_c, n_a) [K]; of shape (0, 0), that of the edges is used.
    """
    x = numbers_from(block.numbers)
    chosen = chosen_from(block.chosen)
    if temperature.size > 0:
        keep(block.temperature, temperature)
    else:
        surroundings.temperature_between_edges(x, block.temperature)
    surroundings.viscosity_by_temperature(x, chosen, block.temperature, block.viscosity)
    put_law(block.law, surroundings.pressure_law_of(x, chosen, block.viscosity))
