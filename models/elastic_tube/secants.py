"""A coupling method as a plug-in: quasi-Newton by secants that age.

The entry point `iqn_ageing` of the group `piston_cosim.methods`, in pyproject.toml, names the
function below. Your own package adds a method in the same way. The memory of a method is plain
data, so that checkpoints hold it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from piston_cosim.master.coupling.methods import QuasiNewton


def iqn_ageing(coupling: Any) -> QuasiNewton:
    """Return the method of ageing secants of a coupling table."""
    return QuasiNewton(
        Ageing(),
        coupling.relaxation,
        coupling.max_iterations,
        coupling.advanced.probing,
        remembered=(Ageing, Rings),
    )


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
    capacity : int
        Pairs remembered.
    drift : float
        d.
    noise : float
        n, of a pair's squared length: what bends the map within a step.
    step, count : int
        Macro steps accepted, and pairs learnt.
    """

    capacity: int = 300
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
        capacity = self.capacity
        if size == 0.0:
            return
        if self.rings is None:
            shape = (capacity, change.size)
            self.rings = Rings(
                np.zeros(shape), np.zeros(shape), np.zeros((capacity, capacity)), np.zeros(capacity)
            )
        rings = self.rings
        k = self.count % capacity
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
        known = slice(min(self.count, self.capacity))
        v = self.rings.residual_changes[known]
        steps = self.rings.steps[known]
        age = np.abs(steps[:, None] - steps)
        matrix = self.rings.products[known, known] * np.exp(-self.drift * age)
        matrix[np.diag_indices_from(matrix)] += self.noise
        aged = np.exp(-self.drift * (self.step - steps)) * (v @ r)
        a = np.linalg.solve(matrix, aged)  # Eq. (Q6)
        return -(a @ self.rings.changes[known]), r - a @ v

    def close(self) -> None:
        self.step += 1
