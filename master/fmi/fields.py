"""Fields of an FMU as the importing side sees them: scalars `name[i,j]` of a model description gathered into arrays."""

import re
from dataclasses import dataclass
from functools import cached_property

import numpy as np

ELEMENT = re.compile(r"^(?P<base>.+)\[(?P<index>\d+(,\d+)*)\]$")


@dataclass(frozen=True)
class Field:
    """An array (or scalar, shape ()) variable of an FMU.

    `references` lists the value references in C order of `shape`; `unit`, `nominal`, `minimum`, `maximum`, `start` are
    those of the first element ("1" and None where the FMU says nothing).
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

    @cached_property
    def size(self):
        return len(self.references)


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
    groups = {}
    for variable in description.modelVariables:
        match = ELEMENT.match(variable.name)
        base, index = (match["base"], tuple(map(int, match["index"].split(",")))) if match else (variable.name, ())
        groups.setdefault(base, []).append((index, variable))
    return {base: _field(base, members) for base, members in groups.items()}


def _field(base, members):
    members.sort(key=lambda member: member[0])
    shape = tuple(int(n) for n in np.max([index for index, _ in members], axis=0)) if members[0][0] else ()
    if [index for index, _ in members] != [tuple(k + 1 for k in index) for index in np.ndindex(*shape)]:
        raise ValueError(f"{base}: its elements do not fill an array of shape {shape}")
    first = members[0][1]
    number = {key: float(value) if (value := getattr(first, key)) not in (None, "") and first.type != "String" else None
              for key in ("nominal", "min", "max")}
    return Field(base, shape, tuple(v.valueReference for _, v in members), first.type, first.causality or "local",
                 first.unit or "1", number["nominal"], number["min"], number["max"], first.start, first.description or "")
