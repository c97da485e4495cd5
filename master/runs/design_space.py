"""Variables of a design: numbers of a case, and shapes that a profile of the skirt consists of.

A design is a vector x of shares, one for each variable. At x = 0 it is the case itself.

Eq. (V1):  number = its value in the case + x times its scale
Eq. (V2):  profile(theta, y) = sum of x_k a s_k,   s_k = B_m(y) cos(q (theta - 90 deg)) - its mean

a is the amplitude of the shapes and B_m a cubic B-spline between both ends of the skirt. theta is
the angle from the pin axis towards the thrust side. The mean over the skirt is zero, so no shape
changes the mean clearance. All shapes are their own mirror images in the thrust plane. Positive
values are further from the bore, as in a table of `profiles`.
"""

import hashlib
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.interpolate import BSpline

from ..case.changes import change, value_at, whole_keys
from ..case.contract import players
from ..case.keys import key_at
from ..case.schema import Case
from ..fmi.cache import write_whole
from ..fmi.errors import BadInput, for_all
from ..fmi.option_classes import Key
from ..fmi.quantities import are_compatible, positive_si, quantity, registry, to_si, unit_text

Changes = list[tuple[str, Any]]
"""Pairs of a dotted key of a case and its value."""
ANGLES = np.arange(0.0, 360.0, 5.0)
"""Angles of a table of shapes, from the pin axis towards the thrust side [deg]."""
HEIGHTS = 81
"""Heights of a table of shapes."""
TABLE_UNITS = {"angle_unit": "1 deg", "height_unit": "1 mm", "value_unit": "1 um"}


@dataclass(frozen=True)
class Number:
    """Number of a case that is varied, Eq. (V1).

    name : as the user wrote it; keys : dotted paths that have the value; value, scale : at x = 0,
    and for a share of 1, in `unit`, "" for a number without one; step_text : `scale` as the user
    wrote it.
    """

    name: str
    keys: tuple[str, ...]
    value: float
    scale: float
    unit: str
    step_text: str = ""

    def changes(self, share: float) -> Changes:
        """Return the changes of the case for a share."""
        number = float(f"{self.value + share * self.scale:.15g}")  # Eq. (V1)
        return [(key, f"{number!r} {self.unit}" if self.unit else number) for key in self.keys]


@dataclass(frozen=True)
class Shapes:
    """Shapes of the profile of a skirt, Eq. (V2).

    names : of the shapes; key : dotted path of the profiles of the piston; before : its value in
    the case; heights : of the tables above the pin [m]; values : ndarray, shape (n, heights,
    angles) [-]; amplitude : a [m]; folder : of the tables that are written.
    """

    names: tuple[str, ...]
    key: str
    before: tuple[Any, ...]
    heights: np.ndarray
    values: np.ndarray
    amplitude: float
    folder: Path

    def profile(self, shares: np.ndarray) -> np.ndarray:
        """Return the profile of shares, shape (heights, angles) [m]."""
        return self.amplitude * np.tensordot(np.asarray(shares), self.values, 1)  # Eq. (V2)

    def changes(self, shares: np.ndarray) -> Changes:
        """Return the changes of the case for shares, none if all are zero; write the table."""
        if not np.any(shares):
            return []
        content = self.table(self.profile(shares))
        self.folder.mkdir(parents=True, exist_ok=True)
        path = self.folder / f"{hashlib.sha256(content).hexdigest()[:16]}.csv"
        if not path.exists():
            write_whole(path, content)
        return [(self.key, [*self.before, {"file": str(path)} | TABLE_UNITS])]

    def table(self, profile: np.ndarray) -> bytes:
        """Return a profile as a table that `profiles` reads, in deg, mm and um."""
        lines = [",".join(["height [mm] / angle [deg]", *(f"{angle:g}" for angle in ANGLES)])]
        for height, row in zip(self.heights, profile):
            lines.append(",".join([f"{1e3 * height:.6g}", *(f"{1e6 * one:.9f}" for one in row)]))
        return ("\n".join(lines) + "\n").encode()


@dataclass(frozen=True)
class DesignSpace:
    """All variables of a design: numbers first, then shapes."""

    numbers: tuple[Number, ...]
    shapes: Shapes | None = None

    def __post_init__(self) -> None:
        """Raise `BadInput` if several variables have one key."""
        keys = [key for one in self.numbers for key in one.keys]
        if repeated := next((key for k, key in enumerate(keys) if key in keys[:k]), None):
            raise BadInput(f"{repeated}: expected the key in one variable, got it in several")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables."""
        return tuple(one.name for one in self.numbers) + (self.shapes.names if self.shapes else ())

    def changes(self, shares: np.ndarray) -> Changes:
        """Return the changes of the case for a vector of shares."""
        split = len(self.numbers)
        changes = [pair for one, x in zip(self.numbers, shares) if x for pair in one.changes(x)]
        return changes + (self.shapes.changes(shares[split:]) if self.shapes else [])


def number_of(tree: dict[str, Any], text: str, folder: Path, option: str) -> Number:
    """Return the number of "KEY" or "KEY=STEP"; keys joined by "+" have one value.

    Without a step it is 2 % of the value.

    Raises
    ------
    BadInput
        For an unknown key, a value that is no number, and a step of another unit or of zero.
    """
    name, sign, step = text.partition("=")
    keys = whole_keys(tree, name, folder, option)
    known = _common_value(tree, keys, folder, option)
    scale = 0.02 * abs(known.magnitude)
    if sign:
        scale = in_units_of(known, step, f"{option} {name.strip()}", is_difference=True)
    if not scale:
        got = f"got {step.strip()}" if sign else "because the value is zero; write KEY=STEP"
        raise BadInput(f"{option} {name.strip()}: expected a step, {got}")
    unit = _unit_of(known)
    text = step.strip() if sign else f"{scale:.3g} {unit}".strip()
    return Number(
        name=name.strip(),
        keys=keys,
        value=known.magnitude,
        scale=abs(scale),
        unit=unit,
        step_text=f"+{text.lstrip('+-')}",
    )


def range_of(
    tree: dict[str, Any], text: str, folder: Path, option: str
) -> tuple[Number, float, float]:
    """Return the number of "KEY=LOW..HIGH" whose share is 1 at half of the range, and its bounds.

    Raises
    ------
    BadInput
        As `number_of`, and if the value of the case is not in the range.
    """
    name, sign, rest = text.partition("=")
    low, dots, high = rest.partition("..")
    if not (sign and dots):
        raise BadInput(f"{option}: expected KEY=LOW..HIGH, got {text!r}")
    keys = whole_keys(tree, name, folder, option)
    known = _common_value(tree, keys, folder, option)
    ends = [in_units_of(known, end, f"{option} {name.strip()}") for end in (low, high)]
    if ends[0] >= ends[1]:
        raise BadInput(f"{option} {name.strip()}: expected LOW below HIGH, got {rest}")
    if not ends[0] <= known.magnitude <= ends[1]:
        raise BadInput(
            f"{option} {name.strip()}: expected a range that contains {known.magnitude:g} "
            f"{_unit_of(known)}, the value of the case, got {rest}"
        )
    scale = 0.5 * (ends[1] - ends[0])
    bounds = [(end - known.magnitude) / scale for end in ends]
    number = Number(
        name=name.strip(), keys=keys, value=known.magnitude, scale=scale, unit=_unit_of(known)
    )
    return number, *bounds


def start_of(ranges: Sequence[tuple[Number, float, float]], texts: Sequence[str]) -> np.ndarray:
    """Return the shares of all numbers, 0 except for those of a text "KEY=VALUE".

    ranges : of `range_of`.

    Raises
    ------
    BadInput
        For a key that is not varied, and a value of another unit or outside the range.
    """
    shares = np.zeros(len(ranges))

    def read(text):
        name, _, value = (one.strip() for one in text.partition("="))
        names = [number.name for number, *_ in ranges]
        if name not in names:
            raise BadInput(f"--start {name}: expected a number of --vary, got another one")
        number, low, high = ranges[names.index(name)]
        made = in_units_of(quantity(f"1 {number.unit}"), value, f"--start {name}")
        share = (made - number.value) / number.scale
        if not low <= share <= high:
            raise BadInput(f"--start {name}: expected a value in the range of --vary, got {value}")
        shares[names.index(name)] = share

    for_all(read, texts)
    return shares


def in_units_of(known: Any, text: str, where: str, is_difference: bool = False) -> float:
    """Return a text as a number in the unit of a quantity.

    As a difference, 5 K and 5 degC are the same.
    """
    try:
        value = quantity(text.strip())
        if not are_compatible(value.units, known.units):
            raise ValueError(text)
        number = value.m_as(known.units)
        zero = 0.0 if not is_difference else registry().Quantity(0.0, value.units).m_as(known.units)
        return number - zero
    except Exception:  # pint raises errors of many kinds
        raise BadInput(
            f"{where}: expected a quantity in {_unit_of(known) or '1'}, got {text.strip()!r}"
        ) from None


def _unit_of(known: Any) -> str:
    return unit_text(known.units).replace(" * ", " ")


def _common_value(tree: dict[str, Any], keys: Sequence[str], folder: Path, option: str) -> Any:
    """Return the value that all keys have; raise `BadInput` if they have different ones."""
    known, *others = (_value_of(tree, key, folder, option) for key in keys)
    for other in others:
        alike = are_compatible(known.units, other.units)
        if not alike or not np.isclose(other.m_as(known.units), known.magnitude, 1e-9, 0.0):
            shown = [f"{one.magnitude:g} {_unit_of(one)}".strip() for one in (known, other)]
            raise BadInput(
                f"{option} {'+'.join(keys)}: expected keys of one value, got {' and '.join(shown)}"
            )
    return known


def _value_of(tree: dict[str, Any], key: str, folder: Path, option: str) -> Any:
    """Return the value of a key in the case, or its default, as a pint quantity."""
    declared = key_at(tree, key, folder)
    try:
        value = value_at(tree, key, folder)
    except KeyError:
        value = _default(declared) if declared else None
    try:
        if isinstance(value, bool) or value is None:
            raise ValueError
        known = quantity(str(value))
    except ValueError:
        shown = "nothing" if value is None else repr(value)
        raise BadInput(
            f"{option} {key}: expected a key whose value is a number, got {shown}"
        ) from None
    if fault := change(deepcopy(tree), key, value, folder):
        raise BadInput(f"{option} {fault}")
    if declared and declared.whole:
        raise BadInput(
            f"{option} {key}: expected a key that is not a whole number, got {value}; "
            "`piston-cosim sweep` varies whole numbers"
        )
    return known


def _default(key: Key) -> str:
    """Return the default of a key with its unit."""
    return f"{key.default} {key.unit}" if key.default in ("0", "0.0") else key.default


def shapes_of(case: Case, tree: dict[str, Any], size: str, amplitude: str, folder: Path) -> Shapes:
    """Return the shapes of the skirt of a case.

    Parameters
    ----------
    case : Case
        Its axes give the ends of the skirt.
    tree : dict
    size : str
        "HEIGHTSxORDERS": number of splines and of orders q = 0, 1, ...
    amplitude : str
        a > 0, a length.
    folder : Path
        Folder of the tables that are written.

    Raises
    ------
    BadInput
        Without one piston and one film, without axes with heights, or for another size or
        amplitude.
    """
    height = positive_si("--amplitude", amplitude, "m")
    films, bodies = (players(tree, role) for role in ("lubrication", "bodies"))
    piston = (
        tree["participants"].get(bodies[0], {}).get("build", {}).get("piston") if bodies else None
    )
    if len(films) != 1 or not isinstance(piston, dict):
        raise BadInput("--shapes: expected a case with one film and a table build.piston")
    axis = case.axes_of(f"{films[0]}.pressure").second
    if not axis.unit:
        raise BadInput("--shapes: expected a case with [[axes]] that give the heights of the skirt")
    splines, orders = _size(size)
    lower, upper = (to_si(f"{end} {axis.unit}", "m") for end in axis.range)
    heights = np.linspace(lower, upper, HEIGHTS)
    names, values = shape_functions((heights - lower) / (upper - lower), splines, orders)
    key = f"participants.{bodies[0]}.build.piston.profiles"
    before = tuple(piston.get("profiles", ()))
    return Shapes(
        names=names,
        key=key,
        before=before,
        heights=heights,
        values=values,
        amplitude=height,
        folder=folder,
    )


def _size(text: str) -> tuple[int, int]:
    splines, _, orders = text.partition("x")
    if splines.isdecimal() and orders.isdecimal():
        if 4 <= int(splines) <= 12 and 1 <= int(orders) <= 8:
            return int(splines), int(orders)
    raise BadInput(f"--shapes: expected HEIGHTSxORDERS, 4x1 to 12x8, got {text!r}")


def shape_functions(
    place: np.ndarray, splines: int, orders: int
) -> tuple[tuple[str, ...], np.ndarray]:
    """Return the names and the values of the shapes s_k of Eq. (V2).

    Parameters
    ----------
    place : ndarray, shape (n,)
        Heights as shares of the skirt, 0 to 1.
    splines, orders : int
        Number of B-splines >= 4, and of orders >= 1.

    Returns
    -------
    names : tuple of str
    values : ndarray, shape (splines orders - 1, n, angles)
        [-]. The splines of order 0 sum to a constant, so the last of them is omitted.
    """
    knots = np.concatenate([[0.0] * 3, np.linspace(0.0, 1.0, splines - 2), [1.0] * 3])
    spline = BSpline(knots, np.eye(splines), 3)(place).T
    turn = np.radians(ANGLES - 90.0)
    names, values = [], []
    for order in range(orders):
        around = np.cos(order * turn)
        for k in range(splines - (order == 0)):
            value = spline[k][:, None] * around
            names.append(f"shape {k + 1} cos {order}")
            values.append(value - value.mean())  # Eq. (V2)
    return tuple(names), np.array(values)
