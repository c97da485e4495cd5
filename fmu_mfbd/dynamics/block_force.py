"""Forces of a cylinder on the block that carries it: bore, deck and main bearings together.

Gas presses on crown and deck alike, film and rings on skirt and bore; the crank's drive stands
outside the block and turns the crank without a force. What is left is the inertia of the moving
parts.
"""

from typing import NamedTuple

from ...master.fmi.compiled import compiled
from .carrier import carried, place
from .floating_frame import FlexibleBody
from .generalised_alpha import Motion
from .piston_motion import LATERAL, Load, imbalance, lateral_motion
from .slider_crank import CrankMotion, Mechanism, motion


class BlockForce(NamedTuple):
    """Forces on the block in its axes.

    Parameters
    ----------
    x, y : float
        Of bore, deck and main bearings [N].
    moment : float
        Of bore and deck about the crank axis, about +z [N m].
    bearing_x, bearing_y : float
        Of the crank on its main bearings alone [N].
    """

    x: float
    y: float
    moment: float
    bearing_x: float
    bearing_y: float


@compiled
def block_force(
    body: FlexibleBody,
    mechanism: Mechanism,
    crank_unbalance: float,
    load: Load,
    now: Motion,
    crank: CrankMotion,
) -> BlockForce:
    """Forces on the block.

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
    # Eq. (D25)
    about_a = load.moment + load.guided * now.position[LATERAL]
    moment = about_a + at.x * load.axial - at.y * load.lateral
    return BlockForce(
        bearing_x - load.lateral, bearing_y - load.axial, -moment, bearing_x, bearing_y
    )


@compiled
def _unbalance(mechanism, load, at, px, py):
    """Acceleration of the end of e [1/s2]; the block's translation pushes the crank's mass, which
    counts among the block's.
    """
    r = mechanism.crank_radius
    carrier = load.carrier
    w = carrier.w
    x = -carrier.alpha * at.py - w * w * at.px - 2 * w * at.py_velocity
    y = carrier.alpha * at.px - w * w * at.py + 2 * w * at.px_velocity
    return (px + x) / r, (py + y) / r
