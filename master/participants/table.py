"""Signal table as a participant: columns of a CSV file over time as outputs.

The first line contains the names of the columns with units in brackets: `time [s], speed [rpm],
lift [mm]`. The first column is the time. Outputs are in SI. `true` and `false` are 1 and 0.
"""

import re
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np

from ..fmi.errors import BadInput, file_fault
from ..fmi.fields import Field
from ..fmi.quantities import is_known, pint_unit, powers_of, registry
from ..fmi.separated import read_rows
from .interpolated import slope_of
from .participant import StartedInHalves
from .plain import pack, unpack

HEAD = re.compile(r"\s*(?P<name>[^\[\]]*?)\s*(?:\[(?P<unit>[^\[\]]*)\])?\s*")
KINDS = ("hold", "linear", "cubic")
TYPES = {"Integer": int, "Enumeration": int, "Boolean": bool}
"""Types that a column can have instead of Real."""
WORDS = {"true": "1", "false": "0"}


class TableParticipant(StartedInHalves):
    """Participant with outputs by interpolation in a table, at the end of every step.

    hold : the value of the last row that is not later; linear : between rows; cubic : the cubic
    spline through all rows (not-a-knot), with the slope of each column as an output `der(NAME)`.

    Parameters
    ----------
    name : str
        Name in the system.
    path : Path
        The CSV file.
    kind : {"hold", "linear", "cubic"}

    Raises
    ------
    BadInput
        With every fault of the file.
    """

    can_redo = can_serialise = declares_units = True
    can_interpolate = has_derivatives = False

    def __init__(self, name, path, kind):
        self.name, self.path, self.kind = name, Path(path), kind
        try:
            names, units, self.times, columns = read_table(self.path)
        except BadInput as error:
            raise BadInput([f"table: {line}" for line in error.faults]) from None
        if kind == "cubic" and len(self.times) < 4:
            got = len(self.times)
            raise BadInput(f"table: {path}: expected at least four rows for cubic, got {got}")
        self.fields = {}
        self.columns = {}
        self.rows = dict(zip(names, columns))
        for column, unit, values in zip(names, units, columns):
            self._add(column, unit, values, f"column {column} of {self.path.name}")
        if kind == "cubic":
            from scipy.interpolate import CubicSpline  # slow to import, and few tables are cubic

            for column, unit in list(zip(names, units)):
                spline = CubicSpline(self.times, self.columns[column])
                self.columns[column] = spline
                slope = _field(slope_of(column), f"{unit}/s", f"slope of {column}", column)
                self.fields[slope.name] = slope
                self.columns[slope.name] = spline.derivative()
        self.now = 0.0

    def _add(self, column, unit, values, description):
        self.fields[column] = _field(column, unit, description)
        self.columns[column] = values

    def give_type(self, column, kind):
        """Give a column the type of the input on its wire. It then holds the value of a row.

        Parameters
        ----------
        column : str
        kind : {"Integer", "Enumeration", "Boolean"}

        Raises
        ------
        BadInput
            If the values are not of that type.
        """
        convert = TYPES[kind]
        wrong = [value for value in self.rows[column].tolist() if convert(value) != value]
        if wrong:
            expected = "0 and 1, or false and true" if kind == "Boolean" else "whole numbers"
            raise BadInput(f"{self.path}, column {column}: expected {expected}, got {wrong[0]:g}")
        self.fields[column] = replace(self.fields[column], type=kind)

    def enter(self, parameters, start_time, stop_time):
        """Run the first half of `start`; raise `BadInput` if the table does not cover the time."""
        first, last = self.times[0], self.times[-1]
        spare = 1e-9 * (stop_time - start_time)
        if start_time < first - spare or (self.kind != "hold" and stop_time > last + spare):
            raise BadInput(
                f"participants.{self.name}.table: expected times from {start_time:g} s to "
                f"{stop_time:g} s, got {first:g} s to {last:g} s in {self.path.name}"
            )
        self.now = start_time

    def leave(self):
        """Do nothing, as the second half of `start`."""

    def set(self, name, value):
        """Raise `KeyError`, because there are no inputs."""
        raise KeyError(name)

    def get(self, name):
        """Return an output at the current time."""
        values = self.columns[name]
        convert = TYPES.get(self.fields[name].type)
        if self.kind == "hold" or convert:
            now = self.now + 1e-12 * abs(self.now)
            row = np.searchsorted(self.times, now, side="right") - 1
            return (convert or float)(self.rows[name][max(row, 0)])
        if self.kind == "cubic":
            return float(values(self.now))
        return float(np.interp(self.now, self.times, values))

    def get_many(self, names):
        """Return the values of several outputs by name."""
        return {name: self.get(name) for name in names}

    def step(self, time, step):
        """Move to the end of a step."""
        self.now = time + step

    def save(self):
        """Return the current time."""
        return self.now

    def restore(self, saved):
        """Restore a saved time."""
        self.now = saved

    def free(self, saved):
        """Do nothing, because there is nothing to free."""

    def serialise(self, saved):
        """Return the saved state as bytes."""
        return pack(saved)

    def deserialise(self, data):
        """Return the state in bytes of `serialise`."""
        return unpack(data)

    def derivative(self, seeds, products):
        """Return zero, because nothing depends on an input."""
        return {name: np.zeros(()) for name in products}

    def close(self):
        """Do nothing, because there is nothing to close."""


def _field(name, unit, description, derivative_of=None):
    """Return the field of an output."""
    none = None, None, None, None
    return Field(name, (), (), "Real", "output", unit, *none, description, derivative_of)


def read_table(path):
    """Return names and SI units of the columns after the first, times [s], and columns in SI.

    Raises `BadInput` with every fault of the file.
    """
    try:
        rows = read_rows(path)
    except (OSError, UnicodeDecodeError) as error:
        raise BadInput(file_fault(path, error)) from None
    if len(rows) < 3:
        got = f"{len(rows)} lines" if rows else "an empty file"
        raise BadInput(f"{path}: expected a line of names and at least two rows, got {got}")
    (_, head), *body = rows
    faults = []
    named = [_column(path, cell, faults) for cell in head]
    names = [name for name, _ in named]
    faults += [
        f"{path}: expected different names, got {n!r} twice"
        for n in set(names)
        if names.count(n) > 1
    ]
    table = _numbers(path, body, len(head), faults)
    if faults:
        raise BadInput(faults)
    columns = [
        registry().Quantity(values, pint_unit(unit)).to_base_units()
        for values, (_, unit) in zip(table.T, named)
    ]
    times, *others = [column.magnitude for column in columns]
    unit, *units = [_si(column.units) for column in columns]
    if unit != "s":
        got = "no unit" if unit == "1" else unit
        faults.append(f"{path}: expected 'time [s]' as the first column, got {head[0]!r}, {got}")
    faults += [
        f"{path}, row {body[k + 1][0]}: expected a time after {body[k][1][0].strip()}, got "
        f"{body[k + 1][1][0].strip()}"
        for k in np.flatnonzero(np.diff(times) <= 0)
    ]
    if not others:
        faults.append(f"{path}: expected a column after the time, got none")
    if faults:
        raise BadInput(faults)
    return names[1:], units, times, others


def _si(unit):
    """Return a unit of SI base units as FMI writes it."""
    powers = sorted(powers_of(unit).items())
    return ".".join(f"{name}{'' if power == 1 else power}" for name, power in powers) or "1"


def _column(path, cell, faults):
    """Return name and unit of a column."""
    match = HEAD.fullmatch(cell)
    if not match or not match["name"]:
        faults.append(f"{path}: expected NAME or NAME [unit], got {cell!r}")
        return "", "1"
    unit = match["unit"] or "1"
    if not is_known(unit):
        faults.append(f"{path}, column {match['name']}: expected a known unit, got {unit!r}")
    return match["name"], unit


def _numbers(path, rows, width, faults):
    """Return the rows as an array; add the fault of each row that is not valid."""
    table = np.zeros((len(rows), width))
    for k, (number, row) in enumerate(rows):
        values = []
        with suppress(ValueError):
            values = [float(WORDS.get(cell.strip().lower()) or cell) for cell in row]
        if len(values) == width and np.isfinite(values).all():
            table[k] = values
        else:
            expected = f"{width} finite numbers"
            faults.append(f"{path}, row {number}: expected {expected}, got {', '.join(row)!r}")
    return table
