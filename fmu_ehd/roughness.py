"""Average flow between rough surfaces: average gap and the flow and shear stress factors of Patir
and Cheng.

With H = h/sigma and Gaussian heights:

Eq. (R1):  h_T/sigma = H/2 (1 + erf(H/sqrt 2)) + (2 pi)^-1/2 exp(-H^2/2)

Pressure flow, for Peklenik numbers up to 1 and above 1:

Eq. (R2):  phi_x = 1 - C exp(-r H);   phi_x = 1 + C H^-r;   phi_y(H, gamma) = phi_x(H, 1/gamma)

Shear flow, for H up to 5 and above 5:

Eq. (R3):  Phi_s = A1 H^a1 exp(-a2 H + a3 H^2);   Phi_s = A2 exp(-H/4)

Couette stress, heights (35/96)(1 - (s/3)^2)^3, local films cut off at sigma/100:

Eq. (R4):  phi_f = h E(1/h_T)

Roughness-induced stress, for H below 7 and from 7 on:

Eq. (R5):  Phi_fs = A3 H^a4 exp(-a5 H + a6 H^2);   Phi_fs = 0

Stress of the pressure gradient:

Eq. (R6):  phi_fp = 1 - D exp(-s H)

Skirt (s) and bore (b) have roughness of their own. With the skirt's share Y of the variance, what a
film is made of (`films`) is

Eq. (R7):  phi = Y phi(H, gamma_s) + (1 - Y) phi(H, gamma_b)            of phi_x, phi_y, Phi_fs
Eq. (R8):  Phi = Y Phi(H, gamma_s) - (1 - Y) Phi(H, gamma_b)            of Phi_s, phi_fp - 1

(R8) of Phi_s is the published one. (R7) is published for equal gamma; the deviations of slight
roughness add up in the variances, whatever the gammas, so it is exact for H >> 1.

Peklenik number gamma = correlation length along / across the sliding direction: > 1 grooves along,
< 1 grooves across. The factors are published for seven values of gamma from 1/9 to 9; between them
the factors (not their coefficients, whose formula changes at gamma = 1) are interpolated linearly
in ln gamma. Below the published range of H, which starts between 0.5 and 1, phi_x and phi_fp keep
their value; the others go on by their formula, which ends well at H = 0.

What confirms the table: (R2) stands in several public sources. The two branches of (R3) meet at H =
5 to the printed digits for all seven gamma, which ties six numbers of each row together
(tests/ehd/test_films.py). For gamma = 1 the open code of R. Boman (github.com/rboman/progs,
apps/EHD, read for comparison) has the same (R4) to (R6), and its line A2 = 1.0766 - 0.3776 ln
gamma, fitted through all gamma, passes within 0.11 of every A2 here. For the rows of (R5) and (R6)
with gamma other than 1 no second source is known, but (R6) follows from (R1) and (R3): what a
pressure gradient does to a sliding surface and what sliding carries through the film have one
coefficient, phi_fp H = h_T/sigma - Phi_s for each gamma within 0.03 H
(tests/ehd/test_values_surfaces.py).

References
----------
[Patir1978] N. Patir, H. S. Cheng, An average flow model for determining effects of
three-dimensional roughness on partial hydrodynamic lubrication, J. Lubr. Technol. 100 (1978) 12-17
(R2).
[Patir1979] N. Patir, H. S. Cheng, Application of average flow model to lubrication between rough
sliding surfaces, J. Lubr. Technol. 101 (1979) 220-229 (R3 to R6).
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from .grid import Array

FLOW_FACTORS = ("none", "patir_cheng_1978")

# functions of the table, in its order: h_T/sigma - H, phi across i and along j, Phi_s, phi_f,
# Phi_fs, phi_fp, each less its limit for smooth surfaces, by Eqs. (R7), (R8)
(
    GAP_EXCESS,
    FLOW_FACTOR_C,
    FLOW_FACTOR_A,
    SHEAR_FLOW_FACTOR,
    COUETTE_FACTOR,
    DRAG_FACTOR,
    POISEUILLE_FACTOR,
) = range(7)
FACTORS = 7


class Row(NamedTuple):
    """Published coefficients for one Peklenik number gamma [-]; names as in Eqs. (R2) to (R6), the
    s of Eq. (R6) as s1; `lowest` is the smallest published H of Eq. (R2).
    """

    gamma: float
    C: float
    r: float
    lowest: float
    A1: float
    a1: float
    a2: float
    a3: float
    A2: float
    A3: float
    a4: float
    a5: float
    a6: float
    D: float
    s1: float


# columns: gamma | C, r, lowest H of (R2) | A1, a1, a2, a3, A2 of (R3) | A3, a4, a5, a6 of (R5)
# | D, s of (R6)
# fmt: off
COEFFICIENTS = tuple(Row._make(numbers) for numbers in (
    (1 / 9, 1.48, 0.42, 1.00, 2.046, 1.12, 0.78, 0.03, 1.856, 14.1, 2.45, 2.30, 0.10, 1.51, 0.52),
    (1 / 6, 1.38, 0.42, 1.00, 1.962, 1.08, 0.77, 0.03, 1.754, 13.4, 2.42, 2.30, 0.10, 1.51, 0.54),
    (1 / 3, 1.18, 0.42, 0.75, 1.858, 1.01, 0.76, 0.03, 1.561, 12.3, 2.32, 2.30, 0.10, 1.47, 0.58),
    (1.0, 0.90, 0.56, 0.50, 1.899, 0.98, 0.92, 0.05, 1.126, 11.1, 2.31, 2.38, 0.11, 1.40, 0.66),
    (3.0, 0.225, 1.5, 0.50, 1.560, 0.85, 1.13, 0.08, 0.556, 9.8, 2.25, 2.80, 0.18, 0.98, 0.79),
    (6.0, 0.520, 1.5, 0.50, 1.290, 0.62, 1.09, 0.08, 0.388, 10.1, 2.25, 2.90, 0.18, 0.97, 0.91),
    (9.0, 0.870, 1.5, 0.50, 1.011, 0.54, 1.07, 0.08, 0.295, 8.7, 2.15, 2.97, 0.18, 0.73, 0.91),
))
# fmt: on
PEKLENIK = np.array([row.gamma for row in COEFFICIENTS])
LOWEST = 0.5  # start of the published range of (R6)
# H beyond which the factors keep their last value, within 0.5 % of smooth surfaces
TABLE_END = 32.0
TABLE_CELLS = 2048
CUT_OFF = 1.0 / 300.0  # smallest local film of (R4), sigma/100 in units of 3 sigma


def average_gap(separation: Any) -> Any:
    """Average gap of Gaussian surfaces over sigma, Eq. (R1), for H = h/sigma [-] of any sign."""
    from scipy.special import erf  # slow to import, and smooth films do without

    above = 0.5 * separation * (1.0 + erf(separation / np.sqrt(2.0)))
    tail = np.exp(-(separation**2) / 2.0) / np.sqrt(2.0 * np.pi)
    return above + tail  # Eq. (R1)


def _between(formula: Callable[[Row], Any], gamma: float) -> Any:
    """A factor between published Peklenik numbers, linear in ln gamma."""
    x = np.log(gamma)
    known = np.log(PEKLENIK)
    k = min(max(int(np.searchsorted(known, x)) - 1, 0), known.size - 2)
    weight = (x - known[k]) / (known[k + 1] - known[k])
    return (1.0 - weight) * formula(COEFFICIENTS[k]) + weight * formula(COEFFICIENTS[k + 1])


def _from(separation: Any, lowest: float) -> Any:
    """H held at the lowest published value (works for complex steps too)."""
    return np.where(np.real(separation) < lowest, lowest, separation)


def pressure_flow_factor(separation: Any, gamma: float) -> Any:
    """Pressure flow factor phi_x along sliding, Eq. (R2), for H [-] and Peklenik number gamma from
    1/9 to 9.
    """

    def formula(row):
        h = _from(separation, row.lowest)
        if row.gamma <= 1.0:
            return 1.0 - row.C * np.exp(-row.r * h)  # Eq. (R2)
        return 1.0 + row.C * h**-row.r

    return _between(formula, gamma)


def shear_flow_factor(separation: Any, gamma: float) -> Any:
    """Shear flow factor Phi_s of one rough surface, Eq. (R3)."""
    h = np.asarray(separation)

    def formula(row):
        near = row.A1 * h**row.a1 * np.exp(-row.a2 * h + row.a3 * h * h)
        far = row.A2 * np.exp(-0.25 * h)
        return np.where(np.real(h) <= 5.0, near, far)  # Eq. (R3)

    return _between(formula, gamma)


def shear_stress_factor(separation: Any) -> Any:
    """Factor phi_f of the mean Couette stress, Eq. (R4) in closed form; Eq. (R4) by moments for H >
    30.
    """
    z = np.asarray(separation) / 3.0
    with np.errstate(divide="ignore", invalid="ignore"):
        cube = (1.0 - z * z) ** 3
        polynomial = -55.0 + z * (
            132.0 + z * (345.0 + z * (-160.0 + z * (-405.0 + z * (60.0 + 147.0 * z))))
        )
        logarithm = np.log((z + 1.0) / CUT_OFF)
        near = 35.0 / 32.0 * z * (cube * logarithm + polynomial / 60.0)  # Eq. (R4)
        logarithm = np.log((z + 1.0) / (z - 1.0))
        polynomial = z / 15.0 * (66.0 + z * z * (30.0 * z * z - 80.0))
        middle = 35.0 / 32.0 * z * (cube * logarithm + polynomial)
        far = 1.0 + (3.0 * z) ** -2.0 + 27.0 / 11.0 * (3.0 * z) ** -4.0
    return np.where(np.real(z) <= 1.0, near, np.where(np.real(z) <= 10.0, middle, far))


def sliding_stress_factor(separation: Any, gamma: float) -> Any:
    """Factor Phi_fs of the roughness-induced stress of one rough surface, Eq. (R5)."""
    h = np.asarray(separation)

    def formula(row):
        near = row.A3 * h**row.a4 * np.exp(-row.a5 * h + row.a6 * h * h)
        return np.where(np.real(h) < 7.0, near, 0.0)  # Eq. (R5)

    return _between(formula, gamma)


def pressure_stress_factor(separation: Any, gamma: float) -> Any:
    """Factor phi_fp of the pressure-gradient stress, Eq. (R6)."""
    h = _from(separation, LOWEST)
    return _between(lambda row: 1.0 - row.D * np.exp(-row.s1 * h), gamma)  # Eq. (R6)


@cache
def factor_table(share: float, gamma_skirt: float, gamma_bore: float) -> Array:
    """Deviations of all factors from their smooth limit on a uniform grid of H from 0 to
    `TABLE_END`.

    Parameters
    ----------
    share : float
        Y, the skirt's share of the variance [-], 0 to 1.
    gamma_skirt, gamma_bore : float
        Peklenik numbers of the axial (sliding) direction [-], 1/9 to 9.

    Returns
    -------
    ndarray, shape (TABLE_CELLS + 1, 14)
        Values and slopes side by side: h_T/sigma - H, phi_c - 1 across i, phi_a - 1 along j,
        Phi_s, phi_f - 1, Phi_fs, phi_fp - 1 [-], by Eqs. (R7), (R8).
    """

    def both(factor: Callable[[float], Any]) -> Any:
        return share * factor(gamma_skirt) + (1.0 - share) * factor(gamma_bore)  # Eq. (R7)

    def against(factor: Callable[[float], Any]) -> Any:
        return share * factor(gamma_skirt) - (1.0 - share) * factor(gamma_bore)  # Eq. (R8)

    points = np.linspace(0.0, TABLE_END, TABLE_CELLS + 1)
    separation = points + 1e-30j  # complex step: slopes to round-off
    separation[0] += 1e-12  # 0 to a power has no complex logarithm
    factors = {
        GAP_EXCESS: average_gap(separation) - separation,
        FLOW_FACTOR_C: both(lambda g: pressure_flow_factor(separation, 1.0 / g)) - 1.0,
        FLOW_FACTOR_A: both(lambda g: pressure_flow_factor(separation, g)) - 1.0,
        SHEAR_FLOW_FACTOR: against(lambda g: shear_flow_factor(separation, g)),
        COUETTE_FACTOR: shear_stress_factor(separation) - 1.0,
        DRAG_FACTOR: both(lambda g: sliding_stress_factor(separation, g)),
        POISEUILLE_FACTOR: against(lambda g: pressure_stress_factor(separation, g) - 1.0),
    }
    table = np.empty((points.size, 2 * FACTORS))
    for k, factor in factors.items():
        table[:, 2 * k] = factor.real
        table[:, 2 * k + 1] = np.imag(factor) * 1e30
    # H^a1 with a1 < 1 has no slope at 0: a cubic without curvature there
    value = 2 * SHEAR_FLOW_FACTOR
    slope = value + 1
    rise = (table[1, value] - table[0, value]) * TABLE_CELLS / TABLE_END
    table[0, slope] = 1.5 * rise - 0.5 * table[1, slope]
    return table
