"""Where the film is full: the active-set solution of the film balance with the signed unknown.

Eq. (C1):  solve M(pattern) u = b(pattern), then take pattern = (u > 0), until the pattern repeats

The balance is piecewise linear in u, so a repeated pattern is its exact solution (semismooth Newton). Should the pattern
wander, cells are switched singly in a fixed order, which ends for every M-matrix [Murty1974].

References
----------
[Murty1974] K. G. Murty, Note on a Bard-type scheme for solving the complementarity problem, Opsearch 11 (1974) 123-130.
"""

import numpy as np
from numba import njit

FRACTION_ROUNDOFF = 1e-13  # a cell this little over-full stays cavitated: rounding of film_fraction - 1
PRESSURE_ROUNDOFF = 1e-12  # a full cell with this share of the largest pressure below zero stays full
PRESSURE_NEGLIGIBLE = 1e-9  # [Pa] the same where there is no pressure at all
ALL_AT_ONCE = 25  # iterations in which all cells switch together
LIMIT = 1000  # iterations in all


class NotConverged(RuntimeError):
    """The pattern of full cells did not settle; the message says how many cells still switch and where."""


@njit(cache=True)
def _switch(full, unknown, singly):
    """New pattern, number of switched cells, their lowest axial station and their first cell."""
    tolerance = max(PRESSURE_ROUNDOFF * unknown.max(), PRESSURE_NEGLIGIBLE)
    pattern = full.copy()
    count, station, first = 0, full.shape[1], (-1, -1)
    for i in range(full.shape[0]):
        for j in range(full.shape[1]):
            u = unknown[i, j]
            if u < -tolerance if full[i, j] else u > FRACTION_ROUNDOFF:
                if count == 0:
                    first = (i, j)
                if count == 0 or not singly:
                    pattern[i, j] = not full[i, j]
                    station = min(station, j)
                count += 1
    return pattern, count, station, first


def settle(assemble, solver, full, all_at_once=ALL_AT_ONCE):
    """Pattern of full cells and signed unknown of one step, Eq. (C1).

    Parameters
    ----------
    assemble : callable
        pattern -> (stencil, right-hand side), e.g. `reynolds.assemble`.
    solver : object
        `factorise(stencil, first)`, `solve(right)`; left with the factorisation of the settled pattern.
    full : ndarray of bool, shape (n_c, n_a)
        First guess.
    all_at_once : int
        Iterations in which all cells switch together; after them they switch singly.

    Returns
    -------
    unknown : ndarray, shape (n_c, n_a)
        u: pressure [Pa] in full cells, film_fraction - 1 [-] elsewhere.
    full : ndarray of bool, shape (n_c, n_a)
    iterations : int
        Number of factorisations.

    Raises
    ------
    NotConverged
        With the number of cells that still switch and the first of them.
    """
    station = 0
    for iteration in range(LIMIT):
        stencil, right = assemble(full)
        solver.factorise(stencil, station)
        unknown = solver.solve(right[None])[0]
        pattern, count, station, first = _switch(full, unknown, iteration >= all_at_once)
        if not np.isfinite(unknown.sum()):
            raise NotConverged("the film solution is not finite: film thickness or viscosity out of all proportion")
        if count == 0:  # Eq. (C1)
            return unknown, full, iteration + 1
        full = pattern
    raise NotConverged(f"cavitation did not settle in {LIMIT} iterations: {count} cells still switch, first "
                       f"[{first[0] + 1},{first[1] + 1}] with u = {unknown[first]:g}")
