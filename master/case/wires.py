"""Wires of a case, ready for use: ends, types, shapes, units and tolerances."""

from dataclasses import replace
from math import inf

from ..coupling.wiring import HeldWire, Wire, is_unknown, port_of
from ..fmi.errors import BadInput, collecting, unknown
from ..fmi.fields import base_of
from ..fmi.quantities import are_compatible, is_known, pint_unit, registry
from ..participants.converted import Conversion, ConvertedParticipant
from ..participants.table import TYPES, TableParticipant
from .values import definition_of, is_relative, item_numbers, items_of, quantity_of

TOLERANCE = 1e-6
"""Tolerance of an unknown wire without a criterion, in nominal values."""


TUNABLE = "tunable parameter"


def field_of(port, causalities, participants, where, faults):
    """Return the field of a port with one of the causalities; append a fault if there is none."""
    owner, name = port_of(port)
    fields = participants[owner].fields
    known = [
        f.name for f in fields.values() if not {f.causality, kind_of(f)}.isdisjoint(causalities)
    ]
    field = fields[name] if name in known else None
    if field is None:
        kind = "variable" if len(causalities) > 2 else causalities[0]
        hint = "`piston-cosim fmu info` lists the variables"
        faults.append(f"{where}: {unknown(kind, port, (f'{owner}.{n}' for n in known), hint)}")
        return None
    return field


def kind_of(field):
    """Return the causality of a field, or `TUNABLE`."""
    return TUNABLE if getattr(field, "tunable", False) else field.causality


def type_of(port, participants):
    """Return the type of a port, None if it does not exist."""
    owner, name = port_of(port)
    field = participants[owner].fields.get(name)
    return None if field is None else field.type


def is_clock(port, participants):
    return type_of(port, participants) == "Clock"


def is_real(table, participants):
    """Return whether both ends of a wire exist and are real."""
    return {type_of(port, participants) for port in (table.source, table.target)} == {"Real"}


def check_sources(tables, faults):
    """Append a fault for each input with several sources."""
    sources: dict[str, list[str]] = {}
    for table in tables:
        sources.setdefault(table.target, []).append(table.source)
    faults += [
        f"wire to {target}: expected one source, got {' and '.join(several)}"
        for target, several in sources.items()
        if len(several) > 1
    ]


def check_elements(tables, participants, faults):
    """Append a fault for each element of an input array that is wired next to its array."""
    targets = {table.target for table in tables}
    for target in sorted(targets):
        owner, name = port_of(target)
        whole = participants[owner].fields.get(base_of(name))
        if base_of(target) in targets - {target} and whole is not None and whole.shape:
            faults.append(
                f"wire to {target}: expected a wire to the array or to its elements, got both"
            )


def give_types(tables, participants, faults):
    """Give each column of a signal table the type of the input on its wire, if it is a number."""
    for table in tables:
        owner, name = port_of(table.source)
        target_owner, target = port_of(table.target)
        one, kind = participants[owner], type_of(table.target, participants)
        if isinstance(one, TableParticipant) and name in one.rows and kind in TYPES:
            with collecting(faults, f"participants.{owner}.table: "):
                one.give_type(name, kind)
                check_items(participants[target_owner].fields[target], set(one.rows[name]))


def check_items(field, values):
    """Raise `BadInput` for values that are not items of a field, if it is an enumeration."""
    items = set(item_numbers(field).values())
    if items and (others := values - items):
        raise BadInput(f"expected {items_of(field)} for {field.name}, got {min(others):g}")


def _items_by_name(field):
    """Return the number of each item of an enumeration, by its name in lower case."""
    return {name.casefold(): number for name, number in item_numbers(field).items()}


def _check_item_names(source, target):
    """Raise `BadInput` if an item has different numbers at the ends of a wire."""
    source_items, taken = _items_by_name(source), _items_by_name(target)
    if any(taken.get(name, number) != number for name, number in source_items.items()):
        got = f"{items_of(source)} of {source.name}"
        raise BadInput(f"expected {items_of(target)} as for {target.name}, got {got}")


def different_items(tables, participants):
    """Return messages about wires that carry a number which has different names at their ends."""
    lines: list[str] = []
    for table in tables:
        ends = [port_of(port) for port in (table.source, table.target)]
        source, target = (participants[owner].fields[name] for owner, name in ends)
        if item_numbers(target) and _items_by_name(source).keys() - _items_by_name(target).keys():
            lines.append(
                f"wire {table.source} -> {table.target}: carries the number, whose names differ: "
                f"{items_of(source)} and {items_of(target)}"
            )
    return lines


OF_NUMBERS = (
    "tolerance",
    "relative_tolerance",
    "largest_decrease",
    "local_error",
    "conjugate",
)
"""Keys of a wire that are valid for real numbers only."""


def wire_of(table, participants, coupling, faults):
    """Return the wire of a case's table; append a fault and return None if an end is missing."""
    where = f"wire {table.source} -> {table.target}"
    source = field_of(table.source, ("output",), participants, where, faults)
    target = field_of(table.target, ("input", TUNABLE), participants, where, faults)
    if source is None or target is None:
        return None
    if source.type != target.type:
        faults.append(f"{where}: expected equal types, got {source.type} and {target.type}")
        return None
    with collecting(faults, f"{where}: "):
        check_items(target, set(item_numbers(source).values()))
        _check_item_names(source, target)
    if source.shape != target.shape:
        faults.append(
            f"{where}: expected equal shapes, got {source.shape} and {target.shape}; "
            "build both FMUs with the same grid"
        )
    if source.type == "Clock" and _clock_kind(table.target, participants) != "triggered":
        faults.append(f"{where}: expected a triggered clock, got one with an interval")
    if 0 in source.shape:
        return None  # there are no values to carry
    named = source
    conversion = None
    try:
        if source.type == "Real":
            named, conversion = common_unit(table, participants)
    except ValueError as error:
        got = f"{source.unit} and {target.unit}"
        faults.append(f"{where}: expected units of one kind, got {got}{error}")
    if _is_held(source, target):
        return _held_wire(table, source, target, where, faults)
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
        local_error=local_error,
    )
    if table.tolerance is not None or table.relative_tolerance:
        return wire
    unknown = is_unknown(wire, coupling.order, coupling.parallel)
    return replace(wire, tolerance=TOLERANCE * nominal if unknown else inf)


def _is_held(source, target):
    """Return whether a wire has no unknowns: of another type, to a parameter or clocked input."""
    return source.type != "Real" or target.causality != "input" or getattr(target, "clocked", False)


def _clock_kind(port, participants):
    """Return the kind of an input clock."""
    owner, name = port_of(port)
    participant = participants[owner]
    return getattr(participant, "described", participant).clocks[name].kind


def _held_wire(table, source, target, where, faults):
    """Return a wire of a type other than Real, or to a tunable parameter or clocked input."""
    numeric_keys = [key for key in OF_NUMBERS if getattr(table, key)]
    numeric_keys += ["interpolation"] if table.interpolation not in (None, "held") else []
    if numeric_keys:
        end = " to a clocked input" if getattr(target, "clocked", False) else ""
        end = f" to a {TUNABLE}" if kind_of(target) == TUNABLE else end
        faults.append(
            f"{where}: expected a wire of real numbers for {', '.join(numeric_keys)}, got type "
            f"{source.type}{end}"
        )
    clocked = getattr(target, "clocked", False)
    return HeldWire(port_of(table.source), port_of(table.target), clocked)


def common_unit(table, participants):
    """Return the end whose unit the wire has, and the `Conversion` to its target or None.

    That end is the source. If an FMU declares no units, it has the unit of the other end.
    """
    ports = [port_of(table.source), port_of(table.target)]
    ends = [participants[owner].fields[name] for owner, name in ports]
    declared = [end for end, (owner, _) in zip(ends, ports) if participants[owner].declares_units]
    if len(declared) < 2 and not all(map(definition_of, ends)):
        return (declared[0] if declared else ends[0]), None
    conversion = _conversion(*ends)
    return ends[0], None if conversion == (1.0, 0.0) else conversion


def conversions_of(tables, participants):
    """Return the `Conversion` of each input whose unit differs from its source's."""
    units = {port_of(table.target): common_unit(table, participants)[1] for table in tables}
    return {port: conversion for port, conversion in units.items() if conversion is not None}


def _conversion(source, target):
    """Return the conversion between the units of two fields.

    It uses the declared definitions of the units, else their names. If a field is a difference,
    there is no offset. Raises `ValueError` if they are not compatible.
    """
    first = definition_of(source)
    second = definition_of(target)
    is_difference = is_relative(source) or is_relative(target)
    if first is not None and second is not None:
        if first.exponents != second.exponents:
            raise ValueError(f"; in base units {first.base} and {second.base}")
        offset = 0.0 if is_difference else first.offset - second.offset
        return Conversion(first.factor / second.factor, offset / second.factor)
    if source.unit == target.unit:
        return Conversion(1.0, 0.0)
    if "1" in (source.unit, target.unit):
        raise ValueError("")
    if not (is_known(source.unit) and is_known(target.unit)):
        raise ValueError("; no FMU declares the conversion")
    unit = registry().Unit(pint_unit(source.unit))
    target_unit = registry().Unit(pint_unit(target.unit))
    if not are_compatible(unit, target_unit):
        raise ValueError("")
    zero, one = (registry().Quantity(value, unit).to(target_unit).magnitude for value in (0.0, 1.0))
    return Conversion(float(one - zero), 0.0 if is_difference else float(zero))


def _nominal(source, target, conversion):
    """Return the nominal value of a wire in its source's unit: the target's if it has one."""
    if target.nominal and conversion is not None:
        return target.nominal / abs(conversion.gain)
    return target.nominal or source.nominal or 1.0


def in_units_of_wires(parameters, conversions):
    """Convert start values of converted inputs from the FMU's unit to the wire's."""
    for (owner, name), conversion in conversions.items():
        if name in parameters[owner]:
            parameters[owner][name] = conversion.back(parameters[owner][name])


def converting(participants, conversions):
    """Return the participants, with wrappers for those whose inputs need conversion."""
    by_owner: dict[str, dict[str, Conversion]] = {}
    for (owner, name), conversion in conversions.items():
        by_owner.setdefault(owner, {})[name] = conversion
    return {
        name: ConvertedParticipant(p, by_owner[name]) if name in by_owner else p
        for name, p in participants.items()
    }


def _amount(text, key, nominal, named, where, faults):
    """Return a positive entry of a wire in its source's unit; None if omitted or invalid.

    A number is a multiple of the nominal value.
    """
    if text is None:
        return None
    try:
        is_share = isinstance(text, float)
        amount = text * nominal if is_share else quantity_of(text, named, is_difference=True)
    except ValueError as error:
        faults.append(f"{where}, {key}: {error}")
        return None
    if not amount > 0:
        faults.append(f"{where}, {key}: expected a positive value, got {text}")
    return amount
