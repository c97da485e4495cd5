"""One instant of the whole body side in compiled code: from predicted motion and forces to accelerations, film and outputs; and
its derivative. Nothing is decided here: the equations stand in `film`, `piston_motion` and `slider_crank`."""

from typing import NamedTuple

import numpy as np

from .compiled import compiled
from .film import Bore, Skirt, Window, film_now, generalised, opening, sliding, window_at
from .floating_frame import Arrow, FlexibleBody, mode_coupling
from .generalised_alpha import predict
from .pin_friction import friction_moment
from .piston_motion import Load, imbalance, settle, solve_coupled, tangent
from .slider_crank import Mechanism, height, motion, rod_turn


class Block(NamedTuple):
    """Modal springs of the cylinder block: stiffness omega^2 [rad2/s2] and damping 2 zeta omega [rad/s], shapes (k',)."""

    stiffness: np.ndarray
    damping: np.ndarray


class System(NamedTuple):
    """Both bodies, the mechanism and the film's geometry.

    gas_force (k,) is the modal force of a unit gas force on the crown [kg^-1/2].
    """

    piston: FlexibleBody
    block: Block
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
        Pin force on the piston [N], friction of the pin on it [N m], drive torque on the crank without its own inertia [N m].
    work_error : float
        Power of the interface forces on the grid minus that in the coordinates, by the sum of all terms' sizes [-]. Both describe
        the same work, so that anything above round-off is an error in the transfer of forces.
    evaluations, size : int, float
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
    size: float


@compiled()
def balance(system, c, motion_before, crank, gas, pressure_force, friction_force):
    """One step: accelerations at its end that balance the forces there, and everything that follows from them.

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
    piston, block, mechanism, skirt, bore, gas_force = system
    n, c1, c2 = 2 + len(piston.stiffness), c.rate, c.place
    place, rate, auxiliary = predict(c, motion_before[0], motion_before[1], motion_before[2], motion_before[3])
    Y0, _, lever0 = height(mechanism, 0.0, crank[0])
    window = window_at(bore.lowest, bore.spacing, Y0, skirt.height)
    forces = generalised(skirt, bore, window, pressure_force, friction_force)
    push = forces.piston.copy()
    for k in range(n - 2):
        push[k] += gas * gas_force[k]
    load = Load(forces.lateral, forces.axial - gas, forces.moment + skirt.pin_offset * gas, push)
    acceleration = np.empty(len(place))
    own, pin_x, pin_y, moment, torque, evaluations, size = settle(
        piston, mechanism, load, place[:n], rate[:n], motion_before[2][:n], crank[0], crank[1], crank[2], c1, c2)
    end, speed = np.empty(len(place)), np.empty(len(place))
    for k in range(len(place)):
        if k < n:
            acceleration[k] = own[k]
        else:
            damping, stiffness = block.damping[k - n], block.stiffness[k - n]
            force = forces.block[k - n] - damping * rate[k] - stiffness * place[k]
            acceleration[k] = force / (1 + c1 * damping + c2 * stiffness)
        end[k], speed[k] = place[k] + c2 * acceleration[k], rate[k] + c1 * acceleration[k]
        auxiliary[k] += c.weight * acceleration[k]
    Y, slope, lever = height(mechanism, end[0], crank[0])
    climb, guided = slope * speed[0] + lever * crank[1], lever0 * crank[1]
    thickness, velocity, lift, power, terms = film_now(skirt, bore, window, (pressure_force, friction_force), climb, guided,
                                                       end, speed)
    work, sizes = forces.axial * climb + lift * guided, abs(forces.axial * climb) + abs(lift * guided) + terms
    for k in range(len(place)):
        force = (forces.lateral if k == 0 else forces.moment if k == 1 else
                 forces.piston[k - 2] if k < n else forces.block[k - n])
        work += force * speed[k]
        sizes += abs(force * speed[k])
    error = abs(power - work) / sizes if sizes > 0.0 else 0.0
    return Balance(end, speed, acceleration, auxiliary, window, load, thickness, velocity, Y, climb, pin_x, pin_y - lift,
                   moment, torque - lift * lever0, error, evaluations, size)


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
    """

    arrow: Arrow
    coupling: np.ndarray
    slope: float
    climb_place: float
    turn_place: float
    friction_x: float
    friction_y: float


@compiled()
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
    _, pin_x, pin_y, _, _ = imbalance(piston, mechanism, load, place, rate, acceleration, angle, speed, turn)
    rod = rod_turn(mechanism, place[0], rate[0], angle, speed)
    friction = friction_moment(mechanism.friction, pin_x, pin_y, rate[1] - rod[0])
    link = motion(mechanism, place[0], rate[0], acceleration[0], angle, speed, turn)
    return Linear(tangent(piston, mechanism, load, place, rate, acceleration, angle, speed, turn, c1, c2),
                  mode_coupling(piston, acceleration[1], rate[1], c1, c2), link[4], link[2] / 2, rod[1], friction[1], friction[2])


@compiled()
def response(system, window, c1, c2, linear, pressure_force, friction_force):
    """Change of film thickness and sliding velocity at the end of a step with the forces at its end.

    Eq. (D1):  J d(acceleration) = dQ,   d(place) = c2 d(acceleration),  d(rate) = c1 d(acceleration)

    Parameters
    ----------
    system : System
    window : Window
    c1, c2 : float
        [s], [s2]
    linear : Linear
    pressure_force, friction_force : ndarray, shape (c, a)
        Direction [N].

    Returns
    -------
    film_thickness, sliding_velocity : ndarray, shape (c, a)
        [m], [m/s]
    """
    block, skirt, bore = system.block, system.skirt, system.bore
    forces = generalised(skirt, bore, window, pressure_force, friction_force)
    rubbing = -linear.friction_x * forces.lateral - linear.friction_y * forces.axial    # the pin carries less of what the film does
    right = np.empty(2 + len(forces.piston))
    right[0] = forces.lateral + linear.slope * forces.axial - linear.turn_place * rubbing
    right[1] = forces.moment + rubbing
    for k in range(len(forces.piston)):
        right[2 + k] = forces.piston[k]
    change, other = solve_coupled(linear.arrow, linear.coupling, right), forces.block                           # Eq. (D1)
    for k in range(len(other)):
        other[k] /= 1 + c1 * block.damping[k] + c2 * block.stiffness[k]
    climb = (c1 * linear.slope + c2 * linear.climb_place) * change[0]
    own, own_rate, other_rate = change.copy(), change.copy(), other.copy()
    scale(own, c2)
    scale(own_rate, c1)
    scale(other_rate, c1)
    scale(other, c2)
    return (opening(skirt, bore, window, own[0], own[1], own[2:], other),
            sliding(skirt, bore, window, climb, own_rate[1], own_rate[2:], other_rate))


@compiled()
def scale(a, factor):
    """a *= factor, in a loop: array expressions take the compiler seconds each."""
    for k in range(len(a)):
        a[k] *= factor
