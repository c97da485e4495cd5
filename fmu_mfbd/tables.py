"""Tables from files: gas pressure over crank angle, measured profiles."""

import csv
from pathlib import Path

import numpy as np


class TableFault(ValueError):
    """A table that cannot be used; the message names file, row and value."""


def read_numbers(path, corner=False):
    """Rows of numbers of a comma or semicolon separated file; text rows at its top are skipped.

    Parameters
    ----------
    path : Path
    corner : bool
        The very first cell names rows or columns and is not read.

    Returns
    -------
    list of (int, list of float)
        Line number and its values.

    Raises
    ------
    TableFault
        At the first later row that is not all numbers.
    """
    text = Path(path).read_text()
    rows = []
    for number, cells in enumerate(csv.reader(text.splitlines(), delimiter=";" if ";" in text else ","), 1):
        cells = [cell.strip() for cell in (cells[1:] if corner and number == 1 else cells) if cell.strip()]
        try:
            values = [float(cell) for cell in cells]
        except ValueError:
            if not rows:
                continue
            raise TableFault(f"{path}, line {number}: {','.join(cells)!r} is not a row of numbers") from None
        if values:
            rows.append((number, values))
    if not rows:
        raise TableFault(f"{path}: no row of numbers")
    return rows


def gas_table(path, cycle, angle_unit, pressure_unit):
    """Gas pressure over one cycle, two columns: crank angle and gauge pressure.

    Parameters
    ----------
    path : Path
    cycle : float
        Angle after which the pressure repeats [rad]: 4 pi four-stroke, 2 pi two-stroke.
    angle_unit, pressure_unit : float
        What 1 in the file means [rad], [Pa].

    Returns
    -------
    dict
        angle, pressure (lists, SI) over exactly one cycle, first pressure = last; cycle.

    Raises
    ------
    TableFault
        Where angles do not rise, do not span the cycle, or the ends differ by more than 1 % of the range: a jump no gas makes.
    """
    rows = read_numbers(path)
    for number, values in rows:
        if len(values) != 2:
            raise TableFault(f"{path}, line {number}: {len(values)} columns where crank angle and pressure are needed")
    angle, pressure = np.array([values for _, values in rows]).T * [[angle_unit], [pressure_unit]]
    bad = np.flatnonzero(np.diff(angle) <= 0)
    if len(bad):
        raise TableFault(f"{path}, line {rows[bad[0] + 1][0]}: crank angle {rows[bad[0] + 1][1][0]:g} does not rise")
    span, step = angle[-1] - angle[0], np.diff(angle).max(initial=0.0)
    if not cycle - 1.5 * step <= span <= cycle * (1 + 1e-9):
        raise TableFault(f"{path}: spans {np.degrees(span):g} deg of a cycle of {np.degrees(cycle):g} deg")
    if span < cycle * (1 - 1e-9):
        angle, pressure = np.append(angle, angle[0] + cycle), np.append(pressure, pressure[0])
    if abs(pressure[-1] - pressure[0]) > 0.01 * np.ptp(pressure):
        raise TableFault(f"{path}: does not close: pressure {pressure[0]:g} Pa at the start and "
                         f"{pressure[-1]:g} Pa one cycle later")
    pressure[-1] = pressure[0]
    return {"angle": angle.tolist(), "pressure": pressure.tolist(), "cycle": float(cycle)}


def gas_pressure(table, crank_angle):
    """Pressure of a `gas_table` at a crank angle [rad], linear between its points [Pa]."""
    first = table["angle"][0]
    return float(np.interp((crank_angle - first) % table["cycle"] + first, table["angle"], table["pressure"]))


def profile_table(path, angle_unit, height_unit, value_unit):
    """Shape over angle and height: the first row holds the angles (its first cell is not read), each later one a height and its
    values.

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
    head, width = rows[0][1], len(rows[0][1]) + 1
    for number, values in rows[1:]:
        if len(values) != width:
            raise TableFault(f"{path}, line {number}: {len(values)} numbers where {width} are needed")
    if len(rows) < 2:
        raise TableFault(f"{path}: the first row must hold the angles, the others a height and one value an angle")
    angle = np.array(head) * angle_unit
    height = np.array([values[0] for _, values in rows[1:]]) * height_unit
    for name, line in (("angles", angle), ("heights", height)):
        if np.any(np.diff(line) <= 0):
            raise TableFault(f"{path}: {name} do not rise")
    if np.ptp(angle) >= 2 * np.pi * (1 - 1e-12):
        raise TableFault(f"{path}: angles span a full turn or more; leave the repeated one out")
    return {"angle": angle.tolist(), "height": height.tolist(),
            "value": (np.array([values[1:] for _, values in rows[1:]]) * value_unit).tolist()}
