"""Faults of a start and of a step, and parameters that do not fit one another.

Python and machine code share them.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ...master.fmi.noted import DAMAGED_STATE, refuse
from .parameters import GAS_TWICE, NO_GAS_TABLE, Parameters, Settings

PIN_SHARE = 0.25
"""Radius of a pin that is not given, by that of the skirt: our own choice, as for `new`."""

PIN_TO_SHELL = 0.02
"""How far the radius of a pin may lie beside that of bosses and eye in their meshes, by it: our own
choice.
"""

TURN = 721
"""Crank angles of a turn at which the skirt has to be in the bore."""

OTHER_FRICTION = "{name}: expected 0 with a floating pin, got {{a}}; its films have the friction"
NO_ROD = "{name}: expected more than 0 {unit} with a film in {films}, got 0 {unit}"
FILMS = ("big_end", "main_bearing", "big_end and main_bearing")
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
    "pin_radius: expected within 2 % of the bosses in the mesh, {b} mm, got {a} mm",
    "pin_radius: expected within 2 % of the eye in its mesh, {b} mm, got {a} mm",
    "big_end_radius: expected within 2 % of the shell, {b} mm, got {a} mm",
    "main_bearing_radius: expected within 2 % of the shell, {b} mm, got {a} mm",
    "pin_mass: expected more than 0 kg with a floating pin, got 0 kg",
    NO_GAS_TABLE,
    GAS_TWICE,
    OTHER_FRICTION.format(name="pin_friction_coefficient"),
    OTHER_FRICTION.format(name="pin_friction_speed"),
    OTHER_FRICTION.format(name="pin_friction_damping"),
    "crank_free: expected 0 with a floating pin, got 1",
    "crank_free: expected 0 with a table build.speed, got 1",
    "quasi_static_frequency: expected more than all modes with a floating pin, {b} Hz, got {a} Hz",
    *(NO_ROD.format(name="rod_mass", unit="kg", films=films) for films in FILMS),
    *(NO_ROD.format(name="rod_inertia", unit="kg.m2", films=films) for films in FILMS),
    DAMAGED_STATE,
)
"""Sentences by number."""
(
    ROD_TOO_SHORT,
    CENTRE_BEYOND,
    RINGS_REVERSED,
    OUT_OF_BORE,
    NOT_SOLVED,
    NO_ANGLE,
    NOT_OF_BOSSES,
    NOT_OF_EYE,
    NOT_OF_BIG_END,
    NOT_OF_MAIN_BEARING,
    WITHOUT_PIN_MASS,
    WITHOUT_TABLE,
    GIVEN_TWICE,
    FRICTION_OF_PIN,
    FRICTION_SPEED,
    FRICTION_DAMPING,
    FREE_ON_FILMS,
    FREE_WITH_TABLE,
    STATIC_ON_FILMS,
    NO_ROD_MASS,
    _,
    _,
    NO_ROD_INERTIA,
    _,
    _,
    OTHER_STATE,
) = map(float, range(len(FAULTS)))  # numba compiles a kernel anew for every literal integer

USUAL = Parameters()
USUAL_FRICTION = float(USUAL.pin_friction_coefficient)
USUAL_SPEED = float(USUAL.pin_friction_speed)
USUAL_DAMPING = float(USUAL.pin_friction_damping)


class Fit(NamedTuple):
    """Data that parameters have to fit; the radii of rigid bodies are 0 [m].

    fastest : highest frequency of the piston's modes [Hz]; has_speed : a table of crank speed.
    """

    piston_radius: float
    skirt_lower: float
    skirt_upper: float
    pin_offset: float
    bore_lower: float
    bore_upper: float
    boss_radius: float
    eye_radius: float
    big_end_shell: float
    main_bearing_shell: float
    fastest: float
    has_speed: bool
    floats: bool
    has_big_end: bool
    has_main_bearing: bool


@compilable
def check(fit: Fit, p: Settings, lacks_gas: bool, faults: np.ndarray) -> None:
    """Note parameters that do not fit each other: rod too short, skirt leaving the bore."""
    offset = fit.pin_offset - p.crank_offset
    reach = p.crank_radius + abs(offset)
    if p.rod_length**2 - reach**2 <= 0.0:
        refuse(faults, ROD_TOO_SHORT, 0.0, 0.0, p.rod_length, reach, 0.0)
        return
    if lacks_gas:
        refuse(faults, WITHOUT_TABLE, 0.0, 0.0, 0.0, 0.0, 0.0)
    if fit.has_speed and p.crank_free != 0.0:
        refuse(faults, FREE_WITH_TABLE, 0.0, 0.0, 0.0, 0.0, 0.0)
    if p.rod_centre > p.rod_length:
        refuse(faults, CENTRE_BEYOND, 0.0, 0.0, p.rod_centre, p.rod_length, 0.0)
    upper = fit.skirt_upper
    second = p.second_ring_height
    top = p.top_ring_height
    if top > 0.0 and not upper <= second <= top:
        refuse(faults, RINGS_REVERSED, 0.0, 0.0, second, upper, top)
    if fit.floats:
        check_pin(fit, p, faults)
    lowest = np.inf
    highest = -np.inf
    for k in range(TURN):
        turn = 2 * np.pi * k / (TURN - 1)
        height = pin_height(turn, offset, p.crank_radius, p.rod_length)
        lowest = min(lowest, height)
        highest = max(highest, height)
    lowest += fit.skirt_lower
    highest += upper
    if lowest < fit.bore_lower or highest > fit.bore_upper:
        refuse(faults, OUT_OF_BORE, fit.bore_upper, 0.0, lowest, highest, fit.bore_lower)


@compilable
def check_pin(fit: Fit, p: Settings, faults: np.ndarray) -> None:
    """Note what does not go with a floating pin and films of the crank."""
    radius = pin_radius(fit.piston_radius, p)
    if fit.boss_radius > 0.0 and lies_beside(radius, fit.boss_radius):
        refuse(faults, NOT_OF_BOSSES, 0.0, 0.0, 1e3 * radius, 1e3 * fit.boss_radius, 0.0)
    if p.pin_mass == 0.0:
        refuse(faults, WITHOUT_PIN_MASS, 0.0, 0.0, 0.0, 0.0, 0.0)
    if p.pin_friction_coefficient != 0.0 and p.pin_friction_coefficient != USUAL_FRICTION:
        refuse(faults, FRICTION_OF_PIN, 0.0, 0.0, p.pin_friction_coefficient, 0.0, 0.0)
    if p.pin_friction_speed != 0.0 and p.pin_friction_speed != USUAL_SPEED:
        refuse(faults, FRICTION_SPEED, 0.0, 0.0, p.pin_friction_speed, 0.0, 0.0)
    if p.pin_friction_damping != 0.0 and p.pin_friction_damping != USUAL_DAMPING:
        refuse(faults, FRICTION_DAMPING, 0.0, 0.0, p.pin_friction_damping, 0.0, 0.0)
    if p.crank_free != 0.0:
        refuse(faults, FREE_ON_FILMS, 0.0, 0.0, 0.0, 0.0, 0.0)
    if fit.fastest > p.quasi_static_frequency:
        refuse(faults, STATIC_ON_FILMS, 0.0, 0.0, p.quasi_static_frequency, fit.fastest, 0.0)
    if fit.eye_radius > 0.0 and lies_beside(radius, fit.eye_radius):
        refuse(faults, NOT_OF_EYE, 0.0, 0.0, 1e3 * radius, 1e3 * fit.eye_radius, 0.0)
    shell = fit.big_end_shell
    if shell > 0.0 and lies_beside(p.big_end_radius, shell):
        refuse(faults, NOT_OF_BIG_END, 0.0, 0.0, 1e3 * p.big_end_radius, 1e3 * shell, 0.0)
    shell = fit.main_bearing_shell
    if shell > 0.0 and lies_beside(p.main_bearing_radius, shell):
        radius = 1e3 * p.main_bearing_radius
        refuse(faults, NOT_OF_MAIN_BEARING, 0.0, 0.0, radius, 1e3 * shell, 0.0)
    if fit.has_big_end or fit.has_main_bearing:
        films = (1.0 if fit.has_big_end else 0.0) + (2.0 if fit.has_main_bearing else 0.0) - 1.0
        if p.rod_mass == 0.0:
            refuse(faults, NO_ROD_MASS + films, 0.0, 0.0, 0.0, 0.0, 0.0)
        if p.rod_inertia == 0.0:
            refuse(faults, NO_ROD_INERTIA + films, 0.0, 0.0, 0.0, 0.0, 0.0)


@compilable
def lies_beside(radius: float, other: float) -> bool:
    """Return whether the radius of a pin is another than that of its shell in a mesh."""
    return abs(radius - other) > PIN_TO_SHELL * other


@compilable
def pin_height(turn, offset, crank_radius, rod_length):
    """Return the height of A above the crank axis [m] at a crank angle [rad], x_A = 0."""
    xi = offset + crank_radius * np.sin(turn)
    return crank_radius * np.cos(turn) + np.sqrt(rod_length**2 - xi**2)  # Eq. (K1)


@compilable
def pin_radius(skirt_radius: float, parameters: Parameters | Settings) -> float:
    """Return the radius of the pin [m]."""
    given = parameters.pin_radius
    return given if given > 0.0 else PIN_SHARE * skirt_radius
