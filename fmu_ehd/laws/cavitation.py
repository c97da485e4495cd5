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

The balance is piecewise linear in u, so a repeated pattern is its exact solution (semismooth
Newton). Should the pattern wander, cells are switched singly in a fixed order, which ends for every
M-matrix [Murty1974]. Only jfo [Jakobsson1957], [Olsson1965] conserves oil; the others are there for
comparison, and their mass_imbalance says what they lose.

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

# a cell this little over-full stays cavitated: rounding of film_fraction - 1
FRACTION_ROUNDOFF = 1e-13
# a full cell with this share of the largest pressure below zero stays full
PRESSURE_ROUNDOFF = 1e-12
PRESSURE_NEGLIGIBLE = 1e-9  # [Pa] the same where there is no pressure at all
ALL_AT_ONCE = 25  # iterations in which all cells switch together, at least
LIMIT = 1000  # iterations in all


class PatternChange(NamedTuple):
    """Pattern of full cells after a solution.

    pattern : ndarray of bool, shape (n_c, n_a), to go on with;
    switched : cells that want to switch, -1: the solution is not finite;
    lowest, highest : first and last axial station of the switched cells;
    i, j : the first cell that wants to switch, or that is not finite.
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
    clipping : negative pressures are cut off afterwards.
    """

    conserving: bool
    switching: bool
    clipping: bool


CAVITATION = {
    "jfo": Cavitation(True, True, False),
    "reynolds": Cavitation(False, True, False),
    "gumbel": Cavitation(False, False, True),
    "full_film": Cavitation(False, False, False),
}


@compiled
def interpret(model: Cavitation, unknown: Array, full: Flags):
    """Pressure [Pa] and film_fraction - 1 [-] of a signed unknown."""
    return _parted(model, unknown, full, unknown)


@compiled
def shares(model: Cavitation, unknown: Array, full: Flags):
    """Return the derivatives of pressure and film fraction to the signed unknown, 0 or 1."""
    return _parted(model, unknown, full, np.ones_like(unknown))


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
        Of the full film.
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
    """`PatternChange` of a pattern by its solution: of all cells that want to, or of the first."""
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
