"""Tables that a build table names besides the bodies, read before any long computation."""

from collections.abc import Callable
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from ..master.fmi.errors import BadInput, for_all
from ..master.fmi.quantities import to_si
from .body_options import ShapeTable
from .dynamics.build_options import WallTemperature, WallTemperatures
from .dynamics.parameters import REFERENCE
from .dynamics.speed_table import SpeedTable, speed_table
from .dynamics.start_state import StartState, read_start
from .dynamics.tables import GasTable, Rows, gas_table, inline_numbers, profile_table, read_numbers
from .geometry.profile import MeasuredShape
from .options import Bodies, Build, Gas, Speed
from .reduction.reduced_body import ReducedBlock, load
from .temperature_options import HIGHEST, LOWEST, Wall

Given = TypeVar("Given")
Table = TypeVar("Table")


class Tables(NamedTuple):
    """Everything that a build table names besides the bodies, read."""

    skirt: tuple[MeasuredShape, ...]
    bore: tuple[MeasuredShape, ...]
    gas: GasTable | None
    speed: SpeedTable | None
    start: StartState | None
    temperatures: WallTemperatures | None = None


NO_TABLES = Tables((), (), None, None, None)


def read_tables(build: Bodies) -> Tables:
    """Read all tables before any long computation, with every fault in one message."""
    faults = []

    def tried(read: Callable[[Given], Table], source: Given) -> Table | None:
        try:
            return read(source)
        except ValueError as error:
            faults.append(str(error))
            return None

    piston, block = build.piston, build.block
    skirt = [tried(_shape, table) for table in (piston.profiles if piston else ())]
    bore = [tried(_shape, table) for table in (block.profiles if block else ())]
    tables = Tables(
        skirt=tuple(shape for shape in skirt if shape),
        bore=tuple(shape for shape in bore if shape),
        gas=tried(_gas, build.gas) if build.gas else None,
        speed=tried(_speed, build.speed) if build.speed else None,
        start=tried(read_start, build.start) if build.start else None,
        temperatures=tried(read_temperatures, build) if isinstance(build, Build) else None,
    )
    if faults:
        raise BadInput(faults)
    return tables


def _shape(table: ShapeTable) -> MeasuredShape:
    return profile_table(table.file, table.angle_unit, table.height_unit, table.value_unit)


def _rows(name: str, table: Gas | Speed, keys: dict[str, str]) -> Rows:
    """Return the numbers of a table in a file or in the case.

    keys : SI unit of the key of each column. Raises `ValueError` if a unit in the header of the
    file contradicts its key.
    """
    if not table.file:
        return inline_numbers(f"{name}.points", table.points or [])
    rows = read_numbers(table.file)
    for cell, (key, si) in zip(rows.head, keys.items()):
        unit = cell.partition("[")[2].partition("]")[0]
        try:
            size = getattr(table, key) / to_si(f"1 {unit}", si)
        except ValueError:  # no unit, or a word such as [gauge]
            continue
        if not 0.5 < size < 2.0:  # a key such as "1.1 MPa" scales a trace
            expected = f"{key} near '1 {unit}' as in the header"
            raise ValueError(f"{table.file}: expected {expected}, got '{size:.3g} {unit}'")
    return rows


def _gas(table: Gas) -> GasTable:
    rows = _rows("gas", table, {"angle_unit": "rad", "pressure_unit": "Pa"})
    cycle = pi * table.strokes
    return gas_table(rows, cycle, table.angle_unit, table.pressure_unit)


def _speed(table: Speed) -> SpeedTable:
    cycle = pi * table.strokes
    unit = table.time_unit or table.angle_unit
    assert unit  # one of the two is given
    over, si = ("time", "s") if table.time_unit else ("angle", "rad")
    rows = _rows("speed", table, {f"{over}_unit": si, "speed_unit": "rad/s"})
    return speed_table(rows, over, cycle, unit, table.speed_unit)


ZEROS = {"K": 0.0, "degC": 273.15}
"""Zero of a unit of temperature [K]."""


def read_temperatures(build: Build) -> WallTemperatures | None:
    """Return the temperatures of skirt and bore of a build table, with tables from their files.

    Raises
    ------
    BadInput
        If a table is missing values, or has one out of range.
    """
    temperatures = build.temperatures
    if temperatures is None:
        return None
    walls = ("skirt", temperatures.skirt), ("bore", temperatures.bore)
    skirt, bore = for_all(lambda wall: _wall(*wall), walls)
    stations = build.block.stations
    if build.block.reduced:
        stations = len(load(ReducedBlock, Path(build.block.reduced)).heights)
    return WallTemperatures(skirt, bore, stations)


def _wall(name: str, wall: Wall) -> WallTemperature:
    """Return the temperature of a wall: its level, and the difference of each part from it."""
    if wall.input:
        return WallTemperature(REFERENCE, varies=True)
    if wall.edges:
        lower, upper = wall.edges
        return WallTemperature((lower + upper) / 2, rise=upper - lower)
    if wall.value is not None:
        return WallTemperature(wall.value)
    assert wall.file and wall.angle_unit and wall.height_unit and wall.temperature_unit
    where = f"temperatures.{name}.file"
    try:
        table = profile_table(wall.file, wall.angle_unit, wall.height_unit, 1.0)
    except ValueError as error:
        raise BadInput(f"{where}: {error}") from None
    value = table.value + ZEROS[wall.temperature_unit]
    out = (value < LOWEST) | (value > HIGHEST)
    if out.any():
        row, column = np.argwhere(out)[0]
        raise BadInput(
            f"{where}: expected {LOWEST:g} to {HIGHEST:g} K, got {value[row, column]:g} K at "
            f"{np.degrees(table.angle[column]):g} deg, {1e3 * table.height[row]:g} mm in "
            f"{wall.file}; check temperature_unit"
        )
    level = float(value.mean())
    return WallTemperature(level, table=replace(table, value=value - level))
