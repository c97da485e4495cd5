"""Shapes that are not cylinders: the skirt's machined profile, measured tables, thermal growth, a
distorted bore.

A skirt's shape is a gap (positive: further from the bore than the nominal cylinder), a bore's is a
widening (positive: outwards); both add to the film thickness, and any number of them may be
superimposed.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ...master.fmi.compiled import compilable


@dataclass(frozen=True)
class MeasuredShape:
    """A shape measured over angle and height; a single angle is a round shape.

    Parameters
    ----------
    angle : ndarray, shape (m,)
        theta, rising within one turn [rad].
    height : ndarray, shape (k,)
        Rising [m].
    value : ndarray, shape (k, m)
        Gap of a skirt, widening of a bore [m].
    """

    angle: np.ndarray
    height: np.ndarray
    value: np.ndarray


@dataclass(frozen=True)
class BoreOrder:
    """One Fourier order of a bore's distortion: order [-], amplitude [m], phase [rad]."""

    order: int
    amplitude: float
    phase: float


@compilable
def barrel(height: np.ndarray, lower: float, upper: float, drop: float) -> np.ndarray:
    """Parabolic barrel: no gap at mid skirt, `drop` at both ends.

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
    """Oval section: full size across the thrust faces, smaller along the pin.

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
    """Measured shape, cubic splines between its points, periodic in angle, its outermost rows held
    beyond its ends.

    Straight lines between 24 points around cut off 0.3 um of the thrust face for each 40 um of
    ovality, more than a film may be thick.

    Parameters
    ----------
    table : MeasuredShape
    angle, height : ndarray, shapes (c,), (a,)
        Where it is wanted [rad], [m].

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
    """Bore distortion by orders, as head bolts and heat make it.

    Eq. (I8):  widening = sum_n amplitude_n cos(n (theta - phase_n))

    Parameters
    ----------
    orders : iterable of BoreOrder
    angle : ndarray, shape (c,)
        [rad]

    Returns
    -------
    ndarray, shape (c,)
        Radial widening [m]; order 0 is growth, order 1 an offset of the axis, 2 ovality, 4 four
        bolts.
    """
    widening = np.zeros_like(angle)
    for term in orders:
        widening += term.amplitude * np.cos(term.order * (angle - term.phase))  # Eq. (I8)
    return widening


@compilable
def linear_growth(
    height: np.ndarray, lower: float, upper: float, at_lower: float, at_upper: float
) -> np.ndarray:
    """Radial growth that varies linearly between two heights [m], and beyond them likewise."""
    return at_lower + (at_upper - at_lower) * (height - lower) / (upper - lower)


@compilable
def tilt_about_x(angle: np.ndarray, height: np.ndarray, tilt: float) -> np.ndarray:
    """Gap of a skirt turned about the x axis, by a pin that is not square to the bore.

    Eq. (I9):  gap = -tilt y' cos theta

    Parameters
    ----------
    angle, height : ndarray, shapes (c, 1), (a,)
        theta [rad], y' above A [m].
    tilt : float
        About +x [rad], small: the upper edge leans to +z.

    Returns
    -------
    ndarray, shape (c, a)
        Radial gap [m].
    """
    return -tilt * (np.cos(angle) * height)  # Eq. (I9)
