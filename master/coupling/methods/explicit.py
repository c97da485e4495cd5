"""No iteration: the loose coupling of most co-simulation tools."""

from dataclasses import dataclass

import numpy as np

from ...fmi.quantities import short
from ..interface import Evaluation, Interface
from ..wiring import Wire, name_of
from .solution import NotConverged, Solution, Tried, check_finite

RISES = 10
"""Successive macro steps in which the residual must grow before the run stops, by LARGEST_GROWTH
or twofold in each of them.
"""
LARGEST_GROWTH = 1e9
"""Growth of the residual, at least of one tolerance, that an exchange may have."""
UNRESOLVED = 0.5
"""A residual above this share of the values is not the change of a resolved signal."""
MOST_LAGS = 3
"""Macro steps after which a residual may return with the opposite sign: as many as the unknowns
of a ring of gain -1 in Jacobi's order.
"""
OPPOSITE, UNDAMPED = 0.2, 0.98
"""A residual that returns with the opposite sign: the largest share by which it may differ, and the
least share of its size. In RISES macro steps it then loses less than a fifth.
"""
STEADY, LEAST_GROWTH = 1e-3, 1.02
"""Largest change of a growth factor that counts as constant over RISES macro steps, and the least
factor. Powers of time up to the fourth, which grow by a falling factor, stay below.
"""


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
    changes : tuple of ndarray
        Residuals in nominals of up to MOST_LAGS macro steps, the last one first.
    returns : tuple of int
        Successive macro steps whose residual is an earlier one with the opposite sign, by lag.
    factor : float
        Growth factor of the residual where it became constant.
    steady : int
        Successive macro steps with this factor.
    """

    last: float = 0.0
    base: float = 1.0
    rises: int = 0
    doublings: int = 0
    early: float = 1.0
    steps: int = 0
    warned: bool = False
    changes: tuple[np.ndarray, ...] = ()
    returns: tuple[int, ...] = (0,) * MOST_LAGS
    factor: float = 0.0
    steady: int = 0

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

    def compare(self, change: np.ndarray) -> None:
        """Compare a residual in nominals with those of the macro steps before."""
        size = float(change @ change)
        products = [float(change @ past) for past in self.changes]
        sizes = [float(past @ past) for past in self.changes]
        likes = [
            size + 2.0 * product + other <= OPPOSITE**2 * size and size >= UNDAMPED**2 * other > 0.0
            for product, other in zip(products, sizes)
        ]
        self.returns = tuple(like * (count + 1) for like, count in zip(likes, self.returns))
        self.returns += (0,) * (MOST_LAGS - len(likes))
        factor = products[0] / sizes[0] if sizes and sizes[0] else 0.0
        if abs(factor - self.factor) <= STEADY:
            self.steady += 1
        else:
            self.factor, self.steady = factor, 0
        self.changes = (change, *self.changes[: MOST_LAGS - 1])

    @property
    def is_due(self) -> bool:
        """Return whether a check is due: after RISES macro steps of one kind, see `Explicit`."""
        grows = self.doublings >= RISES or self.rises % RISES == 0 < self.rises
        return grows or self.grows_steadily or max(self.returns) >= RISES

    @property
    def grows_steadily(self) -> bool:
        """Return whether the residual has grown by a constant factor in RISES macro steps."""
        return self.steady >= RISES and self.factor >= LEAST_GROWTH

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
    grows by as much as LARGEST_GROWTH with breaks, or less in a loop without a break. It also warns
    if the residual of a loop changes its sign without damping, or grows by a constant factor.
    """

    def memory(self) -> Growth:
        return Growth()

    def solve(self, macro_step: Tried, guess: np.ndarray, memory: Growth) -> Solution:
        interface = macro_step.interface
        at = getattr(macro_step, "evaluate_once", macro_step.evaluate)(guess)
        history = (interface.measure(at.residual, at.outputs),)
        messages = ()
        if history[0] <= 1.0:
            memory.note(history[0])
            memory.changes = ()
        else:
            check_finite(interface, at, history)
            memory.note(_residual(interface, at) if interface.relative else history[0])
            unknowns = interface.unknowns
            memory.compare(at.residual[unknowns] / interface.nominal[unknowns])
            if memory.last > LARGEST_GROWTH or memory.is_due:
                messages = _check_growth(interface, at, history, memory)
        return Solution(at.outputs, history, held=at.used, messages=messages)


def _residual(interface: Interface, at: Evaluation) -> float:
    """Return the largest residual in units of 1e-6 nominal values."""
    return 1e6 * float(np.max(np.abs(at.residual / interface.nominal)))


def _check_growth(
    interface: Interface, at: Evaluation, history: tuple[float, ...], memory: Growth
) -> tuple[tuple[str, str], ...]:
    """Return the warning about an exchange; raise NotConverged if it is unstable."""
    sizes = np.abs(np.where(interface.feedback, at.residual, 0.0) / interface.nominal)
    element = int(np.argmax(sizes))
    wire = next(w for w, p in zip(interface.wires, interface.parts) if element < p.stop)
    hint = 'explicit exchange is unstable here; use method = "newton" or a shorter macro step'
    values = float(np.max(np.abs(at.outputs / interface.nominal)))
    is_loop, unresolved = _closes_loop(interface, wire), sizes[element] > UNRESOLVED * values
    doubles = memory.doublings >= RISES and is_loop
    if doubles or (memory.is_unstable and unresolved):
        growth = memory.last / memory.base
        raise NotConverged(
            f"{name_of(wire)}: expected an exchange that stays bounded, got a residual that grew "
            f"{growth:.2g}-fold in {memory.rises} macro steps; {hint}",
            interface,
            at,
            history,
            is_final=True,
        )
    if memory.warned:
        return ()
    if memory.rises >= RISES and is_loop and unresolved:
        growth = memory.last / memory.base
        got = f"the residual grew {growth:.2g}-fold in {memory.rises} macro steps"
    elif max(memory.returns) >= RISES and is_loop:
        size = short(float(abs(at.residual[element])), wire.unit)
        got = f"an undamped oscillation changes the output by {size} in each macro step"
    elif memory.grows_steadily and is_loop:
        got = f"the residual grew {memory.factor:.4g}-fold in each of {memory.steady} macro steps"
    elif memory.last > LARGEST_GROWTH * memory.early:
        got = f"the residual grew {memory.last / memory.early:.2g}-fold since the start"
    else:
        return ()
    memory.warned = True
    return ((name_of(wire), f"{got}; if the values should stay bounded, {hint}"),)


def _closes_loop(interface: Interface, wire: Wire) -> bool:
    """Return whether the source of a wire depends on its target."""
    reached = {wire.target[0]}
    for _ in interface.participants:
        reached |= {one.target[0] for one in interface.wires if one.source[0] in reached}
    return wire.source[0] in reached
