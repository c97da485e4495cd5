"""Figures of the fired engine: rigid bodies and asperity contact, through both FMUs
and in one system of equations (`monolithic` with `mixed_film`), extrapolated from three grids.
"""

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from piston_cosim.master.case.schema import find_case
from piston_cosim.master.fmi.quantities import to_si

from .checks import Check
from .coupled import SCALED, Problem, Quantity, Span, engine, rows, through_fmus
from .mixed_film import Roughness
from .monolithic import Curves, Engine, Monolithic

BODIES = {
    "radial_clearance": "12 um",
    "barrel": "20 um",
    "ovality": "100 um",
    "crank_radius": "29.75 mm",
    "rod_length": "108 mm",
    "crank_offset": "0 mm",
    "rod_mass": "200 g",
    "rod_inertia": "2.2e-4 kg m^2",
    "rod_centre": "33 mm",
    "pin_mass": "60 g",
    "pin_friction_coefficient": "0",
}
LUBRICATION = {
    "bore_radius": "36.5 mm",
    "skirt_length": "27 mm",
    "viscosity": "9 mPa s",
    "asperity_product": "0.04",
    "asperity_slope": "1e-3",
    "contact_modulus": "60 GPa",
    "boundary_friction_coefficient": "0.12",
    "friction_rounding_velocity": "1 mm/s",
}
FLOODED = {"oil_supply": "edges", "roughness_rms": "4 um"}
"""As rough as the film is thick: asperities take 6 % of the friction work."""
QUANTITIES = (
    Quantity("bodies.lateral_displacement", "lateral_displacement", 1.5e-2),
    Quantity("bodies.rocking_angle", "rocking_angle", 1.5e-2),
    Quantity("ehd.minimum_film_thickness", "minimum_film_thickness", 2e-2),
    Quantity("ehd.friction_force_asperity", "asperity_friction", 8e-2),
    Quantity("ehd.friction_power", "friction_power", 5e-3),
)


def fired(film: dict[str, str], start: int) -> Problem:
    """The case `fired_motorcycle` with rigid bodies on one supply of oil, without its measured
    profile, which is no formula.
    """
    return Problem(
        "fired_motorcycle",
        BODIES,
        LUBRICATION | film,
        pin_offset="0.5 mm",
        crank_speed="4000 rpm",
        start=start,
        changes=(("participants.bodies.build.piston.profiles", []),),
    )


def gas_force(problem: Problem) -> Any:
    """Crank angle [rad] to the force of the case's gas on the crown [N]."""
    path = find_case(problem.case)
    table = tomllib.loads(path.read_text())["participants"]["bodies"]["build"]["gas"]
    angle, pressure = np.loadtxt(path.parent / table["file"], delimiter=",", skiprows=1).T
    force = np.pi * to_si(problem.lubrication["bore_radius"], "m") ** 2 * 1e6 * pressure
    period = 360 * table["strokes"] / 2
    return lambda crank: float(np.interp(np.degrees(crank), angle, force, period=period))


def fired_engine(problem: Problem, grid: tuple[int, int]) -> Engine:
    """The same numbers for the system of equations."""
    film = problem.lubrication

    def number(name: str, unit: str) -> float:
        return to_si(film[name], unit)

    return replace(
        engine(problem, grid),
        gas=gas_force(problem),
        roughness=Roughness(
            rms=number("roughness_rms", "m"),
            product=number("asperity_product", "1"),
            slope=number("asperity_slope", "1"),
            modulus=number("contact_modulus", "Pa"),
            friction=number("boundary_friction_coefficient", "1"),
            rounding=number("friction_rounding_velocity", "m/s"),
        ),
    )


class Grid(NamedTuple):
    """Cells around and along the skirt, and steps in a degree."""

    around: int
    along: int
    steps: int


GRIDS = Grid(28, 28, 2), Grid(42, 42, 3), Grid(56, 56, 4)


def in_one_system(problem: Problem, grid: Grid, span: Span) -> Curves:
    """Curves at whole degrees."""
    degrees = problem.start + np.arange(span.end * grid.steps + 1) / grid.steps
    run = Monolithic(fired_engine(problem, grid[:2])).run(np.radians(degrees))
    return Curves(*(curve[:: grid.steps] for curve in run))


def extrapolated(problem: Problem, span: Span) -> Curves:
    """Curves for cells and steps towards zero.

    Eq. (Z10):  u = u_3 + (u_3 - u_2) h_3^q/(h_2^q - h_3^q),   1 <= q <= 2

    q is the order that the three runs show by their root mean square differences.
    """
    runs = [in_one_system(problem, grid, span) for grid in GRIDS]
    size = np.array([1 / grid.around for grid in GRIDS])
    orders = np.linspace(1, 2, 101)
    ratio = (size[0] ** orders - size[1] ** orders) / (size[1] ** orders - size[2] ** orders)
    curves = []
    for coarse, middle, fine in zip(*runs):
        seen = np.linalg.norm(coarse - middle) / max(np.linalg.norm(middle - fine), 1e-300)
        q = orders[np.abs(ratio - seen).argmin()]
        more = size[2] ** q / (size[1] ** q - size[2] ** q)
        curves.append(fine + more * (fine - middle))  # Eq. (Z10)
    return Curves(*curves)


def fired_rows(case: str, ours: dict[str, np.ndarray], theirs: Curves, span: Span):
    """Checks of the distances and of the scales."""
    yield from rows(case, ours, theirs, span, QUANTITIES)
    for one in SCALED:
        reference = getattr(theirs, one.curve)[span.begin :]
        factor = ours[one.port][span.begin :] @ reference / (reference @ reference)
        yield Check(
            case,
            f"{one.port.split('.')[1]}, scale of the curve [-]",
            factor,
            1.0,
            one.allowed,
            "absolute",
            "monolithic solution",
            "an error of 5 % in boundary friction or layer must be seen",
        )


QUICK = Span(10, 60)
"""From firing top dead centre at rest."""
QUICK_GRID = Grid(28, 28, 2)
CYCLE = Span(30, 480)
"""From -360 deg to 120 deg after firing."""


def checks(change: Mapping[str, str] = MappingProxyType({})) -> Iterator[Check]:
    """Flooded, on one grid; `change` of parameters makes the system of equations wrong."""
    problem = fired(FLOODED, 0)
    ours = through_fmus(problem, QUICK_GRID.around, 0, QUICK, "0.5 deg")
    theirs = in_one_system(fired(FLOODED | dict(change), 0), QUICK_GRID, QUICK)
    yield from fired_rows("Fired, rigid, flooded, 28 x 28 cells", ours, theirs, QUICK)


def slow_checks() -> Iterator[Check]:
    """The cycle until firing, on the default grid against three."""
    problem = fired(FLOODED, -360)
    ours = through_fmus(problem, 42, 0, CYCLE)
    case = "Fired, rigid, flooded, 42 x 42 cells, extrapolated reference"
    yield from fired_rows(case, ours, extrapolated(problem, CYCLE), CYCLE)
