"""The tangent of the equations of motion of a piston on a floating pin."""

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.pin import in_space, pair
from .carrier import FIXED
from .floating_frame import RIGID as FRAME
from .floating_frame import TURN, X, Y, frame_arrow, mode_coupling
from .floating_pin import PinFilms, PinImbalance, imbalance, no_films, pushed, springs_of
from .generalised_alpha import Motion
from .pin_coordinates import PIN, Crankshaft, PinBodies, layout
from .pin_films import films_at
from .piston_motion import Load
from .slider_crank import CrankMotion, Mechanism

SHIFT, LARGEST = 1e-6, 1e4
"""Change of a coordinate for central differences [m], [rad], and largest one of its acceleration
[m/s2], [rad/s2].
"""


@compilable
def tangent(
    bodies: PinBodies,
    load: Load,
    now: Motion,
    crank: CrankMotion,
    own: PinFilms,
    lack: PinImbalance,
    to_velocity: np.ndarray,
    to_position: np.ndarray,
) -> np.ndarray:
    """Compute the derivative of the residual (Eq. (D21)) by the end accelerations.

    Each one changes its velocity and position as the time integrator does. A column belongs to one
    of them. Columns of modes, in which the equations are linear, are exact, all others central
    differences.

    Parameters
    ----------
    bodies, load, now, crank
        As for `imbalance`.
    own : PinFilms
        Of `own_films`; the films' nodal forces are held, and turn with their shells.
    lack : PinImbalance
        Of `imbalance`.
    to_velocity, to_position : ndarray, shape (7 + k + 2 n,)
        [s], [s2]; all modes and the play in the bosses alike.

    Returns
    -------
    ndarray, shape (7 + k + 2 n, 7 + k + 2 n)
    """
    first = layout(bodies)
    out = np.empty((first.size, first.size))
    for j in range(first.size):
        if first.modes <= j < first.shapes or first.eye <= j < first.crank:
            continue
        size = SHIFT / max(to_position[j], SHIFT / LARGEST)
        moved = _moved(now, to_velocity, to_position, j, size)
        ahead = _residual(bodies, load, moved, crank, own)
        moved = _moved(now, to_velocity, to_position, j, -size)
        behind = _residual(bodies, load, moved, crank, own)
        for i in range(first.size):
            out[i, j] = (ahead[i] - behind[i]) / (2 * size)
    _put_modes(out, bodies, own, lack, to_velocity, to_position)
    return out


@compilable
def _moved(now, to_velocity, to_position, j, size):
    """Return a motion after a change of the end acceleration of coordinate j."""
    moved = Motion(now.position.copy(), now.velocity.copy(), now.acceleration.copy())
    moved.position[j] += size * to_position[j]
    moved.velocity[j] += size * to_velocity[j]
    moved.acceleration[j] += size
    return moved


@compilable
def _residual(bodies, load, now, crank, own):
    """Return the residual in a motion of bodies and shells."""
    films = films_at(bodies.mechanism, layout(bodies), own, now, crank)
    return imbalance(bodies, load, now, crank, films).residual


@compilable
def _put_modes(out, bodies, own, lack, to_velocity, to_position):
    """Put the columns of the modes of piston and shells into the tangent.

    The piston's modes change the force that its frame needs, those of all shells turn the pressure
    of their films (Eq. (G5)).
    """
    first = layout(bodies)
    piston, frame = bodies.piston, lack.at.frame
    c1, c2 = to_velocity[PIN.boss_x], to_position[PIN.boss_x]
    arrow = frame_arrow(piston, frame, c1, c2)
    coupling = mode_coupling(piston, frame.alpha, frame.w, c1, c2)
    springs = springs_of(bodies)
    films = no_films(first, len(own.force))
    for j in range(first.modes, first.crank):
        m = j - first.modes
        modal = np.zeros(first.shapes - first.modes)
        change = Load(0.0, 0.0, 0.0, 0.0, modal, FIXED)
        if j < first.shapes:
            needed = in_space(lack.at.axes, pair(arrow.top[X, FRAME + m], arrow.top[Y, FRAME + m]))
            for i in range(len(modal)):
                modal[i] = -coupling[i, m]
            modal[m] -= arrow.diagonal[m]
            change = Load(-needed[0], -needed[1], -arrow.top[TURN, FRAME + m], 0.0, modal, FIXED)
        elif j < first.eye:
            continue
        for k in range(len(films.on_pin)):
            films.on_pin[k] = c2 * own.slope_push[k, j]
            films.on_shell[k] = -films.on_pin[k]
        column = pushed(first, lack.at.link, films, change)
        for i in range(first.size):
            out[i, j] = column[i]
        out[j, j] += springs.mass[j] + c1 * springs.damping[j] + c2 * springs.stiffness[j]


@compiled
def inertia(bodies: PinBodies, of_rod: float) -> np.ndarray:
    """Return M of the motion across the bore and of the pin in its shells.

    Eq. (D22):  T = q' . M q'/2      of piston and pin, the piston upright, the rod's eye along the
                                     bore as its big end, at rest without play in it; each shape
                                     and the shells' modes by their own mass
    Eq. (D35):  T += m_r (delta'^2 + 2 k eye' delta_x')/2 + m_c m'^2/2      eye = x_S - delta_x

    With the rod, it swings with its eye (Eqs. (K12), (K16)), and rod and crank move by the play at
    the crank. Driven motion along the bore is none of it, as with a pin that is tied.

    Parameters
    ----------
    bodies : PinBodies
    of_rod : float
        Share of the masses of rod and crank that counts: 0 or 1.
    """
    rod, crank = bodies.mechanism, bodies.crank
    upright = PinBodies(
        bodies.piston,
        Mechanism(
            rod.crank_radius,
            rod.rod_length,
            0.0,
            of_rod * rod.rod_mass,
            of_rod * rod.rod_inertia,
            rod.rod_centre,
            rod.pin_mass,
            rod.friction,
        ),
        bodies.spin_inertia,
        bodies.shapes,
        bodies.shells,
        Crankshaft(
            crank.big_end,
            crank.main_bearing,
            of_rod * crank.mass,
            crank.unbalance,
            crank.big_end_modes,
            crank.main_bearing_modes,
        ),
    )
    first = layout(bodies)
    none = np.zeros(first.size)
    still = Motion(none, none, none)
    crank_at_rest = CrankMotion(0.0, 0.0, 0.0)
    load = Load(0.0, 0.0, 0.0, 0.0, np.zeros(first.shapes - first.modes), FIXED)
    films = no_films(first, 0)
    lack = imbalance(upright, load, still, crank_at_rest, films)
    # Eqs. (D22), (D35)
    return tangent(upright, load, still, crank_at_rest, films, lack, none, none)
