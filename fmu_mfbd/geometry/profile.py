"""Deviations from cylinders: machined profile, measured tables, thermal growth, distorted bore.

The shape of a skirt is a gap, positive if it is further from the bore than the nominal cylinder.
The shape of a bore is a widening, positive outwards. Both add to the film thickness, and any number
of them can be superimposed.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ...master.fmi.compiled import compilable


@dataclass(frozen=True)
class MeasuredShape:
    """Measured shape over angle and height; a shape with a single angle is round.

    Parameters
    ----------
    angle : ndarray, shape (m,)
        theta, ascending within one revolution [rad].
    height : ndarray, shape (k,)
        Ascending heights [m].
    value : ndarray, shape (k, m)
        Gap of a skirt, widening of a bore [m].
    """

    angle: np.ndarray
    height: np.ndarray
    value: np.ndarray


@dataclass(frozen=True)
class HotShape:
    """Displacement of skirt or bore by heat or bolts, on the grid of the film or of the bore.

    Parameters
    ----------
    radial, axial : ndarray, shape (c, a)
        Displacement outwards and along y [m] of the material that is at each point when it is hot.
    lower, upper : float
        Mean displacement of the skirt's edges along y [m]; 0 for a bore.
    motion : ndarray, shape (6,)
        Rigid motion along x, y, z [m] and about them [rad]: of a piston about A, not contained in
        the shape; of a bore about the origin, contained in the shape.
    """

    radial: np.ndarray
    axial: np.ndarray
    lower: float
    upper: float
    motion: np.ndarray


@dataclass(frozen=True)
class BoreOrder:
    """Fourier order of a bore's distortion: order [-], amplitude [m], phase [rad]."""

    order: int
    amplitude: float
    phase: float


@compilable
def barrel(height: np.ndarray, lower: float, upper: float, drop: float) -> np.ndarray:
    """Return the gap of a parabolic barrel, 0 in the middle of the skirt and `drop` at both ends.

    Eq. (I6):  gap = drop ((2 y - y_l - y_u)/(y_u - y_l))^2

    Parameters
    ----------
    height : ndarray
        y' above A [m].
    lower, upper : float
        Skirt edges [m].
    drop : float
        [m], >= 0.

    Returns
    -------
    ndarray
        Radial gap [m].
    """
    return drop * ((2 * height - lower - upper) / (upper - lower)) ** 2  # Eq. (I6)


@compilable
def ovality(angle: np.ndarray, difference: float) -> np.ndarray:
    """Return the gap of an oval section, which is smaller along the pin.

    Eq. (I7):  gap = difference/4 (1 + cos 2 theta)

    Parameters
    ----------
    angle : ndarray
        theta from the pin axis +z towards the thrust side +x [rad].
    difference : float
        Diameter across the thrust faces minus diameter along the pin [m], >= 0.

    Returns
    -------
    ndarray
        Radial gap [m]: difference/2 at the pin ends, 0 at the thrust faces.
    """
    return difference / 4 * (1 + np.cos(2 * angle))  # Eq. (I7)


def table_shape(table: MeasuredShape, angle: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Return a measured shape on a grid by cubic splines, periodic in angle.

    Beyond its first and last row, the shape is constant. Linear interpolation would change the
    thrust face by more than the film thickness.

    Parameters
    ----------
    table : MeasuredShape
    angle, height : ndarray, shapes (c,), (a,)
        Lines of the grid [rad], [m].

    Returns
    -------
    ndarray, shape (c, a)
        [m]
    """
    from scipy.interpolate import CubicSpline  # slow to import, and few cases have a table

    values = table.value
    if table.angle.size > 1:
        closed = np.append(table.angle, table.angle[0] + 2 * np.pi)
        around = CubicSpline(closed, np.hstack([values, values[:, :1]]), axis=1, bc_type="periodic")
        values = around(angle)
    else:
        values = np.repeat(values, angle.size, axis=1)
    rows = table.height
    if rows.size == 1:
        return np.repeat(values.T, height.size, axis=1)
    along = CubicSpline(rows, values)
    return along(np.clip(height, rows[0], rows[-1])).T


def fourier_bore(orders: Iterable[BoreOrder], angle: np.ndarray) -> np.ndarray:
    """Return the bore distortion by Fourier orders.

    Eq. (I8):  widening = sum_n amplitude_n cos(n (theta - phase_n))

    Parameters
    ----------
    orders : iterable of BoreOrder
    angle : ndarray, shape (c,)
        [rad]

    Returns
    -------
    ndarray, shape (c,)
        Radial widening [m]. Order 0 is growth, 1 an offset of the axis, 2 ovality, and 4 the effect
        of four bolts.
    """
    widening = np.zeros_like(angle)
    for term in orders:
        widening += term.amplitude * np.cos(term.order * (angle - term.phase))  # Eq. (I8)
    return widening


@compilable
def linear_growth(
    height: np.ndarray | float, lower: float, upper: float, at_lower: float, at_upper: float
):
    """Return the radial growth, linear in height, from its values at two heights [m]."""
    return at_lower + (at_upper - at_lower) * (height - lower) / (upper - lower)


@compilable
def tilt_about_x(angle: np.ndarray, height: np.ndarray, tilt: float) -> np.ndarray:
    """Return the gap of a skirt that is rotated about x by a pin not perpendicular to the bore.

    Eq. (I9):  gap = -tilt y' cos theta

    Parameters
    ----------
    angle, height : ndarray, shapes (c, 1), (a,)
        theta [rad], y' above A [m].
    tilt : float
        Small angle about +x [rad]; the upper edge moves to +z.

    Returns
    -------
    ndarray, shape (c, a)
        Radial gap [m].
    """
    return -tilt * (np.cos(angle) * height)  # Eq. (I9)
