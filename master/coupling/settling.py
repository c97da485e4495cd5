"""Macro step in which values that are not real numbers agree too: repeated solves."""

import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np

from .interface import Interface
from .methods import Explicit, MacroStep, Method, Solution
from .wiring import HeldWire

MOST_SOLVES = 10
"""Solves of a macro step after which a discrete wire that still changes is held."""


def solve_settled(
    method: Method, macro_step: MacroStep, guess: np.ndarray, memory: Any
) -> Solution:
    """Return the solution in which discrete wires against the stepping order agree too.

    Such a wire is constant during a solve. If its source has changed, the solve is repeated with
    the new value. A wire that still changes after MOST_SOLVES is held at its value at the beginning
    of the macro step, with a warning. `Explicit` solves once.
    """
    interface = macro_step.interface
    if not interface.late or isinstance(method, Explicit):
        return method.solve(macro_step, guess, memory)
    begin = dict(interface.late)
    held: set[HeldWire] = set()
    solution = method.solve(macro_step, guess, memory)
    solves = 1
    while changed := [wire for wire in interface.unsettled() if wire not in held]:
        interface.hold(changed)
        if solves >= MOST_SOLVES:
            held.update(changed)
            interface.late |= {wire: begin[wire] for wire in changed}
            _report(interface, changed, macro_step.time)
        more = method.solve(macro_step, solution.x, memory)
        solves += 1
        solution = more._replace(
            history=solution.history + more.history,
            jacobians=solution.jacobians + more.jacobians,
            products=solution.products + more.products,
            probes=solution.probes + more.probes,
        )
    return solution


def _report(interface: Interface, wires: Iterable[HeldWire], time: float) -> None:
    """Warn once of each wire that does not settle."""
    for wire in wires:
        if wire not in interface.reported:
            interface.reported.add(wire)
            warnings.warn(
                f"wire {'.'.join(wire.source)} -> {'.'.join(wire.target)}: expected a value that "
                f"settles in the macro step from t = {time:.6g} s, got changes in {MOST_SOLVES} "
                "solves; such a step holds the value at its beginning",
                stacklevel=2,
            )
