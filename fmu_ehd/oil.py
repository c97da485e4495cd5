"""Viscosity of the oil: by temperature, by pressure, by shear rate, each law chosen by name.

By temperature: vogel_1921, with t [C], K [Pa s], B and C [K]; walther_1931, with nu [mm2/s] and T
[K], as in ASTM D341; two_point, Eq. (O2) through mu_0 at 40 C and at 100 C.

Eq. (O1):  mu_0 = K exp(B / (t + C))
Eq. (O2):  lg lg(nu + 0.7) = A - M lg T,   mu_0 = rho nu
Eq. (O3):  M = [lg lg(nu_1 + 0.7) - lg lg(nu_2 + 0.7)] / lg(T_2 / T_1)

By pressure (piezoviscosity): barus_1893 and roelands_1966.

Eq. (O4):  mu = mu_0 exp(alpha p)
Eq. (O5):  mu = mu_0 exp{(ln mu_0 + 9.67) [(1 + p / 1.96e8)^Z - 1]},
           Z = alpha 1.96e8 / (ln mu_0 + 9.67)

Reduced pressure, in which the film balance is linear:

Eq. (O6):  q = int_0^p mu_0/mu dp

By shear rate g = |V|/h, with the high-shear ratio m and the critical shear rate g_c [1/s]:
cross_1965 and carreau_1972.

Eq. (O7):  mu/mu_0 = m + (1 - m) / [1 + (g/g_c)^n]
Eq. (O8):  mu/mu_0 = m + (1 - m) [1 + (g/g_c)^2]^((n-1)/2)
Eq. (O9):  lg g_c = a + b t

The shear rate is that of sliding: the film of a skirt is sheared by |V|/h, pressure flow adds
little, and so the thinned viscosity is a function of film and velocity in the same cell, with an
exact derivative. Eq. (O6) is exact where alpha and Z do not vary over the film; with a temperature
field Z belongs to the mean of mu_0.

References
----------
[Vogel1921] H. Vogel, Phys. Z. 22 (1921) 645.
[Walther1931] C. Walther, Erdoel und Teer 7 (1931) 382; ASTM D341.
[Barus1893] C. Barus, Am. J. Sci. 45 (1893) 87.
[Roelands1966] C. J. A. Roelands, thesis, Delft 1966.
[Cross1965] M. M. Cross, J. Colloid Sci. 20 (1965) 417.
[Carreau1972] P. J. Carreau, Trans. Soc. Rheol. 16 (1972) 99.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .declaration import choice, declared
from .grid import Array

ZERO_CELSIUS = 273.15  # [K]
POLE_PRESSURE = 1.96e8  # [Pa], Eq. (O5)
POLE_LOGARITHM = 9.67  # -ln(6.31e-5 Pa s), Eq. (O5)
# mu/mu_0 up to which a pressure law holds: beyond it the oil is next to a glass
LARGEST_RATIO = 1e3
TABLE_CELLS = 2000  # of Eq. (O6): interpolation error below 1 mPa
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)  # in each cell of the table


# ---- temperature


def _constant(oil: Oil, temperature: Array) -> Array:
    return np.full_like(temperature, oil.viscosity, dtype=float)


def _vogel_1921(oil: Oil, temperature: Array) -> Array:
    celsius = temperature - ZERO_CELSIUS
    return oil.vogel_viscosity * np.exp(oil.vogel_b / (celsius + oil.vogel_c))  # Eq. (O1)


def walther_viscosity(a: float, m: float, temperature: Array) -> Array:
    """Kinematic viscosity [m2/s] at a temperature [K], Eq. (O2)."""
    return 1e-6 * (10.0**10.0 ** (a - m * np.log10(temperature)) - 0.7)  # Eq. (O2)


def walther_constants(
    viscosities: Sequence[float], temperatures: Sequence[float]
) -> tuple[float, float]:
    """A and M of Eq. (O2) through two kinematic viscosities [m2/s] at two temperatures [K]."""
    thick, thin = np.log10(np.log10(1e6 * np.asarray(viscosities) + 0.7))
    cold, hot = temperatures
    m = (thick - thin) / np.log10(hot / cold)  # Eq. (O3)
    return thick + m * np.log10(cold), m


def _walther_1931(oil: Oil, temperature: Array) -> Array:
    return oil.density * walther_viscosity(oil.walther_a, oil.walther_m, temperature)


def _two_point(oil: Oil, temperature: Array) -> Array:
    a, m = walther_constants(
        (oil.viscosity_40 / oil.density, oil.viscosity_100 / oil.density),
        (ZERO_CELSIUS + 40.0, ZERO_CELSIUS + 100.0),
    )
    return oil.density * walther_viscosity(a, m, temperature)


VISCOSITY_LAWS: dict[str, Callable[[Oil, Array], Array]] = {
    "constant": _constant,
    "vogel_1921": _vogel_1921,
    "walther_1931": _walther_1931,
    "two_point": _two_point,
}


def vogel_constants(
    viscosities: Sequence[float], temperatures: Sequence[float]
) -> tuple[float, float, float]:
    """K [Pa s], B and C [K] of Eq. (O1) through three dynamic viscosities [Pa s] at three
    temperatures [K].

    The ratio of the two logarithmic viscosity steps is linear in C; B and K follow.
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


def _cross_1965(n: float, ratio: Any) -> tuple[Any, Any]:
    """(mu - m mu_0) / (mu_0 - m mu_0) and its derivative to g/g_c, Eq. (O7)."""
    power = ratio**n
    factor = 1.0 / (1.0 + power)  # Eq. (O7)
    return factor, -n * power / np.maximum(ratio, 1e-30) * factor**2


def _carreau_1972(n: float, ratio: Any) -> tuple[Any, Any]:
    """The same by Eq. (O8)."""
    factor = (1.0 + ratio**2) ** ((n - 1.0) / 2.0)  # Eq. (O8)
    return factor, (n - 1.0) * ratio * factor / (1.0 + ratio**2)


def _no_thinning(n: float, ratio: Any) -> tuple[Any, Any]:
    return np.ones_like(ratio), np.zeros_like(ratio)


SHEAR_THINNING_LAWS = {
    "none": _no_thinning,
    "cross_1965": _cross_1965,
    "carreau_1972": _carreau_1972,
}


# ---- pressure


class Piezoviscosity:
    """A pressure law up to mu/mu_0 = `LARGEST_RATIO` at the pressure `limit`, constant viscosity
    beyond.

    Without the limit q would be bounded and a hard squeeze would have no pressure at all; with it
    the pressure of any q exists and grows steeply. Skirt films stay far below it.
    """

    limit: float

    def ratio(self, pressure: Any) -> tuple[Any, Any]:
        """mu/mu_0 [-] and its derivative to p [1/Pa]."""
        ratio, slope = self._ratio(np.minimum(pressure, self.limit))
        return ratio, np.where(pressure < self.limit, slope, 0.0)

    def reduced(self, pressure: Any) -> Any:
        """q [Pa] of p [Pa], Eq. (O6)."""
        return (
            self._reduced(np.minimum(pressure, self.limit))
            + np.maximum(pressure - self.limit, 0.0) / LARGEST_RATIO
        )

    def pressure(self, reduced: Any) -> Any:
        """p [Pa] of q [Pa]."""
        most = self._reduced(np.array(self.limit))
        return (
            self._pressure(np.minimum(reduced, most))
            + np.maximum(reduced - most, 0.0) * LARGEST_RATIO
        )

    # of each law, below its limit

    def _ratio(self, pressure: Any) -> tuple[Any, Any]:
        raise NotImplementedError

    def _reduced(self, pressure: Any) -> Any:
        raise NotImplementedError

    def _pressure(self, reduced: Any) -> Any:
        raise NotImplementedError


class Barus1893(Piezoviscosity):
    """Eq. (O4), with q = (1 - exp(-alpha p)) / alpha by Eq. (O6).

    Parameters
    ----------
    alpha : float
        [1/Pa].
    low_shear_viscosity : float
        Unused: alpha is a constant of this law.
    """

    def __init__(self, alpha: float, low_shear_viscosity: float):
        self.alpha = alpha
        self.limit = np.log(LARGEST_RATIO) / alpha

    def _ratio(self, pressure):
        ratio = np.exp(self.alpha * pressure)  # Eq. (O4)
        return ratio, self.alpha * ratio

    def _reduced(self, pressure):
        return -np.expm1(-self.alpha * pressure) / self.alpha  # Eq. (O6)

    def _pressure(self, reduced):
        return -np.log1p(-self.alpha * reduced) / self.alpha


def _hermite(x, nodes, values, slopes):
    """Cubic Hermite interpolation on nodes that need not be equally spaced."""
    k = np.clip(np.searchsorted(nodes, x) - 1, 0, nodes.size - 2)
    step = nodes[k + 1] - nodes[k]
    t = (x - nodes[k]) / step
    rise = values[k + 1] - values[k]
    m0 = slopes[k] * step
    m1 = slopes[k + 1] * step
    return values[k] + t * (m0 + t * (3.0 * rise - 2.0 * m0 - m1 + t * (m0 + m1 - 2.0 * rise)))


class Roelands1966(Piezoviscosity):
    """Eq. (O5), with Eq. (O6) in both directions from a table with exact slopes.

    Parameters
    ----------
    alpha : float
        Slope of ln mu at p = 0 [1/Pa].
    low_shear_viscosity : float
        mu_0 [Pa s].
    """

    def __init__(self, alpha: float, low_shear_viscosity: float):
        self.level = np.log(low_shear_viscosity) + POLE_LOGARITHM
        self.z = alpha * POLE_PRESSURE / self.level
        growth = np.log(LARGEST_RATIO) / self.level + 1.0
        self.limit = POLE_PRESSURE * (growth ** (1.0 / self.z) - 1.0)
        self._nodes = np.linspace(0.0, self.limit, TABLE_CELLS + 1)
        half = 0.5 * self._nodes[1]
        points = self._nodes[:-1, None] + half * (1.0 + GAUSS_NODES)
        parts = (half * GAUSS_WEIGHTS / self._ratio(points)[0]).sum(axis=1)
        self._reduced_nodes = np.concatenate([[0.0], np.cumsum(parts)])  # Eq. (O6)
        self._ratio_nodes = self._ratio(self._nodes)[0]

    def _ratio(self, pressure):
        base = np.maximum(1.0 + pressure / POLE_PRESSURE, 1e-3)
        ratio = np.exp(self.level * (base**self.z - 1.0))  # Eq. (O5)
        return ratio, ratio * self.level * self.z / POLE_PRESSURE * base ** (self.z - 1.0)

    def _reduced(self, pressure):
        return _hermite(pressure, self._nodes, self._reduced_nodes, 1.0 / self._ratio_nodes)

    def _pressure(self, reduced):
        return _hermite(reduced, self._reduced_nodes, self._nodes, self._ratio_nodes)


PRESSURE_VISCOSITY_LAWS: dict[str, type[Barus1893] | type[Roelands1966] | None] = {
    "none": None,
    "barus_1893": Barus1893,
    "roelands_1966": Roelands1966,
}


# ---- the oil


@dataclass(frozen=True)
class Oil:
    """An oil by its laws and their constants. Each is declared here, once: unit, default, range
    and meaning.
    """

    viscosity_law: str = choice("Viscosity by temperature", VISCOSITY_LAWS)
    pressure_viscosity_law: str = choice("Viscosity by pressure", PRESSURE_VISCOSITY_LAWS)
    shear_thinning_law: str = choice("Viscosity by shear rate", SHEAR_THINNING_LAWS)

    # Eqs. (O1) to (O3)
    viscosity: float = declared("Pa.s", 0.01, 1e-5, 1e3, "Dynamic viscosity (constant)")
    vogel_viscosity: float = declared(
        "Pa.s", 6.51457e-5, 1e-9, 1e2, "K of mu = K exp(B/(t + C)) (vogel_1921)"
    )
    vogel_b: float = declared("K", 1009.863, 0.0, 1e4, "B (vogel_1921)")
    vogel_c: float = declared("K", 109.047, 50.0, 300.0, "C, t in degrees Celsius (vogel_1921)")
    walther_a: float = declared(
        "1", 8.0, 1.0, 20.0, "A of lg lg(nu + 0.7) = A - M lg T (walther_1931)"
    )
    walther_m: float = declared("1", 3.1, 0.1, 8.0, "M (walther_1931)")
    density: float = declared("kg/m3", 850.0, 500.0, 2000.0, "Density (walther_1931, two_point)")
    viscosity_40: float = declared("Pa.s", 0.06, 1e-3, 1e2, "Dynamic viscosity at 40 C (two_point)")
    viscosity_100: float = declared(
        "Pa.s", 0.009, 5e-4, 1e1, "Dynamic viscosity at 100 C (two_point)"
    )

    # Eqs. (O4), (O5)
    pressure_viscosity_coefficient: float = declared(
        "1/Pa", 1.5e-8, 1e-10, 1e-7, "alpha = d ln mu/dp at p = 0"
    )

    # Eqs. (O7) to (O9)
    high_shear_ratio: float = declared(
        "1", 0.74, 1e-3, 1.0, "Viscosity at high over low shear rate"
    )
    shear_thinning_exponent: float = declared(
        "1", 1.0, 0.1, 4.0, "n of the shear thinning law, below 1 in carreau_1972"
    )
    critical_shear_rate_a: float = declared(
        "1", 2.5, -5.0, 15.0, "a of lg g_c = a + b t, g_c critical shear rate in 1/s"
    )
    critical_shear_rate_b: float = declared("1/K", 0.0213, -0.1, 0.1, "b, t in degrees Celsius")

    @property
    def thins(self) -> bool:
        """Whether the viscosity depends on the shear rate."""
        return self.shear_thinning_law != "none"

    def low_shear_viscosity(self, temperature: Array) -> Array:
        """mu_0 [Pa s] at a temperature [K] (float or ndarray), Eqs. (O1) to (O3)."""
        return VISCOSITY_LAWS[self.viscosity_law](self, temperature)

    def thinning(self, shear_rate: Any, temperature: Any) -> tuple[Any, Any]:
        """mu/mu_0 [-] and its derivative [s] at a shear rate [1/s] and temperature [K], Eqs. (O7)
        to (O9).
        """
        celsius = temperature - ZERO_CELSIUS
        exponent = self.critical_shear_rate_a + self.critical_shear_rate_b * celsius
        critical = 10.0**exponent  # Eq. (O9)
        law = SHEAR_THINNING_LAWS[self.shear_thinning_law]
        factor, slope = law(self.shear_thinning_exponent, shear_rate / critical)
        m = self.high_shear_ratio
        return m + (1.0 - m) * factor, (1.0 - m) * slope / critical

    def piezoviscosity(self, low_shear_viscosity: float) -> Piezoviscosity | None:
        """The pressure law of an oil whose mean mu_0 is given [Pa s]; None without one."""
        law = PRESSURE_VISCOSITY_LAWS[self.pressure_viscosity_law]
        if law is None:
            return None
        return law(self.pressure_viscosity_coefficient, low_shear_viscosity)
