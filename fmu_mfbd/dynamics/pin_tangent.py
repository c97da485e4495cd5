"""The tangent of the equations of motion of a piston on a floating pin."""

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.pin import across, in_axes, in_space, pair
from .carrier import FIXED
from .floating_frame import RIGID as FRAME
from .floating_frame import TURN, FlexibleBody, FrameMotion, X, Y, frame_arrow, mode_coupling
from .floating_pin import PinFilms, PinImbalance, imbalance, no_films, on_rod
from .generalised_alpha import Motion
from .pin_coordinates import COORDINATES, PIN, Crankshaft, PinBodies, layout
from .pin_inertia import way_of
from .piston_motion import LATERAL, ROCKING, Load
from .slider_crank import CrankMotion, Mechanism


@compilable
def tangent(
    bodies: PinBodies,
    load: Load,
    now: Motion,
    films: PinFilms,
    lack: PinImbalance,
    to_velocity: np.ndarray,
    to_position: np.ndarray,
) -> np.ndarray:
    """Compute the derivative of the residual (Eq. (D21)) by the end accelerations.

    Each one changes its velocity and position as the time integrator does. A column belongs to one
    of them.

    Parameters
    ----------
    bodies, load, now, films
        As for `imbalance`; the films' nodal forces are held, and turn with their shells.
    lack : PinImbalance
        Of `imbalance`.
    to_velocity, to_position : ndarray, shape (7 + k + 2 n,)
        [s], [s2]; all modes alike.

    Returns
    -------
    ndarray, shape (7 + k + 2 n, 7 + k + 2 n)
    """
    first = layout(bodies)
    mechanism = bodies.mechanism
    link = lack.at.link
    slope = link.rod.slope
    c1 = to_velocity
    c2 = to_position
    modes = len(bodies.piston.stiffness)
    n = len(bodies.shapes.stiffness)
    frame = _frame_tangent(bodies.piston, lack.at.frame, c1, c2)
    moments = _turned_moments(first, now, films)
    rows = np.empty(FRAME + modes)
    carried = mechanism.rod_centre * mechanism.rod_mass
    swung = link.curvature * lack.above_eye - link.rod.curvature * on_rod(films)
    swung += link.rod_force_by_position + carried * link.curvature * lack.at.shift[1]
    boss = films.bosses.force
    in_eye = films.eye.force
    in_big_end = films.big_end.force
    out = np.zeros((first.size, first.size))
    for j in range(first.size):
        way = way_of(first, j)
        eye_position = way.eye * c2[j]
        eye_velocity = way.eye * c1[j]
        high = link.axial_by_acceleration * way.eye
        high += link.axial_by_velocity * eye_velocity + link.axial_by_position * eye_position
        boss_turn = way.rocking * c2[j]
        eye_turn = slope * eye_position
        on_piston = _frame_rows(rows, lack, frame, way, high, boss_turn)
        slope_push = films.slope_push[way.mode] * c2[j] if way.mode >= 0 else 0.0
        slopes = films.shell_slope_push[way.shell_mode] * c2[j] if way.shell_mode >= 0 else 0.0
        slopes_on_rod = slopes if j < first.main_bearing_shell else 0.0
        slopes_on_pin = slopes if j < first.big_end_shell else 0.0
        on_pin_x = mechanism.pin_mass * way.pin_x
        lifting = on_piston[1] + mechanism.pin_mass * (high + way.pin_y)
        sideways = link.slope * lifting + link.rod_force_by_acceleration * way.eye
        sideways += link.rod_force_by_velocity * eye_velocity + swung * eye_position
        sideways = sideways + slope * slopes_on_rod
        sideways += carried * (way.shift_x + link.slope * way.shift_y)
        levers = _levers(first, now, films, j, c2[j])
        levers += moments[0] * boss_turn + moments[1] * eye_turn
        out[LATERAL, j] = on_piston[0] + on_pin_x + sideways
        out[ROCKING, j] = rows[TURN] - c2[LATERAL] * load.guided * way.x + slope_push
        out[PIN.boss_x, j] = on_pin_x + sideways + boss[1] * boss_turn
        out[PIN.boss_y, j] = -on_piston[1] - boss[0] * boss_turn
        out[PIN.eye_x, j] = -sideways + in_eye[1] * eye_turn
        out[PIN.eye_y, j] = lifting - in_eye[0] * eye_turn
        out[PIN.spin, j] = levers - slope_push - slopes_on_pin
        for m in range(modes):
            out[first.modes + m, j] = rows[FRAME + m]
        # films' forces turn with their shells
        for k in range(n):
            on_boss = films.bosses.on_shapes[k]
            on_eye = films.eye.on_shapes[k]
            out[first.shapes + k, j] = on_boss[1] * boss_turn + on_eye[1] * eye_turn
            out[first.shapes + n + k, j] = -on_boss[0] * boss_turn - on_eye[0] * eye_turn
        rod_x = mechanism.rod_mass * (mechanism.rod_centre * way.eye + way.shift_x)
        rod_y = mechanism.rod_mass * (mechanism.rod_centre * high + way.shift_y)
        if first.big_end >= 0:
            out[first.big_end, j] = sideways - rod_x + in_big_end[1] * eye_turn
            out[first.big_end + 1, j] = -lifting - rod_y - in_big_end[0] * eye_turn
        if first.main_bearing >= 0:
            out[first.main_bearing, j] = bodies.crank.mass * way.journal_x - (sideways - rod_x)
            out[first.main_bearing + 1, j] = bodies.crank.mass * way.journal_y - (-lifting - rod_y)
    _add_springs(out, bodies, c1, c2)
    return out


@compilable
def _turned_moments(first, now, films):
    """Return the change of the moment on the pin with the angles of bosses and eye, (2,) [N m].

    The films' forces turn with their shells. The pin's position and shapes do not.
    """
    boss = films.bosses.force
    eye = films.eye.force
    from_boss = now.position[PIN.boss_x] * boss[0] + now.position[PIN.boss_y] * boss[1]
    from_eye = now.position[PIN.eye_x] * eye[0] + now.position[PIN.eye_y] * eye[1]
    bent_in_boss = 0.0
    bent_in_eye = 0.0
    n = len(films.bosses.on_shapes)
    for k in range(n):
        for way in range(2):
            s = now.position[first.shapes + way * n + k]
            bent_in_boss += s * films.bosses.on_shapes[k, way]
            bent_in_eye += s * films.eye.on_shapes[k, way]
    return pair(from_boss + bent_in_boss, from_eye + bent_in_eye)


@compilable
def _frame_rows(rows, lack, frame, way, high, boss_turn):
    """Fill in the change of the frame's rows with a coordinate.

    Returns the change of the force on the piston in space, (2,).

    `high` is the acceleration along y that the rod gives its eye, the frame's axes turn.
    """
    at = lack.at
    by_frame = in_axes(at.axes, pair(way.x, high + way.y))
    turned_by = across(in_axes(at.axes, at.piston))
    along = by_frame[0] - turned_by[0] * boss_turn
    up = by_frame[1] - turned_by[1] * boss_turn
    for m in range(len(rows)):
        rows[m] = frame[m, X] * along + frame[m, Y] * up + frame[m, TURN] * way.rocking
        if way.mode >= 0:
            rows[m] += frame[m, FRAME + way.mode]
    on_piston = in_space(at.axes, pair(rows[X], rows[Y]))
    turned_force = across(in_space(at.axes, pair(lack.force.x, lack.force.y)))
    return pair(
        on_piston[0] + turned_force[0] * boss_turn, on_piston[1] + turned_force[1] * boss_turn
    )


@compilable
def _levers(first, now, films, j, to_position):
    """Return the change of the moment on the pin with its place and shapes by coordinate j."""
    boss = films.bosses.force
    eye = films.eye.force
    n = len(films.bosses.on_shapes)
    k = j - first.shapes
    if j == PIN.boss_x:
        return boss[1] * to_position
    if j == PIN.boss_y:
        return -boss[0] * to_position
    if j == PIN.eye_x:
        return eye[1] * to_position
    if j == PIN.eye_y:
        return -eye[0] * to_position
    if 0 <= k < n:
        return (films.bosses.on_shapes[k, 1] + films.eye.on_shapes[k, 1]) * to_position
    if n <= k < 2 * n:
        return -(films.bosses.on_shapes[k - n, 0] + films.eye.on_shapes[k - n, 0]) * to_position
    return 0.0


@compilable
def _add_springs(out, bodies, c1, c2):
    """Add inertia, damping and stiffness that each coordinate has by itself to the tangent."""
    first = layout(bodies)
    shapes = bodies.shapes
    n = len(shapes.stiffness)
    out[PIN.spin, PIN.spin] += bodies.spin_inertia
    for k in range(n):
        for way in range(2):
            m = first.shapes + way * n + k
            held = shapes.damping[k] * c1[m] + shapes.stiffness[k] * c2[m]
            out[m, m] += 1.0 + held
    springs = bodies.shells
    for k in range(len(springs.stiffness)):
        m = first.eye + k
        # Eq. (D40)
        out[m, m] += 1.0 + springs.damping[k] * c1[m] + springs.stiffness[k] * c2[m]


@compilable
def _frame_tangent(
    piston: FlexibleBody, frame: FrameMotion, c1: np.ndarray, c2: np.ndarray
) -> np.ndarray:
    """Compute the derivative of the frame's rows (Eqs. (D1) to (D3)), (3 + k, 3 + k).

    The columns are A's acceleration in the body's axes, the angle and the modes. The integrator
    treats angle and modes differently.
    """
    k = len(frame.q)
    out = np.empty((FRAME + k, FRAME + k))
    arrow = frame_arrow(piston, frame, c1[ROCKING], c2[ROCKING])
    for i in range(FRAME):
        for j in range(FRAME):
            out[i, j] = arrow.top[i, j]
    if k == 0:
        return out
    c1_modes = c1[COORDINATES]
    c2_modes = c2[COORDINATES]
    modal = frame_arrow(piston, frame, c1_modes, c2_modes)
    coupling = mode_coupling(piston, frame.alpha, frame.w, c1_modes, c2_modes)
    for i in range(k):
        for j in range(FRAME):
            out[j, FRAME + i] = modal.top[j, FRAME + i]
            out[FRAME + i, j] = arrow.left[i, j]
        for j in range(k):
            out[FRAME + i, FRAME + j] = coupling[i, j]
        out[FRAME + i, FRAME + i] += modal.diagonal[i]
    return out


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
    load = Load(0.0, 0.0, 0.0, 0.0, np.zeros(first.shapes - first.modes), FIXED)
    films = no_films(first)
    lack = imbalance(upright, load, still, CrankMotion(0.0, 0.0, 0.0), films)
    return tangent(upright, load, still, films, lack, none, none)  # Eqs. (D22), (D35)
