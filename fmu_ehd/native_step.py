"""What the block of a native slave holds, and how `step` is called on it.

The block is one flat piece of float64 numbers, all of a slave; `LAYOUT` says what lies in it. What
is done with it is the model's own text, so every number has the same bits; viscosities differ by
the last bit of exp and log where the C library does.
"""

from collections import namedtuple

import numpy as np

from ..master.fmi.compiled import compiled, packed
from . import cavitation, coating, oil_layer, openings, step
from . import step_parts as parts
from .asperity import ContactConstants, pressure_scale
from .blocks import Factors
from .circumferential import Turning, TurningSlopes
from .contradictions import (
    FULL_TURN,
    Kind,
    Supply,
    check_kind,
    edges_of,
    outside_of,
)
from .faults import ROOM, STROKE_TOO_LONG, refuse
from .film_step import Domain
from .films import QUANTITIES, FilmSlopes
from .flow_film import FilmLaws
from .friction import ForceSlopes, ShearConstants, ShearInputs, ShearSlopes
from .grid import Array, Cells, Edges, keep
from .oil import NO_THINNING, TWO_POINT, LowShear, Thinning, low_shear_viscosity
from .oil_layer import OilLayer
from .piezoviscosity import NONE as NO_LAW
from .piezoviscosity import TABLE as LAW_TABLE
from .piezoviscosity import PressureLaw, TruePressure, pressure_law, raised
from .reynolds import Filling
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

# fields of the state, shape (n_c, n_a); the two films have a row for each quantity
STATE_FIELDS = 7 + 2 * QUANTITIES
UNKNOWN, UNKNOWN_BEFORE, CONTENT, GROWTH, GROWTH_BEFORE, DEFLECTION, SPILLED, FILM = range(8)
FILM_BEFORE = FILM + QUANTITIES
PASSED, TRAVEL = range(2)  # shape (n_c, n_a + 1)
(
    STEP_BEFORE,
    FRICTION_WORK,
    BOUNDARY_WORK,
    ENERGY,
    VOLUME,
    REACHED,
    HEIGHT,
    VELOCITY,
    VELOCITY_BEFORE,
    SUPPLIED,
    HELD,
) = range(11)
STATE_NUMBERS = 11

OF_LEVEL, OF_Z, OF_LIMIT, OF_MOST = range(4)  # of `PressureLaw`, between its alpha and its table
LAW_NUMBERS = 4

# fields of the last step, for its tangent; the pressure that the balance was solved with, and the
# true one with what stands under it
(
    VELOCITY_NOW,
    TURNING_NOW,
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
) = range(12)
SLOPES_NOW = FILM_NOW + QUANTITIES
BY_VELOCITY_NOW = SLOPES_NOW + QUANTITIES
BY_TURNING_NOW = BY_VELOCITY_NOW + QUANTITIES
PRESSURE_SLOPE_NOW = BY_TURNING_NOW + QUANTITIES
STRESS_SLOPE_NOW = PRESSURE_SLOPE_NOW + 5
STENCIL_NOW = STRESS_SLOPE_NOW + 5
LAST_FIELDS = STENCIL_NOW + 5
LIFT, LIMIT = range(2)  # shape (n_c, n_a + 1)
EULER_LENGTH, TOUCHING, LINEAR, LOWER_NOW, UPPER_NOW, OPENING_NOW, EDGES_NOW = range(7)
LAST_NUMBERS = EDGES_NOW + 10

# fields that every direction of a tangent shares: of both balances, of the forces, of contact
TO_TURNING, SHEAR_SLOPES = 10, 20
PRESSURE_SHARE, FRACTION_SHARE, WEIGHT, TURNING_SLOPES = range(25, 29)
CONTACT_PRESSURE = TURNING_SLOPES + len(TurningSlopes._fields)
CONTACT_SHEAR = CONTACT_PRESSURE + 5
CONTACT_AROUND = CONTACT_SHEAR + 5
LINEAR_FIELDS = CONTACT_AROUND + 5

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
    "fields": f"{STATE_FIELDS}, n_c, n_a",
    "passed": "2, n_c, n_a + 1",
    "counts": f"{STATE_NUMBERS}",
    "on_bore": f"{ROOM_ON_BORE} * n_c * n_a",
    "reservoir": "n_e, n_c",
    "last": f"{LAST_FIELDS}, n_c, n_a",
    "last_faces": "2, n_c, n_a + 1",
    "last_numbers": f"{LAST_NUMBERS}",
    "linear": f"{LINEAR_FIELDS}, n_c, n_a",
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
temperature, viscosity [K], [Pa s]; fields to reservoir : the state, in one piece; last.. : of the
last step; linear : what directions share; columns to direction : of `blocks.Factors`;
factors : of `roughness.fill_factor_table`; law, law_table : of `piezoviscosity.PressureLaw`.
"""
STATE = ("fields", "reservoir")
"""First and last part of the state."""
Block = namedtuple("Block", ("tables", "bearing", *LAYOUT))
"""Parts of the block of a slave; tables : ndarray, shape (2, 513, 6), of both contact laws."""


def laid_out(first: int):
    """Kernels that make a `Block` of a slave's memory, whose tables begin at `first`, and that put
    into an array the lengths that the entry `size` tells.
    """
    head = f"""
    n_c, n_a, n_e = int(memory[{COLUMNS}]), int(memory[{ROWS}]), int(memory[{ROW_EDGES}])
    a = {first + 2 * CONTACT_TABLE[0] * CONTACT_TABLE[1]}
"""
    takes = measures = head
    for name, shape in LAYOUT.items():
        length = " * ".join(f"({one})" for one in shape.split(", "))
        takes += f"    {name} = memory[a : a + {length}].reshape(({shape},))\n    a += {length}\n"
        if name == STATE[0]:
            measures += "    numbers[1] = a\n"
        if name == "faults":
            measures += "    numbers[3] = a\n"
        measures += f"    a += {length}\n"
        if name == STATE[1]:
            measures += "    numbers[2] = a - numbers[1]\n"
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


@compiled
def keep_all(places: Array, fields: tuple[Array, ...]):
    """Copy a named tuple of fields into rows of the block."""
    for k in range(len(fields)):
        keep(places[k], fields[k])


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


# ---- what of a step stands in the block


@compiled
def layer_of(block: Block, cells: int):
    """`oil_layer.OilLayer` in the block, of so many cells along the bore."""
    n_c, _ = block.mask.shape
    x = block.counts
    return OilLayer(
        block.on_bore[: n_c * cells].reshape((n_c, cells)),
        block.reservoir,
        block.fields[SPILLED],
        x[REACHED],
        x[HEIGHT],
        x[VELOCITY],
        x[VELOCITY_BEFORE],
        x[SUPPLIED],
        x[HELD],
    )


@compiled
def none_followed():
    """`oil_layer.OilLayer` where none is followed."""
    nothing = np.zeros((0, 0))
    return OilLayer(nothing, nothing, nothing, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@compiled
def memory_of(block: Block, fixed: Fixed):
    """`step.Memory` in the block."""
    fields = block.fields
    x = block.counts
    before = parts.Before(
        fields[UNKNOWN],
        fields[UNKNOWN_BEFORE],
        fields[CONTENT],
        fields[GROWTH],
        fields[GROWTH_BEFORE],
        fields[DEFLECTION],
        fields[FILM:FILM_BEFORE],
        fields[FILM_BEFORE:],
        block.passed[PASSED],
        block.passed[TRAVEL],
        x[STEP_BEFORE],
    )
    totals = parts.Totals(x[FRICTION_WORK], x[BOUNDARY_WORK], x[ENERGY], x[VOLUME])
    return Memory(before, totals, layer_of(block, fixed.bore.bottom.size))


@compiled
def keep_memory(block: Block, memory: Memory, follows: bool):
    """A `step.Memory` into the block, parts of which it may consist of; oil outside the film if it
    is followed.
    """
    fields = block.fields
    film, totals, layer = memory
    keep(fields[UNKNOWN_BEFORE], film.unknown_before)
    keep(fields[UNKNOWN], film.unknown)
    keep(fields[GROWTH_BEFORE], film.growth_before)
    keep(fields[GROWTH], film.growth)
    keep(fields[CONTENT], film.content)
    keep(fields[DEFLECTION], film.deflection)
    keep(fields[FILM_BEFORE:], film.film_before)
    keep(fields[FILM:FILM_BEFORE], film.film)
    keep(block.passed[PASSED], film.passed)
    keep(block.passed[TRAVEL], film.travel)
    x = block.counts
    x[STEP_BEFORE] = film.step
    x[FRICTION_WORK] = totals.friction_work
    x[BOUNDARY_WORK] = totals.boundary_work
    x[ENERGY] = totals.stored
    x[VOLUME] = totals.volume
    if follows:
        keep(block.on_bore[: layer.bore.size], layer.bore)
        keep(block.reservoir, layer.reservoir)
        keep(fields[SPILLED], layer.spilled)
        x[REACHED] = layer.reached
        x[HEIGHT] = layer.height
        x[VELOCITY] = layer.velocity
        x[VELOCITY_BEFORE] = layer.velocity_before
        x[SUPPLIED] = layer.supplied
        x[HELD] = layer.held


@compiled
def keep_last(block: Block, last: Last):
    """A `step.Last` into the block."""
    to = block.last
    shear = last.shear
    keep(to[VELOCITY_NOW], shear.velocity)
    keep(to[TURNING_NOW], last.turning.velocity)
    keep(to[SOLVED_NOW], last.filling.pressure)
    keep(to[PRESSURE_NOW], last.under.pressure)
    if last.under.ratio.size > 0:
        keep(to[RATIO_NOW], last.under.ratio)
        keep(to[RATIO_SLOPE_NOW], last.under.slope)
    keep(to[FRACTION_NOW], last.filling.film_fraction)
    keep(to[UNKNOWN_NOW], last.unknown)
    keep(to[SHEARING_NOW], shear.shearing)
    keep(to[STRESS_NOW], shear.boundary_stress)
    keep(to[FILM_NOW:SLOPES_NOW], last.film)
    keep(to[SLOPES_NOW:BY_VELOCITY_NOW], last.slopes.by_film)
    if last.slopes.by_velocity.shape[0] > 0:
        keep(to[BY_VELOCITY_NOW:BY_TURNING_NOW], last.slopes.by_velocity)
        keep(to[BY_TURNING_NOW:PRESSURE_SLOPE_NOW], last.slopes_around.by_velocity)
    keep(to[PRESSURE_SLOPE_NOW:STRESS_SLOPE_NOW], last.pressure_slope)
    keep(to[STRESS_SLOPE_NOW:STENCIL_NOW], last.stress_slope)
    keep(to[STENCIL_NOW:], last.stencil)
    for i in range(to.shape[1]):
        for j in range(to.shape[2]):
            to[FULL_NOW, i, j] = 1.0 if last.full[i, j] else 0.0
    keep(block.last_faces[LIFT], last.filling.lift)
    keep(block.last_faces[LIMIT], last.edges.limit)
    x = block.last_numbers
    x[EULER_LENGTH] = last.length
    x[TOUCHING] = 1.0 if last.touching else 0.0
    x[LINEAR] = 0.0
    x[LOWER_NOW] = shear.constants.lower
    x[UPPER_NOW] = shear.constants.upper
    x[OPENING_NOW] = last.turning.end
    keep(x[EDGES_NOW : EDGES_NOW + 5], last.edges.pressure)
    keep(x[EDGES_NOW + 5 :], last.edges.film_fraction)


@compiled
def last_of(block: Block, fixed: Fixed):
    """`step.Last` in the block."""
    of = block.last
    x = block.last_numbers
    shape = block.mask.shape
    n_c, n_a = shape
    cells = fixed.domain.cells
    film = of[FILM_NOW:SLOPES_NOW]
    by_film = of[SLOPES_NOW:BY_VELOCITY_NOW]
    by_velocity = np.zeros((0, n_c, n_a))
    by_turning = by_velocity
    if fixed.laws.thinning.kind != NO_THINNING:
        by_velocity = of[BY_VELOCITY_NOW:BY_TURNING_NOW]
        by_turning = of[BY_TURNING_NOW:PRESSURE_SLOPE_NOW]
    ratio = np.zeros((0, 0))
    slope = ratio
    if int(chosen_from(block.chosen).pressure_viscosity_law) - 1 != NO_LAW:
        ratio = of[RATIO_NOW]
        slope = of[RATIO_SLOPE_NOW]
    full = np.empty(shape, np.bool_)
    for i in range(n_c):
        for j in range(n_a):
            full[i, j] = of[FULL_NOW, i, j] != 0.0
    rounding = fixed.surfaces.rounding_velocity
    shear = ShearInputs(
        of[PRESSURE_NOW],
        of[SHEARING_NOW],
        of[VELOCITY_NOW],
        raised(film, ratio),
        of[STRESS_NOW],
        fixed.surfaces.area,
        ShearConstants(x[LOWER_NOW], x[UPPER_NOW], cells.dy, rounding),
    )
    return Last(
        film,
        FilmSlopes(by_film, by_velocity),
        FilmSlopes(by_film, by_turning),
        TruePressure(of[PRESSURE_NOW], ratio, slope),
        Filling(of[SOLVED_NOW], of[FRACTION_NOW], block.last_faces[LIFT]),
        Edges(x[EDGES_NOW : EDGES_NOW + 5], x[EDGES_NOW + 5 :], block.last_faces[LIMIT]),
        x[EULER_LENGTH],
        of[UNKNOWN_NOW],
        full,
        of[STENCIL_NOW:],
        shear,
        of[PRESSURE_SLOPE_NOW:STRESS_SLOPE_NOW],
        of[STRESS_SLOPE_NOW:STENCIL_NOW],
        x[TOUCHING] != 0.0,
        Turning(of[TURNING_NOW], x[OPENING_NOW], cells.dx, cells.ring),
    )


@compiled
def keep_linear(block: Block, linear: Linear):
    """A `step.Linear` into the block."""
    to = block.linear
    keep(to[:TO_TURNING], linear.stencil)
    keep_all(to[SHEAR_SLOPES:PRESSURE_SHARE], linear.film.shear)
    keep(to[PRESSURE_SHARE], linear.film.pressure_share)
    keep(to[FRACTION_SHARE], linear.film.fraction_share)
    if linear.weight.size > 0:
        keep(to[WEIGHT], linear.weight)
    if linear.stencil_around.size > 0:
        keep(to[TO_TURNING:SHEAR_SLOPES], linear.stencil_around)
        keep_all(to[TURNING_SLOPES:CONTACT_PRESSURE], linear.around)
    if linear.contact_pressure.size > 0:
        keep(to[CONTACT_PRESSURE:CONTACT_SHEAR], linear.contact_pressure)
        keep(to[CONTACT_SHEAR:CONTACT_AROUND], linear.contact_shear)
    if linear.contact_around.size > 0:
        keep(to[CONTACT_AROUND:], linear.contact_around)


@compiled
def linear_of(block: Block, fixed: Fixed):
    """`step.Linear` in the block."""
    of = block.linear
    n_c, n_a = block.mask.shape
    k = SHEAR_SLOPES
    shear = ShearSlopes(of[k], of[k + 1], of[k + 2], of[k + 3], of[k + 4])
    k = TURNING_SLOPES
    return Linear(
        of[:TO_TURNING].reshape((2, 5, n_c, n_a)),
        of[TO_TURNING:SHEAR_SLOPES].reshape((2, 5, n_c, n_a)),
        ForceSlopes(
            shear,
            fixed.surfaces.area,
            of[PRESSURE_SHARE],
            of[FRACTION_SHARE],
            fixed.domain.cells.dy,
        ),
        TurningSlopes(
            of[k], of[k + 1], of[k + 2], of[k + 3], of[k + 4], of[k + 5], of[k + 6], of[k + 7]
        ),
        of[WEIGHT] if fixed.surfaces.compliance > 0.0 else np.zeros((0, 0)),
        of[CONTACT_PRESSURE:CONTACT_SHEAR],
        of[CONTACT_SHEAR:CONTACT_AROUND],
        of[CONTACT_AROUND:],
    )
