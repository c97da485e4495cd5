"""Tables from files or from the case itself: gas pressure over crank angle, measured profiles; what
both share with others.
"""

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np


class TableFault(ValueError):
    """A table that cannot be used; the message names file, row and value."""


class Rows(NamedTuple):
    """Numbers of a table as the user gave it: its name, and for each row where it stands and its
    values.
    """

    name: str
    places: list
    values: list


def read_numbers(path, corner=False):
    """Rows of numbers of a comma or semicolon separated file; text rows at its top are skipped.

    Parameters
    ----------
    path : Path
    corner : bool
        The very first cell names rows or columns and is not read.

    Returns
    -------
    Rows

    Raises
    ------
    TableFault
        At the first later row that is not all numbers.
    """
    text, rows = Path(path).read_text(), Rows(str(path), [], [])
    for number, cells in enumerate(
        csv.reader(text.splitlines(), delimiter=";" if ";" in text else ","), 1
    ):
        cells = [
            cell.strip()
            for cell in (cells[1:] if corner and number == 1 else cells)
            if cell.strip()
        ]
        try:
            values = [float(cell) for cell in cells]
            finite = bool(np.isfinite(values).all())
        except ValueError:
            finite = False
        if not finite:
            if not rows.values:
                continue
            raise TableFault(
                f"{path}, line {number}: {','.join(cells)!r} is not a row of numbers"
            ) from None
        if values:
            rows.places.append(f"{path}, line {number}")
            rows.values.append(values)
    if not rows.values:
        raise TableFault(f"{path}: no row of numbers")
    return rows


def inline_numbers(name, points):
    """Rows of a table that stands in the case file itself."""
    return Rows(
        name,
        [f"{name}, row {k}" for k in range(1, len(points) + 1)],
        [list(point) for point in points],
    )


def two_columns(rows, first, second, first_unit, second_unit):
    """Two columns in SI, the first rising.

    Parameters
    ----------
    rows : Rows
    first, second : str
        What the columns hold.
    first_unit, second_unit : float
        What 1 means.

    Returns
    -------
    ndarray, shape (2, n)

    Raises
    ------
    TableFault
        At the row that has another number of columns, or whose first value does not rise.
    """
    for place, values in zip(rows.places, rows.values):
        if len(values) != 2:
            raise TableFault(
                f"{place}: {len(values)} columns where {first} and {second} are needed"
            )
    columns = np.array(rows.values).T
    bad = np.flatnonzero(np.diff(columns[0]) <= 0)
    if len(bad):
        raise TableFault(
            f"{rows.places[bad[0] + 1]}: {first} {columns[0, bad[0] + 1]:g} does not rise"
        )
    return columns * [[first_unit], [second_unit]]


def closed(rows, angle, value, cycle, what):
    """A table over exactly one cycle, its last value the first.

    Parameters
    ----------
    rows : Rows
        Where it comes from.
    angle, value : ndarray, shape (n,)
    cycle : float
        [rad]
    what : str
        Name of the value, with its unit.

    Returns
    -------
    angle, value : ndarray

    Raises
    ------
    TableFault
        Where angles do not span the cycle, or the ends differ by more than 1 % of the range.
    """
    span, step = angle[-1] - angle[0], np.diff(angle).max(initial=0.0)
    if not cycle - 1.5 * step <= span <= cycle * (1 + 1e-9):
        raise TableFault(
            f"{rows.name}: spans {np.degrees(span):g} deg of a cycle of {np.degrees(cycle):g} deg"
        )
    if span < cycle * (1 - 1e-9):
        angle, value = np.append(angle, angle[0] + cycle), np.append(value, value[0])
    if abs(value[-1] - value[0]) > 0.01 * np.ptp(value):
        raise TableFault(
            f"{rows.name}: does not close: {what.format(value[0])} at the start and {what.format(value[-1])} one "
            "cycle later"
        )
    value[-1] = value[0]
    return angle, value


def gas_table(rows, cycle, angle_unit, pressure_unit):
    """Gas pressure over one cycle, two columns: crank angle and gauge pressure.

    Parameters
    ----------
    rows : Rows
    cycle : float
        Angle after which the pressure repeats [rad]: 4 pi four-stroke, 2 pi two-stroke.
    angle_unit, pressure_unit : float
        What 1 in the table means [rad], [Pa].

    Returns
    -------
    dict
        angle, pressure (lists, SI) over exactly one cycle, first pressure = last; cycle.

    Raises
    ------
    TableFault
        Where angles do not rise, do not span the cycle, or the ends differ by more than 1 % of the
        range: a jump no gas makes.
    """
    angle, pressure = closed(
        rows,
        *two_columns(rows, "crank angle", "pressure", angle_unit, pressure_unit),
        cycle,
        "pressure {:g} Pa",
    )
    return {"angle": angle.tolist(), "pressure": pressure.tolist(), "cycle": float(cycle)}


def gas_pressure(table, crank_angle):
    """Pressure of a `gas_table` at a crank angle [rad], linear between its points [Pa]."""
    first = table["angle"][0]
    return float(
        np.interp((crank_angle - first) % table["cycle"] + first, table["angle"], table["pressure"])
    )


def profile_table(path, angle_unit, height_unit, value_unit):
    """Shape over angle and height: the first row holds the angles (its first cell is not read),
    each later one a height and its values.

    Returns
    -------
    dict
        angle, height, value (lists, SI) as `profile.table_shape` takes them.

    Raises
    ------
    TableFault
        Where rows differ in length, or angles or heights do not rise or exceed one turn.
    """
    rows = read_numbers(path, corner=True)
    head, *body = rows.values
    for place, values in zip(rows.places[1:], body):
        if len(values) != len(head) + 1:
            raise TableFault(f"{place}: {len(values)} numbers where {len(head) + 1} are needed")
    if not body:
        raise TableFault(
            f"{path}: the first row must hold the angles, the others a height and one value an angle"
        )
    angle = np.array(head) * angle_unit
    height = np.array([values[0] for values in body]) * height_unit
    for name, line in (("angles", angle), ("heights", height)):
        if np.any(np.diff(line) <= 0):
            raise TableFault(f"{path}: {name} do not rise")
    if np.ptp(angle) >= 2 * np.pi * (1 - 1e-12):
        raise TableFault(f"{path}: angles span a full turn or more; leave the repeated one out")
    return {
        "angle": angle.tolist(),
        "height": height.tolist(),
        "value": (np.array([values[1:] for values in body]) * value_unit).tolist(),
    }
