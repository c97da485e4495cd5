"""A whole step of the film as kernels: what `model` does, for a library that needs no Python.

One flat block of numbers holds all of a slave; `Block` names its parts. The kernels called here are
those of the model, unchanged; what the model says in numpy between them is said again in loops. The
fields and all that goes on into the next step have the same bits, sums over the whole film differ
by the order of summation, viscosities by the last bit of exp and log.

Covered is the film that `native.COVERED` describes: a skirt, cut-outs or none, with oil in plenty,
cavitation that conserves oil, hard surfaces with or without asperity contact, any viscosity by
temperature.
"""

from typing import NamedTuple

import numpy as np

from ..master.fmi.compiled import compiled
from . import (
    blocks,
    cavitation,
    contact,
    films,
    friction,
    openings,
    reynolds,
    storage,
    summary,
    transport,
)
from .asperity import ContactConstants, pressure_scale
from .blocks import Factors
from .film_step import REFINE_ABOVE
from .films import COUETTE, QUANTITIES, STORED, FilmSlopes
from .friction import ForceSlopes, ShearConstants, ShearInputs, ShearSlopes
from .grid import (
    FIRST,
    LAST,
    LOWER,
    NORTH,
    OPENINGS,
    SOUTH,
    UPPER,
    Array,
    Cells,
    Edges,
    Entrainment,
    Flags,
)
from .oil import ZERO_CELSIUS, walther_viscosity
from .reynolds import Filling, Storage
from .storage import Past
from .summary import Halves
from .transport import PastTransport

# ---- numbers that a slave is given: parameters in SI, choices by their number from 1 on

NUMBERS = (
    "bore_radius",
    "skirt_length",
    "cavitation_pressure",
    "minimum_flow_film",
    "roughness_rms",
    "asperity_product",
    "asperity_slope",
    "contact_modulus",
    "boundary_friction_coefficient",
    "boundary_shear_strength",
    "friction_rounding_velocity",
    "initial_film_fraction",
    "pressure_lower_edge",
    "pressure_upper_edge",
    "pressure_openings",
    "film_fraction_lower_edge",
    "film_fraction_upper_edge",
    "film_fraction_openings",
    "oil_temperature_lower_edge",
    "oil_temperature_upper_edge",
    "viscosity",
    "vogel_viscosity",
    "vogel_b",
    "vogel_c",
    "walther_a",
    "walther_m",
    "density",
    "viscosity_40",
    "viscosity_100",
)
(
    BORE_RADIUS,
    SKIRT_LENGTH,
    CAVITATION_PRESSURE,
    MINIMUM_FLOW_FILM,
    ROUGHNESS_RMS,
    ASPERITY_PRODUCT,
    ASPERITY_SLOPE,
    CONTACT_MODULUS,
    BOUNDARY_FRICTION_COEFFICIENT,
    BOUNDARY_SHEAR_STRENGTH,
    FRICTION_ROUNDING_VELOCITY,
    INITIAL_FILM_FRACTION,
    PRESSURE_LOWER_EDGE,
    PRESSURE_UPPER_EDGE,
    PRESSURE_OPENINGS,
    FILM_FRACTION_LOWER_EDGE,
    FILM_FRACTION_UPPER_EDGE,
    FILM_FRACTION_OPENINGS,
    OIL_TEMPERATURE_LOWER_EDGE,
    OIL_TEMPERATURE_UPPER_EDGE,
    VISCOSITY,
    VOGEL_VISCOSITY,
    VOGEL_B,
    VOGEL_C,
    WALTHER_A,
    WALTHER_M,
    DENSITY,
    VISCOSITY_40,
    VISCOSITY_100,
) = range(len(NUMBERS))

CHOSEN = ("viscosity_law", "cavity_shear", "contact_law", "opening_supply")
VISCOSITY_LAW, OF_CAVITY_SHEAR, CONTACT_LAW, OPENING_SUPPLY = range(len(CHOSEN))
CONSTANT, VOGEL_1921, WALTHER_1931, TWO_POINT = range(1, 5)
FILM_FRACTION, _ = range(1, 3)
GREENWOOD_TRIPP_1970, _ = range(1, 3)
_, OWN = range(1, 3)

FIELD_INPUTS = ("film_thickness", "sliding_velocity", "oil_temperature")
FILM_THICKNESS, SLIDING_VELOCITY, OIL_TEMPERATURE = range(len(FIELD_INPUTS))

# ---- what it gives

FIELD_OUTPUTS = (
    "nodal_pressure_force",
    "nodal_friction_force",
    "pressure",
    "asperity_pressure",
    "film_fraction",
)
SCALARS = (
    "minimum_film_thickness",
    "maximum_pressure",
    "friction_force_hydrodynamic",
    "friction_force_asperity",
    "friction_power",
    "boundary_friction_share",
    "minimum_film_thickness_thrust_side",
    "radial_force_thrust_side",
    "friction_force_thrust_side",
    "minimum_film_thickness_anti_thrust_side",
    "radial_force_anti_thrust_side",
    "friction_force_anti_thrust_side",
    "flow_lower_edge",
    "flow_upper_edge",
    "stored_energy",
    "energy_gain",
    "flow_openings",
    "oil_in_film",
    "oil_on_bore",
    "oil_supplied",
    "mass_imbalance",
    "contact_area_fraction",
)
COUNTERS = ("solver_iterations",)

# ---- what it refuses

FAULTS = (
    "film_thickness[{i},{j}] = {a} m, and nowhere above 0 m: there is no film",
    "the film solution is not finite, first at [{i},{j}]: film thickness or viscosity out of all "
    "proportion",
    "cavitation did not converge in {a} iterations: {b} cells still switch, first [{i},{j}] with "
    "u = {c}",
    "forces are not finite at [{i},{j}], film_thickness {a} m, sliding_velocity {b} m/s",
    "viscosity_40 = {a} Pa.s: must be above viscosity_100 = {b} Pa.s",
    "pressure_lower_edge = {a} Pa: must not be below cavitation_pressure = {b} Pa",
    "film_fraction_lower_edge = {c} (unit 1) at pressure_lower_edge = {a} Pa: what is only partly "
    "filled must be at cavitation_pressure = {b} Pa, or filled to 1",
    "pressure_upper_edge = {a} Pa: must not be below cavitation_pressure = {b} Pa",
    "film_fraction_upper_edge = {c} (unit 1) at pressure_upper_edge = {a} Pa: what is only partly "
    "filled must be at cavitation_pressure = {b} Pa, or filled to 1",
    "film_fraction_openings = {a} (unit 1), pressure_openings = {b} Pa with opening_supply = "
    "lower_edge: without effect, leave them at 1 and 0 Pa or choose opening_supply = own",
    "the last step was refused, or there was none: it has no directional derivative",
    "pressure_openings = {a} Pa: must not be below cavitation_pressure = {b} Pa",
    "film_fraction_openings = {c} (unit 1) at pressure_openings = {a} Pa: what is only partly "
    "filled must be at cavitation_pressure = {b} Pa, or filled to 1",
)
"""Sentences of the faults, by number; {i} and {j} are the cell, {a} to {c} numbers."""
(
    NO_FILM,
    NOT_FINITE,
    STILL_SWITCHING,
    FORCES_NOT_FINITE,
    VISCOSITIES_REVERSED,
    LOWER_BELOW_CAVITATION,
    LOWER_PARTLY_FILLED,
    UPPER_BELOW_CAVITATION,
    UPPER_PARTLY_FILLED,
    OPENINGS_WITHOUT_EFFECT,
    NO_TANGENT,
    OPENINGS_BELOW_CAVITATION,
    OPENINGS_PARTLY_FILLED,
) = range(len(FAULTS))
MOST_FAULTS = 8
OF_A_FAULT = 6  # number of the sentence, i, j, a, b, c

# ---- the block: what is given, and what the entries make of it

TABLE = (513, 6)  # of `asperity.contact_table`
COLUMNS, ROWS = range(2)  # numbers that a block begins with: cells around and along
GIVEN_HEAD = 2

# fields of the state, shape (n_c, n_a); the two films have a row for each quantity
STATE_FIELDS = 6 + 2 * QUANTITIES
UNKNOWN, UNKNOWN_BEFORE, CONTENT, GROWTH, GROWTH_BEFORE, DEFLECTION, FILM = range(7)
FILM_BEFORE = FILM + QUANTITIES
PASSED, TRAVEL = range(2)  # shape (n_c, n_a + 1)
STEP_BEFORE, FRICTION_WORK, BOUNDARY_WORK, ENERGY, VOLUME = range(5)
STATE_NUMBERS = 5

# fields of the last step, for its tangent
(
    THICKNESS_NOW,
    VELOCITY_NOW,
    PRESSURE_NOW,
    FRACTION_NOW,
    FULL_NOW,
    SHEARING_NOW,
    STRESS_NOW,
    FILM_NOW,
) = range(8)
SLOPES_NOW = FILM_NOW + QUANTITIES
PRESSURE_SLOPE_NOW = SLOPES_NOW + QUANTITIES
STRESS_SLOPE_NOW = PRESSURE_SLOPE_NOW + 5
MATRIX_NOW = STRESS_SLOPE_NOW + 5
LAST_FIELDS = MATRIX_NOW + 5
AREA_PER_STEP, TOUCHING, ASCENDING, LINEAR = range(4)
LAST_NUMBERS = 4

# fields that every direction of a tangent shares: the stencils, then these
TO_FILM, TO_VELOCITY, TO_SHEARING, TO_GRADIENT, TO_PRESSURE, PRESSURE_SHARE, FRACTION_SHARE = range(
    10, 17
)
CONTACT_PRESSURE = 17
CONTACT_SHEAR = CONTACT_PRESSURE + 5
LINEAR_FIELDS = CONTACT_SHEAR + 5


class Block(NamedTuple):
    """Parts of the flat block of a slave, float64 throughout.

    numbers, chosen : values of `NUMBERS` and `CHOSEN`;
    tables : ndarray, shape (2, 513, 6), of both contact laws;
    faults : ndarray, shape (1 + 6 x 8,), how many, then each;
    share, sine : of `summary.Halves`, shape (n_c,);
    mask : shape (n_c, n_a), 1 where there is a film, 0 in cut-outs;
    beside : shape (n_c, n_a), of `openings.nearest`;
    viscosity : shape (n_c, n_a) [Pa s];
    fields, faces, counts : the state, shapes (18, n_c, n_a), (2, n_c, n_a + 1), (5,);
    last, last_faces, last_numbers : of the last step, shapes (.., n_c, n_a), (n_c, n_a + 1), (4,);
    linear : what directions share; columns, diagonals, orders, sizes : of `blocks.Factors`.
    """

    numbers: Array
    chosen: Array
    tables: Array
    faults: Array
    share: Array
    sine: Array
    mask: Array
    beside: Array
    viscosity: Array
    fields: Array
    faces: Array
    counts: Array
    last: Array
    last_faces: Array
    last_numbers: Array
    linear: Array
    columns: Array
    diagonals: Array
    orders: Array
    sizes: Array


class Inputs(NamedTuple):
    """Of a step, each ndarray of shape (n_c, n_a): h [m], V [m/s]."""

    film_thickness: Array
    sliding_velocity: Array


class Outputs(NamedTuple):
    """fields : ndarray, shape (5, n_c, n_a), `FIELD_OUTPUTS`; scalars : `SCALARS`."""

    fields: Array
    scalars: Array


_pace = compiled(transport.pace)
_boundary_force = compiled(friction.boundary_force)
_pressure_scale = compiled(pressure_scale)
_walther_viscosity = compiled(walther_viscosity)
(
    MINIMUM,
    HIGHEST,
    HYDRODYNAMIC,
    ASPERITY,
    POWER,
    BOUNDARY_SHARE,
    THINNEST_THRUST,
    RADIAL_THRUST,
    FRICTION_THRUST,
    THINNEST_ANTI,
    RADIAL_ANTI,
    FRICTION_ANTI,
    FLOW_LOWER,
    FLOW_UPPER,
    STORED_ENERGY,
    ENERGY_GAIN,
    FLOW_OPENINGS,
    OIL_IN_FILM,
    OIL_ON_BORE,
    OIL_SUPPLIED,
    MASS_IMBALANCE,
    CONTACT_AREA,
) = range(len(SCALARS))


# ---- small things


@compiled
def keep(place: Array, values: np.ndarray):
    """Copy an array into a part of the block of the same shape."""
    to = place.reshape(place.size)
    k = 0
    for value in values.flat:
        to[k] = value
        k += 1


@compiled
def refuse(faults: Array, number: int, i: int, j: int, a: float, b: float, c: float):
    """Note a fault."""
    count = int(faults[0])
    if count < MOST_FAULTS:
        first = 1 + OF_A_FAULT * count
        faults[first] = number
        faults[first + 1] = i + 1
        faults[first + 2] = j + 1
        faults[first + 3] = a
        faults[first + 4] = b
        faults[first + 5] = c
        faults[0] = count + 1


@compiled
def dot(a: Array, b: Array):
    """Sum of the products of two fields."""
    total = 0.0
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            total += a[i, j] * b[i, j]
    return total


@compiled
def cells_of(block: Block, shape: tuple[int, int]):
    """`grid.Cells` of the skirt."""
    n_c, n_a = shape
    width = 2.0 * np.pi * block.numbers[BORE_RADIUS]
    return Cells(width / n_c, block.numbers[SKIRT_LENGTH] / n_a, True)


# ---- cells without a film


@compiled
def place_openings(block: Block):
    """Say for each cut-out which film is nearest."""
    cells = cells_of(block, block.mask.shape)
    keep(block.beside, openings.nearest(open_of(block), cells.dx, cells.dy))


@compiled
def open_of(block: Block):
    """Cells without a film."""
    open_cells = np.empty(block.mask.shape, np.bool_)
    for i in range(block.mask.shape[0]):
        for j in range(block.mask.shape[1]):
            open_cells[i, j] = block.mask[i, j] == 0.0
    return open_cells


@compiled
def area_of(block: Block):
    """Area of each cell with a film [m2], 0 in cut-outs."""
    cells = cells_of(block, block.mask.shape)
    n_c, n_a = block.mask.shape
    area = np.zeros((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            if block.mask[i, j] != 0.0:
                area[i, j] = cells.dx * cells.dy
    return area


@compiled
def filled(block: Block, field: Array):
    """A field whose cut-outs show the nearest cell with a film."""
    n_c, n_a = field.shape
    whole = np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            k = int(block.beside[i, j])
            whole[i, j] = field[k // n_a, k % n_a]
    return whole


@compiled
def filled_inputs(block: Block, inputs):
    """`filled` fields of a step."""
    return Inputs(filled(block, inputs.film_thickness), filled(block, inputs.sliding_velocity))


@compiled
def flow_from_openings(open_cells, filling, faces, flow):
    """Flow into the film from all cut-outs [m3/s]."""
    into = openings.spilled(open_cells, filling, faces)
    total = 0.0
    for i in range(open_cells.shape[0]):
        for j in range(open_cells.shape[1]):
            if open_cells[i, j]:
                total += flow[i, j + 1] - flow[i, j] - into[i, j]
    return total


# ---- what is around


@compiled
def check_edge(block, pressure, fraction, below, partly):
    """Note what is wrong with the supply of an edge, `parameters.edge_faults`."""
    least = block.numbers[CAVITATION_PRESSURE]
    if pressure < least:
        refuse(block.faults, below, 0, 0, pressure, least, fraction)
    elif fraction < 1.0 and pressure > least:
        refuse(block.faults, partly, 0, 0, pressure, least, fraction)


@compiled
def check_surroundings(block: Block):
    """Note what is wrong between the parameters."""
    x = block.numbers
    check_edge(
        block,
        x[PRESSURE_LOWER_EDGE],
        x[FILM_FRACTION_LOWER_EDGE],
        LOWER_BELOW_CAVITATION,
        LOWER_PARTLY_FILLED,
    )
    check_edge(
        block,
        x[PRESSURE_UPPER_EDGE],
        x[FILM_FRACTION_UPPER_EDGE],
        UPPER_BELOW_CAVITATION,
        UPPER_PARTLY_FILLED,
    )
    pressure = x[PRESSURE_OPENINGS]
    fraction = x[FILM_FRACTION_OPENINGS]
    if block.chosen[OPENING_SUPPLY] == OWN:
        check_edge(block, pressure, fraction, OPENINGS_BELOW_CAVITATION, OPENINGS_PARTLY_FILLED)
    elif fraction != 1.0 or pressure != 0.0:
        refuse(block.faults, OPENINGS_WITHOUT_EFFECT, 0, 0, fraction, pressure, 0.0)


@compiled
def edges_of(block: Block, shape: tuple[int, int]):
    """`grid.Edges` of oil in plenty."""
    x = block.numbers
    n_c, n_a = shape
    lower = x[PRESSURE_LOWER_EDGE] - x[CAVITATION_PRESSURE]
    below = x[FILM_FRACTION_LOWER_EDGE]
    pressure = np.full(5, lower)
    fraction = np.full(5, below)
    pressure[UPPER] = x[PRESSURE_UPPER_EDGE] - x[CAVITATION_PRESSURE]
    fraction[UPPER] = x[FILM_FRACTION_UPPER_EDGE]
    if block.chosen[OPENING_SUPPLY] == OWN:
        for k in (FIRST, LAST, OPENINGS):
            pressure[k] = x[PRESSURE_OPENINGS] - x[CAVITATION_PRESSURE]
            fraction[k] = x[FILM_FRACTION_OPENINGS]
    return Edges(pressure, fraction, np.full((n_c, n_a + 1), np.inf))


@compiled
def viscosity_at(block: Block, temperature: float):
    """Low-shear viscosity [Pa s] at a temperature [K], Eqs. (O1) to (O3)."""
    x = block.numbers
    law = block.chosen[VISCOSITY_LAW]
    if law == VOGEL_1921:
        celsius = temperature - ZERO_CELSIUS
        return x[VOGEL_VISCOSITY] * np.exp(x[VOGEL_B] / (celsius + x[VOGEL_C]))  # Eq. (O1)
    if law == WALTHER_1931:
        return x[DENSITY] * _walther_viscosity(x[WALTHER_A], x[WALTHER_M], temperature)
    if law == TWO_POINT:
        cold = ZERO_CELSIUS + 40.0
        thick = np.log10(np.log10(1e6 * (x[VISCOSITY_40] / x[DENSITY]) + 0.7))
        thin = np.log10(np.log10(1e6 * (x[VISCOSITY_100] / x[DENSITY]) + 0.7))
        m = (thick - thin) / np.log10((ZERO_CELSIUS + 100.0) / cold)  # Eq. (O3)
        return x[DENSITY] * _walther_viscosity(thick + m * np.log10(cold), m, temperature)
    return x[VISCOSITY]


@compiled
def warm_by_edges(block: Block):
    """Viscosity of every cell for temperatures linear between both edges."""
    cold = block.numbers[OIL_TEMPERATURE_LOWER_EDGE]
    hot = block.numbers[OIL_TEMPERATURE_UPPER_EDGE]
    n_c, n_a = block.viscosity.shape
    for j in range(n_a):
        along = (j + 0.5) / n_a
        here = viscosity_at(block, cold * (1.0 - along) + hot * along)
        for i in range(n_c):
            block.viscosity[i, j] = here


@compiled
def warm_by_field(block: Block, temperature: Array):
    """Viscosity of every cell for a temperature of each, shape (n_c, n_a) [K]."""
    for i in range(temperature.shape[0]):
        for j in range(temperature.shape[1]):
            block.viscosity[i, j] = viscosity_at(block, temperature[i, j])


# ---- linear solver and cavitation, as `blocks.BlockTridiagonal` and `cavitation.full_cells`


class Solved(NamedTuple):
    """Outcome of `full_cells`; solved : False where the step is refused, the fault noted;
    stencil, ascending : of the factorisation at hand.
    """

    solved: bool
    unknown: Array
    full: Flags
    iterations: int
    stencil: Array
    ascending: bool


@compiled
def goes_up(stencil: Array):
    """Whether stations are eliminated with ascending j: downstream, for cavitated cells see
    nothing ahead.
    """
    ahead = 0
    behind = 0
    for i in range(stencil.shape[1]):
        for j in range(stencil.shape[2]):
            if stencil[NORTH, i, j] != 0.0:
                ahead += 1
            if stencil[SOUTH, i, j] != 0.0:
                behind += 1
    return ahead <= behind


@compiled
def solve(factors: Factors, stencil: Array, ascending: bool, right: Array):
    """Solution for one right-hand side, shape (n_c, n_a), in its place."""
    blocks.substitute(factors, stencil, ascending, right.reshape((1, *right.shape)))


@compiled
def full_cells(block, factors, faces, lift, held, edges, guess, open_cells):
    """Pattern of full cells and signed unknown of one step, Eq. (C1)."""
    full = guess
    supply = edges.film_fraction[OPENINGS]
    in_openings = edges.pressure[OPENINGS] if supply >= 1.0 else supply - 1.0
    iteration = 0
    first = 0
    was_up = False
    lowest = 0
    highest = 0
    while True:
        stencil, unknown = reynolds.assemble(full, faces, lift, held, edges, True)
        reynolds.hold(open_cells, in_openings, stencil, unknown)
        ascending = goes_up(stencil)
        first = 0
        if iteration > 0 and ascending == was_up:
            first = lowest if ascending else guess.shape[1] - 1 - highest
        was_up = ascending
        blocks.factorise(stencil, ascending, first, factors)
        solve(factors, stencil, ascending, unknown)
        one = iteration >= cavitation.at_once(guess.shape[0], guess.shape[1])
        found = cavitation._switch(full, unknown, open_cells, True, one)
        if found.switched < 0:
            refuse(block.faults, NOT_FINITE, found.i, found.j, 0.0, 0.0, 0.0)
            return Solved(False, unknown, full, iteration + 1, stencil, ascending)
        if found.switched == 0:  # Eq. (C1)
            return Solved(True, unknown, full, iteration + 1, stencil, ascending)
        iteration += 1
        if iteration == cavitation.LIMIT:
            u = unknown[found.i, found.j]
            refuse(
                block.faults,
                STILL_SWITCHING,
                found.i,
                found.j,
                float(cavitation.LIMIT),
                float(found.switched),
                u,
            )
            return Solved(False, unknown, full, iteration, stencil, ascending)
        lowest = found.lowest
        highest = found.highest
        full = found.pattern


@compiled
def give_up_lift(lift: Array, unknown: Array, full: Flags):
    """Take the lift from rows in which a cell would owe oil; whether there was any."""
    owing = transport.owing(unknown, full)
    found = False
    for i in range(lift.shape[0]):
        if owing[i]:
            for j in range(lift.shape[1]):
                found = found or lift[i, j] != 0.0
                lift[i, j] = 0.0
    return found


# ---- forces


class Shear(NamedTuple):
    """What friction depends on, its forces, and the contact."""

    inputs: ShearInputs
    contact: contact.Contact


@compiled
def contact_of(block: Block, film_thickness: Array):
    """Asperity contact of hard surfaces."""
    x = block.numbers
    exact = block.chosen[CONTACT_LAW] == GREENWOOD_TRIPP_1970
    constants = ContactConstants(
        x[ROUGHNESS_RMS],
        _pressure_scale(x[ASPERITY_PRODUCT], x[ASPERITY_SLOPE], x[CONTACT_MODULUS]),
        np.pi**2 * x[ASPERITY_PRODUCT] ** 2,
        x[BOUNDARY_FRICTION_COEFFICIENT],
        x[BOUNDARY_SHEAR_STRENGTH],
        block.tables[0 if exact else 1],
    )
    none = np.zeros(film_thickness.shape)
    return contact.contact(film_thickness, none, open_of(block), constants, True)


@compiled
def shear_of(block, inputs, quantities, pressure, fraction, edges):
    """What friction depends on."""
    x = block.numbers
    cells = cells_of(block, pressure.shape)
    touching = contact_of(block, inputs.film_thickness)
    shearing = fraction
    if block.chosen[OF_CAVITY_SHEAR] != FILM_FRACTION:
        shearing = np.ones(fraction.shape)
    constants = ShearConstants(
        edges.pressure[LOWER], edges.pressure[UPPER], cells.dy, x[FRICTION_ROUNDING_VELOCITY]
    )
    return Shear(
        ShearInputs(
            pressure,
            shearing,
            inputs.sliding_velocity,
            quantities,
            touching.shear_stress,
            area_of(block),
            constants,
        ),
        touching,
    )


class Powers(NamedTuple):
    """Power of asperity friction and of all rubbing [W], elastic energy [J]."""

    boundary: float
    rubbing: float
    stored: float


@compiled
def give_forces(block, shear, film_thickness, fraction, outputs):
    """Fields and scalars that a film alone says, into `outputs`; `Powers`. A fault is noted where
    forces are not finite.
    """
    inputs, touching = shear
    velocity = inputs.velocity
    n_c, n_a = velocity.shape
    viscous = friction._viscous_force(inputs)
    boundary = _boundary_force(inputs, inputs.boundary_stress)
    normal = np.empty((n_c, n_a))
    absolute = np.empty((n_c, n_a))
    thickness = np.empty((n_c, n_a))
    rubbing = 0.0
    for i in range(n_c):
        for j in range(n_a):
            thickness[i, j] = film_thickness[i, j] if block.mask[i, j] != 0.0 else np.inf
            absolute[i, j] = inputs.pressure[i, j] + block.numbers[CAVITATION_PRESSURE]
            normal[i, j] = (absolute[i, j] + touching.pressure[i, j]) * inputs.area[i, j]
            couette = inputs.film[COUETTE, i, j]
            v = velocity[i, j]
            rubbing += inputs.area[i, j] * inputs.shearing[i, j] * couette * (v * v)  # Eq. (F5)
            outputs.fields[0, i, j] = normal[i, j]
            outputs.fields[1, i, j] = viscous[i, j] + boundary[i, j]
            outputs.fields[2, i, j] = absolute[i, j]
            outputs.fields[3, i, j] = touching.pressure[i, j]
            outputs.fields[4, i, j] = fraction[i, j]
    whole = summary.summarise(
        thickness,
        velocity,
        absolute,
        normal,
        friction.ShearForces(viscous, boundary),
        touching.area_fraction,
        Halves(block.share, block.sine),
    )
    to = outputs.scalars
    to[MINIMUM] = min(whole.thinnest.thrust, whole.thinnest.anti_thrust)
    to[HIGHEST] = whole.highest
    to[HYDRODYNAMIC] = whole.hydrodynamic
    to[ASPERITY] = whole.asperity
    to[POWER] = whole.power
    to[CONTACT_AREA] = whole.contact_area
    to[THINNEST_THRUST] = whole.thinnest.thrust
    to[RADIAL_THRUST] = whole.radial.thrust
    to[FRICTION_THRUST] = whole.friction.thrust
    to[THINNEST_ANTI] = whole.thinnest.anti_thrust
    to[RADIAL_ANTI] = whole.radial.anti_thrust
    to[FRICTION_ANTI] = whole.friction.anti_thrust
    sums = whole.radial.thrust + whole.radial.anti_thrust
    sums += whole.friction.thrust + whole.friction.anti_thrust
    if not np.isfinite(sums):
        note_not_finite(block.faults, outputs.fields, film_thickness, velocity)
    boundary_power = -dot(boundary, velocity)  # Eq. (F3)
    stored = dot(inputs.area, touching.energy)  # Eq. (A10)
    return Powers(boundary_power, rubbing + boundary_power, stored)


@compiled
def note_not_finite(faults, fields, film_thickness, velocity):
    """Note the first cell whose forces are not finite."""
    for i in range(film_thickness.shape[0]):
        for j in range(film_thickness.shape[1]):
            if not np.isfinite(fields[0, i, j] + fields[1, i, j]):
                h = film_thickness[i, j]
                refuse(faults, FORCES_NOT_FINITE, i, j, h, velocity[i, j], 0.0)
                return


@compiled
def give_oil(content, area, scalars):
    """Where the oil is."""
    total = 0.0
    for i in range(content.shape[0]):
        for j in range(content.shape[1]):
            total += content[i, j] * area[i, j]
    scalars[OIL_IN_FILM] = total
    scalars[OIL_ON_BORE] = 0.0
    scalars[OIL_SUPPLIED] = 0.0


# ---- entries: start, a step, what directions share, one direction


@compiled
def start(block: Block, inputs: Inputs, outputs: Outputs):
    """State and outputs at the start, as `LubricationModel.start`; faults are noted in the block.

    Parameters
    ----------
    block : Block
        Its numbers, choices, tables, halves and viscosities given.
    inputs : Inputs
    outputs : Outputs
        Overwritten.
    """
    inputs = filled_inputs(block, inputs)
    film_thickness = inputs.film_thickness
    shape = film_thickness.shape
    n_c, n_a = shape
    x = block.numbers
    if block.chosen[VISCOSITY_LAW] == TWO_POINT and x[VISCOSITY_40] <= x[VISCOSITY_100]:
        refuse(block.faults, VISCOSITIES_REVERSED, 0, 0, x[VISCOSITY_40], x[VISCOSITY_100], 0.0)
    if block.faults[0] > 0.0:
        return
    edges = edges_of(block, shape)
    lower = edges.pressure[LOWER]
    upper = edges.pressure[UPPER]
    quantities, by_film = films.smooth_film(film_thickness, block.viscosity, x[MINIMUM_FLOW_FILM])
    initial = x[INITIAL_FILM_FRACTION]
    fraction = np.full(shape, initial)
    pressure = np.zeros(shape)
    unknown = np.full(shape, initial - 1.0)
    if initial >= 1.0:
        for i in range(n_c):
            for j in range(n_a):
                pressure[i, j] = lower + (upper - lower) * ((j + 0.5) / n_a)
                unknown[i, j] = pressure[i, j]
    shear = shear_of(block, inputs, quantities, pressure, fraction, edges)
    for k in range(outputs.scalars.size):
        outputs.scalars[k] = 0.0
    powers = give_forces(block, shear, film_thickness, fraction, outputs)
    if block.faults[0] > 0.0:
        return
    outputs.scalars[STORED_ENERGY] = powers.stored
    for part in (block.fields, block.faces):
        for k in range(part.shape[0]):
            for i in range(n_c):
                for j in range(part.shape[2]):
                    part[k, i, j] = 0.0
    keep(block.fields[UNKNOWN], unknown)
    keep(block.fields[UNKNOWN_BEFORE], unknown)
    keep(block.fields[CONTENT], fraction * quantities[STORED])
    keep(block.fields[FILM:FILM_BEFORE], quantities)
    keep(block.fields[FILM_BEFORE:], quantities)
    area = shear.inputs.area
    give_oil(block.fields[CONTENT], area, outputs.scalars)
    volume = dot(area, film_thickness)
    block.counts[STEP_BEFORE] = 0.0
    block.counts[FRICTION_WORK] = 0.0
    block.counts[BOUNDARY_WORK] = 0.0
    block.counts[ENERGY] = powers.stored
    block.counts[VOLUME] = volume


@compiled
def lift_of(block, pace, edges, step, cells):
    """Lift of the film fraction at the axial faces, from the past alone."""
    fields = block.fields
    n_c, n_a = block.viscosity.shape
    area = cells.dx * cells.dy
    before = block.counts[STEP_BEFORE]
    open_cells = open_of(block)
    resting = np.empty((n_c, n_a), np.bool_)
    gained = np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            resting[i, j] = fields[UNKNOWN, i, j] > 0.0 or open_cells[i, j]
            passing = block.faces[PASSED, i, j + 1] - block.faces[PASSED, i, j]
            gained[i, j] = fields[GROWTH, i, j] * before + passing / area
    past = PastTransport(
        fields[FILM:FILM_BEFORE],
        fields[FILM_BEFORE:],
        fields[CONTENT],
        resting,
        gained,
        block.faces[PASSED],
        block.faces[TRAVEL],
    )
    return transport.lift(past, pace, edges, step, cells)


@compiled
def guess_of(block, edges, step):
    """Full cells where the unknown goes on as it did; cut-outs by their supply."""
    before = block.counts[STEP_BEFORE]
    ratio = step / before if before > 0.0 else 0.0
    n_c, n_a = block.viscosity.shape
    guess = np.empty((n_c, n_a), np.bool_)
    for i in range(n_c):
        for j in range(n_a):
            if block.mask[i, j] == 0.0:
                guess[i, j] = edges.film_fraction[OPENINGS] >= 1.0
                continue
            u = block.fields[UNKNOWN, i, j]
            guess[i, j] = u + ratio * (u - block.fields[UNKNOWN_BEFORE, i, j]) > 0.0
    return guess


@compiled
def there_is_a_film(block, film_thickness):
    """Whether surfaces are apart anywhere; a fault is noted if not."""
    best_i = 0
    best_j = 0
    for i in range(film_thickness.shape[0]):
        for j in range(film_thickness.shape[1]):
            if film_thickness[i, j] > film_thickness[best_i, best_j]:
                best_i = i
                best_j = j
    widest = film_thickness[best_i, best_j]
    if widest > 0.0:
        return True
    refuse(block.faults, NO_FILM, best_i, best_j, widest, 0.0, 0.0)
    return False


@compiled
def advance(block: Block, inputs: Inputs, step: float, outputs: Outputs):
    """One step, as `LubricationModel.advance`; where it is refused the fault is noted and the state
    stays.

    Parameters
    ----------
    block : Block
    inputs : Inputs
        At the end of the step.
    step : float
        H [s], > 0.
    outputs : Outputs
        Overwritten.

    Returns
    -------
    int
        Number of factorisations.
    """
    inputs = filled_inputs(block, inputs)
    film_thickness, velocity = inputs
    shape = film_thickness.shape
    n_c, n_a = shape
    block.last_numbers[AREA_PER_STEP] = 0.0  # a refused step has no tangent
    if block.faults[0] > 0.0 or not there_is_a_film(block, film_thickness):
        return 0
    fields = block.fields
    counts = block.counts
    factors = Factors(
        block.columns, block.diagonals, block.orders.view(np.int64), block.sizes.view(np.int64)
    )
    edges = edges_of(block, shape)
    cells = cells_of(block, shape)
    cell_area = cells.dx * cells.dy
    open_cells = open_of(block)
    guess = guess_of(block, edges, step)
    past = Past(fields[CONTENT], fields[GROWTH], fields[GROWTH_BEFORE], counts[STEP_BEFORE])
    begin = storage.euler_step(past, step)
    pace = _pace(step, counts[STEP_BEFORE], begin.length)
    lift = lift_of(block, pace, edges, step, cells)
    quantities, by_film = films.smooth_film(
        film_thickness, block.viscosity, block.numbers[MINIMUM_FLOW_FILM]
    )
    none = np.zeros(shape)
    entrainment = Entrainment(none, -0.5 * velocity)
    free = openings.freed(open_cells, quantities)
    faces = reynolds.faces(free, entrainment, cells)
    openings.close(open_cells, faces)
    lift_a = transport.along(lift, entrainment.axial)
    held = Storage(quantities[STORED], begin.content, cell_area / begin.length)
    found = full_cells(block, factors, faces, lift_a, held, edges, guess, open_cells)
    iterations = found.iterations
    while found.solved and give_up_lift(lift_a, found.unknown, found.full):
        found = full_cells(block, factors, faces, lift_a, held, edges, found.full, open_cells)
        iterations += found.iterations
    if not found.solved:
        return 0
    unknown = found.unknown
    pressure, deficit = cavitation.split(unknown, found.full)
    balance = reynolds.balance(pressure, deficit, faces, lift_a, held, edges, open_cells, True)
    if balance.imbalance > REFINE_ABOVE:
        solve(factors, found.stencil, found.ascending, balance.residual)
        unknown = unknown + balance.residual
        pressure, deficit = cavitation.split(unknown, found.full)
        balance = reynolds.balance(pressure, deficit, faces, lift_a, held, edges, open_cells, True)
    fraction = balance.film_fraction
    filling = Filling(pressure, fraction, lift_a)
    flow = reynolds.axial_flow(filling, faces, edges)
    shear = shear_of(block, inputs, quantities, pressure, fraction, edges)
    powers = give_forces(block, shear, film_thickness, fraction, outputs)
    if block.faults[0] > 0.0:
        return 0

    # ---- from here on nothing is refused
    to = outputs.scalars
    friction_work = counts[FRICTION_WORK] + step * to[POWER]
    boundary_work = counts[BOUNDARY_WORK] + step * powers.boundary
    to[BOUNDARY_SHARE] = boundary_work / friction_work if friction_work > 0.0 else 0.0
    to[FLOW_LOWER] = balance.edge_flow[LOWER]
    to[FLOW_UPPER] = balance.edge_flow[UPPER]
    from_openings = flow_from_openings(open_cells, filling, faces, flow)
    to[FLOW_OPENINGS] = from_openings
    to[MASS_IMBALANCE] = balance.imbalance
    to[STORED_ENERGY] = powers.stored
    area = shear.inputs.area
    give_oil(balance.content, area, to)
    volume = dot(area, film_thickness)
    travelled = transport.travelled(block.faces[TRAVEL], pace, entrainment.axial, begin.length)
    inflow = 0.0
    outflow = 0.0
    for i in range(n_c):
        for j in range(n_a + 1):
            block.faces[PASSED, i, j] = (
                pace.share * block.faces[PASSED, i, j] + begin.length * flow[i, j]
            )
            block.faces[TRAVEL, i, j] = travelled[i, j]
        inflow += block.faces[PASSED, i, 0]
        outflow += block.faces[PASSED, i, n_a]
        for j in range(n_a):
            fields[UNKNOWN_BEFORE, i, j] = fields[UNKNOWN, i, j]
            fields[UNKNOWN, i, j] = unknown[i, j]
            fields[GROWTH_BEFORE, i, j] = fields[GROWTH, i, j]
            content = balance.content[i, j]
            growth = (content - fields[CONTENT, i, j]) / step
            fields[GROWTH, i, j] = 0.0 if open_cells[i, j] else growth
            fields[CONTENT, i, j] = content
    # Eq. (A11)
    work = block.numbers[CAVITATION_PRESSURE] * (volume - counts[VOLUME])
    work += edges.pressure[OPENINGS] * step * from_openings
    work += edges.pressure[LOWER] * inflow - edges.pressure[UPPER] * outflow
    to[ENERGY_GAIN] = powers.stored - counts[ENERGY] + step * powers.rubbing - work
    keep(fields[FILM_BEFORE:], fields[FILM:FILM_BEFORE])
    keep(fields[FILM:FILM_BEFORE], quantities)
    counts[STEP_BEFORE] = step
    counts[FRICTION_WORK] = friction_work
    counts[BOUNDARY_WORK] = boundary_work
    counts[ENERGY] = powers.stored
    counts[VOLUME] = volume

    last = block.last
    keep(last[THICKNESS_NOW], film_thickness)
    keep(last[VELOCITY_NOW], velocity)
    keep(last[PRESSURE_NOW], pressure)
    keep(last[FRACTION_NOW], fraction)
    keep(last[SHEARING_NOW], shear.inputs.shearing)
    keep(last[STRESS_NOW], shear.contact.shear_stress)
    keep(last[FILM_NOW:SLOPES_NOW], free)
    keep(last[SLOPES_NOW:PRESSURE_SLOPE_NOW], by_film)
    keep(last[PRESSURE_SLOPE_NOW:STRESS_SLOPE_NOW], shear.contact.pressure_slope)
    keep(last[STRESS_SLOPE_NOW:MATRIX_NOW], shear.contact.shear_stress_slope)
    keep(last[MATRIX_NOW:], found.stencil)
    keep(block.last_faces, lift_a)
    touching = 0.0
    for i in range(n_c):
        for j in range(n_a):
            last[FULL_NOW, i, j] = 1.0 if found.full[i, j] else 0.0
            if shear.contact.area_fraction[i, j] != 0.0:
                touching = 1.0
    block.last_numbers[AREA_PER_STEP] = held.area_per_step
    block.last_numbers[TOUCHING] = touching
    block.last_numbers[ASCENDING] = 1.0 if found.ascending else 0.0
    block.last_numbers[LINEAR] = 0.0
    return iterations


@compiled
def linearise(block: Block):
    """Derivatives of the last step that every direction shares, as `LubricationModel._linearise`,
    into the block.
    """
    last = block.last
    linear = block.linear
    shape = block.viscosity.shape
    n_c, n_a = shape
    edges = edges_of(block, shape)
    cells = cells_of(block, shape)
    cell_area = cells.dx * cells.dy
    length = cell_area / block.last_numbers[AREA_PER_STEP]
    velocity = last[VELOCITY_NOW]
    quantities = last[FILM_NOW:SLOPES_NOW]
    none = np.zeros(shape)
    slopes = FilmSlopes(last[SLOPES_NOW:PRESSURE_SLOPE_NOW], np.zeros((0, n_c, n_a)))
    stencil = reynolds.linearise(
        quantities,
        slopes,
        Entrainment(none, -0.5 * velocity),
        Entrainment(none, np.full(shape, -0.5)),
        Filling(last[PRESSURE_NOW], last[FRACTION_NOW], block.last_faces),
        edges,
        cells,
        cell_area / length,
    )
    area = area_of(block)
    open_cells = open_of(block)
    for m in range(2):
        for k in range(5):
            for i in range(n_c):
                for j in range(n_a):
                    if open_cells[i, j]:
                        stencil[m, k, i, j] = 0.0
    rounding = block.numbers[FRICTION_ROUNDING_VELOCITY]
    constants = ShearConstants(edges.pressure[LOWER], edges.pressure[UPPER], cells.dy, rounding)
    shear = ShearInputs(
        last[PRESSURE_NOW],
        last[SHEARING_NOW],
        velocity,
        quantities,
        last[STRESS_NOW],
        area,
        constants,
    )
    by = friction.shear_slopes(shear, slopes, none)
    keep(linear[:TO_FILM], stencil.reshape((10, n_c, n_a)))
    keep(linear[TO_FILM], by.film)
    keep(linear[TO_VELOCITY], by.velocity)
    keep(linear[TO_SHEARING], by.shearing)
    keep(linear[TO_GRADIENT], by.gradient)
    keep(linear[TO_PRESSURE], by.pressure)
    sheared = block.chosen[OF_CAVITY_SHEAR] == FILM_FRACTION
    for i in range(n_c):
        for j in range(n_a):
            full = last[FULL_NOW, i, j]
            linear[PRESSURE_SHARE, i, j] = full
            linear[FRACTION_SHARE, i, j] = 1.0 - full if sheared else 0.0
            v = velocity[i, j]
            speed = np.sqrt(v * v + rounding * rounding)
            for k in range(5):
                slope = last[PRESSURE_SLOPE_NOW + k, i, j]
                linear[CONTACT_PRESSURE + k, i, j] = area[i, j] * slope
                # Eq. (F2)
                slope = last[STRESS_SLOPE_NOW + k, i, j]
                linear[CONTACT_SHEAR + k, i, j] = -area[i, j] * slope * v / speed
    block.last_numbers[LINEAR] = 1.0


@compiled
def tangent(block: Block, seeds: Array, products: Array):
    """Change of both forces at the end of the last step, as `LubricationModel.tangent`, for one
    direction.

    Parameters
    ----------
    block : Block
    seeds : ndarray, shape (2, 1, n_c, n_a)
        Change of film thickness [m] and of sliding velocity [m/s].
    products : ndarray, shape (2, 1, n_c, n_a)
        Overwritten: change of pressure and friction force [N].
    """
    if block.last_numbers[AREA_PER_STEP] == 0.0:
        refuse(block.faults, NO_TANGENT, 0, 0, 0.0, 0.0, 0.0)
        return
    if block.last_numbers[LINEAR] == 0.0:
        linearise(block)
    linear = block.linear
    n_c, n_a = block.viscosity.shape
    cells = cells_of(block, block.viscosity.shape)
    factors = Factors(
        block.columns, block.diagonals, block.orders.view(np.int64), block.sizes.view(np.int64)
    )
    film = filled(block, seeds[0, 0]).reshape((1, n_c, n_a))
    velocity = filled(block, seeds[1, 0]).reshape((1, n_c, n_a))
    unknown = np.empty((1, n_c, n_a))
    stencil = linear[:TO_FILM].reshape((2, 5, n_c, n_a))
    reynolds.apply_stencils(stencil, film, velocity, unknown)
    ascending = block.last_numbers[ASCENDING] != 0.0
    blocks.substitute(factors, block.last[MATRIX_NOW:], ascending, unknown)  # Eq. (E6)
    slopes = ForceSlopes(
        ShearSlopes(
            linear[TO_FILM],
            linear[TO_VELOCITY],
            linear[TO_SHEARING],
            linear[TO_GRADIENT],
            linear[TO_PRESSURE],
        ),
        area_of(block),
        linear[PRESSURE_SHARE],
        linear[FRACTION_SHARE],
        cells.dy,
    )
    friction.force_changes(slopes, film, velocity, unknown, products[0], products[1])
    if block.last_numbers[TOUCHING] == 0.0:
        return
    none = np.zeros((1, n_c, n_a))
    normal = contact.contact_changes(linear[CONTACT_PRESSURE:CONTACT_SHEAR], film, none)
    along = contact.contact_changes(linear[CONTACT_SHEAR:], film, none)
    for i in range(n_c):
        for j in range(n_a):
            products[0, 0, i, j] += normal[0, i, j]
            products[1, 0, i, j] += along[0, i, j]
