"""From a case to participants and wires, with every fault of wiring, units, shapes and capabilities
found before the run.
"""

from dataclasses import dataclass, replace
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from ..coupling.wiring import HeldWire, System, Wire, is_unknown, port_of
from ..coupling.work import conjugates
from ..fmi.errors import BadInput, file_fault, unknown
from ..fmi.fields import NO_NUMBERS, base_of
from ..fmi.quantities import duration, is_known, pint_unit, registry, to_si
from ..participants.clones import ClonedParticipant
from ..participants.converted import Conversion, ConvertedParticipant
from ..participants.interpolated import InterpolatedParticipant, slope_of
from ..participants.isolated import IsolatedParticipant
from ..participants.one_way import OneWayParticipant
from ..participants.open import open_fmu
from ..participants.plugins import made, plugin
from ..participants.remote import RemoteParticipant
from ..participants.substeps import Substeps
from ..participants.table import TableParticipant
from .contract import starting_order
from .given import build_options, masks
from .keys import SETTABLE, declared_variables
from .machine_code import of_machine_code
from .schema import record_interval, reduced, start_time, times

TOLERANCE = 1e-6
"""Of an unknown wire without a criterion of its own, in nominal values."""


@dataclass(frozen=True)
class Declared:
    """A participant before its FMU is built, by what its part declares."""

    name: str
    path: Path
    fields: dict[str, Any]
    declares_units: bool = True


def faults_ahead(case, folder):
    """Every fault of a case that shows before anything is built: build options, parameters, wires,
    recorded and drawn names of participants whose parts declare their variables; time.

    Parameters
    ----------
    case : Case
    folder : Path
        Of the case.

    Returns
    -------
    list of str
    """
    faults: list[str] = []
    declared = declared_participants(case, folder, faults)
    parameters = parameters_ahead(case, declared, faults)
    _check_sources(case.wires, faults)
    for table in case.wires:
        if {port_of(table.source)[0], port_of(table.target)[0]} <= declared.keys():
            _wire(table, declared, case.coupling, faults)
    for name, table in case.participants.items():
        if not table.host and (fault := _missing_file(table, folder)):
            faults.append(f"participants.{name}.{fault}")
    faults += of_machine_code(case, folder, parameters)[1]
    if declared.keys() == case.participants.keys():
        _check_ports(case, declared, faults)
        _check_time(case, parameters, faults)
    return faults


def run_ahead(case, folder):
    """Clock of the run and its wires of real numbers, as far as they show before anything is built:
    (None, wires) where a participant that turns angles into times is no part that declares its
    variables.
    """
    unheard = []
    declared = declared_participants(case, folder, unheard)
    parameters = parameters_ahead(case, declared, unheard)
    joined = [
        _wire(table, declared, case.coupling, unheard)
        for table in case.wires
        if {port_of(table.source)[0], port_of(table.target)[0]} <= declared.keys()
    ]
    wires = [wire for wire in joined if isinstance(wire, Wire)]
    turning = case.time.angular_speed
    if turning and port_of(turning)[0] not in declared:
        return None, wires
    clock, _ = _check_time(case, parameters, unheard)
    return clock, wires


def declared_participants(case, folder, faults):
    """Participants whose parts declare their variables, by name; faults of their build options
    are appended.
    """
    declared = {}
    for name, table in case.participants.items():
        try:
            variables = declared_variables(table, folder)
        except BadInput as error:
            faults += [f"participants.{name}.{line}" for line in error.faults]
            continue
        if variables is not None:
            fields = {one.name: _as_fmu(one) for one in variables}
            declared[name] = Declared(name, Path(table.package), fields)
    return declared


def parameters_ahead(case, declared, faults):
    """What the case gives declared participants, in SI, by their names; faults are appended."""
    return {
        name: _parameters(participant, case.participants[name].parameters, faults)
        for name, participant in declared.items()
    }


def _as_fmu(variable):
    """A declared variable as an FMU has it: the choices of an enumeration by their numbers."""
    numbers: Any = {text: k for k, text in enumerate(variable.choices, 1)}
    return replace(variable, choices=numbers)


def _check_time(case, parameters, faults):
    """Clock and beginning of the run [s]; None and 0 with a fault."""
    if case.time.angular_speed:
        owner, name = port_of(case.time.angular_speed)
        given = case.participants[owner].parameters
        if name in given and name not in parameters[owner]:
            return None, 0.0  # its value is a fault, told already
    try:
        speed = _angular_speed(case, parameters)
        record_interval(case, speed)
        return times(case, speed), start_time(case, speed)
    except BadInput as error:
        faults += error.faults
        return None, 0.0


def open_system(case, folder, progress, own=None):
    """Build or open every FMU of the case and check the whole before anything runs; `own` holds
    makers of participants that exist in this Python alone, by name.

    Raises
    ------
    BadInput
        With every fault that could be found: what shows before anything is built first, then
        build options of all participants, then parameters, wires, recorded names and time.
    """
    faults = faults_ahead(case, folder)
    if faults:
        raise BadInput(faults)
    participants = {}
    native = _of_machine_code(case, folder)
    if case.native:
        from ..fmi.builder_native import compile_ahead

        compile_ahead([case.participants[name].package for name in sorted(native)], progress)
    builds = build_options(case, folder, progress)
    for name in case.participants:
        try:
            make = (own or {}).get(name)
            participants[name] = (
                make()
                if make
                else _participant(name, case, builds[name], folder, progress, name in native)
            )
        except BadInput as error:
            faults += [f"participants.{name}.{line}" for line in error.faults]
    if faults:
        raise BadInput(faults)
    parameters = {
        name: _parameters(participants[name], case.participants[name].parameters, faults)
        for name in participants
    }
    _check_sources(case.wires, faults)
    _check_elements(case.wires, participants, faults)
    opened = participants
    joined = [_wire(table, participants, case.coupling, faults) for table in case.wires]
    wires = [wire for wire in joined if isinstance(wire, Wire)]
    reals = [table for table in case.wires if _is_real(table, participants)]
    of_clocks = {port_of(t.target) for t in case.wires if _is_clock(t.target, participants)}
    handed = [wire for wire in joined if isinstance(wire, HeldWire)]
    held = [wire for wire in handed if wire.target not in of_clocks]
    conversions = {} if faults else _conversions(reals, participants)
    _in_units_of_wires(parameters, conversions)
    participants = _able(case, _converting(participants, conversions), faults)
    participants = _interpolating(case, participants, {wire.target for wire in wires}, faults)
    try:
        conjugates(wires, case.wires)
    except BadInput as error:
        faults += error.faults
    _check_fixed(case, participants, faults)
    _check_ports(case, participants, faults)
    outside = [("observers", name) for name in case.observers]
    if case.coupling.step_control:
        outside.append(("step_controls", case.coupling.step_control))
    for kind, name in outside:
        try:
            plugin(kind, name)
        except BadInput as error:
            faults += error.faults
    clock, begin = _check_time(case, parameters, faults)
    if faults or clock is None:
        raise BadInput(faults)
    participants = _as_they_start(participants, wires, progress)
    wires += _slopes(case, participants, wires, clock.step)
    for participant in opened.values():
        described = getattr(participant, "described", participant)
        if isinstance(described, Substeps) and described.length is None:
            described.length = clock.step
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
        tuple(held),
        begin,
        clock.period,
        clock.earliest,
        masks(case, builds, folder),
        tuple(wire for wire in handed if wire.target in of_clocks),
        record_interval(case, _angular_speed(case, parameters)),
    )


def _as_they_start(participants, wires, progress):
    """Participants in the order in which they start; says which one does not start where the case
    names it.
    """
    order = starting_order(participants, wires)
    late = [name for name, told in zip(participants, order) if name != told]
    if late:
        progress(f"participants start in the order {', '.join(order)}: films after their bodies")
    return {name: participants[name] for name in order}


def _type(port, participants):
    """Type of a port; None of one that there is not."""
    owner, name = port_of(port)
    field = participants[owner].fields.get(name)
    return None if field is None else field.type


def _is_clock(port, participants):
    return _type(port, participants) == "Clock"


def _is_real(table, participants):
    """Whether both ends of a wire are there and real."""
    return {_type(port, participants) for port in (table.source, table.target)} == {"Real"}


def _of_machine_code(case, folder):
    """Names of the participants that are built as machine code."""
    unheard = []
    declared = declared_participants(case, folder, unheard)
    return of_machine_code(case, folder, parameters_ahead(case, declared, unheard))[0]


def _participant(name, case, build, folder, progress, native):
    table = case.participants[name]
    if table.plugin:
        return made("participants", table.plugin, name, table.build, folder)
    if table.table:
        return TableParticipant(name, folder / table.table, table.interpolation or "linear")
    path = _fmu(table, build, folder, progress, native)
    elements = case.elements_of(name)
    how = {"step": _own_step(table), "elements": elements, "event_mode": table.event_mode}
    open_with = partial(open_fmu, name, path, **how)
    participant = open_with()
    if sizes := _sizes(participant, table.parameters):
        participant = open_with(sizes)
    timeout = duration("timeout", table.timeout)
    if table.host:
        return RemoteParticipant(participant, timeout, table.host)
    if not table.isolated:
        return participant
    apart = IsolatedParticipant(participant, timeout)
    if not table.clones:
        return apart
    if not (apart.can_redo and apart.can_serialise):
        raise BadInput(f"clones: expected an FMU that saves its state, got {path.name}")
    return ClonedParticipant(
        apart, [IsolatedParticipant(participant, timeout) for _ in range(table.clones)]
    )


def _own_step(table):
    """Step [s] that a participant takes inside a macro step, or None."""
    return None if table.step is None else duration("step", table.step)


def _sizes(participant, given):
    """Values of the structural parameters that the case gives."""
    faults, sizes = [], {}
    for name, text in given.items():
        field = participant.fields.get(name)
        if field is not None and field.causality == "structuralParameter":
            try:
                sizes[name] = _value(field, text)
            except ValueError as error:
                faults.append(f"parameters.{name}: {error}")
    if faults:
        raise BadInput(faults)
    return sizes


def _fmu(table, build, folder, progress, native):
    """Return the path of a participant's FMU, built where the case asks for it."""
    if table.package or table.file:
        return _built(table, build, folder, progress, native)
    if fault := _missing_file(table, folder):
        raise BadInput(fault)
    return folder / table.fmu


def _missing_file(table, folder):
    """Return what is wrong with the path of a participant's FMU or table; "" if nothing is."""
    key = "fmu" if table.fmu else "table"
    name = getattr(table, key)
    try:
        if not name or (folder / name).is_file():
            return ""
        (folder / name).open().close()
    except (OSError, ValueError) as error:
        return f"{key}: {file_fault(name[:80], error)}"
    return f"{key}: expected a file, got {name!r}"


def _built(table, build, folder, progress, native):
    """Build the FMU of a package or of a file; what builds is slow to import."""
    from ..fmi.builder import build_fmu, build_fmu_of_file
    from ..fmi.builder_native import build_native_fmu, this_platform

    if table.package and native:
        here = [name for name in [this_platform()] if name]
        return build_native_fmu(table.package, build, folder, progress, platforms=here)
    if table.package:
        return build_fmu(table.package, build, folder, progress)
    return build_fmu_of_file(str(folder / table.file), build, progress)


def _parameters(participant, given, faults):
    """Parameters and input start values in SI; faults are appended."""
    values = {}
    for name, text in given.items():
        where = f"participants.{participant.name}.parameters.{name}"
        field = participant.fields.get(name)
        if field is None or field.causality not in SETTABLE:
            settable = [f.name for f in participant.fields.values() if f.causality in SETTABLE]
            faults.append(f"{where}: {unknown('parameter or input', name, settable)}")
            continue
        try:
            values[name] = _array(field, text) if isinstance(text, list) else _value(field, text)
        except ValueError as error:
            faults.append(f"{where}: {error}")
    return values


def _array(field, rows):
    """An array of values, each as `_value` says."""
    array = np.array(rows, dtype=object)
    if array.shape != field.shape:
        raise ValueError(f"expected shape {field.shape}, got {array.shape}")
    return np.array([_value(field, text) for text in array.ravel()]).reshape(field.shape)


def _value(field, text):
    """A parameter's value in the FMU's unit and type, range checked; ValueError otherwise."""
    if field.type == "Clock":
        raise ValueError(f"expected no value for a clock, got {text!r}")
    if field.type == "String":
        return str(text)
    if field.type == "Binary":
        try:
            return bytes.fromhex(str(text))
        except ValueError:
            raise ValueError(f"expected hexadecimal digits, got {text!r}") from None
    if field.type == "Boolean":
        if not isinstance(text, bool):
            raise ValueError(f"expected true or false, got {text!r}")
        return text
    if field.type == "Enumeration" and isinstance(text, str):
        if text not in field.choices:
            raise ValueError(unknown("choice", text, field.choices))
        return field.choices[text]
    is_whole = isinstance(text, int) and field.type != "Real" and field.unit == "1"
    value = text if is_whole else _quantity(text, field)  # 2^53 + 1 is no float
    fits = getattr(field, "whole_numbers", None) or (-inf, inf)
    low = fits[0] if field.minimum is None else max(fits[0], field.minimum)
    high = fits[1] if field.maximum is None else min(fits[1], field.maximum)
    if not low <= value <= high:
        unit = "" if field.unit == "1" else f" {field.unit}"
        ends = " to ".join(str(end) if isinstance(end, int) else f"{end:g}" for end in (low, high))
        raise ValueError(f"expected {ends}{unit}, got {text}")
    if field.type in ("Integer", "Enumeration") and value != int(value):
        raise ValueError(f"expected a whole number, got {text}")
    return value if field.type == "Real" else int(value)


def _quantity(text, field):
    """A value in the FMU's unit: by what the FMU declares of a unit of its own, else by the unit's
    name.
    """
    definition = _definition(field)
    if definition is None or (definition.factor == 1.0 and definition.offset == 0.0):
        return to_si(text, field.unit)
    try:
        return definition.from_base(to_si(text, definition.base))
    except ValueError as error:
        raise ValueError(f"{error}; the unit of the FMU is {field.unit}") from None


def _field(port, causalities, participants, where, faults):
    owner, name = port_of(port)
    field = participants[owner].fields.get(name)
    known = [f.name for f in participants[owner].fields.values() if f.causality in causalities]
    if field is None or field.causality not in causalities:
        kind = "variable" if len(causalities) > 1 else causalities[0]
        hint = "`piston-cosim fmu info` lists the variables"
        faults.append(f"{where}: {unknown(kind, port, (f'{owner}.{n}' for n in known), hint)}")
        return None
    return field


def _check_sources(tables, faults):
    """One input has one source."""
    sources: dict[str, list[str]] = {}
    for table in tables:
        sources.setdefault(table.target, []).append(table.source)
    faults += [
        f"wire to {target}: expected one source, got {' and '.join(several)}"
        for target, several in sources.items()
        if len(several) > 1
    ]


def _check_elements(tables, participants, faults):
    """Append a fault for each element of an input array that is wired next to its array."""
    targets = {table.target for table in tables}
    for target in sorted(targets):
        owner, name = port_of(target)
        whole = participants[owner].fields.get(base_of(name))
        if base_of(target) in targets - {target} and whole is not None and whole.shape:
            faults.append(
                f"wire to {target}: expected a wire to the array or to its elements, got both"
            )


OF_NUMBERS = (
    "tolerance",
    "relative_tolerance",
    "residual_relative_tolerance",
    "largest_decrease",
    "local_error",
    "conjugate",
)
"""What a wire's table may say of real numbers alone."""


def _wire(table, participants, coupling, faults):
    """The wire of a case's table, ready for use; None and a fault where an end is missing."""
    where = f"wire {table.source} -> {table.target}"
    source = _field(table.source, ("output",), participants, where, faults)
    target = _field(table.target, ("input",), participants, where, faults)
    if source is None or target is None:
        return None
    if source.type != target.type:
        faults.append(f"{where}: expected equal types, got {source.type} and {target.type}")
        return None
    if source.shape != target.shape:
        faults.append(
            f"{where}: expected equal shapes, got {source.shape} and {target.shape}; "
            "build both FMUs with the same grid"
        )
    if source.type == "Clock" and _clock_kind(table.target, participants) != "triggered":
        faults.append(f"{where}: expected a triggered clock, got one with an interval of its own")
    if source.type != "Real" or getattr(target, "clocked", False):
        return _held_wire(table, source, target, where, faults)
    named = source
    conversion = None
    try:
        named, conversion = _common_unit(table, participants)
    except ValueError as error:
        got = f"{source.unit} and {target.unit}"
        faults.append(f"{where}: expected units of one kind, got {got}{error}")
    nominal = _nominal(source, target, conversion)
    tolerance = _amount(table.tolerance, "tolerance", nominal, named, where, faults)
    local_error = _amount(table.local_error, "local_error", nominal, named, where, faults)
    wire = Wire(
        source=port_of(table.source),
        target=port_of(table.target),
        shape=target.shape,
        unit=named.unit,
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


def _clock_kind(port, participants):
    """What kind of clock an input is."""
    owner, name = port_of(port)
    participant = participants[owner]
    return getattr(participant, "described", participant).clocks[name].kind


def _held_wire(table, source, target, where, faults):
    """A wire of integers, booleans, enumerations, texts, bytes or clocks, or to a clocked input."""
    said = [key for key in OF_NUMBERS if getattr(table, key)]
    said += ["interpolation"] if table.interpolation not in (None, "held") else []
    if said:
        faults.append(
            f"{where}: expected a wire of real numbers for {', '.join(said)}, got type "
            f"{source.type}{' to a clocked input' if getattr(target, 'clocked', False) else ''}"
        )
    return HeldWire(port_of(table.source), port_of(table.target))


def _common_unit(table, participants):
    """The end whose unit the wire has, and the `Conversion` to its target or None. That is its
    source; but an FMU that names no unit at all is taken to have the other's.
    """
    ports = [port_of(table.source), port_of(table.target)]
    ends = [participants[owner].fields[name] for owner, name in ports]
    declared = [end for end, (owner, _) in zip(ends, ports) if participants[owner].declares_units]
    if len(declared) < 2:
        return (declared[0] if declared else ends[0]), None
    conversion = _conversion(*ends)
    return ends[0], None if conversion == (1.0, 0.0) else conversion


def _conversions(tables, participants):
    """Input -> `Conversion`, of the wires whose ends differ in unit."""
    units = {port_of(table.target): _common_unit(table, participants)[1] for table in tables}
    return {port: conversion for port, conversion in units.items() if conversion is not None}


def _definition(field):
    """What an FMU declares of a field's unit; a participant that is none declares nothing."""
    return getattr(field, "definition", None)


def _conversion(source, target):
    """From a field's unit to another's, by what both FMUs declare of their units, else by the
    units' names; ValueError where it cannot be.
    """
    first = _definition(source)
    second = _definition(target)
    if first is not None and second is not None:
        if first.exponents != second.exponents:
            raise ValueError(f"; in base units {first.base} and {second.base}")
        return Conversion(
            first.factor / second.factor, (first.offset - second.offset) / second.factor
        )
    if source.unit == target.unit:
        return Conversion(1.0, 0.0)
    if "1" in (source.unit, target.unit):
        raise ValueError("")
    if not (is_known(source.unit) and is_known(target.unit)):
        raise ValueError("; neither FMU says how to convert")
    unit = registry().Unit(pint_unit(source.unit))
    wanted = registry().Unit(pint_unit(target.unit))
    if not unit.is_compatible_with(wanted):
        raise ValueError("")
    zero, one = (registry().Quantity(value, unit).to(wanted).magnitude for value in (0.0, 1.0))
    return Conversion(float(one - zero), float(zero))


def _nominal(source, target, conversion):
    """Nominal value of a wire in its source's unit, that of its target if it has one."""
    if target.nominal and conversion is not None:
        return target.nominal / abs(conversion.gain)
    return target.nominal or source.nominal or 1.0


def _in_units_of_wires(parameters, conversions):
    """Start values of converted inputs are given in the FMU's unit and set in the wire's."""
    for (owner, name), conversion in conversions.items():
        if name in parameters[owner]:
            parameters[owner][name] = conversion.back(parameters[owner][name])


def _converting(participants, conversions):
    """The participants, those with inputs in another unit than their wires' wrapped."""
    by_owner: dict[str, dict[str, Conversion]] = {}
    for (owner, name), conversion in conversions.items():
        by_owner.setdefault(owner, {})[name] = conversion
    return {
        name: ConvertedParticipant(p, by_owner[name]) if name in by_owner else p
        for name, p in participants.items()
    }


def _amount(given, key, nominal, named, where, faults):
    """A positive entry of a wire in its unit, that of its source: a number multiplies the nominal
    value; None if it is not given, or with a fault.
    """
    if given is None:
        return None
    try:
        amount = given * nominal if isinstance(given, float) else _difference(given, named)
    except ValueError as error:
        faults.append(f"{where}, {key}: {error}")
        return None
    if not amount > 0:
        faults.append(f"{where}, {key}: expected a positive value, got {given}")
    return amount


def _difference(given, named):
    """A difference of values in a field's unit: an offset of the unit has no part in it."""
    if _definition(named) is None:
        return to_si(given, named.unit)
    return _quantity(given, replace(named, definition=replace(named.definition, offset=0.0)))


def _interpolating(case, participants, reals, faults):
    """The participants, those with interpolated inputs wrapped; faults of those that cannot are
    appended. `reals` holds the inputs of wires of real numbers.
    """
    kinds = {}
    for wire in case.wires:
        (owner, name), (target, inlet) = port_of(wire.source), port_of(wire.target)
        kind = wire.interpolation or case.coupling.inputs
        if kind == "held" or (target, inlet) not in reals:
            continue
        kinds.setdefault(target, {})[inlet] = kind
        where = f"wire {wire.source} -> {wire.target}, interpolation"
        if case.participants[target].clones:
            faults.append(
                f"{where}: expected held inputs for a participant with clones, got {kind!r}"
            )
        if kind != "mean" and not participants[target].can_interpolate:
            faults.append(
                f"{where}: expected an FMU with canInterpolateInputs, got "
                f"{participants[target].path.name}; write mean or held"
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
    """Wires that carry the slopes of cubic inputs; they may be off by a tolerance of the
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


def _able(case, participants, faults):
    """The participants, those that cannot go back wrapped; a fault where the length of all steps
    follows from a local error.
    """
    unable = [name for name, participant in participants.items() if not participant.can_redo]
    if any(wire.local_error is not None for wire in case.wires):
        faults += [
            f"participants.{name}: expected an FMU that saves its state with local_error, got "
            f"{participants[name].path.name}; remove local_error"
            for name in unable
        ]
        return participants
    return {name: OneWayParticipant(p) if name in unable else p for name, p in participants.items()}


def _check_fixed(case, participants, faults):
    """Where steps are as long as the local error says, an FMU of one step length cannot follow."""
    if any(wire.local_error is not None for wire in case.wires):
        faults += [
            f"participants.{name}: expected an FMU with variable steps with local_error, got "
            f"{participant.path.name}; remove local_error"
            for name, participant in participants.items()
            if _is_fixed(participant)
        ]


def _is_fixed(participant):
    """Whether a participant takes steps of one length alone."""
    return getattr(getattr(participant, "described", participant), "fixed", False)


def _check_ports(case, participants, faults):
    outputs = ("output", "input", "parameter", "local")
    for port in case.record.fields:
        field = _field(port, outputs, participants, "record.fields", faults)
        if field is not None and field.type in NO_NUMBERS:
            faults.append(f"record.fields: expected numbers, got {port} of type {field.type}")
    for where, port in _curves(case):
        field = _field(port, ("output",), participants, where, faults)
        if field is not None and (field.shape or field.type in NO_NUMBERS):
            shape = f"an array of shape {field.shape}" if field.shape else f"a {field.type}"
            faults.append(f"{where}: expected a scalar number, got {port}, {shape}")
    for picture in case.pictures:
        for port in picture.fields:
            _field(port, ("output",), participants, f"pictures.{picture.file}", faults)


def _curves(case):
    """(where, port) of every scalar output that summaries, pictures and reports are made of."""
    for table in ("summary", "monitor"):
        for name, text in getattr(case, table).items():
            yield f"{table}.{name}", reduced(text).port
    for text in case.window:
        yield f"window.{text}", reduced(text).port
    for picture in case.pictures:
        for port in picture.outputs:
            yield f"pictures.{picture.file}", port
    for name, loop in case.report.loops.items():
        for port in (loop.x, *loop.y):
            yield f"report.loops.{name}", port
    for name, study in case.studies.items():
        for port in filter(None, (study.x, *study.curves)):
            yield f"studies.{name}", port


def _angular_speed(case, parameters):
    """Start value [rad/s] of the input that turns angles into times; None if the case is in
    times.
    """
    if case.time.angular_speed is None:
        return None
    owner, name = port_of(case.time.angular_speed)
    if name not in parameters[owner]:
        raise BadInput(
            f"time.angular_speed: expected a parameter with a value, got "
            f"{case.time.angular_speed!r}; set it in participants.{owner}.parameters"
        )
    return parameters[owner][name]
