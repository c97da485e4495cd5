"""Forces of a cylinder on the block that carries it: bore, deck and main bearings together.

Gas presses on crown and deck alike, film and rings on skirt and bore; the crank's drive stands
outside the block and turns the crank without a force. What is left is the inertia of the moving
parts.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from .carrier import carried, place
from .floating_frame import FlexibleBody
from .generalised_alpha import Motion
from .piston_motion import LATERAL, Load, imbalance, lateral_motion
from .response import Response, StepEnd, loaded
from .slider_crank import CrankMotion, Mechanism, motion
from .system import BodySystem


class BlockForce(NamedTuple):
    """Forces on the block in its axes, declared as `drive.Scalars`."""

    force_on_block_x: Annotated[
        float, "N", "Force of bore, deck and main bearings on the block along x", 1e3
    ]
    force_on_block_y: Annotated[
        float, "N", "Force of bore, deck and main bearings on the block along y", 1e3
    ]
    moment_on_block: Annotated[
        float,
        "N.m",
        "Moment of bore, deck and friction of the main bearing on the block about the crank axis",
        1e2,
    ]
    main_bearing_force_x: Annotated[
        float, "N", "Force of the crank on its main bearings along x", 1e3
    ]
    main_bearing_force_y: Annotated[
        float, "N", "Force of the crank on its main bearings along y", 1e3
    ]


@compiled
def block_force(
    body: FlexibleBody,
    mechanism: Mechanism,
    crank_unbalance: float,
    load: Load,
    now: Motion,
    crank: CrankMotion,
) -> BlockForce:
    """Compute the forces on the block.

    Eq. (D24):  main bearings:  F_b = -(pin + m_pin A'' + m_r G'' + U e'')
               e = P/r,  P the crank pin,  U the crank's unbalance
    Eq. (D25):  all:  F = F_b - F_l,   M = -(M_l + x_l x_A + x F_l,y - y F_l,x)
               F_l, M_l the load on the piston: film, gas and rings, (x, y) the place of A

    All accelerations are absolute (Eq. (K14)).

    Parameters
    ----------
    body, mechanism
        As for `imbalance`.
    crank_unbalance : float
        Mass times distance from the axis towards the crank pin [kg m].
    load, now, crank
        As for `imbalance`.

    Returns
    -------
    BlockForce
    """
    at = place(mechanism, lateral_motion(now), crank)
    link = motion(mechanism, lateral_motion(now), crank)
    added = carried(mechanism, load.carrier, lateral_motion(now), crank)
    pin = imbalance(body, mechanism, load, now, crank)
    k = mechanism.rod_centre
    w2 = crank.speed**2
    px = -at.px * w2 - at.py * crank.acceleration  # acceleration of the crank pin in the block
    py = -at.py * w2 + at.px * crank.acceleration
    lateral = now.acceleration[LATERAL]
    axial = link.axial_acceleration
    gx = (1 - k) * px + k * lateral + added.rod_x
    gy = (1 - k) * py + k * axial + added.rod_y
    # the crank's own unbalance moves as its pin does, and with the block
    ux, uy = _unbalance(mechanism, load, at, px, py)
    # Eq. (D24)
    bearing_x = -(pin.pin_x + mechanism.pin_mass * (lateral + added.x) + mechanism.rod_mass * gx)
    bearing_y = -(pin.pin_y + mechanism.pin_mass * (axial + added.y) + mechanism.rod_mass * gy)
    bearing_x -= crank_unbalance * ux
    bearing_y -= crank_unbalance * uy
    return all_on_block(load, now.position[LATERAL], at.x, at.y, bearing_x, bearing_y)


@compiled
def all_on_block(
    load: Load, lateral: float, x: float, y: float, bearing_x: float, bearing_y: float
) -> BlockForce:
    """Return the forces on the block from those on its main bearings.

    Parameters
    ----------
    load : Load
        On the piston.
    lateral, x, y : float
        x_A, and the place of A [m].
    bearing_x, bearing_y : float
        F_b of Eq. (D24) [N].
    """
    # Eq. (D25)
    about_a = load.moment + load.guided * lateral
    moment = about_a + x * load.axial - y * load.lateral
    return BlockForce(
        bearing_x - load.lateral, bearing_y - load.axial, -moment, bearing_x, bearing_y
    )


@compiled
def _unbalance(mechanism, load, at, px, py):
    """Return the acceleration of the end of e [1/s2].

    Translation of the block is omitted, because the crank's mass counts among the block's.
    """
    r = mechanism.crank_radius
    carrier = load.carrier
    w = carrier.w
    x = -carrier.alpha * at.py - w * w * at.px - 2 * w * at.py_velocity
    y = carrier.alpha * at.px - w * w * at.py + 2 * w * at.px_velocity
    return (px + x) / r, (py + y) / r


@compiled
def force_at(system: BodySystem, crank_unbalance: float, last: StepEnd) -> BlockForce:
    """Return the forces on the block at the end of a step."""
    return block_force(
        system.piston, system.mechanism, crank_unbalance, last.load, last.now, last.crank
    )


@compiled
def force_change(
    system: BodySystem, crank_unbalance: float, last: StepEnd, change: Response, carried: np.ndarray
) -> BlockForce:
    """Return the change of the forces on the block.

    Eq. (D20):  (F(s) - F(-s))/(2 s),   F of Eq. (D25) along the change of loads, accelerations
                and the block's motion, s such that accelerations change by 1 m/s2 at most:
                what is not linear is smaller by c2^2, some 1e-18

    Parameters
    ----------
    system : BodySystem
    crank_unbalance : float
        [kg m]
    last : StepEnd
    change : Response
    carried : ndarray, shape (4,)
        Change of the block's motion, as `Carrier` has it.
    """
    size = 1e-300
    for one in change.acceleration:
        size = max(size, abs(one))
    for one in carried:
        size = max(size, abs(one))
    ahead = _moved_along(last, change, 1.0 / size)
    behind = _moved_along(last, change, -1.0 / size)
    up = force_at(system, crank_unbalance, ahead)
    down = force_at(system, crank_unbalance, behind)
    # Eq. (D20)
    return BlockForce(
        (up.force_on_block_x - down.force_on_block_x) * size / 2,
        (up.force_on_block_y - down.force_on_block_y) * size / 2,
        (up.moment_on_block - down.moment_on_block) * size / 2,
        (up.main_bearing_force_x - down.main_bearing_force_x) * size / 2,
        (up.main_bearing_force_y - down.main_bearing_force_y) * size / 2,
    )


@compiled
def _moved_along(last, change, s):
    """Return the end of a step a share s along a change."""
    c = last.coefficients
    load = loaded(last.load, change.load, s)
    n = len(last.now.position)
    moved = Motion(np.empty(n), np.empty(n), np.empty(n))
    for k in range(n):
        a = s * change.acceleration[k]
        moved.position[k] = last.now.position[k] + c.to_position * a
        moved.velocity[k] = last.now.velocity[k] + c.to_velocity * a
        moved.acceleration[k] = last.now.acceleration[k] + a
    return StepEnd(c, last.guided, load, moved, last.crank, last.factors)
