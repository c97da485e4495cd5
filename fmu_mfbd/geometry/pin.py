"""Films of a pin that rotates in a shell: thickness, velocity, and forces on pin and shell.

Points (i, j) of the grid are fixed to the shell; arrays are (n_circumferential, n_axial). i counts
from the shell's own +x towards its +y, about +z: a = 2 pi (i - 1)/n. The pin does not move along
the shell. It is parallel to the shell, or tilts and bends by shapes of its axis, which have a value
for each row.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled

PIN_SURFACES = ("boss_left", "boss_right", "small_end")
"""Film surfaces of a floating pin: bosses, then the rod's eye."""

CRANK_SURFACES = ("big_end", "main_bearing")
"""Optional film surfaces of a crank: its pin in the rod's big end, and its journal in the block."""


class ShellModes(NamedTuple):
    """Modes of a shell's body; a rigid shell has k = 0 modes.

    Parameters
    ----------
    outward, onward : ndarray, shape (cells, k)
        Displacement along e and t at the grid's points, j fastest [kg^-1/2].
    """

    outward: Annotated[np.ndarray, "cells, k"]
    onward: Annotated[np.ndarray, "cells, k"]


class ModeMotion(NamedTuple):
    """Modal coordinates and their velocities.

    They are those of a shell, (k,), or of the shapes of a pin along x and y, (n, 2) [kg^1/2 m].
    """

    position: np.ndarray
    velocity: np.ndarray


PARALLEL = np.zeros((0, 2))
"""Coordinates of a pin without shapes, or forces on its shapes."""


class PinSurface(NamedTuple):
    """Pin in a shell, on a grid of (c, a) cells around and along it.

    Parameters
    ----------
    outward, onward : ndarray, shape (2, c)
        Directions across and along the film in the shell's axes: (cos a, sin a), (-sin a, cos a).
    radius : float
        Radius of the pin [m].
    clearance : ndarray, shape (a,)
        Radius of the shell minus that of the pin, by row [m].
    modes : ShellModes
        Modes of the shell; a rigid shell has none.
    axis : ndarray, shape (a, n)
        Values psi of the pin's shapes at the grid's rows [kg^-1/2]; a pin that is parallel to the
        shell has none.
    """

    outward: Annotated[np.ndarray, "2, c"]
    onward: Annotated[np.ndarray, "2, c"]
    radius: float
    clearance: Annotated[np.ndarray, "a"]
    modes: ShellModes
    axis: Annotated[np.ndarray, "a, n"]


class PinForces(NamedTuple):
    """Forces of the film on its grid, (c, a), or of several films.

    pressure : force that separates pin and shell [N].
    circumferential : force on the pin towards ascending i [N].
    """

    pressure: np.ndarray
    circumferential: np.ndarray


class PinResultants(NamedTuple):
    """Resultants of a film on pin and shell.

    Parameters
    ----------
    force : ndarray, shape (2,)
        Force on the pin in space; its opposite acts on the shell [N].
    on_pin, on_shell : float
        Moments about the pin's axis and about the shell's, about +z [N m].
    on_shapes : ndarray, shape (n, 2)
        Forces on the pin's shapes, along x and y in space [kg^-1/2 N].
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
    """Return the angles of the grid's lines from the shell's own +x about +z, (around,) [rad]."""
    return 2 * np.pi * np.arange(around) / around


def shell_modes(outward: np.ndarray, onward: np.ndarray) -> ShellModes:
    """Return the modes of a shell from their values on its grid, (c, a, k)."""
    around, along, k = outward.shape
    flat = (one.reshape(around * along, k) for one in (outward, onward))
    return ShellModes(*(np.ascontiguousarray(one) for one in flat))


def pin_surface(
    radius: float,
    clearance: float | np.ndarray,
    shape: tuple[int, int],
    modes: ShellModes | None = None,
    axis: np.ndarray | None = None,
) -> PinSurface:
    """Return a film surface on a grid (c, a).

    clearance : constant or by row. modes : default: rigid shell. axis : default: the pin is
    parallel to the shell.
    """
    around, along = shape
    angle = shell_angles(around)
    outward = np.array([np.cos(angle), np.sin(angle)])
    onward = np.array([-np.sin(angle), np.cos(angle)])
    if modes is None:
        modes = ShellModes(*[np.zeros((around * along, 0))] * 2)
    if axis is None:
        axis = np.zeros((along, 0))
    by_row = np.broadcast_to(np.asarray(clearance, dtype=float), along).copy()
    return PinSurface(
        outward=outward,
        onward=onward,
        radius=float(radius),
        clearance=by_row,
        modes=modes,
        axis=np.ascontiguousarray(axis),
    )


@compilable
def turned(angle: float) -> np.ndarray:
    """Return the matrix, (2, 2), from axes that are rotated by an angle [rad] to space."""
    return axes_of(np.cos(angle), np.sin(angle))


@compilable
def axes_of(cosine: float, sine: float) -> np.ndarray:
    """Return the matrix of `turned` for an angle's cosine and sine."""
    out = np.empty((2, 2))
    out[0, 0] = cosine
    out[0, 1] = -sine
    out[1, 0] = sine
    out[1, 1] = cosine
    return out


@compilable
def pair(x: float, y: float) -> np.ndarray:
    """Return a vector in the plane, (2,)."""
    out = np.empty(2)
    out[0] = x
    out[1] = y
    return out


@compilable
def across(vector: np.ndarray) -> np.ndarray:
    """Return Z v, a vector that is rotated by 90 deg about +z."""
    return pair(-vector[1], vector[0])


@compilable
def cross(a: np.ndarray, b: np.ndarray) -> float:
    """Return a x b about +z."""
    return a[0] * b[1] - a[1] * b[0]


@compilable
def in_space(axes: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return R v, a vector in space from its components in axes of `turned`."""
    return pair(
        axes[0, 0] * vector[0] + axes[0, 1] * vector[1],
        axes[1, 0] * vector[0] + axes[1, 1] * vector[1],
    )


@compilable
def in_axes(axes: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return R^T v, the components of a vector in axes of `turned`."""
    return pair(
        axes[0, 0] * vector[0] + axes[1, 0] * vector[1],
        axes[0, 1] * vector[0] + axes[1, 1] * vector[1],
    )


@compilable
def opening_of(surface: PinSurface, place: np.ndarray, shapes: np.ndarray = PARALLEL) -> np.ndarray:
    """Return the change of the film thickness by the pin, or its rate.

    Eq. (H6):  h = c - d . e      d = R(chi)^T (P - C), from the shell's axis C to the pin's P in
                                  the axes of the shell, rotated by chi; e = (cos a, sin a)

    Eq. (H7):  W = R (phi' - chi')      circumferential velocity of the pin's surface from its
                                        rotation relative to the shell

    Eq. (H11):  d_j = d + sum_k psi_kj s_k      replaces d in Eq. (H6) in each row

    It is of first order in d/R, and linear in d.

    Parameters
    ----------
    surface : PinSurface
    place : ndarray, shape (2,)
        d [m], or its rate [m/s].
    shapes : ndarray, shape (n, 2)
        s in the axes of the shell [kg^1/2 m], or its rate.

    Returns
    -------
    ndarray, shape (c, a)
        h - c [m], or its rate [m/s].
    """
    around = surface.outward.shape[1]
    along = len(surface.clearance)
    out = np.empty((around, along))
    for j in range(along):
        at = row_of(surface, place, shapes, j)
        for i in range(around):
            # Eq. (H6)
            out[i, j] = -(at[0] * surface.outward[0, i] + at[1] * surface.outward[1, i])
    return out


@compilable
def row_of(surface: PinSurface, place: np.ndarray, shapes: np.ndarray, j: int) -> np.ndarray:
    """Return d_j of Eq. (H11) at row j, (2,)."""
    x = place[0]
    y = place[1]
    for k in range(surface.axis.shape[1]):
        # Eq. (H11)
        x += surface.axis[j, k] * shapes[k, 0]
        y += surface.axis[j, k] * shapes[k, 1]
    return pair(x, y)


@compilable
def yielded(surface: PinSurface, modal: np.ndarray) -> np.ndarray:
    """Return the change of the film thickness by the shell's deformation, or its rate.

    Eq. (H8):  h = c - d . e + u_e,   u_e = sum_k Phi_ek q_k

    Parameters
    ----------
    surface : PinSurface
    modal : ndarray, shape (k,)
        q [kg^1/2 m], or its rate; not used for a rigid shell.

    Returns
    -------
    ndarray, shape (c, a)
        [m]
    """
    return on_cells(surface, surface.modes.outward, modal)  # Eq. (H8)


@compilable
def on_cells(surface: PinSurface, table: np.ndarray, modal: np.ndarray) -> np.ndarray:
    """Return what a table of the shell's modes gives in each cell, (c, a); 0 of a rigid shell."""
    shape = (surface.outward.shape[1], len(surface.clearance))
    return (table @ modal).reshape(shape) if table.shape[1] > 0 else np.zeros(shape)


@compilable
def around_slope(field: np.ndarray) -> np.ndarray:
    """Return d/da of a field on the grid by central differences around, (c, a)."""
    around, along = field.shape
    out = np.empty((around, along))
    factor = around / (4 * np.pi)
    for i in range(around):
        after = (i + 1) % around
        for j in range(along):
            out[i, j] = (field[after, j] - field[i - 1, j]) * factor
    return out


@compiled
def add_shell_pushes(
    modes: ShellModes,
    pressure: np.ndarray,
    turned: np.ndarray,
    drag: np.ndarray,
    push: np.ndarray,
    slopes: np.ndarray,
) -> None:
    """Add `shell_pushes` of forces in all cells, (cells,); `turned` is the slope of pressure."""
    for cell in range(len(pressure)):
        p, t, f = pressure[cell], turned[cell], drag[cell]
        outward, onward = modes.outward[cell], modes.onward[cell]
        for k in range(len(push)):
            push[k] += p * outward[k] - f * onward[k]  # Eq. (G6)
            slopes[k] -= t * outward[k]  # Eq. (G5), summed by parts


@compilable
def shell_pushes(surface: PinSurface, forces: PinForces) -> np.ndarray:
    """Return the forces of a film on its shell's modes and moments by them, (2, k) [kg^-1/2 N].

    Eq. (G6):  Q_k = sum p Phi_ek - sum f Phi_tk      by virtual work
    Eq. (G5):  M_pin = .. + sum p du_e/da,   M_shell = .. - sum p du_e/da

    Pressure is normal to the deformed shell and therefore has a moment about its axis. The rest of
    the film's balance about this axis acts on the pin, as in Eq. (G3). The second row has that of
    the pin per modal coordinate.
    """
    cells, k = surface.modes.outward.shape
    out = np.zeros((2, k))
    if k > 0:
        shape = (surface.outward.shape[1], len(surface.clearance))
        pressure, drag = forces.pressure.reshape(cells), forces.circumferential.reshape(cells)
        turned = around_slope(forces.pressure.reshape(shape)).reshape(cells)
        add_shell_pushes(surface.modes, pressure, turned, drag, out[0], out[1])
    return out


@compilable
def resultants_on(
    surface: PinSurface,
    forces: PinForces,
    place: np.ndarray,
    axes: np.ndarray,
    shapes: np.ndarray = PARALLEL,
) -> PinResultants:
    """Return the resultants of a film on pin and shell.

    Eq. (G3):  F = R(chi) sum (-p e + f t),   M_shell = -R sum f,   M_pin = R sum f - d x F
               t = (-sin a, cos a)
    Eq. (G8):  Q_k = sum_j psi_kj F_j,   M_pin = .. - sum_k s_k x Q_k      F_j: F of row j

    f is the opposite of the shear on the shell. Pressure has no moment about the shell's axis, so
    the rest of the film's balance acts on the pin.

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
        s_k in space [kg^1/2 m].
    """
    around = surface.outward.shape[1]
    along = len(surface.clearance)
    n = surface.axis.shape[1]
    pushes = forces.pressure.reshape((around, along))
    drags = forces.circumferential.reshape((around, along))
    force = np.zeros(2)
    on_shapes = np.zeros((n, 2))
    around_all = 0.0
    for j in range(along):
        x = 0.0
        y = 0.0
        for i in range(around):
            x += surface.onward[0, i] * drags[i, j] - surface.outward[0, i] * pushes[i, j]
            y += surface.onward[1, i] * drags[i, j] - surface.outward[1, i] * pushes[i, j]
            around_all += drags[i, j]
        row = in_space(axes, pair(x, y))
        for direction in range(2):
            force[direction] += row[direction]  # Eq. (G3)
            for k in range(n):
                on_shapes[k, direction] += surface.axis[j, k] * row[direction]  # Eq. (G8)
    on_shell = -surface.radius * around_all
    on_pin = -on_shell - cross(place, force)
    lever = 0.0
    for k in range(n):
        lever += cross(shapes[k], on_shapes[k])
    return PinResultants(force, on_pin - lever, on_shell, on_shapes)


@compilable
def power_on_grid(
    surface: PinSurface,
    forces: PinForces,
    place: np.ndarray,
    velocity: np.ndarray,
    turning: float,
    opened: np.ndarray,
    rate: np.ndarray,
    bent: ModeMotion,
) -> FilmPower:
    """Return the power of the film on pin and shell as the sum over its cells.

    Eq. (G4):  P = sum p (dh/dt + w dh/da) + sum f ((R - d . e) w + t . d' - u_t')
               w = phi' - chi'

    Pressure acts on the normal velocity of the pin's surface, which includes that by rotation if
    the film is not uniform. f acts on its tangential velocity.

    Parameters
    ----------
    surface : PinSurface
    forces : PinForces
    place, velocity : ndarray, shape (2,)
        d and d' in the axes of the shell [m], [m/s].
    turning : float
        w [rad/s].
    opened : ndarray, shape (c, a)
        `yielded` of the shell [m].
    rate : ndarray, shape (k,)
        q' of the shell [kg^1/2 m/s].
    bent : ModeMotion
        Motion of a pin with shapes, in the axes of the shell; d is then d_j of Eq. (H11).

    Returns
    -------
    FilmPower
    """
    around = surface.outward.shape[1]
    along = len(surface.clearance)
    pushes = forces.pressure.reshape((around, along))
    drags = forces.circumferential.reshape((around, along))
    opening = yielded(surface, rate)
    slope = around_slope(opened)
    moved = on_cells(surface, surface.modes.onward, rate)
    power = 0.0
    size = 0.0
    for j in range(along):
        at = row_of(surface, place, bent.position, j)
        moving = row_of(surface, velocity, bent.velocity, j)
        for i in range(around):
            e_x = surface.outward[0, i]
            e_y = surface.outward[1, i]
            t_x = surface.onward[0, i]
            t_y = surface.onward[1, i]
            # Eq. (G4)
            closing = opening[i, j] - (moving[0] * e_x + moving[1] * e_y)
            closing += turning * (slope[i, j] - (at[0] * t_x + at[1] * t_y))
            arm = surface.radius - (at[0] * e_x + at[1] * e_y)
            onward = turning * arm + moving[0] * t_x + moving[1] * t_y - moved[i, j]
            power += pushes[i, j] * closing + drags[i, j] * onward
            size += abs(pushes[i, j] * closing) + abs(drags[i, j] * onward)
    return FilmPower(power, size)


@compilable
def diameters(opened: np.ndarray) -> tuple[float, float]:
    """Return how much wider a shell is along its own x and y in the middle of its length.

    opened : outward displacement of the shell, (c, a) [m].

    Eq. (H13):  D(a) = u(a) + u(a + pi),   u linear between the grid's lines and rows
    """
    east = _amid(opened, 0.0)
    north = _amid(opened, 0.25)
    west = _amid(opened, 0.5)
    south = _amid(opened, 0.75)
    return east + west, north + south  # Eq. (H13)


@compilable
def _amid(opened, turn):
    """Return the value in the middle of the length at a fraction of a revolution."""
    around, along = opened.shape
    line = int(np.floor(turn * around))
    share = turn * around - line
    one = (opened[line, (along - 1) // 2] + opened[line, along // 2]) / 2
    after = (line + 1) % around
    other = (opened[after, (along - 1) // 2] + opened[after, along // 2]) / 2
    return (1 - share) * one + share * other
