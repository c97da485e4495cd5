"""Fields of an FMU as the importing side sees them: scalars `name[i,j]` of a model description
gathered into arrays.
"""

import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np

ELEMENT = re.compile(r"^(?P<base>.+)\[(?P<index>\d+(,\d+)*)\]$")
TYPES_3 = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean", "String": "String"}
"""FMI 3 types that can take part, by their FMI 2 names."""


@dataclass(frozen=True)
class Field:
    """An array (or scalar, shape ()) variable of an FMU.

    `references` lists the value references: in FMI 2 of all elements in C order of `shape`, in FMI
    3 the array's one. `unit`, `nominal`, `minimum`, `maximum`, `start` are those of the first
    element ("1" and None where the FMU says nothing), `derivative_of` names the field whose time
    derivative this one is.
    """

    name: str
    shape: tuple
    references: tuple
    type: str
    causality: str
    unit: str
    nominal: float | None
    minimum: float | None
    maximum: float | None
    start: str | None
    description: str
    derivative_of: str | None = None

    @cached_property
    def size(self):
        return int(np.prod(self.shape))


def gather_fields(description):
    """Fields of an FMPy model description.

    Parameters
    ----------
    description : fmpy.model_description.ModelDescription

    Returns
    -------
    dict of str to Field
        In the order of first appearance.

    Raises
    ------
    ValueError
        If the elements of an array do not fill a rectangle; names the array.
    """
    if description.fmiVersion.startswith("3"):
        return {v.name: _array(v) for v in description.modelVariables if v.type in TYPES_3}
    groups = {}
    for variable in description.modelVariables:
        match = ELEMENT.match(variable.name)
        base, index = (
            (match["base"], tuple(map(int, match["index"].split(","))))
            if match
            else (variable.name, ())
        )
        groups.setdefault(base, []).append((index, variable))
    return {base: _field(base, members) for base, members in groups.items()}


def _field(base, members):
    members.sort(key=lambda member: member[0])
    shape = (
        tuple(int(n) for n in np.max([index for index, _ in members], axis=0))
        if members[0][0]
        else ()
    )
    if [index for index, _ in members] != [
        tuple(k + 1 for k in index) for index in np.ndindex(*shape)
    ]:
        raise ValueError(f"{base}: its elements do not fill an array of shape {shape}")
    return _described(base, shape, [v for _, v in members], members[0][1].type)


def _array(variable):
    """Field of an FMI 3 variable."""
    return _described(
        variable.name,
        tuple(int(d.start) for d in variable.dimensions),
        [variable],
        TYPES_3[variable.type],
    )


def _described(name, shape, variables, kind):
    first = variables[0]
    number = {
        key: float(value)
        if (value := getattr(first, key)) not in (None, "") and kind != "String"
        else None
        for key in ("nominal", "min", "max")
    }
    return Field(
        name,
        shape,
        tuple(v.valueReference for v in variables),
        kind,
        first.causality or "local",
        first.unit or "1",
        number["nominal"],
        number["min"],
        number["max"],
        first.start,
        first.description or "",
        _derivative_of(first),
    )


def _derivative_of(variable):
    """Name of the field that a variable is the time derivative of, or None."""
    if variable.derivative is None:
        return None
    match = ELEMENT.match(variable.derivative.name)
    return match["base"] if match else variable.derivative.name
