"""Checks of the participants' saved states and derivatives at the start of a run."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf
from typing import Any

import numpy as np

from ..fmi.errors import BadInput, collecting
from ..participants.derivatives import Differenced, objection
from ..participants.one_way import OneWayParticipant
from ..participants.rollback import LARGEST_NOISE, RollbackTrial, rollback_trial
from .components import components, rolled_back
from .methods import Method, Newton
from .wiring import System, Wire

NOISE_MARGIN = 10.0
"""Tolerance of a wire in a loop, in noises of a restored step."""


def trials(system: System, iterates: bool = True) -> dict[str, RollbackTrial]:
    """Return the trials of saved states, by participant.

    Participants whose steps are never repeated are not tried: some FMUs go on differently from a
    state that is restored. `iterates` tells whether the method iterates loops.

    Raises
    ------
    BadInput
        If saved states that the case insists on, or that step control by a local error needs,
        cannot be used, and if instances of an FMU disturb one another.
    """
    by_name: dict[str, RollbackTrial] = {}
    faults: list[str] = []
    for name in rolled_back(system, iterates):
        with collecting(faults):
            by_name[name] = one = _trial(system, name, {})
            if one.fault and name in system.trusted:
                faults.append(
                    f"participants.{name}.rollback: expected saved states, got {one.fault}"
                )
    _measure_at_values(system, by_name)
    if any(wire.local_error is not None for wire in system.wires):
        faults += [
            f"participants.{name}: expected a restored state with local_error, got "
            f"{one.fault or one.message}"
            for name, one in by_name.items()
            if _is_rejected(system, name, one)
        ]
    if faults:
        raise BadInput(faults)
    return by_name


def _trial(system: System, name: str, changes: Mapping[str, Any]) -> RollbackTrial:
    """Return the trial of a participant, with other values of some inputs."""
    wires = (*system.wires, *system.held)
    inputs = [w.target[1] for w in wires if w.target[0] == name]
    outputs = {w.source[1] for w in wires if w.source[0] == name}
    one = system.participants[name]
    return rollback_trial(one, inputs, system.step, system.begin, changes, outputs)


def _measure_at_values(system: System, trials: dict[str, RollbackTrial]) -> None:
    """Repeat trials in which an output on a wire is 0, where relative noise shows no difference.

    Their inputs are the outputs of the other trials, like those of a first evaluation.
    """
    for name in (*trials, *trials):  # the second time against the stepping order
        outputs = {w.source[1] for w in system.wires if w.source[0] == name}
        sizes = [np.abs(value).max() for n, value in trials[name].outputs.items() if n in outputs]
        if trials[name].noise or all(sizes):
            continue
        changes = {
            w.target[1]: trials[w.source[0]].outputs[w.source[1]]
            for w in system.wires
            if w.target[0] == name
            and w.source[1] in trials.get(w.source[0], RollbackTrial()).outputs
        }
        if any(map(np.any, changes.values())):
            one = _trial(system, name, changes)
            trials[name] = one if one.outputs else trials[name]


def _is_rejected(system: System, name: str, one: RollbackTrial) -> bool:
    """Return whether a participant is treated as one without saved states."""
    return bool(one.fault) or (one.is_noisy and name not in system.trusted)


def tried(system: System, trials: Mapping[str, RollbackTrial]) -> System:
    """Return the system in which only participants that passed their trial are restored.

    If a participant of a loop is noisy, the wires of the loop get a tolerance of NOISE_MARGIN times
    that noise.
    """
    participants = {
        name: OneWayParticipant(participant)
        if name in trials and _is_rejected(system, name, trials[name])
        else participant
        for name, participant in system.participants.items()
    }
    system = replace(system, participants=participants)
    noise: dict[str, float] = {}
    for one in components(system):
        if one.is_iterated:
            noises = [trials[name].noise for name in one.names if name in trials]
            largest = max((n for n in noises if n < LARGEST_NOISE), default=0.0)
            noise |= dict.fromkeys(one.names, largest)
    return replace(
        system,
        wires=tuple(
            _raised(wire, noise[wire.source[0]], trials[wire.source[0]].sizes)
            if noise.get(wire.source[0]) and wire.tolerance < inf
            else wire
            for wire in system.wires
        ),
    )


def _raised(wire: Wire, noise: float, sizes: Mapping[str, float]) -> Wire:
    """Return a wire with a tolerance of NOISE_MARGIN times the relative noise of its loop."""
    absolute = NOISE_MARGIN * noise * sizes.get(wire.source[1], 0.0)
    return replace(
        wire,
        tolerance=max(wire.tolerance, absolute),
        relative_tolerance=max(wire.relative_tolerance, NOISE_MARGIN * noise),
        noise=noise,
    )


def trial_sentences(system: System, trials: Mapping[str, RollbackTrial]) -> list[str]:
    """Return the messages about the trials."""
    lines: list[str] = []
    for name, one in trials.items():
        if _is_rejected(system, name, one):
            how = "it is treated as an FMU without saved states"
            hint = "" if one.fault else f"; participants.{name}.rollback = true iterates it"
            lines.append(f"{name}: {one.fault or one.message}; {how}{hint}")
        elif one.noise:
            lines.append(
                f"{name}: {one.message}; its loop is iterated to {NOISE_MARGIN:g} times this"
            )
        if one.remark:
            lines.append(f"{name}: {one.remark}; its recorded values may be wrong")
    return lines


def objections(system: System, method: Method) -> dict[str, str]:
    """Return why a participant's derivative is not used, by participant; empty if it is used.

    Participants are missing if they offer no derivative or the method needs none.

    Parameters
    ----------
    system : System
        Its participants must have been started; they are left as they were.
    method : Method
    """
    if not isinstance(method, Newton) or method.differences:
        return {}
    reasons: dict[str, str] = {}
    for name in rolled_back(system):
        participant = system.participants[name]
        inputs = [w.target[1] for w in system.wires if w.target[0] == name]
        outputs = [w.source[1] for w in system.wires if w.source[0] == name]
        if participant.has_derivatives and participant.can_redo and inputs and outputs:
            reasons[name] = objection(
                participant, inputs, list(dict.fromkeys(outputs)), system.step, system.begin
            )
    return reasons


def by_differences(system: System, objected: dict[str, str]) -> System:
    """Return the system with derivatives by differences where there is an objection."""
    return replace(
        system,
        participants={
            name: Differenced(participant) if objected.get(name) else participant
            for name, participant in system.participants.items()
        },
    )


def sentences(objected: dict[str, str]) -> list[str]:
    """Return the messages about them."""
    return [
        f"{name}: uses finite differences instead of its directional derivative: {why}"
        for name, why in objected.items()
        if why
    ]
