"""Secant pairs of quasi-Newton methods, and updates from them.

A secant pair is a change of the unknowns (the feedback wires) and the resulting change of their
residual, both in nominal values, newest first. The classes here are memories of pairs. `learn` adds
pairs, `update` returns the update for a residual, and `close` ends an accepted macro step. Memories
are plain data, which a checkpoint contains; see `coupling.freezing`. The plug-in
models/elastic_tube/secants.py is another such class.
"""

from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

import numpy as np

from .filtering import filtered


class Secants(Protocol):
    """Memory of secant pairs that returns updates."""

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


@dataclass
class LeastSquares:
    """IQN-ILS: all pairs in one least-squares problem, dependent ones dropped by a filter.

    Eq. (Q4):  dx = X c + m (r + V c),   c = argmin |V c + r|,   V = [dr_1, ..],  X = [dx_1, ..]

    It runs in residual-sum scaling: nominals first, then each wire divided by its share of the
    residuals seen in this macro step, so that no field dominates the others.

    windows : accepted macro steps whose pairs are used again; limit : of the filter; now, past :
    pairs of the running macro step and of accepted ones; shares : residuals seen by wire.

    References
    ----------
    [Degroote2009] J. Degroote, K.-J. Bathe, J. Vierendeels, Computers and Structures 87, 793-801.
    Filters: [Haelterman2016] R. Haelterman et al., Computers and Structures 171, 9-17.
    """

    windows: int = 3
    limit: float = 1e-2
    now: list[Pair] = field(default_factory=list[Pair])
    past: list[list[Pair]] = field(default_factory=list[list[Pair]])
    shares: np.ndarray | None = None

    @property
    def empty(self) -> bool:
        return not (self.now or self.past)

    def begin(self) -> None:
        """Begin an attempt at a macro step."""
        self.now = []
        self.shares = None

    def learn(self, change: np.ndarray, residual_change: np.ndarray) -> None:
        self.now.insert(0, Pair(residual_change, change))

    def update(self, r: np.ndarray, wires: list[slice]) -> tuple[np.ndarray, np.ndarray]:
        """Return the answer to the residual r and the unexplained rest: (X c, r + V c)."""
        new_shares = _shares(r, wires)
        shares = new_shares if self.shares is None else self.shares + new_shares
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
