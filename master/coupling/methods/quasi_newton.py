"""Interface quasi-Newton: updates from secant pairs, for participants without directional
derivatives.
"""

from dataclasses import dataclass, field

import numpy as np

from .krylov import RecycledGmres
from .newton import Newton
from .probing import ProbedStep
from .secants import Ageing, LeastSquares, MultiVector
from .solution import NotConverged, Solution, step_length


@dataclass(frozen=True)
class QuasiNewton:
    """Quasi-Newton iteration on the feedback wires, participants one after the other.

    x_{k+1} = x_k + X c + m (r_k + V c),   r_k = G(x_k) - x_k,   c from the secants (Eq. (C4) to (C6))

    With the mixing factor m = 1 this is IQN, with m < 1 Anderson's mixing: what the secants do not
    explain is relaxed instead of taken whole, which matters where many directions amplify.

    Where hundreds of directions amplify, secants from a bad start mislead. With `probing`, a macro
    step that finds no secants, or that they lead astray, is taken by Newton on differences: sweeps
    from slightly changed iterates, each of them a secant too, and a clean one.

    Parameters
    ----------
    secants : LeastSquares, MultiVector or Ageing
    relaxation : float
        Factor of the first update, while there are no secants.
    mixing : float
        m.
    max_iterations : int
        Sweeps a macro step.
    probing : bool
    astray : float
        With probing, the secants have failed once the residual is this many times the smallest one
        seen, or after half of max_iterations.
    """

    secants: LeastSquares | MultiVector | Ageing = LeastSquares()
    relaxation: float = 0.1
    mixing: float = 1.0
    max_iterations: int = 50
    probing: bool = False
    astray: float = 5.0

    def memory(self):
        return Memory(self.secants.memory())

    def solve(self, macro_step, guess, memory):
        try:
            if self.probing and memory.secants.empty:
                return self._probe(macro_step, guess, memory, ())
            return self._iterate(macro_step, guess, memory.secants)
        except Astray as lost:
            return self._probe(macro_step, guess, memory, lost.history)

    def _iterate(self, macro_step, x, secants):
        interface, history, last, least = macro_step.interface, [], None, np.inf
        feedback, scale = interface.feedback, interface.nominal[interface.feedback]
        secants.begin()
        for iteration in range(self.max_iterations):
            used, y, residual = macro_step.sweep(x)
            history.append(interface.measure(residual, y))
            converged = history[-1] <= 1.0
            if not converged and not np.isfinite(y).all():
                raise NotConverged(
                    "a participant's output is not finite", interface, residual, y, history
                )
            point, r = used[feedback] / scale, (y - used)[feedback] / scale
            if last is not None:
                secants.learn(point - last[0], r - last[1])
            if converged:
                secants.close()
                return Solution(used, tuple(history))
            last, least = (point, r), min(least, np.linalg.norm(r))
            if self.probing and (
                np.linalg.norm(r) > self.astray * least or 2 * iteration > self.max_iterations
            ):
                raise Astray(history)
            x = used + self._step(interface, used, secants, r)
        raise NotConverged(
            f"no convergence in {self.max_iterations} iterations", interface, residual, y, history
        )

    def _step(self, interface, used, secants, r):
        """x_{k+1} - x_k."""
        change, factor = np.zeros(interface.size), self.relaxation if secants.empty else self.mixing
        known, rest = secants.update(r, interface.feedback_wires)
        change[interface.feedback] = known + factor * rest
        change *= interface.nominal
        return step_length(interface, used, change) * change

    def _probe(self, macro_step, guess, memory, history):
        """The macro step by Newton on differences, every probe learnt; `history` is what led astray
        before.
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

    secants: object
    krylov: RecycledGmres = field(default_factory=lambda: RecycledGmres(120))


class Astray(RuntimeError):
    """The secants do not lead to the fixed point; `history` is how the residual went."""

    def __init__(self, history):
        super().__init__()
        self.history = tuple(history)
