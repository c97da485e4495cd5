"""Macro step in which values that are not real numbers agree too: repeated solves."""

from typing import Any

import numpy as np

from .methods import Explicit, MacroStep, Method, Solution
from .wiring import HeldWire, name_of

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
    fixed: dict[HeldWire, Any] = {}
    solution = method.solve(macro_step, guess, memory)
    solves = 1
    while changed := [wire for wire in interface.unsettled() if wire not in fixed]:
        interface.hold(changed)
        if solves >= MOST_SOLVES:
            fixed |= {wire: begin[wire] for wire in changed}
            interface.late |= fixed
        more = method.solve(macro_step, solution.x, memory)
        solves += 1
        solution = more._replace(
            history=solution.history + more.history,
            jacobians=solution.jacobians + more.jacobians,
            products=solution.products + more.products,
            probes=solution.probes + more.probes,
        )
    text = (
        f"expected a value that settles in the macro step, got changes in {MOST_SOLVES} solves; "
        "the step holds the value at its beginning"
    )
    messages = tuple((name_of(wire), text) for wire in fixed)
    return solution._replace(messages=messages, unsettled=len(fixed))
