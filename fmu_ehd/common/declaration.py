"""Parameters declared once: a field of a dataclass with unit and range, its description below it.

`declared` and `choice` are the default of a field; `variables_of` returns the rows of the FMU's
variable table.
"""

from collections.abc import Iterable
from dataclasses import field, fields, replace
from typing import Any

from ...master.fmi.texts import description
from ...master.fmi.variables import Variable

# keys of a declaration in the metadata of its field
VARIABLE = "variable"
CONDITION = "condition"


def declared(
    unit: str,
    start: float,
    low: float,
    high: float,
    condition: bool = False,
    advanced: bool = False,
) -> Any:
    """Declare a number.

    Parameters
    ----------
    unit : str
        SI unit as in `Variable`.
    start, low, high : float
        Default and allowed range [unit], both ends included.
    condition : bool
        True if it may be an input of the FMU, which changes from step to step.
    advanced : bool
        True if few cases need it.
    """
    variable = Variable(
        "", unit, "parameter", "", start, minimum=low, maximum=high, advanced=advanced
    )
    return field(default=start, metadata={VARIABLE: variable, CONDITION: condition})


def choice(allowed: Iterable[str], advanced: bool = False) -> Any:
    """Declare the choice of a law by name; the first name is the default."""
    names = tuple(allowed)
    variable = Variable("", "1", "parameter", "", names[0], choices=names, advanced=advanced)
    return field(default=names[0], metadata={VARIABLE: variable, CONDITION: False})


def variables_of(kind: type, condition: bool = False) -> list[Variable]:
    """Return the variables of the declared fields: the conditions, or all others."""
    return [
        replace(own.metadata[VARIABLE], name=own.name, description=description(kind, own.name))
        for own in fields(kind)
        if own.metadata.get(CONDITION) == condition
    ]
