"""A new case of an engine from a few lengths, with a rule for each omitted value.

Every rule is our own choice, typical of passenger car and motorcycle pistons. None imitates a
measured engine.
"""

import re
import shutil
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import nan, pi, prod, sqrt
from pathlib import Path
from shlex import quote
from typing import Any, NamedTuple

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from ..case.check import CheckedCase, check
from ..fmi.errors import BadInput
from ..fmi.quantities import from_si, registry, to_si
from ..fmi.tree import import_part

STEEL_DENSITY = 7850.0
"""Density of the pin [kg/m3]."""
EXPONENT = 1.33
"""Polytropic exponent of compression and expansion."""
AMBIENT, BOOST = 1.0e5, 2.0e5
"""Absolute pressures [Pa]: of the ambient, and of the charge of a supercharged diesel."""
LEAST_DIESEL = 14.0
"""Compression ratio from which an engine is a diesel."""


class Combustion(NamedTuple):
    """Heat release: start and duration [deg], and factor of Eq. (D13) [-]."""

    start: float
    duration: float
    heat: float


PETROL = Combustion(-8.0, 60.0, 9.3)
"""Our own choice: a compression ratio of 10.5 gives about 6.5 MPa."""
DIESEL = Combustion(-4.0, 70.0, 6.4)
"""Our own choice: a lean charge, 1.45 times the air of petrol. A compression ratio of 17 and a
charge of 2 bar give about 13 MPa."""
CELL_FACTOR, LEAST_CELLS, MOST_CELLS = 57.0, 40, 192
"""Factor of Eq. (D51) and its bounds [cells]: our own choice, see `Engine.cells_around`.
Native films have at most 192 cells around.
"""
FLEXIBLE_CELLS = 64
"""Number of cells around a flexible skirt, whose pressure peak is wide: our own choice."""
OPENING_ANGLE = 20.0
"""Crank angle in which the pressure approaches its new value to 1/e after a valve opens [deg]."""
MESHES = "fmu_mfbd.finite_elements.mesh"
"""Module that reads meshes, called by name because this package does not import bodies."""
TITLES = {True: "motored", False: "fired"}


@dataclass(frozen=True)
class Size:
    """A size of an engine, with an optional rule that estimates it.

    unit : of a bare number; low, high : allowed range in SI; rule : uses the sizes before it;
    words : the rule as text.
    """

    unit: str
    low: float
    high: float
    meaning: str
    rule: Callable[[Mapping[str, float]], float] | None = None
    words: str = ""

    def read(self, name: str, text: str | float) -> float:
        """Return a value in SI; raise `ValueError` with a sentence if it is invalid."""
        allowed = f"{_in(self.low, self.unit)} to {_in(self.high, self.unit)} {self.unit}".strip()
        plain = str(text).strip()
        try:
            float(plain)
            plain = f"{plain} {self.unit}" if self.unit else plain
        except ValueError:
            pass
        try:
            value = to_si(plain, _si(self.unit))
        except ValueError as error:
            if "," in plain:
                raise ValueError(f"{option_of(name)}: {error}") from None
            value = nan
        if not self.low <= value <= self.high:
            raise ValueError(f"{option_of(name)}: expected {allowed}, got {text!r}")
        return value


def option_of(name: str) -> str:
    """Return the command-line option of a size."""
    return f"--{name.replace('_', '-')}"


def _si(unit: str) -> str:
    """Return the SI unit of a unit of the field."""
    if not unit:
        return "1"
    base = f"{registry().Unit(unit).dimensionality}"
    known = {"[length]": "m", "[mass]": "kg", "[mass] / [length] / [time] ** 2": "Pa"}
    known |= {"[mass] * [length] ** 2": "kg*m^2", "[mass] / [length] / [time]": "Pa*s"}
    return known.get(base, "rad/s")


def _in(value: float, unit: str) -> str:
    """Convert a value from SI to a unit of the field."""
    if not unit:
        return f"{value:g}"
    return f"{from_si(value, _si(unit), unit):.6g}"


def _rule(name: str, row: Mapping[str, Any]) -> Callable[[Mapping[str, float]], float] | None:
    """Return the rule of a size: `factor` times the sizes `of`, or one of `RULES`."""
    if "factor" not in row:
        return RULES.get(name)
    return lambda s: row["factor"] * prod(s[other] for other in row.get("of", ()))


RULES: dict[str, Callable[[Mapping[str, float]], float]] = {
    "pin_mass": lambda s: (
        STEEL_DENSITY * pi / 4 * s["pin_diameter"] ** 2 * (1 - 0.55**2) * 0.75 * s["bore"]
    ),
    "intake_pressure": lambda s: BOOST if s["compression"] >= LEAST_DIESEL else AMBIENT,
    "ovality": lambda s: s["bore"] * (1.5e-3 if s["compression"] >= LEAST_DIESEL else 2e-3),
    "viscosity": lambda s: 10e-3 if s["compression"] >= LEAST_DIESEL else 8e-3,
    "rod_inertia": lambda s: s["rod_mass"] * s["rod_centre"] * (s["rod"] - s["rod_centre"]),
}
"""Rules that are no products of sizes."""
TEMPLATES = Path(__file__).parent / "templates"
SIZES = {
    name: Size(
        **{key: row[key] for key in row if key not in ("factor", "of")}, rule=_rule(name, row)
    )
    for name, row in tomllib.loads((TEMPLATES / "sizes.toml").read_text("utf-8")).items()
}
"""Sizes of an engine by option. A rule may use the sizes before it."""


@dataclass(frozen=True)
class Engine:
    """Engine of a data sheet.

    sizes : value in SI of each of `SIZES`; stated : names of those that are not estimated; peak :
    required maximum gas pressure, gauge [Pa], or None; motored : no combustion.
    """

    sizes: dict[str, float]
    stated: frozenset[str]
    peak: float | None = None
    motored: bool = False

    def __getitem__(self, name: str) -> float:
        return self.sizes[name]

    @property
    def crank_radius(self) -> float:
        """Half the stroke [m]."""
        return self["stroke"] / 2

    @property
    def swept_volume(self) -> float:
        """Swept volume [m3]."""
        return pi / 4 * self["bore"] ** 2 * self["stroke"]

    @property
    def skirt_radius(self) -> float:
        """Radius of the skirt [m]."""
        return self["bore"] / 2 - self["clearance"]

    @property
    def top(self) -> float:
        """Height of the pin at top dead centre [m]."""
        offset = self["pin_offset"] - self["crank_offset"]
        return sqrt((self["rod"] + self.crank_radius) ** 2 - offset**2)

    @property
    def bottom(self) -> float:
        """Height of the pin at bottom dead centre [m]."""
        offset = self["pin_offset"] - self["crank_offset"]
        return sqrt((self["rod"] - self.crank_radius) ** 2 - offset**2)

    def bore_ends(self, skirt_below: float) -> tuple[float, float]:
        """Return the heights of the bore's ends above the crank axis [m].

        The lower end is slightly below the skirt at bottom dead centre, the upper one is at the
        crown at top dead centre.
        """
        return (
            self.bottom - skirt_below - 0.02 * self["bore"],
            self.top + self["compression_height"],
        )

    @property
    def diesel(self) -> bool:
        """True for the compression ratio of a diesel."""
        return self["compression"] >= LEAST_DIESEL

    @property
    def combustion(self) -> Combustion:
        """Heat release of petrol or diesel."""
        return DIESEL if self.diesel else PETROL

    @cached_property
    def gain(self) -> float:
        """Factor by which combustion multiplies the polytrope, minus 1 [-].

        Eq. (D13):  gain = q (r - 1) / r^n        r = compression ratio, q = `Combustion.heat`

        Our own choice. Its form is that of heat at constant volume, Q / (c_v T_1) over
        r^(n - 1), times the fresh share (r - 1) / r of the charge. It has no heat losses.
        """
        if self.motored:
            return 0.0
        if self.peak is None:
            ratio = self["compression"]
            return self.combustion.heat * (ratio - 1.0) / ratio**EXPONENT  # Eq. (D13)
        low, high = 0.0, 50.0
        for _ in range(60):
            middle = (low + high) / 2
            below = float(self.pressure(CYCLE, middle).max()) < self.peak
            low, high = (middle, high) if below else (low, middle)
        return (low + high) / 2

    def gas_pressure(self, degrees: np.ndarray) -> np.ndarray:
        """Return the gauge pressure over a cycle [Pa], -360 to 360 deg, 0 at firing TDC.

        Eq. (D12):  p = p_0 ((V/V_bdc)^-n (1 + gain x_b) - 1) + p_0 - p_a
                   x_b = 1 - exp(-5 ((phi - phi_0)/d)^1.5)
                   while the valves are closed, -180 to 180 deg; then p falls with e^(-phi/20 deg),
                   and from -360 deg on it rises to p_0 - p_a in the same way

        p_0 is the intake pressure and p_a that of the ambient. Our own choice, which imitates no
        measured curve. The exhaust has no back pressure.
        """
        return self.pressure(degrees, self.gain)

    def pressure(
        self, degrees: np.ndarray, gain: float, combustion: Combustion | None = None
    ) -> np.ndarray:
        """Return the gauge pressure of Eq. (D12) with another gain or heat release [Pa]."""
        start, duration, _ = combustion or self.combustion
        burnt = 1.0 - np.exp(-5.0 * (np.clip(degrees - start, 0.0, None) / duration) ** 1.5)
        intake = self["intake_pressure"]
        charge = intake - AMBIENT
        polytrope = intake * (
            self.volume_ratio(degrees) ** -EXPONENT * (1.0 + gain * burnt) - 1.0
        )  # Eq. (D12)
        filling = charge * -np.expm1(-np.clip(degrees + 360.0, 0.0, None) / OPENING_ANGLE)
        left = (intake * gain + charge) * np.exp(
            -np.clip(degrees - 180.0, 0.0, None) / OPENING_ANGLE
        )
        closed = np.abs(degrees) < 180.0
        return np.where(closed, polytrope + charge, np.where(degrees >= 180.0, left, filling))

    @cached_property
    def largest_side_force(self) -> float:
        """Largest side force of gas and inertia of a rigid piston with its pin [N]."""
        angle, r = np.radians(CYCLE), self.crank_radius
        mass = self["mass"] + self["pin_mass"]
        ratio = r / self["rod"]
        inertia = mass * r * self["speed"] ** 2 * (np.cos(angle) + ratio * np.cos(2 * angle))
        gas = self.gas_pressure(CYCLE) * pi / 4 * self["bore"] ** 2
        sine = ratio * np.sin(angle)
        return float(np.abs((gas - inertia) * sine / np.sqrt(1.0 - sine**2)).max())

    @property
    def cells_around(self) -> int:
        """Number of cells around a rigid skirt, so that four or more span the pressure peak.

        Eq. (D51):  n = 57 Z^(-1/2),   Z = mu U L^2 R / (F (b + c) (o/2 + c))

        mu is the viscosity, U the velocity of the crank pin, L the length of the skirt and R its
        radius. F is the side force, b the barrel, c the clearance and o the ovality. The peak is
        narrow if the film is thin compared with the gap next to it. Factor and exponent are our
        own choice: the check of the grid passes for the engines of tests/master/test_new.py.
        """
        length, c = self["skirt_below"] + self["skirt_above"], self["clearance"]
        lift = self["viscosity"] * self["speed"] * self.crank_radius * length**2 * self.skirt_radius
        load = self.largest_side_force * (self["barrel"] + c) * (self["ovality"] / 2 + c)
        cells = CELL_FACTOR * (lift / load) ** -0.5  # Eq. (D51)
        return int(np.clip(8 * np.ceil(cells / 8), LEAST_CELLS, MOST_CELLS))

    def volume_ratio(self, degrees: np.ndarray) -> np.ndarray:
        """Return the cylinder volume relative to bottom dead centre, without offsets."""
        angle = np.radians(degrees)
        r = self.crank_radius
        below_top = r + self["rod"] - self._height(angle)
        clearance = 2.0 * r / (self["compression"] - 1.0)
        return (clearance + below_top) / (clearance + 2.0 * r)

    def _height(self, angle: np.ndarray) -> np.ndarray:
        r = self.crank_radius
        return r * np.cos(angle) + np.sqrt(self["rod"] ** 2 - (r * np.sin(angle)) ** 2)


CYCLE = np.arange(-360.0, 361.0, 1.0)
"""Crank angles of a cycle [deg]."""


def engine(
    texts: Mapping[str, str | float | None], peak: str | None = None, motored: bool = False
) -> Engine:
    """Return an engine of the given sizes, with estimates of the others.

    Parameters
    ----------
    texts : mapping
        Names of `SIZES` -> text with a unit, or a number in the size's usual unit. None means
        omitted. bore, stroke and rod are required.
    peak : str, optional
        Maximum gas pressure, gauge.
    motored : bool
        Compression and expansion without combustion.

    Raises
    ------
    BadInput
        With every fault.
    """
    faults: list[str] = []
    sizes: dict[str, float] = {}
    given_sizes = {name: value for name, value in texts.items() if value is not None}
    for name, size in SIZES.items():
        option = option_of(name)
        if name in given_sizes:
            try:
                sizes[name] = size.read(name, given_sizes[name])
            except ValueError as error:
                faults.append(str(error))
                sizes[name] = size.low
        elif size.rule is None:
            faults.append(f"{option}: expected a value in {size.unit}, got nothing")
            sizes[name] = size.low
        else:
            sizes[name] = size.rule(sizes)
    if motored and "intake_pressure" not in given_sizes:
        sizes["intake_pressure"] = AMBIENT
    limit = None
    if peak is not None:
        try:
            limit = Size("bar", 1e4, 5e7, "").read("peak_pressure", peak)
        except ValueError as error:
            faults.append(str(error))
    new_engine = Engine(sizes, frozenset(given_sizes), limit, motored)
    if not faults:
        faults = _contradictions(new_engine)
    if faults:
        raise BadInput(faults)
    return new_engine


UNUSUAL_FACTOR = 6.0
"""Factor between a size and its estimate that hints at a wrong unit: our own choice."""
USUAL_ROD = 1.7
"""Length of the rod in strokes."""
MAY_BE_SMALL = ("barrel", "ovality", "skirt_above", "centre")
"""Sizes that may be far below their estimate."""


def unusual(engine: Engine) -> list[str]:
    """Return warnings about sizes that are far from an estimate by lengths and masses."""
    larger = {name: value * (1 + (name != "compression")) for name, value in engine.sizes.items()}
    rules = {name: size.rule for name, size in SIZES.items() if size.rule}
    rules["rod"] = lambda s: USUAL_ROD * s["stroke"]
    out: list[str] = []
    for name in sorted(engine.stated & rules.keys()):
        value, estimate, unit = engine[name], rules[name](engine.sizes), SIZES[name].unit
        scales = rules[name](larger) != estimate
        is_low = value < estimate / UNUSUAL_FACTOR and name not in MAY_BE_SMALL
        if scales and (value > UNUSUAL_FACTOR * estimate or is_low):
            out.append(
                f"{option_of(name)} = {_in(value, unit)} {unit}: our estimate is "
                f"{_in(estimate, unit)} {unit}; check its unit"
            )
    return out


def _contradictions(engine: Engine) -> list[str]:
    """Return the contradictions between sizes that are each in range."""
    faults = []
    reach = engine.crank_radius + abs(engine["pin_offset"] - engine["crank_offset"])
    if engine["rod"] <= 1.05 * reach:
        faults.append(
            f"--rod: expected more than {1050 * reach:g} mm, 1.05 times half the stroke and the "
            f"offsets, got {1e3 * engine['rod']:g} mm"
        )
    if engine["skirt_above"] >= engine["compression_height"]:
        faults.append(
            f"--skirt-above: expected less than the compression height, "
            f"{1e3 * engine['compression_height']:g} mm, got {1e3 * engine['skirt_above']:g} mm"
        )
    if engine["rod_centre"] >= engine["rod"]:
        faults.append(
            f"--rod-centre: expected less than the rod, {1e3 * engine['rod']:g} mm, got "
            f"{1e3 * engine['rod_centre']:g} mm"
        )
    if engine.peak is not None:
        bare = float(engine.pressure(CYCLE, 0.0).max())
        if engine.motored or not bare < engine.peak < 40.0 * bare:
            faults.append(
                f"--peak-pressure: expected {bare / 1e5:.3g} bar of compression to "
                f"{40 * bare / 1e5:.3g} bar without --motored, got {engine.peak / 1e5:g} bar"
            )
    return faults


def write_case(engine: Engine, folder: Path, mesh: Path | None = None) -> CheckedCase:
    """Write the case of an engine into a new folder: case.toml, gas_pressure.csv and the mesh.

    Parameters
    ----------
    engine : Engine
    folder : Path
        Must not exist, or be empty.
    mesh : Path, optional
        Mesh of the piston. Default: a rigid piston with the data sheet's sizes.

    Returns
    -------
    CheckedCase
        Result of `check`.

    Raises
    ------
    BadInput
        If the folder is not empty, or the mesh cannot be used.
    """
    faults = []
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        faults.append(f"{folder}: expected a new or empty folder, got an existing one")
    if re.search(r'["\\\x00-\x1f]', folder.name):
        got = repr(folder.name)
        faults.append(f"NAME: expected a folder name without quotes and backslashes, got {got}")
    if mesh and not mesh.is_file():
        faults.append(f"--mesh: expected a mesh, got no such file {str(mesh)!r}")
    if faults:
        raise BadInput(faults)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "gas_pressure.csv").write_text(gas_table(CYCLE, engine.gas_pressure(CYCLE)))
    case = folder / "case.toml"
    if mesh is None:
        case.write_text(_text(engine, folder.name), "utf-8")
        return check(folder)
    shutil.copy(mesh, folder / mesh.name)
    unit = _mesh_unit(folder / mesh.name)
    case.write_text(_text(engine, folder.name, mesh.name, unit), "utf-8")
    checked = check(folder)  # the file must contain the ends of the mesh's skirt as well
    lower, upper = (checked.figure(f"bodies.{name}") for name in ("skirt_lower", "skirt_upper"))
    if lower is None or upper is None:
        return checked
    fitted = {**engine.sizes, "skirt_below": -lower.value, "skirt_above": upper.value}
    measured = Engine(fitted, engine.stated, engine.peak, engine.motored)
    case.write_text(_text(measured, folder.name, mesh.name, unit), "utf-8")
    return check(folder)


def gas_table(degrees: np.ndarray, pressure: np.ndarray) -> str:
    """Return gauge pressures [Pa] over the crank angle as CSV."""
    rows = [f"{a:g},{p * 1e-6:.6g}" for a, p in zip(degrees, pressure)]
    return "\n".join(["crank angle [deg],gauge pressure [MPa]", *rows]) + "\n"


def _mesh_unit(mesh: Path) -> str:
    """Return "1 mm" if a mesh is larger than any piston in metres, else "1 m"."""
    reader: Any = import_part(MESHES)
    try:
        points = reader.read_raw(mesh).points
    except reader.MeshFault:
        return "1 m"  # the check of the case reports the fault
    return "1 mm" if np.ptp(points, axis=0).max() > 5.0 else "1 m"


def _text(engine: Engine, name: str, mesh: str | None = None, mesh_unit: str = "") -> str:
    """Return the text of the case file."""
    templates = Environment(
        loader=FileSystemLoader(TEMPLATES),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
    )

    def origin(size: str) -> str:
        """Return the origin of a size."""
        if size in engine.stated:
            return "given"
        return f"our estimate: {SIZES[size].words}"

    def shown(value: float, unit: str) -> str:
        return f"{value:.6g} {unit}"

    low, high = engine.bore_ends(engine["skirt_below"])
    return templates.get_template("engine.toml").render(
        name=name,
        quoted=quote(name),
        e=engine,
        origin=origin,
        mm=lambda value: shown(1e3 * value, "mm"),
        um=lambda value: shown(1e6 * value, "um"),
        grams=lambda value: shown(1e3 * value, "g"),
        inertia=lambda value: shown(1e6 * value, "kg*mm^2"),
        rpm=f"{engine['speed'] * 30 / pi:.6g} rpm",
        bore_lower=low,
        bore_upper=high,
        volume=f"{1e6 * engine.swept_volume:.6g}",
        kind=TITLES[engine.motored],
        peak=f"{float(engine.gas_pressure(CYCLE).max()) / 1e6:.3g}",
        gas=dict(exponent=EXPONENT, burn=engine.combustion, gain=f"{engine.gain:.4g}"),
        mesh=mesh,
        mesh_unit=mesh_unit,
        around=FLEXIBLE_CELLS if mesh else engine.cells_around,
    )
