"""A system ready to run: participants and wires in SI."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..participants.participant import Participant

Port = tuple[str, str]
"""(participant, variable)."""


def port_of(text: str) -> Port:
    """Port of "participant.variable"; the variable's own name may hold dots."""
    owner, _, name = text.partition(".")
    return owner, name


@dataclass(frozen=True)
class HeldWire:
    """A wire that carries no real numbers, or ends at a clocked input: what the source says at the
    beginning of a macro step is set at the target and held over the step.
    """

    source: Port
    target: Port


@dataclass(frozen=True)
class Wire:
    """A wire ready for use: both ends, shape, and in SI its nominal, tolerance and allowed local
    error.

    tolerance : infinite on a wire that is not measured, 0 where a relative criterion alone counts.
    """

    source: Port
    target: Port
    shape: tuple[int, ...]
    unit: str
    nominal: float
    tolerance: float
    largest_decrease: float | None
    relative_tolerance: float = 0.0
    residual_relative_tolerance: float = 0.0
    local_error: float | None = None

    def allowed(self, values: np.ndarray, first: float) -> float:
        """Size of an element's residual that counts as converged, for given values and rms of the
        step's first residual.
        """
        return max(
            self.tolerance,
            self.relative_tolerance * rms(values),
            self.residual_relative_tolerance * first,
        )

    def measure(self, residual: np.ndarray, values: np.ndarray, first: float) -> float:
        """How far the wire is from converged; 1 is just there, NaN if an element is not finite.

        Eq. (S1):  min(max|r| / tolerance, rms(r) / (relative tolerance x rms(values)),
                       rms(r) / (residual-relative tolerance x rms(r of the macro step's first
                       evaluation)))
        """
        largest = float(np.max(np.abs(residual))) / self.tolerance if self.tolerance else np.inf
        if not (self.relative_tolerance or self.residual_relative_tolerance):
            return largest
        relative = max(
            self.relative_tolerance * rms(values), self.residual_relative_tolerance * first
        )
        # Eq. (S1)
        return float(np.minimum(largest, rms(residual) / max(relative, np.finfo(float).tiny)))


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def is_unknown(wire: Wire, order: Sequence[str], parallel: bool) -> bool:
    """Whether a wire runs against the stepping order: what it carries is then an unknown of the
    iteration.
    """
    return parallel or order.index(wire.target[0]) <= order.index(wire.source[0])


@dataclass(frozen=True)
class System:
    """Participants in the order they start, stepping order, wires, parameters in SI, times,
    folder of the case.

    begin, stop, step : start and stop time, macro step [s]; smallest_step : where step control
    divides macro steps [s]; record_interval : from one record of the fields to the next [s], 0
    where macro steps are counted; parallel : Jacobi's order, every participant reads what the
    others said in the evaluation before; held : wires that carry no real numbers, or end at clocked
    inputs; clocks : wires from clock to clock; period : of the machine [s], 0 where it is unknown;
    earliest : where the run may end [s], `stop` unless it ends once periodic; masks : participant
    -> rows of the cells of its fields, 1 where there is one, 0 where not.
    """

    participants: Mapping[str, Any]
    order: tuple[str, ...]
    wires: tuple[Wire, ...]
    parameters: Mapping[str, Mapping[str, Any]]
    stop: float
    step: float
    smallest_step: float = 0.0
    folder: str = ""
    parallel: bool = False
    held: tuple[HeldWire, ...] = ()
    begin: float = 0.0
    period: float = 0.0
    earliest: float = 0.0
    masks: Mapping[str, list[list[int]]] = field(default_factory=dict)
    clocks: tuple[HeldWire, ...] = ()
    record_interval: float = 0.0


def carry(participants: Mapping[str, Participant], held: Iterable[HeldWire]) -> None:
    """Set what held wires carry, as their sources say it now."""
    for wire in held:
        value = participants[wire.source[0]].get(wire.source[1])
        participants[wire.target[0]].set(wire.target[1], value)
