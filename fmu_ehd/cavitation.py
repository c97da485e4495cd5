"""Cavitation models, and the search for the cells where the film is full.

Eq. (C1):  solve M(pattern) u = b(pattern), then take pattern = (u > 0), until the pattern repeats
Eq. (C2):  jfo:       u > 0: p = u, f = 1;   u <= 0: p = 0, f = 1 + u           oil is conserved
Eq. (C3):  reynolds:  p = max(u, 0), f = 1; balance where p > 0, surplus of oil u < 0 dropped where p = 0
Eq. (C4):  gumbel:    p = max(u, 0), f = 1; balance with p = u everywhere
Eq. (C5):  full_film: p = u, f = 1

The balance is piecewise linear in u, so a repeated pattern is its exact solution (semismooth
Newton). Should the pattern wander, cells are switched singly in a fixed order, which ends for every
M-matrix [Murty1974]. Only jfo conserves oil; the others are there for comparison, and their
mass_imbalance says what they lose.

References ---------- [Jakobsson1957] B. Jakobsson, L. Floberg, The finite journal bearing
considering vaporization, Chalmers 1957; K.-O. Olsson, Cavitation in dynamically loaded bearings,
Chalmers 1965 (C2). [Murty1974] K. G. Murty, Note on a Bard-type scheme for solving the
complementarity problem, Opsearch 11 (1974) 123-130.
"""

from dataclasses import dataclass

import numpy as np

from ..master.fmi.compiled import compiled

FRACTION_ROUNDOFF = (
    1e-13  # a cell this little over-full stays cavitated: rounding of film_fraction - 1
)
PRESSURE_ROUNDOFF = (
    1e-12  # a full cell with this share of the largest pressure below zero stays full
)
PRESSURE_NEGLIGIBLE = 1e-9  # [Pa] the same where there is no pressure at all
ALL_AT_ONCE = 25  # iterations in which all cells switch together
LIMIT = 1000  # iterations in all


class NotConverged(RuntimeError):
    """A step that has no solution, or none was found; the message says what, where and by how
    much.
    """


@compiled
def split(unknown, full):
    """The unknown where the film is full and zero elsewhere, and the other way round."""
    inside, outside = np.zeros_like(unknown), np.zeros_like(unknown)
    for i in range(full.shape[0]):
        for j in range(full.shape[1]):
            if full[i, j]:
                inside[i, j] = unknown[i, j]
            else:
                outside[i, j] = unknown[i, j]
    return inside, outside


@dataclass(frozen=True)
class Cavitation:
    """A cavitation model, Eqs. (C2) to (C5).

    Parameters
    ----------
    name : str
    conserving : bool
        Cavitated cells carry film fraction.
    switching : bool
        Cells without pressure leave the pressure equation.
    clipping : bool
        Negative pressures are cut off afterwards.
    """

    name: str
    conserving: bool
    switching: bool
    clipping: bool

    def first_guess(self, full):
        """Pattern to start from: `full` itself, or all cells where none ever switches."""
        return full if self.switching else np.ones_like(full)

    def interpret(self, unknown, full):
        """Pressure [Pa] and film_fraction - 1 [-] of a signed unknown."""
        if self.conserving:
            return split(unknown, full)  # Eq. (C2)
        kept = full & (unknown > 0.0) if self.clipping else full
        return np.where(kept, unknown, 0.0), np.zeros_like(unknown)  # Eqs. (C3) to (C5)

    def shares(self, unknown, full):
        """Derivatives of pressure and film fraction to the signed unknown, 0 or 1."""
        kept = full & (unknown > 0.0) if self.clipping else full
        return kept.astype(float), (~full).astype(float) if self.conserving else np.zeros_like(
            unknown
        )


CAVITATION = {
    model.name: model
    for model in (
        Cavitation("jfo", True, True, False),
        Cavitation("reynolds", False, True, False),
        Cavitation("gumbel", False, False, True),
        Cavitation("full_film", False, False, False),
    )
}


@compiled
def without_pressure(full, centre, south, north, west, east):
    """Take the pressure of cells outside the pattern out of their neighbours' balance, Eq. (C3); in
    place.

    Parameters
    ----------
    full : ndarray of bool, shape (n_c, n_a)
    centre, south, north, west, east : ndarray, shape (n_c, n_a)
        Stencil of the full film.
    """
    n_c, n_a = full.shape
    for i in range(n_c):
        for j in range(n_a):
            if not full[i, j]:
                north[i, max(j - 1, 0)] *= 1.0 if j == 0 else 0.0
                south[i, min(j + 1, n_a - 1)] *= 1.0 if j == n_a - 1 else 0.0
                east[(i - 1) % n_c, j] = 0.0
                west[(i + 1) % n_c, j] = 0.0


@compiled
def _switch(full, unknown, fixed, conserving, singly):
    """New pattern, number of switched cells (-1: not finite), their first and last axial station,
    and their first cell.
    """
    highest = 0.0
    for row in unknown:
        for u in row:
            highest = max(highest, u)
    tolerance = max(PRESSURE_ROUNDOFF * highest, PRESSURE_NEGLIGIBLE)
    over = FRACTION_ROUNDOFF if conserving else tolerance
    pattern = full.copy()
    count, south, north, first = 0, full.shape[1], -1, (-1, -1)
    for i in range(full.shape[0]):
        for j in range(full.shape[1]):
            u = unknown[i, j]
            if not np.isfinite(u):
                return pattern, -1, (south, north), (i, j)
            if not fixed[i, j] and (u < -tolerance if full[i, j] else u > over):
                if count == 0:
                    first = (i, j)
                if count == 0 or not singly:
                    pattern[i, j] = not full[i, j]
                    south, north = min(south, j), max(north, j)
                count += 1
    return pattern, count, (south, north), first


def settle(model, assemble, solver, full, fixed, all_at_once=ALL_AT_ONCE):
    """Pattern of full cells and signed unknown of one step, Eq. (C1).

    Parameters
    ----------
    model : Cavitation
    assemble : callable
        pattern -> (stencil, right-hand side), e.g. `reynolds.assemble`.
    solver : object
        `factorise(stencil, stations)`, `solve(right)`; left with the factorisation of the settled
        pattern.
    full : ndarray of bool, shape (n_c, n_a)
        First guess.
    fixed : ndarray of bool, shape (n_c, n_a)
        Cells that never switch.
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
    stations = None
    for iteration in range(LIMIT):
        stencil, right = assemble(full)
        solver.factorise(stencil, stations)
        unknown = solver.solve(right[None])[0]
        pattern, count, stations, first = _switch(
            full, unknown, fixed, model.conserving, iteration >= all_at_once
        )
        if count < 0:
            raise NotConverged(
                f"the film solution is not finite, first at [{first[0] + 1},{first[1] + 1}]: film thickness or "
                "viscosity out of all proportion"
            )
        if count == 0 or not model.switching:  # Eq. (C1)
            return unknown, full, iteration + 1
        full = pattern
    raise NotConverged(
        f"cavitation did not settle in {LIMIT} iterations: {count} cells still switch, first "
        f"[{first[0] + 1},{first[1] + 1}] with u = {unknown[first]:g}"
    )
