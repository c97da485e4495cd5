"""Energy that comes from nowhere: what participants say that they took from one another in a macro
step.

A participant that knows tells in an output, named in the contract, how much energy it took over its
wires in the last step: what it holds more of, and what it turned into heat. What one takes another
gives.

Eq. (W2):  c = sum over participants of E_i,   believed as long as  c <= LIMIT (X + sum Z_i) + Y,
           X = sum |F_in| . |dq_out|,   Y = sum |F_in| . (tolerance of q)

F and q are those of Eq. (W1), in the step: X is what passed to and fro, by the trapezoidal rule, Y
what the wires' tolerance is worth, Z_i the size of what a participant's account is made of besides,
where it tells. Of X + sum Z_i half of that of the step before counts, if it is more: an integrator
carries the errors of a step into the next, and after a stop little else is left. c is 0 where every
account is complete, and negative by the heat that none of them counts; where it is positive energy
was made, by a participant's discretisation in time or by its model. A macro step that is not
believed is taken back and halved, as one that does not converge.
"""

from collections.abc import Mapping

from ..fmi.errors import BadInput
from .stepping import EnergyCreated
from .wiring import Port
from .work import Exchange

LIMIT = 0.1
"""Of what passed to and fro and of what is held: our own choice. A mass that an integrator throws
back from a film faster than it came has a step with 0.2 or more (`tests/mfbd/test_impact.py`).
"""
REMEMBERED = 0.5
"""Of the size of a step, in the next one."""


class Ledger:
    """What participants took, over the macro steps.

    Parameters
    ----------
    ports : sequence of (participant, variable)
        Outputs E_i [J].
    sizes : sequence of (participant, variable)
        Outputs Z_i [J].

    Attributes
    ----------
    taken : dict of str to float
        Sum of E_i by participant [J].
    largest : float
        Largest c / (X + sum Z_i + Y) of a step [-], negative where none made energy.
    size : float
        X + sum Z_i of the last step, or what counted in its place [J].
    """

    def __init__(self, ports: list[Port], sizes: list[Port]):
        self.ports = ports
        self.sizes = sizes
        self.taken = {name: 0.0 for name, _ in ports}
        self.largest = -float("inf")
        self.size = 0.0

    def check(self, participants: Mapping, exchange: Exchange) -> None:
        """Raise EnergyCreated unless the last step of the participants is to be believed."""
        amounts = self._read(participants)
        created = sum(amounts.values())
        whole = self._whole(participants, exchange)
        allowed = LIMIT * whole + exchange.worth
        if created > allowed:  # Eq. (W2)
            said = ", ".join(f"{name} {amount:.3g} J" for name, amount in amounts.items())
            raise EnergyCreated(
                f"energy from nowhere: {created:.3g} J ({said}) of {whole:.3g} J that "
                f"passed to and fro or was held, allowed {allowed:.3g} J"
            )

    def add(self, participants: Mapping, exchange: Exchange) -> None:
        """Count the last step of the participants."""
        amounts = self._read(participants)
        for name, amount in amounts.items():
            self.taken[name] += amount
        self.size = self._whole(participants, exchange)
        whole = self.size + exchange.worth
        if whole > 0.0:
            self.largest = max(self.largest, sum(amounts.values()) / whole)

    def summary(self) -> dict[str, float]:
        """Summary entries: the energy that each took [J], and `largest`."""
        taken = {f"energy_taken_{name}_j": amount for name, amount in self.taken.items()}
        return taken | {"energy_created_share_max": self.largest}

    def _whole(self, participants, exchange):
        held = (float(participants[name].get(port)) for name, port in self.sizes)
        return max(exchange.passed + sum(held), REMEMBERED * self.size)

    def _read(self, participants):
        return {name: float(participants[name].get(port)) for name, port in self.ports}


def ledger(
    ports: list[Port], sizes: list[Port], conjugates: int, participants: Mapping
) -> Ledger | None:
    """Of a case in which at least two participants tell what they took, and wires tell what passed;
    arguments as of `Ledger`.

    Raises
    ------
    BadInput
        If an output is in another unit than J.
    """
    for name, port in (*ports, *sizes):
        unit = participants[name].fields[port].unit
        if unit != "J":
            raise BadInput(f"{name}.{port}: is in {unit}, the contract says J")
    return Ledger(ports, sizes) if len(ports) > 1 and conjugates else None
