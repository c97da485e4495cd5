"""One instant of the whole body side in compiled code: from predicted motion and forces to
accelerations, film and outputs; and its derivative. Nothing is decided here: the equations stand in
`film`, `piston_motion` and `slider_crank`.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..geometry.film import Bore, Skirt, Window, film_now, generalised, opening, sliding, window_at
from .floating_frame import Arrow, FlexibleBody, mode_coupling
from .generalised_alpha import predict
from .pin_friction import friction_moment
from .piston_motion import Load, imbalance, settle, solve_coupled, tangent
from .quasi_static import StaticModes, static_coordinates
from .slider_crank import Mechanism, height, motion, rod_turn


class Block(NamedTuple):
    """Modal springs of the cylinder block: stiffness omega^2 [rad2/s2] and damping [rad/s], shapes
    (k',).
    """

    stiffness: np.ndarray
    damping: np.ndarray


class System(NamedTuple):
    """Both bodies, the mechanism and the film's geometry.

    Of each body, the modes that move and, after them, those that follow statically. gas_force (k +
    s,) is the modal force of a unit gas force on the crown [kg^-1/2].
    """

    piston: FlexibleBody
    piston_static: StaticModes
    block: Block
    block_static: StaticModes
    mechanism: Mechanism
    skirt: Skirt
    bore: Bore
    gas_force: np.ndarray


class Balance(NamedTuple):
    """Motion, forces and film at an instant.

    Parameters
    ----------
    place, rate, acceleration : ndarray, shape (n,)
        [x_A, rocking angle, piston then block modal coordinates] and derivatives in time.
    auxiliary : ndarray, shape (n,)
        The time integrator's auxiliary acceleration.
    window : Window
    load : Load
        On the piston, gas included.
    film_thickness, sliding_velocity : ndarray, shape (c, a)
        [m], [m/s]
    position, velocity : float
        Height of A [m] and its rate [m/s].
    pin_x, pin_y, pin_moment, torque : float
        Pin force on the piston [N], friction of the pin on it [N m], drive torque on the crank
        without its own inertia [N m].
    work_error : float
        Power of the interface forces on the grid minus that in the coordinates, by the sum of all
        terms' sizes [-]. Both describe the same work, so that anything above round-off is an error
        in the transfer of forces.
    evaluations, tangents, size : int, int, float
        Of `settle`.
    """

    place: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    auxiliary: np.ndarray
    window: Window
    load: Load
    film_thickness: np.ndarray
    sliding_velocity: np.ndarray
    position: float
    velocity: float
    pin_x: float
    pin_y: float
    pin_moment: float
    torque: float
    work_error: float
    evaluations: int
    tangents: int
    size: float


@compiled
def balance(system, c, motion_before, crank, gas, pressure_force, friction_force):
    """One step: accelerations at its end that balance the forces there, and everything that follows
    from them.

    Parameters
    ----------
    system : System
    c : Coefficients
    motion_before : tuple of ndarray, shape (n,)
        Place, rate, acceleration and auxiliary acceleration at the start of the step.
    crank : tuple of float
        Angle [rad], speed [rad/s], acceleration [rad/s2].
    gas : float
        Gas force on the piston along -y [N].
    pressure_force, friction_force : ndarray, shape (c, a)
        [N]

    Returns
    -------
    Balance
    """
    mechanism, skirt, bore, n = (
        system.mechanism,
        system.skirt,
        system.bore,
        2 + len(system.piston.stiffness),
    )
    before = predict(c, motion_before[0], motion_before[1], motion_before[2], motion_before[3])
    Y0, _, lever0 = height(mechanism, 0.0, crank[0])
    window = window_at(bore.lowest, bore.spacing, Y0, skirt.height)
    forces = generalised(skirt, bore, window, pressure_force, friction_force)
    push = forces.piston.copy()
    for k in range(len(push)):
        push[k] += gas * system.gas_force[k]
    load = Load(
        forces.lateral, forces.axial - gas, forces.moment + skirt.pin_offset * gas, push[: n - 2]
    )
    own, pin_x, pin_y, moment, torque, evaluations, tangents, size = settle(
        system.piston,
        mechanism,
        load,
        before[0][:n],
        before[1][:n],
        motion_before[2][:n],
        crank[0],
        crank[1],
        crank[2],
        c.rate,
        c.place,
    )
    end, speed, acceleration, auxiliary = _modes_after(
        system, c, motion_before[0], before, own, push, forces.block, crank
    )
    Y, slope, lever = height(mechanism, end[0], crank[0])
    climb, guided = slope * speed[0] + lever * crank[1], lever0 * crank[1]
    thickness, velocity, lift, power, terms = film_now(
        skirt, bore, window, (pressure_force, friction_force), climb, guided, end, speed
    )
    work, sizes = (
        forces.axial * climb + lift * guided,
        abs(forces.axial * climb) + abs(lift * guided) + terms,
    )
    m = 2 + len(push)
    for k in range(len(end)):
        force = (
            forces.lateral
            if k == 0
            else forces.moment
            if k == 1
            else forces.piston[k - 2]
            if k < m
            else forces.block[k - m]
        )
        work += force * speed[k]
        sizes += abs(force * speed[k])
    error = abs(power - work) / sizes if sizes > 0.0 else 0.0
    return Balance(
        end,
        speed,
        acceleration,
        auxiliary,
        window,
        load,
        thickness,
        velocity,
        Y,
        climb,
        pin_x,
        pin_y - lift,
        moment,
        torque - lift * lever0,
        error,
        evaluations,
        tangents,
        size,
    )


@compiled
def _modes_after(system, c, place_before, before, own, push, block_force, crank):
    """Places, rates, accelerations and auxiliary accelerations of everything at the end of a step.

    `before` holds places, rates and auxiliary accelerations as predicted, `own` the accelerations
    of the piston's moving part.
    """
    block, n, m = system.block, len(own), 2 + len(push)
    place, rate, auxiliary = before
    end, speed, acceleration = np.empty(len(place)), np.empty(len(place)), np.zeros(len(place))
    for k in range(n):
        acceleration[k] = own[k]
    for k in range(len(block.stiffness)):
        force = block_force[k] - block.damping[k] * rate[m + k] - block.stiffness[k] * place[m + k]
        acceleration[m + k] = force / (1 + c.rate * block.damping[k] + c.place * block.stiffness[k])
    for k in range(len(place)):
        end[k], speed[k] = place[k] + c.place * acceleration[k], rate[k] + c.rate * acceleration[k]
        auxiliary[k] += c.weight * acceleration[k]
    if len(system.piston_static.stiffness):
        ax, ay = in_frame(
            own[0],
            motion(system.mechanism, end[0], speed[0], own[0], crank[0], crank[1], crank[2])[0],
            end[1],
        )
        q = static_coordinates(system.piston_static, push[n - 2 :], ax, ay, own[1], speed[1] ** 2)
        _follow(end, speed, place_before, q, n, c.step)
    moving = len(block.stiffness)
    q = static_coordinates(system.block_static, block_force[moving:], 0.0, 0.0, 0.0, 0.0)
    _follow(end, speed, place_before, q, m + moving, c.step)
    return end, speed, acceleration, auxiliary


@compiled
def in_frame(ax, ay, angle):
    """A vector's components in a frame turned by an angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return c * ax + s * ay, -s * ax + c * ay


@compiled
def _follow(end, speed, place_before, q, first, step):
    """Put static modes at their coordinates from `first` on; their rate is the mean one over the
    step, 0 at the start.
    """
    for k in range(len(q)):
        end[first + k] = q[k]
        speed[first + k] = (q[k] - place_before[first + k]) / step if step > 0.0 else 0.0


class Linear(NamedTuple):
    """The piston's motion at the end of a step, linearised.

    Parameters
    ----------
    arrow : Arrow
    coupling : ndarray, shape (k, k)
        Together the tangent J (`floating_frame.mode_coupling`).
    slope, climb_place, turn_place : float
        dY/dx_A [-], the change of A's velocity along y with x_A [1/s], dpsi/dx_A [1/m].
    friction_x, friction_y : float
        Change of the pin's friction moment with the pin force [m].
    ride : ndarray, shape (2, 3)
        Change of A's acceleration in the body frame (x, y) [-] and of w^2 [rad/s2] with x_A'' and
        with the angular acceleration.
    """

    arrow: Arrow
    coupling: np.ndarray
    slope: float
    climb_place: float
    turn_place: float
    friction_x: float
    friction_y: float
    ride: np.ndarray


@compiled
def linearise(system, load, place, rate, acceleration, crank, c1, c2):
    """The piston's motion linearised about the end of a step.

    Parameters
    ----------
    system : System
    load : Load
    place, rate, acceleration : ndarray, shape (2 + k,)
        Of the piston.
    crank : tuple of float
        Angle [rad], speed [rad/s], acceleration [rad/s2].
    c1, c2 : float
        [s], [s2]

    Returns
    -------
    Linear
    """
    piston, mechanism = system.piston, system.mechanism
    angle, speed, turn = crank
    _, pin_x, pin_y, _, _ = imbalance(
        piston, mechanism, load, place, rate, acceleration, angle, speed, turn
    )
    rod = rod_turn(mechanism, place[0], rate[0], angle, speed)
    friction = friction_moment(mechanism.friction, pin_x, pin_y, rate[1] - rod[0])
    link = motion(mechanism, place[0], rate[0], acceleration[0], angle, speed, turn)
    ride, (ax, ay) = np.zeros((2, 3)), in_frame(acceleration[0], link[0], place[1])
    ride[0, 0], ride[0, 1] = in_frame(1.0, link[1] + c1 * link[2] + c2 * link[3], place[1])
    ride[1, 0], ride[1, 1], ride[1, 2] = c2 * ay, -c2 * ax, 2 * rate[1] * c1
    return Linear(
        tangent(piston, mechanism, load, place, rate, acceleration, angle, speed, turn, c1, c2),
        mode_coupling(piston, acceleration[1], rate[1], c1, c2),
        link[4],
        link[2] / 2,
        rod[1],
        friction[1],
        friction[2],
        ride,
    )


@compiled
def response(system, window, c, linear, pressure_force, friction_force):
    """Change of film thickness and sliding velocity at the end of a step with the forces at its
    end.

    Eq. (D1):  J d(acceleration) = dQ,   d(place) = c2 d(acceleration),  d(rate) = c1 d(acceleration);   static modes by Eq. (Q1)

    Parameters
    ----------
    system : System
    window : Window
    c : Coefficients
        Of the step.
    linear : Linear
    pressure_force, friction_force : ndarray, shape (c, a)
        Direction [N].

    Returns
    -------
    film_thickness, sliding_velocity : ndarray, shape (c, a)
        [m], [m/s]
    """
    skirt, bore, n = system.skirt, system.bore, 2 + len(system.piston.stiffness)
    forces = generalised(skirt, bore, window, pressure_force, friction_force)
    # the pin carries what the film does not
    rubbing = -linear.friction_x * forces.lateral - linear.friction_y * forces.axial
    right = np.empty(n)
    right[0] = forces.lateral + linear.slope * forces.axial - linear.turn_place * rubbing
    right[1] = forces.moment + rubbing
    for k in range(n - 2):
        right[2 + k] = forces.piston[k]
    change = solve_coupled(linear.arrow, linear.coupling, right)  # Eq. (D1)
    climb = (c.rate * linear.slope + c.place * linear.climb_place) * change[0]
    own, own_rate = _changes(c, change, 2 + len(forces.piston))
    x, y, spin = ridden(linear.ride, change[0], change[1])
    q = static_coordinates(system.piston_static, forces.piston[n - 2 :], x, y, change[1], spin)
    _follow(own, own_rate, np.zeros(len(own)), q, n, c.step)
    moving = len(system.block.stiffness)
    sway = np.empty(moving)
    for k in range(moving):
        sway[k] = forces.block[k] / (
            1 + c.rate * system.block.damping[k] + c.place * system.block.stiffness[k]
        )
    other, other_rate = _changes(c, sway, len(forces.block))
    q = static_coordinates(system.block_static, forces.block[moving:], 0.0, 0.0, 0.0, 0.0)
    _follow(other, other_rate, np.zeros(len(other)), q, moving, c.step)
    return (
        opening(skirt, bore, window, own[0], own[1], own[2:], other),
        sliding(skirt, bore, window, climb, own_rate[1], own_rate[2:], other_rate),
    )


@compiled
def ridden(ride, lateral, turn):
    """Changes of A's acceleration in the body frame and of w^2, see `Linear`."""
    return (
        ride[0, 0] * lateral + ride[1, 0] * turn,
        ride[0, 1] * lateral + ride[1, 1] * turn,
        ride[0, 2] * lateral + ride[1, 2] * turn,
    )


@compiled
def _changes(c, acceleration, size):
    """Changes of places and rates at the end of a step with changes of accelerations there; zeros
    up to `size`.
    """
    place, rate = np.zeros(size), np.zeros(size)
    for k in range(len(acceleration)):
        place[k], rate[k] = c.place * acceleration[k], c.rate * acceleration[k]
    return place, rate
