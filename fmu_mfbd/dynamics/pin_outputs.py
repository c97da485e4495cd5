"""Scalar outputs of a floating pin, and of the films in the small end and of the crank."""

from typing import Any

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.surfaces import pins_of
from ..mechanism.chain import BLOCK, NONE, REACTION, Loads
from ..mechanism.cylinder import BODY, EYE, PIN, film_of, floats
from ..mechanism.floating_frame import X, Y
from ..mechanism.generalised_alpha import Motion
from ..mechanism.laws import between
from .pin_shells import shapes_of
from .system import BodySystem


def _both(name, unit, description, nominal):
    """Return an output along x and one along y: name, unit, description, nominal value."""
    return [(f"{name}_{axis}", unit, f"{description} along {axis}", nominal) for axis in "xy"]


def _of_film(name, play, load, directions):
    """Return the outputs of a film, `OF_FILM` rows."""
    title = name.replace("_", " ")
    widening = f"Change of the diameter of the {title} at mid-length"
    return [
        *_both(f"{name}_displacement", "m", f"Displacement of {play}", 1e-5),
        *_both(f"{name}_force", "N", f"Force of {load}", 1e3),
        (f"{name}_friction_moment", "N.m", f"Friction moment of {load} about +z", 0.1),
        *[
            (f"{name}_widening_{direction}", "m", f"{widening}, {text}", 1e-5)
            for direction, text in directions.items()
        ],
    ]


BENDING = "Displacement of the floating pin at mid-length from the mean of both ends"
BY_ROD = {"across": "across the rod", "along": "along the rod"}
BY_BLOCK = {"x": "along x", "y": "along y"}
PLAY_OF_BOSSES = "Displacement of the pin axis from the axis of the bosses"
PLAY_OF_EYE = "the pin axis from the axis of the small end"
PLAY_OF_BIG_END = "the crank pin from the middle of the rod's big end"
PLAY_OF_JOURNAL = "the main journal from the middle of the main bearing"
PIN_OUTPUTS: tuple[tuple[Any, ...], ...] = (
    *_both("pin_displacement", "m", PLAY_OF_BOSSES, 1e-5),
    ("pin_angle", "rad", "Rotation angle of the pin about +z", 1.0),
    ("pin_rotation_speed", "rad/s", "Angular velocity of the pin about +z", 10.0),
    ("pin_tilt_x", "rad", "Tilt of the floating pin in its bosses, dx/dz", 1e-4),
    ("pin_tilt_y", "rad", "Tilt of the floating pin in its bosses, dy/dz", 1e-4),
    *_both("pin_bending", "m", BENDING, 1e-5),
    *_of_film("small_end", PLAY_OF_EYE, "the pin on the rod", BY_ROD),
    *_of_film("big_end", PLAY_OF_BIG_END, "the crank pin on the rod", BY_ROD),
    *_of_film("main_bearing", PLAY_OF_JOURNAL, "the main journal on the block", BY_BLOCK),
)
"""Scalar outputs of pin, small end and crank: name, unit, description, nominal value."""

PIN_NAMES = tuple(name for name, *_ in PIN_OUTPUTS)
COUNT, OF_FILM = len(PIN_NAMES), 7
"""Numbers of all outputs, and of those of each film."""
BOSS, SPIN, TILT, SAG, FILMS = map(
    PIN_NAMES.index,
    ("pin_displacement_x", "pin_angle", "pin_tilt_x", "pin_bending_x", "small_end_displacement_x"),
)
"""First outputs of the pin's position, angle, tilt and bending, and of the films."""


@compilable
def pin_scalars(
    of: BodySystem, now: Motion, loads: Loads, widening: np.ndarray, on_slopes: float
) -> np.ndarray:
    """Return the values of `PIN_OUTPUTS` at an instant, 0 if their part is absent.

    `widening` is that of `pin_films.PinFilmState`, `on_slopes` the axial force of pressure on the
    slopes of the bore, which all joints pass on to the block (Eq. (D70)) [N].
    """
    out, position, elements = np.zeros(COUNT), now.position, of.chain.elements
    if pins_of(of.pin_surfaces) == 0:
        return out
    in_eye, by_laws = NONE, np.zeros(2)
    if floats(of.chain):
        in_eye = EYE
        out[BOSS], out[BOSS + 1] = position[PIN.boss_x], position[PIN.boss_y]
        out[SPIN], out[SPIN + 1] = position[PIN.spin], now.velocity[PIN.spin]
        bent = shapes_of(elements, position, EYE)
        for k in range(len(of.shapes.slope)):
            for direction in range(2):
                out[TILT + direction] += of.shapes.slope[k] * bent[k, direction]
                out[SAG + direction] += of.shapes.sag[k] * bent[k, direction]
        if len(of.chain.laws.kind) > 0:
            by_laws = between(of.chain, loads, BODY.rod, BODY.pin)
    first = FILMS
    for e, x, y in (
        (in_eye, by_laws[X], on_slopes + by_laws[Y]),
        (film_of(of.chain, BODY.rod), 0.0, -on_slopes),
        (film_of(of.chain, BLOCK), 0.0, on_slopes),
    ):
        if e >= 0:
            wrench, play = loads.wrench[e], elements.play[e]
            out[first], out[first + 1] = position[play], position[play + 1]
            out[first + 2], out[first + 3] = x - wrench[X], y - wrench[Y]  # Eq. (D70)
            out[first + 4] = wrench[REACTION]
            out[first + 5], out[first + 6] = widening[e, 0], widening[e, 1]
        first += OF_FILM
    return out
