"""Viscosity by pressure: barus_1893 and roelands_1966.

The film balance is linear in the reduced pressure q.

Eq. (O4):  mu = mu_0 exp(alpha_p p)
Eq. (O5):  mu = mu_0 exp{(ln mu_0 + 9.67) [(1 + p / 1.96e8)^Z - 1]},
           Z = alpha_p 1.96e8 / (ln mu_0 + 9.67)
Eq. (O6):  q = int_0^p mu_0/mu dp

By Eq. (O4) it is q = (1 - exp(-alpha_p p)) / alpha_p; by Eq. (O5) a table with exact slopes, read
in both directions. Eq. (O6) is exact where alpha_p and Z do not vary over the film; with a
temperature field Z belongs to the mean of mu_0 over the cells with a film.

Suction in a full film has p < 0. Eq. (O5) ends at p = -1.96e8 Pa, and a step that needs less is
discarded. Below this end q continues linearly, so that trials of an iteration remain finite.

A law holds up to mu/mu_0 = `LARGEST_RATIO`, the viscosity is constant beyond. Without the limit q
would be bounded and a hard squeeze would have no pressure at all; with it the pressure of any q
exists and grows steeply. Skirt films stay far below it.

References
----------
[Barus1893] C. Barus, Am. J. Sci. 45 (1893) 87.
[Roelands1966] C. J. A. Roelands, thesis, Delft 1966.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled, numbered
from ..common.faults import FAULT, refuse
from ..common.grid import Array, Field
from ..common.quantities import COUETTE

PRESSURE_VISCOSITY_LAWS = numbered("none", "barus_1893", "roelands_1966")

POLE_PRESSURE = 1.96e8  # [Pa], Eq. (O5)
POLE_LOGARITHM = 9.67  # -ln(6.31e-5 Pa s), Eq. (O5)
# mu/mu_0 up to which a pressure law holds: beyond it the oil is next to a glass
LARGEST_RATIO = 1e3
# cells of the table of Eq. (O6), above p = 0 of equal change of (1 + p / 1.96e8)^Z, below it of
# 1 + p / 1.96e8 to the power 1 / `TOWARDS_POLE`; interpolation error of p below 1e-5
TABLE_CELLS, SUCTION_CELLS = 2000, 400
TOWARDS_POLE = 1.5
ROW = numbered("pressure", "reduced", "ratio")  # of the table
TABLE = (len(ROW), SUCTION_CELLS + TABLE_CELLS + 1)
GAUSS_NODES, GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(4)  # in each cell of the table


class PressureLaw(NamedTuple):
    """A pressure law with its constants.

    kind : number in `PRESSURE_VISCOSITY_LAWS`; alpha : slope of ln mu at p = 0 [1/Pa];
    level, z : ln mu_0 + 9.67 and Z of Eq. (O5) [-]; limit : pressure up to which it holds [Pa];
    most : its q [Pa];
    table : ndarray of shape `TABLE`, p, q [Pa] and mu/mu_0 [-]; used by Eq. (O5) alone.
    """

    kind: int
    alpha: float
    level: float
    z: float
    limit: float
    most: float
    table: Annotated[Array, f"{TABLE[0]}, {TABLE[1]}"]


class TruePressure(NamedTuple):
    """True pressure of a film, with the viscosity under it; arrays of shape (n_c, n_a).

    pressure : p above cavitation pressure [Pa];
    ratio, slope : mu/mu_0 = dp/dq [-] and its derivative to p [1/Pa]; of shape (0, 0) without
    piezoviscosity.
    """

    pressure: Field
    ratio: Field
    slope: Field


@compilable
def pressure_law(
    kind: int, alpha: float, viscosity: Array, images: Array, table: Array
) -> PressureLaw:
    """Return the pressure law of an oil.

    Parameters
    ----------
    kind : int
        Number in `PRESSURE_VISCOSITY_LAWS`.
    alpha : float
        [1/Pa].
    viscosity : ndarray, shape (n_c, n_a)
        Low-shear mu_0 [Pa s]; its mean is that of Eq. (O5).
    images : ndarray, shape (n_c, n_a)
        Number of cells of the film that a cell represents, 0 in openings: its weight in the mean.
    table : ndarray of shape `TABLE`
        Overwritten by the table of Eq. (O5).

    Returns
    -------
    PressureLaw
    """
    if kind == PRESSURE_VISCOSITY_LAWS.barus_1893:
        return _barus_1893(alpha, table)
    if kind == PRESSURE_VISCOSITY_LAWS.roelands_1966:
        return _roelands_1966(alpha, viscosity, images, table)
    return PressureLaw(
        kind=PRESSURE_VISCOSITY_LAWS.none,
        alpha=alpha,
        level=0.0,
        z=0.0,
        limit=np.inf,
        most=np.inf,
        table=table,
    )


@compiled
def _barus_1893(alpha, table):
    limit = np.log(LARGEST_RATIO) / alpha
    most = -np.expm1(-alpha * limit) / alpha  # Eq. (O6)
    return PressureLaw(
        kind=PRESSURE_VISCOSITY_LAWS.barus_1893,
        alpha=alpha,
        level=0.0,
        z=0.0,
        limit=limit,
        most=most,
        table=table,
    )


@compiled
def _roelands_1966(alpha, viscosity, images, table):
    total = 0.0
    cells = 0.0
    for i in range(viscosity.shape[0]):
        for j in range(viscosity.shape[1]):
            total += images[i, j] * viscosity[i, j]
            cells += images[i, j]
    kind = PRESSURE_VISCOSITY_LAWS.roelands_1966
    level = np.log(total / max(cells, 1.0)) + POLE_LOGARITHM
    z = alpha * POLE_PRESSURE / level
    growth = np.log(LARGEST_RATIO) / level
    law = PressureLaw(kind=kind, alpha=alpha, level=level, z=z, limit=np.inf, most=0.0, table=table)
    for k in range(table.shape[1]):
        power = 1.0 + growth * ((k - SUCTION_CELLS) / TABLE_CELLS)
        base = power ** (1.0 / z) if k >= SUCTION_CELLS else (k / SUCTION_CELLS) ** TOWARDS_POLE
        pressure = POLE_PRESSURE * (base - 1.0)
        table[ROW.pressure, k] = pressure
        table[ROW.ratio, k], _ = _ratio_below(law, pressure)
    table[ROW.reduced, SUCTION_CELLS] = 0.0
    for k in range(SUCTION_CELLS, table.shape[1] - 1):
        table[ROW.reduced, k + 1] = table[ROW.reduced, k] + _part(law, k)
    for k in range(SUCTION_CELLS - 1, -1, -1):
        table[ROW.reduced, k] = table[ROW.reduced, k + 1] - _part(law, k)
    limit = table[ROW.pressure, -1]
    return PressureLaw(
        kind=kind,
        alpha=alpha,
        level=level,
        z=z,
        limit=limit,
        most=table[ROW.reduced, -1],
        table=table,
    )


@compiled
def _part(law, k):
    """Return the integral of Eq. (O6) over cell k of the table by Gauss points [Pa]."""
    half = 0.5 * (law.table[ROW.pressure, k + 1] - law.table[ROW.pressure, k])
    part = 0.0
    for m in range(GAUSS_NODES.size):
        at, _ = _ratio_below(law, law.table[ROW.pressure, k] + half * (1.0 + GAUSS_NODES[m]))
        part += half * GAUSS_WEIGHTS[m] / at  # Eq. (O6)
    return part


# ---- below the limit


@compiled
def _ratio_below(law, pressure):
    """Return mu/mu_0 [-] and its derivative to p [1/Pa]."""
    if law.kind == PRESSURE_VISCOSITY_LAWS.barus_1893:
        ratio = np.exp(law.alpha * pressure)  # Eq. (O4)
        return ratio, law.alpha * ratio
    base = 1.0 + pressure / POLE_PRESSURE
    if base <= 0.0:
        return np.exp(-law.level), 0.0
    ratio = np.exp(law.level * (base**law.z - 1.0))  # Eq. (O5)
    return ratio, ratio * law.level * law.z / POLE_PRESSURE * base ** (law.z - 1.0)


@compiled
def _reduced_below(law, pressure):
    """Return q [Pa] of p [Pa]."""
    if law.kind == PRESSURE_VISCOSITY_LAWS.barus_1893:
        return -np.expm1(-law.alpha * pressure) / law.alpha  # Eq. (O6)
    return _read(law.table, ROW.pressure, ROW.reduced, pressure)


@compiled
def _pressure_below(law, reduced):
    """Return p [Pa] of q [Pa]."""
    if law.kind == PRESSURE_VISCOSITY_LAWS.barus_1893:
        return -np.log1p(-law.alpha * reduced) / law.alpha
    return _read(law.table, ROW.reduced, ROW.pressure, reduced)


@compiled
def _read(table, known, wanted, x):
    """Return the cubic Hermite interpolation between nodes, straight below the first one."""
    low = 0
    high = table.shape[1] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if table[known, middle] <= x:
            low = middle
        else:
            high = middle
    # dq/dp = mu_0/mu
    m0 = table[ROW.ratio, low]
    m1 = table[ROW.ratio, high]
    if wanted == ROW.reduced:
        m0 = 1.0 / m0
        m1 = 1.0 / m1
    step = table[known, high] - table[known, low]
    t = (x - table[known, low]) / step
    rise = table[wanted, high] - table[wanted, low]
    m0 *= step
    m1 *= step
    if t < 0.0:
        return table[wanted, low] + t * m0
    third = m0 + m1 - 2.0 * rise
    return table[wanted, low] + t * (m0 + t * (3.0 * rise - 2.0 * m0 - m1 + t * third))


# ---- of any pressure


@compiled
def viscosity_ratio(law: PressureLaw, pressure: float):
    """Return mu/mu_0 [-] at p [Pa] and its derivative to p [1/Pa]."""
    ratio, slope = _ratio_below(law, min(pressure, law.limit))
    return ratio, slope if pressure < law.limit else 0.0


@compiled
def reduced_pressure(law: PressureLaw, pressure: float):
    """Return q [Pa] of p [Pa], Eq. (O6)."""
    beyond = max(pressure - law.limit, 0.0)
    return _reduced_below(law, min(pressure, law.limit)) + beyond / LARGEST_RATIO


@compiled
def pressure_of(law: PressureLaw, reduced: float):
    """Return p [Pa] of q [Pa]."""
    beyond = max(reduced - law.most, 0.0)
    return _pressure_below(law, min(reduced, law.most)) + beyond * LARGEST_RATIO


# ---- of a film


@compilable
def reduced_at_edges(law: PressureLaw, pressure: Array) -> Array:
    """Return q [Pa] of the pressures at the edges, shape (5,)."""
    return (
        pressure if law.kind == PRESSURE_VISCOSITY_LAWS.none else _reduced_at_edges(law, pressure)
    )


@compiled
def _reduced_at_edges(law, pressure):
    reduced = np.empty(pressure.size)
    for k in range(pressure.size):
        reduced[k] = reduced_pressure(law, pressure[k])
    return reduced


@compilable
def true_pressure(law: PressureLaw, reduced: Array) -> TruePressure:
    """Return the `TruePressure` of a reduced pressure, shape (n_c, n_a) [Pa]."""
    if law.kind == PRESSURE_VISCOSITY_LAWS.none:
        return TruePressure(reduced, np.zeros((0, 0)), np.zeros((0, 0)))
    return _true_pressure(law, reduced)


@compiled
def _true_pressure(law, reduced):
    n_c, n_a = reduced.shape
    pressure = np.empty((n_c, n_a))
    ratio = np.empty((n_c, n_a))
    slope = np.empty((n_c, n_a))
    for i in range(n_c):
        for j in range(n_a):
            p = pressure_of(law, reduced[i, j])
            pressure[i, j] = p
            ratio[i, j], slope[i, j] = viscosity_ratio(law, p)
    return TruePressure(pressure, ratio, slope)


@compiled
def check_suction(law: PressureLaw, pressure: Array, faults: Array):
    """Note the first cell whose pressure [Pa] is below the end of the law, the pole of Eq. (O5)."""
    if law.kind != PRESSURE_VISCOSITY_LAWS.roelands_1966:
        return
    for i in range(pressure.shape[0]):
        for j in range(pressure.shape[1]):
            if pressure[i, j] <= -POLE_PRESSURE:
                refuse(faults, FAULT.below_pressure_law, i, j, pressure[i, j], -POLE_PRESSURE, 0.0)
                return


@compilable
def raised(quantities: Array, ratio: Array) -> Array:
    """Return quantities of a film, or their derivatives, with the Couette stress times mu/mu_0.

    Parameters
    ----------
    quantities : ndarray, shape (6, n_c, n_a), or (0, n_c, n_a)
    ratio : ndarray, shape (n_c, n_a)
        `ratio` of `TruePressure`. If its shape is (0, 0), the viscosity does not change.
    """
    if ratio.size == 0 or quantities.shape[0] == 0:
        return quantities
    return _raised(quantities, ratio)


@compiled
def _raised(quantities, ratio):
    whole = quantities.copy()
    for i in range(ratio.shape[0]):
        for j in range(ratio.shape[1]):
            whole[COUETTE, i, j] *= ratio[i, j]
    return whole
