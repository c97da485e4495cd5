"""The variable table: each variable of an FMU is declared once, for all its uses.

They are XML, range checks, result files and axis labels.
"""

from dataclasses import dataclass, replace
from math import prod
from typing import Any

import numpy as np

from .errors import BadInput, unknown

KINDS = ("parameter", "input", "constant", "output", "tunable parameter")
"""Causalities, and parameters that may change, in the order of the front (front.h)."""

END = "end of the step"
"""When a step reads its inputs, unless the model interpolates them."""


@dataclass(frozen=True)
class Variable:
    """One variable of an FMU, scalar or array.

    In FMI 2 an array of shape (n, m) becomes n*m scalars `name[i,j]` with consecutive value
    references. They are 1-based, and j runs fastest.

    Parameters
    ----------
    name : str
        Standard term of the field, as in the interface contract.
    unit : str
        SI unit as FMI writes it: "m", "m/s", "Pa", "Pa.s", "N", "N.m", "rad", "rad/s", "kg", "1"
        for none.
    causality : {"parameter", "input", "output", "constant"}
        Parameters that are not tunable are read once, when initialisation ends. A constant is a
        property of the built FMU (grid sizes).
    description : str
        One sentence.
    start : float, int or str
        Start value (every element of an array). Its type determines the FMI type: float Real, int
        Integer, str String, or with `choices` Enumeration.
    nominal : float, optional
        Typical magnitude [unit], used to scale residuals.
    minimum, maximum : float, optional
        Allowed range [unit], both ends included.
    shape : tuple of int
        () for a scalar.
    derivative_of : str, optional
        Name of the variable whose time derivative this one is.
    choices : tuple of str
        Allowed texts. Importers see their numbers, which begin at 1.
    tunable : bool
        Whether a parameter may change between two steps.
    advanced : bool
        Whether few cases need a parameter; the list of keys omits it by default.
    """

    name: str
    unit: str
    causality: str
    description: str
    start: float | int | str = 0.0
    nominal: float | None = None
    minimum: float | None = None
    maximum: float | None = None
    shape: tuple[int, ...] = ()
    derivative_of: str | None = None
    choices: tuple[str, ...] = ()
    tunable: bool = False
    advanced: bool = False

    @property
    def kind(self) -> str:
        """One of `KINDS`."""
        return KINDS[-1] if self.tunable else self.causality

    @property
    def size(self) -> int:
        """Number of scalars."""
        return prod(self.shape)

    @property
    def type(self) -> str:
        """FMI type name: Real, Integer, String or Enumeration."""
        if self.choices:
            return "Enumeration"
        return {float: "Real", int: "Integer", str: "String"}[type(self.start)]

    def fault(self, value: Any) -> str | None:
        """Return a sentence why `value` [unit] is not allowed, or None."""
        if self.type == "String":
            return None
        if self.choices:
            known = value in self.choices
            return None if known else f"{self.name}: {unknown('choice', value, self.choices)}"
        low = float("-inf") if self.minimum is None else self.minimum
        high = float("inf") if self.maximum is None else self.maximum
        if low <= value <= high:
            return None
        unit = "" if self.unit == "1" else f" {self.unit}"
        return f"{self.name}: expected {low:g} to {high:g}{unit}, got {value:g}{unit}"

    def starting(self, value: Any) -> "Variable":
        """Return the variable with another start value; one of a choice may be its number.

        Raises
        ------
        BadInput
            If the elements of an array differ, because an FMU declares one value for all of them.
        """
        start, *others = dict.fromkeys(np.ravel(value).tolist())
        if others:
            raise BadInput(
                f"{self.name}: expected one start value for all elements, got {1 + len(others)}; "
                "set the input after the FMU is loaded"
            )
        if self.choices and isinstance(start, int):
            start = self.choices[start - 1]
        return replace(self, start=type(self.start)(start))

    def at_the_end(self) -> "Variable":
        """Return an input whose description says when a step reads it."""
        if self.causality != "input" or END in self.description:
            return self
        return replace(self, description=f"{self.description}; its value at the {END}")

    def number(self, value: Any) -> Any:
        """Return the stored form of a value: for a choice, its number."""
        return self.choices.index(value) + 1 if self.choices else value


def constant(name: str, value: int | float, description: str) -> Variable:
    """Return a property of the built FMU (grid size, contract version)."""
    return Variable(name, "1", "constant", description, value, minimum=value, maximum=value)


def parameter(
    name: str,
    unit: str,
    description: str,
    start: float | int | str,
    minimum: float | None = None,
    maximum: float | None = None,
    shape: tuple[int, ...] = (),
) -> Variable:
    """Return a parameter with its allowed range; with a shape, they hold for every element."""
    return Variable(
        name,
        unit,
        "parameter",
        description,
        start,
        minimum=minimum,
        maximum=maximum,
        shape=shape,
    )


def input_variable(
    name: str,
    unit: str,
    description: str,
    start: float | int = 0.0,
    nominal: float | None = None,
    shape: tuple[int, ...] = (),
    *,
    limits: tuple[float | None, float | None] = (None, None),
) -> Variable:
    """Return an input with its allowed range; with a shape, all hold for every element."""
    return Variable(name, unit, "input", description, start, nominal, *limits, shape=shape)


def output_variable(
    name: str,
    unit: str,
    description: str,
    nominal: float | None = None,
    shape: tuple[int, ...] = (),
    *,
    start: float | int = 0.0,
    derivative_of: str | None = None,
) -> Variable:
    """Return an output; with a shape, `start` and `nominal` hold for every element."""
    return Variable(
        name,
        unit,
        "output",
        description,
        start,
        nominal=nominal,
        shape=shape,
        derivative_of=derivative_of,
    )
