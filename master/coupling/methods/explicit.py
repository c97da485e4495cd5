"""No iteration: the loose coupling of most co-simulation tools."""

import warnings
from dataclasses import dataclass

import numpy as np

from ..interface import Evaluation, Interface
from ..wiring import Wire
from .solution import NotConverged, Solution, Tried, check_finite

RISES = 10
"""Successive macro steps in which the residual must grow before the run stops, by LARGEST_GROWTH
or twofold in each of them.
"""
LARGEST_GROWTH = 1e9
"""Growth of the residual, at least of one tolerance, that an exchange may have."""
UNRESOLVED = 0.5
"""A residual above this share of the values is not the change of a resolved signal."""


@dataclass
class Growth:
    """Growth of the residual over the macro steps.

    Attributes
    ----------
    last : float
        Residual / tolerance of the last macro step.
    base : float
        The same where the residual began to grow, at least 1.
    rises : int
        Successive macro steps in which it has grown.
    doublings : int
        Successive macro steps in which it has at least doubled.
    early : float
        Largest of the first RISES macro steps, at least 1.
    steps : int
        Macro steps so far.
    warned : bool
        The warning has been given.
    """

    last: float = 0.0
    base: float = 1.0
    rises: int = 0
    doublings: int = 0
    early: float = 1.0
    steps: int = 0
    warned: bool = False

    def note(self, residual: float) -> None:
        """Note the residual / tolerance of a macro step."""
        self.steps += 1
        self.doublings = self.doublings + 1 if residual >= 2.0 * self.last and residual else 0
        if self.steps > 1 and residual > self.last:
            self.rises += 1
        else:
            self.rises, self.base = 0, max(residual, 1.0)
        if self.steps <= RISES:
            self.early = max(self.early, residual)
        self.last = residual

    @property
    def is_due(self) -> bool:
        """Return whether the residual has grown or doubled in RISES macro steps since a check."""
        return self.doublings >= RISES or self.rises % RISES == 0 < self.rises

    @property
    def is_unstable(self) -> bool:
        """Return whether the residual has grown without a break by more than it may."""
        return self.rises >= RISES and self.last > LARGEST_GROWTH * self.base


@dataclass(frozen=True)
class Explicit:
    """One evaluation for each macro step, without iteration.

    A wire along the stepping order carries the output at the end of the macro step. A wire against
    it carries the output at its beginning, or extrapolated ones with a predictor. Both are held
    over the macro step, so that errors are of first order in the macro step.

    Stable only where the coupling is weak. The run stops if the residual, which is the change of
    the wires against the order, grows in RISES successive macro steps by LARGEST_GROWTH and is
    more than half of the values, or in a loop doubles in each of them. The run warns once if it
    grows by as much as LARGEST_GROWTH with breaks, or less in a loop without a break.
    """

    def memory(self) -> Growth:
        return Growth()

    def solve(self, macro_step: Tried, guess: np.ndarray, memory: Growth) -> Solution:
        interface = macro_step.interface
        at = getattr(macro_step, "evaluate_once", macro_step.evaluate)(guess)
        history = (interface.measure(at.residual, at.outputs),)
        if history[0] <= 1.0:
            memory.note(history[0])
        else:
            check_finite(interface, at, history)
            memory.note(_residual(interface, at) if interface.relative else history[0])
            if memory.last > LARGEST_GROWTH or memory.is_due:
                _check_growth(interface, at, history, memory)
        return Solution(at.outputs, history, held=at.used)


def _residual(interface: Interface, at: Evaluation) -> float:
    """Return the largest residual in units of 1e-6 nominal values."""
    return 1e6 * float(np.max(np.abs(at.residual / interface.nominal)))


def _check_growth(
    interface: Interface, at: Evaluation, history: tuple[float, ...], memory: Growth
) -> None:
    """Raise NotConverged if the exchange is unstable; warn if it has grown by as much."""
    sizes = np.abs(np.where(interface.feedback, at.residual, 0.0) / interface.nominal)
    element = int(np.argmax(sizes))
    wire = next(w for w, p in zip(interface.wires, interface.parts) if element < p.stop)
    name = f"wire {'.'.join(wire.source)} -> {'.'.join(wire.target)}"
    hint = 'explicit exchange is unstable here; use method = "newton" or a shorter macro step'
    values = float(np.max(np.abs(at.outputs / interface.nominal)))
    is_loop, unresolved = _closes_loop(interface, wire), sizes[element] > UNRESOLVED * values
    doubles = memory.doublings >= RISES and is_loop
    if doubles or (memory.is_unstable and unresolved):
        growth = memory.last / memory.base
        raise NotConverged(
            f"{name}: expected an exchange that stays bounded, got a residual that grew "
            f"{growth:.2g}-fold in {memory.rises} macro steps; {hint}",
            interface,
            at,
            history,
            is_final=True,
        )
    swings = memory.rises >= RISES and is_loop and unresolved
    if not memory.warned and (swings or memory.last > LARGEST_GROWTH * memory.early):
        memory.warned = True
        growth = memory.last / (memory.base if swings else memory.early)
        span = f"in {memory.rises} macro steps" if swings else "since the start"
        warnings.warn(
            f"{name}: the residual grew {growth:.2g}-fold {span}; if the values should "
            f"stay bounded, {hint}",
            stacklevel=2,
        )


def _closes_loop(interface: Interface, wire: Wire) -> bool:
    """Return whether the source of a wire depends on its target."""
    reached = {wire.target[0]}
    for _ in interface.participants:
        reached |= {one.target[0] for one in interface.wires if one.source[0] in reached}
    return wire.source[0] in reached
