"""Loops of a system before its run: how strongly each answers itself, and what would solve it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from ..fmi.errors import Discard, ParticipantFault
from ..fmi.quantities import short
from ..participants.restarted import RestartedParticipant
from .components import Component, Part, components, part
from .interface import Interface
from .methods import Explicit, MacroStep
from .methods.probing import jacobian
from .negotiation import trials, tried
from .wiring import System

MOST_UNKNOWNS = 200
"""Unknowns of a loop up to which its matrix is measured, one step of all members for each."""
FEW_UNKNOWNS = 20
"""Number of unknowns up to which Newton by differences needs fewer evaluations than secants."""
WEAK_GAIN = 0.5
"""Gain up to which an exchange without iteration is taken to be stable and of use."""
GAIN_ERROR = 1e-3
"""Error of a gain that is measured by differences."""
MOST_HALVINGS = 6
"""Maximum number of halvings of the step to find one with a weak gain."""

ROW = "  {:9s} {:>8s} {:>9s} {:>9s} {:>9s}  {}"
HEADER = ROW.format("method", "unknowns", "gain", "condition", "step", "participants")


@dataclass(frozen=True)
class Loop:
    """A component of the wires as it is at the start of a run.

    Eq. (S4):  gain = max |eigenvalue of J|,   condition = (1 + |J|) / smallest singular value of
               I - J,   J = dG/dx in nominals

    unknowns : elements that the iteration looks for; gain, condition : NaN if not measured, for
    the reason in `why`; method, step [s] : what the master would choose; unstable : why an
    exchange without iteration does not settle, or "".
    """

    component: Component
    unknowns: int = 0
    gain: float = np.nan
    condition: float = np.nan
    method: str = "once"
    step: float = np.nan
    why: str = ""
    unstable: str = ""

    header: ClassVar[str] = HEADER

    @property
    def line(self) -> str:
        """Row of a table, see `header`."""
        numbers = [f"{self.gain:.3g}", f"{self.condition:.3g}", short(self.step, "s")]
        shown = ["-" if text.startswith("nan") else text for text in numbers]
        cells = (self.method, str(self.unknowns or "-"), *shown, ", ".join(self.component.names))
        return ROW.format(*cells) + (f"  ({self.why})" if self.why else "")


def loops(system: System) -> list[Loop]:
    """Return the components of a started system in the order in which they would step.

    Gain and condition are those of one macro step from the start, by differences. FMUs without
    saved states are started again for each. The participants are no longer to be run afterwards.
    """
    system = tried(system, trials(system))
    groups = components(system)
    fixed = {name for one in groups for name in one.fixed}
    known: dict[str, Any] = {
        name: _restarted(system, name) if name in fixed else participant
        for name, participant in system.participants.items()
    }
    whole = Interface(
        {name: known[name] for name in system.order},
        system.wires,
        system.parallel,
        system.discrete,
    )
    return [
        _loop(part(whole, one, Explicit(), system.parallel), system) if one.is_loop else Loop(one)
        for one in groups
    ]


def _restarted(system: System, name: str) -> RestartedParticipant:
    """Return a participant that restarts with its present inputs."""
    one = system.participants[name]
    inputs = [w.target[1] for w in (*system.wires, *system.held) if w.target[0] == name]
    now = {key: one.get(key) for key in inputs if key in one.fields}
    return RestartedParticipant(one, {**system.parameters[name], **now}, system.begin, system.stop)


def _loop(own: Part, system: System) -> Loop:
    """Return the loop of a component."""
    unknowns = int(own.interface.feedback.sum())
    one = Loop(own.component, unknowns, step=system.step)
    members: Any = own.interface.participants
    has_derivatives = all(members[name].has_derivatives for name in own.component.names)
    secants = unknowns > FEW_UNKNOWNS and not has_derivatives
    method = "explicit" if own.component.fixed else "iqn_ils" if secants else "newton"
    one = replace(one, method=method)
    if not unknowns:
        return replace(one, why="not measured: its unknowns are not real numbers")
    if unknowns > MOST_UNKNOWNS:
        return replace(one, why=f"not measured: more than {MOST_UNKNOWNS} unknowns")
    try:
        matrix = _matrix(own, system.begin, system.step)
        unstable = _unstable(matrix, own)
        one = replace(one, gain=_gain(matrix), condition=_condition(matrix), unstable=unstable)
        return _explicit(one, own, system) if own.component.fixed else _iterated(one)
    except (Discard, ParticipantFault) as failure:
        return replace(one, why=f"not measured: {failure}")


def _iterated(one: Loop) -> Loop:
    """Return an iterated loop with the reason if it has no unique solution."""
    singular = not one.condition < 1.0 / np.finfo(float).eps ** 0.5
    return replace(one, why="singular at the start: no unique solution" if singular else "")


def _explicit(one: Loop, own: Part, system: System) -> Loop:
    """Look for a step with which a loop that cannot be iterated is weak."""
    unable = f"{', '.join(one.component.fixed)} cannot restore a saved state"
    step, gain = system.step, one.gain
    for halvings in range(MOST_HALVINGS + 1):
        if halvings:
            step = system.step / 2**halvings
            gain = _gain(_matrix(own, system.begin, step))
        if gain <= WEAK_GAIN:
            return replace(one, step=step, why=unable)
    smallest = short(step, "s")
    return replace(one, why=f"{unable}; gain {gain:.3g} still at a step of {smallest}: may diverge")


def _matrix(own: Part, begin: float, step: float) -> np.ndarray:
    """Return J of a loop in nominals, by differences over a step from the start [s]."""
    interface = own.interface
    names: Sequence[str] = own.component.names
    saved = {name: interface.participants[name].save() for name in names}
    macro_step = own.of(MacroStep(interface, begin, step, saved))
    matrix = jacobian(macro_step, interface.read())
    for name in names:
        interface.participants[name].restore(saved[name])
        interface.participants[name].free(saved[name])
    return matrix


def _gain(matrix: np.ndarray) -> float:
    return float(np.max(np.abs(np.linalg.eigvals(matrix))))  # Eq. (S4)


def _unstable(matrix: np.ndarray, own: Part) -> str:
    """Return why an exchange without iteration does not settle, with the output that moves most.

    A change returns multiplied by the eigenvalues of J. A positive one of 1 keeps a value.
    """
    values, vectors = np.linalg.eig(matrix)
    away = np.where(np.real(values) > 0.0, np.abs(values) - GAIN_ERROR, np.abs(values) + GAIN_ERROR)
    k = int(np.argmax(away))
    if not away[k] >= 1.0:
        return ""
    interface = own.interface
    element = int(interface.unknowns[np.argmax(np.abs(vectors[:, k]))])
    wire = next(w for w, p in zip(interface.wires, interface.parts) if element < p.stop)
    behaviour = "grows" if np.abs(values[k]) > 1.0 + GAIN_ERROR else "oscillates without damping"
    factor = short(float(np.abs(values[k])), "1")
    return (
        f"expected an iteration of the loop {', '.join(own.component.names)}, got an exchange that "
        f"{behaviour}: a change of {'.'.join(wire.source)} is {factor} times as large after a "
        "macro step"
    )


def _condition(matrix: np.ndarray) -> float:
    smallest = np.linalg.svd(np.eye(len(matrix)) - matrix, compute_uv=False)[-1]
    whole = 1.0 + float(np.linalg.norm(matrix, 2))
    return whole / float(smallest) if smallest else np.inf  # Eq. (S4)
