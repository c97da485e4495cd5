"""Quantities with units in user files: "25 um" -> 2.5e-5, for pydantic models. SI inside, units at
the edge alone.
"""

import re
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from math import isfinite
from shutil import rmtree
from typing import Annotated, Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import core_schema

from .answers import kept_answers
from .cache import cache_folder
from .errors import BadInput


@cache
def registry():
    """The pint registry, made on first use, knowing rpm and deg as engine people write them. pint
    keeps its definitions as read in the user's cache: 0.03 s, and 0.4 s where there is none. What
    is kept and cannot be read is thrown away.
    """
    import pint

    made = partial(pint.UnitRegistry, autoconvert_offset_to_baseunit=True)
    with suppress(OSError, RuntimeError):  # there is nowhere to keep it
        kept = cache_folder("units")
        try:
            return made(cache_folder=kept)
        except Exception:  # whatever a damaged pickle raises
            rmtree(kept, ignore_errors=True)
    return made()


def pint_unit(unit):
    """A unit as pint writes it, from FMI's way: "kg.m2" -> "kg*m**2", "1" -> "dimensionless"."""
    return (
        "dimensionless"
        if unit == "1"
        else re.sub(r"(?<=[A-Za-z])(-?\d)", r"**\1", unit).replace(".", "*")
    )


TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
"""Units of time by their size [s]."""
SI = ("m", "kg", "N", "Pa", "J", "W", "K", "A", "V")
WRITTEN = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z]+)\s*")


def _without_pint(value, unit):
    """Return the SI value of a number or a plain text such as "1 ms", None of any other.

    pint gives the same bits, and takes 0.3 s to import.
    """
    if unit == "1" and type(value) in (int, float):
        return float(value)
    written = WRITTEN.fullmatch(value) if isinstance(value, str) else None
    if written is None:
        return None
    number, name = written.groups()
    if unit == "s" and name in TIMES:
        return float(number) * TIMES[name]
    return float(number) if name == unit and name in SI else None


def to_si(value, unit):
    """Convert a user's value to SI; see `_by_pint`."""
    plain = _without_pint(value, unit)
    plain = _by_pint(value, unit) if plain is None else plain
    if not isfinite(plain):
        raise _not_a_quantity(value, unit)
    return plain


EXAMPLES = {"m": "1 mm", "rad": "10 deg", "rad/s": "3000 rpm", "K": "90 degC", "1": "0.5"}
"""A quantity as users write it, by its SI unit; default: "1 UNIT"."""


def _not_a_quantity(value, unit):
    """Return the error of a value that is no finite quantity of the unit."""
    wanted = "a number" if unit == "1" else f"a quantity in {unit}"
    example = EXAMPLES.get(unit, f"1 {pint_unit(unit)}".replace("**", "^"))
    return ValueError(f"expected {wanted}, got {value!r}; write for example '{example}'")


@kept_answers("pint")
def _by_pint(value, unit):
    """Convert a user's value to SI.

    Parameters
    ----------
    value : str or float
        "25 um"; a bare number is taken only where `unit` is dimensionless.
    unit : str
        The SI unit it must have, as FMI or pint write it ("Pa.s", "1").

    Raises
    ------
    ValueError
        If the text is no quantity, or of another dimension; the sentence names value and unit.
    """
    if not is_known(unit):
        raise ValueError(f"expected a known unit, got {unit!r}")
    ureg = registry()
    target = ureg.Unit(pint_unit(unit))
    if isinstance(value, bool) or not isinstance(value, (str, int, float)):
        raise _not_a_quantity(value, unit)
    try:
        quantity = ureg.Quantity(value)
        compatible = quantity.is_compatible_with(target)
    except Exception:  # pint raises errors of many kinds
        compatible = False
    if not compatible:
        raise _not_a_quantity(value, unit)
    return float(quantity.to(target).magnitude)


@kept_answers("pint")
def from_si(value: float, si: str, unit: str) -> float:
    """A value in the SI unit `si` in another unit, as pint writes it; ValueError where there is no
    such unit, or of another dimension.
    """
    import pint

    try:
        return float(registry().Quantity(value, pint_unit(si)).to(unit).magnitude)
    except pint.PintError as error:
        raise ValueError(f"expected a unit of {si}, got {unit!r}") from error


@kept_answers("pint")
def worth(unit: str, other: str) -> str:
    """What the product of two units is, as FMI writes them: "energy", "power", or its own unit."""
    product = registry()(pint_unit(unit)) * registry()(pint_unit(other))
    for kind in ("energy", "power"):
        if product.check(f"[{kind}]"):
            return kind
    return f"{product.units:~P}"


def duration(name, text):
    """A positive time that a user gave for `name`, in seconds; BadInput if it is none."""
    try:
        seconds = to_si(text, "s")
    except ValueError as error:
        raise BadInput(f"{name}: {error}") from None
    if not seconds > 0:
        raise BadInput(f"{name}: expected a positive time, got {text!r}")
    return seconds


def is_angle(text: str) -> bool:
    """Whether a text is an angle; a pure number is none."""
    return _without_pint(text, "s") is None and _is_angle(text)


@kept_answers("pint")
def _is_angle(text: str) -> bool:
    try:
        units = registry().Quantity(text).units
    except Exception:
        return False
    return units.is_compatible_with("rad") and str(units) != "dimensionless"


@kept_answers("pint")
def is_known(unit: str) -> bool:
    """Whether a unit can be read; FMI leaves FMUs free to name theirs as they like."""
    try:
        registry().Unit(pint_unit(unit))
    except Exception:
        return False
    return True


@dataclass(frozen=True)
class in_unit:
    """Reads a pydantic field of floats from text with a unit, into SI `unit`; its JSON schema says
    the unit, and that of it a text is wanted.
    """

    unit: str

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_before_validator_function(
            lambda value: to_si(value, self.unit), handler(source)
        )

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        written = ["number", "string"] if self.unit == "1" else "string"
        return {**handler(schema), "type": written, "unit": self.unit}


def Quantity(unit):
    """Pydantic field type: float in SI `unit`, read from text with a unit."""
    return Annotated[float, in_unit(unit)]


def short(value, unit, digits=3):
    """A value with a unit of handy size: 5.2e-6 m -> "5.2 um"."""
    if unit == "1":
        return f"{value:.{digits}g}"
    if unit == "rad":
        return f"{registry().Quantity(value, 'rad').to('deg').magnitude:.1f} deg"
    if not is_known(unit):
        return f"{value:.{digits}g} {unit}"
    compact = registry().Quantity(float(value), pint_unit(unit)).to_compact()
    return one_micro(f"{compact:.{digits}g~P}")


def one_micro(text):
    """What pint has written, with the micro sign for the Greek letter that newer versions take."""
    return text.replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}")
