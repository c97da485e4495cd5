"""One instant of the whole body side in compiled code: from predicted motion and forces to accelerations, film and outputs; and its
derivative. Nothing is decided here: the equations stand in `film`, `piston_motion` and `slider_crank`."""

from typing import NamedTuple

import numpy as np
from numba import njit

from .film import Bore, FilmForces, Skirt, Window, film_now, generalised, opening, sliding, window_at
from .floating_frame import FlexibleBody
from .piston_motion import Load, settle
from .slider_crank import Mechanism, height


class Block(NamedTuple):
    """Modal springs of the cylinder block: stiffness omega^2 [rad2/s2] and damping 2 zeta omega [rad/s], shapes (k',)."""

    stiffness: np.ndarray
    damping: np.ndarray


class System(NamedTuple):
    """Both bodies, the mechanism and the film's geometry; gas_force (k,): modal force of a unit gas force on the crown [kg^-1/2]."""

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
    window : Window
    load : Load
        On the piston, gas included.
    forces : FilmForces
    film_thickness, sliding_velocity : ndarray, shape (c, a)
        [m], [m/s]
    position, velocity : float
        Height of A [m] and its rate [m/s].
    pin_x, pin_y, torque : float
        Pin force on the piston [N], drive torque on the crank without its own inertia [N m].
    work_error : float
        Power of the interface forces on the grid minus that in the coordinates, by the sum of all terms' sizes [-]. Both describe the
        same work, so that anything above round-off is an error in the transfer of forces.
    evaluations, size : int, float
        Of `settle`.
    """

    place: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    window: Window
    load: Load
    forces: FilmForces
    film_thickness: np.ndarray
    sliding_velocity: np.ndarray
    position: float
    velocity: float
    pin_x: float
    pin_y: float
    torque: float
    work_error: float
    evaluations: int
    size: float


@njit(cache=True)
def balance(system, c1, c2, place, rate, guess, crank, gas, pressure_force, friction_force):
    """Accelerations that balance the forces, and everything that follows from them.

    Parameters
    ----------
    system : System
    c1, c2 : float
        What an acceleration of 1 adds to rate and place at the end of the step [s], [s2].
    place, rate, guess : ndarray, shape (n,)
        Predicted without the end accelerations; a guess of these.
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
    n = 2 + len(piston.stiffness)
    Y0, _, lever0 = height(mechanism, 0.0, crank[0])
    window = window_at(bore.lowest, bore.spacing, Y0 + skirt.height)
    forces = generalised(skirt, bore, window, pressure_force, friction_force)
    load = Load(forces.lateral, forces.axial - gas, forces.moment + skirt.pin_offset * gas, forces.piston + gas * gas_force)
    acceleration = np.empty(len(place))
    acceleration[:n], pin_x, pin_y, torque, evaluations, size = settle(
        piston, mechanism, load, place[:n], rate[:n], guess[:n], crank[0], crank[1], crank[2], c1, c2)
    acceleration[n:] = ((forces.block - block.damping * rate[n:] - block.stiffness * place[n:])
                        / (1 + c1 * block.damping + c2 * block.stiffness))
    place, rate = place + c2 * acceleration, rate + c1 * acceleration
    Y, slope, lever = height(mechanism, place[0], crank[0])
    climb, guided = slope * rate[0] + lever * crank[1], lever0 * crank[1]
    thickness, velocity, lift, power, terms = film_now(skirt, bore, window, (pressure_force, friction_force), climb, guided, place, rate)
    own = np.concatenate((np.array([forces.lateral * rate[0], forces.axial * climb, forces.moment * rate[1], lift * guided]),
                          forces.piston * rate[2:n], forces.block * rate[n:]))
    terms += np.abs(own).sum()
    error = abs(power - own.sum()) / terms if terms > 0.0 else 0.0
    return Balance(place, rate, acceleration, window, load, forces, thickness, velocity, Y, climb, pin_x, pin_y - lift,
                   torque - lift * lever0, error, evaluations, size)


@njit(cache=True)
def response(system, window, c1, c2, slope, climb_place, inverse, pressure_force, friction_force):
    """Change of film thickness and sliding velocity at the end of a step with the forces at its end.

    Eq. (D1):  J d(acceleration) = dQ,   d(place) = c2 d(acceleration),  d(rate) = c1 d(acceleration)

    Parameters
    ----------
    system : System
    window : Window
    c1, c2 : float
        [s], [s2]
    slope, climb_place : float
        dY/dx_A [-], and the change of A's velocity along y with x_A [1/s].
    inverse : ndarray, shape (2 + k, 2 + k)
        J^-1 of the piston's motion.
    pressure_force, friction_force : ndarray, shape (c, a)
        Direction [N].

    Returns
    -------
    film_thickness, sliding_velocity : ndarray, shape (c, a)
        [m], [m/s]
    """
    block, skirt, bore = system.block, system.skirt, system.bore
    forces = generalised(skirt, bore, window, pressure_force, friction_force)
    right = np.empty(len(inverse))
    right[0], right[1] = forces.lateral + slope * forces.axial, forces.moment
    right[2:] = forces.piston
    own = inverse @ right                                                                                       # Eq. (D1)
    other = forces.block / (1 + c1 * block.damping + c2 * block.stiffness)
    climb = (c1 * slope + c2 * climb_place) * own[0]
    return (opening(skirt, bore, window, c2 * own[0], c2 * own[1], c2 * own[2:], c2 * other),
            sliding(skirt, bore, window, climb, c1 * own[1], c1 * own[2:], c1 * other))
