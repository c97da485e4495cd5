"""Rigid crank and rod: the position of pin point A, masses and forces.

The crank rotates about +z. From firing top dead centre the crank pin moves towards -x, so that gas
pressure presses the piston on the thrust side, +x. The origin is on the crank axis, and y points to
the head.
"""

from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from .pin_friction import PinFriction


class Mechanism(NamedTuple):
    """Lengths and masses of crank and rod [SI].

    Parameters
    ----------
    crank_radius, rod_length : float
        [m], rod_length > crank_radius + |offsets|.
    offset : float
        x of the concentric pin point A from the crank axis: pin offset minus crank offset [m].
    rod_mass : float
        [kg]
    rod_inertia : float
        About the rod's centre of mass [kg m2].
    rod_centre : float
        Distance of the rod's centre of mass from the big end, as a fraction of the rod length [-].
    pin_mass : float
        Mass that moves with A and does not turn with the piston [kg].
    friction : PinFriction
        Between piston and rod.
    """

    crank_radius: float
    rod_length: float
    offset: float
    rod_mass: float
    rod_inertia: float
    rod_centre: float
    pin_mass: float
    friction: PinFriction = PinFriction(0.0, 1.0, 0.0)


class CrankMotion(NamedTuple):
    """Motion of the crank at an instant.

    Parameters
    ----------
    angle : float
        phi [rad], 0 with the crank pin at the top.
    speed, acceleration : float
        w = phi' [rad/s], w' [rad/s2].
    """

    angle: float
    speed: float
    acceleration: float


@compilable
def driven(before: CrankMotion, step: float, speed: float) -> CrankMotion:
    """Return the motion of a crank a step [s] later at `speed` [rad/s], steadily accelerated."""
    return CrankMotion(
        before.angle + step * (before.speed + speed) / 2,
        speed,
        (speed - before.speed) / step,
    )


class Height(NamedTuple):
    """Height of A and its slopes.

    Parameters
    ----------
    height : float
        Y above the crank axis [m].
    slope : float
        dY/dx_A [-].
    lever : float
        dY/dphi [m/rad].
    """

    height: float
    slope: float
    lever: float


@compiled
def height(mechanism: Mechanism, lateral: float, crank_angle: float) -> Height:
    """Return the height of A above the crank axis and its slopes.

    Eq. (K1):  Y = r cos phi + f(xi),  f = sqrt(L^2 - xi^2),  xi = offset + x_A + r sin phi

    Parameters
    ----------
    mechanism : Mechanism
    lateral : float
        x_A [m].
    crank_angle : float
        phi [rad], 0 with the crank pin at the top.

    Returns
    -------
    Height

    >>> rigid = Mechanism(crank_radius=0.04, rod_length=0.14, offset=0.0, rod_mass=0.5,
    ...     rod_inertia=1e-3, rod_centre=0.3, pin_mass=0.1)
    >>> print(f"{height(rigid, 0.0, 0.0).height:.2f} m, {height(rigid, 0.0, np.pi).height:.2f} m")
    0.18 m, 0.10 m
    """
    r = mechanism.crank_radius
    xi = mechanism.offset + lateral + r * np.sin(crank_angle)
    f = np.sqrt(mechanism.rod_length**2 - xi**2)
    Y = r * np.cos(crank_angle) + f  # Eq. (K1)
    slope = -xi / f
    lever = -r * np.sin(crank_angle) + slope * r * np.cos(crank_angle)
    return Height(Y, slope, lever)


@compiled
def moved_inertia(mechanism: Mechanism, mass: float, crank_angle: float) -> float:
    """Return the moment of inertia that pin, piston and rod add to the crank [kg m2].

    Torque of the drive per angular acceleration, for a rigid piston in the middle of the bore.

    Eq. (K28):  J = m Y_phi^2 + m_r |G_phi|^2 + J_r psi_phi^2,   G = (1 - k) P + k A
                Y of Eq. (K1), psi of Eq. (K3), G the rod's centre of mass, P the crank pin

    Parameters
    ----------
    mechanism : Mechanism
    mass : float
        m of piston and pin [kg].
    crank_angle : float
        phi [rad].
    """
    r, k = mechanism.crank_radius, mechanism.rod_centre
    x, y = -r * np.cos(crank_angle), -r * np.sin(crank_angle)
    upright = height(mechanism, 0.0, crank_angle)
    turn = x / (upright.height + x)
    gx, gy = (1 - k) * x, (1 - k) * y + k * upright.lever
    moved = mass * upright.lever**2 + mechanism.rod_mass * (gx * gx + gy * gy)
    return moved + mechanism.rod_inertia * turn * turn  # Eq. (K28)


@compilable
def side_force_demand(mechanism: Mechanism, mass: float, others: Any, crank: CrankMotion) -> float:
    """Return the side force that gas, rings and inertia demand of a piston in mid-bore.

    The piston is rigid and has no friction. A film must carry this force on average.

    Eq. (K11):  F = F_x + f1 (F_y - p A - m Y'') - R    with x_A = x_A' = x_A'' = 0
                F_x, F_y of the rings, the rest of Eqs. (K2), (K4)
    Eq. (K2):  Y'' = -r cos(phi) w^2 - r sin(phi) w' + f1 xi'' + f2 xi'^2
               f1 = -xi/f,  f2 = -L^2/f^3        derivatives of f(xi), Eq. (K1)
    Eq. (K3):  psi = -asin(xi/L),  psi'' = -xi''/f - xi xi'^2/f^3        the rod's angle
    Eq. (K4):  R = k m_r e . G'' - J_r psi''/f,   e = (1, f1),   G of Eq. (K28)

    Parameters
    ----------
    mechanism : Mechanism
    mass : float
        m of piston and pin [kg].
    others : OtherForces
        Gas and rings.
    crank : CrankMotion

    Returns
    -------
    float
        On the bore, positive on the thrust side [N].
    """
    r, k, w = mechanism.crank_radius, mechanism.rod_centre, crank.speed
    sine, cosine = np.sin(crank.angle), np.cos(crank.angle)
    px = r * sine * w**2 - r * cosine * crank.acceleration
    py = -r * cosine * w**2 - r * sine * crank.acceleration
    xi, passing = mechanism.offset + r * sine, r * cosine * w
    f = np.sqrt(mechanism.rod_length**2 - xi**2)
    f1 = -xi / f
    rising = py - f1 * px - mechanism.rod_length**2 / f**3 * passing**2  # Eq. (K2)
    turning = px / f - xi / f**3 * passing**2  # Eq. (K3)
    swing = (1 - k) * px + f1 * (k * rising + (1 - k) * py)
    rod = k * mechanism.rod_mass * swing - mechanism.rod_inertia * turning / f  # Eq. (K4)
    axial = others.rings.axial - others.gas - mass * rising
    return others.rings.lateral + f1 * axial - rod  # Eq. (K11)
