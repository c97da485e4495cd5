"""Geometry of the film on the skirt: thickness, sliding velocity, and forces by virtual work.

Points (i, j) of the grid move with the skirt; arrays are (n_circumferential, n_axial). theta is the
angle from +z towards +x. Modal fields have heights as rows and angles as columns.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from .arrays import Matrix
from .modal_field import ModalField, modal_field, read, read_both, spread

NO_TEMPERATURE = np.zeros((0, 0))
"""Temperature field of a wall without one."""


class Skirt(NamedTuple):
    """Skirt side of the film, c x a grid cells.

    They are the film, n = c, or half of it, n > c. The normal and axial forces on a cell of half a
    film are the sums over the cell and its mirror image. Sums over all cells are then those of the
    film.

    Parameters
    ----------
    angle : ndarray, shape (c,)
        theta [rad].
    height : ndarray, shape (a,)
        y' above A [m].
    gap : ndarray, shape (c, a)
        Clearance and profile: film thickness of the concentric, undeformed skirt [m].
    radius, pin_offset : float
        Skirt radius; x of A from the skirt's axis [m].
    radial, axial : ModalField
        Modal displacement outwards and along y at the grid points, with a rows.
    rows : ndarray, shape (n,)
        Row of the grid for each row of the film.
    temperature : ndarray, shape (c, a)
        Difference of the wall's temperature from its level; no rows if it is not given [K].
    """

    angle: Annotated[np.ndarray, "c"]
    height: Annotated[np.ndarray, "a"]
    gap: Annotated[np.ndarray, "c, a"]
    radius: float
    pin_offset: float
    radial: ModalField
    axial: ModalField
    rows: Annotated[np.ndarray, "n"]
    temperature: Matrix = NO_TEMPERATURE


class BoreSplines(NamedTuple):
    """Bore side of the film: its modes as uniform cubic B-splines in height.

    Parameters
    ----------
    lowest, spacing : float
        Height of the first coefficient's knot and distance of knots [m].
    radial, axial : ModalField
        Spline coefficients at the angles of the grid, one row for each knot.
    shape : ndarray, shape (knots, c)
        Spline coefficients of the undeformed bore's widening; no rows for a cylinder [m].
    temperature : ndarray, shape (knots, c)
        Spline coefficients of the difference of the wall's temperature from its level, as of
        `Skirt` [K].
    """

    lowest: float
    spacing: float
    radial: ModalField
    axial: ModalField
    shape: Matrix
    temperature: Matrix = NO_TEMPERATURE


class FilmSurface(NamedTuple):
    """Film surface: a part of the piston with its own film in the bore."""

    skirt: Skirt
    bore: BoreSplines


class NodalForces(NamedTuple):
    """Forces at the cells of the film grid.

    Parameters
    ----------
    pressure, friction : ndarray, shape (c, a)
        Force that separates the surfaces, and force along y on the skirt [N].
    """

    pressure: np.ndarray
    friction: np.ndarray


class FilmForces(NamedTuple):
    """Generalised forces of the film.

    Parameters
    ----------
    axial : float
        On the piston along y [N].
    push : ndarray, shape (2 + k + k',)
        On x_A [N], the rocking angle [N m], modes of piston and block [kg^-1/2 N].
    """

    axial: float
    push: np.ndarray


class SlopePush(NamedTuple):
    """Axial force of a film on the slopes of the bore, Eq. (H24).

    Parameters
    ----------
    undeformed : float
        On the undeformed bore [N].
    modal : ndarray, shape (k',)
        By the modes of the block [kg^-1/2 N/m].
    """

    undeformed: float
    modal: np.ndarray


class Window(NamedTuple):
    """Part of the bore that faces the skirt at a given height of A.

    Parameters
    ----------
    first, knots : int
        First knot of the splines in use, and number of knots.
    knot : ndarray of int, shape (a,)
        First of the four knots of each grid row, counted from `first`.
    value, slope : ndarray, shape (a, 4)
        Weights of these knots for the spline [-] and for its slope in height [1/m].
    """

    first: int
    knots: int
    knot: np.ndarray
    value: np.ndarray
    slope: np.ndarray


class FilmState(NamedTuple):
    """Geometry of the film at an instant, and power of the forces on it.

    Parameters
    ----------
    film_thickness, sliding_velocity : ndarray, shape (c, a)
        [m], [m/s]
    axial_force : float
        Force on the piston along y by pressure on a bore that is not straight: sum F dh/dY [N].
    power, power_size : float
        sum F dh/dt + sum f v, and the sum of the absolute values of its terms [W].
    """

    film_thickness: np.ndarray
    sliding_velocity: np.ndarray
    axial_force: float
    power: float
    power_size: float


def bore_splines(
    heights: np.ndarray,
    radial: np.ndarray,
    axial: np.ndarray,
    kind: np.ndarray | None = None,
    shape: np.ndarray | None = None,
    temperature: np.ndarray = NO_TEMPERATURE,
) -> BoreSplines:
    """Return the cubic spline through tabulated bore modes.

    Eq. (H3):  (c_(i-1) + 4 c_i + c_(i+1))/6 = value_i, second derivative zero at both ends

    It is twice continuously differentiable in height, so the film of a moving skirt has no kinks.

    Parameters
    ----------
    heights : ndarray, shape (s,)
        Equally spaced [m].
    radial, axial : ndarray, shape (c, s, k)
    kind : ndarray of int, shape (k,), optional
        Symmetry classes of the modes.
    shape : ndarray, shape (c, s), optional
        Widening of the undeformed bore [m].
    temperature : ndarray, shape (c, s), optional
        As of `BoreSplines`, at these heights [K].

    Returns
    -------
    BoreSplines
    """
    inverse = knot_rule(len(heights))
    if shape is not None and (shape.any() or temperature.size):
        widening = np.ascontiguousarray(inverse @ shape.T)
    else:
        widening = np.zeros((0, len(radial)))
    spacing = float(heights[1] - heights[0])
    return BoreSplines(
        lowest=float(heights[0]) - spacing,
        spacing=spacing,
        radial=modal_field(np.einsum("rs,csk->crk", inverse, radial), kind),
        axial=modal_field(np.einsum("rs,csk->crk", inverse, axial), kind),
        shape=widening,
        temperature=np.ascontiguousarray(inverse @ temperature.T)
        if temperature.size
        else temperature,
    )


def knot_rule(stations: int) -> np.ndarray:
    """Return the matrix from values to spline coefficients, (stations + 2, stations), Eq. (H3)."""
    s = stations
    straight = [1.0, -2.0, 1.0]
    rule = np.zeros((s + 2, s + 2))
    rule[0, :3] = straight
    rule[-1, -3:] = straight
    for i in range(s):
        rule[i + 1, i : i + 3] = 1 / 6, 4 / 6, 1 / 6  # Eq. (H3)
    return np.linalg.inv(rule)[:, 1:-1]


@compiled
def window_at(lowest: float, spacing: float, height_of_A: float, rows: np.ndarray) -> Window:
    """Return the positions of the skirt's grid rows on the bore's splines.

    Eq. (H5):  b_0 = (1 - t)^3/6,  b_1 = (4 - 6 t^2 + 3 t^3)/6
               b_2 = (1 + 3 t + 3 t^2 - 3 t^3)/6,  b_3 = t^3/6       t: from one knot to the next

    Parameters
    ----------
    lowest, spacing : float
        As of `BoreSplines` [m].
    height_of_A : float
        Above the crank axis [m].
    rows : ndarray, shape (a,)
        Heights of the grid rows above A, ascending [m].

    Returns
    -------
    Window
    """
    a = len(rows)
    first = int(np.floor((height_of_A + rows[0] - lowest) / spacing)) - 1
    knot = np.empty(a, np.int64)
    value = np.empty((a, 4))
    slope = np.empty((a, 4))
    for j in range(a):
        x = (height_of_A + rows[j] - lowest) / spacing
        k = int(np.floor(x))
        t = x - k
        knot[j] = k - 1 - first
        # Eq. (H5)
        values = (
            (1 - t) ** 3 / 6,
            (4 - 6 * t * t + 3 * t**3) / 6,
            (1 + 3 * t + 3 * t * t - 3 * t**3) / 6,
            t**3 / 6,
        )
        slopes = (
            -((1 - t) ** 2) / (2 * spacing),
            (3 * t * t - 4 * t) / (2 * spacing),
            (1 + 2 * t - 3 * t * t) / (2 * spacing),
            t * t / (2 * spacing),
        )
        for m in range(4):
            value[j, m] = values[m]
            slope[j, m] = slopes[m]
    return Window(first, knot[a - 1] + 4, knot, value, slope)


@compiled
def on_rows(window: Window, weight: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """Return values at the grid rows, (a, c), from spline coefficients at the window's knots.

    knots : (knots, c). weight : `window.value` or `window.slope`.
    """
    a = len(window.knot)
    c = knots.shape[1]
    out = np.empty((a, c))
    for j in range(a):
        k = window.knot[j]
        for i in range(c):
            total = weight[j, 0] * knots[k, i]
            for m in range(1, 4):
                total += weight[j, m] * knots[k + m, i]
            out[j, i] = total
    return out


@compiled
def on_knots(window: Window, weight: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Return forces on the window's knots, (knots, c), from forces (a, c) at the grid rows.

    It is the transpose of `on_rows`, with its `weight`.
    """
    out = np.zeros((window.knots, force.shape[1]))
    for j in range(len(window.knot)):
        for m in range(4):
            share = weight[j, m]
            k = window.knot[j] + m
            for i in range(force.shape[1]):
                out[k, i] += share * force[j, i]
    return out


@compiled
def on_bore(bore: BoreSplines, window: Window, weight: np.ndarray, knots: np.ndarray) -> np.ndarray:
    """Return `on_rows` of a field of the bore, zeros if no shape and no mode deforms it."""
    if len(bore.shape) == 0 and len(bore.radial.table) == 0:
        return np.zeros((len(window.knot), knots.shape[1]))
    return on_rows(window, weight, knots)


@compiled
def opening(
    skirt: Skirt,
    bore: BoreSplines,
    window: Window,
    lateral: float,
    angle: float,
    piston: np.ndarray,
    block: np.ndarray,
) -> np.ndarray:
    """Return the change of the film thickness by motion and deformation.

    Eq. (H1):  h = h_0(theta, y') - (x_A - beta y') sin theta - u_r(skirt) + w_r(bore)
               h_0 the gap of undeformed, concentric bodies, the bore read at Y_0(phi) + y'

    It is linear in the small motions, so that velocities give the rate of change. The bore is read
    at the height of A for x_A = 0. The error is less than x_A r/L, micrometres on a field that
    varies over millimetres.

    Parameters
    ----------
    skirt : Skirt
    bore : BoreSplines
    window : Window
    lateral, angle : float
        x_A [m] and rocking angle beta [rad].
    piston, block : ndarray, shapes (k,), (k',)
        Modal coordinates [kg^1/2 m].

    Returns
    -------
    ndarray, shape (c, a)
        [m]
    """
    inner = read(skirt.radial, 0, skirt.gap.shape[1], piston)
    knots = read(bore.radial, window.first, window.knots, block)
    outer = on_bore(bore, window, window.value, knots)
    return _opening(skirt, lateral, angle, inner, outer)


@compiled
def _opening(skirt, lateral, angle, inner, outer):
    """Return Eq. (H1) without the gap for displacements of skirt and bore on the rows, (a, c)."""
    c, a = skirt.gap.shape
    out = np.empty((c, a))
    for i in range(c):
        sine = np.sin(skirt.angle[i])
        for j in range(a):
            rigid = (angle * skirt.height[j] - lateral) * sine
            out[i, j] = rigid - inner[j, i] + outer[j, i]  # Eq. (H1)
    return out


@compiled
def sliding(
    skirt: Skirt,
    bore: BoreSplines,
    window: Window,
    axial_velocity: float,
    angular_velocity: float,
    piston: np.ndarray,
    block: np.ndarray,
) -> np.ndarray:
    """Return the axial velocity of the skirt minus that of the bore.

    Eq. (H2):  v = Y_A' + beta' (R sin theta - pin offset) + u_y'(skirt) - w_y'(bore)

    Parameters
    ----------
    skirt : Skirt
    bore : BoreSplines
    window : Window
    axial_velocity, angular_velocity : float
        Velocity of A along y [m/s] and of the rocking angle [rad/s].
    piston, block : ndarray, shapes (k,), (k',)
        Modal velocities [kg^1/2 m/s].

    Returns
    -------
    ndarray, shape (c, a)
        [m/s]
    """
    c, a = skirt.gap.shape
    inner = read(skirt.axial, 0, a, piston)
    knots = read(bore.axial, window.first, window.knots, block)
    outer = on_bore(bore, window, window.value, knots)
    out = np.empty((c, a))
    for i in range(c):
        arm = skirt.radius * np.sin(skirt.angle[i]) - skirt.pin_offset
        rigid = axial_velocity + angular_velocity * arm
        for j in range(a):
            out[i, j] = rigid + inner[j, i] - outer[j, i]  # Eq. (H2)
    return out


@compiled
def generalised(
    skirt: Skirt,
    bore: BoreSplines,
    window: Window,
    forces: NodalForces,
    sliding_modes: bool = True,
) -> FilmForces:
    """Return the forces on the coordinates by virtual work: Q_k = sum F dh/dq_k + sum f dv/dq'_k.

    Parameters
    ----------
    skirt : Skirt
    bore : BoreSplines
    window : Window
    forces : NodalForces
    sliding_modes : bool
        Whether the sliding velocity of modes counts. An inexact derivative omits it.

    Returns
    -------
    FilmForces
    """
    push = by_rows(forces.pressure)
    drag = by_rows(forces.friction)
    piston = np.zeros(len(skirt.axial.table))
    if sliding_modes:
        piston = spread(skirt.axial, 0, drag)
    subtract(piston, spread(skirt.radial, 0, push))
    block = np.zeros(0)
    if len(bore.radial.table) > 0:
        block = spread(bore.radial, window.first, on_knots(window, window.value, push))
    if len(bore.radial.table) > 0 and sliding_modes:
        on_axial = on_knots(window, window.value, drag)
        subtract(block, spread(bore.axial, window.first, on_axial))
    out = np.concatenate((np.zeros(2), piston, block))
    return FilmForces(write_resultants(skirt, forces, out), out)


@compiled
def slope_push(bore: BoreSplines, window: Window, pressure: np.ndarray) -> SlopePush:
    """Return the axial force of pressure (c, a) on the slopes of the bore.

    Eq. (H24):  F_s = sum_ij F_ij dw/dY      w the widening of the bore, linear in its modes
    """
    knots = on_knots(window, window.slope, by_rows(pressure))  # Eq. (H24)
    undeformed = 0.0
    if len(bore.shape):
        for row in range(len(knots)):
            for i in range(knots.shape[1]):
                undeformed += knots[row, i] * bore.shape[window.first + row, i]
    return SlopePush(undeformed, spread(bore.radial, window.first, knots))


@compiled
def write_resultants(skirt: Skirt, forces: NodalForces, push: np.ndarray) -> float:
    """Write lateral force and moment about A of the film into `push`, and return the axial force.

    Eq. (G1):  lateral = -sum F sin theta,  axial = sum f
               moment = sum (F y' sin theta + f (R sin theta - pin offset))
    """
    pressure = forces.pressure
    friction = forces.friction
    height = skirt.height
    lateral = 0.0
    axial = 0.0
    moment = 0.0
    for i in range(pressure.shape[0]):
        pressing = 0.0
        tilting = 0.0
        drag = 0.0
        for j in range(pressure.shape[1]):
            pressing += pressure[i, j]
            tilting += pressure[i, j] * height[j]
            drag += friction[i, j]
        # Eq. (G1)
        sine = np.sin(skirt.angle[i])
        lateral -= pressing * sine
        axial += drag
        moment += tilting * sine + drag * (skirt.radius * sine - skirt.pin_offset)
    push[0], push[1] = lateral, moment
    return axial


@compiled
def by_rows(field: np.ndarray) -> np.ndarray:
    """Return the contiguous transpose, (a, c)."""
    out = np.empty((field.shape[1], field.shape[0]))
    for i in range(field.shape[0]):
        for j in range(field.shape[1]):
            out[j, i] = field[i, j]
    return out


@compiled
def subtract(a: np.ndarray, b: np.ndarray) -> None:
    """Subtract b from a in place, in a loop, because array expressions compile slowly."""
    for k in range(len(a)):
        a[k] -= b[k]


@compiled
def film_now(
    skirt: Skirt,
    bore: BoreSplines,
    window: Window,
    forces: NodalForces,
    axial_velocity: float,
    guided_velocity: float,
    position: np.ndarray,
    velocity: np.ndarray,
) -> FilmState:
    """Return film thickness, sliding velocity and power of the interface forces at an instant.

    Parameters
    ----------
    skirt : Skirt
    bore : BoreSplines
    window : Window
    forces : NodalForces
    axial_velocity, guided_velocity : float
        Velocity of A, and of the height Y_0 at which the bore is read [m/s].
    position, velocity : ndarray, shape (2 + k + k',)
        [x_A, rocking angle, piston then block modal coordinates] and velocities.

    Returns
    -------
    FilmState
    """
    x = position[0]
    angle = position[1]
    q = position[2:]
    dx = velocity[0]
    turning = velocity[1]
    dq = velocity[2:]
    k = len(skirt.radial.table)
    a = skirt.gap.shape[1]
    sliding_velocity = sliding(skirt, bore, window, axial_velocity, turning, dq[:k], dq[k:])
    inner, inner_velocity = read_both(skirt.radial, 0, a, q[:k], dq[:k])
    surface, surface_velocity = read_both(bore.radial, window.first, window.knots, q[k:], dq[k:])
    outer_velocity = on_bore(bore, window, window.value, surface_velocity)
    opening_rate = _opening(skirt, dx, turning, inner_velocity, outer_velocity)
    if len(bore.shape):
        for row in range(window.knots):
            for i in range(surface.shape[1]):
                surface[row, i] += bore.shape[window.first + row, i]
    outer = on_bore(bore, window, window.value, surface)
    thickness = _opening(skirt, x, angle, inner, outer)
    slope = on_bore(bore, window, window.slope, surface)  # under the moving skirt
    axial_force = 0.0
    power = 0.0
    power_size = 0.0
    for i in range(len(thickness)):
        for j in range(thickness.shape[1]):
            thickness[i, j] += skirt.gap[i, j]
        lifting = 0.0
        working = 0.0
        size = 0.0
        for j in range(thickness.shape[1]):
            push = forces.pressure[i, j]
            normal = push * (opening_rate[i, j] + guided_velocity * slope[j, i])
            tangential = forces.friction[i, j] * sliding_velocity[i, j]
            lifting += push * slope[j, i]
            working += normal + tangential
            size += abs(normal) + abs(tangential)
        axial_force += lifting
        power += working
        power_size += size
    return FilmState(thickness, sliding_velocity, axial_force, power, power_size)
