"""Whole engines through both FMUs, and in one system of equations (`monolithic`).

Both sides use the same numbers. Both film models put the same resistance on a face, which is two
half cells in series. The mean film of both cells would move the curves by 1 % on 42 cells.
"""

import tomllib
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from piston_cosim.fmu_mfbd.geometry.grid import film_rows
from piston_cosim.master.case.reading import find_case
from piston_cosim.master.fmi.quantities import to_si

from .coupling import summary_of
from .mixed_film import Roughness, Supply
from .monolithic import Curves, Elasticity, Engine, Monolithic


class Problem(NamedTuple):
    """A case for both sides: parameters of bodies and film, and build options of the piston."""

    case: str
    bodies: dict[str, str]
    lubrication: dict[str, str]
    piston: dict[str, Any]


class Grid(NamedTuple):
    """Cells around the skirt and as many along it, and steps in a degree."""

    cells: int
    steps: int


class Span(NamedTuple):
    """Crank angle at the start from rest [deg]; from there, begin and end of what is compared."""

    start: int
    begin: int
    end: int


FULL = {
    "oil_supply": "edges",
    "film_fraction_lower_edge": "1",
    "film_fraction_upper_edge": "1",
    "initial_film_fraction": "1",
}
MOTORED = Problem(
    "numerical_example",
    {
        "crank_speed": "6000 rpm",
        "radial_clearance": "15 um",
        "barrel": "15 um",
        "ovality": "150 um",
        "crank_radius": "24.75 mm",
        "rod_length": "100 mm",
        "crank_offset": "0.8 mm",
        "rod_mass": "140 g",
        "rod_inertia": "2.2e-4 kg m^2",
        "rod_centre": "30 mm",
        "pin_mass": "30 g",
        "pin_friction_coefficient": "0",
    },
    FULL
    | {
        "bore_radius": "28.25 mm",
        "skirt_length": "27 mm",
        "viscosity": "12 mPa s",
        "roughness_rms": "0 um",
    },
    # The piston's inertia turns it from the first instant on, and the film swings it over within a
    # few steps at 223 deg: a test of what the bodies' integrator takes for an impact.
    {"pin_offset": "0.4 mm"},
)
"""Smooth and flooded."""

FIRED = Problem(
    "fired_motorcycle",
    {
        "crank_speed": "4000 rpm",
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
    },
    FULL
    | {
        "bore_radius": "36.5 mm",
        "skirt_length": "27 mm",
        "viscosity": "9 mPa s",
        "roughness_rms": "4 um",
        "asperity_product": "0.04",
        "asperity_slope": "1e-3",
        "contact_modulus": "60 GPa",
        "boundary_friction_coefficient": "0.12",
        "friction_rounding_velocity": "1 mm/s",
    },
    # the measured profile is no formula, and the compliance of the reference fixes the pin bores
    {"pin_offset": "0.5 mm", "profiles": [], "tie": "rbe2"},
)
"""Flooded, and as rough as the film is thick: asperities take 6 % of the friction work."""
EDGES = {
    "film_fraction_lower_edge": "0.12",
    "film_fraction_upper_edge": "0.12",
    "roughness_rms": "1.8 um",
}
"""Asperities take more than 10 % of the friction work."""
RING = {
    "oil_supply": "bore_and_ring",
    "oil_ring_layer": "2 um",
    "oil_splash": "0.1 mm/s",
    "initial_oil_layer": "3 um",
    "initial_film_fraction": "0.3",
    "largest_oil_layer": "50 um",
    "chamfer_capacity": "1e-7 m^2",
    "roughness_rms": "2.5 um",
}
"""The variant `starved`: asperities take 30 % of the friction work."""


def fired(film: dict[str, str]) -> Problem:
    """Return the fired engine with other parameters of the film."""
    return FIRED._replace(lubrication=FIRED.lubrication | film)


PORTS = (
    "bodies.crank_angle",
    "bodies.lateral_displacement",
    "bodies.rocking_angle",
    "bodies.side_force",
    "ehd.minimum_film_thickness",
    "ehd.maximum_pressure",
    "ehd.friction_force_asperity",
    "ehd.friction_power",
    "ehd.oil_in_film",
)
"""Of the results, in the order of `Curves`."""


def through_fmus(problem: Problem, grid: Grid, modes: int, span: Span) -> Curves:
    """Curves at whole degrees from the start to the end of a span."""
    tables = {
        "time": {
            "stop": f"{span.end} deg",
            "step": f"{1 / grid.steps} deg",
            "until_periodic": 0.0,
        },
        "participants.bodies.build": {"grid": [grid.cells] * 2},
        "participants.ehd.build": {"grid": [grid.cells] * 2, "mask": "none"},
        "participants.bodies.build.piston": problem.piston | {"modes": modes},
        "participants.bodies.build.block": {"modes": modes},
        "participants.bodies.parameters": problem.bodies
        | {"start_crank_angle": f"{span.start} deg"},
        "participants.ehd.parameters": problem.lubrication,
    }
    changes = [(f"{name}.{key}", of[key]) for name, of in tables.items() for key in of]
    return summary_of(problem.case, *changes, look=partial(_at_degrees, span))["curves"]


def _at_degrees(span: Span, results) -> dict[str, Curves]:
    degrees = np.degrees(results.series(PORTS[0]).values)
    whole = span.start + np.arange(span.end + 1)
    steps = np.abs(degrees[:, None] - whole).argmin(axis=0)
    np.testing.assert_allclose(degrees[steps], whole, atol=1e-6)
    return {"curves": Curves(*(results.series(port).values[steps] for port in PORTS))}


def _bodies_of(case: str) -> tuple[dict[str, Any], Path]:
    """Build options of a case's bodies, and its folder."""
    path = find_case(case)
    return tomllib.loads(path.read_text())["participants"]["bodies"]["build"], path.parent


@cache
def of_mesh(what: str, case: str, pin_offset: str, cells: int):
    """Return `compliance.rigid_piston` or `compliance.compliance` of a case's meshes."""
    from . import compliance  # slow to import

    options, folder = _bodies_of(case)
    options["grid"] = [cells, cells]
    options["piston"]["pin_offset"] = pin_offset
    return getattr(compliance, what)(options, folder)


UNITS = {
    name: unit
    for unit, names in {
        "m": "bore_radius radial_clearance barrel ovality crank_radius rod_length crank_offset "
        "pin_offset rod_centre roughness_rms oil_ring_layer initial_oil_layer largest_oil_layer",
        "m2": "chamfer_capacity",
        "m/s": "friction_rounding_velocity oil_splash",
        "rad/s": "crank_speed",
        "kg": "rod_mass pin_mass",
        "kg.m2": "rod_inertia",
        "Pa": "contact_modulus",
        "Pa.s": "viscosity",
        "1": "film_fraction_lower_edge initial_film_fraction asperity_product asperity_slope "
        "boundary_friction_coefficient",
    }.items()
    for name in names.split()
}
"""Of the parameters that both sides name alike."""


def engine(problem: Problem, cells: int) -> Engine:
    """Return the same numbers for the system of equations."""
    pin_offset = problem.piston["pin_offset"]
    given = problem.bodies | problem.lubrication | {"pin_offset": pin_offset}

    def numbers(kind: type) -> dict[str, Any]:
        common = UNITS.keys() & kind.__annotations__
        return {name: to_si(given[name], UNITS[name]) for name in common}

    piston = of_mesh("rigid_piston", problem.case, pin_offset, cells)
    scarce = given["oil_supply"] == "bore_and_ring"
    return Engine(
        **numbers(Engine),
        **piston._asdict(),
        grid=(cells, cells),
        gas=_gas_force(problem.case, to_si(given["bore_radius"], "m")),
        roughness=Roughness(**numbers(Roughness)) if "asperity_slope" in given else None,
        supply=Supply(**numbers(Supply)) if scarce else None,
    )


def _gas_force(case: str, bore_radius: float) -> Callable[[float], float]:
    """Crank angle [rad] to the force of the case's gas on the crown [N]."""
    options, folder = _bodies_of(case)
    if "gas" not in options:
        return lambda crank: 0.0
    table = options["gas"]
    angle, pressure = np.loadtxt(folder / table["file"], delimiter=",", skiprows=1).T
    force = np.pi * bore_radius**2 * 1e6 * pressure
    period = 360 * table["strokes"] / 2
    return lambda crank: float(np.interp(np.degrees(crank), angle, force, period=period))


def elasticity(problem: Problem, cells: int, share: float) -> Elasticity:
    """Both bodies' compliance, times `share`."""
    whole = of_mesh("compliance", problem.case, problem.piston["pin_offset"], cells)
    rows = film_rows(whole.piston.skirt_lower, whole.piston.skirt_upper, (1, cells))
    spline = CubicSpline(whole.stations, np.eye(len(whole.stations)), bc_type="natural")

    def compliance(height: float) -> np.ndarray:
        at = spline(height + rows)
        facing = np.einsum("as,isjt,bt->iajb", at, whole.bore, at, optimize=True)
        return share * (whole.skirt + facing.reshape(whole.skirt.shape))

    return Elasticity(compliance, share * whole.skirt_inertia, share * whole.skirt_gas)


def in_one_system(problem: Problem, grid: Grid, span: Span, share: float = 0.0) -> Curves:
    """Curves at whole degrees, of bodies with that share of their compliance."""
    degrees = span.start + np.arange(span.end * grid.steps + 1) / grid.steps
    elastic = elasticity(problem, grid.cells, share) if share else None
    run = Monolithic(engine(problem, grid.cells), elastic).run(np.radians(degrees))
    return Curves(*(curve[:: grid.steps] for curve in run))


def extrapolated(runs: Sequence[Curves], grids: Sequence[Grid]) -> Curves:
    """Curves of three grids for cells and steps towards zero.

    Eq. (Z10):  u = u_3 + (u_3 - u_2) h_3^q/(h_2^q - h_3^q),   1 <= q <= 2

    q is the order that the three runs show by their root mean square differences.
    """
    size = np.array([1 / grid.cells for grid in grids])
    orders = np.linspace(1, 2, 101)
    ratio = (size[0] ** orders - size[1] ** orders) / (size[1] ** orders - size[2] ** orders)
    curves = []
    for coarse, middle, fine in zip(*runs):
        seen = np.linalg.norm(coarse - middle) / max(np.linalg.norm(middle - fine), 1e-300)
        q = orders[np.abs(ratio - seen).argmin()]
        more = size[2] ** q / (size[1] ** q - size[2] ** q)
        curves.append(fine + more * (fine - middle))  # Eq. (Z10)
    return Curves(*curves)
