"""Macro step to solve, its solution, and its failure."""

from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any, NamedTuple, Protocol

import numpy as np

from ..interface import Evaluation, Interface


class MacroStep(NamedTuple):
    """Macro step of `interface` from `time` over `step` [s].

    Every evaluation begins from the `saved` states. share : of the predicted change, which the
    limits of wires have left.
    """

    interface: Interface
    time: float
    step: float
    saved: dict[str, Any]
    share: float = 1.0

    def evaluate(self, x: np.ndarray) -> Evaluation:
        """Return `Interface.evaluate` of this step."""
        return self.interface.evaluate(x, (self.time, self.step), self.saved)

    def evaluate_once(self, x: np.ndarray) -> Evaluation:
        """Return the only evaluation of this step, which restores no state.

        Some FMUs continue differently from a restored state.
        """
        return self.interface.evaluate(x, (self.time, self.step))

    def derivative(self, change: np.ndarray) -> np.ndarray:
        """Return `Interface.derivative` at the last evaluation."""
        return self.interface.derivative(change)


class Solution(NamedTuple):
    """An accepted macro step.

    x : the wires at its end, from which the next step starts; held : inputs that differ from `x`
    in a step that was not iterated; history : `Interface.measure` of every iteration; jacobians :
    number of linearisations; products : number of directional derivatives of the whole evaluation;
    probes : number of evaluations that replaced them; messages : warnings, each the name of a wire
    and a text; unsettled : number of discrete wires that were held because they do not settle.
    """

    x: np.ndarray
    history: tuple[float, ...]
    jacobians: int = 0
    products: int = 0
    probes: int = 0
    held: np.ndarray | None = None
    messages: tuple[tuple[str, str], ...] = ()
    unsettled: int = 0

    @property
    def inputs(self) -> np.ndarray:
        """Values that the inputs were set to."""
        return self.x if self.held is None else self.held

    @property
    def iterations(self) -> int:
        """Number of evaluations without probes."""
        return len(self.history)


class Tried(Protocol):
    """A macro step for a method: `MacroStep`, or an object that replaces it."""

    @property
    def interface(self) -> Interface: ...
    def evaluate(self, x: np.ndarray) -> Evaluation: ...
    def derivative(self, change: np.ndarray) -> np.ndarray: ...


class Method(Protocol):
    """Method that finds the fixed point of a macro step."""

    def memory(self) -> Any:
        """Return what the method carries from one macro step to the next, None if nothing."""

    def solve(self, macro_step: Tried, guess: np.ndarray, memory: Any) -> Solution:
        """Return the macro step at its fixed point; raise NotConverged if there is none."""
        ...


class NotConverged(RuntimeError):
    """A macro step without a fixed point: the reason, the worst residual, and its history.

    Attributes
    ----------
    is_final : bool
        The run stops at once, since shorter macro steps cannot help.
    is_not_finite : bool
        The first evaluation gave an output that is not finite.
    cause : callable, optional
        Returns the likely cause. It evaluates the participants again, so that it is asked only if
        the run stops.
    """

    is_not_finite = False
    cause: Callable[[], str] | None = None

    def __init__(
        self,
        reason: str,
        interface: Interface,
        evaluation: Evaluation,
        history: Sequence[float],
        is_final: bool = False,
    ):
        self.iterations = len(history)
        self.is_final = is_final
        trail = [f"{value:.2g}" for value in history]
        shown = trail if len(trail) <= 12 else [*trail[:6], "...", *trail[-5:]]
        if isfinite(history[-1]):
            reason = f"{reason}; {interface.worst(evaluation.residual, evaluation.outputs)}"
        super().__init__(f"{reason}; residual/tolerance per iteration: {' '.join(shown)}")

    def explained(self) -> str:
        """Return the message with the likely cause."""
        return f"{self}; {self.cause()}" if self.cause else str(self)


def check_finite(interface: Interface, evaluation: Evaluation, history: Sequence[float]) -> None:
    """Raise NotConverged if an output is NaN or infinite."""
    if not isfinite(history[-1]) and not np.isfinite(evaluation.outputs).all():
        failure = NotConverged(interface.not_finite(evaluation), interface, evaluation, history)
        failure.is_not_finite = len(history) == 1
        raise failure
