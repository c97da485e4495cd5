"""From a case to participants and wires, with every fault of wiring, units, shapes and capabilities
found before the run.
"""

from dataclasses import replace
from difflib import get_close_matches
from math import inf

from ..coupling.wiring import System, Wire, is_unknown
from ..coupling.work import conjugates
from ..fmi.builder import build_fmu, build_fmu_of_file
from ..fmi.errors import BadInput
from ..fmi.quantities import to_si
from ..participants.interpolated import InterpolatedParticipant, slope_of
from ..participants.isolated import IsolatedParticipant
from ..participants.open import open_fmu
from .schema import times

TOLERANCE = 1e-6
"""Of an unknown wire without a criterion of its own, in nominal values."""


def open_system(case, folder, progress):
    """Build or open every FMU of the case and check the whole before anything runs.

    Raises
    ------
    BadInput
        With every fault that could be found: build options of all participants first, then
        parameters, wires, recorded names and time.
    """
    faults: list[str] = []
    participants = {}
    for name in case.participants:
        try:
            participants[name] = _participant(name, case.participants[name], folder, progress)
        except BadInput as error:
            faults += [f"participants.{name}: {line}" for line in error.faults]
    if faults:
        raise BadInput(faults)
    parameters = {
        name: _parameters(participants[name], case.participants[name].parameters, faults)
        for name in participants
    }
    joined = [_wire(table, participants, case.coupling, faults) for table in case.wires]
    wires = [wire for wire in joined if wire is not None]
    participants = _interpolating(case, participants, faults)
    try:
        conjugates(wires, case.wires)
    except BadInput as error:
        faults += error.faults
    _check_capabilities(participants, faults)
    _check_ports(case, participants, faults)
    clock = None
    try:
        clock = times(case, _angular_speed(case, parameters))
    except BadInput as error:
        faults += error.faults
    if faults or clock is None:
        raise BadInput(faults)
    wires += _slopes(case, participants, wires, clock.step)
    return System(
        participants,
        tuple(case.coupling.order),
        tuple(wires),
        parameters,
        clock.stop,
        clock.step,
        clock.smallest_step,
        str(folder),
        case.coupling.parallel,
    )


def _participant(name, table, folder, progress):
    participant = open_fmu(name, _fmu(table, folder, progress))
    if not table.isolated:
        return participant
    try:
        timeout = to_si(table.timeout, "s")
    except ValueError as error:
        raise BadInput(f"timeout: {error}") from None
    if not timeout > 0:
        raise BadInput(f"timeout = {table.timeout}: must be positive")
    return IsolatedParticipant(participant, timeout)


def _fmu(table, folder, progress):
    if table.package:
        return build_fmu(table.package, table.build, folder, progress)
    if table.file:
        return build_fmu_of_file(str(folder / table.file), table.build, progress)
    path = folder / table.fmu
    if not path.is_file():
        raise BadInput(f"fmu = {table.fmu!r}: no such file in {folder}")
    return path


def _parameters(participant, given, faults):
    """Parameters and input start values in SI; faults are appended."""
    values = {}
    for name, text in given.items():
        where = f"participants.{participant.name}.parameters.{name}"
        field = participant.fields.get(name)
        if field is None or field.causality not in ("parameter", "input"):
            settable = [
                f.name for f in participant.fields.values() if f.causality in ("parameter", "input")
            ]
            faults.append(f"{where}: the FMU has no such parameter or input{_near(name, settable)}")
            continue
        try:
            values[name] = _value(field, text)
        except ValueError as error:
            faults.append(f"{where}: {error}")
    return values


def _value(field, text):
    """A parameter's value in the FMU's unit and type, range checked; ValueError otherwise."""
    if field.type == "String":
        return str(text)
    if field.type == "Boolean":
        if not isinstance(text, bool):
            raise ValueError(f"{text!r} must be true or false")
        return text
    value = to_si(text, field.unit)
    low = float("-inf") if field.minimum is None else field.minimum
    high = float("inf") if field.maximum is None else field.maximum
    if not low <= value <= high:
        unit = "" if field.unit == "1" else f" {field.unit}"
        raise ValueError(f"{text} is {value:g}{unit}, allowed is {low:g} to {high:g}{unit}")
    if field.type in ("Integer", "Enumeration") and value != int(value):
        raise ValueError(f"{text} must be a whole number")
    return value if field.type == "Real" else int(value)


def _near(name, known):
    close = get_close_matches(name, known, 1)
    return f" (did you mean {close[0]}?)" if close else ""


def _field(port, causalities, participants, where, faults):
    owner, name = port.split(".")
    field = participants[owner].fields.get(name)
    known = [f.name for f in participants[owner].fields.values() if f.causality in causalities]
    if field is None or field.causality not in causalities:
        faults.append(
            f"{where}: {port} is no {' or '.join(causalities)} of the FMU{_near(name, known)}"
        )
        return None
    return field


def _wire(table, participants, coupling, faults):
    """The wire of a case's table, ready for use; None and a fault where an end is missing."""
    where = f"wire {table.source} -> {table.target}"
    source = _field(table.source, ("output",), participants, where, faults)
    target = _field(table.target, ("input",), participants, where, faults)
    if source is None or target is None:
        return None
    if source.shape != target.shape:
        faults.append(
            f"{where}: shapes differ, {source.shape} and {target.shape} "
            "(build both FMUs with the same grid)"
        )
    declared = [
        field.unit
        for field, port in ((source, table.source), (target, table.target))
        if participants[port.split(".")[0]].declares_units
    ]
    if len(set(declared)) > 1:
        faults.append(f"{where}: units differ, {source.unit} and {target.unit}")
    unit = declared[-1] if declared else "1"
    nominal = target.nominal or source.nominal or 1.0
    tolerance = _amount(table.tolerance, "tolerance", nominal, unit, where, faults)
    local_error = _amount(table.local_error, "local_error", nominal, unit, where, faults)
    wire = Wire(
        source=tuple(table.source.split(".")),
        target=tuple(table.target.split(".")),
        shape=target.shape,
        unit=unit,
        nominal=nominal,
        tolerance=0.0 if tolerance is None else tolerance,
        largest_decrease=table.largest_decrease,
        relative_tolerance=table.relative_tolerance,
        residual_relative_tolerance=table.residual_relative_tolerance,
        local_error=local_error,
    )
    if table.tolerance is not None or table.relative_tolerance or table.residual_relative_tolerance:
        return wire
    unknown = is_unknown(wire, coupling.order, coupling.parallel)
    return replace(wire, tolerance=TOLERANCE * nominal if unknown else inf)


def _amount(given, key, nominal, unit, where, faults):
    """A positive entry of a wire in SI: a number multiplies the nominal value; None if it is not
    given, or with a fault.
    """
    if given is None:
        return None
    try:
        amount = given * nominal if isinstance(given, float) else to_si(given, unit)
    except ValueError as error:
        faults.append(f"{where}: {key}: {error}")
        return None
    if not amount > 0:
        faults.append(f"{where}: {key} = {given}: must be positive")
    return amount


def _interpolating(case, participants, faults):
    """The participants, those with interpolated inputs wrapped; faults of those that cannot are
    appended.
    """
    kinds = {}
    for wire in case.wires:
        (owner, name), (target, inlet) = wire.source.split("."), wire.target.split(".")
        if wire.interpolation == "held":
            continue
        kinds.setdefault(target, {})[inlet] = wire.interpolation
        where = f"wire {wire.source} -> {wire.target}: interpolation = {wire.interpolation!r}"
        if not participants[target].can_interpolate:
            faults.append(
                f"{where}: {participants[target].path.name} cannot follow inputs over a step "
                "(canInterpolateInputs of FMI 2.0); write held, or take shorter macro steps"
            )
        if wire.interpolation == "hermite" and not _slope_output(participants[owner], name):
            faults.append(
                f"{where}: {participants[owner].path.name} declares no output as the "
                f"derivative of {name}; write linear"
            )
    return {
        name: InterpolatedParticipant(p, kinds[name]) if name in kinds else p
        for name, p in participants.items()
    }


def _slope_output(participant, name):
    """Name of the output that is the time derivative of output `name`, or None."""
    return next(
        (
            f.name
            for f in participant.fields.values()
            if f.derivative_of == name and f.causality == "output"
        ),
        None,
    )


def _slopes(case, participants, wires, step):
    """Connections that carry the slopes of cubic inputs; they may be off by a tolerance of the
    value in a macro step [s].
    """
    cubic = {(wire.source, wire.target) for wire in case.wires if wire.interpolation == "hermite"}
    slopes = []
    for c in wires:
        (owner, name), (target, inlet) = c.source, c.target
        if (f"{owner}.{name}", f"{target}.{inlet}") in cubic:
            slopes.append(
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
    return slopes


def _check_capabilities(participants, faults):
    for participant in participants.values():
        if not participant.can_redo:
            faults.append(
                f"participant {participant.name}: {participant.path.name} cannot save and restore "
                "its state, so no step can be repeated"
            )


def _check_ports(case, participants, faults):
    outputs = ("output", "input", "parameter", "local")
    for port in case.record.fields:
        _field(port, outputs, participants, "record.fields", faults)
    for table in ("summary", "monitor"):
        for name, text in getattr(case, table).items():
            _field(text.split()[1], ("output",), participants, f"{table}.{name}", faults)


def _angular_speed(case, parameters):
    """Start value [rad/s] of the input that turns angles into times; None if the case is in
    times.
    """
    if case.time.angular_speed is None:
        return None
    owner, name = case.time.angular_speed.split(".")
    if name not in parameters[owner]:
        raise BadInput(
            f"time.angular_speed = {case.time.angular_speed}: give it a value in "
            f"participants.{owner}.parameters"
        )
    return parameters[owner][name]
