"""Quantities with units in user files: "25 um" -> 2.5e-5, for pydantic models."""

import re
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, partial
from importlib import import_module
from math import floor, isfinite, isnan, log10
from shutil import rmtree
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import core_schema

from .cache import cache_folder
from .errors import BadInput


@cache
def registry() -> Any:
    """Return the pint registry with rpm and deg.

    pint caches its parsed definitions in the user's cache, which takes 0.03 s instead of 0.4 s.
    An unreadable cache is deleted.
    """
    pint: Any = import_module("pint")
    make_registry = partial(pint.UnitRegistry, autoconvert_offset_to_baseunit=True)
    with suppress(OSError, RuntimeError):  # there is no place for a cache
        cache = cache_folder("units")
        try:
            return make_registry(cache_folder=cache)
        except Exception:  # whatever a damaged pickle raises
            rmtree(cache, ignore_errors=True)
    return make_registry()


def pint_unit(unit: str) -> str:
    """Convert a unit from FMI to pint: "kg.m2" -> "kg*m**2", "1" -> "dimensionless".

    pint itself reads "mPas" as several millipascals.

    >>> pint_unit("kg.m2"), pint_unit("1"), pint_unit("mPas")
    ('kg*m**2', 'dimensionless', 'mPa*s')
    """
    if unit == "1":
        return "dimensionless"
    unit = re.sub(r"Pas\b", "Pa*s", unit)
    return re.sub(r"(?<=[A-Za-z])(-?\d)\b", r"**\1", unit).replace(".", "*")


TIMES = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}
"""Units of time [s]."""
SI = ("m", "kg", "N", "Pa", "J", "W", "K", "A", "V")
WRITTEN = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z]+)\s*")


def _without_pint(value: Any, unit: str) -> float | None:
    """Return the SI value of a number or of a plain text such as "1 ms"; None for all others.

    pint gives the same bits but takes 0.3 s to import.
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


def to_si(value: object, unit: str, is_difference: bool = False) -> float:
    """Convert a user's value to SI; see `_by_pint`.

    >>> to_si("40 mm", "m"), to_si("90 degC", "K"), to_si(0.5, "1")
    (0.04, 363.15, 0.5)
    """
    plain = _without_pint(value, unit)
    if plain is None and not isinstance(value, bool) and isinstance(value, (str, int, float)):
        plain = _by_pint(value, unit, is_difference)
    if plain is None or not isfinite(plain):
        raise _not_a_quantity(value, unit)
    return plain


EXAMPLES = {"m": "1 mm", "rad": "10 deg", "rad/s": "3000 rpm", "K": "90 degC", "1": "0.5"}
"""Example of a quantity by its SI unit; default: "1 UNIT"."""


def _not_a_quantity(value: object, unit: str) -> ValueError:
    """Return the error for a value that is not a finite quantity of the unit.

    The example is the value with a decimal point, without spaces in its number or with a unit, if
    that makes it a quantity.
    """
    expected = "a number" if unit == "1" else f"a quantity in {unit}"
    example = EXAMPLES.get(unit, f"1 {pint_unit(unit)}".replace("**", "^"))
    plain = re.sub(r"(?<=\d)[\s_](?=\d)", "", str(value)).strip().replace(",", ".")
    own_unit = example.partition(" ")[2]
    with suppress(ValueError):
        closer = plain if quantity(plain).units._units or unit == "1" else f"{plain} {own_unit}"
        example = example if _is_apart(quantity(closer), unit) else closer
    expected += " with a decimal point" if "," in str(value) else ""
    return ValueError(f"expected {expected}, got {value!r}; write for example '{example}'")


QUANTITY = re.compile(
    r"\s*(?P<number>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?:\s*\*)?\s*(?P<unit>.*?)\s*"
)
"""Number with a unit or without."""
EXPONENT = re.compile(r"(?:\^|\*\*)\s*\(?[-+]?\d+(?:\.\d+)?\)?|(?<=[^\W\d_])-?\d+\b")
"""Exponent in a unit: m^2, m**2, m2, min-1."""


@cache
def quantity(text: str) -> Any:
    """Return the pint quantity of one number with a unit, or of a number alone.

    pint itself reads "0,045 mm" and "3 000 rpm" as 0, "mm" as 1 mm, and "Grad", which is German
    for degree, as 1e9 rad.

    Raises
    ------
    ValueError
        If the text is not one number with a known unit.
    """
    written = QUANTITY.fullmatch(text.replace("\N{MINUS SIGN}", "-"))
    if written is None:
        raise ValueError(f"expected one number with a unit, got {text!r}")
    unit = re.sub(r"^1?\s*/", "1/", written["unit"])
    if re.search(r"[-+,\d]", EXPONENT.sub("", unit.removeprefix("1/"))) or unit == "Grad":
        raise ValueError(f"expected one number with a unit, got {text!r}")
    try:
        value = registry().Quantity(float(written["number"]), pint_unit(unit or "1"))
    except Exception:  # pint raises errors of many kinds
        raise ValueError(f"expected a known unit, got {text!r}") from None
    return value


def angle_power(units: Any) -> float:
    """Return the exponent of the angle in a unit of pint, which pint counts as no dimension.

    It is 1 for rpm and 0 for Hz, which differ by 2 pi.
    """
    return registry().Quantity(1.0, units).to_root_units()._units.get("radian", 0)


def times(text: str, factor: float) -> str:
    """Return a quantity times a number, as text.

    >>> times("40 mm", 1.5)
    '60 mm'
    """
    one = quantity(text)
    return f"{factor * one.magnitude:.12g} {one.units:~}"


def are_compatible(units: Any, others: Any) -> bool:
    """Return whether two units of pint have the same dimension, angles included."""
    same = registry().Quantity(1.0, units).is_compatible_with(others)
    return same and angle_power(units) == angle_power(others)


def _is_apart(value: Any, unit: str) -> bool:
    """Return whether a quantity of pint is infinite or of another dimension than the unit."""
    return not (isfinite(value.magnitude) and are_compatible(value.units, pint_unit(unit)))


@cache
def _by_pint(value: str | float, unit: str, is_difference: bool = False) -> float:
    """Convert a user's value to SI.

    Parameters
    ----------
    value : str or float
        "25 um". A bare number is valid only if `unit` is dimensionless and no angle.
    unit : str
        Required SI unit, as FMI or pint write it ("Pa.s", "1").
    is_difference : bool
        Whether the value is a difference, whose unit has no offset: "5 degC" is 5 K.

    Raises
    ------
    ValueError
        If the text is not a quantity, or has another dimension. It contains value and unit.
    """
    if not is_known(unit):
        raise ValueError(f"expected a known unit, got {unit!r}")
    try:
        parsed = quantity(str(value))
    except ValueError:
        raise _not_a_quantity(value, unit) from None
    target = pint_unit(unit)
    # a bare number for a unit such as % is a share or in the unit: factor 100
    bare = not parsed.units._units and registry().Quantity(1.0, target).to_root_units().m != 1.0
    if _is_apart(parsed, unit) or bare:
        raise _not_a_quantity(value, unit)
    zero = registry().Quantity(0.0, parsed.units).to(target).magnitude if is_difference else 0.0
    return float(parsed.to(target).magnitude - zero)


@cache
def from_si(value: float, si: str, unit: str) -> float:
    """Convert a value from the SI unit `si` to another unit, as pint writes it.

    Raises `ValueError` if the unit is unknown or has another dimension.

    >>> print(f"{from_si(2.0, 'rad/s', 'rpm'):.3f}")
    19.099
    """
    amount = registry().Quantity(value, pint_unit(si))
    if not is_known(unit) or not are_compatible(amount.units, pint_unit(unit)):
        raise ValueError(f"expected a unit of {si}, got {unit!r}")
    return float(amount.to(pint_unit(unit)).magnitude)


@cache
def worth(unit: str, other: str) -> str:
    """Return the kind of the product of two FMI units: "energy", "power", or its unit."""
    product = registry()(pint_unit(unit)) * registry()(pint_unit(other))
    for kind in ("energy", "power"):
        if product.check(f"[{kind}]"):
            return kind
    return f"{product.units:~P}"


def powers_of(unit: Any) -> dict[str, int]:
    """Return the exponents of the SI base units in a unit of pint."""
    return {f"{registry().Unit(name):~}": int(power) for name, power in unit._units.items()}


def base_unit(unit: str) -> dict[str, str]:
    """Return the attributes of the element `BaseUnit` of FMI: factor and exponents."""
    base = registry().Quantity(1.0, pint_unit(unit)).to_base_units()
    powers = {name: str(power) for name, power in sorted(powers_of(base.units).items())}
    return powers if base.magnitude == 1.0 else {"factor": repr(base.magnitude)} | powers


def positive_si(name: str, text: str, unit: str) -> float:
    """Convert a quantity above 0 to SI; raise `BadInput` with `name` for others.

    >>> positive_si("--time-limit", "20 ms", "s")
    0.02
    """
    try:
        value = to_si(text, unit)
    except ValueError as error:
        raise BadInput(f"{name}: {error}") from None
    if not value > 0.0:
        raise BadInput(f"{name}: expected a value above 0 {unit}, got {text!r}")
    return value


def is_angle(text: str) -> bool:
    """Return whether a text is an angle with a unit."""
    return _without_pint(text, "s") is None and _is_angle(text)


@cache
def _is_angle(text: str) -> bool:
    try:
        return are_compatible(quantity(text).units, "rad")
    except ValueError:
        return False


@cache
def is_known(unit: str) -> bool:
    """Return whether pint knows a unit; FMUs may use any name.

    >>> is_known("MPa"), is_known("furlong per sol")
    (True, False)
    """
    try:
        registry().Unit(pint_unit(unit))
    except Exception:
        return False
    return True


@dataclass(frozen=True)
class in_unit:
    """Annotation of a pydantic float that is read from text with a unit into SI `unit`.

    Its JSON schema contains the unit and the type string. If `alone`, the value is the unit of a
    table or mesh, and "mm" is valid as well as "1 mm".
    """

    unit: str
    alone: bool = False

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        return core_schema.no_info_before_validator_function(
            lambda value: to_si(self.with_number(value), self.unit), handler(source)
        )

    def with_number(self, value: Any) -> Any:
        """Return a unit alone with the number 1, any other value unchanged."""
        is_unit = self.alone and isinstance(value, str) and is_known(value)
        return f"1 {value}" if is_unit and not re.search(r"\d", value[:1]) else value

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        written = ["number", "string"] if self.unit == "1" else "string"
        return {**handler(schema), "type": written, "unit": self.unit}


def short(value: float, unit: str, digits: int = 3) -> str:
    """Return a value as text with a prefixed unit: 5.2e-6 m -> "5.2 um".

    >>> short(5.2e-6, "m"), short(3.2e6, "Pa"), short(0.25, "1")
    ('5.2 µm', '3.2 MPa', '0.25')
    """
    if unit == "1":
        return f"{value:.{digits}g}"
    if unit == "rad":
        return f"{registry().Quantity(value, 'rad').to('deg').magnitude:z.1f} deg"
    if not is_known(unit):
        return f"{value:.{digits}g} {unit}"
    compact = registry().Quantity(float(value), pint_unit(unit)).to_compact()
    return one_micro(f"{compact:.{digits}g~P}")


def one_micro(text: str) -> str:
    """Replace the Greek letter mu, which newer versions of pint write, by the micro sign."""
    return text.replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}")


def unit_text(units: Any) -> str:
    """Return units of pint as a case file writes them, with u for micro."""
    return one_micro(f"{units:~}").replace("\N{MICRO SIGN}", "u")


TWO_DIGITS = 3.55
"""Leading digits of an uncertainty up to which it has two digits, as in the tables of the Particle
Data Group. A larger one has one digit."""


def numbers_text(value: float, spread: float) -> str:
    """Return a value with its uncertainty, "2.17 +- 0.08": both end with the same digit.

    A value above its uncertainty has another digit if both would be equal. An uncertainty of NaN is
    unknown.

    >>> numbers_text(2.1685, 0.081), numbers_text(2.1685, 0.0)
    ('2.17 +- 0.08', '2.17')
    """
    if isnan(spread):
        return f"{value:.3g} +- unknown"
    if not spread > 0.0:
        return f"{value:.3g}"
    power = floor(log10(spread))
    places = -power + (spread / 10.0**power < TWO_DIGITS)
    places += spread < abs(value) and round(abs(value), places) == round(spread, places)
    shown = [f"{round(number, places):z.{max(places, 0)}f}" for number in (value, spread)]
    return " +- ".join(shown)
