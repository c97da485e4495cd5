"""Tables from files or from the case: gas pressure over crank angle, measured profiles."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ...master.fmi.errors import file_fault
from ...master.fmi.separated import read_rows
from ..geometry.profile import MeasuredShape

WIDEST_GAP = 4.0
"""Largest gap between angles of a profile, relative to the usual one. A spline over a wider gap is
arbitrary."""

POSSIBLE_GAS = -0.101325e6, 100e6
"""Gauge pressures of a gas table [Pa]: from a vacuum to far above those of engines."""


class TableFault(ValueError):
    """A table that cannot be used; the message names file, row and value."""


class Rows(NamedTuple):
    """Numbers of a table as the user gave it: its name, names of rows, values, last text row."""

    name: str
    row_names: list[str]
    values: list[list[float]]
    head: Sequence[str] = ()


class Column(NamedTuple):
    """Quantity of a column, and the SI value of 1 in it."""

    name: str
    unit: float


class GasTable(NamedTuple):
    """Gauge pressure of the gas over exactly one cycle; empty if there is none.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        Crank angle, rising by `cycle` from the first to the last [rad].
    pressure : ndarray, shape (n,)
        [Pa], the last is the first.
    cycle : float
        [rad]
    """

    angle: Annotated[np.ndarray, "points"]
    pressure: Annotated[np.ndarray, "points"]
    cycle: float


def read_numbers(path: Path | str, corner: bool = False) -> Rows:
    """Read rows of numbers of a separated file, without text rows at its top.

    Parameters
    ----------
    path : Path
    corner : bool
        The first row of numbers has a first cell that names rows or columns and is not read.

    Returns
    -------
    Rows

    Raises
    ------
    TableFault
        At the first row that is not all numbers, but begins with one or follows a row of numbers.
    """
    try:
        lines = read_rows(path)
    except (OSError, UnicodeDecodeError) as error:
        raise TableFault(file_fault(path, error)) from None
    rows = Rows(str(path), [], [], head := [])
    for number, line in lines:
        if corner and not rows.values:
            line = line[1:]
        cells = [cell.strip() for cell in line if cell.strip()]
        values = _finite_numbers(cells)
        if values is None and (rows.values or _finite_numbers(cells[:1])):
            wrong = next(cell for cell in cells if _finite_numbers([cell]) is None)
            raise TableFault(f"{path}, line {number}: expected numbers, got {wrong!r}")
        if values is None:
            head[:] = cells
        if values:
            rows.row_names.append(f"{path}, line {number}")
            rows.values.append(values)
    if not rows.values:
        raise TableFault(f"{path}: expected rows of numbers, got none")
    return rows


def _finite_numbers(cells: list[str]) -> list[float] | None:
    """Return cells as numbers, None unless all are finite."""
    try:
        values = [float(cell) for cell in cells]
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None


def inline_numbers(name: str, points: Sequence[Sequence[float]]) -> Rows:
    """Return the rows of a table in the case file."""
    row_names = [f"{name}, row {k}" for k in range(1, len(points) + 1)]
    return Rows(name, row_names, [list(point) for point in points])


def two_columns(rows: Rows, first: Column, second: Column) -> np.ndarray:
    """Return two columns in SI, the first rising.

    Parameters
    ----------
    rows : Rows
    first, second : Column

    Returns
    -------
    ndarray, shape (2, n)

    Raises
    ------
    TableFault
        At the row that has another number of columns, or whose first value does not rise.
    """
    for row_name, values in zip(rows.row_names, rows.values):
        if len(values) != 2:
            raise TableFault(
                f"{row_name}: expected two numbers, {first.name} and {second.name}, "
                f"got {len(values)}; decimal commas need ; or tabs between columns"
            )
    columns = np.array(rows.values).T
    bad = np.flatnonzero(np.diff(columns[0]) <= 0) + 1
    if len(bad):
        raise TableFault(
            f"{rows.row_names[bad[0]]}: expected {first.name} above "
            f"{columns[0, bad[0] - 1]:g}, got {columns[0, bad[0]]:g}"
        )
    return columns * [[first.unit], [second.unit]]


def closed(
    rows: Rows, angle: np.ndarray, value: np.ndarray, cycle: float, in_words: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return a table over exactly one cycle, whose last value equals the first.

    Parameters
    ----------
    rows : Rows
        Rows of the table, for messages.
    angle, value : ndarray, shape (n,)
    cycle : float
        [rad]
    in_words : str
        Format of a value: name, {} for the number, unit.

    Returns
    -------
    angle, value : ndarray

    Raises
    ------
    TableFault
        Where angles do not span the cycle, or the ends differ by more than 1 % of the range.
    """
    span = angle[-1] - angle[0]
    # two rows do not show the step that the end lacks
    widest_step = np.diff(angle).max(initial=0.0) if len(angle) > 2 else 0.0
    if not cycle * (1 - 1e-9) - 1.5 * widest_step <= span <= cycle * (1 + 1e-9):
        raise TableFault(
            f"{rows.name}: expected a cycle of {np.degrees(cycle):g} deg, "
            f"got {np.degrees(span):g} deg; check angle_unit and strokes"
        )
    if span < cycle * (1 - 1e-9):
        angle = np.append(angle, angle[0] + cycle)
        value = np.append(value, value[0])
    if abs(value[-1] - value[0]) > 0.01 * np.ptp(value):
        raise TableFault(
            f"{rows.name}: expected {in_words.format(value[0])} at the end as at the start, "
            f"got {in_words.format(value[-1])}"
        )
    value[-1] = value[0]
    return angle, value


def gas_table(rows: Rows, cycle: float, angle_unit: float, pressure_unit: float) -> GasTable:
    """Return the gas pressure over one cycle from crank angle and gauge pressure.

    Parameters
    ----------
    rows : Rows
    cycle : float
        Angle after which the pressure repeats [rad]: 4 pi four-stroke, 2 pi two-stroke.
    angle_unit, pressure_unit : float
        Size of 1 in the table [rad], [Pa].

    Returns
    -------
    GasTable

    Raises
    ------
    TableFault
        Where angles do not rise, do not span the cycle, or the ends differ by more than 1 % of the
        range: a jump no gas makes. Also if a pressure is below a vacuum or far above engines.
    """
    columns = two_columns(
        rows, Column("crank angle", angle_unit), Column("pressure", pressure_unit)
    )
    angle, pressure = columns
    angle, pressure = closed(rows, angle, pressure, cycle, "pressure {:g} Pa")
    low, high = POSSIBLE_GAS
    for extreme in (pressure.min(), pressure.max()):
        if not low <= extreme <= high:
            raise TableFault(
                f"{rows.name}: expected gauge pressures from {1e-6 * low:g} to {1e-6 * high:g} "
                f"MPa, got {1e-6 * extreme:g} MPa; check pressure_unit"
            )
    return GasTable(angle, pressure, float(cycle))


@compilable
def gas_pressure(table: GasTable, crank_angle: float) -> float:
    """Return the gas pressure at a crank angle [rad], linear between the points [Pa]."""
    first = table.angle[0]
    within = (crank_angle - first) % table.cycle + first
    return float(np.interp(within, table.angle, table.pressure))


def profile_table(
    path: Path | str, angle_unit: float, height_unit: float, value_unit: float
) -> MeasuredShape:
    """Read a shape over angle and height.

    The first row holds the angles, and its first cell is not read. Each further row holds a height
    and its values.

    Parameters
    ----------
    path : Path
    angle_unit, height_unit, value_unit : float
        Size of 1 in the file [rad], [m], [m].

    Returns
    -------
    MeasuredShape

    Raises
    ------
    TableFault
        Where rows differ in length, or angles or heights do not rise or exceed one turn.
    """
    rows = read_numbers(path, corner=True)
    head, *body = rows.values
    for row_name, values in zip(rows.row_names[1:], body):
        if len(values) != len(head) + 1:
            raise TableFault(
                f"{row_name}: expected {len(head) + 1} numbers, a height and {len(head)} values, "
                f"got {len(values)}; the first cell of the angles is not read"
            )
    if not body:
        raise TableFault(
            f"{path}: expected a row of angles and rows of a height and values, got one row"
        )
    if len(body) > 1 and body[0][0] > body[-1][0]:  # from the top to the bottom
        rows.row_names[1:], body = rows.row_names[:0:-1], body[::-1]
    for name, places, line in (
        ("an angle", [rows.row_names[0]] * len(head), head),
        ("a height", rows.row_names[1:], [values[0] for values in body]),
    ):
        for place, before, after in zip(places[1:], line, line[1:]):
            if after <= before:
                raise TableFault(f"{place}: expected {name} above {before:g}, got {after:g}")
    angle = np.array(head) * angle_unit
    height = np.array([values[0] for values in body]) * height_unit
    if np.ptp(angle) >= 2 * np.pi * (1 - 1e-12):
        raise TableFault(
            f"{path}: expected angles below a full revolution, got {np.degrees(np.ptp(angle)):.6g} "
            "deg; remove a repeated angle, or check angle_unit"
        )
    gaps = np.diff(angle, append=angle[0] + 2 * np.pi)
    if gaps.max() > WIDEST_GAP * np.median(gaps):
        raise TableFault(
            f"{path}: expected gaps near {np.degrees(np.median(gaps)):g} deg between angles, got "
            f"{np.degrees(gaps.max()):g} deg; a table covers a full revolution; check angle_unit"
        )
    return MeasuredShape(angle, height, np.array([values[1:] for values in body]) * value_unit)
