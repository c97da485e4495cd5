"""Inputs inside a macro step, and the capabilities that a case needs of its FMUs."""

from dataclasses import replace

from ..coupling.wiring import port_of
from ..participants.interpolated import InterpolatedParticipant, slope_of
from ..participants.one_way import OneWayParticipant


def interpolating(case, participants, reals, faults):
    """Return the participants, with wrappers for interpolated inputs; append faults.

    `reals` holds the inputs of wires of real numbers.
    """
    kinds = {}
    for wire in case.wires:
        (owner, name), (target, inlet) = port_of(wire.source), port_of(wire.target)
        kind = wire.interpolation or case.coupling.inputs
        if kind == "held" or (target, inlet) not in reals:
            continue
        kinds.setdefault(target, {})[inlet] = kind
        where = f"wire {wire.source} -> {wire.target}, interpolation"
        if kind != "mean" and not participants[target].can_interpolate:
            at_end = getattr(participants[target], "reads_ends", False)
            why = ", which reads its inputs at the end of a step" if at_end else ""
            faults.append(
                f"{where}: expected an FMU with canInterpolateInputs, got "
                f"{participants[target].path.name}{why}; write mean or held"
            )
        if wire.interpolation == "hermite" and not _slope_output(participants[owner], name):
            faults.append(
                f"{where}: expected an output declared as derivative of {name}, got none in "
                f"{participants[owner].path.name}; write linear"
            )
    if faults:
        return participants
    return {
        name: InterpolatedParticipant(p, kinds[name]) if name in kinds else p
        for name, p in participants.items()
    }


def _slope_output(participant, name):
    """Return the name of the output that is the time derivative of output `name`, or None."""
    return next(
        (
            f.name
            for f in participant.fields.values()
            if f.derivative_of == name and f.causality == "output"
        ),
        None,
    )


def slopes(case, participants, wires, step):
    """Return the wires that carry the slopes of cubic inputs.

    Their tolerance is that of the value in a macro step [s].
    """
    cubic = {(wire.source, wire.target) for wire in case.wires if wire.interpolation == "hermite"}
    pieces = []
    for c in wires:
        (owner, name), (target, inlet) = c.source, c.target
        if (f"{owner}.{name}", f"{target}.{inlet}") in cubic:
            pieces.append(
                replace(
                    c,
                    source=(owner, _slope_output(participants[owner], name)),
                    target=(target, slope_of(inlet)),
                    unit=f"{c.unit}/s",
                    nominal=c.nominal / step,
                    tolerance=c.tolerance / step,
                    largest_decrease=None,
                    local_error=None,
                )
            )
    return pieces


def with_one_way(case, participants, faults):
    """Return the participants, with wrappers for those that cannot or must not be restored.

    If a local error determines the steps, these are faults.
    """
    unable = [
        name
        for name, participant in participants.items()
        if not participant.can_redo or case.participants[name].rollback is False
    ]
    faults += [
        f"participants.{name}.rollback: expected an FMU that saves its state, got "
        f"{participants[name].path.name}"
        for name in unable
        if case.participants[name].rollback
    ]
    if any(wire.local_error is not None for wire in case.wires):
        faults += [
            f"participants.{name}: expected an FMU that saves its state with local_error, got "
            f"{participants[name].path.name}; remove local_error"
            for name in unable
        ]
        return participants
    return {name: OneWayParticipant(p) if name in unable else p for name, p in participants.items()}


def check_fixed(case, participants, faults):
    """Append faults of FMUs with one step length, if a local error determines the steps."""
    if any(wire.local_error is not None for wire in case.wires):
        faults += [
            f"participants.{name}: expected an FMU with variable steps with local_error, got "
            f"{participant.path.name}; remove local_error"
            for name, participant in participants.items()
            if getattr(getattr(participant, "described", participant), "fixed", False)
        ]
