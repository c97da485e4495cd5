"""A step of the film on one flat block of numbers, for a library that needs no Python.

`Block` names the parts of the block, which holds all of a slave. What is done with them are the
kernels of the model (`step_parts`, `film_step`), so every number has the same bits; viscosities
differ by the last bit of exp and log where the C library does.

Covered is the film that `native.COVERED` describes: a skirt, cut-outs or none, with oil in plenty.
"""

from typing import NamedTuple

import numpy as np

from ..master.fmi.compiled import compiled
from . import (
    blocks,
    cavitation,
    coated_film,
    coating,
    film_step,
    friction,
    openings,
    reynolds,
    step_parts,
)
from .asperity import ContactConstants, pressure_scale
from .blocks import Factors
from .coated_film import Layer, Pressed
from .coating import Softness
from .contact import contact_changes
from .faults import (
    FACTORS_WITHOUT_ROUGHNESS,
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
from .film_step import Domain, FilmSolution, Given
from .films import QUANTITIES, STORED, FilmSlopes
from .flow_film import FilmLaws, FlowFilm, Sheared, flow_film
from .friction import ForceSlopes, ShearConstants, ShearInputs, ShearSlopes
from .grid import (
    LOWER,
    UPPER,
    Array,
    Cells,
    Edges,
    Entrainment,
)
from .oil import NO_THINNING, TWO_POINT, LowShear, Thinning, low_shear_viscosity
from .piezoviscosity import NONE as NO_LAW
from .piezoviscosity import (
    PressureLaw,
    TruePressure,
    pressure_law,
    raised,
    reduced_at_edges,
    true_pressure,
)
from .reynolds import Filling
from .roughness import fill_factor_table
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
    "pressure_viscosity_coefficient",
    "high_shear_ratio",
    "shear_thinning_exponent",
    "critical_shear_rate_a",
    "critical_shear_rate_b",
    "roughness_share_skirt",
    "peklenik_number_skirt",
    "peklenik_number_bore",
    "coating_thickness",
    "coating_modulus",
    "coating_poisson",
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
    PRESSURE_VISCOSITY_COEFFICIENT,
    HIGH_SHEAR_RATIO,
    SHEAR_THINNING_EXPONENT,
    CRITICAL_SHEAR_RATE_A,
    CRITICAL_SHEAR_RATE_B,
    ROUGHNESS_SHARE_SKIRT,
    PEKLENIK_NUMBER_SKIRT,
    PEKLENIK_NUMBER_BORE,
    COATING_THICKNESS,
    COATING_MODULUS,
    COATING_POISSON,
) = range(len(NUMBERS))

CHOSEN = (
    "viscosity_law",
    "cavity_shear",
    "contact_law",
    "opening_supply",
    "cavitation_model",
    "pressure_viscosity_law",
    "shear_thinning_law",
    "flow_factors",
)
(
    VISCOSITY_LAW,
    OF_CAVITY_SHEAR,
    CONTACT_LAW,
    OPENING_SUPPLY,
    CAVITATION_MODEL,
    PRESSURE_VISCOSITY_LAW,
    SHEAR_THINNING_LAW,
    OF_FLOW_FACTORS,
) = range(len(CHOSEN))
FILM_FRACTION, _ = range(1, 3)
GREENWOOD_TRIPP_1970, _ = range(1, 3)
_, OWN = range(1, 3)
_, PATIR_CHENG_1978 = range(1, 3)

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

OF_LEVEL, OF_Z, OF_LIMIT, OF_MOST = range(4)  # of `PressureLaw`, between its alpha and its table
LAW_NUMBERS = 4

# fields of the last step, for its tangent; the pressure that the balance was solved with, and the
# true one with what stands under it
(
    VELOCITY_NOW,
    SOLVED_NOW,
    PRESSURE_NOW,
    RATIO_NOW,
    RATIO_SLOPE_NOW,
    FRACTION_NOW,
    FULL_NOW,
    SHEARING_NOW,
    STRESS_NOW,
    UNKNOWN_NOW,
    FILM_NOW,
) = range(11)
SLOPES_NOW = FILM_NOW + QUANTITIES
BY_VELOCITY_NOW = SLOPES_NOW + QUANTITIES
PRESSURE_SLOPE_NOW = BY_VELOCITY_NOW + QUANTITIES
STRESS_SLOPE_NOW = PRESSURE_SLOPE_NOW + 5
MATRIX_NOW = STRESS_SLOPE_NOW + 5
LAST_FIELDS = MATRIX_NOW + 5
EULER_LENGTH, TOUCHING, LINEAR = range(3)
LAST_NUMBERS = 3

# fields that every direction of a tangent shares: the stencils, then these
(
    TO_FILM,
    TO_VELOCITY,
    TO_SHEARING,
    TO_GRADIENT,
    TO_PRESSURE,
    PRESSURE_SHARE,
    FRACTION_SHARE,
    WEIGHT,
    CONTACT_PRESSURE,
) = range(10, 19)
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
    temperature, viscosity : shape (n_c, n_a) [K], [Pa s];
    factors : of `roughness.fill_factor_table`, shape (2049, 14);
    law, law_table : of `piezoviscosity.PressureLaw`, shapes (4,), (3, 2001);
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
    temperature: Array
    viscosity: Array
    factors: Array
    law: Array
    law_table: Array
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
    """A solved film: deflection of the coating [m], flow_film.FlowFilm,
    piezoviscosity.TruePressure, film fraction [-].
    """

    deflection: Array
    flow: FlowFilm
    under: TruePressure
    fraction: Array


class Outputs(NamedTuple):
    """fields : ndarray, shape (5, n_c, n_a), `FIELD_OUTPUTS`; scalars : `SCALARS`."""

    fields: Array
    scalars: Array


JFO, REYNOLDS, GUMBEL, FULL_FILM = cavitation.CAVITATION.values()
_pressure_scale = compiled(pressure_scale)
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
    if block.chosen[OF_FLOW_FACTORS] == PATIR_CHENG_1978 and x[ROUGHNESS_RMS] <= 0.0:
        refuse(block.faults, FACTORS_WITHOUT_ROUGHNESS, 0, 0, 0.0, 0.0, 0.0)


@compiled
def outside_of(block: Block):
    """`step_parts.Outside`."""
    x = block.numbers
    least = x[CAVITATION_PRESSURE]
    lower = x[PRESSURE_LOWER_EDGE] - least
    opening = x[PRESSURE_OPENINGS] - least if block.chosen[OPENING_SUPPLY] == OWN else lower
    return Outside(least, lower, x[PRESSURE_UPPER_EDGE] - least, opening)


@compiled
def edges_of(block: Block, shape: tuple[int, int]):
    """`grid.Edges` of oil in plenty, with reduced pressures."""
    x = block.numbers
    n_c, n_a = shape
    outside = outside_of(block)
    own = block.chosen[OPENING_SUPPLY] == OWN
    below = x[FILM_FRACTION_LOWER_EDGE]
    pressure = np.full(5, outside.opening)
    fraction = np.full(5, x[FILM_FRACTION_OPENINGS] if own else below)
    pressure[LOWER] = outside.lower
    fraction[LOWER] = below
    pressure[UPPER] = outside.upper
    fraction[UPPER] = x[FILM_FRACTION_UPPER_EDGE]
    reduced = reduced_at_edges(law_of(block), pressure)
    return Edges(reduced, fraction, np.full((n_c, n_a + 1), np.inf))


@compiled
def low_shear_of(block: Block):
    """`oil.LowShear`."""
    x = block.numbers
    return LowShear(
        int(block.chosen[VISCOSITY_LAW]) - 1,
        x[VISCOSITY],
        x[VOGEL_VISCOSITY],
        x[VOGEL_B],
        x[VOGEL_C],
        x[WALTHER_A],
        x[WALTHER_M],
        x[DENSITY],
        x[VISCOSITY_40],
        x[VISCOSITY_100],
    )


@compiled
def warm_by_edges(block: Block):
    """Temperature of every cell, linear between both edges, and what follows from it."""
    cold = block.numbers[OIL_TEMPERATURE_LOWER_EDGE]
    hot = block.numbers[OIL_TEMPERATURE_UPPER_EDGE]
    n_c, n_a = block.viscosity.shape
    oil = low_shear_of(block)
    for j in range(n_a):
        along = (j + 0.5) / n_a
        temperature = cold * (1.0 - along) + hot * along
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
    kind = int(block.chosen[PRESSURE_VISCOSITY_LAW]) - 1
    alpha = block.numbers[PRESSURE_VISCOSITY_COEFFICIENT]
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
        int(block.chosen[PRESSURE_VISCOSITY_LAW]) - 1,
        block.numbers[PRESSURE_VISCOSITY_COEFFICIENT],
        law[OF_LEVEL],
        law[OF_Z],
        law[OF_LIMIT],
        law[OF_MOST],
        block.law_table,
    )


@compiled
def roughen(block: Block):
    """The table of the flow factors, into the block."""
    x = block.numbers
    if block.chosen[OF_FLOW_FACTORS] == PATIR_CHENG_1978:
        fill_factor_table(
            x[ROUGHNESS_SHARE_SKIRT],
            x[PEKLENIK_NUMBER_SKIRT],
            x[PEKLENIK_NUMBER_BORE],
            block.factors,
        )


@compiled
def laws_of(block: Block):
    """`flow_film.FilmLaws`."""
    x = block.numbers
    factors = np.zeros((0, 0))
    if block.chosen[OF_FLOW_FACTORS] == PATIR_CHENG_1978:
        factors = block.factors
    thinning = Thinning(
        int(block.chosen[SHEAR_THINNING_LAW]) - 1,
        x[HIGH_SHEAR_RATIO],
        x[SHEAR_THINNING_EXPONENT],
        x[CRITICAL_SHEAR_RATE_A],
        x[CRITICAL_SHEAR_RATE_B],
    )
    return FilmLaws(x[MINIMUM_FLOW_FILM], x[ROUGHNESS_RMS], factors, thinning)


@compiled
def sheared_of(block: Block, velocity: Array):
    """`flow_film.Sheared` on a skirt."""
    return Sheared(velocity, np.zeros(velocity.shape), block.viscosity, block.temperature)


@compiled
def compliance_of(block: Block):
    """Of the coating [m/Pa], 0 without."""
    x = block.numbers
    return coating.compliance(x[COATING_THICKNESS], x[COATING_MODULUS], x[COATING_POISSON])


@compiled
def model_of(block: Block):
    """`cavitation.Cavitation`."""
    number = int(block.chosen[CAVITATION_MODEL]) - 1
    if number == 1:
        return REYNOLDS
    if number == 2:
        return GUMBEL
    return JFO if number == 0 else FULL_FILM


@compiled
def domain_of(block: Block):
    """`film_step.Domain` of the skirt."""
    n_c, n_a = block.mask.shape
    open_cells = open_of(block)
    has_openings = False
    for i in range(n_c):
        for j in range(n_a):
            has_openings = has_openings or open_cells[i, j]
    cells = cells_of(block, block.mask.shape)
    together = cavitation.at_once(n_c, n_a)
    return Domain(cells, open_cells, has_openings, model_of(block), together)


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
def contact_of(block: Block):
    """`asperity.ContactConstants`."""
    x = block.numbers
    exact = block.chosen[CONTACT_LAW] == GREENWOOD_TRIPP_1970
    return ContactConstants(
        x[ROUGHNESS_RMS],
        _pressure_scale(x[ASPERITY_PRODUCT], x[ASPERITY_SLOPE], x[CONTACT_MODULUS]),
        np.pi**2 * x[ASPERITY_PRODUCT] ** 2,
        x[BOUNDARY_FRICTION_COEFFICIENT],
        x[BOUNDARY_SHEAR_STRENGTH],
        block.tables[0 if exact else 1],
    )


@compiled
def surfaces_of(block: Block):
    """`step_parts.Surfaces`."""
    x = block.numbers
    return Surfaces(
        area_of(block),
        contact_of(block),
        Halves(block.share, block.sine),
        compliance_of(block),
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
def forces_of(block: Block, inputs: Inputs, solved: Solved, outputs: Outputs):
    """`step_parts.Forces` of a solved film; fields and scalars that it alone says, into `outputs`.
    A fault is noted where forces are not finite.
    """
    outside = outside_of(block)
    film = Film(
        inputs.film_thickness,
        solved.deflection,
        inputs.sliding_velocity,
        np.zeros(solved.fraction.shape),
        raised(solved.flow.quantities, solved.under.ratio),
        solved.under.pressure,
        solved.fraction,
        outside.lower,
        outside.upper,
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
    if int(block.chosen[VISCOSITY_LAW]) - 1 == TWO_POINT and x[VISCOSITY_40] <= x[VISCOSITY_100]:
        refuse(block.faults, VISCOSITIES_REVERSED, 0, 0, x[VISCOSITY_40], x[VISCOSITY_100], 0.0)
    if block.faults[0] > 0.0:
        return
    edges = edges_of(block, shape)
    lower = edges.pressure[LOWER]
    upper = edges.pressure[UPPER]
    sheared = sheared_of(block, inputs.sliding_velocity)
    flow = flow_film(film_thickness, sheared, laws_of(block))
    quantities = flow.quantities
    initial = x[INITIAL_FILM_FRACTION]
    fraction = np.full(shape, initial)
    pressure = np.zeros(shape)
    unknown = np.full(shape, initial - 1.0)
    if initial >= 1.0:
        for i in range(n_c):
            for j in range(n_a):
                pressure[i, j] = lower + (upper - lower) * ((j + 0.5) / n_a)
                unknown[i, j] = pressure[i, j]
    under = true_pressure(law_of(block), pressure)
    solved = Solved(np.zeros(shape), flow, under, fraction)
    acted = forces_of(block, inputs, solved, outputs)
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


class Found(NamedTuple):
    """Film of a step: deflection of the coating [m], flow_film.FlowFilm, film_step.FilmSolution."""

    deflection: Array
    flow: FlowFilm
    solution: FilmSolution


@compiled
def coated(block: Block, inputs: Inputs, given: Given, domain: Domain):
    """`Found` under a coating, `given` without its film; a fault is noted where there is none."""
    layer = Layer(compliance_of(block), contact_of(block), laws_of(block), law_of(block), -0.5)
    pressed = Pressed(
        inputs.film_thickness,
        block.fields[DEFLECTION],
        block.fields[UNKNOWN],
        sheared_of(block, inputs.sliding_velocity),
    )
    whole = coated_film.solve(pressed, layer, given, domain, factors_of(block), block.faults)
    return Found(whole.deflection, whole.flow, whole.solution)


@compiled
def bare(block: Block, inputs: Inputs, given: Given, domain: Domain):
    """`Found` between hard surfaces, as `coated`."""
    sheared = sheared_of(block, inputs.sliding_velocity)
    flow = flow_film(inputs.film_thickness, sheared, laws_of(block))
    whole = Given(
        flow.quantities,
        given.entrainment,
        given.edges,
        given.start,
        given.full,
        given.softness,
        given.lift,
    )
    found = film_step.solve(whole, domain, factors_of(block), block.faults)
    return Found(block.fields[DEFLECTION], flow, found)


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
    fields = block.fields
    edges = edges_of(block, shape)
    domain = domain_of(block)
    before = before_of(block)
    begun = step_parts.begin(before, step)
    lift = step_parts.lift(before, begun.pace, edges, step, domain)
    entrainment = Entrainment(np.zeros(shape), -0.5 * velocity)
    nothing = np.zeros((0, 0))
    unknown_yet = np.zeros((0, 0, 0))
    hard = Softness(unknown_yet, nothing, nothing)
    given = Given(unknown_yet, entrainment, edges, begun.start, begun.guess, hard, lift)
    if compliance_of(block) > 0.0:
        deflection, flow, found = coated(block, inputs, given, domain)
    else:
        deflection, flow, found = bare(block, inputs, given, domain)
    if block.faults[0] > 0.0:
        return 0
    quantities = flow.quantities
    under = true_pressure(law_of(block), found.pressure)
    solved = Solved(deflection, flow, under, found.film_fraction)
    acted = forces_of(block, inputs, solved, outputs)
    if block.faults[0] > 0.0:
        return 0

    # ---- from here on nothing is refused
    to = outputs.scalars
    went = step_parts.passage(before, begun, found, entrainment.axial, step, domain)
    powers = Powers(to[POWER], acted.boundary_power, acted.rubbing_power + acted.boundary_power)
    outside = outside_of(block)
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
    keep(fields[DEFLECTION], deflection)
    keep(fields[FILM_BEFORE:], fields[FILM:FILM_BEFORE])
    keep(fields[FILM:FILM_BEFORE], quantities)
    keep(block.faces[PASSED], went.passed)
    keep(block.faces[TRAVEL], went.travel)

    last = block.last
    keep(last[VELOCITY_NOW], velocity)
    keep(last[SOLVED_NOW], found.unknown if domain.model.clipping else found.pressure)
    keep(last[PRESSURE_NOW], under.pressure)
    if under.ratio.size > 0:
        keep(last[RATIO_NOW], under.ratio)
        keep(last[RATIO_SLOPE_NOW], under.slope)
    keep(last[FRACTION_NOW], found.film_fraction)
    keep(last[UNKNOWN_NOW], found.unknown)
    keep(last[SHEARING_NOW], acted.shear.shearing)
    keep(last[STRESS_NOW], acted.contact.shear_stress)
    keep(last[FILM_NOW:SLOPES_NOW], quantities)
    keep(last[SLOPES_NOW:BY_VELOCITY_NOW], flow.slopes.by_film)
    if flow.slopes.by_velocity.shape[0] > 0:
        keep(last[BY_VELOCITY_NOW:PRESSURE_SLOPE_NOW], flow.slopes.by_velocity)
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
    domain = domain_of(block)
    outside = outside_of(block)
    velocity = last[VELOCITY_NOW]
    quantities = last[FILM_NOW:SLOPES_NOW]
    none = np.zeros(shape)
    nothing = np.zeros((0, 0))
    slopes = FilmSlopes(last[SLOPES_NOW:BY_VELOCITY_NOW], np.zeros((0, n_c, n_a)))
    if laws_of(block).thinning.kind != NO_THINNING:
        slopes = FilmSlopes(slopes.by_film, last[BY_VELOCITY_NOW:PRESSURE_SLOPE_NOW])
    under = TruePressure(last[PRESSURE_NOW], nothing, nothing)
    if law_of(block).kind != NO_LAW:
        under = TruePressure(last[PRESSURE_NOW], last[RATIO_NOW], last[RATIO_SLOPE_NOW])
    stencil = film_step.film_slopes(
        quantities,
        slopes,
        Entrainment(none, -0.5 * velocity),
        Entrainment(none, np.full(shape, -0.5)),
        Filling(last[SOLVED_NOW], last[FRACTION_NOW], block.last_faces),
        edges_of(block, shape),
        block.last_numbers[EULER_LENGTH],
        domain,
    )
    shear = ShearInputs(
        under.pressure,
        last[SHEARING_NOW],
        velocity,
        raised(quantities, under.ratio),
        last[STRESS_NOW],
        area_of(block),
        ShearConstants(
            outside.lower,
            outside.upper,
            domain.cells.dy,
            block.numbers[FRICTION_ROUNDING_VELOCITY],
        ),
    )
    full = np.empty(shape, np.bool_)
    for i in range(n_c):
        for j in range(n_a):
            full[i, j] = last[FULL_NOW, i, j] != 0.0
    shares = cavitation.shares(domain.model, last[UNKNOWN_NOW], full)
    by_oil = block.chosen[OF_CAVITY_SHEAR] == FILM_FRACTION
    of_film = step_parts.force_slopes(shear, quantities, slopes, shares, under, by_oil)
    by = of_film.shear
    keep(linear[:TO_FILM], stencil.reshape((10, n_c, n_a)))
    keep(linear[TO_FILM], by.film)
    keep(linear[TO_VELOCITY], by.velocity)
    keep(linear[TO_SHEARING], by.shearing)
    keep(linear[TO_GRADIENT], by.gradient)
    keep(linear[TO_PRESSURE], by.pressure)
    keep(linear[PRESSURE_SHARE], of_film.pressure_share)
    keep(linear[FRACTION_SHARE], of_film.fraction_share)
    compliance = compliance_of(block)
    contact_slope = last[PRESSURE_SLOPE_NOW:STRESS_SLOPE_NOW]
    if compliance > 0.0:
        keep(linear[WEIGHT], compliance * coating.yielding(compliance, contact_slope))
    if block.last_numbers[TOUCHING] != 0.0:
        normal, along = step_parts.contact_slopes(
            shear,
            contact_slope,
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
    hard = filled(block, seeds[0, 0]).reshape((1, n_c, n_a))
    velocity = filled(block, seeds[1, 0]).reshape((1, n_c, n_a))
    deflection = np.zeros((1, n_c, n_a))
    coated = compliance_of(block) > 0.0
    contact_slope = block.last[PRESSURE_SLOPE_NOW:STRESS_SLOPE_NOW]
    by_contact = deflection
    moved = hard
    if coated:
        by_contact = contact_changes(contact_slope, hard, deflection)
        moved = coating.pushed(linear[WEIGHT], by_contact, hard)
    unknown = np.empty((1, n_c, n_a))
    stencil = linear[:TO_FILM].reshape((2, 5, n_c, n_a))
    reynolds.apply_stencils(stencil, moved, velocity, unknown)
    ascending = factors.direction[0] > 0.0
    blocks.substitute(factors, block.last[MATRIX_NOW:], ascending, unknown)  # Eq. (E6)
    film = hard
    if coated:
        share = linear[PRESSURE_SHARE]
        deflection = coating.deflection_changes(linear[WEIGHT], by_contact, share, unknown)
        film = hard + deflection
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
    add = step_parts.add_contact_changes
    add(linear[CONTACT_PRESSURE:CONTACT_SHEAR], hard, deflection, products[0])
    add(linear[CONTACT_SHEAR:], hard, deflection, products[1])
