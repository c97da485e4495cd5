"""Asperity contact of nominally flat rough surfaces by Greenwood and Tripp.

Eq. (A1):  F_n(H) = (2 pi)^-1/2 int_H^inf (s - H)^n exp(-s^2/2) ds = Gamma(n+1) (2 pi)^-1/2 exp(-H^2/4) D_{-n-1}(H)
Eq. (A2):  dF_n/dH = -n F_{n-1}
Eq. (A3):  p = (16 sqrt(2) pi / 15) (eta beta sigma)^2 sqrt(sigma/beta) E* F_5/2(h/sigma),   1/E* = sum (1 - nu^2)/E
Eq. (A4):  A_c/A = pi^2 (eta beta sigma)^2 F_2(h/sigma)

D is the parabolic cylinder function. E* is the contact modulus with the sum of both compliances; with E' = 2/sum the
factor of Eq. (A3) is half as large. For H < 0 the integrals go on along their tangent at H = 0: the height distribution says
nothing about overlap, and a straight line keeps the contact stiffness finite there.

References
----------
[Greenwood1970] J. A. Greenwood, J. H. Tripp, The contact of two nominally flat rough surfaces, Proc. Instn Mech.
Engrs 185 (1970) 625-633.
"""

from functools import cache

import numpy as np
from numba import njit
from scipy.special import gamma, pbdv

TABLE_END = 8.0  # F_5/2(8) is 1e-16 of F_5/2(0)
TABLE_CELLS = 512  # Hermite error 1e-10 of F_5/2(0)


def gaussian_integral(order, separation):
    """Integral F_n of the Gaussian height distribution, Eq. (A1).

    Parameters
    ----------
    order : float
        n [-], > -1.
    separation : float or ndarray
        H = h / sigma [-], any sign.

    Returns
    -------
    float or ndarray
        F_n(H) [-].

    References
    ----------
    [Greenwood1970]. Checked in fmu_ehd/verification.py against published values.
    """
    value, _ = pbdv(-order - 1.0, separation)
    return gamma(order + 1.0) / np.sqrt(2.0 * np.pi) * np.exp(-np.square(separation) / 4.0) * value  # Eq. (A1)


@cache
def contact_table():
    """Values and slopes of F_5/2 and F_2 on a uniform grid of H from 0 to `TABLE_END`.

    Returns
    -------
    ndarray, shape (TABLE_CELLS + 1, 4)
        F_5/2, dF_5/2/dH, F_2, dF_2/dH [-].
    """
    separation = np.linspace(0.0, TABLE_END, TABLE_CELLS + 1)
    pressure, area = gaussian_integral(2.5, separation), gaussian_integral(2.0, separation)
    slopes = -2.5 * gaussian_integral(1.5, separation), -2.0 * gaussian_integral(1.0, separation)  # Eq. (A2)
    return np.ascontiguousarray(np.stack([pressure, slopes[0], area, slopes[1]], axis=1))


@njit(cache=True, inline="always")
def _interpolate(table, column, separation):
    """Cubic Hermite value and slope of a table column at H; straight below 0, zero above the end."""
    step = TABLE_END / (table.shape[0] - 1)
    if separation >= TABLE_END:
        return 0.0, 0.0
    if separation <= 0.0:
        return table[0, column] + table[0, column + 1] * separation, table[0, column + 1]
    k = int(separation / step)
    x = separation / step - k
    y0, y1 = table[k, column], table[k + 1, column]
    m0, m1 = table[k, column + 1] * step, table[k + 1, column + 1] * step
    c2, c3 = 3.0 * (y1 - y0) - 2.0 * m0 - m1, 2.0 * (y0 - y1) + m0 + m1
    return y0 + x * (m0 + x * (c2 + x * c3)), (m0 + x * (2.0 * c2 + 3.0 * x * c3)) / step


def pressure_scale(roughness_product, slope_ratio, contact_modulus):
    """Factor of F_5/2 in the asperity pressure, Eq. (A3).

    Parameters
    ----------
    roughness_product : float
        eta beta sigma [-], asperity density x tip radius x composite rms height; 0.03 to 0.05 for engineering surfaces.
    slope_ratio : float
        sigma / beta [-], 1e-4 to 1e-2.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        [Pa].
    """
    return 16.0 * np.sqrt(2.0) * np.pi / 15.0 * roughness_product**2 * np.sqrt(slope_ratio) * contact_modulus  # Eq. (A3)


@njit(cache=True)
def contact(film_thickness, roughness_rms, scale, area_scale, table):
    """Asperity pressure, its derivative, and contact area fraction, Eqs. (A3), (A4).

    Parameters
    ----------
    film_thickness : ndarray, shape (n_c, n_a)
        h [m], any sign.
    roughness_rms : float
        Composite sigma [m]; 0 = smooth, no contact.
    scale : float
        From `pressure_scale` [Pa].
    area_scale : float
        pi^2 (eta beta sigma)^2 [-].
    table : ndarray
        From `contact_table`.

    Returns
    -------
    pressure, slope : ndarray, shape (n_c, n_a)
        [Pa], [Pa/m].
    area_fraction : float
        Mean of A_c/A over the cells, each at most 1 [-].
    """
    pressure, slope = np.zeros_like(film_thickness), np.zeros_like(film_thickness)
    area = 0.0
    if roughness_rms <= 0.0:
        return pressure, slope, area
    for cell in np.ndindex(film_thickness.shape):
        separation = film_thickness[cell] / roughness_rms
        if separation < TABLE_END:
            value, derivative = _interpolate(table, 0, separation)
            pressure[cell] = scale * value  # Eq. (A3)
            slope[cell] = scale * derivative / roughness_rms
            area += min(1.0, area_scale * _interpolate(table, 2, separation)[0])  # Eq. (A4)
    return pressure, slope, area / film_thickness.size
