"""Faults of a start and of a step, and parameters that do not fit one another.

Python and machine code share them.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ...master.fmi.noted import DAMAGED_STATE, numbers_of, refuse
from .parameters import GAS_TWICE, NO_GAS_TABLE, TORQUE_UNUSED, Parameters, Settings

PIN_SHARE = 0.25
"""Radius of a pin that is not given, by that of the skirt: our own choice, as for `new`."""

PIN_TO_SHELL = 0.02
"""Largest difference between the radius of a pin and those of bosses and eye in their meshes,
relative to it: our own choice.
"""

CRANK_ANGLES = 721
"""Number of crank angles of a revolution at which the skirt has to be in the bore."""

OTHER_FRICTION = "{name}: expected 0 with a floating pin, got {{a}}; its films have the friction"
ODD_FORCE = (
    "[{i},{j}]: expected {b} N as in the mirror image with film_symmetry = thrust_plane, got {a} "
    "N; set film_symmetry = none"
)
NO_ROD = "{name}: expected more than 0 {unit} with a film in {films}, got 0 {unit}"
SENTENCES = {
    "rod_too_short": "rod_length: expected more than crank_radius plus the offsets, {b} m, "
    "got {a} m",
    "centre_beyond": "rod_centre: expected at most rod_length = {b} m, got {a} m",
    "rings_reversed": "second_ring_height: expected {b} m, the skirt's upper edge, to "
    "top_ring_height = {c} m, got {a} m",
    "out_of_bore": "crank_radius, rod_length: expected a skirt within the bore, {c} to {i} m, "
    "got {a} to {b} m above the crank axis",
    "not_solved": "piston motion at crank angle {a} rad: Newton's method finds no accelerations; "
    "their last relative change is {b} (nan: diverged)",
    "no_angle": "crank angle = {a} rad: must be finite",
    "not_of_bosses": "pin_radius: expected within 2 % of the bosses in the mesh, {b} mm, "
    "got {a} mm",
    "not_of_eye": "pin_radius: expected within 2 % of the eye in its mesh, {b} mm, got {a} mm",
    "not_of_big_end": "big_end_radius: expected within 2 % of the shell, {b} mm, got {a} mm",
    "not_of_main_bearing": "main_bearing_radius: expected within 2 % of the shell, {b} mm, "
    "got {a} mm",
    "bore_of_pin": "pin_bore_radius: expected less than the radius of the pin, {b} mm, got {a} mm",
    "short_pin": "pin_length: expected 0 or at least the length of all films, {b} mm, got {a} mm",
    "no_pin_mass": "pin_mass: expected more than 0 kg with a floating pin, got 0 kg",
    "no_gas_table": NO_GAS_TABLE,
    "gas_twice": GAS_TWICE,
    "torque_unused": TORQUE_UNUSED,
    "friction_of_pin": OTHER_FRICTION.format(name="pin_friction_coefficient"),
    "friction_speed": OTHER_FRICTION.format(name="pin_friction_speed"),
    "friction_damping": OTHER_FRICTION.format(name="pin_friction_damping"),
    "free_with_table": "crank_free: expected 0 with a table build.speed, got 1",
    "tilted": "pin_tilt: expected 0 rad with modes of a symmetric film, got {a} rad; use modes "
    "with symmetric_film = false",
    "other_state": DAMAGED_STATE,
    "no_half": "film_symmetry: expected none for films or bodies that differ from their mirror "
    "image, and with pin_tilt = {a} rad, got thrust_plane",
    "odd_pressure_force": "nodal_pressure_force" + ODD_FORCE,
    "odd_friction_force": "nodal_friction_force" + ODD_FORCE,
} | {
    f"no_{name}_{k}": NO_ROD.format(name=name, unit=unit, films=films)
    for name, unit in (("rod_mass", "kg"), ("rod_inertia", "kg.m2"))
    for k, films in enumerate(("big_end", "main_bearing", "big_end and main_bearing"))
}
FAULTS = tuple(SENTENCES.values())
"""Sentences by number."""
FAULT = numbers_of(SENTENCES)

USUAL = Parameters()
USUAL_FRICTION = float(USUAL.pin_friction_coefficient)
USUAL_SPEED = float(USUAL.pin_friction_speed)
USUAL_DAMPING = float(USUAL.pin_friction_damping)


class Fit(NamedTuple):
    """Data that parameters have to fit; the radii of rigid bodies are 0 [m].

    has_speed : a table of crank speed;
    pin_span : least length of a pin with shapes [m], 0 without;
    symmetric_film : whether the modes assume a symmetric film.
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
    pin_span: float
    has_speed: bool
    floats: bool
    has_big_end: bool
    has_main_bearing: bool
    symmetric_film: bool


@compilable
def check(fit: Fit, p: Settings, lacks_gas: bool, faults: np.ndarray) -> None:
    """Note parameters that do not fit each other: rod too short, skirt leaving the bore."""
    offset = fit.pin_offset - p.crank_offset
    reach = p.crank_radius + abs(offset)
    if p.rod_length**2 - reach**2 <= 0.0:
        refuse(faults, FAULT.rod_too_short, 0.0, 0.0, p.rod_length, reach, 0.0)
        return
    if lacks_gas:
        refuse(faults, FAULT.no_gas_table, 0.0, 0.0, 0.0, 0.0, 0.0)
    if fit.has_speed and p.crank_free != 0.0:
        refuse(faults, FAULT.free_with_table, 0.0, 0.0, 0.0, 0.0, 0.0)
    if p.rod_centre > p.rod_length:
        refuse(faults, FAULT.centre_beyond, 0.0, 0.0, p.rod_centre, p.rod_length, 0.0)
    upper = fit.skirt_upper
    second = p.second_ring_height
    top = p.top_ring_height
    if top > 0.0 and not upper <= second <= top:
        refuse(faults, FAULT.rings_reversed, 0.0, 0.0, second, upper, top)
    if fit.symmetric_film and p.pin_tilt != 0.0:
        refuse(faults, FAULT.tilted, 0.0, 0.0, p.pin_tilt, 0.0, 0.0)
    if fit.floats:
        check_pin(fit, p, faults)
    if fit.has_big_end or fit.has_main_bearing:
        check_crank(fit, p, faults)
    lowest = np.inf
    highest = -np.inf
    for k in range(CRANK_ANGLES):
        turn = 2 * np.pi * k / (CRANK_ANGLES - 1)
        height = pin_height(turn, offset, p.crank_radius, p.rod_length)
        lowest = min(lowest, height)
        highest = max(highest, height)
    lowest += fit.skirt_lower
    highest += upper
    if lowest < fit.bore_lower or highest > fit.bore_upper:
        refuse(faults, FAULT.out_of_bore, fit.bore_upper, 0.0, lowest, highest, fit.bore_lower)


@compilable
def check_pin(fit: Fit, p: Settings, faults: np.ndarray) -> None:
    """Note what does not go with a floating pin."""
    radius = pin_radius(fit.piston_radius, p)
    refuse_beside(faults, FAULT.not_of_bosses, radius, fit.boss_radius)
    if p.pin_mass == 0.0:
        refuse(faults, FAULT.no_pin_mass, 0.0, 0.0, 0.0, 0.0, 0.0)
    for number, value, usual in (
        (FAULT.friction_of_pin, p.pin_friction_coefficient, USUAL_FRICTION),
        (FAULT.friction_speed, p.pin_friction_speed, USUAL_SPEED),
        (FAULT.friction_damping, p.pin_friction_damping, USUAL_DAMPING),
    ):
        if value != 0.0 and value != usual:
            refuse(faults, number, 0.0, 0.0, value, 0.0, 0.0)
    refuse_beside(faults, FAULT.not_of_eye, radius, fit.eye_radius)
    if fit.pin_span > 0.0 and p.pin_bore_radius >= radius:
        refuse(faults, FAULT.bore_of_pin, 0.0, 0.0, 1e3 * p.pin_bore_radius, 1e3 * radius, 0.0)
    if 0.0 < p.pin_length < (1 - 1e-9) * fit.pin_span:
        refuse(faults, FAULT.short_pin, 0.0, 0.0, 1e3 * p.pin_length, 1e3 * fit.pin_span, 0.0)


@compilable
def check_crank(fit: Fit, p: Settings, faults: np.ndarray) -> None:
    """Note what does not go with films of the crank."""
    refuse_beside(faults, FAULT.not_of_big_end, p.big_end_radius, fit.big_end_shell)
    refuse_beside(faults, FAULT.not_of_main_bearing, p.main_bearing_radius, fit.main_bearing_shell)
    films = (1.0 if fit.has_big_end else 0.0) + (2.0 if fit.has_main_bearing else 0.0) - 1.0
    if p.rod_mass == 0.0:
        refuse(faults, FAULT.no_rod_mass_0 + films, 0.0, 0.0, 0.0, 0.0, 0.0)
    if p.rod_inertia == 0.0:
        refuse(faults, FAULT.no_rod_inertia_0 + films, 0.0, 0.0, 0.0, 0.0, 0.0)


@compilable
def refuse_beside(faults: np.ndarray, number: float, radius: float, shell: float) -> None:
    """Note a radius that is another than that of its shell in a mesh; 0 without a mesh [m]."""
    if shell > 0.0 and abs(radius - shell) > PIN_TO_SHELL * shell:
        refuse(faults, number, 0.0, 0.0, 1e3 * radius, 1e3 * shell, 0.0)


@compilable
def pin_height(turn, offset, crank_radius, rod_length):
    """Return the height of A above the crank axis [m] at a crank angle [rad], x_A = 0."""
    xi = offset + crank_radius * np.sin(turn)
    return crank_radius * np.cos(turn) + np.sqrt(rod_length**2 - xi**2)  # Eq. (K1)


@compilable
def pin_radius(skirt_radius: float, parameters: Parameters | Settings) -> float:
    """Return the radius of the pin [m]."""
    radius = parameters.pin_radius
    return radius if radius > 0.0 else PIN_SHARE * skirt_radius
