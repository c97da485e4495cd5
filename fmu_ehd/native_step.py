"""A step of the film on one flat block of numbers, for a library that needs no Python.

`Block` names the parts of the block, which holds all of a slave. What is done with them are the
kernels of the model (`step_parts`, `film_step`), so every number has the same bits; viscosities
differ by the last bit of exp and log where the C library does.

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
    film_step,
    films,
    friction,
    openings,
    reynolds,
    step_parts,
)
from .asperity import ContactConstants, pressure_scale
from .blocks import Factors
from .coating import Softness
from .faults import (
    LOWER_BELOW_CAVITATION,
    LOWER_PARTLY_FILLED,
    NO_TANGENT,
    OPENINGS_BELOW_CAVITATION,
    OPENINGS_PARTLY_FILLED,
    OPENINGS_WITHOUT_EFFECT,
    UPPER_BELOW_CAVITATION,
    UPPER_PARTLY_FILLED,
    VISCOSITIES_REVERSED,
    refuse,
)
from .film_step import Domain, Given
from .films import QUANTITIES, STORED, FilmSlopes
from .friction import ForceSlopes, ShearConstants, ShearInputs, ShearSlopes
from .grid import (
    FIRST,
    LAST,
    LOWER,
    OPENINGS,
    UPPER,
    Array,
    Cells,
    Edges,
    Entrainment,
)
from .oil import ZERO_CELSIUS, walther_viscosity
from .reynolds import Filling
from .step_parts import (
    Before,
    Film,
    Outside,
    Powers,
    Surfaces,
    Totals,
)
from .summary import Halves

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
OF_PRESSURE_FORCE, OF_FRICTION_FORCE, OF_PRESSURE, OF_ASPERITY_PRESSURE, OF_FILM_FRACTION = range(
    len(FIELD_OUTPUTS)
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
    UNKNOWN_NOW,
    FILM_NOW,
) = range(9)
SLOPES_NOW = FILM_NOW + QUANTITIES
PRESSURE_SLOPE_NOW = SLOPES_NOW + QUANTITIES
STRESS_SLOPE_NOW = PRESSURE_SLOPE_NOW + 5
MATRIX_NOW = STRESS_SLOPE_NOW + 5
LAST_FIELDS = MATRIX_NOW + 5
EULER_LENGTH, TOUCHING, LINEAR = range(3)
LAST_NUMBERS = 3

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
    last, last_faces, last_numbers : of the last step, shapes (.., n_c, n_a), (n_c, n_a + 1), (3,);
    linear : what directions share;
    columns, diagonals, orders, sizes, direction : of `blocks.Factors`.
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
    direction: Array


class Inputs(NamedTuple):
    """Of a step, each ndarray of shape (n_c, n_a): h [m], V [m/s]."""

    film_thickness: Array
    sliding_velocity: Array


class Solved(NamedTuple):
    """A solved film: quantities of `films`, pressure above cavitation pressure [Pa], film
    fraction [-].
    """

    quantities: Array
    pressure: Array
    fraction: Array


class Outputs(NamedTuple):
    """fields : ndarray, shape (5, n_c, n_a), `FIELD_OUTPUTS`; scalars : `SCALARS`."""

    fields: Array
    scalars: Array


CONSERVING = cavitation.CAVITATION["jfo"]
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
    of = values.reshape(values.size)
    for k in range(to.size):
        to[k] = of[k]


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
    return openings.filled(block.beside, field.reshape((1, n_c, n_a)))[0]


@compiled
def filled_inputs(block: Block, inputs):
    """`filled` fields of a step."""
    return Inputs(filled(block, inputs.film_thickness), filled(block, inputs.sliding_velocity))


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


@compiled
def domain_of(block: Block):
    """`film_step.Domain` of the skirt, in which oil is conserved."""
    n_c, n_a = block.mask.shape
    open_cells = open_of(block)
    has_openings = False
    for i in range(n_c):
        for j in range(n_a):
            has_openings = has_openings or open_cells[i, j]
    cells = cells_of(block, block.mask.shape)
    together = cavitation.at_once(n_c, n_a)
    return Domain(cells, open_cells, has_openings, CONSERVING, together)


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


# ---- what of a step stands in the block


@compiled
def surfaces_of(block: Block):
    """`step_parts.Surfaces` of hard surfaces."""
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
    return Surfaces(
        area_of(block),
        constants,
        Halves(block.share, block.sine),
        0.0,
        x[CAVITATION_PRESSURE],
        x[FRICTION_ROUNDING_VELOCITY],
        block.chosen[OF_CAVITY_SHEAR] == FILM_FRACTION,
    )


@compiled
def before_of(block: Block):
    """`step_parts.Before` in the block."""
    fields = block.fields
    return Before(
        fields[UNKNOWN],
        fields[UNKNOWN_BEFORE],
        fields[CONTENT],
        fields[GROWTH],
        fields[GROWTH_BEFORE],
        fields[FILM:FILM_BEFORE],
        fields[FILM_BEFORE:],
        block.faces[PASSED],
        block.faces[TRAVEL],
        block.counts[STEP_BEFORE],
    )


@compiled
def forces_of(block: Block, inputs: Inputs, solved: Solved, edges: Edges, outputs: Outputs):
    """`step_parts.Forces` of a solved film; fields and scalars that it alone says, into `outputs`.
    A fault is noted where forces are not finite.
    """
    none = np.zeros(solved.pressure.shape)
    film = Film(
        inputs.film_thickness,
        none,
        inputs.sliding_velocity,
        none,
        solved.quantities,
        solved.pressure,
        solved.fraction,
        edges.pressure[LOWER],
        edges.pressure[UPPER],
    )
    acted = step_parts.forces(film, surfaces_of(block), domain_of(block), block.faults)
    keep(outputs.fields[OF_PRESSURE_FORCE], acted.pressure)
    keep(outputs.fields[OF_FRICTION_FORCE], acted.friction)
    keep(outputs.fields[OF_PRESSURE], acted.absolute)
    keep(outputs.fields[OF_ASPERITY_PRESSURE], acted.contact.pressure)
    keep(outputs.fields[OF_FILM_FRACTION], solved.fraction)
    whole = acted.summary
    to = outputs.scalars
    for k in range(to.size):
        to[k] = 0.0
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
    to[STORED_ENERGY] = acted.stored
    return acted


@compiled
def keep_totals(block: Block, totals: Totals):
    """Sums that go on, into the block."""
    block.counts[FRICTION_WORK] = totals.friction_work
    block.counts[BOUNDARY_WORK] = totals.boundary_work
    block.counts[ENERGY] = totals.stored
    block.counts[VOLUME] = totals.volume


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
    solved = Solved(quantities, pressure, fraction)
    acted = forces_of(block, inputs, solved, edges, outputs)
    if block.faults[0] > 0.0:
        return
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
    outputs.scalars[OIL_IN_FILM] = step_parts.oil_in(block.fields[CONTENT], acted.shear.area)
    block.counts[STEP_BEFORE] = 0.0
    keep_totals(block, Totals(0.0, 0.0, acted.stored, acted.volume))


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
    block.last_numbers[EULER_LENGTH] = 0.0  # a refused step has no tangent
    step_parts.check_film(film_thickness, block.faults)
    if block.faults[0] > 0.0:
        return 0
    x = block.numbers
    fields = block.fields
    edges = edges_of(block, shape)
    domain = domain_of(block)
    before = before_of(block)
    begun = step_parts.begin(before, step)
    lift = step_parts.lift(before, begun.pace, edges, step, domain)
    quantities, by_film = films.smooth_film(film_thickness, block.viscosity, x[MINIMUM_FLOW_FILM])
    entrainment = Entrainment(np.zeros(shape), -0.5 * velocity)
    hard = Softness(np.zeros((0, 0, 0)), np.zeros((0, 0)), np.zeros((0, 0)))
    given = Given(quantities, entrainment, edges, begun.start, begun.guess, hard, lift)
    found = film_step.solve(given, domain, factors_of(block), block.faults)
    if block.faults[0] > 0.0:
        return 0
    solved = Solved(quantities, found.pressure, found.film_fraction)
    acted = forces_of(block, inputs, solved, edges, outputs)
    if block.faults[0] > 0.0:
        return 0

    # ---- from here on nothing is refused
    to = outputs.scalars
    went = step_parts.passage(before, begun, found, entrainment.axial, step, domain)
    powers = Powers(to[POWER], acted.boundary_power, acted.rubbing_power + acted.boundary_power)
    outside = Outside(
        x[CAVITATION_PRESSURE],
        edges.pressure[LOWER],
        edges.pressure[UPPER],
        edges.pressure[OPENINGS],
    )
    totals = Totals(
        block.counts[FRICTION_WORK],
        block.counts[BOUNDARY_WORK],
        block.counts[ENERGY],
        block.counts[VOLUME],
    )
    account = step_parts.account(totals, acted, powers, found, went.passed, outside, step)
    to[BOUNDARY_SHARE] = account.boundary_share
    to[ENERGY_GAIN] = account.energy_gain
    to[OIL_IN_FILM] = account.oil
    to[FLOW_LOWER] = found.edge_flow[LOWER]
    to[FLOW_UPPER] = found.edge_flow[UPPER]
    to[FLOW_OPENINGS] = found.from_openings
    to[MASS_IMBALANCE] = found.mass_imbalance
    keep_totals(block, account.totals)
    block.counts[STEP_BEFORE] = step
    keep(fields[UNKNOWN_BEFORE], fields[UNKNOWN])
    keep(fields[UNKNOWN], found.unknown)
    keep(fields[GROWTH_BEFORE], fields[GROWTH])
    keep(fields[GROWTH], went.growth)
    keep(fields[CONTENT], found.content)
    keep(fields[FILM_BEFORE:], fields[FILM:FILM_BEFORE])
    keep(fields[FILM:FILM_BEFORE], quantities)
    keep(block.faces[PASSED], went.passed)
    keep(block.faces[TRAVEL], went.travel)

    last = block.last
    keep(last[THICKNESS_NOW], film_thickness)
    keep(last[VELOCITY_NOW], velocity)
    keep(last[PRESSURE_NOW], found.pressure)
    keep(last[FRACTION_NOW], found.film_fraction)
    keep(last[UNKNOWN_NOW], found.unknown)
    keep(last[SHEARING_NOW], acted.shear.shearing)
    keep(last[STRESS_NOW], acted.contact.shear_stress)
    keep(last[FILM_NOW:SLOPES_NOW], quantities)
    keep(last[SLOPES_NOW:PRESSURE_SLOPE_NOW], by_film)
    keep(last[PRESSURE_SLOPE_NOW:STRESS_SLOPE_NOW], acted.contact.pressure_slope)
    keep(last[STRESS_SLOPE_NOW:MATRIX_NOW], acted.contact.shear_stress_slope)
    keep(last[MATRIX_NOW:], found.stencil)
    keep(block.last_faces, found.lift)
    for i in range(shape[0]):
        for j in range(shape[1]):
            last[FULL_NOW, i, j] = 1.0 if found.full[i, j] else 0.0
    block.last_numbers[EULER_LENGTH] = begun.start.length
    block.last_numbers[TOUCHING] = 1.0 if acted.touching else 0.0
    block.last_numbers[LINEAR] = 0.0
    return found.iterations


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
    velocity = last[VELOCITY_NOW]
    quantities = last[FILM_NOW:SLOPES_NOW]
    none = np.zeros(shape)
    slopes = FilmSlopes(last[SLOPES_NOW:PRESSURE_SLOPE_NOW], np.zeros((0, n_c, n_a)))
    stencil = film_step.film_slopes(
        quantities,
        slopes,
        Entrainment(none, -0.5 * velocity),
        Entrainment(none, np.full(shape, -0.5)),
        Filling(last[PRESSURE_NOW], last[FRACTION_NOW], block.last_faces),
        edges,
        block.last_numbers[EULER_LENGTH],
        domain_of(block),
    )
    shear = ShearInputs(
        last[PRESSURE_NOW],
        last[SHEARING_NOW],
        velocity,
        quantities,
        last[STRESS_NOW],
        area_of(block),
        ShearConstants(
            edges.pressure[LOWER],
            edges.pressure[UPPER],
            cells.dy,
            block.numbers[FRICTION_ROUNDING_VELOCITY],
        ),
    )
    full = np.empty(shape, np.bool_)
    for i in range(n_c):
        for j in range(n_a):
            full[i, j] = last[FULL_NOW, i, j] != 0.0
    of_pressure, of_fraction = cavitation.shares(CONSERVING, last[UNKNOWN_NOW], full)
    by = friction.shear_slopes(shear, slopes, none)
    keep(linear[:TO_FILM], stencil.reshape((10, n_c, n_a)))
    keep(linear[TO_FILM], by.film)
    keep(linear[TO_VELOCITY], by.velocity)
    keep(linear[TO_SHEARING], by.shearing)
    keep(linear[TO_GRADIENT], by.gradient)
    keep(linear[TO_PRESSURE], by.pressure)
    keep(linear[PRESSURE_SHARE], of_pressure)
    by_oil = block.chosen[OF_CAVITY_SHEAR] == FILM_FRACTION
    keep(linear[FRACTION_SHARE], of_fraction if by_oil else none)
    if block.last_numbers[TOUCHING] != 0.0:
        normal, along = step_parts.contact_slopes(
            shear,
            last[PRESSURE_SLOPE_NOW:STRESS_SLOPE_NOW],
            last[STRESS_SLOPE_NOW:MATRIX_NOW],
        )
        keep(linear[CONTACT_PRESSURE:CONTACT_SHEAR], normal)
        keep(linear[CONTACT_SHEAR:], along)
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
    if block.last_numbers[EULER_LENGTH] == 0.0:
        refuse(block.faults, NO_TANGENT, 0, 0, 0.0, 0.0, 0.0)
        return
    if block.last_numbers[LINEAR] == 0.0:
        linearise(block)
    linear = block.linear
    n_c, n_a = block.viscosity.shape
    cells = cells_of(block, block.viscosity.shape)
    factors = factors_of(block)
    film = filled(block, seeds[0, 0]).reshape((1, n_c, n_a))
    velocity = filled(block, seeds[1, 0]).reshape((1, n_c, n_a))
    unknown = np.empty((1, n_c, n_a))
    stencil = linear[:TO_FILM].reshape((2, 5, n_c, n_a))
    reynolds.apply_stencils(stencil, film, velocity, unknown)
    ascending = factors.direction[0] > 0.0
    blocks.substitute(factors, block.last[MATRIX_NOW:], ascending, unknown)  # Eq. (E6)
    by = ShearSlopes(
        linear[TO_FILM],
        linear[TO_VELOCITY],
        linear[TO_SHEARING],
        linear[TO_GRADIENT],
        linear[TO_PRESSURE],
    )
    slopes = ForceSlopes(
        by, area_of(block), linear[PRESSURE_SHARE], linear[FRACTION_SHARE], cells.dy
    )
    friction.force_changes(slopes, film, velocity, unknown, products[0], products[1])
    if block.last_numbers[TOUCHING] == 0.0:
        return
    none = np.zeros((1, n_c, n_a))
    step_parts.add_contact_changes(linear[CONTACT_PRESSURE:CONTACT_SHEAR], film, none, products[0])
    step_parts.add_contact_changes(linear[CONTACT_SHEAR:], film, none, products[1])
