"""Values of parameters: texts with units to numbers of an FMU, with the key of each fault."""

from dataclasses import replace
from math import inf, isclose

import numpy as np

from ..fmi.errors import names_of, unknown
from ..fmi.quantities import angle_power, is_known, pint_unit, to_si
from .keys import SETTABLE

ROUND_OFF = 1e-14
"""Relative error of a conversion of units."""


def parameter_values(participant, texts, faults):
    """Return parameters and input start values in SI; append faults."""
    values = {}
    for name, text in texts.items():
        where = f"participants.{participant.name}.parameters.{name}"
        field = participant.fields.get(name)
        if field is None or not is_settable(field):
            settable = [f.name for f in participant.fields.values() if is_settable(f)]
            faults.append(f"{where}: {unknown('parameter or input', name, settable)}")
            continue
        try:
            values[name] = _array(field, text) if isinstance(text, list) else value_of(field, text)
        except ValueError as error:
            faults.append(f"{where}: {error}")
    return values


def is_settable(field):
    """Return whether a case can set a variable: a parameter, an input or another start value."""
    return field.causality in SETTABLE or getattr(field, "has_start", False)


def _array(field, rows):
    """Return an array of values, each by `value_of`."""
    array = np.array(rows, dtype=object)
    if not field.shape:
        raise ValueError(f"expected one value, got a list of {len(rows)}")
    if array.shape != field.shape:
        raise ValueError(f"expected shape {field.shape}, got {array.shape}")
    return np.array([value_of(field, text) for text in array.ravel()]).reshape(field.shape)


def value_of(field, text):
    """Return a parameter's value in the FMU's unit and type; raise `ValueError` if out of range."""
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
        return item_numbers(field)[text]
    if field.type == "Enumeration" and field.choices and text not in item_numbers(field).values():
        raise ValueError(f"expected {items_of(field)}, got {text!r}")
    is_whole = type(text) is int and field.type != "Real" and field.unit == "1"
    value = text if is_whole else quantity_of(text, field)  # 2^53 + 1 is not exact as a float
    fits = getattr(field, "whole_numbers", None) or (-inf, inf)
    low = fits[0] if field.minimum is None else max(fits[0], field.minimum)
    high = fits[1] if field.maximum is None else min(fits[1], field.maximum)
    for end in () if is_whole else (low, high):
        value = end if isclose(value, end, rel_tol=ROUND_OFF) else value
    if not low <= value <= high:
        unit = "" if field.unit == "1" else f" {field.unit}"
        ends = " to ".join(str(end) if isinstance(end, int) else f"{end:g}" for end in (low, high))
        raise ValueError(f"expected {ends}{unit}, got {text}")
    if field.type in ("Integer", "Enumeration") and value != int(value):
        raise ValueError(f"expected a whole number, got {text}")
    return value if field.type == "Real" else int(value)


def item_numbers(field):
    """Return the number of each item of an enumeration; models of this tool count from 1."""
    items = getattr(field, "choices", {})
    return items if isinstance(items, dict) else {name: k for k, name in enumerate(items, 1)}


def items_of(field):
    """Return the items of an enumeration as the expected part of a sentence."""
    return names_of(f"{name!r} ({value})" for name, value in item_numbers(field).items())


def quantity_of(text, field, is_difference=False):
    """Convert a value to the FMU's unit, by the declared definition or by the unit's name.

    Differences, also those that the FMU declares with relativeQuantity, have no offset.
    """
    definition = definition_of(field)
    is_difference = is_difference or is_relative(field)
    if definition is None or (definition.factor == 1.0 and definition.offset == 0.0):
        return to_si(text, field.unit, is_difference)
    if is_difference:
        definition = replace(definition, offset=0.0)
    base = definition.base
    omitted = "rad" not in dict(definition.exponents) and is_known(field.unit)
    if omitted and (power := angle_power(pint_unit(field.unit))):
        base += f".rad{power:g}"  # FMI allows to omit the angle
    if base == "1":  # in percent, because a bare number is ambiguous
        definition, base = replace(definition, factor=100.0 * definition.factor), "%"
    try:
        return definition.from_base(to_si(text, base, is_difference))
    except ValueError as error:
        raise ValueError(f"{error}; the unit of the FMU is {field.unit}") from None


def is_relative(field):
    """Return whether the values of a field are differences; False for other participants."""
    return getattr(field, "relative", False)


def definition_of(field):
    """Return the declared definition of a field's unit; None for other participants."""
    return getattr(field, "definition", None)
