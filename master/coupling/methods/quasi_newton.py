"""Interface quasi-Newton by secants, for participants without directional derivatives."""

from copy import deepcopy
from dataclasses import dataclass, field

import numpy as np

from ..interface import Interface
from ..vector import moved
from .iteration import accepted_of
from .krylov import RecycledGmres
from .newton import Newton
from .probing import ProbedStep
from .secants import LeastSquares, Secants
from .solution import NotConverged, Solution, Tried, check_finite


@dataclass(frozen=True)
class QuasiNewton:
    """Quasi-Newton iteration on the feedback wires, participants one after the other.

    Eq. (Q8):  x_{k+1} = x_k + X c + (r_k + V c),   r_k = G(x_k) - x_k,
               c from the secants (see `secants`)

    If the loop amplifies hundreds of directions, secants from a bad start fail. With `probing`, a
    macro step without secants, or for which they fail, uses Newton's method with differences. They
    are evaluations of slightly changed iterates, and each is an accurate secant.

    Parameters
    ----------
    secants : Secants
        Without pairs.
    relaxation : float
        Factor of the first update, while there are no secants.
    max_iterations : int
        Evaluations a macro step.
    probing : bool
    astray : float
        With probing, the secants have failed once the residual is this many times the smallest one
        seen, or after half of max_iterations.
    remembered : tuple of type
        Classes of the memory of secants of another package, for checkpoints.
    """

    secants: Secants = field(default_factory=LeastSquares)
    relaxation: float = 0.1
    max_iterations: int = 50
    probing: bool = False
    astray: float = 5.0
    remembered: tuple[type, ...] = ()

    def memory(self) -> "Memory":
        return Memory(deepcopy(self.secants))

    def solve(self, macro_step: Tried, guess: np.ndarray, memory: "Memory") -> Solution:
        try:
            if self.probing and memory.secants.empty:
                return self._probe(macro_step, guess, memory, ())
            return self._iterate(macro_step, guess, memory.secants)
        except SecantsDiverged as lost:
            return self._probe(macro_step, guess, memory, lost.history)

    def _iterate(self, macro_step: Tried, guess: np.ndarray, secants: Secants) -> Solution:
        interface = macro_step.interface
        feedback = interface.feedback
        scale = interface.nominal[feedback]
        x = guess
        history: list[float] = []
        last = None
        least = np.inf
        secants.begin()
        while True:
            at = macro_step.evaluate(x)
            history.append(interface.measure(at.residual, at.outputs))
            converged = history[-1] <= accepted_of(len(history), self.max_iterations)
            if not converged:
                check_finite(interface, at, history)
            point = at.used[feedback] / scale
            r = (at.outputs - at.used)[feedback] / scale
            if last is not None:
                secants.learn(point - last[0], r - last[1])
            if converged:
                secants.close()
                return Solution(at.used, tuple(history))
            last = point, r
            least = min(least, float(np.linalg.norm(r)))
            if self.probing and self._is_astray(r, least, len(history)):
                raise SecantsDiverged(history)
            if len(history) == self.max_iterations:
                raise NotConverged(
                    f"no convergence in {self.max_iterations} iterations", interface, at, history
                )
            x = self._moved(interface, at.used, secants, r)

    def _is_astray(self, r: np.ndarray, least: float, iterations: int) -> bool:
        """Return whether the secants have failed."""
        grown = np.linalg.norm(r) > self.astray * least
        return bool(grown) or 2 * (iterations - 1) > self.max_iterations

    def _moved(
        self, interface: Interface, used: np.ndarray, secants: Secants, r: np.ndarray
    ) -> np.ndarray:
        """Return x_{k+1}."""
        change = np.zeros(interface.size)
        factor = self.relaxation if secants.empty else 1.0
        known, rest = secants.update(r, interface.feedback_wires)
        change[interface.feedback] = known + factor * rest  # Eq. (Q8)
        change *= interface.nominal
        return moved(interface.layout, used, change)

    def _probe(
        self, macro_step: Tried, guess: np.ndarray, memory: "Memory", history: tuple[float, ...]
    ) -> Solution:
        """Solve the macro step by Newton on differences and learn from every probe.

        history : measures of the iteration that failed before.
        """
        memory.secants.begin()
        newton = Newton(self.max_iterations, forcing=1e-2)
        solution = newton.solve(ProbedStep(macro_step, memory.secants.learn), guess, memory.krylov)
        memory.secants.close()
        return Solution(
            solution.x, (*history, *solution.history), solution.jacobians, probes=solution.products
        )


@dataclass
class Memory:
    """Secants, and the Krylov pairs of the macro steps that were probed."""

    secants: Secants
    krylov: RecycledGmres = field(default_factory=RecycledGmres)


class SecantsDiverged(RuntimeError):
    """The secants do not lead to the fixed point; `history` is how the residual went."""

    def __init__(self, history: list[float]):
        super().__init__()
        self.history = tuple(history)
