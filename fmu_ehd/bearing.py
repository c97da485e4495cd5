"""A journal bearing under a constant load in one call: `piston_cosim.bearing`.

The axes belong to the load: y points against it, x follows y by 90 deg clockwise, and the journal
rotates counter-clockwise. Angles count from the load in the direction of rotation.

Eq. (E20):  S = mu N 2 R L/W (R/C)^2,   f = M/(R W),   k = C K/W,   d = C omega D/W

N are the revolutions per second, and mu is the viscosity of the oil without pressure and shear.

Each figure is computed on three grids, each with twice the cells of the next. They give f_1 on
the finest one, f_2 and f_3, and the uncertainty by the grid:

Eq. (E21):  U = 5/4 max(|f_1 - f_2|, |f_2 - f_3|/4)

This is the grid convergence index of [Roache1998] with the order 1, because grooves and boundaries
of cavities move by whole cells. The second part holds if the first one is small by chance. It is
also the first one for figures of order 2.

References
----------
[Roache1998] P. J. Roache, Verification and validation in computational science and engineering,
Hermosa 1998.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from ..master.fmi.errors import BadInput, Discard, collecting, unknown
from ..master.fmi.quantities import from_si, numbers_text, to_si
from ..master.fmi.variables import Variable
from .alone import KNOWN, Film
from .common.grid import Array, Flags

GROOVE_ANGLE = 2.0 * np.pi / 30.0
"""Width of the groove around the shell [rad]."""
LAND_SHARE = 1.0 / 6.0
"""Part of the length between the groove and each edge."""
COARSEST_GRID = (30, 6)
"""Cells of the coarsest grid, which have a whole number of them in the groove."""
GRID_LEVELS = 3
SAFETY_FACTOR = 1.25
"""Factor of Eq. (E21)."""
FLOODED, GROOVED = "flooded", "groove"
SUPPLIES = {
    FLOODED: (
        "the film begins full at its thickest position, with ambient pressure there and at both "
        "edges; a bearing that receives less oil has a thinner film"
    ),
    GROOVED: (
        "axial groove, 12 deg wide and as long as two thirds of the bearing; the film conserves "
        "the oil that the groove feeds"
    ),
}
LAWS: dict[str, dict[str, Any]] = {
    FLOODED: dict(cavitation_model="jfo", cavity_shear="full_film"),
    GROOVED: dict(cavitation_model="jfo", opening_supply="own"),
}
"""Parameters of the film with each supply. The first one is that of Raimondi and Boyd."""
FIRST_ATTITUDE = np.radians(50.0)
GROOVE_TOLERANCE, MOST_TURNS = 1e-3, 20
"""Angle between the thickest film and its groove [rad], and most positions of the load."""


def _input(name: str, unit: str, low: float, high: float, meaning: str) -> Variable:
    """Return the declaration of an input."""
    return Variable(name, unit, "input", meaning, low, minimum=low, maximum=high)


INPUTS = {
    v.name: v
    for v in (
        _input("radius", "m", 1e-3, 1.0, "Radius R of the shell"),
        _input("length", "m", 1e-3, 2.0, "Length L of the bearing"),
        _input("clearance", "m", 1e-7, 1e-2, "Radial clearance C"),
        _input("speed", "rad/s", 1e-3, 1e5, "Speed omega of the journal"),
        _input("load", "N", 1e-3, 1e9, "Load W on the journal"),
        _input("supply_pressure", "Pa", 0.0, 1e8, "Gauge pressure in the groove"),
        _input("groove_angle", "rad", 0.0, 2.0 * np.pi, "Angle from the load to the groove"),
    )
}
"""Inputs with unit and allowed range."""
RATIOS = {"length": (0.02, 2000.0), "clearance": (1e-6, 0.1)}
"""Allowed ranges over the radius."""
OWN = {"bore_radius", "skirt_length", "open_cells", "surface", "opening_supply", "oil"}
OWN |= {"pressure_openings", "sector_angle", "grid", "oil_supply", "viscosity"}
"""Parameters of a film that follow from the inputs."""
EDGES = "oil_temperature_lower_edge", "oil_temperature_upper_edge"
"""Parameters of a film that have the temperature of its oil."""

ROWS = {
    "sommerfeld_number": ("Sommerfeld number S", ""),
    "eccentricity_ratio": ("eccentricity ratio e/C", ""),
    "attitude_angle": ("attitude angle", "deg"),
    "minimum_film_thickness": ("minimum film thickness", "um"),
    "maximum_pressure": ("maximum pressure", "MPa"),
    "maximum_pressure_angle": ("its angle from the load", "deg"),
    "friction_torque": ("friction torque", "N*m"),
    "friction_coefficient": ("friction coefficient M/(R W)", ""),
    "side_flow": ("side flow, both sides", "cm^3/s"),
}
"""Figure -> its name and its unit in the table."""
MATRICES = {
    "stiffness": ("K", "MN/m"),
    "damping": ("D", "kN*s/m"),
    "dimensionless_stiffness": ("C K/W", ""),
    "dimensionless_damping": ("C omega D/W", ""),
}
"""The same of matrices."""
UNITS = {"deg": "rad", "um": "m", "MPa": "Pa", "N*m": "N*m", "cm^3/s": "m^3/s"}
UNITS |= {"MN/m": "N/m", "kN*s/m": "N*s/m"}
"""Unit of the table -> SI."""


@dataclass(frozen=True, repr=False)
class Bearing:
    """A journal bearing in balance, in SI; `print` writes a table.

    Parameters
    ----------
    sommerfeld_number, eccentricity_ratio : float
        S of Eq. (E20); e/C.
    attitude_angle : float
        From the load to the journal in the direction of rotation [rad].
    minimum_film_thickness, maximum_pressure, maximum_pressure_angle : float
        C - e [m]; at mid-length [Pa], and its angle from the load [rad].
    friction_torque, friction_coefficient : float
        M on the journal [N m]; M/(R W).
    side_flow : float
        Out of both edges [m3/s].
    stiffness, damping : ndarray, shape (2, 2)
        K [N/m] and D [N s/m] by x and y, F(x + dx) = F(x) - K dx - D d(dx)/dt.
    dimensionless_stiffness, dimensionless_damping : ndarray, shape (2, 2)
        k and d of Eq. (E20).
    uncertainty : dict
        U of Eq. (E21) by the name of the figure; NaN where a coarse grid has no solution.
    supply : str
        Assumption on the oil supply.
    viscosity : float
        mu [Pa s].
    rough : bool
        Whether surfaces have a roughness, so that they can touch.
    film : dict
        `angle` from the load [rad], `pressure` [Pa] and `film_thickness` [m] of the cells, and the
        `position` of the journal over C.
    """

    sommerfeld_number: float
    eccentricity_ratio: float
    attitude_angle: float
    minimum_film_thickness: float
    maximum_pressure: float
    maximum_pressure_angle: float
    friction_torque: float
    friction_coefficient: float
    side_flow: float
    stiffness: Array
    damping: Array
    dimensionless_stiffness: Array
    dimensionless_damping: Array
    uncertainty: dict[str, Any]
    supply: str
    viscosity: float
    rough: bool
    film: dict[str, Array]

    def __repr__(self) -> str:
        lines = [
            _row(name, getattr(self, key), self.uncertainty[key], unit)
            for key, (name, unit) in ROWS.items()
        ]
        for key, (symbol, unit) in MATRICES.items():
            value, uncertainty = getattr(self, key), self.uncertainty[key]
            for i, j in np.ndindex(2, 2):
                lines.append(
                    _row(f"{symbol}, {'xy'[i]}{'xy'[j]}", value[i, j], uncertainty[i, j], unit)
                )
        known = all(np.isfinite(one).all() for one in self.uncertainty.values())
        why = [] if known else [NO_UNCERTAINTY]
        contact = [] if self.rough else [SMOOTH]
        oil = f"oil supply {self.supply}", f"viscosity {1e3 * self.viscosity:.4g} mPa s"
        return "\n".join([*lines, *oil, *NOTES, *contact, *why])

    def plot(self) -> Any:
        """Return a matplotlib figure: the bearing with its pressure, and both along the angle."""
        from .bearing_picture import picture

        return picture(self)


NO_UNCERTAINTY = (
    "The uncertainty is unknown: on a coarser grid no position of the journal carries the load. "
    "Try a finer grid, e.g. 240 and 48 cells."
)
NOTES = (
    "S = mu N D L/W (R/C)^2 with N in revolutions per second; x, y: y points against the load,",
    "x 90 deg clockwise from y; the journal rotates counter-clockwise, and angles follow it.",
    "The number after +- is the uncertainty by the grid. The oil has one temperature.",
)
SMOOTH = "Smooth surfaces never touch; give roughness_rms for contact."


def _row(name: str, value: float, uncertainty: float, unit: str) -> str:
    """Return a line of the table."""
    if unit in UNITS:
        value, uncertainty = (from_si(float(x), UNITS[unit], unit) for x in (value, uncertainty))
    exact = uncertainty <= 1e-9 * abs(value)
    text = f"{value:.5g}" if exact else numbers_text(value, uncertainty)
    return f"{name:32s} {text} {unit.replace('*', ' ')}".rstrip()


def bearing(
    *,
    radius: str,
    length: str,
    clearance: str,
    speed: str,
    load: str,
    oil: str,
    supply: str = FLOODED,
    supply_pressure: str = "0 bar",
    groove_angle: str = "180 deg",
    grid: tuple[int, int] = (120, 24),
    progress: Callable[[str], object] = lambda text: None,
    **film: Any,
) -> Bearing:
    """Return a journal bearing that carries a constant load, with the uncertainty of each figure.

    The journal is rigid and parallel to its shell, and the oil has one temperature. Eq. (E16) gives
    the position of the journal, and Eq. (E18) stiffness and damping.

    Parameters
    ----------
    radius, length, clearance, speed, load : str
        With a unit: "25 mm", "3000 rpm", "5 kN". The clearance is radial.
    oil : str
        Viscosity, such as "12 mPa s", or an oil of the library with its temperature, such as
        "SAE 5W-30 at 90 degC". `piston-cosim keys oil` lists the oils.
    supply : str
        "flooded": the film begins full where it is thickest, as Raimondi and Boyd assume. "groove":
        an axial groove feeds a film that conserves its oil.
    supply_pressure, groove_angle : str
        Gauge pressure in the groove, and its angle from the load in the direction of rotation.
    grid : tuple of int
        Cells around and along, multiples of 120 and 24.
    progress : callable, optional
        Called with a message when all inputs are valid.
    **film
        Other parameters of `Film`, with a unit, such as `roughness_rms="0.3 um"` for contact.

    Returns
    -------
    Bearing

    Raises
    ------
    BadInput
        With every input that is missing, of another unit or out of its range.
    Discard
        If no position of the journal carries the load.

    Examples
    --------
    >>> bearing = pc.bearing(
    ...     radius="25 mm", length="25 mm", clearance="25 um", speed="3000 rpm", load="2 kN",
    ...     oil="SAE 5W-30 at 90 degC",
    ... )
    >>> print(f"{bearing.sommerfeld_number:.3f} {bearing.eccentricity_ratio:.2f}")
    0.361 0.57
    """
    inputs = dict(radius=radius, length=length, clearance=clearance, speed=speed, load=load)
    inputs |= dict(supply_pressure=supply_pressure, groove_angle=groove_angle)
    values, parameters = _read(inputs, oil, supply, grid, film)
    progress("computing on three grids; a first call also compiles for about a minute")
    levels: list[Any] = []
    attitude = FIRST_ATTITUDE
    for level in reversed(range(GRID_LEVELS)):
        around, along = (n // 2**level for n in grid)
        try:
            levels.insert(0, _solved(values, parameters, (around, along), supply, attitude))
            attitude = levels[0][0]["attitude_angle"]
        except Discard:
            if not level:
                raise
            levels.insert(0, None)
    (figures, fields_of_film, viscosity), *coarser = levels
    return Bearing(
        **figures,
        uncertainty=_uncertainty([figures, *(one and one[0] for one in coarser)]),
        supply=f"{supply}: {SUPPLIES[supply]}; cavitation model {parameters['cavitation_model']}",
        viscosity=viscosity,
        rough=parameters.get("roughness_rms", 0.0) > 0.0,
        film=fields_of_film,
    )


def _uncertainty(levels: list[Any]) -> dict[str, Any]:
    """Return U of each figure from the figures of three grids, the finest first, Eq. (E21)."""
    if None in levels:
        unknown_ones = {name: np.nan * value for name, value in levels[0].items()}
        return unknown_ones | {"sommerfeld_number": 0.0}  # which no grid affects

    def of(name: str) -> Any:
        last, before = (np.abs(one[name] - other[name]) for one, other in pairwise(levels))
        return SAFETY_FACTOR * np.maximum(last, 0.25 * before)  # Eq. (E21)

    return {name: of(name) for name in levels[0]}


# ---- inputs


def _read(
    inputs: Mapping[str, Any], oil: Any, supply: str, grid: Any, film: Mapping[str, Any]
) -> tuple[dict[str, float], dict[str, Any]]:
    """Return inputs in SI and the parameters of the film; BadInput with every fault."""
    faults: list[str] = []
    values: dict[str, float] = {}
    for name, value in inputs.items():
        with collecting(faults):
            values[name] = _number(INPUTS[name], value)
    for name, (low, high) in RATIOS.items():
        if {name, "radius"} <= set(values):
            share = values[name] / values["radius"]
            if not low <= share <= high:
                faults.append(f"{name}: expected {low:g} to {high:g} of the radius, got {share:g}")
    if supply not in SUPPLIES:
        faults.append(f"supply: {unknown('supply', supply, SUPPLIES)}")
    elif supply == FLOODED and values.get("supply_pressure"):
        faults.append("supply_pressure: expected supply='groove' with it, got 'flooded'")
    sizes = tuple(n * 2 ** (GRID_LEVELS - 1) for n in COARSEST_GRID)
    if len(grid) != 2 or any(not n or n % size for n, size in zip(grid, sizes)):
        faults.append(f"grid: expected multiples of {sizes[0]} and {sizes[1]} cells, got {grid}")
    for name in sorted(OWN & set(film)):
        faults.append(f"{name}: expected no value, which the inputs set, got {film[name]!r}")
    parameters: dict[str, Any] = dict(LAWS.get(supply, {}))
    with collecting(faults):
        parameters |= _oil(oil)
    for name, value in film.items():
        with collecting(faults):
            if name not in OWN:
                has_unit = name in KNOWN and KNOWN[name].unit != "1"
                parameters[name] = _number(KNOWN[name], value) if has_unit else value
    with collecting(faults):
        Film((4, 4), surface="bearing", **parameters)
    if faults:
        raise BadInput(faults)
    return values, parameters


def _number(variable: Variable, value: Any) -> float:
    """Return a value in SI; BadInput if it is no quantity with a unit, or out of its range."""
    try:
        number = to_si(value, variable.unit)
    except ValueError as error:
        text = str(error).replace("got None", "got nothing")
        raise BadInput(f"{variable.name}: {text}") from None
    if fault := variable.fault(number):
        raise BadInput(f"{fault.rpartition(', got ')[0]}, got {value}")
    return number


def _oil(oil: Any) -> dict[str, Any]:
    """Return the parameters of an oil, which is a viscosity, or a name at a temperature.

    "SAE 5W-30" is the same as "sae_5w_30". All others raise BadInput.
    """
    name, _, temperature = str(oil or "").partition(" at ")
    if oil is None or name.strip()[:1] in set("0123456789.+-"):
        try:
            return dict(viscosity=_number(replace(KNOWN["viscosity"], name="oil"), oil))
        except BadInput as error:
            raise BadInput(f"{error}; a name of an oil is 'SAE 5W-30 at 90 degC'") from None
    library = name.strip().lower().replace(" ", "_").replace("-", "_")
    faults: list[str] = []
    with collecting(faults):
        Film((4, 4), surface="bearing", oil=library)
    with collecting(faults):
        if not temperature:
            raise BadInput(
                f"oil: expected a temperature after the name, got {oil!r}; write for example "
                "'SAE 5W-30 at 90 degC'"
            )
        kelvin = _number(replace(KNOWN[EDGES[0]], name="oil"), temperature)
    if faults:
        raise BadInput(faults)
    return dict(oil=library) | dict.fromkeys(EDGES, kelvin)


# ---- one grid


def _line(grid: tuple[int, int]) -> Flags:
    """Return a groove at the first cell around."""
    cells = np.zeros(grid, dtype=bool)
    cells[0] = True
    return cells


def _groove(grid: tuple[int, int]) -> Flags:
    """Return the cells of a groove, which begins at the first one around."""
    around, along = grid
    cells = np.zeros(grid, dtype=bool)
    land = round(LAND_SHARE * along)
    cells[: round(GROOVE_ANGLE / (2.0 * np.pi) * around), land : along - land] = True
    return cells


GROOVES = {FLOODED: _line, GROOVED: _groove}


def _film(
    x: Mapping[str, float], parameters: Mapping[str, Any], grid: tuple[int, int], supply: str
) -> Film:
    """Return the film of a bearing on one grid, with its groove."""
    options: dict[str, Any] = dict(parameters) | dict(
        bore_radius=x["radius"], skirt_length=x["length"]
    )
    if supply == GROOVED:
        options["pressure_openings"] = x["supply_pressure"]
    return Film(grid, surface="bearing", open_cells=GROOVES[supply](grid), **options)


def _balance(
    film: Film, x: Mapping[str, float], supply: str, attitude: float
) -> tuple[float, dict[str, Any]]:
    """Return the angle of the load from the cell i = 0 [rad], and the outputs of `equilibrium`.

    The load turns, and not the groove, so that all grids have the same groove. It turns until the
    film is thickest at the groove, from an attitude angle on, or until the groove has its angle.
    """
    surface_speed = x["speed"] * x["radius"]
    if supply == GROOVED:
        towards = 0.5 * GROOVE_ANGLE - np.pi / film.grid[0] - x["groove_angle"]
    else:
        towards = np.pi - attitude
    for _ in range(MOST_TURNS):
        load = x["load"] * np.array([np.cos(towards), np.sin(towards)])
        outputs = film.equilibrium(load, x["clearance"], circumferential_velocity=surface_speed)
        right, up = outputs["position"]
        angle = float(np.arctan2(-up, -right))  # of the thickest film
        if supply == GROOVED or abs(angle) < GROOVE_TOLERANCE:
            return towards, outputs
        towards -= angle
    raise Discard(f"the thickest film does not settle: {np.degrees(angle):.2g} deg from its groove")


def _solved(
    x: Mapping[str, float],
    parameters: Mapping[str, Any],
    grid: tuple[int, int],
    supply: str,
    attitude: float,
) -> tuple[dict[str, Any], dict[str, Array], float]:
    """Return figures, fields and viscosity of a bearing on one grid, from an attitude angle on."""
    film = _film(x, parameters, grid, supply)
    towards, outputs = _balance(film, x, supply, attitude)
    cosine, sine = np.cos(towards), np.sin(towards)
    axes = -np.array([[sine, -cosine], [cosine, sine]])
    oil, laws = film.model.parameters.oil, film.model.parameters
    viscosity = float(oil.low_shear_viscosity(np.array(laws.oil_temperature_lower_edge)))
    cells: Array = 2.0 * np.pi / grid[0] * np.arange(0.0, grid[0])
    angle = (cells - towards + np.pi) % (2.0 * np.pi) - np.pi
    peak = _peak(outputs["pressure"], angle, GROOVES[supply](grid))
    shown = dict(
        angle=angle,
        pressure=outputs["pressure"],
        film_thickness=outputs["film_thickness"],
        position=axes @ outputs["position"] / x["clearance"],
    )
    return _figures(x, outputs, axes, viscosity) | peak, shown, viscosity


def _figures(
    x: Mapping[str, float], outputs: Mapping[str, Any], axes: Array, viscosity: float
) -> dict[str, Any]:
    """Return the figures of a bearing without its highest pressure; `axes` are the unit vectors."""
    right, up = axes @ outputs["position"]
    radius, clearance, speed, load = (x[name] for name in ("radius", "clearance", "speed", "load"))
    eccentricity = float(np.hypot(right, up))
    torque = outputs["friction_power"] / speed
    stiffness, damping = (axes @ outputs[name] @ axes.T for name in ("stiffness", "damping"))
    area = 2.0 * radius * x["length"]
    # Eq. (E20)
    sommerfeld = viscosity * speed / (2.0 * np.pi) * area / load * (radius / clearance) ** 2
    return dict(
        sommerfeld_number=sommerfeld,
        eccentricity_ratio=eccentricity / clearance,
        attitude_angle=float(np.arctan2(right, -up)),
        minimum_film_thickness=clearance - eccentricity,
        friction_torque=torque,
        friction_coefficient=torque / (radius * load),
        side_flow=-(outputs["flow_lower_edge"] + outputs["flow_upper_edge"]),
        stiffness=stiffness,
        damping=damping,
        dimensionless_stiffness=stiffness * clearance / load,
        dimensionless_damping=damping * clearance * speed / load,
    )


def _peak(pressure: Array, angle: Array, groove: Flags) -> dict[str, float]:
    """Return the highest pressure at mid-length [Pa] and its angle [rad].

    Parabolas through the nearest cells give both: an even one along, and one around. In the groove
    the pressure is uniform.
    """
    half = pressure.shape[1] // 2
    middle = (9.0 * pressure[:, half] - pressure[:, half + 1]) / 8.0
    top = int(middle.argmax())
    if groove[top, half]:
        before = at = after = pressure[top, half]
    else:
        before, at, after = middle[[top - 1, top, (top + 1) % len(middle)]]
    bend = before - 2.0 * at + after
    shift = 0.5 * (before - after) / bend if bend < 0.0 else 0.0
    peak = at - 0.25 * (before - after) * shift
    moved = angle[top] + shift * 2.0 * np.pi / len(middle)
    return dict(maximum_pressure=float(peak), maximum_pressure_angle=float(moved))
