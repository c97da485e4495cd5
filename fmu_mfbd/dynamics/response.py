"""The derivative at the end of a step of a piston whose pin is tied."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.arrays import Matrix
from ..geometry.film import FilmForces, NodalForces
from .carrier import Carrier, carried
from .elimination import LUFactors
from .floating_frame import Arrow, in_frame, mode_coupling
from .generalised_alpha import Coefficients, Motion
from .pin_friction import friction_moment
from .piston_motion import (
    LATERAL,
    RIGID,
    ROCKING,
    Load,
    imbalance,
    lateral_motion,
    solve_coupled,
    tangent,
)
from .quasi_static import STILL, FrameAcceleration, follow, static_coordinates
from .skirt_films import Change, forces_by_film, skirt_changes, together
from .slider_crank import CrankMotion, motion
from .system import BodySystem, RingForce


class StepEnd(NamedTuple):
    """End of a step, for derivatives and for forces on the block.

    Parameters
    ----------
    coefficients : Coefficients
    guided : float
        Height at which the bore is read [m].
    load : Load
    now : Motion
        Of the piston's moving coordinates, with a floating pin of all.
    crank : CrankMotion
    factors : LUFactors
        Of the tangent of Eq. (D21) of a floating pin.
    """

    coefficients: Coefficients
    guided: float
    load: Load
    now: Motion
    crank: CrankMotion
    factors: LUFactors


class Linearisation(NamedTuple):
    """The piston's motion at the end of a step, linearised: what all directions share.

    Parameters
    ----------
    arrow : Arrow
    coupling : ndarray, shape (k, k)
        Together the tangent J (`floating_frame.mode_coupling`).
    slope : float
        dY/dx_A [-].
    axial_velocity_slope : float
        Change of A's velocity along y with x_A [1/s].
    rod_slope : float
        dpsi/dx_A [1/m].
    friction_x, friction_y : float
        Change of the pin's friction moment with the pin force [m].
    x_by_lateral, y_by_lateral : float
        Change of A's acceleration in the body frame with x_A'' [-].
    x_by_rocking, y_by_rocking, spin_by_rocking : float
        Change of the same [m] and of w^2 [-] with the angular acceleration.
    """

    arrow: Arrow
    coupling: Matrix
    slope: float
    axial_velocity_slope: float
    rod_slope: float
    friction_x: float
    friction_y: float
    x_by_lateral: float
    y_by_lateral: float
    x_by_rocking: float
    y_by_rocking: float
    spin_by_rocking: float


@compiled
def linearise(system: BodySystem, last: StepEnd) -> Linearisation:
    """Return the piston's motion linearised about the end of a step."""
    piston = system.piston
    mechanism = system.mechanism
    load, now, crank = last.load, last.now, last.crank
    c1 = last.coefficients.to_velocity
    c2 = last.coefficients.to_position
    lateral = lateral_motion(now)
    angle = now.position[ROCKING]
    slip = now.velocity[ROCKING]
    w = slip + load.carrier.w
    pin = imbalance(piston, mechanism, load, now, crank)
    link = motion(mechanism, lateral, crank)
    rod = link.rod
    friction = friction_moment(mechanism.friction, pin.pin_x, pin.pin_y, slip - rod.velocity)
    added = carried(mechanism, load.carrier, lateral, crank)
    across = lateral.acceleration + added.x
    ax, ay = in_frame(across, link.axial_acceleration + added.y, angle)
    alpha = now.acceleration[ROCKING] + load.carrier.alpha
    axial = link.axial_by_acceleration + c1 * link.axial_by_velocity + c2 * link.axial_by_position
    x, y = in_frame(1.0, axial, angle)
    return Linearisation(
        arrow=tangent(piston, mechanism, load, now, crank, c1, c2),
        coupling=mode_coupling(piston, alpha, w, c1, c2),
        slope=link.slope,
        axial_velocity_slope=link.axial_by_velocity / 2,
        rod_slope=rod.slope,
        friction_x=friction.by_x,
        friction_y=friction.by_y,
        x_by_lateral=x,
        y_by_lateral=y,
        x_by_rocking=c2 * ay,
        y_by_rocking=-c2 * ax,
        spin_by_rocking=2 * w * c1,
    )


class Response(NamedTuple):
    """Change of the films' geometry and of the piston's motion.

    Parameters
    ----------
    film_thickness, sliding_velocity : ndarray, shape (cells,)
        Of all surfaces, stacked [m], [m/s].
    lateral_velocity, rocking_velocity, piston_velocity : float
        [m/s], [rad/s], [m/s]
    acceleration : ndarray, shape (2 + k,)
        Of the piston's moving coordinates [m/s2], [rad/s2], [kg^1/2 m/s2].
    load : Load
        Of the films and rings on the piston, and of the motion of the block.
    """

    film_thickness: np.ndarray
    sliding_velocity: np.ndarray
    lateral_velocity: float
    rocking_velocity: float
    piston_velocity: float
    acceleration: np.ndarray
    load: Load


@compilable
def load_change(
    system: BodySystem, films: FilmForces, rings: RingForce, modal: np.ndarray, carrier: Carrier
) -> Load:
    """Return the change of the load on the piston with films, rings and the block's motion."""
    return Load(
        films.lateral + rings.lateral,
        films.axial + rings.axial,
        films.moment + rings.moment - rings.axial * system.pin_offset,  # Eq. (D8)
        -rings.axial,
        modal,
        carrier,
    )


@compiled
def loaded(load: Load, change: Load, s: float) -> Load:
    """Return a load plus `s` times a change of it."""
    own, more = load.carrier, change.carrier
    modal = np.empty(len(load.modal))
    for k in range(len(modal)):
        modal[k] = load.modal[k] + s * change.modal[k]
    carrier = Carrier(
        own.ax + s * more.ax, own.ay + s * more.ay, own.alpha + s * more.alpha, own.w + s * more.w
    )
    return Load(
        load.lateral + s * change.lateral,
        load.axial + s * change.axial,
        load.moment + s * change.moment,
        load.guided + s * change.guided,
        modal,
        carrier,
    )


@compiled
def _by_carrier(system, last, carrier):
    """Return dQ of Eq. (D7) with a change of the block's motion.

    Eq. (D19):  dQ = (R(-s) - R(s))/(2 s),    R of Eq. (D5) along the change, of second order in it,
                s such that the largest number changes by 1 (SI units)
    """
    size = 0.0
    for one in carrier:
        size = max(size, abs(one))
    if size == 0.0:
        return np.zeros(len(last.now.position))
    change = Load(0.0, 0.0, 0.0, 0.0, np.zeros(len(last.load.modal)), carrier)
    up = loaded(last.load, change, 1 / size)
    down = loaded(last.load, change, -1 / size)
    right = imbalance(system.piston, system.mechanism, down, last.now, last.crank).residual
    above = imbalance(system.piston, system.mechanism, up, last.now, last.crank).residual
    for k in range(len(right)):
        right[k] = (right[k] - above[k]) * (size / 2)  # Eq. (D19)
    return right


@compiled
def _right_side(system, last, linear, change):
    """Return dQ of Eq. (D7) on the piston's moving coordinates.

    The pin carries what film and rings do not.
    """
    right = _by_carrier(system, last, change.carrier)
    arm = last.now.position[LATERAL]
    rubbing = -linear.friction_x * change.lateral - linear.friction_y * change.axial
    right[LATERAL] += change.lateral + linear.slope * change.axial - linear.rod_slope * rubbing
    right[ROCKING] += change.moment + change.guided * arm + rubbing  # Eq. (D8)
    for k in range(len(change.modal)):
        right[RIGID + k] += change.modal[k]
    return right


@compiled
def response(
    system: BodySystem,
    last: StepEnd,
    linear: Linearisation,
    forces: NodalForces,
    rings: RingForce,
    carrier: Carrier,
) -> Response:
    """Return the change of film and motion at the end of a step with the forces there.

    Eq. (D7):  J d(acceleration) = dQ
               d(position) = c2 d(acceleration),  d(velocity) = c1 d(acceleration)
               static modes by Eq. (D6)

    Parameters
    ----------
    system : BodySystem
    last : StepEnd
    linear : Linearisation
    forces : NodalForces
        Direction, stacked [N].
    rings : RingForce
        Direction.
    carrier : Carrier
        Direction of the motion of a mounted block.

    Returns
    -------
    Response
    """
    film_forces = together(forces_by_film(system, last.guided, forces))
    moving = len(system.piston.stiffness)
    change = load_change(system, film_forces, rings, film_forces.piston[:moving], carrier)
    # Eq. (D7)
    right = _right_side(system, last, linear, change)
    acceleration = solve_coupled(linear.arrow, linear.coupling, right)
    lateral = acceleration[LATERAL]
    c = last.coefficients
    rising = (c.to_velocity * linear.slope + c.to_position * linear.axial_velocity_slope) * lateral
    piston = _piston_change(system, c, linear, acceleration, film_forces.piston)
    block = _block_change(system, c, film_forces.block)
    films = skirt_changes(system, last.guided, rising, piston, block)
    return Response(
        films.film_thickness,
        films.sliding_velocity,
        piston.velocity[LATERAL],
        piston.velocity[ROCKING],
        rising,
        acceleration,
        change,
    )


@compiled
def _piston_change(system, c, linear, acceleration, force):
    """Return the changes of the piston's coordinates, static modes included.

    They follow from changes of accelerations and modal forces.
    """
    moving = len(system.piston.stiffness)
    out = _changes(c, acceleration, RIGID + len(force))
    lateral, rocking = acceleration[LATERAL], acceleration[ROCKING]
    ride = FrameAcceleration(
        linear.x_by_lateral * lateral + linear.x_by_rocking * rocking,
        linear.y_by_lateral * lateral + linear.y_by_rocking * rocking,
        rocking,
        linear.spin_by_rocking * rocking,
    )
    q = static_coordinates(system.piston_static, force[moving:], ride)
    before = np.zeros(len(out.position))
    follow(out.position, out.velocity, before, q, RIGID + moving, c.step)
    return out


@compiled
def _block_change(system, c, force):
    """Return the changes of all coordinates of the block with its modal forces."""
    block = system.block
    moving = len(block.stiffness)
    acceleration = np.empty(moving)
    for k in range(moving):
        inertia = 1 + c.to_velocity * block.damping[k] + c.to_position * block.stiffness[k]
        acceleration[k] = force[k] / inertia
    out = _changes(c, acceleration, len(force))
    q = static_coordinates(system.block_static, force[moving:], STILL)
    follow(out.position, out.velocity, np.zeros(len(out.position)), q, moving, c.step)
    return out


@compiled
def _changes(c, acceleration, size):
    """Return the changes of positions and velocities at the end of a step with accelerations there.

    They have zeros up to `size`.
    """
    out = Change(np.zeros(size), np.zeros(size))
    for k in range(len(acceleration)):
        out.position[k] = c.to_position * acceleration[k]
        out.velocity[k] = c.to_velocity * acceleration[k]
    return out
