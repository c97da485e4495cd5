"""Ways to the fixed point of a macro step.

A method is a value with `memory()` and `solve(macro_step, guess, memory)` (`Method` is the
protocol). `solve` returns a `Solution` in which every element of every wire agrees to its
tolerance, or raises `NotConverged`; it never returns anything else. `memory()` makes what the
method carries from one macro step to the next (None if nothing); the stepper drops it after a
failure.
"""

from typing import Any

from ...participants.plugins import from_plugin
from .explicit import Explicit
from .newton import Newton
from .quasi_newton import QuasiNewton
from .relaxation import Relaxation
from .secants import LeastSquares
from .solution import MacroStep, Method, NotConverged, Solution

__all__ = [
    "METHODS",
    "Explicit",
    "LeastSquares",
    "MacroStep",
    "Method",
    "Newton",
    "NotConverged",
    "QuasiNewton",
    "Relaxation",
    "Solution",
    "method_of",
]


METHODS = ("newton", "iqn_ils", "aitken", "constant", "explicit")
"""Names of those in this folder; further ones are entry points."""


def method_of(coupling: Any) -> Method:
    """Return the method of a case's coupling table, as `coupled.Coupling` or `schema.Coupling`."""
    if coupling.method not in METHODS:
        return from_plugin("methods", coupling.method, coupling)
    advanced = coupling.advanced
    if coupling.method == "newton":
        return Newton(coupling.max_iterations, differences=advanced.differences)
    if coupling.method == "explicit":
        return Explicit()
    if coupling.method in ("aitken", "constant"):
        return Relaxation(coupling.relaxation, coupling.method == "aitken", coupling.max_iterations)
    return QuasiNewton(
        LeastSquares(advanced.windows, advanced.filter_limit),
        coupling.relaxation,
        coupling.max_iterations,
        advanced.probing,
    )
