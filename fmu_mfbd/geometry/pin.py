"""Films of a pin that turns in a shell: thickness and velocity from where it stands and how it
turns, and forces back on pin and shell.

Points (i, j) of the grid rest on the shell; arrays are (n_circumferential, n_axial). i counts from
the shell's own +x towards its +y, about +z: a = 2 pi (i - 1)/n. The pin does not move along the
shell. It stays parallel to it, or tilts and bends by shapes of its axis, which are read row by row.
"""

from typing import NamedTuple

import numpy as np

PIN_SURFACES = ("boss_left", "boss_right", "small_end")
"""Film surfaces of a floating pin: bosses, then the rod's eye."""

CRANK_SURFACES = ("big_end", "main_bearing")
"""Film surfaces of a crank that may come with them: its pin in the rod's big end, its journal in
the block; each a `PinSurface` likewise.
"""


class ShellModes(NamedTuple):
    """How a shell yields, by k modes of its body.

    Parameters
    ----------
    outward, onward : ndarray, shape (cells, k)
        Displacement along e and t at the grid's points, j fastest [kg^-1/2].
    slope : ndarray, shape (cells, k)
        d outward/da, by central differences around [kg^-1/2].
    """

    outward: np.ndarray
    onward: np.ndarray
    slope: np.ndarray


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
    """A pin in a shell.

    Parameters
    ----------
    outward, onward : ndarray, shape (2, c)
        Across the film and along it, in the shell's axes: (cos a, sin a), (-sin a, cos a).
    radius : float
        Of the pin [m].
    clearance : float or ndarray, shape (a,)
        Radius of the shell minus that of the pin [m]; by row of a relieved shell.
    shape : (int, int)
        (c, a), cells around and along the shell.
    modes : ShellModes, optional
        None: a rigid shell.
    axis : ndarray, shape (a, n), optional
        Values psi of the pin's shapes at the grid's rows [-]; None: it stays parallel to the shell.
    """

    outward: np.ndarray
    onward: np.ndarray
    radius: float
    clearance: float | np.ndarray
    shape: tuple[int, int]
    modes: ShellModes | None = None
    axis: np.ndarray | None = None


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

    def with_slopes(self, moment: float) -> "PinResultants":
        """With the moment of pressure by the slopes of a yielding shell (Eq. (G5)) [N m]."""
        return self._replace(on_pin=self.on_pin + moment, on_shell=self.on_shell - moment)


def shell_angles(around: int) -> np.ndarray:
    """Angles of the grid's lines from the shell's own +x about +z, (around,) [rad]."""
    return 2 * np.pi * np.arange(around) / around


def shell_modes(outward: np.ndarray, onward: np.ndarray) -> ShellModes:
    """Modes of a shell, given on its grid, (c, a, k)."""
    around, along, k = outward.shape
    step = 2 * np.pi / around
    slope = (np.roll(outward, -1, axis=0) - np.roll(outward, 1, axis=0)) / (2 * step)
    return ShellModes(*(one.reshape(around * along, k) for one in (outward, onward, slope)))


def pin_surface(
    radius: float,
    clearance: float | np.ndarray,
    shape: tuple[int, int],
    modes: ShellModes | None = None,
    axis: np.ndarray | None = None,
) -> PinSurface:
    """Film surface on a grid (c, a)."""
    around, _ = shape
    angle = shell_angles(around)
    outward = np.array([np.cos(angle), np.sin(angle)])
    onward = np.array([-np.sin(angle), np.cos(angle)])
    return PinSurface(outward, onward, radius, clearance, shape, modes, axis)


def relieved(clearance: float, relief: float, rows: np.ndarray, length: float) -> np.ndarray:
    """Clearance of a shell that widens towards its ends, by row.

    Eq. (H12):  c(z) = c + r (2 (z - z_0)/L)^2      z_0 its middle, L its length

    Parameters
    ----------
    clearance, relief : float
        c amid, r more at the ends [m].
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


def turned(angle: float) -> np.ndarray:
    """Matrix, (2, 2), that takes components in axes turned by an angle [rad] to space."""
    c = np.cos(angle)
    s = np.sin(angle)
    return np.array([[c, -s], [s, c]])


def across(vector: np.ndarray) -> np.ndarray:
    """Z v, a vector turned by a quarter about +z."""
    x, y = vector
    return np.array([-y, x])


def cross(a: np.ndarray, b: np.ndarray) -> float:
    """a x b about +z."""
    return float(across(a) @ b)


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
    return _lines(surface, -(place @ surface.outward))  # Eq. (H6)


def _lines(surface, values):
    """A value of each line along the shell on the grid."""
    return np.repeat(values[:, None], surface.shape[1], axis=1)


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
    if surface.axis is None:
        return np.zeros(surface.shape)
    return -(surface.axis @ shapes @ surface.outward).T  # Eq. (H11)


def yielded(surface: PinSurface, modal: np.ndarray) -> np.ndarray:
    """What the shell's yielding adds to the film thickness, or to its change in time.

    Eq. (H8):  h = c - d . e + u_e,   u_e = sum_k Phi_ek q_k

    Parameters
    ----------
    surface : PinSurface
    modal : ndarray, shape (k,)
        q [kg^1/2 m], or its change.

    Returns
    -------
    ndarray, shape (c, a)
        [m]
    """
    if surface.modes is None:
        return np.zeros(surface.shape)
    return (surface.modes.outward @ modal).reshape(surface.shape)  # Eq. (H8)


def modal_push(surface: PinSurface, forces: PinForces) -> np.ndarray:
    """Forces of a film on its shell's modes by virtual work, (k,) [kg^-1/2 N].

    Eq. (G6):  Q_k = sum p Phi_ek - sum f Phi_tk
    """
    assert surface.modes
    push = np.ravel(forces.pressure) @ surface.modes.outward
    return push - np.ravel(forces.circumferential) @ surface.modes.onward  # Eq. (G6)


def slope_push(surface: PinSurface, pressure: np.ndarray) -> np.ndarray:
    """Moment of pressure on the pin about +z, by modal coordinate, (k,) [kg^-1/2 N].

    Eq. (G5):  M_pin = .. + sum p du_e/da,   M_shell = .. - sum p du_e/da

    Pressure stands upright on a shell that is not round any more, and so has a moment about its
    axis; what is left of the film's balance about it acts on the pin, as in Eq. (G3).
    """
    assert surface.modes
    return np.ravel(pressure) @ surface.modes.slope  # Eq. (G5)


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
    shape = surface.shape
    pushes = forces.pressure.reshape(shape)
    drags = forces.circumferential.reshape(shape)
    push = pushes.sum(axis=1)
    drag = drags.sum(axis=1)
    # Eq. (G3)
    force = axes @ (surface.onward @ drag - surface.outward @ push)
    on_shell = -surface.radius * float(drag.sum())
    on_pin = -on_shell - cross(place, force)
    if surface.axis is None:
        return PinResultants(force, on_pin, on_shell)
    rows = axes @ (surface.onward @ drags - surface.outward @ pushes)
    on_shapes = (rows @ surface.axis).T  # Eq. (G8)
    lever = sum(cross(*pair) for pair in zip(shapes, on_shapes))
    return PinResultants(force, on_pin - lever, on_shell, on_shapes)


def grid_power(
    surface: PinSurface,
    forces: PinForces,
    place: np.ndarray,
    velocity: np.ndarray,
    turning: float,
    yielding: Yielding | None = None,
    bent: Bent | None = None,
) -> tuple[float, float]:
    """Power of the film on pin and shell, from what every cell sees, and the sum of the absolute
    values of its terms.

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
    yielding : Yielding, optional
        Of a shell with modes.
    bent : Bent, optional
        Of a pin with shapes, in the axes of the shell; d is d_j then (Eq. (H11)).

    Returns
    -------
    float, float
        [W], [W]
    """
    push = forces.pressure.reshape(surface.shape)
    drag = forces.circumferential.reshape(surface.shape)
    # Eq. (G4)
    closing = -(velocity @ surface.outward) - turning * (place @ surface.onward)
    arm = surface.radius - place @ surface.outward
    onward = turning * arm + velocity @ surface.onward
    terms = push.sum(axis=1) * closing, drag.sum(axis=1) * onward
    if surface.modes is not None and yielding is not None:
        outward = surface.modes.outward @ yielding.velocity
        outward += turning * (surface.modes.slope @ yielding.position)
        along = surface.modes.onward @ yielding.velocity
        terms = (*terms, push.ravel() * outward, -drag.ravel() * along)
    if surface.axis is not None and bent is not None:
        aside, moving = (surface.axis @ one for one in bent)
        closing = -(moving @ surface.outward) - turning * (aside @ surface.onward)
        onward = moving @ surface.onward - turning * (aside @ surface.outward)
        terms = (*terms, push.T * closing, drag.T * onward)
    return sum(float(one.sum()) for one in terms), sum(float(np.abs(one).sum()) for one in terms)
