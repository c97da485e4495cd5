"""Films of a pin that turns in a shell: thickness and velocity from where it stands and how it
turns, and forces back on pin and shell.

Points (i, j) of the grid rest on the shell; arrays are (n_circumferential, n_axial). i counts from
the shell's own +x towards its +y, about +z: a = 2 pi (i - 1)/n. The pin does not move along the
shell. It stays parallel to it, or tilts and bends by shapes of its axis, which are read row by row.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from .arrays import Matrix, Vector
from .film import subtract

PIN_SURFACES = ("boss_left", "boss_right", "small_end")
"""Film surfaces of a floating pin: bosses, then the rod's eye."""

CRANK_SURFACES = ("big_end", "main_bearing")
"""Film surfaces of a crank that may come with them: its pin in the rod's big end, its journal in
the block; each a `PinSurface` likewise.
"""


class ShellModes(NamedTuple):
    """How a shell yields, by k modes of its body; k = 0: it is rigid.

    Parameters
    ----------
    outward, onward : ndarray, shape (cells, k)
        Displacement along e and t at the grid's points, j fastest [kg^-1/2].
    slope : ndarray, shape (cells, k)
        d outward/da, by central differences around [kg^-1/2].
    """

    outward: Matrix
    onward: Matrix
    slope: Matrix


class Yielding(NamedTuple):
    """Where a shell yields and how fast: modal coordinates and velocities, (k,)."""

    position: np.ndarray
    velocity: np.ndarray


class Bent(NamedTuple):
    """How a pin tilts and bends, and how fast: coordinates of its n shapes along x and y [m], and
    their velocities [m/s], (n, 2).
    """

    position: np.ndarray
    velocity: np.ndarray


PARALLEL = np.zeros((0, 2))
"""Coordinates of a pin without shapes, or forces on them."""


class PinSurface(NamedTuple):
    """A pin in a shell, on a grid of (c, a) cells around and along it.

    Parameters
    ----------
    outward, onward : ndarray, shape (2, c)
        Across the film and along it, in the shell's axes: (cos a, sin a), (-sin a, cos a).
    radius : float
        Of the pin [m].
    clearance : ndarray, shape (a,)
        Radius of the shell minus that of the pin, by row [m].
    modes : ShellModes
        None of a rigid shell.
    axis : ndarray, shape (a, n)
        Values psi of the pin's shapes at the grid's rows [-]; none where it stays parallel to the
        shell.
    """

    outward: Matrix
    onward: Matrix
    radius: float
    clearance: Vector
    modes: ShellModes
    axis: Matrix


class PinForces(NamedTuple):
    """Of the film on its grid, shape (c, a), or stacked: pushing pin and shell apart, and around,
    on the pin with ascending i [N].
    """

    pressure: np.ndarray
    circumferential: np.ndarray


class PinResultants(NamedTuple):
    """What a film does to pin and shell.

    Parameters
    ----------
    force : ndarray, shape (2,)
        On the pin, in space; its opposite acts on the shell [N].
    on_pin, on_shell : float
        Moments about the pin's axis and about the shell's, about +z [N m].
    on_shapes : ndarray, shape (n, 2)
        Forces on the pin's shapes, along x and y in space [N].
    """

    force: np.ndarray
    on_pin: float
    on_shell: float
    on_shapes: np.ndarray = PARALLEL


class FilmPower(NamedTuple):
    """Power of a film, and the sum of the absolute values of its terms [W]."""

    power: float
    size: float


def shell_angles(around: int) -> np.ndarray:
    """Angles of the grid's lines from the shell's own +x about +z, (around,) [rad]."""
    return 2 * np.pi * np.arange(around) / around


def shell_modes(outward: np.ndarray, onward: np.ndarray) -> ShellModes:
    """Modes of a shell, given on its grid, (c, a, k)."""
    around, along, k = outward.shape
    step = 2 * np.pi / around
    slope = (np.roll(outward, -1, axis=0) - np.roll(outward, 1, axis=0)) / (2 * step)
    flat = (one.reshape(around * along, k) for one in (outward, onward, slope))
    return ShellModes(*(np.ascontiguousarray(one) for one in flat))


def pin_surface(
    radius: float,
    clearance: float | np.ndarray,
    shape: tuple[int, int],
    modes: ShellModes | None = None,
    axis: np.ndarray | None = None,
) -> PinSurface:
    """Film surface on a grid (c, a); `clearance` even or by row, no modes: a rigid shell, no axis:
    the pin stays parallel to it.
    """
    around, along = shape
    angle = shell_angles(around)
    outward = np.array([np.cos(angle), np.sin(angle)])
    onward = np.array([-np.sin(angle), np.cos(angle)])
    if modes is None:
        modes = ShellModes(*[np.zeros((around * along, 0))] * 3)
    if axis is None:
        axis = np.zeros((along, 0))
    by_row = np.broadcast_to(np.asarray(clearance, dtype=float), along).copy()
    return PinSurface(outward, onward, float(radius), by_row, modes, np.ascontiguousarray(axis))


def relieved(
    clearance: float | np.ndarray, relief: float, rows: np.ndarray, length: float
) -> np.ndarray:
    """Clearance of a shell that widens towards its ends, by row.

    Eq. (H12):  c(z) = c + r (2 (z - z_0)/L)^2      z_0 its middle, L its length

    Parameters
    ----------
    clearance : float or ndarray, shape (a,)
        c amid, even or by row [m].
    relief : float
        r, by which it is more at the ends [m].
    rows : ndarray, shape (a,)
        z of the grid's rows [m].
    length : float
        L [m].

    Returns
    -------
    ndarray, shape (a,)
        [m]
    """
    return clearance + relief * (2 * (rows - rows.mean()) / length) ** 2  # Eq. (H12)


@compilable
def turned(angle: float) -> np.ndarray:
    """Matrix, (2, 2), that takes components in axes turned by an angle [rad] to space."""
    return axes_of(np.cos(angle), np.sin(angle))


@compilable
def axes_of(cosine: float, sine: float) -> np.ndarray:
    """The matrix of `turned`, of an angle's cosine and sine."""
    out = np.empty((2, 2))
    out[0, 0] = cosine
    out[0, 1] = -sine
    out[1, 0] = sine
    out[1, 1] = cosine
    return out


@compilable
def pair(x: float, y: float) -> np.ndarray:
    """A vector in the plane, (2,)."""
    out = np.empty(2)
    out[0] = x
    out[1] = y
    return out


@compilable
def across(vector: np.ndarray) -> np.ndarray:
    """Z v, a vector turned by a quarter about +z."""
    return pair(-vector[1], vector[0])


@compilable
def cross(a: np.ndarray, b: np.ndarray) -> float:
    """a x b about +z."""
    return a[0] * b[1] - a[1] * b[0]


@compilable
def in_space(axes: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """R v: from axes of `turned` to space."""
    return pair(
        axes[0, 0] * vector[0] + axes[0, 1] * vector[1],
        axes[1, 0] * vector[0] + axes[1, 1] * vector[1],
    )


@compilable
def in_axes(axes: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """R^T v: from space into axes of `turned`."""
    return pair(
        axes[0, 0] * vector[0] + axes[1, 0] * vector[1],
        axes[0, 1] * vector[0] + axes[1, 1] * vector[1],
    )


@compilable
def opening_of(surface: PinSurface, place: np.ndarray) -> np.ndarray:
    """What the pin's place adds to the film thickness.

    Eq. (H6):  h = c - d . e      d = R(chi)^T (P - C), from the shell's axis C to the pin's P in
                                  the axes of the shell, which has turned by chi; e = (cos a, sin a)

    Eq. (H7):  W = R (phi' - chi')      circumferential velocity of the pin's surface; R times what
                                        the pin turns faster than its shell

    Of first order in d/R. Linear: with changes of d it gives those of h.

    Parameters
    ----------
    surface : PinSurface
    place : ndarray, shape (2,)
        d [m].

    Returns
    -------
    ndarray, shape (c, a)
        h - c [m].
    """
    around = surface.outward.shape[1]
    along = len(surface.clearance)
    out = np.empty((around, along))
    for i in range(around):
        # Eq. (H6)
        opened = -(place[0] * surface.outward[0, i] + place[1] * surface.outward[1, i])
        for j in range(along):
            out[i, j] = opened
    return out


@compilable
def row_of(surface: PinSurface, shapes: np.ndarray, j: int) -> np.ndarray:
    """sum_k psi_kj s_k of the shapes' coordinates (n, 2) at row j, (2,)."""
    x = 0.0
    y = 0.0
    for k in range(surface.axis.shape[1]):
        x += surface.axis[j, k] * shapes[k, 0]
        y += surface.axis[j, k] * shapes[k, 1]
    return pair(x, y)


@compilable
def leaning(surface: PinSurface, shapes: np.ndarray) -> np.ndarray:
    """What the pin's tilt and bending add to the film thickness, or to its change in time.

    Eq. (H11):  d_j = d + sum_k psi_kj s_k      in place of d in Eq. (H6), row by row

    Parameters
    ----------
    surface : PinSurface
    shapes : ndarray, shape (n, 2)
        s in the axes of the shell [m], or its change.

    Returns
    -------
    ndarray, shape (c, a)
        [m]
    """
    around = surface.outward.shape[1]
    along = len(surface.clearance)
    out = np.zeros((around, along))
    if surface.axis.shape[1] == 0:
        return out
    for j in range(along):
        aside = row_of(surface, shapes, j)
        for i in range(around):
            # Eq. (H11)
            out[i, j] = -(aside[0] * surface.outward[0, i] + aside[1] * surface.outward[1, i])
    return out


@compilable
def yielded(surface: PinSurface, modal: np.ndarray) -> np.ndarray:
    """What the shell's yielding adds to the film thickness, or to its change in time.

    Eq. (H8):  h = c - d . e + u_e,   u_e = sum_k Phi_ek q_k

    Parameters
    ----------
    surface : PinSurface
    modal : ndarray, shape (k,)
        q [kg^1/2 m], or its change; not looked at for a rigid shell.

    Returns
    -------
    ndarray, shape (c, a)
        [m]
    """
    around = surface.outward.shape[1]
    along = len(surface.clearance)
    if surface.modes.outward.shape[1] == 0:
        return np.zeros((around, along))
    return (surface.modes.outward @ modal).reshape((around, along))  # Eq. (H8)


@compilable
def modal_push(surface: PinSurface, forces: PinForces) -> np.ndarray:
    """Forces of a film on its shell's modes by virtual work, (k,) [kg^-1/2 N].

    Eq. (G6):  Q_k = sum p Phi_ek - sum f Phi_tk
    """
    cells, k = surface.modes.outward.shape
    if k == 0:
        return np.zeros(0)
    # Eq. (G6)
    push = forces.pressure.reshape(cells) @ surface.modes.outward
    subtract(push, forces.circumferential.reshape(cells) @ surface.modes.onward)
    return push


@compilable
def slope_push(surface: PinSurface, pressure: np.ndarray) -> np.ndarray:
    """Moment of pressure on the pin about +z, by modal coordinate, (k,) [kg^-1/2 N].

    Eq. (G5):  M_pin = .. + sum p du_e/da,   M_shell = .. - sum p du_e/da

    Pressure stands upright on a shell that is not round any more, and so has a moment about its
    axis; what is left of the film's balance about it acts on the pin, as in Eq. (G3).
    """
    cells, k = surface.modes.slope.shape
    if k == 0:
        return np.zeros(0)
    return pressure.reshape(cells) @ surface.modes.slope  # Eq. (G5)


@compilable
def with_slopes(found: PinResultants, moment: float) -> PinResultants:
    """Resultants with the moment of pressure by the slopes of a yielding shell (Eq. (G5)) [N m]."""
    on_pin = found.on_pin + moment
    return PinResultants(found.force, on_pin, found.on_shell - moment, found.on_shapes)


@compilable
def resultants_on(
    surface: PinSurface,
    forces: PinForces,
    place: np.ndarray,
    axes: np.ndarray,
    shapes: np.ndarray = PARALLEL,
) -> PinResultants:
    """What a film does to pin and shell.

    Eq. (G3):  F = R(chi) sum (-p e + f t),   M_shell = -R sum f,   M_pin = R sum f - d x F
               t = (-sin a, cos a)
    Eq. (G8):  Q_k = sum_j psi_kj F_j,   M_pin = .. - sum_k s_k x Q_k      F_j: F of row j

    f is the opposite of the shear on the shell, about whose axis pressure has no moment: what is
    left of the film's balance about it acts on the pin, with the lever of its force.

    Parameters
    ----------
    surface : PinSurface
    forces : PinForces
        p and f of each cell.
    place : ndarray, shape (2,)
        P - C in space [m].
    axes : ndarray, shape (2, 2)
        R(chi), of `turned`.
    shapes : ndarray, shape (n, 2)
        s_k in space [m].
    """
    around = surface.outward.shape[1]
    along = len(surface.clearance)
    n = surface.axis.shape[1]
    pushes = forces.pressure.reshape((around, along))
    drags = forces.circumferential.reshape((around, along))
    x = 0.0
    y = 0.0
    around_all = 0.0
    for i in range(around):
        push = 0.0
        drag = 0.0
        for j in range(along):
            push += pushes[i, j]
            drag += drags[i, j]
        x += surface.onward[0, i] * drag - surface.outward[0, i] * push
        y += surface.onward[1, i] * drag - surface.outward[1, i] * push
        around_all += drag
    # Eq. (G3)
    force = in_space(axes, pair(x, y))
    on_shell = -surface.radius * around_all
    on_pin = -on_shell - cross(place, force)
    on_shapes = np.zeros((n, 2))
    lever = 0.0
    if n > 0:
        for j in range(along):
            x = 0.0
            y = 0.0
            for i in range(around):
                x += surface.onward[0, i] * drags[i, j] - surface.outward[0, i] * pushes[i, j]
                y += surface.onward[1, i] * drags[i, j] - surface.outward[1, i] * pushes[i, j]
            row = in_space(axes, pair(x, y))
            for k in range(n):
                # Eq. (G8)
                on_shapes[k, 0] += surface.axis[j, k] * row[0]
                on_shapes[k, 1] += surface.axis[j, k] * row[1]
        for k in range(n):
            lever += cross(shapes[k], on_shapes[k])
    return PinResultants(force, on_pin - lever, on_shell, on_shapes)


def grid_power(
    surface: PinSurface,
    forces: PinForces,
    place: np.ndarray,
    velocity: np.ndarray,
    turning: float,
    yielding: Yielding | None = None,
    bent: Bent | None = None,
) -> FilmPower:
    """`power_on_grid`; without `yielding` or `bent` the shell does not yield, the pin not bend."""
    if yielding is None:
        yielding = Yielding(*[np.zeros(surface.modes.outward.shape[1])] * 2)
    if bent is None:
        bent = Bent(*[np.zeros((surface.axis.shape[1], 2))] * 2)
    return power_on_grid(surface, forces, place, velocity, turning, yielding, bent)


@compilable
def power_on_grid(
    surface: PinSurface,
    forces: PinForces,
    place: np.ndarray,
    velocity: np.ndarray,
    turning: float,
    yielding: Yielding,
    bent: Bent,
) -> FilmPower:
    """Power of the film on pin and shell, from what every cell sees.

    Eq. (G4):  P = sum p (dh/dt + w dh/da) + sum f ((R - d . e) w + t . d' - u_t')
               w = phi' - chi'

    Pressure works on the normal velocity of the pin's surface, which turning adds to where the film
    is not even; f on its tangential one.

    Parameters
    ----------
    surface : PinSurface
    forces : PinForces
    place, velocity : ndarray, shape (2,)
        d and d' in the axes of the shell [m], [m/s].
    turning : float
        w [rad/s].
    yielding : Yielding
        Of a shell with modes.
    bent : Bent
        Of a pin with shapes, in the axes of the shell; d is d_j then (Eq. (H11)).

    Returns
    -------
    FilmPower
    """
    around = surface.outward.shape[1]
    along = len(surface.clearance)
    pushes = forces.pressure.reshape((around, along))
    drags = forces.circumferential.reshape((around, along))
    power = 0.0
    size = 0.0
    # Eq. (G4)
    for i in range(around):
        push = 0.0
        drag = 0.0
        for j in range(along):
            push += pushes[i, j]
            drag += drags[i, j]
        e_x = surface.outward[0, i]
        e_y = surface.outward[1, i]
        t_x = surface.onward[0, i]
        t_y = surface.onward[1, i]
        closing = -(velocity[0] * e_x + velocity[1] * e_y)
        closing -= turning * (place[0] * t_x + place[1] * t_y)
        arm = surface.radius - (place[0] * e_x + place[1] * e_y)
        onward = turning * arm + velocity[0] * t_x + velocity[1] * t_y
        power += push * closing + drag * onward
        size += abs(push * closing) + abs(drag * onward)
    if surface.modes.outward.shape[1] > 0:
        opening = surface.modes.outward @ yielding.velocity
        slope = surface.modes.slope @ yielding.position
        moved = surface.modes.onward @ yielding.velocity
        for i in range(around):
            for j in range(along):
                m = i * along + j
                normal = pushes[i, j] * (opening[m] + turning * slope[m])
                tangential = -drags[i, j] * moved[m]
                power += normal + tangential
                size += abs(normal) + abs(tangential)
    if surface.axis.shape[1] > 0:
        for j in range(along):
            aside = row_of(surface, bent.position, j)
            moving = row_of(surface, bent.velocity, j)
            for i in range(around):
                e_x = surface.outward[0, i]
                e_y = surface.outward[1, i]
                t_x = surface.onward[0, i]
                t_y = surface.onward[1, i]
                closing = -(moving[0] * e_x + moving[1] * e_y)
                closing -= turning * (aside[0] * t_x + aside[1] * t_y)
                onward = moving[0] * t_x + moving[1] * t_y
                onward -= turning * (aside[0] * e_x + aside[1] * e_y)
                power += pushes[i, j] * closing + drags[i, j] * onward
                size += abs(pushes[i, j] * closing) + abs(drags[i, j] * onward)
    return FilmPower(power, size)


@compilable
def diameters(opened: np.ndarray) -> tuple[float, float]:
    """By how much a shell is wider along its own x and y, amid its length, from what it yields by,
    (c, a).

    Eq. (H13):  D(a) = u(a) + u(a + pi),   u linear between the grid's lines and rows
    """
    east = _amid(opened, 0.0)
    north = _amid(opened, 0.25)
    west = _amid(opened, 0.5)
    south = _amid(opened, 0.75)
    return east + west, north + south  # Eq. (H13)


@compilable
def _amid(opened, turn):
    """Value amid the length, at a share of a turn."""
    around, along = opened.shape
    line = int(np.floor(turn * around))
    share = turn * around - line
    one = (opened[line, (along - 1) // 2] + opened[line, along // 2]) / 2
    after = (line + 1) % around
    other = (opened[after, (along - 1) // 2] + opened[after, along // 2]) / 2
    return (1 - share) * one + share * other
