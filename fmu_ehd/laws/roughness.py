"""Average flow between rough surfaces by Patir and Cheng.

Average gap, flow factors and shear stress factors.

With Lambda = h/sigma and Gaussian heights:

Eq. (R1):  h_T/sigma = Lambda/2 (1 + erf(Lambda/sqrt 2)) + (2 pi)^-1/2 exp(-Lambda^2/2)

Pressure flow, for Peklenik numbers up to 1 and above 1:

Eq. (R2):  phi_x = 1 - C exp(-r Lambda);   phi_x = 1 + C Lambda^-r
           phi_y(Lambda, gamma) = phi_x(Lambda, 1/gamma)

Shear flow, for Lambda up to 5 and above 5:

Eq. (R3):  Phi_s = A1 Lambda^a1 exp(-a2 Lambda + a3 Lambda^2);   Phi_s = A2 exp(-Lambda/4)

Couette stress, for the distribution of heights (35/96)(1 - (s/3)^2)^3, without local films below
sigma/100. In overlap, only the remaining local films count:

Eq. (R4):  phi_f/Lambda = sigma E(1/h_T)

Shear rate of the oil, as the mean over the remaining local films. V is the sliding velocity, h_s
the harmonic mean of these films, and P their share of the area:

Eq. (R9):  gamma' = V/h_s,   h_s/sigma = P(h_T > 0) / [sigma E(1/h_T)]

Roughness-induced stress, for Lambda below 7 and from 7 on:

Eq. (R5):  Phi_fs = A3 Lambda^a4 exp(-a5 Lambda + a6 Lambda^2);   Phi_fs = 0

Stress of the pressure gradient:

Eq. (R6):  phi_fp = 1 - D exp(-s Lambda)

Skirt (s) and bore (b) have separate roughness. With the skirt's share Y of the variance, the
factors of the film (`films`) are

Eq. (R7):  phi = Y phi(Lambda, gamma_s) + (1 - Y) phi(Lambda, gamma_b)   of phi_x, phi_y, Phi_fs
Eq. (R8):  Phi = Y Phi(Lambda, gamma_s) - (1 - Y) Phi(Lambda, gamma_b)   of Phi_s, phi_fp - 1

(R8) of Phi_s is the published one. (R7) is published for equal gamma. For other gammas it is exact
for Lambda >> 1, because the effects of slight roughness are additive in the variances.

Peklenik number gamma = correlation length along / across the sliding direction: > 1 grooves along,
< 1 grooves across. The factors are published for seven values of gamma from 1/9 to 9; between them
the factors (not their coefficients, whose formula changes at gamma = 1) are interpolated linearly
in ln gamma. Below the published range of Lambda, which starts between 0.5 and 1, phi_x and phi_fp
are constant. The others follow their formula, Phi_s and Phi_fs to 0 at Lambda = 0. In overlap,
Lambda < 0, (R1) and (R4) are valid. They describe the remaining gap of two surfaces that are
pressed together, and its drag, which ends at Lambda = -3. Below Lambda = -2.7, where the drag is
2e-3 of that at Lambda = 0, (R9) is constant.

A bearing slides around its axis. Its parameters refer to the axis, so gamma is their inverse. The
journal corresponds to the skirt. The grid is at rest on the shell, so Phi_s of (R8) changes its
sign. For axial sliding, a bearing has the factors of circumferential sliding.

The following facts confirm the table. (R2) is in several public sources. The two branches of (R3)
meet at Lambda = 5 to the printed digits for all seven gamma, which ties six numbers of each row
together (tests/ehd/test_films.py). For gamma = 1 the open code of R. Boman
(github.com/rboman/progs, apps/EHD, read for comparison) has the same (R4) to (R6). Its line A2 =
1.0766 - 0.3776 ln gamma, fitted through all gamma, passes within 0.11 of every A2 here. For the
rows of (R5) and (R6) with gamma other than 1 no second source is known, but (R6) follows from (R1)
and (R3): the effect of a pressure gradient on a sliding surface and the flow by sliding have one
coefficient. For each gamma, phi_fp Lambda = h_T/sigma - Phi_s within 0.03 Lambda
(tests/ehd/test_values_surfaces.py).

References
----------
[Patir1978] N. Patir, H. S. Cheng, An average flow model for determining effects of
three-dimensional roughness on partial hydrodynamic lubrication, J. Lubr. Technol. 100 (1978) 12-17
(R2).
[Patir1979] N. Patir, H. S. Cheng, Application of average flow model to lubrication between rough
sliding surfaces, J. Lubr. Technol. 101 (1979) 220-229 (R3 to R6).
"""

from math import erf
from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled, numbered
from ..common.grid import Array

FLOW_FACTORS = ("none", "patir_cheng_1978")

# functions of the table, in its order, by Eqs. (R7), (R8): h_T/sigma - Lambda; phi - 1 across i and
# along j; Phi_s; (phi_f + Phi_fs)/Lambda, which is finite at Lambda = 0; phi_fp - 1
FACTOR = numbered("gap_excess", "flow_c", "flow_a", "shear_flow", "drag", "poiseuille")
FACTORS = len(FACTOR)


class Row(NamedTuple):
    """Published coefficients for one Peklenik number gamma [-].

    Names are as in Eqs. (R2) to (R6), with the s of Eq. (R6) as s1; `lowest` is the smallest
    published Lambda of Eq. (R2).
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


# columns: gamma | C, r, lowest Lambda of (R2) | A1, a1, a2, a3, A2 of (R3) | A3, a4, a5, a6 of (R5)
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
LOGARITHMS = np.log(PEKLENIK)
LOWEST = 0.5  # start of the published range of (R6)
TABLE_START = -4.0  # h_T is 7e-6 sigma
# Lambda beyond which the factors keep their last value, within 0.5 % of smooth surfaces
TABLE_END = 32.0
TABLE_CELLS = 2304  # Lambda = 0 is a point
TABLE = (TABLE_CELLS + 1, 2 * FACTORS)
CUT_OFF = 1.0 / 300.0  # smallest local film of (R4), sigma/100 in units of 3 sigma
LEAST_SHARED = -2.7  # start of (R9)


class Factor(NamedTuple):
    """A factor at Lambda = h/sigma [-], and its derivative to Lambda."""

    value: float
    slope: float


@compiled
def average_gap(separation: float):
    """Average gap of Gaussian surfaces over sigma, Eq. (R1), for Lambda of any sign [-].

    >>> print(f"{average_gap(0.0).value:.4f} {average_gap(3.0).value:.4f}")
    0.3989 3.0004
    """
    share = 0.5 * (1.0 + erf(separation / np.sqrt(2.0)))
    tail = np.exp(-separation * separation / 2.0) / np.sqrt(2.0 * np.pi)
    return Factor(separation * share + tail, share)  # Eq. (R1)


# ---- of one published Peklenik number


@compiled
def _pressure_flow(row, separation):
    h = max(separation, row.lowest)
    if row.gamma <= 1.0:
        fall = row.C * np.exp(-row.r * h)
        value = 1.0 - fall  # Eq. (R2)
        slope = row.r * fall
    else:
        rise = row.C * h**-row.r
        value = 1.0 + rise
        slope = -row.r * rise / h
    return Factor(value, slope if separation >= row.lowest else 0.0)


@compiled
def _shear_flow(row, h):
    if h <= 0.0:
        return Factor(0.0, 0.0)
    if h <= 5.0:
        near = row.A1 * h**row.a1 * np.exp(-row.a2 * h + row.a3 * h * h)  # Eq. (R3)
        return Factor(near, near * (row.a1 / h - row.a2 + 2.0 * row.a3 * h))
    far = row.A2 * np.exp(-0.25 * h)
    return Factor(far, -0.25 * far)


@compiled
def _sliding_stress(row, h):
    if h <= 0.0 or h >= 7.0:
        return Factor(0.0, 0.0)
    near = row.A3 * h**row.a4 * np.exp(-row.a5 * h + row.a6 * h * h)  # Eq. (R5)
    return Factor(near, near * (row.a4 / h - row.a5 + 2.0 * row.a6 * h))


@compiled
def _pressure_stress(row, separation):
    fall = row.D * np.exp(-row.s1 * max(separation, LOWEST))
    return Factor(1.0 - fall, row.s1 * fall if separation >= LOWEST else 0.0)  # Eq. (R6)


# ---- of any


@compiled
def _place(gamma):
    """Return the published Peklenik number below, and the share of the next one in ln gamma."""
    x = np.log(gamma)
    k = 0
    while k < LOGARITHMS.size - 2 and LOGARITHMS[k + 1] < x:
        k += 1
    return k, (x - LOGARITHMS[k]) / (LOGARITHMS[k + 1] - LOGARITHMS[k])


@compiled
def _between(low, high, weight):
    value = (1.0 - weight) * low.value + weight * high.value
    return Factor(value, (1.0 - weight) * low.slope + weight * high.slope)


@compiled
def pressure_flow_factor(separation: float, gamma: float):
    """Return the pressure flow factor phi_x along sliding, Eq. (R2).

    Lambda [-], Peklenik number gamma from 1/9 to 9.

    >>> print(f"{pressure_flow_factor(3.0, 1.0).value:.3f}")
    0.832
    """
    k, weight = _place(gamma)
    low = _pressure_flow(COEFFICIENTS[k], separation)
    return _between(low, _pressure_flow(COEFFICIENTS[k + 1], separation), weight)


@compiled
def shear_flow_factor(separation: float, gamma: float):
    """Return the shear flow factor Phi_s of one rough surface, Eq. (R3), 0 in overlap.

    >>> print(f"{shear_flow_factor(3.0, 1.0).value:.3f}")
    0.553
    """
    k, weight = _place(gamma)
    low = _shear_flow(COEFFICIENTS[k], separation)
    return _between(low, _shear_flow(COEFFICIENTS[k + 1], separation), weight)


@compiled
def mean_inverse_gap(separation: float):
    """Return the mean of sigma/h, Eq. (R4), in closed form, by moments for Lambda > 30."""
    z = separation / 3.0
    if z > 10.0:
        h = separation
        value = 1.0 / h + h**-3.0 + 27.0 / 11.0 * h**-5.0
        return Factor(value, -(h**-2.0) - 3.0 * h**-4.0 - 135.0 / 11.0 * h**-6.0)
    if z <= CUT_OFF - 1.0:
        return Factor(0.0, 0.0)
    square = 1.0 - z * z
    cube = square * square * square
    dcube = -6.0 * z * square * square
    if z <= 1.0:
        polynomial = -55.0 + z * (
            132.0 + z * (345.0 + z * (-160.0 + z * (-405.0 + z * (60.0 + 147.0 * z))))
        )
        polynomial /= 60.0
        dpolynomial = 132.0 + z * (690.0 + z * (-480.0 + z * (-1620.0 + z * (300.0 + 882.0 * z))))
        dpolynomial /= 60.0
        logarithm = np.log((z + 1.0) / CUT_OFF)
        dlogarithm = 1.0 / (z + 1.0)
    else:
        polynomial = z / 15.0 * (66.0 + z * z * (30.0 * z * z - 80.0))
        dpolynomial = (66.0 + z * z * (150.0 * z * z - 240.0)) / 15.0
        logarithm = np.log((z + 1.0) / (z - 1.0))
        dlogarithm = 2.0 / square
    mean = cube * logarithm + polynomial
    dmean = dcube * logarithm + cube * dlogarithm + dpolynomial
    return Factor(35.0 / 96.0 * mean, 35.0 / 288.0 * dmean)  # Eq. (R4)


@compiled
def sheared_gap(separation: float):
    """Return the harmonic mean of the remaining local films over sigma, Eq. (R9)."""
    h = max(separation, LEAST_SHARED)
    z = min(h / 3.0, 1.0)
    square = z * z
    cube = 1.0 - square
    left = 0.5 + z / 32.0 * (35.0 + square * (-35.0 + square * (21.0 - 5.0 * square)))
    dleft = 35.0 / 96.0 * cube * cube * cube
    inverse = mean_inverse_gap(h)
    value = left / inverse.value  # Eq. (R9)
    slope = (dleft - value * inverse.slope) / inverse.value
    return Factor(value, slope if separation > LEAST_SHARED else 0.0)


@compiled
def sliding_stress_factor(separation: float, gamma: float):
    """Return the factor Phi_fs of one rough surface, Eq. (R5); 0 in overlap."""
    k, weight = _place(gamma)
    low = _sliding_stress(COEFFICIENTS[k], separation)
    return _between(low, _sliding_stress(COEFFICIENTS[k + 1], separation), weight)


@compiled
def pressure_stress_factor(separation: float, gamma: float):
    """Return the factor phi_fp of the pressure-gradient stress, Eq. (R6)."""
    k, weight = _place(gamma)
    low = _pressure_stress(COEFFICIENTS[k], separation)
    return _between(low, _pressure_stress(COEFFICIENTS[k + 1], separation), weight)


# ---- the table


@compiled
def _put(table, k, factor, limit, factor_of):
    """Write a factor without the limit of smooth surfaces, and its slope, as node k."""
    table[k, 2 * factor] = factor_of.value - limit
    table[k, 2 * factor + 1] = factor_of.slope


@compiled
def _both(share, of_skirt, of_bore):
    """Return Eq. (R7)."""
    value = share * of_skirt.value + (1.0 - share) * of_bore.value  # Eq. (R7)
    return Factor(value, share * of_skirt.slope + (1.0 - share) * of_bore.slope)


@compiled
def _against(share, of_skirt, of_bore, limit):
    """Return Eq. (R8) of a factor less its limit."""
    value = share * (of_skirt.value - limit) - (1.0 - share) * (of_bore.value - limit)  # Eq. (R8)
    return Factor(value, share * of_skirt.slope - (1.0 - share) * of_bore.slope)


@compiled
def _drag(h, sliding):
    """Return (phi_f + Phi_fs)/Lambda with Phi_fs of both surfaces."""
    inverse = mean_inverse_gap(h)
    if h <= 0.0:
        return inverse
    slope = inverse.slope + (sliding.slope - sliding.value / h) / h
    return Factor(inverse.value + sliding.value / h, slope)


@compiled
def factor_table(
    share: float, gamma_skirt: float, gamma_bore: float, bearing: bool = False
) -> Array:
    """Return the table of the factors on a uniform grid of Lambda.

    The table is from `TABLE_START` to `TABLE_END`. A bearing slides around its axis. Its grid is
    fixed to the bore, not to the skirt, which is the journal.

    Parameters
    ----------
    share : float
        Y, the skirt's share of the variance [-], 0 to 1.
    gamma_skirt, gamma_bore : float
        Peklenik numbers of the axial direction [-], 1/9 to 9.
    bearing : bool

    Returns
    -------
    ndarray, shape (2305, 12)
        Values and slopes side by side: h_T/sigma - Lambda, phi_c - 1 across i, phi_a - 1 along j,
        Phi_s, (phi_f + Phi_fs)/Lambda, phi_fp - 1 [-], by Eqs. (R7), (R8).
    """
    table = np.empty(TABLE)
    y = share
    s = 1.0 / gamma_skirt if bearing else gamma_skirt
    b = 1.0 / gamma_bore if bearing else gamma_bore
    for k in range(TABLE_CELLS + 1):
        h = TABLE_START + k * ((TABLE_END - TABLE_START) / TABLE_CELLS)
        gap = average_gap(h)
        _put(table, k, FACTOR.gap_excess, h, Factor(gap.value, gap.slope - 1.0))
        first = pressure_flow_factor(h, 1.0 / gamma_skirt)
        around = _both(y, first, pressure_flow_factor(h, 1.0 / gamma_bore))
        _put(table, k, FACTOR.flow_c, 1.0, around)
        first = pressure_flow_factor(h, gamma_skirt)
        axial = _both(y, first, pressure_flow_factor(h, gamma_bore))
        _put(table, k, FACTOR.flow_a, 1.0, axial)
        carried = _against(y, shear_flow_factor(h, s), shear_flow_factor(h, b), 0.0)
        if bearing:  # the bore rests
            carried = Factor(-carried.value, -carried.slope)
        _put(table, k, FACTOR.shear_flow, 0.0, carried)
        sliding = _both(y, sliding_stress_factor(h, s), sliding_stress_factor(h, b))
        _put(table, k, FACTOR.drag, 0.0, _drag(h, sliding))
        driven = _against(y, pressure_stress_factor(h, s), pressure_stress_factor(h, b), 1.0)
        _put(table, k, FACTOR.poiseuille, 0.0, driven)
    return table
