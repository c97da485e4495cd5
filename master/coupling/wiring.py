"""A system ready to run: participants and wires in SI."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf, prod
from typing import Any

import numpy as np

from ..fmi.symmetry import thrust_image
from ..participants.participant import Participant
from .vector import Layout

Port = tuple[str, str]
"""(participant, variable)."""


def port_of(text: str) -> Port:
    """Return the port of "participant.variable"; the variable's name may contain dots."""
    owner, _, name = text.partition(".")
    return owner, name


@dataclass(frozen=True)
class HeldWire:
    """Wire that is not iterated: its values are not real numbers, or it is clocked.

    clocked : whether it ends at a clocked input or a tunable parameter. Then the target gets the
    value of the source at the beginning of a macro step, otherwise in each evaluation
    (`Interface`).
    """

    source: Port
    target: Port
    clocked: bool = False


@dataclass(frozen=True)
class Wire:
    """Wire in SI.

    tolerance : infinite if the wire is not measured, 0 if only a relative criterion counts; noise :
    error of its values after a restored step, relative to their size; mirrored : whether its field
    is expected to be its own mirror image about the thrust plane.
    """

    source: Port
    target: Port
    shape: tuple[int, ...]
    unit: str
    nominal: float
    tolerance: float
    largest_decrease: float | None
    relative_tolerance: float = 0.0
    local_error: float | None = None
    noise: float = 0.0
    mirrored: bool = False

    def allowed(self, values: np.ndarray) -> float:
        """Return the residual that counts as converged, by element, for outputs of the wire."""
        return max(self.tolerance, self.relative_tolerance * rms(values))

    def measure(self, residual: np.ndarray, values: np.ndarray) -> float:
        """Return the measure of convergence: converged if at most 1, NaN if not finite.

        Eq. (S1):  min(max|r| / tolerance, rms(r) / (relative tolerance x rms(values)))
        """
        largest = float(np.max(np.abs(residual))) / self.tolerance if self.tolerance else np.inf
        if not self.relative_tolerance:
            return largest
        relative = self.relative_tolerance * rms(values)
        # Eq. (S1)
        return float(np.minimum(largest, rms(residual) / max(relative, np.finfo(float).tiny)))


def name_of(wire: Wire | HeldWire) -> str:
    """Return "wire a.y -> b.u", also of a wire from another component."""
    return f"wire {'.'.join(filter(None, wire.source))} -> {'.'.join(wire.target)}"


def rms(values: np.ndarray) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))


def is_unknown(wire: Wire | HeldWire, order: Sequence[str], parallel: bool) -> bool:
    """Return whether a wire runs against the stepping order and so carries unknowns."""
    return parallel or order.index(wire.target[0]) <= order.index(wire.source[0])


def layout_of(wires: Sequence[Wire], order: Sequence[str], parallel: bool) -> Layout:
    """Return the layout of the vector of wires for a stepping order, see `is_unknown`."""
    sizes = np.array([prod(wire.shape) for wire in wires], int)

    def by_element(values: Iterable[float]) -> np.ndarray:
        return np.repeat(np.array([*values], float), sizes)

    limits = [inf if w.largest_decrease is None else w.largest_decrease for w in wires]
    ends = np.cumsum(sizes)
    unknowns = np.flatnonzero(by_element(is_unknown(wire, order, parallel) for wire in wires))
    images = np.arange(sum(sizes))
    for wire, end in zip(wires, ends):
        if wire.mirrored:
            own = images[end - prod(wire.shape) : end].reshape(wire.shape)
            own[:] = own[thrust_image(len(own))]
    half = unknowns[unknowns <= images[unknowns]]
    return Layout(
        ends=ends,
        unknowns=unknowns,
        half=half,
        images=images[half],
        nominal=by_element(wire.nominal for wire in wires),
        tolerance=by_element(wire.tolerance for wire in wires),
        largest_decrease=np.array(limits, float),
    )


@dataclass(frozen=True)
class System:
    """Participants in the order they start, wires, parameters in SI, and times.

    begin, stop, step : start and stop time, macro step [s]; smallest_step : where step control
    divides macro steps [s]; record_interval : time between records of the fields [s], 0 if macro
    steps are counted; parallel : Jacobi's order, in which every participant reads the outputs of
    the evaluation before; held : wires that are not iterated; clocks : wires from clock to clock;
    period : of the machine [s], 0 if it is unknown; earliest : first time at which the run may end
    [s], which is `stop` unless the run ends when it is periodic; masks : participant -> rows of the
    cells of its fields, 1 for an existing cell, else 0; trusted : participants that are restored
    without a test of their states; limits : outputs with the longest step that resolves the motion
    of a participant [s].
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
    masks: Mapping[str, list[list[int]]] = field(default_factory=dict[str, list[list[int]]])
    clocks: tuple[HeldWire, ...] = ()
    record_interval: float = 0.0
    trusted: frozenset[str] = frozenset()
    limits: tuple[Port, ...] = ()

    @property
    def discrete(self) -> list[HeldWire]:
        """Wires of values that are not real numbers."""
        return [wire for wire in self.held if not wire.clocked]


def carry(participants: Mapping[str, Participant], held: Iterable[HeldWire]) -> None:
    """Set the targets of held wires to the present values of their sources."""
    for wire in held:
        value = participants[wire.source[0]].get(wire.source[1])
        participants[wire.target[0]].set(wire.target[1], value)
