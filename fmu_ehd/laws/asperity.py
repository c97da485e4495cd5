"""Asperity contact of nominally flat rough surfaces by Greenwood and Tripp.

Eq. (A1):  F_n(Lambda) = (2 pi)^-1/2 int_Lambda^inf (z - Lambda)^n exp(-z^2/2) dz
                  = Gamma(n+1) (2 pi)^-1/2 exp(-Lambda^2/4) D_{-n-1}(Lambda)
Eq. (A2):  dF_n/dLambda = -n F_{n-1}
Eq. (A3):  p = (16 sqrt(2) pi / 15) (eta beta_a sigma)^2 sqrt(sigma/beta_a) E* F_5/2(Lambda),
           1/E* = sum (1 - nu^2)/E
Eq. (A4):  A_c/A = pi^2 (eta beta_a sigma)^2 F_2(Lambda)

The separation is that of the mean planes of the summits, which are z_s above the mean planes of the
surfaces, summed over both bodies:

Eq. (A13):  Lambda = (h - z_s)/sigma

The usual power fit, 4 to 74 % low for Lambda = 0 to 3:

Eq. (A5):  F_5/2(Lambda) = 4.4086e-5 (4 - Lambda)^6.804, Lambda < 4

Elastic energy by area, which the asperities release as the gap opens:

Eq. (A9):  e = int_h^inf p dh' = (2/7) p_0 sigma F_7/2(Lambda),   p = p_0 F_5/2

Boundary shear stress, by Coulomb friction and by the boundary layer:

Eq. (A6):  tau_b = mu_b p + tau_0 A_c/A

D is the parabolic cylinder function. E* is the contact modulus with the sum of both compliances;
with E' = 2/sum the factor of Eq. (A3) is half as large. For Lambda < 0 the integrals continue along
their tangent at Lambda = 0, because the height distribution does not describe overlap. A straight
line also keeps the contact stiffness finite. At Lambda = -1.5 it is below half of the integral.
Therefore the law ends:

Eq. (A14):  h > -1.5 sigma

Smooth surfaces, sigma = 0, have no contact law and must not touch. A coating deflects by less than
its thickness d, so h without its deflection is above -1.5 sigma - d.

References
----------
[Greenwood1970] J. A. Greenwood, J. H. Tripp, The contact of two nominally flat rough surfaces,
Proc. Instn Mech. Engrs 185 (1970) 625-633.
[Whitehouse1970] D. J. Whitehouse, J. F. Archard, The properties of random surfaces of significance
in their contact, Proc. R. Soc. Lond. A 316 (1970) 97-121.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..common.grid import Array
from .hermite import interpolate

CONTACT_LAWS = ("greenwood_tripp_1970", "power_fit")
TABLE_END = 8.0  # F_5/2(8) is 1e-16 of F_5/2(0)
TABLE_CELLS = 512  # Hermite error 1e-10 of F_5/2(0)

# columns of the table: each integral, its slope in the column behind
PRESSURE_COLUMN = 0
AREA_COLUMN = 2
ENERGY_COLUMN = 4

MOST_OVERLAP = 1.5  # of Eq. (A14), -h/sigma

FIT_FACTOR = 4.4086e-5  # of Eq. (A5)
FIT_POWER = 6.804
FIT_REACH = 4.0


class ContactConstants(NamedTuple):
    """Constants of contact.

    roughness_rms : composite sigma [m]; 0 = smooth, no contact;
    pressure_scale : from `pressure_scale` [Pa];
    area_scale : pi^2 (eta beta_a sigma)^2 [-];
    friction_coefficient : mu_b [-];
    shear_strength : tau_0 [Pa];
    summit_height : z_s [m];
    table : ndarray from `contact_table`.
    """

    roughness_rms: float
    pressure_scale: float
    area_scale: float
    friction_coefficient: float
    shear_strength: float
    summit_height: float
    table: Array


class PointContact(NamedTuple):
    """Contact at a point.

    pressure : p [Pa]; pressure_slope : dp/dh [Pa/m]; area_fraction : A_c/A [-], up to 1;
    shear_stress : tau_b [Pa]; shear_stress_slope : dtau_b/dh [Pa/m]; energy : e [J/m2].
    """

    pressure: float
    pressure_slope: float
    area_fraction: float
    shear_stress: float
    shear_stress_slope: float
    energy: float


def gaussian_integral(order: float, separation: Any) -> Any:
    """Return the integral F_n of the Gaussian height distribution, Eq. (A1).

    Parameters
    ----------
    order : float
        n [-], > -1.
    separation : float or ndarray
        Lambda [-], any sign.

    Returns
    -------
    float or ndarray
        F_n(Lambda) [-].

    References
    ----------
    [Greenwood1970]. Checked in tests/verification/cases/film.py against published values.

    >>> print(f"{gaussian_integral(2.5, 0.0):.4f} {gaussian_integral(2.5, 3.0):.2e}")
    0.6166 1.71e-04
    """
    from scipy.special import gamma, pbdv  # slow to import, and smooth films do without

    value, _ = pbdv(-order - 1.0, separation)
    scale = gamma(order + 1.0) / np.sqrt(2.0 * np.pi)
    return scale * np.exp(-np.square(separation) / 4.0) * value  # Eq. (A1)


def fitted_integral(separation: Any) -> tuple[Any, Any]:
    """Return the usual power fit of F_5/2 and its slope, Eq. (A5), for Lambda >= 0.

    >>> print(f"{fitted_integral(3.0)[0]:.2e}")
    4.41e-05
    """
    reach = np.maximum(FIT_REACH - separation, 0.0)
    value = FIT_FACTOR * reach**FIT_POWER  # Eq. (A5)
    slope = -FIT_FACTOR * FIT_POWER * reach ** (FIT_POWER - 1.0)
    return value, slope


@cache
def contact_table(law: str = "greenwood_tripp_1970") -> Array:
    """Return a table of F_5/2, F_2 and int_Lambda^inf F_5/2 with their slopes.

    The grid of Lambda is uniform from 0 to `TABLE_END`.

    Parameters
    ----------
    law : str
        One of `CONTACT_LAWS`: exact integrals, or F_5/2 by the power fit.

    Returns
    -------
    ndarray, shape (TABLE_CELLS + 1, 6)
        F_5/2, dF_5/2/dLambda, F_2, dF_2/dLambda, int_Lambda^inf F_5/2, -F_5/2 [-].
    """
    separation = np.linspace(0.0, TABLE_END, TABLE_CELLS + 1)
    if law == "power_fit":
        pressure, pressure_slope = fitted_integral(separation)
        energy = pressure * np.maximum(FIT_REACH - separation, 0.0) / (FIT_POWER + 1.0)
    else:
        pressure = gaussian_integral(2.5, separation)
        pressure_slope = -2.5 * gaussian_integral(1.5, separation)  # Eq. (A2)
        energy = 2.0 / 7.0 * gaussian_integral(3.5, separation)  # Eq. (A9), by Eq. (A2)
    area = gaussian_integral(2.0, separation)
    area_slope = -2.0 * gaussian_integral(1.0, separation)
    columns = [pressure, pressure_slope, area, area_slope, energy, -pressure]
    return np.ascontiguousarray(np.stack(columns, axis=1))


@compiled(forceinline=True)
def _integral(table, column, separation):
    """Return the tabulated integral and its slope; linear below 0, zero above the table."""
    if separation >= TABLE_END:
        return 0.0, 0.0
    if separation < 0.0:
        return table[0, column] + table[0, column + 1] * separation, table[0, column + 1]
    return interpolate(table, column, TABLE_END, separation)


@compiled(forceinline=True)
def _energy_integral(table, separation):
    """Return int_Lambda^inf F_5/2, with F_5/2 straight below 0."""
    value, slope = _integral(table, ENERGY_COLUMN, separation)
    if separation < 0.0:
        value -= 0.5 * table[0, PRESSURE_COLUMN + 1] * separation * separation
    return value


@compilable
def contact_constants(x: Any, table: Array) -> ContactConstants:
    """Return the constants of a contact, by numbers `x` with names, and `contact_table`."""
    return ContactConstants(
        roughness_rms=x.roughness_rms,
        pressure_scale=pressure_scale(x.asperity_product, x.asperity_slope, x.contact_modulus),
        area_scale=np.pi**2 * x.asperity_product**2,
        friction_coefficient=x.boundary_friction_coefficient,
        shear_strength=x.boundary_shear_strength,
        summit_height=x.summit_height,
        table=table,
    )


@compilable
def pressure_scale(roughness_product: float, slope_ratio: float, contact_modulus: float) -> float:
    """Return the factor of F_5/2 in the asperity pressure, Eq. (A3).

    Parameters
    ----------
    roughness_product : float
        eta beta_a sigma [-], asperity density x tip radius x composite rms height; 0.03 to 0.05 for
        engineering surfaces.
    slope_ratio : float
        sigma / beta_a [-], 1e-4 to 1e-2.
    contact_modulus : float
        E* [Pa].

    Returns
    -------
    float
        [Pa].

    >>> print(f"{1e-6 * pressure_scale(0.04, 1e-3, 113e9):.1f} MPa")
    27.1 MPa
    """
    factor = 16.0 * np.sqrt(2.0) * np.pi / 15.0
    return factor * roughness_product**2 * np.sqrt(slope_ratio) * contact_modulus  # Eq. (A3)


@compiled(forceinline=True)
def point_contact(film_thickness, constants):
    """Return the contact at a point, Eqs. (A3), (A4), (A6), (A9), (A13).

    Parameters
    ----------
    film_thickness : float
        h [m], any sign.

    Returns
    -------
    PointContact
    """
    rms, scale, area_scale, friction_coefficient, shear_strength, summit_height, table = constants
    separation = (film_thickness - summit_height) / rms  # Eq. (A13)
    value, dvalue = _integral(table, PRESSURE_COLUMN, separation)
    covered, dcovered = _integral(table, AREA_COLUMN, separation)
    pressure = scale * value  # Eq. (A3)
    slope = scale * dvalue / rms
    area = min(1.0, area_scale * covered)  # Eq. (A4)
    darea = area_scale * dcovered / rms if area < 1.0 else 0.0
    stress = friction_coefficient * pressure + shear_strength * area  # Eq. (A6)
    dstress = friction_coefficient * slope + shear_strength * darea
    energy = scale * rms * _energy_integral(table, separation)  # Eq. (A9)
    return PointContact(
        pressure=pressure,
        pressure_slope=slope,
        area_fraction=area,
        shear_stress=stress,
        shear_stress_slope=dstress,
        energy=energy,
    )
