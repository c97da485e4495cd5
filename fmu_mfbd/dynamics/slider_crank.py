"""Rigid crank and rod: where they put pin point A, and what they weigh.

The crank turns positively about +z: from firing top dead centre the crank pin leaves towards -x, so
that gas pressure presses the piston on the +x (thrust) side. Origin on the crank axis, y towards
the head.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
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


@compiled
def height(mechanism, lateral, crank_angle):
    """Height of A above the crank axis and its slopes.

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
    Y, dY/dx_A, dY/dphi : float
        [m], [-], [m/rad]
    """
    r, length = mechanism.crank_radius, mechanism.rod_length
    xi = mechanism.offset + lateral + r * np.sin(crank_angle)
    f = np.sqrt(length**2 - xi**2)
    slope = -xi / f
    return (
        r * np.cos(crank_angle) + f,
        slope,
        -r * np.sin(crank_angle) + slope * r * np.cos(crank_angle),
    )  # Eq. (K1)


@compiled
def motion(
    mechanism,
    lateral,
    lateral_rate,
    lateral_acceleration,
    crank_angle,
    crank_speed,
    crank_acceleration,
):
    """Acceleration of A along y and the rod's share of the equations of motion.

    Eq. (K2):  Y'' = -r cos(phi) w^2 - r sin(phi) w' + f1 xi'' + f2 xi'^2          f1 = -xi/f,  f2 = -L^2/f^3,  f3 = -3 L^2 xi/f^5
    Eq. (K3):  rod angle psi = -asin(xi/L);  centre of mass G = (1-k) P + k A, P the crank pin, k = rod_centre
               rod force on x_A:  k m_r e . G'' + J_r psi1 psi'',  e = (1, f1);  on phi:  m_r G_phi . G'' + J_r psi_phi psi''

    Parameters
    ----------
    mechanism : Mechanism
    lateral, lateral_rate, lateral_acceleration : float
        x_A [m] and its derivatives in time.
    crank_angle, crank_speed, crank_acceleration : float
        [rad], [rad/s], [rad/s2]

    Returns
    -------
    ndarray, shape (11,)
        Y'' [m/s2] and its slopes against x_A'', x_A', x_A; dY/dx_A and its slope; rod force on x_A
        [N] and its slopes against x_A'', x_A', x_A; rod moment on phi [N m].
    """
    r, length, k = mechanism.crank_radius, mechanism.rod_length, mechanism.rod_centre
    mass, inertia = mechanism.rod_mass, mechanism.rod_inertia
    sine, cosine, w = np.sin(crank_angle), np.cos(crank_angle), crank_speed
    px = r * sine * w**2 - r * cosine * crank_acceleration  # acceleration of the crank pin
    py = -r * cosine * w**2 - r * sine * crank_acceleration
    xi = mechanism.offset + lateral + r * sine
    speed, rate = lateral_rate + r * cosine * w, lateral_acceleration - px
    f = np.sqrt(length**2 - xi**2)
    f1, f2, f3 = -xi / f, -(length**2) / f**3, -3 * length**2 * xi / f**5
    lift = py + f1 * rate + f2 * speed**2  # Eq. (K2)
    lift_acceleration, lift_rate, lift_place = f1, 2 * f2 * speed, f2 * rate + f3 * speed**2

    p1, p2, p3 = -1 / f, -xi / f**3, -1 / f**3 - 3 * xi**2 / f**5  # Eq. (K3)
    turn = p1 * rate + p2 * speed**2
    turn_rate, turn_place = 2 * p2 * speed, p2 * rate + p3 * speed**2
    gx = k * lateral_acceleration + (1 - k) * px
    gy = k * lift + (1 - k) * py
    force = k * mass * (gx + f1 * gy) + inertia * p1 * turn
    force_acceleration = k * mass * (k + f1 * k * lift_acceleration) + inertia * p1 * p1
    force_rate = k * mass * f1 * k * lift_rate + inertia * p1 * turn_rate
    force_place = k * mass * (f2 * gy + f1 * k * lift_place) + inertia * (
        p2 * turn + p1 * turn_place
    )
    moment = (
        mass
        * (
            -(1 - k) * r * cosine * gx
            + (-(1 - k) * r * sine + k * (-r * sine + f1 * r * cosine)) * gy
        )
        + inertia * p1 * r * cosine * turn
    )
    return np.array(
        [
            lift,
            lift_acceleration,
            lift_rate,
            lift_place,
            f1,
            f2,
            force,
            force_acceleration,
            force_rate,
            force_place,
            moment,
        ]
    )


@compiled
def rod_turn(mechanism, lateral, lateral_rate, crank_angle, crank_speed):
    """Angular velocity of the rod and its slopes (Eq. (K3)).

    Parameters
    ----------
    mechanism : Mechanism
    lateral, lateral_rate : float
        x_A [m] and its rate [m/s].
    crank_angle, crank_speed : float
        [rad], [rad/s]

    Returns
    -------
    psi', dpsi/dx_A, d2psi/dx_A2, dpsi'/dx_A, dpsi/dphi : float
        [rad/s], [1/m], [1/m2], [1/(m s)], [-]; psi about +z, 0 where the rod stands upright.
    """
    r = mechanism.crank_radius
    xi = mechanism.offset + lateral + r * np.sin(crank_angle)
    f = np.sqrt(mechanism.rod_length**2 - xi**2)
    p1, p2, lever = -1 / f, -xi / f**3, r * np.cos(crank_angle)
    speed = lateral_rate + lever * crank_speed
    return p1 * speed, p1, p2, p2 * speed, p1 * lever
