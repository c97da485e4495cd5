"""Bearings of experiments and published studies: computed figures next to those of the source.

`models/measured/NAME` holds the inputs of a case (case.toml) and the figures (data.csv). Nothing
is fitted to them. A column of data.csv is an input or an entry of `QUANTITIES`. If the source does
not state the oil supply, the table `supplies` assumes several, and the result is the band over all.
"""

import csv
import functools
import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

import piston_cosim as pc
from piston_cosim.fmu_ehd import journal
from piston_cosim.fmu_ehd.common.grid import Array, Flags
from piston_cosim.fmu_mfbd.dynamics.bearing_shell import LoadedShell
from piston_cosim.fmu_mfbd.reduction.reduced_body import ShellFilm
from piston_cosim.fmu_mfbd.shell.build import elastic_shell
from piston_cosim.master.fmi.quantities import from_si, to_si
from piston_cosim.tests.verification.cases.elastic_parts import ShellModes, elastic_modes

FOLDER = Path(__file__).parents[3] / "models" / "measured"
ANGLE = "angle [deg]"
"""Column of the place of a value. It is not an input of a bearing."""
HEADS = ("case", "at", "quantity", "{}", "computed", "difference", "of the largest")
"""Heads of the table; the fourth one says whether the source measured or published the figure."""


class Figure(NamedTuple):
    """One figure of a source.

    case, status, source : as in case.toml; at : inputs; quantity, unit : what is compared;
    published, computed : in that unit; largest : of the published ones of the series.
    """

    case: str
    status: str
    source: str
    at: dict[str, str]
    quantity: str
    unit: str
    published: float
    computed: float
    largest: float

    @property
    def difference(self) -> float:
        """Distance over the published value [-]."""
        return self.computed / self.published - 1.0

    @property
    def share(self) -> float:
        """Distance over the largest published value of the series [-]."""
        return (self.computed - self.published) / self.largest


class Solved(NamedTuple):
    """Outputs of a bearing, its number on the shaft and its clearance [m].

    omega : [rad/s]; angle : where an output is compared, from x [rad].
    """

    outputs: dict[str, Any]
    count: int
    clearance: float
    omega: float
    angle: float


def torque(bearings: list[Solved]) -> float:
    """Return the torque that drives the shaft [N m]."""
    return sum(each.count * each.outputs["friction_power"] / each.omega for each in bearings)


def thinnest(bearings: list[Solved]) -> float:
    """Return the smallest film thickness of the first bearing [m]."""
    return float(bearings[0].outputs["minimum_film_thickness"])


def eccentricity(bearings: list[Solved]) -> float:
    """Return the eccentricity of the first bearing [-]."""
    first = bearings[0]
    return float(np.hypot(*first.outputs["position"]) / first.clearance)


def _in_the_middle(field: str):
    """Return a function for a field of the first bearing in its middle, at an angle."""

    def value(bearings: list[Solved]) -> float:
        first = bearings[0]
        values: Array = first.outputs[field]
        around, along = values.shape
        return float(values[round(first.angle / (2.0 * np.pi) * around) % around, along // 2])

    return value


def highest(bearings: list[Solved]) -> float:
    """Return the highest pressure in the middle of the first bearing [Pa]."""
    values: Array = bearings[0].outputs["pressure"]
    return float(values[:, values.shape[1] // 2].max())


def _stiffness(row: int, column: int):
    return lambda bearings: float(bearings[0].outputs["stiffness"][row][column])


QUANTITIES = {
    "friction_torque": (torque, "N.m"),
    "minimum_film_thickness": (thinnest, "m"),
    "eccentricity": (eccentricity, "1"),
    "pressure": (_in_the_middle("pressure"), "Pa"),
    "maximum_pressure_middle": (highest, "Pa"),
    "deflection": (_in_the_middle("deflection"), "m"),
    "stiffness_xx": (_stiffness(0, 0), "N/m"),
    "stiffness_xy": (_stiffness(0, 1), "N/m"),
    "stiffness_yx": (_stiffness(1, 0), "N/m"),
    "stiffness_yy": (_stiffness(1, 1), "N/m"),
}
"""What is compared: its function and its unit."""


def names() -> list[str]:
    """Return the names of the cases."""
    return sorted(path.parent.name for path in FOLDER.glob("*/data.csv"))


def case_of(name: str) -> dict[str, Any]:
    """Return the inputs of a case."""
    return tomllib.loads((FOLDER / name / "case.toml").read_text())


def figures(
    name: str,
    film: dict[str, Any] | None = None,
    supply: dict[str, Any] | None = None,
    **only: str,
) -> Iterator[Figure]:
    """Yield the figures of a case, in the rows of data.csv whose inputs are as in `only`.

    `film` replaces parameters of the film, and `supply` adds the oil supply of its bearings.
    """
    tree = case_of(name)
    tree["film"] |= film or {}
    tree["bearings"] = [one | (supply or {}) for one in tree["bearings"]]
    with (FOLDER / name / "data.csv").open() as lines:
        rows = list(csv.DictReader(lines))
    solved, last = [], {}
    for row in rows:
        cells = {head.split(" [")[0]: cell for head, cell in row.items()}
        if any(cells[key] != value for key, value in only.items()):
            continue
        at = {head: cell for head, cell in row.items() if head.split(" [")[0] not in QUANTITIES}
        if (inputs := {head: cell for head, cell in at.items() if head != ANGLE}) != last:
            solved, last = [bearing(tree, one, inputs) for one in tree["bearings"]], inputs
        angle = to_si(f"{at.get(ANGLE, 0)} deg", "rad")
        for head, cell in row.items():
            quantity, _, unit = head.removesuffix("]").partition(" [")
            if quantity not in QUANTITIES or not cell:
                continue
            compute, si = QUANTITIES[quantity]
            value = compute([each._replace(angle=angle) for each in solved])
            series = [
                abs(float(other[head]))
                for other in rows
                if other[head] and other.get("load [N]") == row.get("load [N]")
            ]
            yield Figure(
                name,
                tree["status"],
                tree["source"],
                at,
                quantity,
                unit,
                float(cell),
                value if unit == "1" else from_si(value, si, unit),
                max(series),
            )


def bands(name: str, film: dict[str, Any] | None = None) -> dict[str, list[Figure]]:
    """Return supply -> figures of a case; a case with a known supply has one, without a name."""
    supplies = case_of(name).get("supplies", {"": None})
    return {key: list(figures(name, film, supply)) for key, supply in supplies.items()}


def bearing(tree: dict[str, Any], one: dict[str, Any], at: dict[str, str]) -> Solved:
    """Return the steady outputs of a bearing of a case.

    It carries its share of the load, or has a given eccentricity.
    """

    def given(key: str, unit: str) -> float:
        head = next((head for head in at if head.startswith(f"{key} [")), None)
        return to_si(one[key] if head is None else f"{at[head]} {head.split('[')[1][:-1]}", unit)

    around, along = one["grid"]
    degrees = 360.0 / around * np.arange(around)
    parameters: dict[str, Any] = tree["film"] | one["film"]
    length = to_si(parameters["skirt_length"], "m")
    height = length * ((np.arange(along) + 0.5) / along - 0.5)
    cells = np.zeros((around, along), dtype=bool)
    for opening in one["openings"]:
        first, last = (np.degrees(to_si(angle, "rad")) for angle in opening["angles"])
        cells |= _within(degrees, first, last, height, to_si(opening["middle"], "m"))
    clearance = given("clearance", "m")
    free = np.full((around, along), clearance)
    if "pocket_start" in one:
        ends = np.degrees([to_si(one["pocket_start"], "rad"), given("pocket_end", "rad")])
        width = length * float(at["pocket_width [1]"])
        free[_within(degrees, *ends, height, width) & ~cells] += given("pocket_depth", "m")
    speed = given("speed", "rad/s")
    oil = pc.Film((around, along), surface="bearing", open_cells=cells, **parameters)
    surface = speed * to_si(parameters["bore_radius"], "m")
    if "eccentricity" in one:
        angle = to_si(one["direction"], "rad")
        place = one["eccentricity"] * clearance * np.array([np.cos(angle), np.sin(angle)])
        thickness = journal.gap(free, place, oil.grid)
        shells = [_modes("diaphragm", json.dumps(one))] if at["shell"] == "elastic" else []
        outputs = oil.equilibrium(None, thickness, circumferential_velocity=surface, shells=shells)
        return Solved(outputs, one["count"], clearance, speed, 0.0)
    angle = to_si(one.get("direction", "270 deg"), "rad")
    load = one["load_share"] * given("load", "N") * np.array([np.cos(angle), np.sin(angle)])
    shells: list[journal.ElasticShell] = []
    if "shell" in one:
        build = one["shell"] | {"grid": one["grid"], "length": parameters["skirt_length"]}
        shells = [_shell(json.dumps(build))]
    if "journal" in one:
        shells.append(_modes("journal", json.dumps(one)))
    conditions = {"circumferential_velocity": surface} | one.get("conditions", {})
    outputs = oil.equilibrium(load, free, shells=shells, **conditions)
    return Solved(outputs, one["count"], clearance, speed, 0.0)


@functools.cache
def _shell(build: str) -> LoadedShell:
    """Return the elastic shell of a build table in JSON."""
    return elastic_shell(json.loads(build), FOLDER, progress=lambda text: None)


@functools.cache
def _modes(part: str, build: str) -> ShellModes:
    """Return the modes of diaphragm or journal of a bearing in JSON."""
    one = json.loads(build)
    radius, length = (to_si(one["film"][name], "m") for name in ("bore_radius", "skirt_length"))
    film = ShellFilm(tuple(one["grid"]), length, one[part]["modes"])
    return elastic_modes(part, one[part], radius, film)


def _within(degrees: Array, first: float, last: float, height: Array, width: float) -> Flags:
    """Return the cells between two angles, in the middle part of the bearing."""
    around = (degrees - first) % 360.0 < last - first - 1e-9
    return around[:, None] & (np.abs(height) < 0.5 * width)


def _shown(head: str, cell: str) -> str:
    """Return an input with its unit."""
    unit = head.partition(" [")[2].removesuffix("]")
    return cell if unit in ("", "1") else f"{cell} {unit}"


def _range(values: list[float], form: str) -> str:
    """Return a value, or the smallest and largest of several."""
    return " to ".join(dict.fromkeys(form.format(one) for one in (min(values), max(values))))


def verify_measured(console: Console, page: Path | None = None) -> None:
    """Print the figures of all cases, and write them to `page` if given."""
    heads = [head.format("measured or published") for head in HEADS]
    lines = [f"| {' | '.join(heads)} |", "|---" * len(HEADS) + "|"]
    for name in names():
        rows = list(zip(*bands(name).values()))
        first = rows[0][0]
        title = f"{name}, {first.status}: {first.source}"
        if len(rows[0]) > 1:
            title += f"; band over {len(rows[0])} assumed supplies"
        table = Table(*(head.format(first.status) for head in HEADS), box=None, title=title)
        for row in rows:
            one = row[0]
            cells = (
                name,
                ", ".join(_shown(head, cell) for head, cell in one.at.items()),
                f"{one.quantity} [{one.unit}]",
                f"{one.published:.4g}",
                _range([each.computed for each in row], "{:.4g}"),
                _range([100.0 * each.difference for each in row], "{:+.1f}") + " %",
                _range([100.0 * each.share for each in row], "{:+.1f}") + " %",
            )
            table.add_row(*map(Text, cells))
            lines.append(f"| {' | '.join(cells)} |")
        console.print(table)
    if page is not None:
        page.write_text("\n".join([*lines, ""]))
