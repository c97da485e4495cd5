"""Cavitation models, and the search for the cells where the film is full.

Eq. (C1):  solve M(pattern) u = b(pattern), then take pattern = (u > 0), until the pattern repeats

jfo, oil is conserved:

Eq. (C2):  u > 0: p = u, f = 1;   u <= 0: p = 0, f = 1 + u

reynolds, balance where p > 0, surplus of oil u < 0 dropped where p = 0:

Eq. (C3):  p = max(u, 0), f = 1

gumbel, balance with p = u everywhere:

Eq. (C4):  p = max(u, 0), f = 1

full_film:

Eq. (C5):  p = u, f = 1

jfo with a rounding p_r > 0, smooth in u [Pa]:

Eq. (C6):  (p + p_r) (1 - f) = p_r,   p - u_v (1 - f) = u

The balance is piecewise linear in u, so a repeated pattern is its exact solution (semismooth
Newton). If the pattern does not settle, cells are switched one by one in a fixed order, which ends
for every M-matrix [Murty1974]. Only jfo [Jakobsson1957], [Olsson1965] conserves oil. The others are
for comparison, and their mass_imbalance is the oil that they lose.

By Eqs. (C2) to (C5), derivatives jump when a cell fills or empties. A gradient by differences of
two runs over many steps then has an error of percents. By Eq. (C6), forces are a smooth function of
the film thickness. It is Boyle's law of a gas that fills a cavity at the absolute pressure p_r, so
f >= 0 with p >= 0, and 1 - f is about p_r / p in full cells. u_v is only a scale of the unknown.
Newton's method starts from the solution of Eq. (C1).

References
----------
[Jakobsson1957] B. Jakobsson, L. Floberg, The finite journal bearing considering vaporization,
Chalmers 1957.
[Murty1974] K. G. Murty, Note on a Bard-type scheme for solving the complementarity problem,
Opsearch 11 (1974) 123-130.
[Olsson1965] K.-O. Olsson, Cavitation in dynamically loaded bearings, Chalmers 1965.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..common.grid import EAST, NORTH, SOUTH, WEST, Array, Flags
from .contact import neighbour

# a cell this little over-full stays cavitated: rounding of film_fraction - 1
FRACTION_ROUNDOFF = 1e-13
# a full cell with this share of the largest pressure below zero stays full
PRESSURE_ROUNDOFF = 1e-12
PRESSURE_NEGLIGIBLE = 1e-9  # [Pa] the same where there is no pressure at all
ALL_AT_ONCE = 25  # iterations in which all cells switch together, at least
LIMIT = 1000  # iterations in all
VOID_PRESSURE = 1e6  # u_v [Pa]
MOST_ROUNDED = 100  # Newton iterations with a rounding
SETTLED = 1e-8  # change of the derivatives of Eq. (C6) by the last Newton step


class PatternChange(NamedTuple):
    """Pattern of full cells after a solution.

    pattern : ndarray of bool, shape (n_c, n_a), the next pattern;
    switched : number of cells whose state contradicts their solution, -1: it is not finite;
    lowest, highest : first and last axial station of these cells;
    i, j : the first of them, or the first cell that is not finite.
    """

    pattern: Flags
    switched: int
    lowest: int
    highest: int
    i: int
    j: int


class Cavitation(NamedTuple):
    """A cavitation model, Eqs. (C2) to (C5).

    conserving : cavitated cells carry film fraction;
    switching : cells without pressure leave the pressure equation;
    clipping : negative pressures are cut off afterwards;
    rounding : p_r of Eq. (C6) [Pa], 0 for Eq. (C2).
    """

    conserving: bool
    switching: bool
    clipping: bool
    rounding: float = 0.0


CAVITATION = {
    "jfo": Cavitation(True, True, False),
    "reynolds": Cavitation(False, True, False),
    "gumbel": Cavitation(False, False, True),
    "full_film": Cavitation(False, False, False),
}


@compiled
def interpret(model: Cavitation, unknown: Array, full: Flags, fixed: Flags):
    """Return the pressure [Pa] and film_fraction - 1 [-] of a signed unknown.

    Eq. (C6) does not hold in `fixed` cells, the openings.
    """
    pressure, deficit = _parted(model, unknown, full, unknown)
    if model.rounding > 0.0:
        for i in range(full.shape[0]):
            for j in range(full.shape[1]):
                if not fixed[i, j]:
                    absolute, void, _ = _rounded(unknown[i, j], model.rounding)
                    pressure[i, j] = absolute - model.rounding
                    deficit[i, j] = -void / VOID_PRESSURE
    return pressure, deficit


@compiled
def shares(model: Cavitation, unknown: Array, full: Flags):
    """Return the derivatives of pressure and film fraction to the signed unknown.

    They are 0 or 1 without rounding.
    """
    of_pressure, of_fraction = _parted(model, unknown, full, np.ones_like(unknown))
    if model.rounding > 0.0:
        for i in range(full.shape[0]):
            for j in range(full.shape[1]):
                absolute, void, root = _rounded(unknown[i, j], model.rounding)
                of_pressure[i, j] = absolute / root
                of_fraction[i, j] = void / (VOID_PRESSURE * root)
    return of_pressure, of_fraction


@compiled(forceinline=True)
def _rounded(u, rounding):
    """Return p + p_r, u_v (1 - f) and their sum by Eq. (C6) [Pa], without cancellation."""
    product = rounding * VOID_PRESSURE
    difference = u + rounding
    root = np.sqrt(difference * difference + 4.0 * product)
    larger = 0.5 * (abs(difference) + root)
    smaller = product / larger
    absolute, void = (larger, smaller) if difference > 0.0 else (smaller, larger)
    return absolute, void, root  # Eq. (C6)


@compiled
def rounding_start(unknown: Array, full: Flags, fixed: Flags):
    """Return the unknown of Eq. (C6) from that of Eq. (C2)."""
    start = unknown.copy()
    for i in range(full.shape[0]):
        for j in range(full.shape[1]):
            if not full[i, j] and not fixed[i, j]:
                start[i, j] *= VOID_PRESSURE
    return start


@compiled
def add_weighted(stencil: Array, share: Array, other: Array, other_share: Array):
    """Multiply the column of each cell in two stencils by its share, and sum into the first one.

    Stencils have the shape (5, n_c, n_a), shares (n_c, n_a).
    """
    _, n_c, n_a = stencil.shape
    for k in range(5):
        for i in range(n_c):
            for j in range(n_a):
                a, b = neighbour(k, i, j, n_c, n_a)
                of_other = other[k, i, j] * other_share[a, b]
                stencil[k, i, j] = stencil[k, i, j] * share[a, b] + of_other


@compiled
def unsettled(rounding: float, unknown: Array, change: Array, fixed: Flags):
    """Return the largest change of the shares by a Newton step, and its cell.

    It is that of dp/du of Eq. (C6) to first order, `nan` where it is not finite.
    """
    largest = 0.0
    at_i = 0
    at_j = 0
    for i in range(unknown.shape[0]):
        for j in range(unknown.shape[1]):
            if not fixed[i, j]:
                _, _, root = _rounded(unknown[i, j], rounding)
                bend = abs(2.0 * rounding * VOID_PRESSURE / (root * root * root) * change[i, j])
                if not bend <= largest:
                    largest = bend
                    at_i = i
                    at_j = j
    return largest, at_i, at_j


@compiled
def _parted(model, unknown, full, values):
    """Return values of the cells under pressure, and of those of partly filled film; else 0."""
    pressure = np.zeros_like(unknown)
    deficit = np.zeros_like(unknown)
    for i in range(full.shape[0]):
        for j in range(full.shape[1]):
            if full[i, j] and (unknown[i, j] > 0.0 or not model.clipping):
                pressure[i, j] = values[i, j]  # Eqs. (C2) to (C5)
            elif model.conserving:
                deficit[i, j] = values[i, j]  # Eq. (C2), Eq. (E4)
    return pressure, deficit


@compiled
def without_pressure(full: Flags, stencil: Array):
    """Remove the pressure of cavitated cells from the balance of their neighbours, Eq. (C3).

    The stencil changes in place.

    Parameters
    ----------
    full : ndarray of bool, shape (n_c, n_a)
    stencil : ndarray, shape (5, n_c, n_a)
        Stencil of the full film, see `reynolds`.
    """
    n_c, n_a = full.shape
    for i in range(n_c):
        for j in range(n_a):
            if not full[i, j]:
                if j > 0:
                    stencil[NORTH, i, j - 1] *= 0.0
                if j < n_a - 1:
                    stencil[SOUTH, i, j + 1] *= 0.0
                stencil[EAST, (i - 1) % n_c, j] = 0.0
                stencil[WEST, (i + 1) % n_c, j] = 0.0


@compiled
def switch(full: Flags, unknown: Array, fixed: Flags, conserving: bool, singly: bool):
    """Return the change of a pattern by its solution: all cells that switch, or the first one."""
    highest_pressure = 0.0
    for i in range(full.shape[0]):
        for j in range(full.shape[1]):
            if not fixed[i, j]:
                highest_pressure = max(highest_pressure, unknown[i, j])
    tolerance = max(PRESSURE_ROUNDOFF * highest_pressure, PRESSURE_NEGLIGIBLE)
    over = FRACTION_ROUNDOFF if conserving else tolerance
    pattern = full.copy()
    count = 0
    lowest = full.shape[1]
    highest = -1
    first_i = -1
    first_j = -1
    for i in range(full.shape[0]):
        for j in range(full.shape[1]):
            u = unknown[i, j]
            if not np.isfinite(u):
                return PatternChange(
                    pattern=pattern, switched=-1, lowest=lowest, highest=highest, i=i, j=j
                )
            if not fixed[i, j] and (u < -tolerance if full[i, j] else u > over):
                if count == 0:
                    first_i = i
                    first_j = j
                if count == 0 or not singly:
                    pattern[i, j] = not full[i, j]
                    lowest = min(lowest, j)
                    highest = max(highest, j)
                count += 1
    return PatternChange(
        pattern=pattern, switched=count, lowest=lowest, highest=highest, i=first_i, j=first_j
    )


@compilable
def at_once(n_c: int, n_a: int) -> int:
    """Return the number of iterations in which all cells switch together.

    A full region may spread by one cell in each, and across the whole film.
    """
    return max(ALL_AT_ONCE, min(n_c + n_a, LIMIT // 2))
