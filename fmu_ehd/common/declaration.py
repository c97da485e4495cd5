"""Parameters declared once: a field of a dataclass that also says unit, range and description.

`declared` and `choice` stand where the default of a field stands; `variables_of` makes the rows of
the FMU's variable table of them.
"""

from collections.abc import Iterable
from dataclasses import field, fields, replace
from typing import Any

from ...master.fmi.variables import Variable

# keys of a declaration in the metadata of its field
VARIABLE = "variable"
CONDITION = "condition"


def declared(
    unit: str, start: float, low: float, high: float, description: str, condition: bool = False
) -> Any:
    """Declare a number.

    Parameters
    ----------
    unit : str
        SI unit as in `Variable`.
    start, low, high : float
        Default and allowed range [unit], both ends included.
    description : str
        One sentence.
    condition : bool
        True if it may be an input of the FMU, which changes from step to step.
    """
    variable = Variable("", unit, "parameter", description, start, minimum=low, maximum=high)
    return field(default=start, metadata={VARIABLE: variable, CONDITION: condition})


def choice(description: str, allowed: Iterable[str]) -> Any:
    """Declare the choice of a law by name; the first name is the default."""
    names = tuple(allowed)
    variable = Variable("", "1", "parameter", description, names[0], choices=names)
    return field(default=names[0], metadata={VARIABLE: variable, CONDITION: False})


def variables_of(declaration: type, condition: bool = False) -> list[Variable]:
    """Rows of the variable table for the declared fields that are conditions, or are not."""
    return [
        replace(entry.metadata[VARIABLE], name=entry.name)
        for entry in fields(declaration)
        if entry.metadata.get(CONDITION) == condition
    ]
