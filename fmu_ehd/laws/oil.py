"""Viscosity of the oil: by temperature, by pressure, by shear rate, each law chosen by name.

By temperature: vogel_1921, with T_o [C], K [Pa s], B and C [K]; walther_1931, with nu [mm2/s] and
T_K [K], as in ASTM D341; two_point, Eq. (O2) through mu_0 at 40 C and at 100 C.

Eq. (O1):  mu_0 = K exp(B / (T_o + C))
Eq. (O2):  lg lg(nu + 0.7) = A - M lg T_K,   mu_0 = rho nu
Eq. (O3):  M = [lg lg(nu_1 + 0.7) - lg lg(nu_2 + 0.7)] / lg(T_K2 / T_K1)

By pressure: `piezoviscosity`.

By shear rate gamma' = |V|/h, or Eq. (R9) with flow factors, with the high-shear ratio m and the
critical shear rate gamma'_c [1/s]: cross_1965 and carreau_1972.

Eq. (O7):  mu/mu_0 = m + (1 - m) / [1 + (gamma'/gamma'_c)^n]
Eq. (O8):  mu/mu_0 = m + (1 - m) [1 + (gamma'/gamma'_c)^2]^((n-1)/2)
Eq. (O9):  lg gamma'_c = a + b T_o

Pressure flow along the sliding direction changes the shear rate of the Couette flow a little. It
meets the slope of the shear stress, pressure flow across meets mu itself [Dien1983]:

Eq. (O10):  mu_t = max(d(mu gamma')/dgamma', m mu_0)

The bound acts for exponents above 1 only, where the stress may fall with the shear rate.

The shear rate is that of sliding, because pressure flow adds little to it in the film of a skirt.
So the thinned viscosity is a function of film and velocity in the same cell, and its derivative is
exact.

References
----------
[Vogel1921] H. Vogel, Phys. Z. 22 (1921) 645.
[Walther1931] C. Walther, Erdoel und Teer 7 (1931) 382; ASTM D341.
[Cross1965] M. M. Cross, J. Colloid Sci. 20 (1965) 417.
[Carreau1972] P. J. Carreau, Trans. Soc. Rheol. 16 (1972) 99.
[Dien1983] I. K. Dien, H. G. Elrod, A generalized steady-state Reynolds equation for non-Newtonian
fluids, with application to journal bearings, J. Lubr. Technol. 105 (1983) 385-390.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, numbered
from ..common.declaration import choice, declared
from ..common.grid import Array
from .piezoviscosity import PRESSURE_VISCOSITY_LAWS

ZERO_CELSIUS = 273.15  # [K]


# ---- temperature


VISCOSITY_LAWS = numbered("constant", "vogel_1921", "walther_1931", "two_point")


@compilable
def low_shear_viscosity(kind: int, x: Any, temperature: Any) -> Any:
    """Return mu_0 [Pa s] at a temperature [K] (float or ndarray), Eqs. (O1) to (O3).

    kind : number in `VISCOSITY_LAWS`; x : constants by their names in `Oil`.
    """
    if kind == VISCOSITY_LAWS.vogel_1921:
        celsius = temperature - ZERO_CELSIUS
        return x.vogel_viscosity * np.exp(x.vogel_b / (celsius + x.vogel_c))  # Eq. (O1)
    if kind == VISCOSITY_LAWS.walther_1931:
        return x.density * walther_viscosity(x.walther_a, x.walther_m, temperature)
    if kind == VISCOSITY_LAWS.two_point:
        cold = ZERO_CELSIUS + 40.0
        thick = _double_logarithm(x.viscosity_40 / x.density)
        thin = _double_logarithm(x.viscosity_100 / x.density)
        m = (thick - thin) / np.log10((ZERO_CELSIUS + 100.0) / cold)  # Eq. (O3)
        return x.density * walther_viscosity(thick + m * np.log10(cold), m, temperature)
    return x.viscosity + 0.0 * temperature


@compilable
def _double_logarithm(viscosity: float) -> float:
    """Return lg lg(nu + 0.7) of a kinematic viscosity [m2/s]."""
    return np.log10(np.log10(1e6 * viscosity + 0.7))


@compilable
def walther_viscosity(a: float, m: float, temperature: Any) -> Any:
    """Return the kinematic viscosity [m2/s] at a temperature [K], Eq. (O2).

    >>> nu = walther_viscosity(8.0, 3.1, 373.15)
    >>> print(f"{1e6 * nu:.2f} mm2/s")
    10.90 mm2/s
    """
    return 1e-6 * (10.0**10.0 ** (a - m * np.log10(temperature)) - 0.7)  # Eq. (O2)


def vogel_constants(
    viscosities: Sequence[float], temperatures: Sequence[float]
) -> tuple[float, float, float]:
    """Return K [Pa s], B and C [K] of Eq. (O1) from three dynamic viscosities.

    The viscosities [Pa s] belong to three temperatures [K].

    The ratio of the two logarithmic viscosity steps is linear in C; B and K follow.

    >>> K, B, C = vogel_constants([0.06, 0.02, 0.009], [313.15, 343.15, 373.15])
    >>> print(f"{K * np.exp(B / (70.0 + C)):.4f} Pa s")
    0.0200 Pa s
    """
    cold, warm, hot = np.asarray(temperatures) - ZERO_CELSIUS
    thick, medium, thin = viscosities
    first = np.log(thick / medium)
    second = np.log(medium / thin)
    near = first * (hot - warm)
    far = second * (warm - cold)
    c = (far * hot - near * cold) / (near - far)
    b = first / (1.0 / (cold + c) - 1.0 / (warm + c))
    return thick / np.exp(b / (cold + c)), b, c


# ---- shear rate


SHEAR_THINNING_LAWS = numbered("none", "cross_1965", "carreau_1972")


class Thinning(NamedTuple):
    """A law of shear thinning with its constants.

    kind : number in `SHEAR_THINNING_LAWS`; high_shear_ratio : m [-]; exponent : n [-];
    a, b : of Eq. (O9) [-], [1/K].
    """

    kind: int
    high_shear_ratio: float
    exponent: float
    a: float
    b: float


@compilable
def thinning_law(kind: int, x: Any) -> Thinning:
    """Return the law of a number in `SHEAR_THINNING_LAWS`, by numbers `x` with names."""
    return Thinning(
        kind,
        x.high_shear_ratio,
        x.shear_thinning_exponent,
        x.critical_shear_rate_a,
        x.critical_shear_rate_b,
    )


@compilable
def _cross_1965(n: float, ratio: Any) -> tuple[Any, Any]:
    """Return (mu - m mu_0) / (mu_0 - m mu_0) and its derivative to gamma'/gamma'_c, Eq. (O7)."""
    power = ratio**n
    factor = 1.0 / (1.0 + power)  # Eq. (O7)
    return factor, -n * power / np.maximum(ratio, 1e-30) * factor**2


@compilable
def _carreau_1972(n: float, ratio: Any) -> tuple[Any, Any]:
    """Return the factor of Eq. (O8) and its derivative to gamma'/gamma'_c."""
    factor = (1.0 + ratio**2) ** ((n - 1.0) / 2.0)  # Eq. (O8)
    return factor, (n - 1.0) * ratio * factor / (1.0 + ratio**2)


@compilable
def _critical_shear_rate(law: Thinning, temperature: Any) -> Any:
    """Return gamma'_c [1/s], Eq. (O9)."""
    return 10.0 ** (law.a + law.b * (temperature - ZERO_CELSIUS))  # Eq. (O9)


@compilable
def thinning(law: Thinning, shear_rate: Any, temperature: Any) -> tuple[Any, Any]:
    """Return mu/mu_0 [-] and its derivative [s], Eqs. (O7) to (O9).

    Shear rate [1/s], temperature [K]; the law is not none.

    >>> cross = Thinning(SHEAR_THINNING_LAWS.cross_1965, 0.74, 1.0, 6.0, 0.0)
    >>> print(f"{thinning(cross, 1e6, 373.15)[0]:.2f}")
    0.87
    """
    critical = _critical_shear_rate(law, temperature)
    ratio = shear_rate / critical
    if law.kind == SHEAR_THINNING_LAWS.cross_1965:
        factor, slope = _cross_1965(law.exponent, ratio)
    else:
        factor, slope = _carreau_1972(law.exponent, ratio)
    m = law.high_shear_ratio
    return m + (1.0 - m) * factor, (1.0 - m) * slope / critical


@compilable
def _cross_tangent(n: float, ratio: Any) -> tuple[Any, Any]:
    """Return d(x F)/dx and its derivative for the F of `_cross_1965` and x = gamma'/gamma'_c."""
    power = ratio**n
    factor = 1.0 / (1.0 + power)
    slope = n * power / np.maximum(ratio, 1e-30) * factor**2
    return factor - n * power * factor**2, slope * (2.0 * n * power * factor - n - 1.0)


@compilable
def _carreau_tangent(n: float, ratio: Any) -> tuple[Any, Any]:
    """Return d(x F)/dx and its derivative for the F of `_carreau_1972` and x = gamma'/gamma'_c."""
    square = 1.0 + ratio**2
    factor = square ** ((n - 1.0) / 2.0)
    share = (1.0 + n * ratio**2) / square
    slope = (n - 1.0) * ratio * factor / square
    return factor * share, slope * (share + 2.0 / square)


@compilable
def tangent_thinning(law: Thinning, shear_rate: float, temperature: float) -> tuple[float, float]:
    """Return mu_t/mu_0 [-] and its derivative [s], Eq. (O10), as `thinning`."""
    critical = _critical_shear_rate(law, temperature)
    ratio = shear_rate / critical
    if law.kind == SHEAR_THINNING_LAWS.cross_1965:
        factor, slope = _cross_tangent(law.exponent, ratio)
    else:
        factor, slope = _carreau_tangent(law.exponent, ratio)
    m = law.high_shear_ratio
    share = 1.0 - m if factor > 0.0 else 0.0  # Eq. (O10)
    return m + share * factor, share * slope / critical


# ---- the oil


@dataclass(frozen=True)
class Oil:
    """Oil by its laws and their constants.

    Each constant is declared here, once: unit, default, range and meaning.

    >>> oil = Oil(viscosity_law="two_point", viscosity_40=0.06, viscosity_100=0.009)
    >>> print(f"{oil.low_shear_viscosity(343.15):.4f} Pa s")
    0.0198 Pa s
    """

    viscosity_law: str = choice(VISCOSITY_LAWS._fields)
    """Dependence of the viscosity on temperature."""
    pressure_viscosity_law: str = choice(PRESSURE_VISCOSITY_LAWS._fields)
    """Dependence of the viscosity on pressure."""
    shear_thinning_law: str = choice(SHEAR_THINNING_LAWS._fields)
    """Dependence of the viscosity on shear rate."""

    # Eqs. (O1) to (O3)
    viscosity: float = declared("Pa.s", 0.01, 1e-5, 1e3)
    """Dynamic viscosity for the law constant."""
    vogel_viscosity: float = declared("Pa.s", 6.51457e-5, 1e-9, 1e2)
    """Constant K of the law vogel_1921: mu = K exp[B/(t + C)]."""
    vogel_b: float = declared("K", 1009.863, 0.0, 1e4)
    """Constant B of the law vogel_1921."""
    vogel_c: float = declared("K", 109.047, 50.0, 300.0)
    """Constant C of the law vogel_1921, with the temperature T_o in degrees Celsius."""
    walther_a: float = declared("1", 8.0, 1.0, 20.0)
    """Constant A of the law walther_1931: lg lg(nu + 0.7) = A - M lg T."""
    walther_m: float = declared("1", 3.1, 0.1, 8.0)
    """Constant M of the law walther_1931."""
    density: float = declared("kg/m3", 850.0, 500.0, 2000.0)
    """Density for the laws walther_1931 and two_point."""
    viscosity_40: float = declared("Pa.s", 0.06, 1e-3, 1e2)
    """Dynamic viscosity at 40 degC for the law two_point."""
    viscosity_100: float = declared("Pa.s", 0.009, 5e-4, 1e1)
    """Dynamic viscosity at 100 degC for the law two_point."""

    # Eqs. (O4), (O5)
    pressure_viscosity_coefficient: float = declared("1/Pa", 1.5e-8, 1e-10, 1e-7)
    """Pressure-viscosity coefficient alpha = d ln mu/dp at p = 0."""

    # Eqs. (O7) to (O9)
    high_shear_ratio: float = declared("1", 0.74, 1e-3, 1.0)
    """Ratio of the viscosity at high shear rate to that at low shear rate."""
    shear_thinning_exponent: float = declared("1", 1.0, 0.1, 4.0)
    """Exponent n of the shear-thinning law; below 1 for carreau_1972."""
    critical_shear_rate_a: float = declared("1", 2.5, -5.0, 15.0)
    """Constant a of the critical shear rate [1/s]: lg gamma'_c = a + b T_o."""
    critical_shear_rate_b: float = declared("1/K", 0.0213, -0.1, 0.1)
    """Constant b of the critical shear rate, with the temperature T_o in degrees Celsius."""

    @property
    def thinning(self) -> Thinning:
        """Law of shear thinning."""
        return thinning_law(getattr(SHEAR_THINNING_LAWS, self.shear_thinning_law), self)

    def low_shear_viscosity(self, temperature: Array) -> Array:
        """Return mu_0 [Pa s] at a temperature [K] (float or ndarray), Eqs. (O1) to (O3)."""
        kind = getattr(VISCOSITY_LAWS, self.viscosity_law)
        return low_shear_viscosity(kind, self, temperature)
