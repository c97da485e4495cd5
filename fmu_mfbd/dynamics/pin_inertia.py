"""Elastic energy of a piston on a floating pin, and the motion that each coordinate gives."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from .pin_coordinates import NOWHERE, PIN, Layout, PinBodies, layout
from .piston_motion import LATERAL, ROCKING


@compilable
def elastic_energy(bodies: PinBodies, position: np.ndarray) -> float:
    """Return the energy of the modes of piston and shells and of the pin's shapes [J]."""
    first = layout(bodies)
    total = 0.0
    for k in range(len(bodies.piston.stiffness)):
        total += bodies.piston.stiffness[k] * position[first.modes + k] ** 2 / 2
    for k in range(len(bodies.shells.stiffness)):
        total += bodies.shells.stiffness[k] * position[first.eye + k] ** 2 / 2
    n = len(bodies.shapes.stiffness)
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
