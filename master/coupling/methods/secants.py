"""What quasi-Newton methods learn from iterates, and three ways to an update from it.

A secant pair is a change of the unknowns (the feedback wires) and the change of their residual that
came with it, both in nominals, newest first. Each way below is a value; its `memory()` collects
pairs by `learn`, answers a residual by `update`, and is told by `close` that the macro step is
accepted. Memories are plain data: a checkpoint pickles them.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from .filtering import filtered


@dataclass(frozen=True)
class LeastSquares:
    """IQN-ILS: all pairs in one least-squares problem, dependent ones dropped by a filter.

    Eq. (C4):  dx = X c + m (r + V c),   c = argmin |V c + r|,   V = [dr_1, ..],  X = [dx_1, ..]

    It runs in residual-sum scaling: nominals first, then each wire divided by its share of the
    residuals seen in this macro step, so that no field drowns another.

    Parameters
    ----------
    windows : int
        Accepted macro steps whose pairs are used again.
    limit : float
        Of the filter.
    rule : {"QR1", "QR2", "QR3"}
        See `filtering.filtered`.

    References ---------- Degroote, Bathe, Vierendeels (2009), Computers and Structures 87, 793-801.
    Filters: Haelterman et al. (2016), Computers and Structures 171, 9-17.
    """

    windows: int = 3
    limit: float = 1e-2
    rule: str = "QR2"

    def memory(self):
        return LeastSquaresMemory(self)


@dataclass
class LeastSquaresMemory:
    """`now` holds the pairs of the running macro step, `past` those of accepted ones, `shares` the
    residuals seen per wire.
    """

    way: LeastSquares
    now: list = field(default_factory=list)
    past: list = field(default_factory=list)
    shares: np.ndarray | None = None

    @property
    def empty(self):
        return not (self.now or self.past)

    def begin(self):
        """A macro step is tried."""
        self.now, self.shares = [], None

    def learn(self, change, residual_change):
        self.now.insert(0, (residual_change, change))

    def update(self, r, wires):
        """Answer to the residual r, and what of r no pair explains: (X c, r + V c) of Eq. (C4);
        `wires` are slices of r.
        """
        seen = _shares(r, wires)
        self.shares = seen if self.shares is None else self.shares + seen
        weight = 1.0 / np.sqrt(self.shares)
        columns = self.now + [pair for window in self.past for pair in window]
        chosen, q, triangle = filtered(
            [weight * v for v, _ in columns], self.way.limit, self.way.rule
        )
        change, rest = np.zeros_like(r), r.copy()
        if chosen:
            for factor, k in zip(np.linalg.solve(triangle, -(q.T @ (weight * r))), chosen):
                rest += factor * columns[k][0]
                change += factor * columns[k][1]
        return change, rest

    def close(self):
        self.past, self.now = (
            ([self.now, *self.past] if self.now else self.past)[: self.way.windows],
            [],
        )


def _shares(r, wires):
    """Share of each wire in the squared residual, spread over its elements."""
    total, shares = max(r @ r, np.finfo(float).tiny), np.empty_like(r)
    for part in wires:
        shares[part] = max(r[part] @ r[part] / total, 1e-16)
    return shares


@dataclass(frozen=True)
class MultiVector:
    """IQN-IMVJ: each macro step's pairs correct the inverse Jacobian of the steps before it.

    Eq. (C5):  B_n = B_{n-1} + (X_n - B_{n-1} V_n) V_n^+,   B_0 = -m I,   dx = -B_n r

    B is never formed: its steps act one after the other, newest first, each on what the newer ones
    left of r. Steps older than `windows` are forgotten. Of a step's pairs, dependent ones are
    dropped (QR2, see `LeastSquares`) by `limit`.

    References
    ----------
    Lindner, Mehl, Scheufele, Uekermann (2015), Proc. Coupled Problems VI, 649-660.
    """

    windows: int = 50
    limit: float = 1e-3

    def memory(self):
        return MultiVectorMemory(self)


@dataclass
class MultiVectorMemory:
    """`now` holds the running step's pairs, `past` one (Q, R, X) of every accepted step."""

    way: MultiVector
    now: list = field(default_factory=list)
    past: list = field(default_factory=list)

    @property
    def empty(self):
        return not (self.now or self.past)

    def begin(self):
        """A macro step is tried."""
        self.now = []

    def learn(self, change, residual_change):
        self.now.insert(0, (residual_change, change))

    def update(self, r, wires):
        """Answer to the residual r, and what of r no pair explains."""
        change, rest = np.zeros_like(r), r.copy()
        for q, triangle, changes in [*self._decomposed(), *self.past]:
            share = q.T @ rest  # Eq. (C5)
            change -= changes @ np.linalg.solve(triangle, share)
            rest -= q @ share
        return change, rest

    def _decomposed(self):
        chosen, q, triangle = filtered([v for v, _ in self.now], self.way.limit, "QR2")
        return [(q, triangle, np.array([self.now[k][1] for k in chosen]).T)] if chosen else []

    def close(self):
        self.past, self.now = [*self._decomposed(), *self.past][: self.way.windows], []


@dataclass(frozen=True)
class Ageing:
    """Pairs trusted less the older they are: least squares that know how fast the Jacobian drifts.

    Eq. (C6):  dx = -X a + m (r - V a),   (G o R + n I) a = e o (V' r),   G = V' V,  |dr_i| = 1
               R_ij = exp(-d |t_i - t_j|),   e_i = exp(-d |t - t_i|),   t in macro steps

    The inverse Jacobian is taken as a random field that forgets the share d of itself every macro
    step; dx is its mean, given all pairs. With d = 0 and n = 0 this is the least squares of Eq.
    (C4). No pair has to be dropped: what two old, nearly parallel pairs disagree on counts as
    drift, where a filter must throw one away or amplify the disagreement.

    Parameters
    ----------
    kept : int
        Pairs remembered.
    drift : float
        d.
    noise : float
        n, of a pair's squared length: what bends the map within a step.
    """

    kept: int = 300
    drift: float = 1e-4
    noise: float = 1e-6

    def memory(self):
        return AgeingMemory(self)


@dataclass
class AgeingMemory:
    """Rings of pairs: unit residual changes and their changes, shape (kept, n); their inner
    products; their macro steps.
    """

    way: Ageing
    step: int = 0
    count: int = 0
    residual_changes: np.ndarray | None = None
    changes: np.ndarray | None = None
    products: np.ndarray | None = None
    steps: np.ndarray | None = None

    @property
    def empty(self):
        return self.count == 0

    def begin(self):
        """A macro step is tried."""

    def learn(self, change, residual_change):
        size, kept = np.linalg.norm(residual_change), self.way.kept
        if size == 0.0:
            return
        if self.empty:
            self.residual_changes, self.changes = (
                np.zeros((kept, change.size)),
                np.zeros((kept, change.size)),
            )
            self.products, self.steps = np.zeros((kept, kept)), np.zeros(kept)
        k, self.count = self.count % kept, self.count + 1
        self.residual_changes[k], self.changes[k], self.steps[k] = (
            residual_change / size,
            change / size,
            self.step,
        )
        self.products[k] = self.products[:, k] = self.residual_changes @ self.residual_changes[k]

    def update(self, r, wires):
        """Answer to the residual r, and what of r no pair explains: (-X a, r - V a) of Eq. (C6)."""
        if self.empty:
            return np.zeros_like(r), r
        known = slice(min(self.count, self.way.kept))
        v, steps = self.residual_changes[known], self.steps[known]
        matrix = self.products[known, known] * np.exp(
            -self.way.drift * np.abs(steps[:, None] - steps)
        )
        matrix[np.diag_indices_from(matrix)] += self.way.noise
        a = cho_solve(
            cho_factor(matrix), np.exp(-self.way.drift * (self.step - steps)) * (v @ r)
        )  # Eq. (C6)
        return -(a @ self.changes[known]), r - a @ v

    def close(self):
        self.step += 1
