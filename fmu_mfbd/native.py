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
from .dynamics.assembly import TURN, damping_at, machined_gap, measured, pin_height
from .dynamics.build_options import BuildOptions
from .dynamics.carrier import FIXED
from .dynamics.drive import demand_of, others_of, scalars_of
from .dynamics.first_steps import FIRST_STEPS, first_steps
from .dynamics.floating_frame import Arrow
from .dynamics.gas_on_bore import bore_wall
from .dynamics.generalised_alpha import Coefficients, Motion, coefficients
from .dynamics.instant import Linear, RingForce, end_of_step, linearise, response
from .dynamics.piston_motion import LATERAL, RIGID, ROCKING, Load
from .dynamics.slider_crank import CrankMotion, driven
from .dynamics.tables import gas_pressure
from .geometry.film import knot_rule
from .geometry.grid import cell_centres
from .geometry.modal_field import ModalField, modal_field
from .geometry.profile import fourier_bore, linear_growth
from .native_block import (
    ACCELERATION,
    ANGLE,
    AUXILIARY,
    AXIAL,
    BAND_ABOVE,
    BAND_RATIO,
    BANDS_GIVEN,
    BLOCK_DAMPING,
    BLOCK_OMEGA,
    BLOCK_STIFFNESS,
    BORE_RADIUS,
    CIRCUMFERENTIAL,
    CONSTANTS,
    COUPLING,
    CRANK_ACCELERATION,
    CRANK_ANGLE,
    CRANK_SPEED,
    CRANK_SPEED_GIVEN,
    CYLINDER_PRESSURE,
    DIAGONAL,
    DRAG,
    ENERGY_GAIN,
    ENERGY_SIZE,
    EVALUATIONS,
    FAULT,
    FAULT_A,
    FAULT_B,
    FAULT_C,
    FAULT_I,
    FAULTS_AT,
    FILM_THICKNESS,
    FORCE,
    GAP,
    GAS,
    GAS_ANGLE,
    GAS_CYCLE,
    GAS_PRESSURE,
    GUIDED,
    HEIGHT,
    HEIGHTS,
    INPUTS,
    INVERSE,
    IS_LINEAR,
    JACOBIAN_EVALUATIONS,
    KINETIC,
    LAND,
    LAST_ACCELERATION,
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
    OF_FIELD,
    OF_INPUTS,
    OF_LAST,
    OF_OUTPUTS,
    OF_PRODUCTS,
    OF_SEEDS,
    OF_STATE,
    OTHER_FORCES,
    OUTPUTS,
    PARTS,
    PARTS_FROM,
    PIN_OFFSET,
    PISTON_DAMPING,
    PISTON_OMEGA,
    PISTON_STIFFNESS,
    POSITION,
    RESIDUAL_EVALUATIONS,
    RINGS,
    SEEDED_RINGS,
    SETTING,
    SETTING_COUNT,
    SETTINGS,
    SHAPE,
    SIDE_FORCE_DEMAND,
    SKIRT_LOWER,
    SKIRT_UPPER,
    SLIDING_VELOCITY,
    START_ANGLE,
    START_GIVEN,
    START_POSITION,
    START_VELOCITY,
    STATE,
    STATIONS,
    STEPS,
    TANGENTS,
    TIME,
    TOP,
    VELOCITY,
    WALL_ABOVE,
    WALL_ABOVE_NOW,
    WALL_AT,
    WALL_AT_NOW,
    WIDENING,
    WORK_ERROR,
    coefficients_from,
    count,
    crank_from,
    linear_from,
    load_from,
    part,
    place,
    put_coefficients,
    put_crank,
    put_linear,
    put_load,
    settings_of,
    system_of,
)
from .reduction.reduced_body import ReducedBlock, ReducedPiston, load, mode_classes


class GasAtAngle(NamedTuple):
    """`GasTable`, as kernels know it."""

    angle: np.ndarray
    pressure: np.ndarray
    cycle: float


COVERED: dict[str, tuple[str, ...] | float] = {"crank_free": 0.0, "quasi_static_frequency": 1e9}
"""The only value of a number that is in the library; all else is free."""

FAULTS = (
    "rod_length = {a} m: must exceed crank_radius plus the offsets, {b} m",
    "rod_centre = {a} m: must lie within rod_length = {b} m",
    "second_ring_height = {a} m: must lie between the skirt's upper edge, {b} m above the pin, and "
    "top_ring_height = {c} m",
    "crank_radius, rod_length: the skirt travels from {a} to {b} m above the crank axis, the bore "
    "reaches from {c} to {i} m",
    "piston motion at crank angle {a} rad: Newton's method finds no accelerations; their last "
    "relative change is {b} (nan: diverged)",
    "crank angle = {a} rad: must be finite",
)
ROD_TOO_SHORT, CENTRE_BEYOND, RINGS_REVERSED, OUT_OF_BORE, NOT_SOLVED, NO_ANGLE = range(len(FAULTS))

OPTIONS = {
    "speed": "a table of crank speed",
    "floating_pin": "a floating pin",
    "film_surfaces": "several film surfaces",
    "surfaces": "several film surfaces",
    "mounted": "a mounted block",
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
            yield f"{name}: a native FMU has no {what.split(' ', 1)[1]}"


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
            f"piston mesh: skirt radius {piston.radius:g} m is not smaller than the bore radius "
            f"{block.radius:g} m"
        )
    contents = _contents(piston, block, options) | {"places": _places(slave)}
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
    contents = {
        "counts": [*options.grid, k, m, len(block.heights)],
        "constants": constants,
        "angle": angle,
        "height": height,
        "measured": profile,
        "heights": block.heights,
        "widening": widening,
        "inverse": knot_rule(len(block.heights)),
        "band_above": [band.above for band in bands] or np.zeros(2),
        "band_ratio": [band.ratio for band in bands] or np.zeros(2),
        "gas_angle": gas.angle if gas else [],
        "gas_pressure": gas.pressure if gas else [],
        "start_position": begin.position() if begin else np.zeros(RIGID + k + m),
        "start_velocity": begin.velocity() if begin else np.zeros(RIGID + k + m),
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
    of_skirt = (*options.grid, k)
    knots = knot_rule(len(block.heights))
    for name, values, body in (
        ("skirt_radial", piston.radial.reshape(of_skirt), piston),
        ("skirt_axial", piston.axial.reshape(of_skirt), piston),
        ("bore_radial", np.einsum("rs,csk->crk", knots, block.radial), block),
        ("bore_axial", np.einsum("rs,csk->crk", knots, block.axial), block),
    ):
        contents |= _of_field(name, modal_field(values, mode_classes(body)))
    return {name: np.asarray(value, dtype=float).ravel() for name, value in contents.items()}


def _of_field(name, field: ModalField):
    """Parts of a modal field, tables and whole numbers by their bits."""
    lines, length = field.table.shape
    table = np.zeros(field.table.size + field.table.size % 2, dtype=np.float32)
    table[: field.table.size] = field.table.ravel()
    parts = (
        [lines, length, field.modes, field.classes, field.part],
        table.view(float),
        np.ascontiguousarray(field.mode, dtype=np.int64).view(float),
        np.ascontiguousarray(field.kind, dtype=np.int64).view(float),
        np.ascontiguousarray(field.image, dtype=np.int64).ravel().view(float),
        field.share,
    )
    return {f"{name}_{part}": value for part, value in zip(OF_FIELD, parts)}


def _places(slave):
    """Where the numbers lie among a slave's variables."""
    names = (*SETTING, *INPUTS, *OUTPUTS)
    directions = [
        reserved(kind, name)
        for kind, all_of_them in (
            (SEED, slave.derivative_inputs),
            (PRODUCT, slave.derivative_outputs),
        )
        for name in all_of_them
    ]
    places = [slave.references.get(name, NOWHERE) for name in (*names, *directions)]
    places[SETTING.index("crank_free")] = NOWHERE  # no real number; 0 is all that is covered
    return np.array(places, dtype=float)


def _lengths(given, options):
    """Lengths of the parts that are made later, from those that are given."""
    c, a = options.grid
    k, m = given["piston_omega"], given["block_omega"]
    n = RIGID + k + m
    stations = given["heights"]
    of_motion = RIGID + k
    return {
        "settings": SETTING_COUNT,
        "gap": c * a,
        "shape": (stations + 2) * c,
        "wall_above_now": given["wall_above"],
        "wall_at_now": given["wall_at"],
        "piston_stiffness": k,
        "piston_damping": k,
        "block_stiffness": m,
        "block_damping": m,
        "none": 0,
        "numbers": len(OF_STATE),
        **dict.fromkeys(STATE[1:], n),
        "last_numbers": len(OF_LAST),
        "last_coefficients": len(Coefficients._fields),
        "last_load": len(Load._fields),
        "last_crank": len(CrankMotion._fields),
        "last_position": of_motion,
        "last_velocity": of_motion,
        "last_acceleration": of_motion,
        "modal_load": k,
        "linear_numbers": len(Linear._fields),
        "top": RIGID * of_motion,
        "left": RIGID * k,
        "diagonal": k,
        "coupling": k * k,
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
def refused(memory):
    """Whether a fault is noted."""
    return part(memory, FAULTS_AT)[0] > 0.0


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
    if p.rod_centre > p.rod_length:
        refuse(memory, CENTRE_BEYOND, p.rod_centre, p.rod_length, 0.0, 0.0)
    upper = x[SKIRT_UPPER]
    second = p.second_ring_height
    if p.top_ring_height > 0.0 and not upper <= second <= p.top_ring_height:
        refuse(memory, RINGS_REVERSED, second, upper, p.top_ring_height, 0.0)
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
def prepare(real, memory):
    """What follows from the parameters, as `assembly.assemble`."""
    settings = part(memory, SETTINGS)
    for k in range(SETTING_COUNT):
        at = place(memory, k)
        settings[k] = real[at] if at >= 0 else 0.0
    p = settings_of(memory)
    x = part(memory, CONSTANTS)
    c = count(memory, CIRCUMFERENTIAL)
    a = count(memory, AXIAL)
    s = count(memory, STATIONS)
    angle = part(memory, ANGLE)
    height = part(memory, HEIGHT)
    gap = part(memory, GAP)
    profile = part(memory, MEASURED)
    for i in range(c):
        for j in range(a):
            gap[i * a + j] = profile[i * a + j] + machined_gap(
                angle[i], height[j], x[SKIRT_LOWER], x[SKIRT_UPPER], p
            )
    heights = part(memory, HEIGHTS)
    inverse = part(memory, INVERSE)
    shape = part(memory, SHAPE)
    widening = part(memory, WIDENING)
    for k in range(s + 2):
        for i in range(c):
            total = 0.0
            for j in range(s):
                wider = widening[i * s + j] + linear_growth(
                    heights[j], heights[0], heights[-1], p.bore_growth_lower, p.bore_growth_upper
                )
                total += inverse[k * s + j] * wider
            shape[k * c + i] = total
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
    ):
        omega = part(memory, of_omega)
        damp(memory, p, omega, part(memory, damping))
        for k in range(len(omega)):
            part(memory, stiffness)[k] = omega[k] ** 2


# ---- a step


@compiled
def stacked(real, memory, which, cells):
    """A field of inputs or seeds that begins at a place."""
    at = place(memory, which)
    return real[at : at + cells]


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
def keep(to, what):
    """Copy, in a loop."""
    for k in range(len(to)):
        to[k] = what[k]


@compiled
def publish(real, integer, memory, now, scalars):
    """Outputs into the variables, and how much work there was so far."""
    for k in range(len(scalars)):
        real[place(memory, OF_OUTPUTS + k)] = scalars[k]
    cells = len(now.film_thickness)
    keep(stacked(real, memory, OF_OUTPUTS + FILM_THICKNESS, cells), now.film_thickness)
    keep(stacked(real, memory, OF_OUTPUTS + SLIDING_VELOCITY, cells), now.sliding_velocity)
    real[place(memory, OF_OUTPUTS + WORK_ERROR)] = now.work_error[0]
    modes = len(now.position) - RIGID
    if modes:
        keep(stacked(real, memory, OF_OUTPUTS + MODAL_COORDINATE, modes), now.position[RIGID:])
        keep(stacked(real, memory, OF_OUTPUTS + MODAL_VELOCITY, modes), now.kept_velocity[RIGID:])
    last = part(memory, LAST_NUMBERS)
    last[EVALUATIONS] += now.evaluations
    last[TANGENTS] += now.tangents
    integer[place(memory, OF_OUTPUTS + RESIDUAL_EVALUATIONS)] = int(last[EVALUATIONS])
    integer[place(memory, OF_OUTPUTS + JACOBIAN_EVALUATIONS)] = int(last[TANGENTS])


@compiled
def remember(memory, c, now, crank):
    """What a derivative at the end of this step starts from."""
    last = part(memory, LAST_NUMBERS)
    last[GUIDED] = now.guided
    last[IS_LINEAR] = 0.0
    put_coefficients(part(memory, LAST_COEFFICIENTS), c)
    put_load(part(memory, LAST_LOAD), now.load)
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
    cells = len(part(memory, GAP))
    pressure = number_at(real, memory, OF_INPUTS + GAS)
    if len(part(memory, GAS_ANGLE)):
        table = GasAtAngle(part(memory, GAS_ANGLE), part(memory, GAS_PRESSURE), x[GAS_CYCLE])
        pressure += gas_pressure(table, crank.angle)
    others = others_of(
        np.pi * x[BORE_RADIUS] ** 2,
        pressure,
        rings_at(real, memory, OF_INPUTS + RINGS),
        number_at(real, memory, OF_INPUTS + LAND),
        FIXED,
    )
    now = end_of_step(
        system,
        c,
        before,
        auxiliary,
        crank,
        others,
        stacked(real, memory, OF_INPUTS + FORCE, cells),
        stacked(real, memory, OF_INPUTS + DRAG, cells),
    )
    if now.evaluations == 0:
        refuse(memory, NOT_SOLVED, crank.angle, now.change, 0.0, 0.0)
        return
    scalars = scalars_of(now, crank, p.crank_inertia)
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
def make_linear(memory, system):
    """Derivatives of the last step that every direction shares, into the memory."""
    found = linearise(
        system,
        coefficients_from(part(memory, LAST_COEFFICIENTS)),
        load_from(part(memory, LAST_LOAD), part(memory, MODAL_LOAD), FIXED),
        Motion(
            part(memory, LAST_POSITION),
            part(memory, LAST_VELOCITY),
            part(memory, LAST_ACCELERATION),
        ),
        crank_from(part(memory, LAST_CRANK)),
    )
    put_linear(part(memory, LINEAR_NUMBERS), found)
    keep(part(memory, TOP), found.arrow.top.reshape(found.arrow.top.size))
    keep(part(memory, LEFT), found.arrow.left.reshape(found.arrow.left.size))
    keep(part(memory, DIAGONAL), found.arrow.diagonal)
    keep(part(memory, COUPLING), found.coupling.reshape(found.coupling.size))
    last = part(memory, LAST_NUMBERS)
    last[IS_LINEAR] = 1.0
    last[TANGENTS] += 1.0


# ---- entries


@compiled
def start(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """State and outputs at the start; `numbers` unused."""
    part(memory, FAULTS_AT)[0] = 0.0
    prepare(real, memory)
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
    modes = len(part(memory, PISTON_OMEGA))
    cells = len(part(memory, GAP))
    last = part(memory, LAST_NUMBERS)
    if last[IS_LINEAR] == 0.0:
        make_linear(memory, system)
    change = response(
        system,
        last[GUIDED],
        linear_of(memory, modes),
        stacked(real, memory, OF_SEEDS, cells),
        stacked(real, memory, OF_SEEDS + 1, cells),
        rings_at(real, memory, SEEDED_RINGS),
        np.zeros(RIGID + modes),
    )
    keep(stacked(real, memory, OF_PRODUCTS, cells), change.film_thickness)
    keep(stacked(real, memory, OF_PRODUCTS + 1, cells), change.sliding_velocity)
    real[place(memory, OF_PRODUCTS + 2)] = change.lateral_velocity
    real[place(memory, OF_PRODUCTS + 3)] = change.rocking_velocity
    real[place(memory, OF_PRODUCTS + 4)] = change.piston_velocity


PART = NativePart(
    entries=tuple(Entry(kernel) for kernel in (size, start, advance, tangent)),
    given=given,
    uncovered=uncovered,
    covered=COVERED,
    faults=FAULTS,
    refusal="",
    uncovered_ahead=uncovered,
)
