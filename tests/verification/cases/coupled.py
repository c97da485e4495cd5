"""Figures of the coupled problem: the numerical example through both FMUs beside one system of
equations (`monolithic`), on the same grid and in the same steps; for `piston-cosim verify coupled`.

Both film models put the same resistance on a face (two half cells in series), because the mean
film of both cells moves the curves by 1 % on 42 cells: what is compared is everything else. The
grid's own error is a matter of the studies.
"""

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse as sp
from scipy.interpolate import CubicSpline

from piston_cosim.fmu_mfbd.geometry.grid import film_rows
from piston_cosim.master.case.reading import find_case
from piston_cosim.master.fmi.quantities import to_si

from .checks import Check, at_most
from .coupling import summary_of
from .monolithic import Curves, Elasticity, Engine, Monolithic, mirrored


class Problem(NamedTuple):
    """A case for both sides: parameters of bodies and film, pin offset, crank speed, the crank
    angle at the start [deg], and what else the FMUs' case changes.
    """

    case: str
    bodies: dict[str, str]
    lubrication: dict[str, str]
    pin_offset: str
    crank_speed: str
    start: int = 0
    changes: tuple[tuple[str, Any], ...] = ()


MOTORED = Problem(
    "numerical_example",
    {
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
    {
        "bore_radius": "28.25 mm",
        "skirt_length": "27 mm",
        "viscosity": "12 mPa s",
        "roughness_rms": "0 um",
    },
    # The piston's inertia turns it from the first instant on, and the film swings it over within a
    # few steps at 223 deg: a test of what the bodies' integrator takes for an impact.
    pin_offset="0.4 mm",
    crank_speed="6000 rpm",
)


class Span(NamedTuple):
    """Crank angles that are compared [deg], in steps of 1 deg; the turn starts at 0 from rest."""

    begin: int
    end: int


FIRST_TURN = Span(30, 360)
SECOND_TURN = Span(360, 720)
"""For elastic bodies: the start from rest rings their modes, which no step of 1 deg resolves and a
compliance does not have; what that does to the oil is forgotten after a turn."""


class Quantity(NamedTuple):
    """What is compared: port of the results, name in `Curves`, allowed rms distance over the
    range.
    """

    port: str
    curve: str
    allowed: float


QUANTITIES = (
    Quantity("bodies.lateral_displacement", "lateral_displacement", 5e-3),
    Quantity("bodies.rocking_angle", "rocking_angle", 5e-3),
    Quantity("bodies.side_force", "side_force", 1.5e-3),
    Quantity("ehd.minimum_film_thickness", "minimum_film_thickness", 1e-2),
    Quantity("ehd.maximum_pressure", "maximum_pressure", 1.5e-2),
    Quantity("ehd.friction_power", "friction_power", 1e-3),
)
SCALED = (
    Quantity("ehd.friction_force_asperity", "asperity_friction", 3e-2),
    Quantity("ehd.oil_in_film", "oil_in_film", 5e-3),
)
"""Curves of the fired engine whose scale is compared: the factor that fits one to the other."""
REASON = "different integrators with steps of 1 deg, and different transport of oil across faces"


def through_fmus(
    problem: Problem, cells: int, modes: int, span: Span, step: str = "1 deg"
) -> dict[str, np.ndarray]:
    """Curves on cells x cells from the start to the end of a span at whole degrees, by port."""
    changes: list[tuple[str, Any]] = [("time.stop", f"{span.end} deg"), ("time.step", step)]
    changes += [(f"participants.{name}.build.grid", [cells, cells]) for name in ("bodies", "ehd")]
    for body in ("piston", "block"):
        changes.append((f"participants.bodies.build.{body}.modes", modes))
    changes.append(("participants.ehd.build.mask", "none"))
    changes.append(("participants.bodies.build.piston.pin_offset", problem.pin_offset))
    bodies = problem.bodies | {
        "crank_speed": problem.crank_speed,
        "start_crank_angle": f"{problem.start} deg",
    }
    changes += [(f"participants.bodies.parameters.{key}", bodies[key]) for key in bodies]
    film = problem.lubrication
    changes += [(f"participants.ehd.parameters.{key}", film[key]) for key in film]
    changes += problem.changes
    return summary_of(problem.case, *changes, look=curves)["curves"]


def curves(results) -> dict[str, Any]:
    """The compared scalar outputs of a run at whole degrees of the crank."""
    degrees = np.degrees(results.series("bodies.crank_angle").values)
    whole = np.arange(round(degrees[0]), round(degrees[-1]) + 1)
    steps = np.abs(degrees[:, None] - whole).argmin(axis=0)
    np.testing.assert_allclose(degrees[steps], whole, atol=1e-6)
    ports = {one.port for one in QUANTITIES + SCALED}
    return {"curves": {port: results.series(port).values[steps] for port in ports}}


@cache
def of_mesh(what: str, case: str, pin_offset: str, cells: int):
    """Return `compliance.rigid_piston` or `compliance.compliance` of a case's meshes."""
    from . import compliance  # slow to import

    path = find_case(case)
    options = tomllib.loads(path.read_text())["participants"]["bodies"]["build"]
    options["grid"] = [cells, cells]
    options["piston"]["pin_offset"] = pin_offset
    return getattr(compliance, what)(options, path.parent)


def engine(problem: Problem, grid: tuple[int, int]) -> Engine:
    """The same numbers for the system of equations."""
    bodies, film = problem.bodies, problem.lubrication
    piston = of_mesh("rigid_piston", problem.case, problem.pin_offset, grid[1])
    return Engine(
        grid=grid,
        bore_radius=to_si(film["bore_radius"], "m"),
        viscosity=to_si(film["viscosity"], "Pa.s"),
        clearance=to_si(bodies["radial_clearance"], "m"),
        barrel=to_si(bodies["barrel"], "m"),
        ovality=to_si(bodies["ovality"], "m"),
        crank_radius=to_si(bodies["crank_radius"], "m"),
        rod_length=to_si(bodies["rod_length"], "m"),
        crank_offset=to_si(bodies["crank_offset"], "m"),
        pin_offset=to_si(problem.pin_offset, "m"),
        rod_mass=to_si(bodies["rod_mass"], "kg"),
        rod_inertia=to_si(bodies["rod_inertia"], "kg.m2"),
        rod_centre=to_si(bodies["rod_centre"], "m"),
        pin_mass=to_si(bodies["pin_mass"], "kg"),
        piston_mass=piston.mass,
        piston_inertia=piston.inertia,
        piston_centre=piston.centre,
        skirt_lower=piston.skirt_lower,
        skirt_upper=piston.skirt_upper,
        speed=to_si(problem.crank_speed, "rad/s"),
    )


STIFF = 1e-4
"""Compliance of a pattern of pressure over the largest one, below which a pattern is left out."""


def elasticity(problem: Problem, cells: int, share: float = 1.0) -> Elasticity:
    """Both bodies' compliance, times `share`."""
    whole = of_mesh("compliance", problem.case, problem.pin_offset, cells)
    rows = film_rows(whole.piston.skirt_lower, whole.piston.skirt_upper, (1, cells))
    skirt = symmetric_factor(whole.skirt, cells)
    stations = len(whole.stations)
    table = (cells * stations,) * 2
    bore = symmetric_factor(whole.bore.reshape(table), cells).reshape(cells, stations, -1)
    spline = CubicSpline(whole.stations, np.eye(stations), bc_type="natural")

    def factor(height: float) -> np.ndarray:
        facing = np.einsum("as,isk->iak", spline(height + rows), bore, optimize=True)
        both = np.hstack([skirt, facing.reshape(len(skirt), -1)])
        return np.sqrt(share) * both

    return Elasticity(factor, share * whole.skirt_inertia, share * whole.skirt_gas)


def symmetric_factor(compliance: np.ndarray, around: int) -> np.ndarray:
    """Return L with L L^T the compliance of the loads that are symmetric about the plane of
    motion; rows by columns of cells around, patterns below `STIFF` left out.
    """
    orbits, _ = mirrored(around, len(compliance) // around)
    basis = orbits @ sp.diags(1 / np.sqrt(np.asarray(orbits.sum(axis=0)).ravel()))
    values, patterns = np.linalg.eigh(basis.T @ (compliance @ basis))
    chosen = values > STIFF * values[-1]
    return (basis @ patterns[:, chosen]) * np.sqrt(values[chosen])


def in_one_system(cells: int, span: Span, elastic: Elasticity | None = None) -> Curves:
    """Curves of the motored engine at whole degrees."""
    angles = np.radians(np.arange(span.end + 1))
    return Monolithic(engine(MOTORED, (cells, cells)), elastic).run(angles)


def distances(
    ours: Mapping[str, np.ndarray],
    theirs: Curves,
    span: Span,
    quantities: Sequence[Quantity] = QUANTITIES,
) -> Iterator[tuple[Quantity, float]]:
    """Every quantity and its root mean square distance over the range of the reference [-], within
    the span.
    """
    for one in quantities:
        reference = getattr(theirs, one.curve)[span.begin :]
        apart = np.sqrt(np.mean((ours[one.port][span.begin :] - reference) ** 2))
        yield one, float(apart / np.ptp(reference))


def rows(
    case: str,
    ours: Mapping[str, np.ndarray],
    theirs: Curves,
    span: Span,
    quantities: Sequence[Quantity] = QUANTITIES,
) -> Iterator[Check]:
    """A check for each quantity."""
    for one, apart in distances(ours, theirs, span, quantities):
        what = f"{one.port.split('.')[1]}, rms difference over range [-]"
        yield at_most(case, what, apart, one.allowed, "monolithic solution", REASON)


def rigid_checks(cells: int) -> Iterator[Check]:
    """Rigid bodies in the first turn on cells x cells."""
    ours = through_fmus(MOTORED, cells, 0, FIRST_TURN)
    theirs = in_one_system(cells, FIRST_TURN)
    case = f"Rigid bodies, {cells} x {cells} cells, first revolution"
    yield from rows(case, ours, theirs, FIRST_TURN)


def softer_row(case: str, softer: Iterator[tuple[Quantity, float]]) -> Check:
    """A check that the comparison with a compliance 5 % larger, `distances`, fails."""
    passed = [apart <= one.allowed for one, apart in softer]
    return at_most(
        case,
        "passed comparisons if the compliance is 5 % larger [-]",
        sum(passed),
        len(passed) - 1,
        "monolithic solution",
        "the comparison must detect 5 %",
    )


def checks() -> Iterator[Check]:
    """Rigid bodies on 42 x 42."""
    yield from rigid_checks(42)


def slow_checks() -> Iterator[Check]:
    """Rigid bodies on 82 x 82; flexible ones on 42 x 42, where an error of 5 % in the compliance
    must be seen.
    """
    yield from rigid_checks(82)
    span = SECOND_TURN
    flexible = through_fmus(MOTORED, 42, 150, span)
    case = "Flexible bodies, 150 symmetric modes per body, 42 x 42 cells, second revolution"
    yield from rows(case, flexible, in_one_system(42, span, elasticity(MOTORED, 42)), span)
    softer = in_one_system(42, span, elasticity(MOTORED, 42, 1.05))
    yield softer_row(case, distances(flexible, softer, span))
