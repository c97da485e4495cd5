"""No iteration: the loose coupling of most co-simulation tools."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

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
LASTING = 0.45
"""Share of the last residual above which a residual lasts. Only such residuals are compared."""
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
    lasting : int
        Successive macro steps in which it has kept at least LASTING of its size.
    changes : tuple of ndarray
        Residuals of up to RISES + 1 macro steps, the last one first.
    """

    last: float = 0.0
    base: float = 1.0
    rises: int = 0
    doublings: int = 0
    early: float = 1.0
    steps: int = 0
    warned: bool = False
    lasting: int = 0
    changes: tuple[np.ndarray, ...] = ()

    def note(self, residual: float) -> None:
        """Note the residual / tolerance of a macro step."""
        self.steps += 1
        self.lasting = self.lasting + 1 if residual >= LASTING * self.last and residual else 0
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
        """Return whether a check is due, after RISES macro steps without a break."""
        grows = self.doublings >= RISES or self.rises % RISES == 0 < self.rises
        return grows or self.lasting % RISES == 0 < self.lasting

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

    Stable only where the coupling is weak. The residual is the change of the wires against the
    order. The run stops if the residual grows in RISES successive macro steps by LARGEST_GROWTH
    and is more than half of the values. It also stops if that of a loop doubles in each of them.
    The run warns once if the residual grows by as much as LARGEST_GROWTH with breaks, or less in a
    loop without a break. It also warns if the residual of a loop changes its sign without damping,
    or grows by a constant factor.
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
            memory.changes = (at.residual, *memory.changes[:RISES])
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
    swings, factor = _repetition(interface, memory.changes) if is_loop else (False, 0.0)
    if memory.rises >= RISES and is_loop and unresolved:
        growth = memory.last / memory.base
        got = f"the residual grew {growth:.2g}-fold in {memory.rises} macro steps"
    elif swings:
        unit = "" if wire.unit == "1" else f" {wire.unit}"
        size = f"{abs(at.residual[element]):.3g}{unit}"
        got = f"an undamped oscillation changes the output by {size} in each macro step"
    elif factor:
        got = f"the residual grew {factor:.4g}-fold in each of {RISES} macro steps"
    elif memory.last > LARGEST_GROWTH * memory.early:
        got = f"the residual grew {memory.last / memory.early:.2g}-fold since the start"
    else:
        return ()
    memory.warned = True
    return ((name_of(wire), f"{got}; if the values should stay bounded, {hint}"),)


def _repetition(interface: Interface, changes: Sequence[np.ndarray]) -> tuple[bool, float]:
    """Return whether residuals oscillate without damping, and their constant growth factor or 0.

    changes : those of successive macro steps, the last one first.
    """
    if len(changes) <= RISES:
        return False, 0.0
    rows = (np.array(changes) / interface.nominal)[:, interface.unknowns]
    swings = any(_returns(rows[:-lag], rows[lag:]) for lag in range(1, MOST_LAGS + 1))
    products = np.sum(rows[:-1] * rows[1:], axis=1)
    factors = products / np.maximum(np.sum(rows[1:] ** 2, axis=1), np.finfo(float).tiny)
    is_steady = np.ptp(factors) <= STEADY and factors.min() >= LEAST_GROWTH
    return swings, float(factors[0]) if is_steady else 0.0


def _returns(later: np.ndarray, earlier: np.ndarray) -> bool:
    """Return whether each residual is the earlier one with the opposite sign."""
    sizes = np.linalg.norm(later, axis=1)
    are_opposite = np.linalg.norm(later + earlier, axis=1) <= OPPOSITE * sizes
    return bool((are_opposite & (sizes >= UNDAMPED * np.linalg.norm(earlier, axis=1))).all())


def _closes_loop(interface: Interface, wire: Wire) -> bool:
    """Return whether the source of a wire depends on its target."""
    reached = {wire.target[0]}
    for _ in interface.participants:
        reached |= {one.target[0] for one in interface.wires if one.source[0] in reached}
    return wire.source[0] in reached
