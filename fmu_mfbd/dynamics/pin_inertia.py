"""Inertia and elastic energy of a piston on a floating pin."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from .floating_frame import X, Y
from .pin_coordinates import NOWHERE, PIN, Layout, PinBodies, layout
from .piston_motion import LATERAL, ROCKING
from .slider_crank import carried_mass


@compilable
def elastic_energy(bodies: PinBodies, position: np.ndarray) -> float:
    """Return the energy of the modes of piston and shells and of the pin's shapes [J]."""
    first = layout(bodies)
    total = 0.0
    for k in range(len(bodies.piston.stiffness)):
        total += bodies.piston.stiffness[k] * position[first.modes + k] ** 2 / 2
    for k in range(len(bodies.shells.stiffness)):
        total += bodies.shells.stiffness[k] * position[first.eye + k] ** 2 / 2
    n = len(bodies.shapes.mass)
    for k in range(n):
        for way in range(2):
            s = position[first.shapes + way * n + k]
            total += bodies.shapes.stiffness[k] * s**2 / 2
    return total


class UnitMotion(NamedTuple):
    """Motion of all parts with a single coordinate.

    The parts are A, the pin's axis, the eye from its big end, the big end from its position without
    play, and the journal. It also has the rocking angle, and the numbers of the piston's mode and
    of the shells' mode, else `NOWHERE`.
    """

    x: float
    y: float
    pin_x: float
    pin_y: float
    eye: float
    shift_x: float
    shift_y: float
    journal_x: float
    journal_y: float
    rocking: float
    mode: int
    shell_mode: int


@compilable
def way_of(first: Layout, j: int) -> UnitMotion:
    """Return how coordinate j moves everything."""
    lateral = 1.0 if j == LATERAL else 0.0
    boss_x = 1.0 if j == PIN.boss_x else 0.0
    boss_y = 1.0 if j == PIN.boss_y else 0.0
    eye_x = 1.0 if j == PIN.eye_x else 0.0
    eye_y = 1.0 if j == PIN.eye_y else 0.0
    journal_x = 1.0 if j == first.main_bearing else 0.0
    journal_y = 1.0 if first.main_bearing >= 0 and j == first.main_bearing + 1 else 0.0
    shift_x = journal_x - (1.0 if j == first.big_end else 0.0)
    shift_y = journal_y - (1.0 if first.big_end >= 0 and j == first.big_end + 1 else 0.0)
    return UnitMotion(
        x=lateral,
        y=eye_y - boss_y + shift_y,
        pin_x=lateral + boss_x,
        pin_y=eye_y + shift_y,
        eye=lateral + boss_x - eye_x - shift_x,
        shift_x=shift_x,
        shift_y=shift_y,
        journal_x=journal_x,
        journal_y=journal_y,
        rocking=1.0 if j == ROCKING else 0.0,
        mode=j - first.modes if first.modes <= j < first.shapes else NOWHERE,
        shell_mode=j - first.eye if first.eye <= j < first.crank else NOWHERE,
    )


@compilable
def _coupled(piston, a, b):
    """Return rows of rotation and modes of Eq. (D22) for a pair of coordinates."""
    total = a.rocking * (piston.S[X] * b.y - piston.S[Y] * b.x)
    if b.mode >= 0:
        total += a.rocking * piston.g[b.mode]
        total += a.x * piston.T[X, b.mode] + a.y * piston.T[Y, b.mode]
    return total


@compiled
def inertia(bodies: PinBodies) -> np.ndarray:
    """Return M of the motion across the bore and of the pin in its shells.

    Eq. (D22):  T = q' . M q'/2      of piston and pin, the piston upright, the rod's eye along the
                                     bore as its big end, at rest without play in it; each shape
                                     and the shells' modes by their own mass

    Driven motion along the bore is none of it, as with a pin that is tied, nor is the rod.
    """
    piston = bodies.piston
    first = layout(bodies)
    out = np.empty((first.size, first.size))
    for i in range(first.size):
        a = way_of(first, i)
        for j in range(first.size):
            b = way_of(first, j)
            # Eq. (D22)
            both = _coupled(piston, a, b) + _coupled(piston, b, a)
            out[i, j] = piston.mass * (a.x * b.x + a.y * b.y) + both
            out[i, j] += bodies.mechanism.pin_mass * (a.pin_x * b.pin_x + a.pin_y * b.pin_y)
    out[ROCKING, ROCKING] += piston.I0
    out[PIN.spin, PIN.spin] += bodies.spin_inertia
    for k in range(first.modes, first.shapes):
        out[k, k] += 1.0
    n = len(bodies.shapes.mass)
    for k in range(n):
        for way in range(2):
            m = first.shapes + way * n + k
            out[m, m] += bodies.shapes.mass[k]
    for k in range(first.eye, first.eye + len(bodies.shells.stiffness)):
        out[k, k] += 1.0
    return out


@compiled
def inertia_with_rod(bodies: PinBodies) -> np.ndarray:
    """Compute M of `inertia` with the rod that swings with its eye (Eqs. (K12), (K16)).

    It includes the motion of rod and crank due to play at the crank.

    Eq. (D35):  T += m_r (delta'^2 + 2 k eye' delta_x')/2 + m_c m'^2/2      eye = x_S - delta_x
    """
    out = inertia(bodies)
    mechanism = bodies.mechanism
    first = layout(bodies)
    swung = carried_mass(mechanism)
    for i in range(first.size):
        a = way_of(first, i)
        for j in range(first.size):
            b = way_of(first, j)
            out[i, j] += swung * (a.eye * b.eye)
            # Eq. (D35)
            both = mechanism.rod_centre * (a.eye * b.shift_x + b.eye * a.shift_x)
            shifted = a.shift_x * b.shift_x + a.shift_y * b.shift_y
            out[i, j] += mechanism.rod_mass * (shifted + both)
            thrown = a.journal_x * b.journal_x + a.journal_y * b.journal_y
            out[i, j] += bodies.crank.mass * thrown
    return out
