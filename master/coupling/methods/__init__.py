"""Ways to the fixed point of a macro step.

A method is a value with `memory()` and `solve(macro_step, guess, memory)`. `solve` returns a
`Solution` in which every element of every wire agrees to its tolerance, or raises `NotConverged`;
it never returns anything else. `memory()` makes what the method carries from one macro step to the
next (None if nothing); the stepper drops it after a failure.
"""

from .explicit import Explicit
from .newton import Newton
from .quasi_newton import QuasiNewton
from .relaxation import Relaxation
from .secants import Ageing, LeastSquares, MultiVector
from .solution import MacroStep, NotConverged, Solution, step_length

__all__ = [
    "Ageing",
    "Explicit",
    "LeastSquares",
    "MacroStep",
    "MultiVector",
    "Newton",
    "NotConverged",
    "QuasiNewton",
    "Relaxation",
    "Solution",
    "method_of",
    "step_length",
]


def method_of(coupling):
    """The method a case's coupling table asks for."""
    if coupling.method == "newton":
        return Newton(
            coupling.max_iterations, coupling.largest_krylov_space, differences=coupling.differences
        )
    if coupling.method == "explicit":
        return Explicit()
    if coupling.method in ("aitken", "constant"):
        return Relaxation(coupling.relaxation, coupling.method == "aitken", coupling.max_iterations)
    secants = {
        "iqn_ils": LeastSquares(coupling.windows, coupling.filter_limit, coupling.filter),
        "iqn_imvj": MultiVector(coupling.windows, coupling.filter_limit),
        "iqn_ageing": Ageing(),
    }[coupling.method]
    return QuasiNewton(
        secants, coupling.relaxation, coupling.mixing, coupling.max_iterations, coupling.probing
    )
