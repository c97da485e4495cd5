"""Viscosity of the oil: by temperature, by pressure, by shear rate, each law chosen by name.

Eq. (O1):  vogel_1921:    mu_0 = K exp(B / (t + C))                             t temperature [C], K [Pa s], B, C [K]
Eq. (O2):  walther_1931:  lg lg(nu + 0.7) = A - M lg T,  mu_0 = rho nu           nu [mm2/s], T [K], as in ASTM D341
Eq. (O3):  two_point:     Eq. (O2) through mu_0 at 40 C and at 100 C
Eq. (O4):  barus_1893:    mu = mu_0 exp(alpha p)
Eq. (O5):  roelands_1966: mu = mu_0 exp{(ln mu_0 + 9.67) [(1 + p / 1.96e8)^Z - 1]},   Z = alpha 1.96e8 / (ln mu_0 + 9.67)
Eq. (O6):  q = int_0^p mu_0/mu dp                                               reduced pressure: the film balance is linear in q
Eq. (O7):  cross_1965:    mu/mu_0 = m + (1 - m) / [1 + (g/g_c)^n]                g shear rate |V|/h, m high-shear ratio
Eq. (O8):  carreau_1972:  mu/mu_0 = m + (1 - m) [1 + (g/g_c)^2]^((n-1)/2)
Eq. (O9):  lg g_c = a + b t                                                     critical shear rate [1/s]

The shear rate is that of sliding: the film of a skirt is sheared by |V|/h, pressure flow adds
little, and so the thinned viscosity is a function of film and velocity in the same cell, with an
exact derivative. Eq. (O6) is exact where alpha and Z do not vary over the film; with a temperature
field Z belongs to the mean of mu_0.

References ---------- [Vogel1921] H. Vogel, Phys. Z. 22 (1921) 645. [Walther1931] C. Walther, Erdoel
und Teer 7 (1931) 382; ASTM D341. [Barus1893] C. Barus, Am. J. Sci. 45 (1893) 87. [Roelands1966] C.
J. A. Roelands, thesis, Delft 1966. [Cross1965] M. M. Cross, J. Colloid Sci. 20 (1965) 417.
[Carreau1972] P. J. Carreau, Trans. Soc. Rheol. 16 (1972) 99.
"""

from dataclasses import dataclass

import numpy as np

ZERO_CELSIUS = 273.15  # [K]
POLE_PRESSURE = 1.96e8  # [Pa], Eq. (O5)
POLE_LOGARITHM = 9.67  # -ln(6.31e-5 Pa s), Eq. (O5)
LARGEST_RATIO = (
    1e3  # mu/mu_0 up to which a pressure law holds: beyond it the oil is next to a glass
)
TABLE_CELLS = 2000  # of Eq. (O6): interpolation error below 1 mPa
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)  # in each cell of the table


@dataclass(frozen=True)
class Oil:
    """An oil by its laws and their constants; names, units and ranges in `variables.py`.

    Parameters
    ----------
    viscosity_law : str
        "constant", "vogel_1921", "walther_1931" or "two_point".
    pressure_viscosity_law : str
        "none", "barus_1893" or "roelands_1966".
    shear_thinning_law : str
        "none", "cross_1965" or "carreau_1972".
    viscosity : float
        mu_0 of "constant" [Pa s].
    vogel_viscosity, vogel_b, vogel_c : float
        K [Pa s], B, C [K].
    walther_a, walther_m : float
        A, M of Eq. (O2).
    density : float
        rho [kg/m3], of Eqs. (O2), (O3).
    viscosity_40, viscosity_100 : float
        Of Eq. (O3) [Pa s].
    pressure_viscosity_coefficient : float
        alpha [1/Pa].
    high_shear_ratio, shear_thinning_exponent : float
        m, n [-].
    critical_shear_rate_a, critical_shear_rate_b : float
        a [-], b [1/K] of Eq. (O9).
    """

    viscosity_law: str = "constant"
    pressure_viscosity_law: str = "none"
    shear_thinning_law: str = "none"
    viscosity: float = 0.01
    vogel_viscosity: float = 6.51457e-5
    vogel_b: float = 1009.863
    vogel_c: float = 109.047
    walther_a: float = 8.0
    walther_m: float = 3.1
    density: float = 850.0
    viscosity_40: float = 0.06
    viscosity_100: float = 0.009
    pressure_viscosity_coefficient: float = 1.5e-8
    high_shear_ratio: float = 0.74
    shear_thinning_exponent: float = 1.0
    critical_shear_rate_a: float = 2.5
    critical_shear_rate_b: float = 0.0213

    def low_shear_viscosity(self, temperature):
        """mu_0 [Pa s] at a temperature [K] (float or ndarray), Eqs. (O1) to (O3)."""
        return VISCOSITY_LAWS[self.viscosity_law](self, temperature)

    def thinning(self, shear_rate, temperature):
        """mu/mu_0 [-] and its derivative [s] at a shear rate [1/s] and temperature [K], Eqs. (O7)
        to (O9).
        """
        critical = 10.0 ** (
            self.critical_shear_rate_a + self.critical_shear_rate_b * (temperature - ZERO_CELSIUS)
        )  # Eq. (O9)
        factor, slope = SHEAR_THINNING_LAWS[self.shear_thinning_law](
            self.shear_thinning_exponent, shear_rate / critical
        )
        m = self.high_shear_ratio
        return m + (1.0 - m) * factor, (1.0 - m) * slope / critical

    def thickening(self, low_shear_viscosity):
        """The pressure law of an oil whose mean mu_0 is given [Pa s]."""
        return PRESSURE_VISCOSITY_LAWS[self.pressure_viscosity_law](
            self.pressure_viscosity_coefficient, low_shear_viscosity
        )


# ---- temperature
# --------------------------------------------------------------------------------------------------------


def _constant(oil, temperature):
    return np.full_like(temperature, oil.viscosity, dtype=float)


def _vogel_1921(oil, temperature):
    return oil.vogel_viscosity * np.exp(
        oil.vogel_b / (temperature - ZERO_CELSIUS + oil.vogel_c)
    )  # Eq. (O1)


def walther_viscosity(a, m, temperature):
    """Kinematic viscosity [m2/s] at a temperature [K], Eq. (O2)."""
    return 1e-6 * (10.0**10.0 ** (a - m * np.log10(temperature)) - 0.7)  # Eq. (O2)


def walther_constants(viscosities, temperatures):
    """A and M of Eq. (O2) through two kinematic viscosities [m2/s] at two temperatures [K]."""
    level = np.log10(np.log10(1e6 * np.asarray(viscosities) + 0.7))
    m = (level[0] - level[1]) / np.log10(temperatures[1] / temperatures[0])  # Eq. (O3)
    return level[0] + m * np.log10(temperatures[0]), m


def _walther_1931(oil, temperature):
    return oil.density * walther_viscosity(oil.walther_a, oil.walther_m, temperature)


def _two_point(oil, temperature):
    constants = walther_constants(
        (oil.viscosity_40 / oil.density, oil.viscosity_100 / oil.density),
        (ZERO_CELSIUS + 40.0, ZERO_CELSIUS + 100.0),
    )
    return oil.density * walther_viscosity(*constants, temperature)


VISCOSITY_LAWS = {
    "constant": _constant,
    "vogel_1921": _vogel_1921,
    "walther_1931": _walther_1931,
    "two_point": _two_point,
}


def vogel_constants(viscosities, temperatures):
    """K [Pa s], B and C [K] of Eq. (O1) through three dynamic viscosities [Pa s] at three
    temperatures [K].

    The ratio of the two logarithmic viscosity steps is linear in C; B and K follow.
    """
    t = np.asarray(temperatures) - ZERO_CELSIUS
    first, second = np.log(viscosities[0] / viscosities[1]), np.log(viscosities[1] / viscosities[2])
    near, far = first * (t[2] - t[1]), second * (t[1] - t[0])
    c = (far * t[2] - near * t[0]) / (near - far)
    b = first / (1.0 / (t[0] + c) - 1.0 / (t[1] + c))
    return viscosities[0] / np.exp(b / (t[0] + c)), b, c


# ---- shear rate
# ---------------------------------------------------------------------------------------------------------


def _cross_1965(n, ratio):
    """(mu - m mu_0) / (mu_0 - m mu_0) and its derivative to g/g_c, Eq. (O7)."""
    power = ratio**n
    factor = 1.0 / (1.0 + power)  # Eq. (O7)
    return factor, -n * power / np.maximum(ratio, 1e-30) * factor**2


def _carreau_1972(n, ratio):
    """The same by Eq. (O8)."""
    factor = (1.0 + ratio**2) ** ((n - 1.0) / 2.0)  # Eq. (O8)
    return factor, (n - 1.0) * ratio * factor / (1.0 + ratio**2)


SHEAR_THINNING_LAWS = {"none": None, "cross_1965": _cross_1965, "carreau_1972": _carreau_1972}


# ---- pressure
# -----------------------------------------------------------------------------------------------------------


class _Thickening:
    """A pressure law up to mu/mu_0 = `LARGEST_RATIO` at the pressure `limit`, constant viscosity
    beyond.

    Without the limit q would be bounded and a hard squeeze would have no pressure at all; with it
    the pressure of any q exists and grows steeply. Skirt films stay far below it.
    """

    def ratio(self, pressure):
        """mu/mu_0 [-] and its derivative to p [1/Pa]."""
        ratio, slope = self._ratio(np.minimum(pressure, self.limit))
        return ratio, np.where(pressure < self.limit, slope, 0.0)

    def reduced(self, pressure):
        """q [Pa] of p [Pa], Eq. (O6)."""
        return (
            self._reduced(np.minimum(pressure, self.limit))
            + np.maximum(pressure - self.limit, 0.0) / LARGEST_RATIO
        )

    def pressure(self, reduced):
        """p [Pa] of q [Pa]."""
        most = self._reduced(np.array(self.limit))
        return (
            self._pressure(np.minimum(reduced, most))
            + np.maximum(reduced - most, 0.0) * LARGEST_RATIO
        )


class Barus1893(_Thickening):
    """Eq. (O4): q = (1 - exp(-alpha p)) / alpha.

    Parameters
    ----------
    alpha : float
        [1/Pa].
    low_shear_viscosity : float
        Unused: alpha is a constant of this law.
    """

    def __init__(self, alpha, low_shear_viscosity):
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
    rise, m0, m1 = values[k + 1] - values[k], slopes[k] * step, slopes[k + 1] * step
    return values[k] + t * (m0 + t * (3.0 * rise - 2.0 * m0 - m1 + t * (m0 + m1 - 2.0 * rise)))


class Roelands1966(_Thickening):
    """Eq. (O5), with Eq. (O6) in both directions from a table with exact slopes.

    Parameters
    ----------
    alpha : float
        Slope of ln mu at p = 0 [1/Pa].
    low_shear_viscosity : float
        mu_0 [Pa s].
    """

    def __init__(self, alpha, low_shear_viscosity):
        self.level = np.log(low_shear_viscosity) + POLE_LOGARITHM
        self.z = alpha * POLE_PRESSURE / self.level
        self.limit = POLE_PRESSURE * (
            (np.log(LARGEST_RATIO) / self.level + 1.0) ** (1.0 / self.z) - 1.0
        )
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


PRESSURE_VISCOSITY_LAWS = {"none": None, "barus_1893": Barus1893, "roelands_1966": Roelands1966}
