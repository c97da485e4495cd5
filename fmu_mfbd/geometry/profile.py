"""Shapes that are not cylinders: the skirt's machined profile, measured tables, thermal growth, a
distorted bore.

A skirt's shape is a gap (positive: further from the bore than the nominal cylinder), a bore's is a
widening (positive: outwards); both add to the film thickness, and any number of them may be
superimposed.
"""

import numpy as np
from scipy.interpolate import RegularGridInterpolator


def barrel(height, lower, upper, drop):
    """Parabolic barrel: no gap at mid skirt, `drop` at both ends.

    Eq. (P1):  gap = drop ((2 y - y_l - y_u)/(y_u - y_l))^2

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
    return drop * ((2 * height - lower - upper) / (upper - lower)) ** 2  # Eq. (P1)


def ovality(angle, difference):
    """Oval section: full size across the thrust faces, smaller along the pin.

    Eq. (P2):  gap = difference/4 (1 + cos 2 theta)

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
    return difference / 4 * (1 + np.cos(2 * angle))  # Eq. (P2)


def table_shape(table, angle, height):
    """Measured shape, linear between its points, periodic in angle, its outermost rows held beyond
    its ends.

    Parameters
    ----------
    table : dict
        angle (m,) rising within one turn [rad], height (k,) rising [m], value (k, m) [m]; one angle
        alone is a round shape.
    angle, height : ndarray, shapes (c,), (a,)
        Where it is wanted [rad], [m].

    Returns
    -------
    ndarray, shape (c, a)
        [m]
    """
    known, value = np.asarray(table["angle"], dtype=float), np.asarray(table["value"], dtype=float)
    wrapped = np.concatenate([known[-1:] - 2 * np.pi, known, known[:1] + 2 * np.pi])
    wide = np.hstack([value[:, -1:], value, value[:, :1]])
    rows = np.asarray(table["height"], dtype=float)
    if len(rows) == 1:
        rows, wide = np.array([rows[0], rows[0] + 1.0]), np.vstack([wide, wide])
    at = np.meshgrid(
        np.clip(height, rows[0], rows[-1]),
        np.remainder(angle - known[0], 2 * np.pi) + known[0],
        indexing="ij",
    )
    return RegularGridInterpolator((rows, wrapped), wide)(np.stack(at, axis=-1)).T


def fourier_bore(orders, angle):
    """Bore distortion by orders, as head bolts and heat make it.

    Eq. (P3):  widening = sum_n amplitude_n cos(n (theta - phase_n))

    Parameters
    ----------
    orders : list of dict
        order [-], amplitude [m], phase [rad].
    angle : ndarray, shape (c,)

    Returns
    -------
    ndarray, shape (c,)
        Radial widening [m]; order 0 is growth, order 1 an offset of the axis, 2 ovality, 4 four
        bolts.
    """
    out = np.zeros_like(angle)
    for term in orders:
        out += term["amplitude"] * np.cos(term["order"] * (angle - term["phase"]))  # Eq. (P3)
    return out


def linear_growth(height, lower, upper, at_lower, at_upper):
    """Radial growth that varies linearly between two heights [m], and beyond them likewise."""
    return at_lower + (at_upper - at_lower) * (height - lower) / (upper - lower)


def tilt_about_x(angle, height, tilt):
    """Gap of a skirt turned about the x axis, by a pin that is not square to the bore.

    Eq. (P4):  gap = -tilt y' cos theta

    Parameters
    ----------
    angle, height : ndarray, shapes (c,), (a,)
        theta [rad], y' above A [m].
    tilt : float
        About +x [rad], small: the upper edge leans to +z.

    Returns
    -------
    ndarray, shape (c, a)
        Radial gap [m].
    """
    return -tilt * np.outer(np.cos(angle), height)  # Eq. (P4)
