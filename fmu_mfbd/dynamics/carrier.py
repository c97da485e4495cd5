"""A cylinder block that moves: what its motion adds to the inertia forces of the mechanism in it.

All coordinates of the mechanism are those in the block. The block moves in the plane of the
cylinder: its acceleration at the crank axis, its angular acceleration and velocity.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled, packed
from .slider_crank import CrankMotion, LateralMotion, Mechanism, height


class Carrier(NamedTuple):
    """Motion of the block in the plane of the cylinder, in the block's axes.

    Parameters
    ----------
    ax, ay : float
        Acceleration of the crank axis [m/s2].
    alpha, w : float
        Angular acceleration [rad/s2] and velocity [rad/s] about +z.
    """

    ax: float
    ay: float
    alpha: float
    w: float


_, carrier_from = packed(Carrier)

FIXED = Carrier(0.0, 0.0, 0.0, 0.0)
"""A block that does not move."""


class CarrierEffect(NamedTuple):
    """Terms that the block's motion adds.

    Parameters
    ----------
    x, y : float
        To the acceleration of pin point A [m/s2].
    rod_x, rod_y : float
        To that of the rod's centre of mass [m/s2].
    rod_force : float
        To the rod's inertia force on x_A [N].
    rod_moment : float
        To the rod's inertia moment on phi [N m].
    """

    x: float
    y: float
    rod_x: float
    rod_y: float
    rod_force: float
    rod_moment: float


@compiled
def transport(carrier: Carrier, x: float, y: float, vx: float, vy: float) -> tuple[float, float]:
    """Return the part of a point's acceleration that comes from the block's motion.

    The point is at (x, y) from the crank axis and moves in the block at (vx, vy).

    Eq. (K14):  a_O + alpha Z r - w^2 r + 2 w Z v        Z = [0, -1; 1, 0]
    """
    w = carrier.w
    # Eq. (K14)
    return (
        carrier.ax - carrier.alpha * y - w * w * x - 2 * w * vy,
        carrier.ay + carrier.alpha * x - w * w * y + 2 * w * vx,
    )


class MechanismMotion(NamedTuple):
    """Positions and velocities of crank pin P, pin point A and the rod's centre of mass G.

    Positions are from the crank axis [m]. Velocities are relative to the block [m/s].
    """

    px: float
    py: float
    x: float
    y: float
    gx: float
    gy: float
    px_velocity: float
    py_velocity: float
    x_velocity: float
    y_velocity: float
    gx_velocity: float
    gy_velocity: float


@compiled
def place(mechanism: Mechanism, lateral: LateralMotion, crank: CrankMotion) -> MechanismMotion:
    """Return positions and velocities of Eqs. (K1) and (K5)."""
    r = mechanism.crank_radius
    k = mechanism.rod_centre
    px = -r * np.sin(crank.angle)
    py = r * np.cos(crank.angle)
    px_velocity = -py * crank.speed
    py_velocity = px * crank.speed
    x = mechanism.offset + lateral.position
    y, slope, lever = height(mechanism, lateral.position, crank.angle)
    y_velocity = slope * lateral.velocity + lever * crank.speed
    return MechanismMotion(
        px,
        py,
        x,
        y,
        (1 - k) * px + k * x,
        (1 - k) * py + k * y,
        px_velocity,
        py_velocity,
        lateral.velocity,
        y_velocity,
        (1 - k) * px_velocity + k * lateral.velocity,
        (1 - k) * py_velocity + k * y_velocity,
    )


@compiled
def carried(
    mechanism: Mechanism, carrier: Carrier, lateral: LateralMotion, crank: CrankMotion
) -> CarrierEffect:
    """Compute what the block's motion adds to accelerations and to the rod's inertia forces.

    Eq. (K15):  on x_A:  k m_r e . g + J_r psi1 alpha,    on phi:  m_r G_phi . g + J_r psi_phi alpha
                g of Eq. (K14) at G, the rest as in Eq. (K3) to (K5)

    Parameters
    ----------
    mechanism : Mechanism
    carrier : Carrier
    lateral : LateralMotion
    crank : CrankMotion

    Returns
    -------
    CarrierEffect
    """
    k = mechanism.rod_centre
    mass = mechanism.rod_mass
    turning = mechanism.rod_inertia * carrier.alpha
    at = place(mechanism, lateral, crank)
    x, y = transport(carrier, at.x, at.y, at.x_velocity, at.y_velocity)
    gx, gy = transport(carrier, at.gx, at.gy, at.gx_velocity, at.gy_velocity)
    f = at.y - at.py
    f1 = -(at.x - at.px) / f
    psi1 = -1 / f
    gx_by_phi = -(1 - k) * at.py
    gy_by_phi = at.px + k * f1 * at.py
    return CarrierEffect(
        x,
        y,
        gx,
        gy,
        k * mass * (gx + f1 * gy) + psi1 * turning,  # Eq. (K15)
        mass * (gx_by_phi * gx + gy_by_phi * gy) + psi1 * at.py * turning,
    )
