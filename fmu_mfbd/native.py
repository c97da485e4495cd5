"""Bodies as a library that needs no Python: what its memory begins with, its entries, and what it
covers. The entries put the kernels and functions of `dynamics` together, as `model` does.
"""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ..master.fmi.compiled import compiled
from ..master.fmi.errors import BadInput
from ..master.fmi.native_parts import Entry, NativePart, size
from ..master.fmi.slave import PRODUCT, SEED, reserved
from .dynamics.account import account
from .dynamics.assembly import (
    BESIDE_BOSSES,
    BESIDE_EYE,
    NO_PIN_MASS,
    NO_ROD,
    OTHER_FRICTION,
    TURN,
    damping_at,
    lies_beside,
    machined_gap,
    measured,
    modes_beside_pin,
    pin_height,
    pin_radius,
    pin_surfaces,
    surfaces,
)
from .dynamics.block_force import StepEnd, by_carrier, carried_force, force_at, force_change
from .dynamics.build_options import BuildOptions
from .dynamics.carrier import FIXED, Carrier
from .dynamics.drive import demand_of, others_of, scalars_of
from .dynamics.elimination import Factors
from .dynamics.first_steps import FIRST_STEPS, first_steps
from .dynamics.floating_frame import Arrow
from .dynamics.floating_pin import (
    COORDINATES,
    inertia,
    inertia_with_rod,
    layout,
    of_eye,
)
from .dynamics.gas_on_bore import bore_wall
from .dynamics.generalised_alpha import Coefficients, Motion, coefficients
from .dynamics.instant import Linear, RingForce, end_of_step, linearise, response
from .dynamics.parameters import (
    CRANK_PARAMETERS,
    GAS_TWICE,
    NO_GAS_TABLE,
    Parameters,
    PinParameters,
)
from .dynamics.pin_instant import EYE, PinStepEnd, end_of_pin_step, respond_pin
from .dynamics.piston_motion import LATERAL, RIGID, ROCKING, Load
from .dynamics.slider_crank import CrankMotion, driven
from .dynamics.tables import gas_pressure
from .geometry import pin_surfaces as pin_block
from .geometry.film import NodalForces, knot_rule
from .geometry.grid import cell_centres
from .geometry.pin import PinForces
from .geometry.pin_surfaces import CLEARANCE, part_of_pin
from .geometry.pin_surfaces import NUMBERS as PIN_NUMBERS
from .geometry.profile import fourier_bore, linear_growth
from .geometry.surfaces import count_of, in_block, surface_at, with_room
from .native_block import (
    ACCELERATION,
    AUXILIARY,
    BAND_ABOVE,
    BAND_RATIO,
    BANDS_GIVEN,
    BLOCK_DAMPING,
    BLOCK_MODES,
    BLOCK_OMEGA,
    BLOCK_PRODUCTS,
    BLOCK_STIFFNESS,
    BORE_RADIUS,
    BOSS_RADIUS,
    CARRIED,
    CARRIED_SEEDS,
    CELLS,
    COLUMNS,
    CONSTANTS,
    COUPLING,
    CRANK_ACCELERATION,
    CRANK_ANGLE,
    CRANK_SPEED,
    CRANK_SPEED_GIVEN,
    CYLINDER_PRESSURE,
    DIAGONAL,
    DRAG,
    DRAG_SEED,
    ENERGY_GAIN,
    ENERGY_SIZE,
    EVALUATIONS,
    EYE_COORDINATE,
    EYE_DAMPING,
    EYE_OMEGA,
    EYE_RADIUS,
    EYE_STIFFNESS,
    EYE_VELOCITY,
    FACTORS,
    FAULT,
    FAULT_A,
    FAULT_B,
    FAULT_C,
    FAULT_I,
    FAULTS_AT,
    FILM_CELLS,
    FILM_PRODUCTS,
    FILM_SEEDS,
    FILM_THICKNESS,
    FORCE,
    FORCE_SEED,
    GAS,
    GAS_ANGLE,
    GAS_CYCLE,
    GAS_PRESSURE,
    GUIDED,
    HAS_BIG_END,
    HAS_MAIN_BEARING,
    HEIGHTS,
    INERTIA_MATRIX,
    INPUTS,
    INVERSE,
    IS_LINEAR,
    JACOBIAN_EVALUATIONS,
    KINETIC,
    LAND,
    LAST_ACCELERATION,
    LAST_CARRIER,
    LAST_COEFFICIENTS,
    LAST_CRANK,
    LAST_LOAD,
    LAST_NUMBERS,
    LAST_POSITION,
    LAST_VELOCITY,
    LEFT,
    LINEAR_NUMBERS,
    MEASURED,
    MODAL_COORDINATE,
    MODAL_LOAD,
    MODAL_VELOCITY,
    MOST_FAULTS,
    NOWHERE,
    NUMBERS,
    OF_A_FAULT,
    OF_FILM,
    OF_INPUTS,
    OF_LAST,
    OF_OUTPUTS,
    OF_PIN_OUTPUTS,
    OF_PRODUCTS,
    OF_SEEDS,
    OF_STATE,
    ON_BLOCK,
    ON_PIN,
    ORDER,
    OTHER_FORCES,
    OUTPUTS,
    PARTS,
    PARTS_FROM,
    PIN_CELLS,
    PIN_OFFSET,
    PIN_OUTPUTS,
    PIN_SURFACES_AT,
    PISTON_DAMPING,
    PISTON_MODES,
    PISTON_OMEGA,
    PISTON_RADIUS,
    PISTON_STIFFNESS,
    POSITION,
    PRODUCED,
    RESIDUAL_EVALUATIONS,
    RINGS,
    SEEDED,
    SETTING,
    SETTING_COUNT,
    SETTINGS,
    SIDE_FORCE_DEMAND,
    SKIRT_LOWER,
    SKIRT_UPPER,
    SLIDING_PRODUCT,
    SLIDING_VELOCITY,
    START_ANGLE,
    START_GIVEN,
    START_POSITION,
    START_VELOCITY,
    STATE,
    STEPS,
    SURFACES,
    TANGENTS,
    THICKNESS_PRODUCT,
    TIME,
    TOP,
    VELOCITY,
    WALL_ABOVE,
    WALL_ABOVE_NOW,
    WALL_AT,
    WALL_AT_NOW,
    WIDENING,
    WITH_ROD,
    WORK_ERROR,
    carrier_from,
    coefficients_from,
    count,
    crank_from,
    film_place,
    films,
    linear_from,
    load_from,
    part,
    pin_films,
    pin_system_of,
    place,
    put_carrier,
    put_coefficients,
    put_crank,
    put_linear,
    put_load,
    settings_of,
    system_of,
)
from .reduction.reduced_body import (
    ReducedBlock,
    ReducedBosses,
    ReducedPiston,
    ReducedSmallEnd,
    load,
)


class GasAtAngle(NamedTuple):
    """`GasTable`, as kernels know it."""

    angle: np.ndarray
    pressure: np.ndarray
    cycle: float


COVERED: dict[str, tuple[str, ...] | float] = {"crank_free": 0.0, "quasi_static_frequency": 1e9}
"""The only value of a number that is in the library; all else is free."""

FAULTS = (
    "rod_length: expected more than crank_radius plus the offsets, {b} m, got {a} m",
    "rod_centre: expected at most rod_length = {b} m, got {a} m",
    "second_ring_height: expected {b} m, the skirt's upper edge, to top_ring_height = {c} m, "
    "got {a} m",
    "crank_radius, rod_length: expected a skirt within the bore, {c} to {i} m, "
    "got {a} to {b} m above the crank axis",
    "piston motion at crank angle {a} rad: Newton's method finds no accelerations; their last "
    "relative change is {b} (nan: diverged)",
    "crank angle = {a} rad: must be finite",
    BESIDE_BOSSES,
    BESIDE_EYE,
    NO_PIN_MASS,
    *OTHER_FRICTION.values(),
    *NO_ROD.values(),
    NO_GAS_TABLE,
    GAS_TWICE,
)
(
    ROD_TOO_SHORT,
    CENTRE_BEYOND,
    RINGS_REVERSED,
    OUT_OF_BORE,
    NOT_SOLVED,
    NO_ANGLE,
    NOT_OF_BOSSES,
    NOT_OF_EYE,
    WITHOUT_PIN_MASS,
    FRICTION_OF_PIN,
) = range(10)
FRICTION_SPEED = FRICTION_OF_PIN + 1
FRICTION_DAMPING = FRICTION_OF_PIN + 2
WITHOUT_TABLE, GIVEN_TWICE = len(FAULTS) - 2, len(FAULTS) - 1
GAS_EITHER, GAS_TABLE, GAS_INPUT = range(1, 4)
"""Numbers of the choices in `GAS_SOURCES`."""
CHOSEN_GAS = SETTING.index("gas_source")
ROD_IN_BIG_END = FRICTION_OF_PIN + len(OTHER_FRICTION)
ROD_IN_BEARING = ROD_IN_BIG_END + 2
ROD_IN_BOTH = ROD_IN_BIG_END + 4
"""Without mass of the rod, and without inertia one further."""
USUAL = Parameters()
USUAL_FRICTION = float(USUAL.pin_friction_coefficient)
USUAL_SPEED = float(USUAL.pin_friction_speed)
USUAL_DAMPING = float(USUAL.pin_friction_damping)

OPTIONS = {
    "speed": "a table of crank speed",
    "motion_in_space": "a motion in space",
    "in_space": "a motion in space",
}
"""Build options, as a case gives them and as build.json holds them, that are not covered."""
ON_WHEN_EMPTY = ("motion_in_space", "in_space")
"""Those of which an empty table is a choice."""


def uncovered(options: Mapping[str, Any]) -> Iterable[str]:
    """Sentences on build options that the library does not cover."""
    for name, what in OPTIONS.items():
        if options.get(name) or (name in ON_WHEN_EMPTY and options.get(name) == {}):
            yield f"{name}: expected nothing in a native FMU, got {what}"
    if (options.get("block") or {}).get("bore_from_outside"):
        yield "block.bore_from_outside: expected nothing in a native FMU, got a table"
    if shapes := dict(options.get("floating_pin") or {}).get("pin_shapes"):
        yield f"floating_pin.pin_shapes: expected 0 in a native FMU, got {shapes}"


# ---- what the memory begins with


def given(slave: Any) -> np.ndarray:
    """What the memory of a slave begins with: head, then the parts that depend on no parameter.

    Parameters
    ----------
    slave : slave.Mfbd
        Its resources hold the reduced bodies.
    """
    options: BuildOptions = slave.built
    piston = load(ReducedPiston, slave.resources / options.piston.file)
    block = load(ReducedBlock, slave.resources / options.block.file)
    if piston.radius >= block.radius:
        raise BadInput(
            f"piston: expected a skirt radius below the bore radius, {block.radius:g} m, got "
            f"{piston.radius:g} m"
        )
    contents = _contents(piston, block, options) | _of_pin(slave, piston, block)
    contents |= {"places": _places(slave), "film_places": _film_places(slave)}
    contents["counts"] = np.append(contents["counts"], _pin_cells(options))
    contents["constants"] = np.append(contents["constants"], contents.pop("pin_constants"))
    lengths = {name: np.size(value) for name, value in contents.items()}
    lengths |= _lengths(lengths, options)
    begins = np.cumsum([PARTS_FROM + len(PARTS) + 1, *(lengths[name] for name in PARTS)])
    first = dict(zip(PARTS, begins))
    states = sum(lengths[name] for name in STATE)
    head = [begins[-1], first[STATE[0]], states, first["faults"], *begins]
    return np.concatenate([head, *(contents[name] for name in PARTS if name in contents)])


def _contents(piston: ReducedPiston, block: ReducedBlock, options: BuildOptions):
    """Parts that are given, one-dimensional, by name."""
    angle, height = cell_centres(*options.grid, piston.skirt_lower, piston.skirt_upper)
    k, m = len(piston.omega), len(block.omega)
    wall = bore_wall(block.heights, block.radial, block.radius, 1.0, 1.0)
    orders = fourier_bore(options.block.orders, angle)[:, None]
    widening = orders + measured(options.block.profiles, angle, block.heights)
    widening = np.broadcast_to(widening, (len(angle), len(block.heights)))
    profile = np.broadcast_to(measured(options.piston.profiles, angle, height), options.grid)
    of_films = [profile[:, one.first : one.last].ravel() for one in options.film_surfaces()]
    gas, begin = options.gas, options.start
    constants = [
        piston.mass,
        piston.I0,
        piston.radius,
        piston.skirt_lower,
        piston.skirt_upper,
        options.piston.pin_offset,
        block.radius,
        block.heights[1] - block.heights[0],
        gas.cycle if gas else 0.0,
        bool(options.damping_bands),
        begin is not None,
        begin.crank_angle if begin else 0.0,
    ]
    bands = options.damping_bands
    n = coordinates(options, k, m)
    contents = {
        "counts": [sum(map(len, of_films)), k, m, len(block.heights)],
        "constants": constants,
        "surfaces": _surfaces(piston, block, options),
        "measured": np.concatenate(of_films),
        "heights": block.heights,
        "widening": widening,
        "inverse": knot_rule(len(block.heights)),
        "band_above": [band.above for band in bands] or np.zeros(2),
        "band_ratio": [band.ratio for band in bands] or np.zeros(2),
        "gas_angle": gas.angle if gas else [],
        "gas_pressure": gas.pressure if gas else [],
        "start_position": begin.position() if begin else np.zeros(n),
        "start_velocity": begin.velocity() if begin else np.zeros(n),
        "first_moment": piston.S,
        "T": piston.T,
        "b": piston.b,
        "B": piston.B,
        "g": piston.g,
        "G": piston.G,
        "piston_omega": piston.omega,
        "gas_force": piston.gas_force,
        "block_omega": block.omega,
        "wall_above": wall.above,
        "wall_at": wall.at,
    }
    return {name: np.asarray(value, dtype=float).ravel() for name, value in contents.items()}


def _surfaces(piston, block, options):
    """All film surfaces in a block, with room for the widening of the bore that they share."""
    made = surfaces(piston, block, options, Parameters())
    return in_block(with_room(made, len(block.heights)))


def coordinates(options: BuildOptions, piston_modes: int, block_modes: int) -> int:
    """How many the bodies have."""
    pin = options.floating_pin
    if pin is None:
        return RIGID + piston_modes + block_modes
    return COORDINATES + piston_modes + pin.small_end_modes + 2 * len(options.crank_bearings)


def _pin_cells(options):
    """Cells of all films of pin and crank."""
    return sum(int(np.prod(film.shape)) for film in options.pin_grids())


def _of_pin(slave, piston, block):
    """Parts of a floating pin that are given."""
    options = slave.built
    pin = options.floating_pin
    if pin is None:
        return {"pin_surfaces": np.zeros(1), "eye_omega": np.zeros(0), "pin_constants": np.zeros(4)}
    bosses = load(ReducedBosses, slave.resources / pin.bosses) if pin.bosses else None
    eye = load(ReducedSmallEnd, slave.resources / pin.small_end) if pin.small_end else None
    if wrong := modes_beside_pin(piston, block, bosses):
        raise BadInput(wrong)
    crank = {name: CRANK_PARAMETERS[name]() for name in options.crank_surfaces()}
    films = pin_surfaces(options, 1.0, PinParameters(), crank, bosses, eye)
    return {
        "pin_surfaces": pin_block.in_block(films),
        "eye_omega": eye.eye_omega if eye else np.zeros(0),
        "pin_constants": np.array(
            [
                "big_end" in crank,
                "main_bearing" in crank,
                bosses.boss_radius if bosses else 0.0,
                eye.eye_radius if eye else 0.0,
            ],
            dtype=float,
        ),
    }


def _places(slave):
    """Where the numbers lie among a slave's variables."""
    places = [slave.references.get(name, NOWHERE) for name in (*SETTING, *INPUTS, *OUTPUTS)]
    places += _reserved(slave, SEED, SEEDED) + _reserved(slave, PRODUCT, PRODUCED)
    places += [slave.references.get(name, NOWHERE) for name in PIN_OUTPUTS]
    places[SETTING.index("crank_free")] = NOWHERE  # no real number; 0 is all that is covered
    # `gas_source` is a choice: its place is among the whole numbers
    return np.array(places, dtype=float)


def _film_places(slave):
    """Where the fields of all surfaces begin among a slave's variables."""
    films = [(film, {}) for film in slave.built.film_grids()]
    films += [(film, ON_PIN) for film in slave.built.pin_grids()]
    rows = []
    for film, others in films:
        fields, seeds, products = (
            [f"{film.prefix}{others.get(name, name)}" for name in names]
            for names in (OF_FILM, FILM_SEEDS, FILM_PRODUCTS)
        )
        rows += [slave.references[name] for name in fields]
        rows += _reserved(slave, SEED, seeds) + _reserved(slave, PRODUCT, products)
        rows.append(np.prod(film.shape))
    return np.array(rows, dtype=float)


def _reserved(slave, kind, names):
    """Where seeds or products of variables lie."""
    return [slave.references.get(reserved(kind, name), NOWHERE) for name in names]


def _lengths(given, options):
    """Lengths of the parts that are made later, from those that are given."""
    k, m = given["piston_omega"], given["block_omega"]
    n = coordinates(options, k, m)
    floats = options.floating_pin is not None
    of_motion = n if floats else RIGID + k
    of_tangent = 0 if floats else k
    of_pin = n if floats else 0
    return {
        "settings": SETTING_COUNT,
        "wall_above_now": given["wall_above"],
        "wall_at_now": given["wall_at"],
        "piston_stiffness": k,
        "piston_damping": k,
        "block_stiffness": m,
        "block_damping": m,
        "eye_stiffness": given["eye_omega"],
        "eye_damping": given["eye_omega"],
        "inertia": of_pin * of_pin,
        "with_rod": of_pin * of_pin,
        "none": 0,
        "numbers": len(OF_STATE),
        **dict.fromkeys(STATE[1:], n),
        "last_numbers": len(OF_LAST),
        "last_coefficients": len(Coefficients._fields),
        "last_load": len(Load._fields),
        "last_carrier": len(Carrier._fields),
        "last_crank": len(CrankMotion._fields),
        "last_position": of_motion,
        "last_velocity": of_motion,
        "last_acceleration": of_motion,
        "modal_load": k,
        "linear_numbers": len(Linear._fields),
        "top": 0 if floats else RIGID * of_motion,
        "left": RIGID * of_tangent,
        "diagonal": of_tangent,
        "coupling": of_tangent * of_tangent,
        "columns": len(Carrier._fields) * of_motion if options.mounted else 0,
        "factors": of_pin * of_pin,
        "order": of_pin,
        "faults": 1 + OF_A_FAULT * MOST_FAULTS,
    }


# ---- a start


@compiled
def refuse(memory, number, a, b, c, d):
    """Note a fault: its number among FAULTS and what its sentence names."""
    faults = part(memory, FAULTS_AT)
    at = int(faults[0])
    if at < MOST_FAULTS:
        one = faults[1 + OF_A_FAULT * at :]
        one[FAULT] = number
        one[FAULT_I] = d
        one[FAULT_A] = a
        one[FAULT_B] = b
        one[FAULT_C] = c
        faults[0] = at + 1.0


@compiled
def remark(memory, number):
    """Note a warning in the place of the first fault: below 0, and no fault is counted."""
    faults = part(memory, FAULTS_AT)
    if faults[0] == 0.0:
        faults[1 + FAULT] = -1.0 - number


@compiled
def refused(memory):
    """Whether a fault is noted."""
    return part(memory, FAULTS_AT)[0] > 0.0


@compiled
def check_pin(memory, p):
    """Note what does not go with a floating pin, as `assembly.floating_faults`, `eye_faults` and
    `crank_faults`.
    """
    x = part(memory, CONSTANTS)
    radius = pin_radius(x[PISTON_RADIUS], p)
    if x[BOSS_RADIUS] > 0.0 and lies_beside(radius, x[BOSS_RADIUS]):
        refuse(memory, NOT_OF_BOSSES, 1e3 * radius, 1e3 * x[BOSS_RADIUS], 0.0, 0.0)
    if p.pin_mass == 0.0:
        refuse(memory, WITHOUT_PIN_MASS, 0.0, 0.0, 0.0, 0.0)
    if p.pin_friction_coefficient != 0.0 and p.pin_friction_coefficient != USUAL_FRICTION:
        refuse(memory, FRICTION_OF_PIN, p.pin_friction_coefficient, 0.0, 0.0, 0.0)
    if p.pin_friction_speed != 0.0 and p.pin_friction_speed != USUAL_SPEED:
        refuse(memory, FRICTION_SPEED, p.pin_friction_speed, 0.0, 0.0, 0.0)
    if p.pin_friction_damping != 0.0 and p.pin_friction_damping != USUAL_DAMPING:
        refuse(memory, FRICTION_DAMPING, p.pin_friction_damping, 0.0, 0.0, 0.0)
    if x[EYE_RADIUS] > 0.0 and lies_beside(radius, x[EYE_RADIUS]):
        refuse(memory, NOT_OF_EYE, 1e3 * radius, 1e3 * x[EYE_RADIUS], 0.0, 0.0)
    has_big_end = x[HAS_BIG_END] > 0.0
    has_bearing = x[HAS_MAIN_BEARING] > 0.0
    if has_big_end or has_bearing:
        sentence = ROD_IN_BIG_END
        if has_bearing:
            sentence = ROD_IN_BOTH if has_big_end else ROD_IN_BEARING
        if p.rod_mass == 0.0:
            refuse(memory, sentence, 0.0, 0.0, 0.0, 0.0)
        if p.rod_inertia == 0.0:
            refuse(memory, sentence + 1, 0.0, 0.0, 0.0, 0.0)


@compiled
def check(memory):
    """Note parameters that do not fit each other, as `assembly.faults`."""
    x = part(memory, CONSTANTS)
    p = settings_of(memory)
    offset = x[PIN_OFFSET] - p.crank_offset
    reach = p.crank_radius + abs(offset)
    if p.rod_length**2 - reach**2 <= 0.0:
        refuse(memory, ROD_TOO_SHORT, p.rod_length, reach, 0.0, 0.0)
        return
    if p.gas_source == GAS_TABLE and not len(part(memory, GAS_ANGLE)):
        refuse(memory, WITHOUT_TABLE, 0.0, 0.0, 0.0, 0.0)
    if p.rod_centre > p.rod_length:
        refuse(memory, CENTRE_BEYOND, p.rod_centre, p.rod_length, 0.0, 0.0)
    upper = x[SKIRT_UPPER]
    second = p.second_ring_height
    if p.top_ring_height > 0.0 and not upper <= second <= p.top_ring_height:
        refuse(memory, RINGS_REVERSED, second, upper, p.top_ring_height, 0.0)
    if pin_films(memory) > 0:
        check_pin(memory, p)
    lowest = np.inf
    highest = -np.inf
    for k in range(TURN):
        turn = 2 * np.pi * k / (TURN - 1)
        height = pin_height(turn, offset, p.crank_radius, p.rod_length)
        lowest = min(lowest, height)
        highest = max(highest, height)
    lowest += x[SKIRT_LOWER]
    highest += upper
    heights = part(memory, HEIGHTS)
    if lowest < heights[0] or highest > heights[-1]:
        refuse(memory, OUT_OF_BORE, lowest, highest, heights[0], heights[-1])


@compiled
def damp(memory, p, omega, damping):
    """Damping of a body's modes, by the bands that hold their frequencies (Eq. (I5))."""
    above = part(memory, BAND_ABOVE)
    ratio = part(memory, BAND_RATIO)
    for k in range(len(omega)):
        band = 0
        for j in range(len(above)):
            if 2 * np.pi * above[j] <= omega[k]:
                band = j
        damping[k] = damping_at(
            omega[k], ratio[band], p.rayleigh_mass_factor, p.rayleigh_stiffness_factor
        )


@compiled
def machine(memory, p):
    """Gaps of all surfaces, as `assembly.skirt_gap`."""
    x = part(memory, CONSTANTS)
    profile = part(memory, MEASURED)
    all_of_them = part(memory, SURFACES)
    first = 0
    for k in range(count_of(all_of_them)):
        skirt = surface_at(all_of_them, k).skirt
        c, a = skirt.gap.shape
        for i in range(c):
            for j in range(a):
                skirt.gap[i, j] = profile[first + i * a + j] + machined_gap(
                    skirt.angle[i], skirt.height[j], x[SKIRT_LOWER], x[SKIRT_UPPER], p
                )
        first += c * a


@compiled
def machine_pins(memory, p):
    """Radii and clearances of pin and crank, as `assembly.pin_surfaces`; what has inertia."""
    x = part(memory, CONSTANTS)
    block = part(memory, PIN_SURFACES_AT)
    for k in range(pin_films(memory)):
        radius = pin_radius(x[PISTON_RADIUS], p)
        clearance = p.boss_clearance if k < EYE else p.small_end_clearance
        if k == EYE + 1 and x[HAS_BIG_END] > 0.0:
            radius = p.big_end_radius
            clearance = p.big_end_clearance
        elif k > EYE:
            radius = p.main_bearing_radius
            clearance = p.main_bearing_clearance
        part_of_pin(block, k, PIN_NUMBERS)[0] = radius
        rows = part_of_pin(block, k, CLEARANCE)
        for j in range(len(rows)):
            rows[j] = clearance
    bodies = pin_system_of(memory, system_of(memory)).bodies
    moving = inertia(bodies)
    keep(part(memory, INERTIA_MATRIX), moving.reshape(moving.size))
    with_rod = inertia_with_rod(bodies)
    keep(part(memory, WITH_ROD), with_rod.reshape(with_rod.size))


@compiled
def widen(memory, p):
    """The bore's widening, as `assembly.bore_shape`: of the one bore of all surfaces."""
    heights = part(memory, HEIGHTS)
    inverse = part(memory, INVERSE)
    widening = part(memory, WIDENING)
    shape = surface_at(part(memory, SURFACES), 0).bore.shape
    knots, c = shape.shape
    s = len(heights)
    for k in range(knots):
        for i in range(c):
            total = 0.0
            for j in range(s):
                wider = widening[i * s + j] + linear_growth(
                    heights[j], heights[0], heights[-1], p.bore_growth_lower, p.bore_growth_upper
                )
                total += inverse[k * s + j] * wider
            shape[k, i] = total


@compiled
def prepare(real, integer, memory):
    """What follows from the parameters, as `assembly.assemble`."""
    settings = part(memory, SETTINGS)
    for k in range(SETTING_COUNT):
        at = place(memory, k)
        settings[k] = 0.0
        if at >= 0:
            settings[k] = float(integer[at]) if k == CHOSEN_GAS else real[at]
    p = settings_of(memory)
    x = part(memory, CONSTANTS)
    machine(memory, p)
    widen(memory, p)
    gas = 1.0 if p.top_ring_height > 0.0 else 0.0
    for given_part, made in ((WALL_ABOVE, WALL_ABOVE_NOW), (WALL_AT, WALL_AT_NOW)):
        source = part(memory, given_part)
        target = part(memory, made)
        for k in range(len(source)):
            target[k] = gas * source[k]
    if x[BANDS_GIVEN] == 0.0:
        part(memory, BAND_ABOVE)[1] = p.damping_transition_frequency
        part(memory, BAND_RATIO)[0] = p.damping_ratio
        part(memory, BAND_RATIO)[1] = p.high_frequency_damping_ratio
    for of_omega, stiffness, damping in (
        (PISTON_OMEGA, PISTON_STIFFNESS, PISTON_DAMPING),
        (BLOCK_OMEGA, BLOCK_STIFFNESS, BLOCK_DAMPING),
        (EYE_OMEGA, EYE_STIFFNESS, EYE_DAMPING),
    ):
        omega = part(memory, of_omega)
        damp(memory, p, omega, part(memory, damping))
        for k in range(len(omega)):
            part(memory, stiffness)[k] = omega[k] ** 2
    if pin_films(memory) > 0:
        machine_pins(memory, p)


# ---- a step


@compiled
def stacked(real, memory, which, cells):
    """So many of the variables from a place on."""
    at = place(memory, which)
    return real[at : at + cells]


@compiled
def gathered(real, memory, which, of_pin):
    """A field of all film surfaces of the skirt, or of pin and crank, their cells one after
    another.
    """
    field = np.empty(count(memory, PIN_CELLS if of_pin else CELLS))
    begin = films(memory) if of_pin else 0
    end = films(memory) + (pin_films(memory) if of_pin else 0)
    first = 0
    for s in range(begin, end):
        cells = film_place(memory, s, FILM_CELLS)
        at = film_place(memory, s, which)
        for k in range(cells):
            field[first + k] = real[at + k]
        first += cells
    return field


@compiled
def scatter(real, memory, which, field, of_pin):
    """The opposite: a stacked field into the variables of all film surfaces."""
    begin = films(memory) if of_pin else 0
    end = films(memory) + (pin_films(memory) if of_pin else 0)
    first = 0
    for s in range(begin, end):
        cells = film_place(memory, s, FILM_CELLS)
        at = film_place(memory, s, which)
        for k in range(cells):
            real[at + k] = field[first + k]
        first += cells


@compiled
def number_at(real, memory, which):
    """A scalar input or seed."""
    return real[place(memory, which)]


@compiled
def rings_at(real, memory, first):
    """Forces of the rings, or their seeds, from a place on."""
    return RingForce(
        number_at(real, memory, first),
        number_at(real, memory, first + 1),
        number_at(real, memory, first + 2),
    )


@compiled
def carried_at(real, memory, first):
    """Motion of a mounted block, or its seeds, from a place on; 0 of another."""
    motion = np.zeros(len(FIXED))
    if is_mounted(memory):
        for k in range(len(motion)):
            motion[k] = number_at(real, memory, first + k)
    return motion


@compiled
def is_mounted(memory):
    """Whether the block moves."""
    return place(memory, OF_INPUTS + CARRIED) >= 0


@compiled
def keep(to, what):
    """Copy, in a loop."""
    for k in range(len(to)):
        to[k] = what[k]


@compiled
def publish(real, integer, memory, now, scalars):
    """Outputs into the variables, and how much work there was so far."""
    for k in range(len(scalars)):
        real[place(memory, OF_OUTPUTS + k)] = scalars[k]
    scatter(real, memory, FILM_THICKNESS, now.film_thickness, False)
    scatter(real, memory, SLIDING_VELOCITY, now.sliding_velocity, False)
    for s in range(len(now.work_error)):
        real[film_place(memory, s, WORK_ERROR)] = now.work_error[s]
    modes = count(memory, PISTON_MODES) + count(memory, BLOCK_MODES)
    if modes:
        first = COORDINATES if pin_films(memory) > 0 else RIGID
        keep(stacked(real, memory, OF_OUTPUTS + MODAL_COORDINATE, modes), now.position[first:])
        keep(stacked(real, memory, OF_OUTPUTS + MODAL_VELOCITY, modes), now.kept_velocity[first:])
    last = part(memory, LAST_NUMBERS)
    last[EVALUATIONS] += now.evaluations
    last[TANGENTS] += now.tangents
    integer[place(memory, OF_OUTPUTS + RESIDUAL_EVALUATIONS)] = int(last[EVALUATIONS])
    integer[place(memory, OF_OUTPUTS + JACOBIAN_EVALUATIONS)] = int(last[TANGENTS])


@compiled
def publish_pin(real, memory, bodies, found):
    """Outputs of pin and crank into the variables; the tangent that derivatives ask for."""
    scatter(real, memory, FILM_THICKNESS, found.film_thickness, True)
    scatter(real, memory, SLIDING_VELOCITY, found.circumferential_velocity, True)
    for s in range(len(found.work_error)):
        real[film_place(memory, films(memory) + s, WORK_ERROR)] = found.work_error[s]
    scalars = found.scalars
    for k in range(len(scalars)):
        at = place(memory, OF_PIN_OUTPUTS + k)
        if at >= 0:
            real[at] = scalars[k]
    modes = len(bodies.eye.stiffness)
    if modes:
        first = layout(bodies)
        own = of_eye(first, found.now.position)
        keep(stacked(real, memory, OF_PIN_OUTPUTS + EYE_COORDINATE, modes), own)
        own = of_eye(first, found.now.kept_velocity)
        keep(stacked(real, memory, OF_PIN_OUTPUTS + EYE_VELOCITY, modes), own)
    keep(part(memory, FACTORS), found.factors.both.reshape(found.factors.both.size))
    keep(part(memory, ORDER), found.factors.order)


@compiled
def remember(memory, c, now, crank):
    """What a derivative at the end of this step starts from."""
    last = part(memory, LAST_NUMBERS)
    last[GUIDED] = now.guided
    last[IS_LINEAR] = 0.0
    put_coefficients(part(memory, LAST_COEFFICIENTS), c)
    put_load(part(memory, LAST_LOAD), now.load)
    put_carrier(part(memory, LAST_CARRIER), now.load.carrier)
    put_crank(part(memory, LAST_CRANK), crank)
    keep(part(memory, LAST_POSITION), now.position)
    keep(part(memory, LAST_VELOCITY), now.velocity)
    keep(part(memory, LAST_ACCELERATION), now.acceleration)
    keep(part(memory, MODAL_LOAD), now.load.modal)


class End(NamedTuple):
    """Of a step: the crank there, the time [s], and whether it is the start."""

    crank: CrankMotion
    time: float
    begins: bool


@compiled
def crown_pressure(real, memory, p, crank_angle):
    """Gas pressure by input and table [Pa], as `gas_source` says; a remark if it is given twice."""
    given = number_at(real, memory, OF_INPUTS + GAS)
    angle = part(memory, GAS_ANGLE)
    if len(angle) and given != 0.0 and p.gas_source == GAS_EITHER:
        remark(memory, GIVEN_TWICE)
    pressure = 0.0 if p.gas_source == GAS_TABLE else given
    if len(angle) and p.gas_source != GAS_INPUT:
        table = GasAtAngle(angle, part(memory, GAS_PRESSURE), part(memory, CONSTANTS)[GAS_CYCLE])
        pressure += gas_pressure(table, crank_angle)
    return pressure


@compiled
def solve(real, integer, memory, c, before, auxiliary, at):
    """The `End` of a step as `model.PistonInBore._solve`, state and outputs. A fault is noted where
    it is not found, and the state stays.
    """
    crank = at.crank
    if not np.isfinite(crank.angle):
        refuse(memory, NO_ANGLE, crank.angle, 0.0, 0.0, 0.0)
        return
    x = part(memory, CONSTANTS)
    p = settings_of(memory)
    system = system_of(memory)
    pressure = crown_pressure(real, memory, p, crank.angle)
    ride = carried_at(real, memory, OF_INPUTS + CARRIED)
    others = others_of(
        np.pi * x[BORE_RADIUS] ** 2,
        pressure,
        rings_at(real, memory, OF_INPUTS + RINGS),
        number_at(real, memory, OF_INPUTS + LAND),
        carrier_from(ride),
    )
    push = gathered(real, memory, FORCE, False)
    drag = gathered(real, memory, DRAG, False)
    if pin_films(memory) > 0:
        of = pin_system_of(memory, system)
        forces = PinForces(gathered(real, memory, FORCE, True), gathered(real, memory, DRAG, True))
        skirt = NodalForces(push, drag)
        found_with_pin = end_of_pin_step(of, c, before, auxiliary, crank, others, skirt, forces)
        now = found_with_pin.now
        if now.evaluations > 0:
            publish_pin(real, memory, of.bodies, found_with_pin)
    else:
        now = end_of_step(system, c, before, auxiliary, crank, others, push, drag)
    if now.evaluations == 0:
        refuse(memory, NOT_SOLVED, crank.angle, now.change, 0.0, 0.0)
        return
    scalars = scalars_of(now, crank, p.crank_inertia, system.piston, system.surfaces)
    state = part(memory, NUMBERS)
    publish(real, integer, memory, now, scalars)
    if not at.begins:
        n = len(now.position)
        way = np.empty(n)
        for k in range(n):
            way[k] = now.position[k] - before.position[k]
        found = account(
            (state[KINETIC], now.ledger.accounted),
            way,
            (part(memory, OTHER_FORCES), now.other_forces),
            scalars.energy_gain,
        )
        real[place(memory, OF_OUTPUTS + ENERGY_GAIN)] = found.gain
        real[place(memory, OF_OUTPUTS + ENERGY_SIZE)] = found.size
    real[place(memory, OF_OUTPUTS + CYLINDER_PRESSURE)] = pressure
    real[place(memory, OF_OUTPUTS + SIDE_FORCE_DEMAND)] = demand_of(system, others, crank)
    remember(memory, c, now, crank)
    if is_mounted(memory):
        force = force_at(end_of(memory, system))
        real[place(memory, OF_OUTPUTS + ON_BLOCK)] = force.x
        real[place(memory, OF_OUTPUTS + ON_BLOCK + 1)] = force.y
        real[place(memory, OF_OUTPUTS + ON_BLOCK + 2)] = force.moment
        real[place(memory, OF_OUTPUTS + ON_BLOCK + 3)] = force.bearing_x
        real[place(memory, OF_OUTPUTS + ON_BLOCK + 4)] = force.bearing_y
    state[TIME] = at.time
    state[CRANK_ANGLE] = crank.angle
    state[CRANK_SPEED] = crank.speed
    state[CRANK_ACCELERATION] = crank.acceleration
    state[KINETIC] = now.ledger.accounted
    state[STEPS] = 0.0 if at.begins else state[STEPS] + 1.0
    keep(part(memory, POSITION), now.position)
    keep(part(memory, VELOCITY), now.kept_velocity)
    keep(part(memory, ACCELERATION), now.kept_acceleration)
    keep(part(memory, OTHER_FORCES), now.other_forces)
    auxiliary_now = part(memory, AUXILIARY)
    forgets = state[STEPS] < FIRST_STEPS
    for k in range(len(auxiliary_now)):
        auxiliary_now[k] = 0.0 if forgets else now.auxiliary[k]


@compiled
def linear_of(memory, modes):
    """`Linear` in the memory."""
    arrow = Arrow(
        part(memory, TOP).reshape((RIGID, RIGID + modes)),
        part(memory, LEFT).reshape((modes, RIGID)),
        part(memory, DIAGONAL),
    )
    coupling = part(memory, COUPLING).reshape((modes, modes))
    return linear_from(part(memory, LINEAR_NUMBERS), arrow, coupling)


@compiled
def end_of(memory, system):
    """What derivatives at the end of the last step, and forces on the block, follow from."""
    load = load_from(
        part(memory, LAST_LOAD),
        part(memory, MODAL_LOAD),
        carrier_from(part(memory, LAST_CARRIER)),
    )
    now = Motion(
        part(memory, LAST_POSITION),
        part(memory, LAST_VELOCITY),
        part(memory, LAST_ACCELERATION),
    )
    return StepEnd(
        system.piston,
        system.mechanism,
        settings_of(memory).crank_unbalance,
        load,
        now,
        crank_from(part(memory, LAST_CRANK)),
    )


@compiled
def make_linear(memory, system):
    """Derivatives of the last step of a tied pin that every direction shares, into the memory."""
    end = end_of(memory, system)
    found = linearise(
        system,
        coefficients_from(part(memory, LAST_COEFFICIENTS)),
        end.load,
        end.now,
        end.crank,
    )
    if is_mounted(memory):
        columns = by_carrier(end)
        keep(part(memory, COLUMNS), columns.reshape(columns.size))
    put_linear(part(memory, LINEAR_NUMBERS), found)
    keep(part(memory, TOP), found.arrow.top.reshape(found.arrow.top.size))
    keep(part(memory, LEFT), found.arrow.left.reshape(found.arrow.left.size))
    keep(part(memory, DIAGONAL), found.arrow.diagonal)
    keep(part(memory, COUPLING), found.coupling.reshape(found.coupling.size))
    last = part(memory, LAST_NUMBERS)
    last[IS_LINEAR] = 1.0
    last[TANGENTS] += 1.0


@compiled
def change_of_tied(real, memory, system):
    """Answer of a tied pin to the seeds."""
    modes = len(part(memory, PISTON_OMEGA))
    moving = RIGID + modes
    carried = carried_at(real, memory, OF_SEEDS + CARRIED_SEEDS)
    on_piston = np.zeros(moving)
    if is_mounted(memory):
        columns = part(memory, COLUMNS).reshape((len(FIXED), moving))
        keep(on_piston, carried_force(columns, carried))
    return response(
        system,
        part(memory, LAST_NUMBERS)[GUIDED],
        linear_of(memory, modes),
        gathered(real, memory, FORCE_SEED, False),
        gathered(real, memory, DRAG_SEED, False),
        rings_at(real, memory, OF_SEEDS),
        on_piston,
    )


@compiled
def change_with_pin(real, memory, system):
    """Answer of a floating pin to the seeds, that of its films into the variables."""
    end = end_of(memory, system)
    n = len(part(memory, ORDER))
    found = respond_pin(
        pin_system_of(memory, system),
        PinStepEnd(
            coefficients_from(part(memory, LAST_COEFFICIENTS)),
            part(memory, LAST_NUMBERS)[GUIDED],
            end.now,
            end.crank,
            Factors(part(memory, FACTORS).reshape((n, n)), part(memory, ORDER)),
        ),
        NodalForces(
            gathered(real, memory, FORCE_SEED, False), gathered(real, memory, DRAG_SEED, False)
        ),
        rings_at(real, memory, OF_SEEDS),
        PinForces(
            gathered(real, memory, FORCE_SEED, True), gathered(real, memory, DRAG_SEED, True)
        ),
    )
    scatter(real, memory, THICKNESS_PRODUCT, found.film_thickness, True)
    scatter(real, memory, SLIDING_PRODUCT, found.circumferential_velocity, True)
    return found.change


# ---- entries


@compiled
def start(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """State and outputs at the start; `numbers` unused."""
    part(memory, FAULTS_AT)[0] = 0.0
    prepare(real, integer, memory)
    check(memory)
    if refused(memory):
        return
    last = part(memory, LAST_NUMBERS)
    last[EVALUATIONS] = 0.0
    last[TANGENTS] = 0.0
    p = settings_of(memory)
    x = part(memory, CONSTANTS)
    position = part(memory, START_POSITION).copy()
    crank_angle = x[START_ANGLE]
    if x[START_GIVEN] == 0.0:
        position[LATERAL] = p.start_lateral_displacement
        position[ROCKING] = p.start_rocking_angle
        crank_angle = p.start_crank_angle
    at_rest = np.zeros(len(position))
    before = Motion(position, part(memory, START_VELOCITY), at_rest)
    speed = number_at(real, memory, OF_INPUTS + CRANK_SPEED_GIVEN)
    crank = CrankMotion(crank_angle, speed, 0.0)
    now = coefficients(0.0, p.spectral_radius)
    solve(real, integer, memory, now, before, at_rest, End(crank, 0.0, True))


@compiled
def advance(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """One step; numbers: its length [s]."""
    part(memory, FAULTS_AT)[0] = 0.0
    step = numbers[0]
    state = part(memory, NUMBERS)
    before = Motion(
        part(memory, POSITION).copy(),
        part(memory, VELOCITY).copy(),
        part(memory, ACCELERATION).copy(),
    )
    auxiliary = part(memory, AUXILIARY).copy()
    begun = CrankMotion(state[CRANK_ANGLE], state[CRANK_SPEED], state[CRANK_ACCELERATION])
    crank = driven(begun, step, number_at(real, memory, OF_INPUTS + CRANK_SPEED_GIVEN))
    time = state[TIME] + step
    if state[STEPS] < FIRST_STEPS:
        c = first_steps(step)
    else:
        c = coefficients(step, settings_of(memory).spectral_radius)
    solve(real, integer, memory, c, before, auxiliary, End(crank, time, False))


@compiled
def tangent(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Products of the seeds among the variables (Eq. (D7)); `numbers` unused."""
    part(memory, FAULTS_AT)[0] = 0.0
    system = system_of(memory)
    if pin_films(memory) > 0:
        change = change_with_pin(real, memory, system)
    else:
        if part(memory, LAST_NUMBERS)[IS_LINEAR] == 0.0:
            make_linear(memory, system)
        change = change_of_tied(real, memory, system)
    scatter(real, memory, THICKNESS_PRODUCT, change.film_thickness, False)
    scatter(real, memory, SLIDING_PRODUCT, change.sliding_velocity, False)
    real[place(memory, OF_PRODUCTS)] = change.lateral_velocity
    real[place(memory, OF_PRODUCTS + 1)] = change.rocking_velocity
    real[place(memory, OF_PRODUCTS + 2)] = change.piston_velocity
    if is_mounted(memory):
        carried = carried_at(real, memory, OF_SEEDS + CARRIED_SEEDS)
        c = coefficients_from(part(memory, LAST_COEFFICIENTS))
        force = force_change(end_of(memory, system), c, change, carried)
        real[place(memory, OF_PRODUCTS + BLOCK_PRODUCTS)] = force.x
        real[place(memory, OF_PRODUCTS + BLOCK_PRODUCTS + 1)] = force.y
        real[place(memory, OF_PRODUCTS + BLOCK_PRODUCTS + 2)] = force.moment


PART = NativePart(
    entries=tuple(Entry(kernel) for kernel in (size, start, advance, tangent)),
    given=given,
    uncovered=uncovered,
    covered=COVERED,
    faults=FAULTS,
    refusal="",
    uncovered_ahead=uncovered,
)
