"""Asperity contact of nominally flat rough surfaces by Greenwood and Tripp.

Eq. (A1):  F_n(H) = (2 pi)^-1/2 int_H^inf (s - H)^n exp(-s^2/2) ds = Gamma(n+1) (2 pi)^-1/2 exp(-H^2/4) D_{-n-1}(H)
Eq. (A2):  dF_n/dH = -n F_{n-1}
Eq. (A3):  p = (16 sqrt(2) pi / 15) (eta beta sigma)^2 sqrt(sigma/beta) E* F_5/2(h/sigma),   1/E* = sum (1 - nu^2)/E
Eq. (A4):  A_c/A = pi^2 (eta beta sigma)^2 F_2(h/sigma)
Eq. (A5):  F_5/2(H) = 4.4086e-5 (4 - H)^6.804, H < 4            the usual power fit, 4 to 74 % low for H = 0 to 3
Eq. (A6):  tau_b = mu_b p + tau_0 A_c/A                             boundary shear: Coulomb, and shear of the boundary layer

D is the parabolic cylinder function. E* is the contact modulus with the sum of both compliances;
with E' = 2/sum the factor of Eq. (A3) is half as large. For H < 0 the integrals go on along their
tangent at H = 0: the height distribution says nothing about overlap, and a straight line keeps the
contact stiffness finite there.

References ---------- [Greenwood1970] J. A. Greenwood, J. H. Tripp, The contact of two nominally
flat rough surfaces, Proc. Instn Mech. Engrs 185 (1970) 625-633.
"""

from functools import cache

import numpy as np
from scipy.special import gamma, pbdv

from ..master.fmi.compiled import compiled
from .hermite import interpolate

CONTACT_LAWS = ("greenwood_tripp_1970", "power_fit")
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
    return (
        gamma(order + 1.0) / np.sqrt(2.0 * np.pi) * np.exp(-np.square(separation) / 4.0) * value
    )  # Eq. (A1)


def fitted_integral(separation):
    """The usual power fit of F_5/2, Eq. (A5), for H >= 0; its slope too."""
    reach = np.maximum(4.0 - separation, 0.0)
    return 4.4086e-5 * reach**6.804, -4.4086e-5 * 6.804 * reach**5.804  # Eq. (A5)


@cache
def contact_table(law="greenwood_tripp_1970"):
    """Values and slopes of F_5/2 and F_2 on a uniform grid of H from 0 to `TABLE_END`.

    Parameters
    ----------
    law : str
        One of `CONTACT_LAWS`: exact integrals, or F_5/2 by the power fit.

    Returns
    -------
    ndarray, shape (TABLE_CELLS + 1, 4)
        F_5/2, dF_5/2/dH, F_2, dF_2/dH [-].
    """
    separation = np.linspace(0.0, TABLE_END, TABLE_CELLS + 1)
    exact = (
        gaussian_integral(2.5, separation),
        -2.5 * gaussian_integral(1.5, separation),
    )  # Eq. (A2)
    pressure = exact if law == "greenwood_tripp_1970" else fitted_integral(separation)
    area = gaussian_integral(2.0, separation), -2.0 * gaussian_integral(1.0, separation)
    return np.ascontiguousarray(np.stack([*pressure, *area], axis=1))


@compiled(inline="always")
def _integral(table, column, separation):
    """Tabulated integral and its slope at H; straight below 0, zero above the table."""
    if separation >= TABLE_END:
        return 0.0, 0.0
    if separation < 0.0:
        return table[0, column] + table[0, column + 1] * separation, table[0, column + 1]
    return interpolate(table, column, TABLE_END, separation)


def pressure_scale(roughness_product, slope_ratio, contact_modulus):
    """Factor of F_5/2 in the asperity pressure, Eq. (A3).

    Parameters
    ----------
    roughness_product : float
        eta beta sigma [-], asperity density x tip radius x composite rms height; 0.03 to 0.05 for
        engineering surfaces.
    slope_ratio : float
        sigma / beta [-], 1e-4 to 1e-2.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        [Pa].
    """
    return (
        16.0
        * np.sqrt(2.0)
        * np.pi
        / 15.0
        * roughness_product**2
        * np.sqrt(slope_ratio)
        * contact_modulus
    )  # Eq. (A3)


@compiled
def contact(
    film_thickness, roughness_rms, scale, area_scale, friction_coefficient, shear_strength, table
):
    """Asperity pressure, contact area fraction and boundary shear stress with their slopes, Eqs.
    (A3), (A4), (A6).

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
    friction_coefficient : float
        mu_b [-].
    shear_strength : float
        tau_0 [Pa].
    table : ndarray
        From `contact_table`.

    Returns
    -------
    pressure, slope, area, stress, stress_slope : ndarray, shape (n_c, n_a)
        p [Pa], dp/dh [Pa/m], A_c/A [-] up to 1, tau_b [Pa], dtau_b/dh [Pa/m].
    """
    pressure, slope, area = (
        np.zeros_like(film_thickness),
        np.zeros_like(film_thickness),
        np.zeros_like(film_thickness),
    )
    stress, stress_slope = np.zeros_like(film_thickness), np.zeros_like(film_thickness)
    if roughness_rms <= 0.0:
        return pressure, slope, area, stress, stress_slope
    for i in range(film_thickness.shape[0]):
        for j in range(film_thickness.shape[1]):
            separation = film_thickness[i, j] / roughness_rms
            if separation < TABLE_END:
                value, derivative = _integral(table, 0, separation)
                covered, dcovered = _integral(table, 2, separation)
                pressure[i, j] = scale * value  # Eq. (A3)
                slope[i, j] = scale * derivative / roughness_rms
                area[i, j] = min(1.0, area_scale * covered)  # Eq. (A4)
                darea = area_scale * dcovered / roughness_rms if area[i, j] < 1.0 else 0.0
                stress[i, j] = (
                    friction_coefficient * pressure[i, j] + shear_strength * area[i, j]
                )  # Eq. (A6)
                stress_slope[i, j] = friction_coefficient * slope[i, j] + shear_strength * darea
    return pressure, slope, area, stress, stress_slope
