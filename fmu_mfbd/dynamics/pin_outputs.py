"""Scalar outputs of a floating pin, the rod's eye and the films of the crank."""

from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.surfaces import pins_of
from ..mechanism.chain import BLOCK, NONE, Loads
from ..mechanism.cylinder import BODY, EYE, PIN, film_of, floats
from ..mechanism.floating_frame import X, Y
from ..mechanism.generalised_alpha import Motion
from ..mechanism.laws import between
from ..mechanism.loads import REACTION
from .pin_shells import play_at, shapes_of
from .system import BodySystem


def _both(name, unit, description, nominal):
    """Return an output along x and one along y: name, unit, description, nominal value."""
    return [(f"{name}_{axis}", unit, f"{description} along {axis}", nominal) for axis in "xy"]


def _displacement(name, what):
    return _both(f"{name}_displacement", "m", f"Displacement of {what}", 1e-5)


def _force(name, what):
    moment = f"{name}_friction_moment", "N.m", f"Friction moment of {what} about +z", 0.1
    return [*_both(f"{name}_force", "N", f"Force of {what}", 1e3), moment]


BENDING = "Displacement of the floating pin at mid-length from the mean of both ends"
WIDENING = "Change of the diameter of the {} at mid-length, {}"


def _widening(name, directions):
    what = name.replace("_", " ")
    return [
        (f"{name}_widening_{direction}", "m", WIDENING.format(what, text), 1e-5)
        for direction, text in directions.items()
    ]


BY_ROD = {"across": "across the rod", "along": "along the rod"}
PIN_OUTPUTS: tuple[tuple[Any, ...], ...] = (
    *_displacement("pin", "the pin axis from the axis of the bosses"),
    *_displacement("small_end", "the pin axis from the axis of the small end"),
    ("pin_angle", "rad", "Rotation angle of the pin about +z", 1.0),
    ("pin_rotation_speed", "rad/s", "Angular velocity of the pin about +z", 10.0),
    *_force("small_end", "the pin on the rod"),
    ("pin_tilt_x", "rad", "Tilt of the floating pin in its bosses, dx/dz", 1e-4),
    ("pin_tilt_y", "rad", "Tilt of the floating pin in its bosses, dy/dz", 1e-4),
    *_both("pin_bending", "m", BENDING, 1e-5),
    *_widening("small_end", BY_ROD),
    *_displacement("big_end", "the crank pin from the middle of the rod's big end"),
    *_force("big_end", "the crank pin on the rod"),
    *_widening("big_end", BY_ROD),
    *_displacement("main_bearing", "the main journal from the middle of the main bearing"),
    *_force("main_bearing", "the main journal on the block"),
    *_widening("main_bearing", {"x": "along x", "y": "along y"}),
)
"""Scalar outputs of pin, eye and crank: name, unit, description, nominal value."""

MEMBERS = [(name, float) for name, *_ in PIN_OUTPUTS]
PinScalars = NamedTuple("PinScalars", MEMBERS)
"""Their values, as `drive.Scalars`; 0 if their part is absent."""

NO_PIN = PinScalars(*[0.0] * len(PinScalars._fields))
"""Those of a tied pin on a crank without films."""


@compilable
def _wrench_of(loads, e):
    """Return the force and the moments of film e, zeros without this film."""
    return loads.wrench[e] if e >= 0 else np.zeros(loads.wrench.shape[1])


@compilable
def _widened(widening, e):
    """Return the changes of diameter of the shell of film e, zeros without this film."""
    return widening[e] if e >= 0 else np.zeros(2)


@compilable
def pin_scalars(
    of: BodySystem, now: Motion, loads: Loads, widening: np.ndarray, on_slopes: float
) -> PinScalars:
    """Return the scalar outputs at an instant.

    `widening` is that of `pin_films.PinFilmState`, `on_slopes` the axial force of pressure on the
    slopes of the bore, which all joints pass on to the block (Eq. (D70)) [N].
    """
    if pins_of(of.pin_surfaces) == 0:
        return NO_PIN
    position, elements = now.position, of.chain.elements
    tilt, sag = np.zeros(2), np.zeros(2)
    in_eye, spin, spinning = NONE, 0.0, 0.0
    boss, small_end = np.zeros(2), np.zeros(2)
    if floats(of.chain):
        in_eye, spin, spinning = EYE, position[PIN.spin], now.velocity[PIN.spin]
        boss, small_end = play_at(PIN.boss_x, position), play_at(PIN.eye_x, position)
    for k in range(len(of.shapes.slope)):
        bent = shapes_of(of.chain.elements, position, EYE)
        for direction in range(2):
            tilt[direction] += of.shapes.slope[k] * bent[k, direction]
            sag[direction] += of.shapes.sag[k] * bent[k, direction]
    in_big_end, in_main = film_of(of.chain, BODY.rod), film_of(of.chain, BLOCK)
    eye, big_end, main_bearing = (
        _wrench_of(loads, in_eye),
        _wrench_of(loads, in_big_end),
        _wrench_of(loads, in_main),
    )
    on_eye = on_slopes if in_eye >= 0 else 0.0  # Eq. (D70)
    on_big_end = on_slopes if in_big_end >= 0 else 0.0
    on_main = on_slopes if in_main >= 0 else 0.0
    by_laws = np.zeros(2)
    if floats(of.chain) and len(of.chain.laws.kind) > 0:
        by_laws = between(of.chain, loads, BODY.rod, BODY.pin)
    wider = _widened(widening, in_eye)
    wider_end = _widened(widening, in_big_end)
    wider_main = _widened(widening, in_main)
    crank_pin = play_at(elements.play[in_big_end] if in_big_end >= 0 else NONE, position)
    journal = play_at(elements.play[in_main] if in_main >= 0 else NONE, position)
    return PinScalars(
        pin_displacement_x=boss[0],
        pin_displacement_y=boss[1],
        small_end_displacement_x=small_end[0],
        small_end_displacement_y=small_end[1],
        pin_angle=spin,
        pin_rotation_speed=spinning,
        small_end_force_x=by_laws[X] - eye[X],
        small_end_force_y=on_eye + by_laws[Y] - eye[Y],
        small_end_friction_moment=eye[REACTION],
        pin_tilt_x=tilt[0],
        pin_tilt_y=tilt[1],
        pin_bending_x=sag[0],
        pin_bending_y=sag[1],
        small_end_widening_across=wider[0],
        small_end_widening_along=wider[1],
        big_end_displacement_x=crank_pin[0],
        big_end_displacement_y=crank_pin[1],
        big_end_force_x=-big_end[X],
        big_end_force_y=-big_end[Y] - on_big_end,
        big_end_friction_moment=big_end[REACTION],
        big_end_widening_across=wider_end[0],
        big_end_widening_along=wider_end[1],
        main_bearing_displacement_x=journal[0],
        main_bearing_displacement_y=journal[1],
        main_bearing_force_x=-main_bearing[X],
        main_bearing_force_y=on_main - main_bearing[Y],
        main_bearing_friction_moment=main_bearing[REACTION],
        main_bearing_widening_x=wider_main[0],
        main_bearing_widening_y=wider_main[1],
    )
