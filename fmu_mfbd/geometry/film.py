"""The film's geometry: thickness and sliding velocity on the skirt grid from the motion, and forces
back by virtual work.

Points (i, j) of the grid ride on the skirt; arrays are (n_circumferential, n_axial). theta counts
from +z towards +x. Inside, rows are heights and columns angles, as `modal_field` wants them.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from .modal_field import ModalField, modal_field, read, read_both, spread


class Skirt(NamedTuple):
    """Skirt side of the film, c x a grid cells.

    Parameters
    ----------
    angle : ndarray, shape (c,)
        theta [rad].
    height : ndarray, shape (a,)
        y' above A [m].
    gap : ndarray, shape (c, a)
        Clearance and profile: film thickness in the concentric, undeformed place [m].
    radius, pin_offset : float
        Skirt radius; x of A from the skirt's axis [m].
    radial, axial : ModalField
        Modal displacement outwards and along y at the grid points, a rows.
    """

    angle: np.ndarray
    height: np.ndarray
    gap: np.ndarray
    radius: float
    pin_offset: float
    radial: ModalField
    axial: ModalField


class Bore(NamedTuple):
    """Bore side of the film: its modes as uniform cubic B-splines in height.

    Parameters
    ----------
    lowest, spacing : float
        Height of the first coefficient's knot and distance of knots [m].
    radial, axial : ModalField
        Spline coefficients at the angles of the grid, one row a knot.
    shape : ndarray, shape (knots, c)
        Likewise of the undeformed bore's widening; no rows where it is a cylinder [m].
    """

    lowest: float
    spacing: float
    radial: ModalField
    axial: ModalField
    shape: np.ndarray


class FilmForces(NamedTuple):
    """Generalised forces of the film.

    Parameters
    ----------
    lateral, axial, moment : float
        On the piston along x and y, and about A [N], [N], [N m].
    piston, block : ndarray
        Modal forces [kg^-1/2 N].
    """

    lateral: float
    axial: float
    moment: float
    piston: np.ndarray
    block: np.ndarray


class Window(NamedTuple):
    """The part of the bore that faces the skirt when A stands at a given height.

    Parameters
    ----------
    first, knots : int
        First knot of the splines in use and how many.
    place : ndarray of int, shape (a,)
        First of the four knots of each grid row, counted from `first`.
    value, slope : ndarray, shape (a, 4)
        Weights of these knots for the spline [-] and its slope in height [1/m].
    """

    first: int
    knots: int
    place: np.ndarray
    value: np.ndarray
    slope: np.ndarray


def bore_splines(heights, radial, axial, kind=None, shape=None):
    """Cubic spline through tabulated bore modes.

    Eq. (H3):  (c_(i-1) + 4 c_i + c_(i+1))/6 = value_i, second derivative zero at both ends

    Twice continuously differentiable in height, so that a moving skirt sees no kinks.

    Parameters
    ----------
    heights : ndarray, shape (s,)
        Equally spaced [m].
    radial, axial : ndarray, shape (c, s, k)
    kind : ndarray of int, shape (k,), optional
        Symmetry classes of the modes.
    shape : ndarray, shape (c, s), optional
        Widening of the undeformed bore [m].

    Returns
    -------
    Bore
    """
    s, c = len(heights), radial.shape[0]
    rule = np.zeros((s + 2, s + 2))
    rule[0, :3] = rule[-1, -3:] = 1.0, -2.0, 1.0
    for i in range(s):
        rule[i + 1, i : i + 3] = 1 / 6, 4 / 6, 1 / 6  # Eq. (H3)
    inverse = np.linalg.inv(rule)[:, 1:-1]
    spacing = float(heights[1] - heights[0])
    fields = (modal_field(np.einsum("rs,csk->crk", inverse, v), kind) for v in (radial, axial))
    widening = (
        np.ascontiguousarray(inverse @ shape.T)
        if shape is not None and shape.any()
        else np.zeros((0, c))
    )
    return Bore(float(heights[0]) - spacing, spacing, *fields, widening)


@compiled
def window_at(lowest, spacing, height_of_A, rows):
    """Window for grid rows at rising heights `rows` above A, A above the crank axis [m]."""
    a = len(rows)
    first = int(np.floor((height_of_A + rows[0] - lowest) / spacing)) - 1
    place, value, slope = np.empty(a, np.int64), np.empty((a, 4)), np.empty((a, 4))
    for j in range(a):
        x = (height_of_A + rows[j] - lowest) / spacing
        k = int(np.floor(x))
        t, place[j] = x - k, k - 1 - first
        value[j, 0], slope[j, 0] = (1 - t) ** 3 / 6, -((1 - t) ** 2) / (2 * spacing)
        value[j, 1], slope[j, 1] = (
            (4 - 6 * t * t + 3 * t**3) / 6,
            (3 * t * t - 4 * t) / (2 * spacing),
        )
        value[j, 2], slope[j, 2] = (
            (1 + 3 * t + 3 * t * t - 3 * t**3) / 6,
            (1 + 2 * t - 3 * t * t) / (2 * spacing),
        )
        value[j, 3], slope[j, 3] = t**3 / 6, t * t / (2 * spacing)
    return Window(first, place[a - 1] + 4, place, value, slope)


@compiled
def on_rows(window, weight, knots):
    """Values at the grid rows, (a, c), from spline coefficients at the window's knots, (knots,
    c).
    """
    out = np.empty((len(window.place), knots.shape[1]))
    for j in range(len(window.place)):
        k = window.place[j]
        for i in range(knots.shape[1]):
            out[j, i] = (
                weight[j, 0] * knots[k, i]
                + weight[j, 1] * knots[k + 1, i]
                + weight[j, 2] * knots[k + 2, i]
                + weight[j, 3] * knots[k + 3, i]
            )
    return out


@compiled
def on_knots(window, force):
    """Forces on the window's knots, (knots, c), from forces (a, c) at the grid rows: the transpose
    of `on_rows`.
    """
    out = np.zeros((window.knots, force.shape[1]))
    for j in range(len(window.place)):
        for t in range(4):
            w, k = window.value[j, t], window.place[j] + t
            for i in range(force.shape[1]):
                out[k, i] += w * force[j, i]
    return out


@compiled
def opening(skirt, bore, window, lateral, angle, piston, block):
    """What motion and deformation add to the film thickness.

    Eq. (H1):  h = gap(theta, y') - (x_A - angle y') sin theta - u_r(skirt) + w_r(bore at Y_0(crank angle) + y')

    Linear in the small motions: with the coordinates' rates it gives the rate. The bore is read at
    the height that A has when x_A = 0: the true one differs by less than x_A r/L, micrometres on a
    field that varies over millimetres.

    Parameters
    ----------
    skirt : Skirt
    bore : Bore
    window : Window
    lateral, angle : float
        x_A [m] and rocking angle [rad].
    piston, block : ndarray
        Modal coordinates [kg^1/2 m].

    Returns
    -------
    ndarray, shape (c, a)
        [m]
    """
    outer = on_rows(window, window.value, read(bore.radial, window.first, window.knots, block))
    return _opening(skirt, lateral, angle, read(skirt.radial, 0, skirt.gap.shape[1], piston), outer)


@compiled
def _opening(skirt, lateral, angle, inner, outer):
    """Eq. (H1) without the gap, the displacements of skirt and bore given on the rows, (a, c)."""
    c, a = skirt.gap.shape
    out = np.empty((c, a))
    for i in range(c):
        sine = np.sin(skirt.angle[i])
        for j in range(a):
            out[i, j] = (
                (angle * skirt.height[j] - lateral) * sine - inner[j, i] + outer[j, i]
            )  # Eq. (H1)
    return out


@compiled
def sliding(skirt, bore, window, height_rate, angle_rate, piston_rate, block_rate):
    """Axial velocity of the skirt minus that of the bore.

    Eq. (H2):  v = Y_A' + angle' (R sin theta - pin offset) + u_y'(skirt) - w_y'(bore)

    Parameters
    ----------
    skirt : Skirt
    bore : Bore
    window : Window
    height_rate, angle_rate : float
        Of A [m/s] and of the rocking angle [rad/s].
    piston_rate, block_rate : ndarray
        [kg^1/2 m/s]

    Returns
    -------
    ndarray, shape (c, a)
        [m/s]
    """
    c, a = skirt.gap.shape
    inner = read(skirt.axial, 0, a, piston_rate)
    outer = on_rows(window, window.value, read(bore.axial, window.first, window.knots, block_rate))
    out = np.empty((c, a))
    for i in range(c):
        rigid = height_rate + angle_rate * (
            skirt.radius * np.sin(skirt.angle[i]) - skirt.pin_offset
        )
        for j in range(a):
            out[i, j] = rigid + inner[j, i] - outer[j, i]  # Eq. (H2)
    return out


@compiled
def generalised(skirt, bore, window, pressure_force, friction_force):
    """Forces on the coordinates by virtual work: Q_k = sum F dh/dq_k + sum f dv/dq'_k.

    Parameters
    ----------
    skirt : Skirt
    bore : Bore
    window : Window
    pressure_force, friction_force : ndarray, shape (c, a)
        [N]: pushing the surfaces apart; along y on the skirt.

    Returns
    -------
    FilmForces
    """
    lateral, axial, moment = resultants(skirt, pressure_force, friction_force)
    push, drag = by_rows(pressure_force), by_rows(friction_force)
    piston, block = (
        spread(skirt.axial, 0, drag),
        spread(bore.radial, window.first, on_knots(window, push)),
    )
    subtract(piston, spread(skirt.radial, 0, push))
    subtract(block, spread(bore.axial, window.first, on_knots(window, drag)))
    return FilmForces(lateral, axial, moment, piston, block)


@compiled
def resultants(skirt, pressure_force, friction_force):
    """Forces of the film on the piston along x and y, and moment about A."""
    lateral, axial, moment = 0.0, 0.0, 0.0
    for i in range(pressure_force.shape[0]):
        push, lift, drag = 0.0, 0.0, 0.0
        for j in range(pressure_force.shape[1]):
            push += pressure_force[i, j]
            lift += pressure_force[i, j] * skirt.height[j]
            drag += friction_force[i, j]
        sine = np.sin(skirt.angle[i])
        lateral -= push * sine
        axial += drag
        moment += lift * sine + drag * (skirt.radius * sine - skirt.pin_offset)
    return lateral, axial, moment


@compiled
def by_rows(field):
    """The transpose (a, c), contiguous."""
    out = np.empty((field.shape[1], field.shape[0]))
    for i in range(field.shape[0]):
        for j in range(field.shape[1]):
            out[j, i] = field[i, j]
    return out


@compiled
def subtract(a, b):
    """a -= b, in a loop: array expressions take the compiler seconds each."""
    for k in range(len(a)):
        a[k] -= b[k]


@compiled
def film_now(skirt, bore, window, forces, height_rate, guided_rate, place, rate):
    """Film thickness and sliding velocity at an instant, and the power of the interface forces at
    the grid points.

    Parameters
    ----------
    skirt : Skirt
    bore : Bore
    window : Window
    forces : tuple of ndarray, shape (c, a)
        Pressure and friction forces [N].
    height_rate, guided_rate : float
        Velocity of A, and of the height at which the bore is read [m/s].
    place, rate : ndarray
        [x_A, rocking angle, piston then block modal coordinates] and rates.

    Returns
    -------
    film_thickness, sliding_velocity : ndarray, shape (c, a)
        [m], [m/s]
    lift : float
        Force on the piston along y by pressure on a bore that is not straight: sum F dh/dY [N].
    power, size : float
        sum F dh/dt + sum f v, and the sum of the absolute values of its terms [W].
    """
    pressure_force, friction_force = forces
    n = 2 + skirt.radial.modes
    velocity = sliding(skirt, bore, window, height_rate, rate[1], rate[2:n], rate[n:])
    inner, inner_rate = read_both(skirt.radial, 0, skirt.gap.shape[1], place[2:n], rate[2:n])
    surface, surface_rate = read_both(bore.radial, window.first, window.knots, place[n:], rate[n:])
    opening_rate = _opening(
        skirt, rate[0], rate[1], inner_rate, on_rows(window, window.value, surface_rate)
    )
    if len(bore.shape):
        for k in range(window.knots):
            for i in range(surface.shape[1]):
                surface[k, i] += bore.shape[window.first + k, i]
    thickness = _opening(skirt, place[0], place[1], inner, on_rows(window, window.value, surface))
    slope = by_rows(on_rows(window, window.slope, surface))  # of the bore, under the moving skirt
    lift, power, size = 0.0, 0.0, 0.0
    for i in range(len(thickness)):
        for j in range(thickness.shape[1]):
            thickness[i, j] += skirt.gap[i, j]
        line = _work(
            pressure_force[i],
            friction_force[i],
            opening_rate[i],
            velocity[i],
            slope[i],
            guided_rate,
        )
        lift, power, size = lift + line[0], power + line[1], size + line[2]
    return thickness, velocity, lift, power, size


@compiled
def _work(push, drag, opening_rate, velocity, slope, guided_rate):
    """A line's share of lift, power and size, see `film_now`."""
    lift, power, size = 0.0, 0.0, 0.0
    for j in range(len(push)):
        first, second = push[j] * (opening_rate[j] + guided_rate * slope[j]), drag[j] * velocity[j]
        lift += push[j] * slope[j]
        power += first + second
        size += abs(first) + abs(second)
    return lift, power, size
