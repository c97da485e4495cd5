"""Work that crosses the interface, as each of its two sides computes it.

The difference is an error of the iteration.
"""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from ..fmi.errors import BadInput
from ..fmi.quantities import worth
from .interface import Interface
from .wiring import Wire


class WireWithConjugate(Protocol):
    """Wire of the case: both ends as "participant.variable", and its conjugate."""

    source: str
    target: str
    conjugate: str | None


End = tuple[float, np.ndarray, np.ndarray]
"""End of a step: time [s], and the values of inputs and outputs there."""


class ConjugatePair(NamedTuple):
    """Indices of a wire and its conjugate.

    is_power : whether their product is power, not work; tolerance : absolute tolerance of the wire,
    0 if it is not measured.
    """

    wire: int
    conjugate: int
    is_power: bool
    tolerance: float


class Exchange(NamedTuple):
    """Work across the interface in a macro step [J].

    work : ndarray, shape (2,), W_1 and W_2; exchanged : sum |F_in| . |dq_out|; passed : the same by
    the trapezoidal rule, with what F_in and a velocity were at the beginning; worth : sum |F_in| .
    (tolerance of q), what the iteration leaves open; step : length of the macro step [s].
    """

    work: np.ndarray
    exchanged: float
    passed: float
    worth: float
    step: float


class InterfaceWork:
    """Work of the wires that name a `conjugate`, summed over the macro steps.

    Eq. (W1):  W_1 = sum_steps F_in . (q_out(t+H) - q_out(t)),
               W_2 = sum_steps F_out . (q_in(t+H) - q_in(t))

    q is the wire's field, F its conjugate. Side 1 computes q_out from F_in, and side 2 computes
    F_out from q_in. If q is a velocity, q H replaces the difference. Both sides of a wire agree
    within its tolerance, and W_1 - W_2 is the energy that corresponds to the remaining difference.

    Parameters
    ----------
    interface : Interface
    tables : sequence of WireTable
        The wires as the case says them.
    begin : float
        Time of the participants at the start [s].

    Raises
    ------
    BadInput
        If a conjugate is no output that its wire's source reads, or the product is neither work nor
        power.
    """

    def __init__(
        self, interface: Interface, tables: Sequence[WireWithConjugate], begin: float = 0.0
    ):
        self.pairs = conjugates(interface.wires, tables)
        self.parts = interface.parts
        self.work = np.zeros(2)
        self.exchanged = 0.0
        self.last: End = begin, interface.read(), interface.read()

    def exchange(self, begin: End, end: End) -> Exchange:
        """Return the exchange in a step."""
        before, used_before, y_before = begin
        time, used, y = end
        step = time - before
        work = np.zeros(2)
        exchanged = passed = worth = 0.0
        for pair in self.pairs:
            q = self.parts[pair.wire]
            f = self.parts[pair.conjugate]
            span = step if pair.is_power else 1.0
            out = y[q] * step if pair.is_power else y[q] - y_before[q]
            into = used[q] * step if pair.is_power else used[q] - used_before[q]
            work += np.array([used[f] @ out, y[f] @ into])  # Eq. (W1)
            force = np.abs(used[f])
            ended = np.abs(out)
            began = np.abs(y_before[q]) * step if pair.is_power else ended
            across = float(force @ ended)
            exchanged += across
            passed += across / 2
            passed += float(np.abs(used_before[f]) @ began) / 2
            worth += span * pair.tolerance * float(force.sum())
        return Exchange(work, exchanged, passed, worth, step)

    def add(self, end: End, exchange: Exchange) -> None:
        """Add an accepted step; exchange : that since the last one."""
        self.last = end
        self.work += exchange.work
        self.exchanged += exchange.exchanged

    def summary(self) -> dict[str, float]:
        """Return the summary entries, none without conjugates.

        They are W_1 [J] and (W_1 - W_2) / sum |F_in| . |dq_out|.
        """
        if not self.pairs:
            return {}
        first, second = self.work.tolist()
        return {
            "interface_work_j": first,
            "interface_work_imbalance": (first - second) / (self.exchanged or 1.0),
        }


def conjugates(wires: Sequence[Wire], tables: Sequence[WireWithConjugate]) -> list[ConjugatePair]:
    """Return the pair of each wire that has a conjugate."""
    faults: list[str] = []
    pairs: list[ConjugatePair] = []
    ports = {(".".join(wire.source), ".".join(wire.target)): k for k, wire in enumerate(wires)}
    for table in tables:
        if table.conjugate is None or (table.source, table.target) not in ports:
            continue
        k = ports[table.source, table.target]
        back = _wire_back(wires, wires[k], table.conjugate)
        where = f"wire {table.source} -> {table.target}: conjugate = {table.conjugate!r}"
        if back is None:
            faults.append(
                f"{where}: expected a wire of this shape to {wires[k].source[0]}, got none"
            )
            continue
        product = worth(wires[k].unit, wires[back].unit)
        if product not in ("energy", "power"):
            faults.append(f"{where}: expected a product of work or power, got unit {product}")
        tolerance = wires[k].tolerance if np.isfinite(wires[k].tolerance) else 0.0
        pairs.append(ConjugatePair(k, back, product == "power", tolerance))
    if faults:
        raise BadInput(faults)
    return pairs


def _wire_back(wires: Sequence[Wire], wire: Wire, conjugate: str) -> int | None:
    """Return the index of the first wire of this shape from `conjugate` to the source of `wire`."""
    for k, other in enumerate(wires):
        from_there = ".".join(other.source) == conjugate
        if from_there and other.target[0] == wire.source[0] and other.shape == wire.shape:
            return k
    return None
