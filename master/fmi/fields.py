"""Fields of an imported FMU: scalars `name[i,j]` gathered into arrays."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

LARGEST_EXTENT = 2**31
BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
ELEMENT = re.compile(r"^(?P<base>.+)\[(?P<index>\d+(,\d+)*)\]$")
TYPES_3 = {
    "Float64": "Real",
    "Float32": "Real",
    **{f"{sign}{bits}": "Integer" for sign in ("Int", "UInt") for bits in (8, 16, 32, 64)},
    "Enumeration": "Enumeration",
    "Boolean": "Boolean",
    "String": "String",
    "Binary": "Binary",
    "Clock": "Clock",
}
"""FMI 2 types of FMI 3 types. Binary and Clock have no FMI 2 type."""
VENDOR = "piston-cosim"
"""Tool name of the VendorAnnotations with the reserved references of derivatives."""
WHOLE = re.compile(r"[-+]?\d+")
STARTS = {
    "Real": re.compile(r"[-+]?(?:(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|INF|inf)|NaN|nan"),
    "Integer": WHOLE,
    "Enumeration": WHOLE,
    "Boolean": re.compile("true|false|0|1"),
}
"""Start values of XML by type, each a list of words for arrays."""
NO_NUMBERS = ("String", "Binary", "Clock")
"""Types that cannot be recorded as numbers."""


@dataclass(frozen=True)
class UnitDefinition:
    """Unit as an FMU declares it, in SI base units.

    Eq. (P4):  (value in base units) = factor (value in the unit) + offset

    exponents : pairs of base unit and exponent, without zeros.
    """

    exponents: tuple[tuple[str, int], ...]
    factor: float
    offset: float

    @property
    def base(self) -> str:
        """Base unit as FMI writes it ("kg.m-1.s-2", "1")."""
        return ".".join(f"{unit}{power}" for unit, power in self.exponents) or "1"

    def from_base(self, value: float) -> float:
        """Convert a value from base units to the unit."""
        return (value - self.offset) / self.factor  # Eq. (P4)


Units = dict[str, UnitDefinition | None]
"""Definitions by the name of the unit."""


@dataclass(frozen=True)
class Field:
    """Array (or scalar, shape ()) variable of an FMU.

    `references` are the value references. FMI 2 has one for each element in C order of `shape`,
    FMI 3 has one for the array. `unit`, `nominal`, `minimum`, `maximum` and `start` are those of
    the first element ("1" and None if the FMU declares none). `derivative_of` names the field
    whose time derivative this is. `definition` is the declared unit. `choices` are the items of
    an enumeration, name to value. `native` is the FMI 3 type. `clocked` means that the value
    changes only at clock ticks. `tunable` parameters may change between steps. `has_start` means
    that a start value may be set before the initialization. `relative` values are differences,
    which have no offset ("5 degC" is 5 K).
    """

    name: str
    shape: tuple[int, ...]
    references: tuple[int, ...]
    type: str
    causality: str
    unit: str
    nominal: float | None
    minimum: float | None
    maximum: float | None
    start: str | None
    description: str
    derivative_of: str | None = None
    definition: UnitDefinition | None = None
    choices: dict[str, int] = field(default_factory=dict[str, int])
    native: str | None = None
    clocked: bool = False
    tunable: bool = False
    has_start: bool = False
    relative: bool = False

    @cached_property
    def size(self) -> int:
        return int(np.prod(self.shape))

    @property
    def whole_numbers(self) -> tuple[int, int] | None:
        """Smallest and largest integer of its type; None for other types."""
        if self.type not in ("Integer", "Enumeration"):
            return None
        kind = {None: "Int32", "Enumeration": "Int64"}.get(self.native, self.native)
        bits = int(re.sub(r"\D", "", str(kind)))
        half = 2 ** (bits - 1)
        return (0, 2 * half - 1) if str(kind).startswith("U") else (-half, half - 1)

    @property
    def is_double(self) -> bool:
        """True if its values are 64-bit floats, which are passed by pointer."""
        return self.type == "Real" and self.native != "Float32"


def gather_fields(
    description: Any, sizes: Mapping[str, int] | None = None, elements: Collection[str] = ()
) -> dict[str, Field]:
    """Return the fields of an FMPy model description.

    FMI 2.0 has no arrays. Variables `name[i,j]` become one array `name` if they fill a rectangle
    that begins at 0 or 1, and have the same type, causality and unit. All others stay scalars.

    Parameters
    ----------
    description : fmpy.model_description.ModelDescription
    sizes : dict of str to int, optional
        Values of structural parameters, which set the size of arrays in FMI 3.0. Default: start
        values.
    elements : iterable of str, optional
        Elements of arrays ("name[2]") that become scalar fields too, next to their array.

    Returns
    -------
    dict of str to Field
        In the order of first appearance.

    Raises
    ------
    ValueError
        With names that occur twice, or the first invalid unit, dimension or enumeration.
    """
    _check_names(description.modelVariables)
    units = {unit.name: _definition(unit.baseUnit) for unit in description.unitDefinitions}
    if description.fmiVersion.startswith("3"):
        events = bool(description.coSimulation and description.coSimulation.hasEventMode)
        return {
            v.name: _array(v, units, sizes or {}, events)
            for v in description.modelVariables
            if v.type in TYPES_3 and (events or v.type != "Clock")
        }
    groups: dict[str, list[tuple[tuple[int, ...], Any]]] = {}
    for variable in description.modelVariables:
        match = ELEMENT.match(variable.name)
        base, index = (
            (match["base"], tuple(map(int, match["index"].split(","))))
            if match
            else (variable.name, ())
        )
        groups.setdefault(base, []).append((index, variable))
    fields: dict[str, Field] = {}
    for base, members in groups.items():
        members.sort(key=lambda member: member[0])
        variables = [variable for _, variable in members]
        shape = _shape([index for index, _ in members], variables)
        if shape is not None:
            fields[base] = _described(base, shape, variables, variables[0].type, units)
        singled = {v.name: v for v in variables if shape is None or v.name in elements}
        fields |= {name: _described(name, (), [v], v.type, units) for name, v in singled.items()}
    return fields


def _check_names(variables: Sequence[Any]) -> None:
    """Raise `ValueError` with all names that several variables have, and their lines."""
    lines: dict[str, list[str]] = {}
    for variable in variables:
        lines.setdefault(variable.name, []).append(str(variable.sourceline))
    twice = [f"{n!r} in lines {' and '.join(rows)}" for n, rows in lines.items() if len(rows) > 1]
    if twice:
        raise ValueError(f"expected variables with different names, got {', '.join(twice)}")


def base_of(name: str) -> str:
    """Return the array's name of an element "name[i,j]"; the name itself of any other variable."""
    match = ELEMENT.match(name)
    return match["base"] if match else name


def _definition(base: Any) -> UnitDefinition | None:
    """Return the unit definition of an FMPy base unit; None if there is none."""
    if base is None:
        return None
    exponents = {name: int(getattr(base, name)) for name in BASES}
    factor = float(base.factor)
    if factor == 0.0:
        raise ValueError("a BaseUnit has the factor 0")
    return UnitDefinition(
        tuple((name, power) for name, power in exponents.items() if power),
        factor,
        float(base.offset),
    )


def _shape(indices: Sequence[tuple[int, ...]], variables: Sequence[Any]) -> tuple[int, ...] | None:
    """Return the shape of the array that sorted elements make, None if they make none."""
    if not indices[0]:
        return () if len(indices) == 1 else None
    if len({len(index) for index in indices}) > 1:
        return None
    if len({(v.type, v.causality, v.unit, bool(v.relativeQuantity)) for v in variables}) > 1:
        return None
    first = min(map(min, indices))
    shape = tuple(max(axis) + 1 - first for axis in zip(*indices))
    filled = len(indices) == np.prod(shape, dtype=float) and indices == [
        tuple(k + first for k in index) for index in np.ndindex(*shape)
    ]
    return shape if first in (0, 1) and filled else None


def _array(variable: Any, units: Units, sizes: Mapping[str, int], events: bool) -> Field:
    """Return the field of an FMI 3 variable; `events` enables clocks."""
    shape = tuple(_extent(variable.name, dimension, sizes) for dimension in variable.dimensions)
    field = _described(variable.name, shape, [variable], TYPES_3[variable.type], units)
    return replace(field, native=variable.type, clocked=events and bool(variable.clocks))


def _extent(name: str, dimension: Any, sizes: Mapping[str, int]) -> int:
    """Return the length of a dimension: a number, or the value of a structural parameter."""
    start = dimension.start
    if start is None and dimension.variable is not None:
        start = sizes.get(dimension.variable.name, dimension.variable.start)
    try:
        extent = int(str(start))
    except ValueError:
        extent = -1
    if not 0 <= extent <= LARGEST_EXTENT:
        raise ValueError(f"{name}: a dimension of length {start}")
    return extent


def _described(
    name: str, shape: tuple[int, ...], variables: Sequence[Any], kind: str, units: Units
) -> Field:
    first = variables[0]
    definition = units.get(first.unit)
    if definition and first.relativeQuantity:
        definition = replace(definition, offset=0.0)
    for variable in variables if kind in STARTS else ():
        for word in str(variable.start or "").split():
            if not STARTS[kind].fullmatch(word):
                got = f"expected {kind} values as start, got {variable.start!r}"
                raise ValueError(f"{variable.name}: {got}")
    number = dict.fromkeys(("nominal", "min", "max"))
    for key in number if kind in ("Real", "Integer", "Enumeration") else ():
        if (value := getattr(first, key)) not in (None, ""):
            try:
                number[key] = float(value)
            except ValueError:
                raise ValueError(f"{name}: expected a number as {key}, got {value!r}") from None
    return Field(
        name=name,
        shape=shape,
        references=tuple(v.valueReference for v in variables),
        type=kind,
        causality=first.causality or "local",
        unit=first.unit or "1",
        nominal=number["nominal"],
        minimum=number["min"],
        maximum=number["max"],
        start=first.start,
        description=first.description or "",
        derivative_of=_derivative_of(first, shape),
        definition=definition,
        choices=_choices(first) if kind == "Enumeration" else {},
        tunable=first.causality == "parameter" and first.variability == "tunable",
        has_start=first.variability != "constant" and first.initial in ("exact", "approx"),
        relative=bool(first.relativeQuantity),
    )


def _choices(variable: Any) -> dict[str, int]:
    """Return the items of an enumeration, name to value; empty if the FMU declares no type."""
    items = variable.declaredType.items if variable.declaredType else ()
    try:
        return {item.name: int(item.value) for item in items or ()}
    except (TypeError, ValueError):
        got = ", ".join(f"{item.name!r} with value {item.value!r}" for item in items)
        raise ValueError(
            f"{variable.declaredType.name}: expected an enumeration of names with whole numbers, "
            f"got {got}"
        ) from None


def _derivative_of(variable: Any, shape: tuple[int, ...]) -> str | None:
    """Return the name of the field that a variable is the time derivative of, or None."""
    if variable.derivative is None:
        return None
    name = variable.derivative.name
    return base_of(name) if shape else name
