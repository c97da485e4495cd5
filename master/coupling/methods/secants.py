"""What quasi-Newton methods learn from iterates, and three ways to an update from it.

A secant pair is a change of the unknowns (the feedback wires) and the change of their residual that
came with it, both in nominals, newest first. Each way below is a memory of pairs: it collects them
by `learn`, returns the answer to a residual by `update`, and accepts the macro step by `close`.
Memories are plain data, which a checkpoint holds; see `coupling.freezing`.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np

from .filtering import filtered


class Secants(Protocol):
    """A way to an update from secant pairs, with its memory of them."""

    @property
    def empty(self) -> bool: ...

    def begin(self) -> None:
        """Begin an attempt at a macro step."""

    def learn(self, change: np.ndarray, residual_change: np.ndarray) -> None:
        """Add a pair."""

    def update(self, r: np.ndarray, wires: list[slice]) -> tuple[np.ndarray, np.ndarray]:
        """Return the answer to the residual r and the unexplained rest; `wires` slice r."""
        ...

    def close(self) -> None:
        """Accept the macro step."""


class Pair(NamedTuple):
    """A change of the unknowns, and the change of their residual that came with it."""

    residual_change: np.ndarray
    change: np.ndarray


class Decomposed(NamedTuple):
    """The pairs of a macro step: residual changes V = Q R, and their changes X, a column each."""

    q: np.ndarray
    triangle: np.ndarray
    changes: np.ndarray


@dataclass
class PairMemory:
    """Memory of pairs by macro step.

    windows : accepted macro steps whose pairs are used again; limit : of the filter; now, past : of
    the running and of accepted macro steps.
    """

    windows: int
    limit: float
    now: list[Pair] = field(default_factory=list[Pair])
    past: list[Any] = field(default_factory=list[Any])

    @property
    def empty(self) -> bool:
        return not (self.now or self.past)

    def begin(self) -> None:
        """Begin an attempt at a macro step."""
        self.now = []

    def learn(self, change: np.ndarray, residual_change: np.ndarray) -> None:
        self.now.insert(0, Pair(residual_change, change))


@dataclass
class LeastSquares(PairMemory):
    """IQN-ILS: all pairs in one least-squares problem, dependent ones dropped by a filter.

    Eq. (Q4):  dx = X c + m (r + V c),   c = argmin |V c + r|,   V = [dr_1, ..],  X = [dx_1, ..]

    It runs in residual-sum scaling: nominals first, then each wire divided by its share of the
    residuals seen in this macro step, so that no field drowns another.

    past holds lists of pairs; shares : residuals seen by wire.

    References
    ----------
    [Degroote2009] J. Degroote, K.-J. Bathe, J. Vierendeels, Computers and Structures 87, 793-801.
    Filters: [Haelterman2016] R. Haelterman et al., Computers and Structures 171, 9-17.
    """

    windows: int = 3
    limit: float = 1e-2
    shares: np.ndarray | None = None

    def begin(self) -> None:
        """Begin an attempt at a macro step."""
        super().begin()
        self.shares = None

    def update(self, r: np.ndarray, wires: list[slice]) -> tuple[np.ndarray, np.ndarray]:
        """Return the answer to the residual r and the unexplained rest: (X c, r + V c)."""
        seen = _shares(r, wires)
        shares = seen if self.shares is None else self.shares + seen
        self.shares = shares
        weight = 1.0 / np.sqrt(shares)
        columns = self.now + [pair for window in self.past for pair in window]
        chosen, q, triangle = filtered(
            [weight * pair.residual_change for pair in columns], self.limit
        )
        change = np.zeros_like(r)
        rest = r.copy()
        if chosen:
            factors = np.linalg.solve(triangle, -(q.T @ (weight * r)))  # Eq. (Q4)
            for factor, k in zip(factors, chosen):
                rest += factor * columns[k].residual_change
                change += factor * columns[k].change
        return change, rest

    def close(self) -> None:
        windows = [self.now, *self.past] if self.now else self.past
        self.past = windows[: self.windows]
        self.now = []


def _shares(r: np.ndarray, wires: list[slice]) -> np.ndarray:
    """Return the share of each wire in the squared residual, by element."""
    total = max(r @ r, np.finfo(float).tiny)
    shares = np.empty_like(r)
    for part in wires:
        shares[part] = max(r[part] @ r[part] / total, 1e-16)
    return shares


@dataclass
class MultiVector(PairMemory):
    """IQN-IMVJ: each macro step's pairs correct the inverse Jacobian of the steps before it.

    Eq. (Q5):  B_n = B_{n-1} + (X_n - B_{n-1} V_n) V_n^+,   B_0 = -m I,   dx = -B_n r

    B is never formed: its steps act one after the other, newest first, each on what the newer ones
    left of r. Steps older than `windows` are forgotten. Of a step's pairs, dependent ones are
    dropped as in `LeastSquares` by `limit`. past holds `Decomposed`.

    References
    ----------
    [Lindner2015] F. Lindner, M. Mehl, K. Scheufele, B. Uekermann, Proc. Coupled Problems VI,
    649-660.
    """

    windows: int = 50
    limit: float = 1e-3

    def update(self, r: np.ndarray, wires: list[slice]) -> tuple[np.ndarray, np.ndarray]:
        """Return the answer to the residual r and the unexplained rest."""
        change = np.zeros_like(r)
        rest = r.copy()
        for q, triangle, changes in [*self._decomposed(), *self.past]:
            share = q.T @ rest  # Eq. (Q5)
            change -= changes @ np.linalg.solve(triangle, share)
            rest -= q @ share
        return change, rest

    def _decomposed(self) -> list[Decomposed]:
        columns = [pair.residual_change for pair in self.now]
        chosen, q, triangle = filtered(columns, self.limit)
        if not chosen:
            return []
        return [Decomposed(q, triangle, np.array([self.now[k].change for k in chosen]).T)]

    def close(self) -> None:
        self.past = [*self._decomposed(), *self.past][: self.windows]
        self.now = []


@dataclass
class Rings:
    """Pairs of known macro steps, the newest in the place of the oldest.

    residual_changes : unit vectors, shape (kept, n); changes : theirs, shape (kept, n); products :
    inner products of the residual changes, shape (kept, kept); steps : their macro steps.
    """

    residual_changes: np.ndarray
    changes: np.ndarray
    products: np.ndarray
    steps: np.ndarray


@dataclass
class Ageing:
    """Pairs trusted less the older they are: least squares that know how fast the Jacobian drifts.

    Eq. (Q6):  dx = -X a + m (r - V a),   (G o R + n I) a = e o (V' r),   G = V' V,  |dr_i| = 1
               R_ij = exp(-d |t_i - t_j|),   e_i = exp(-d |t - t_i|),   t in macro steps

    The inverse Jacobian is taken as a random field that forgets the share d of itself every macro
    step; dx is its mean, given all pairs. With d = 0 and n = 0 this is `LeastSquares`. No pair has
    to be dropped: what two old, nearly parallel pairs disagree on counts as drift, where a filter
    must throw one away or amplify the disagreement.

    Parameters
    ----------
    kept : int
        Pairs remembered.
    drift : float
        d.
    noise : float
        n, of a pair's squared length: what bends the map within a step.
    step, count : int
        Macro steps accepted, and pairs learnt.
    """

    kept: int = 300
    drift: float = 1e-4
    noise: float = 1e-6
    step: int = 0
    count: int = 0
    rings: Rings | None = None

    @property
    def empty(self) -> bool:
        return self.count == 0

    def begin(self) -> None:
        """Begin an attempt at a macro step."""

    def learn(self, change: np.ndarray, residual_change: np.ndarray) -> None:
        size = np.linalg.norm(residual_change)
        kept = self.kept
        if size == 0.0:
            return
        if self.rings is None:
            shape = (kept, change.size)
            self.rings = Rings(
                np.zeros(shape), np.zeros(shape), np.zeros((kept, kept)), np.zeros(kept)
            )
        rings = self.rings
        k = self.count % kept
        self.count += 1
        rings.residual_changes[k] = residual_change / size
        rings.changes[k] = change / size
        rings.steps[k] = self.step
        rings.products[k] = rings.residual_changes @ rings.residual_changes[k]
        rings.products[:, k] = rings.products[k]

    def update(self, r: np.ndarray, wires: list[slice]) -> tuple[np.ndarray, np.ndarray]:
        """Return the answer to the residual r and the unexplained rest: (-X a, r - V a)."""
        if self.rings is None:
            return np.zeros_like(r), r
        known = slice(min(self.count, self.kept))
        v = self.rings.residual_changes[known]
        steps = self.rings.steps[known]
        apart = np.abs(steps[:, None] - steps)
        matrix = self.rings.products[known, known] * np.exp(-self.drift * apart)
        matrix[np.diag_indices_from(matrix)] += self.noise
        aged = np.exp(-self.drift * (self.step - steps)) * (v @ r)
        a = np.linalg.solve(matrix, aged)  # Eq. (Q6)
        return -(a @ self.rings.changes[known]), r - a @ v

    def close(self) -> None:
        self.step += 1
