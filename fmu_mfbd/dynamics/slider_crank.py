"""Rigid crank and rod: where they put pin point A, and what they weigh.

The crank turns positively about +z: from firing top dead centre the crank pin leaves towards -x, so
that gas pressure presses the piston on the +x (thrust) side. Origin on the crank axis, y towards
the head.
"""

from typing import NamedTuple

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


class LateralMotion(NamedTuple):
    """Motion of A across the bore at an instant.

    Parameters
    ----------
    position, velocity, acceleration : float
        x_A from its concentric place [m], [m/s], [m/s2].
    """

    position: float
    velocity: float
    acceleration: float


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


class RodTurn(NamedTuple):
    """Rotation of the rod; its angle psi about +z is 0 if it is upright.

    Parameters
    ----------
    velocity : float
        psi' [rad/s].
    slope : float
        dpsi/dx_A [1/m].
    lever : float
        dpsi/dphi [-].
    """

    velocity: float
    slope: float
    lever: float


class Link(NamedTuple):
    """Acceleration of A along y, and the rod's share of the equations of motion.

    Parameters
    ----------
    axial_acceleration : float
        Y'' [m/s2].
    axial_by_velocity : float
        Its slope against x_A' [1/s].
    slope : float
        dY/dx_A [-].
    rod_force : float
        Inertia force of the rod on x_A [N].
    rod_moment : float
        Inertia moment of the rod on phi [N m].
    rod : RodTurn
    """

    axial_acceleration: float
    axial_by_velocity: float
    slope: float
    rod_force: float
    rod_moment: float
    rod: RodTurn


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
    """
    r = mechanism.crank_radius
    xi = mechanism.offset + lateral + r * np.sin(crank_angle)
    f = np.sqrt(mechanism.rod_length**2 - xi**2)
    Y = r * np.cos(crank_angle) + f  # Eq. (K1)
    slope = -xi / f
    lever = -r * np.sin(crank_angle) + slope * r * np.cos(crank_angle)
    return Height(Y, slope, lever)


@compiled
def motion(mechanism: Mechanism, lateral: LateralMotion, crank: CrankMotion) -> Link:
    """Return the acceleration of A along y and the rod's share of the equations of motion.

    Eq. (K2):  Y'' = -r cos(phi) w^2 - r sin(phi) w' + f1 xi'' + f2 xi'^2
               f1 = -xi/f,  f2 = -L^2/f^3        derivatives of f(xi), Eq. (K1)
    Eq. (K3):  psi = -asin(xi/L),  psi'' = psi1 xi'' + psi2 xi'^2
               psi1 = -1/f,  psi2 = -xi/f^3         the rod's angle
    Eq. (K4):  on x_A:  k m_r e . G'' + J_r psi1 psi'',  e = (1, f1)
    Eq. (K5):  on phi:  m_r G_phi . G'' + J_r psi_phi psi''
               G = (1 - k) P + k A  the rod's centre of mass, P the crank pin, k = rod_centre
    Eq. (K6):  psi' = psi1 xi',  xi' = x_A' + r cos(phi) w        psi1 as in Eq. (K3)

    Parameters
    ----------
    mechanism : Mechanism
    lateral : LateralMotion
    crank : CrankMotion

    Returns
    -------
    Link
    """
    r = mechanism.crank_radius
    length = mechanism.rod_length
    k = mechanism.rod_centre
    mass = mechanism.rod_mass
    inertia = mechanism.rod_inertia
    sine = np.sin(crank.angle)
    cosine = np.cos(crank.angle)
    w = crank.speed

    # acceleration of the crank pin
    px = r * sine * w**2 - r * cosine * crank.acceleration
    py = -r * cosine * w**2 - r * sine * crank.acceleration

    # how far A stands beside the crank pin
    xi = mechanism.offset + lateral.position + r * sine
    xi_velocity = lateral.velocity + r * cosine * w
    xi_acceleration = lateral.acceleration - px

    # Eq. (K2)
    f = np.sqrt(length**2 - xi**2)
    f1 = -xi / f
    f2 = -(length**2) / f**3
    axial = py + f1 * xi_acceleration + f2 * xi_velocity**2

    # Eq. (K3)
    psi1 = -1 / f
    psi2 = -xi / f**3
    turn = psi1 * xi_acceleration + psi2 * xi_velocity**2

    # Eq. (K4)
    gx = k * lateral.acceleration + (1 - k) * px
    gy = k * axial + (1 - k) * py
    force = k * mass * (gx + f1 * gy) + inertia * psi1 * turn

    # Eq. (K5)
    gx_by_phi = -(1 - k) * r * cosine
    gy_by_phi = -(1 - k) * r * sine + k * (-r * sine + f1 * r * cosine)
    moment = mass * (gx_by_phi * gx + gy_by_phi * gy) + inertia * psi1 * r * cosine * turn

    return Link(
        axial_acceleration=axial,
        axial_by_velocity=2 * f2 * xi_velocity,
        slope=f1,
        rod_force=force,
        rod_moment=moment,
        rod=RodTurn(
            velocity=psi1 * xi_velocity,  # Eq. (K6)
            slope=psi1,
            lever=psi1 * r * cosine,
        ),
    )


@compiled
def carried_mass(mechanism: Mechanism) -> float:
    """Return the mass of the rod that moves with x_A, without piston and pin [kg].

    Eq. (K12):  m' = k^2 m_r + J_r / L^2        Eq. (K4) against x_A'', the rod upright

    At a slant it is larger by shares of f1^2, as those of piston and pin are.
    """
    swinging = mechanism.rod_centre**2 * mechanism.rod_mass
    return swinging + mechanism.rod_inertia / mechanism.rod_length**2  # Eq. (K12)


class PistonLoad(NamedTuple):
    """Load of the pin in addition to that of the film.

    Parameters
    ----------
    mass : float
        Of piston and pin [kg].
    gas : float
        Along -y on the crown [N].
    rings_lateral, rings_axial : float
        Of the rings, along x and y [N].
    """

    mass: float
    gas: float
    rings_lateral: float
    rings_axial: float


@compilable
def side_force_demand(mechanism: Mechanism, load: PistonLoad, crank: CrankMotion) -> float:
    """Return the side force that gas, rings and inertia demand of a piston in mid-bore.

    The piston is rigid and has no friction. A film must carry this force on average.

    Eq. (K11):  F = F_x + f1 (F_y - p A - m Y'') - R    with x_A = x_A' = x_A'' = 0
                Y'', f1 of Eq. (K2), R of Eq. (K4), F_x, F_y of the rings

    Parameters
    ----------
    mechanism : Mechanism
    load : PistonLoad
    crank : CrankMotion

    Returns
    -------
    float
        On the bore, positive on the thrust side [N].
    """
    link = motion(mechanism, LateralMotion(0.0, 0.0, 0.0), crank)
    axial = load.rings_axial - load.gas - load.mass * link.axial_acceleration
    return load.rings_lateral + link.slope * axial - link.rod_force  # Eq. (K11)
