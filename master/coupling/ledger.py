"""Spurious energy: sum of the energies that participants receive from each other in a step.

A participant may have an output, named in the contract, for the power that it received over its
wires, mean over the last step. Times the length of the step, it is the sum E_i of the stored and
the dissipated energy.

Eq. (W2):  c = sum over participants of E_i - L,   accepted if
               c <= LARGEST_SHARE (X + sum Z_i) + Y,
           X = sum |F_in| . |dq_out|,   Y = sum |F_in| . (tolerance of q)

F and q are those of Eq. (W1) in the step. X is the energy exchanged, by the trapezoidal rule. Y is
the energy of the wires' tolerances. Z_i is the size of the other terms of a participant's balance,
if it has outputs for it. X + sum Z_i is at least half of that of the previous step, because an
integrator carries the errors of a step into the next. For the same reason a step can return L, half
of the energy that was lost in the previous one. An impact is too short for the trapezoidal rule: it
loses energy in one step and returns a part in the next. c is 0 if every balance is complete, and
negative by dissipation that no balance includes. c is positive if time integration or a model
creates energy. A macro step that is not accepted is rejected and halved, as if it did not converge.

Parts that resolve an impact are balanced together: E_i, X and the Z_i of powers are sums over the
macro step, Y and the stored Z_i the largest of its parts. The force of a film that opens drops
within a step of any length. The share of a short part is therefore no smaller, and it is large if
the motion turns round in the part.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ..fmi.errors import BadInput
from ..participants.participant import Participant
from .stepping import EnergyCreated
from .wiring import Port
from .work import End, Exchange

Participants = Mapping[str, Participant]

LARGEST_SHARE = 0.1
"""Largest spurious energy over the energy exchanged and stored, an assumption. The shipped cases
exceed 2 % in 6 of 726 steps at most, and slaps on scarce oil have up to 8 %
(docs/measurements/impacts.md).
"""
MEMORY_SHARE = 0.5
"""Fraction of the size and of the loss of a step that counts in the next one."""


class Balance(NamedTuple):
    """Energies of a macro step, or of a part of it [J].

    amounts : E_i by participant; passed : X and the Z_i of powers; stored : the other Z_i; worth :
    Y.
    """

    amounts: dict[str, float]
    passed: float
    stored: float
    worth: float

    @property
    def total(self) -> float:
        """Sum of E_i [J]."""
        return sum(self.amounts.values())


def total_balance(parts: Sequence[Balance]) -> Balance:
    """Return the balance of a macro step from those of its parts."""
    if len(parts) == 1:
        return parts[0]
    return Balance(
        {name: sum(part.amounts[name] for part in parts) for name in parts[0].amounts},
        sum(part.passed for part in parts),
        max(part.stored for part in parts),
        max(part.worth for part in parts),
    )


class JudgedPart(NamedTuple):
    """Part of a macro step that is not accepted yet; balance : None without a ledger."""

    is_first: bool
    end: End
    exchange: Exchange
    balance: Balance | None


class Ledger:
    """Energy that participants received over the macro steps.

    Parameters
    ----------
    ports : sequence of (participant, variable)
        Outputs E_i over the step [W].
    sizes : sequence of (participant, variable, unit)
        Outputs with parts of Z_i [J], or of Z_i over the step [W].

    Attributes
    ----------
    taken : dict of str to float
        Sum of E_i by participant [J].
    largest : float
        Largest c / (X + sum Z_i + Y) of a step [-], negative if no step created energy.
    size : float
        X + sum Z_i of the last step, or the fraction of the previous one [J].
    lost : float
        L of the next step [J], not below 0.
    """

    def __init__(self, ports: list[Port], sizes: list[tuple[str, str, str]]):
        self.ports = ports
        self.sizes = sizes
        self.taken = {name: 0.0 for name, _ in ports}
        self.largest = -float("inf")
        self.size = 0.0
        self.lost = 0.0

    def balance(self, participants: Participants, exchange: Exchange) -> Balance:
        """Return the balance of the last step of the participants."""
        sizes = {"J": 0.0, "W": 0.0}
        for name, port, unit in self.sizes:
            sizes[unit] += float(participants[name].get(port))
        step = exchange.step
        amounts = {name: step * float(participants[name].get(port)) for name, port in self.ports}
        passed = exchange.passed + step * sizes["W"]
        return Balance(amounts, passed, sizes["J"], exchange.worth)

    def check(self, step: Balance) -> None:
        """Raise EnergyCreated if the spurious energy of a macro step exceeds its limit."""
        created = step.total - self.lost
        size = self._size(step)
        allowed = LARGEST_SHARE * size + step.worth
        if created > allowed:  # Eq. (W2)
            amounts = ", ".join(f"{name} {amount:.3g} J" for name, amount in step.amounts.items())
            raise EnergyCreated(
                f"spurious energy: {created:.3g} J ({amounts}) of {size:.3g} J exchanged or "
                f"stored, limit {allowed:.3g} J"
            )

    def add(self, step: Balance) -> None:
        """Count a macro step."""
        for name, amount in step.amounts.items():
            self.taken[name] += amount
        self.size = self._size(step)
        size = self.size + step.worth
        created = step.total - self.lost
        if size > 0.0:
            self.largest = max(self.largest, created / size)
        self.lost = MEMORY_SHARE * max(-created, 0.0)

    def summary(self) -> dict[str, float]:
        """Return the summary entries: energy received by each participant [J], and `largest`."""
        taken = {f"energy_taken_{name}_j": amount for name, amount in self.taken.items()}
        return taken | {"energy_created_share_max": self.largest}

    def _size(self, step: Balance) -> float:
        return max(step.passed + step.stored, MEMORY_SHARE * self.size)


def ledger(
    ports: list[Port], sizes: list[Port], conjugates: int, participants: Participants
) -> Ledger | None:
    """Return the ledger of a case, None if fewer than two participants report their power.

    Return None also if no wire has a conjugate. The arguments are those of `Ledger`, without units.

    Raises
    ------
    BadInput
        If an output is in another unit than W, or J of a size.
    """
    units = {port: participants[port[0]].fields[port[1]].unit for port in (*ports, *sizes)}
    faults = [
        f"{a}.{b}: expected unit W, got {units[a, b]}" for a, b in ports if units[a, b] != "W"
    ]
    faults += [
        f"{a}.{b}: expected unit J or W, got {units[a, b]}"
        for a, b in sizes
        if units[a, b] not in ("J", "W")
    ]
    if faults:
        raise BadInput(faults)
    known = [(*port, units[port]) for port in sizes]
    return Ledger(ports, known) if len(ports) > 1 and conjugates else None
