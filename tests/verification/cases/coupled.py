"""Figures of the coupled problem: the numerical example through both FMUs beside one system of
equations (`monolithic`), on the same grid and in the same steps; for `piston-cosim verify coupled`.

Both film models put the same resistance on a face (two half cells in series), because the mean
film of both cells moves the curves by 1 % on 42 cells: what is compared is everything else. The
grid's own error is a matter of the studies.
"""

import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from piston_cosim.master.case.schema import find_case
from piston_cosim.master.fmi.quantities import to_si
from piston_cosim.master.fmi.tree import import_part

from .checks import Check, at_most
from .coupling import summary_of
from .monolithic import Curves, Elasticity, Engine, Monolithic

CASE = "numerical_example"
BODIES = {
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
}
LUBRICATION = {
    "bore_radius": "28.25 mm",
    "skirt_length": "27 mm",
    "viscosity": "12 mPa s",
    "roughness_rms": "0 um",
}
PIN_OFFSET = "0.4 mm"
"""The piston's inertia turns it from the first instant on, and the film swings it over within a few
steps at 223 deg: a test of what the bodies' integrator takes for an impact.
"""
CRANK_SPEED = "6000 rpm"


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
REASON = "different integrators with steps of 1 deg, and different transport of oil across faces"


def through_fmus(cells: int, modes: int, span: Span) -> dict[str, np.ndarray]:
    """Curves on cells x cells from 0 to the end of a span, by port."""
    changes: list[tuple[str, Any]] = [("time.stop", f"{span.end} deg"), ("time.step", "1 deg")]
    changes += [(f"participants.{name}.build.grid", [cells, cells]) for name in ("bodies", "ehd")]
    for body in ("piston", "block"):
        changes.append((f"participants.bodies.build.{body}.modes", modes))
    changes.append(("participants.ehd.build.mask", "none"))
    changes.append(("participants.bodies.build.piston.pin_offset", PIN_OFFSET))
    changes.append(("participants.bodies.parameters.crank_speed", CRANK_SPEED))
    changes += [(f"participants.bodies.parameters.{key}", BODIES[key]) for key in BODIES]
    changes += [(f"participants.ehd.parameters.{key}", LUBRICATION[key]) for key in LUBRICATION]
    return summary_of(CASE, *changes, look=curves)["curves"]


def curves(results) -> dict[str, Any]:
    """The compared scalar outputs of a run."""
    return {"curves": {one.port: results.series(one.port).values for one in QUANTITIES}}


@cache
def of_mesh(what: str, cells: int):
    """`rigid_piston` or `compliance` of the example's meshes (fmu_mfbd.reduction.compliance)."""
    path = find_case(CASE)
    options = tomllib.loads(path.read_text())["participants"]["bodies"]["build"]
    options["grid"] = [cells, cells]
    options["piston"]["pin_offset"] = PIN_OFFSET
    return getattr(import_part("fmu_mfbd.reduction.compliance"), what)(options, path.parent)


def engine(cells: int) -> Engine:
    """The same numbers for the system of equations."""
    piston = of_mesh("rigid_piston", cells)
    return Engine(
        grid=(cells, cells),
        bore_radius=to_si(LUBRICATION["bore_radius"], "m"),
        viscosity=to_si(LUBRICATION["viscosity"], "Pa.s"),
        clearance=to_si(BODIES["radial_clearance"], "m"),
        barrel=to_si(BODIES["barrel"], "m"),
        ovality=to_si(BODIES["ovality"], "m"),
        crank_radius=to_si(BODIES["crank_radius"], "m"),
        rod_length=to_si(BODIES["rod_length"], "m"),
        crank_offset=to_si(BODIES["crank_offset"], "m"),
        pin_offset=to_si(PIN_OFFSET, "m"),
        rod_mass=to_si(BODIES["rod_mass"], "kg"),
        rod_inertia=to_si(BODIES["rod_inertia"], "kg.m2"),
        rod_centre=to_si(BODIES["rod_centre"], "m"),
        pin_mass=to_si(BODIES["pin_mass"], "kg"),
        piston_mass=piston.mass,
        piston_inertia=piston.inertia,
        piston_centre=piston.centre,
        skirt_lower=piston.skirt_lower,
        skirt_upper=piston.skirt_upper,
        speed=to_si(CRANK_SPEED, "rad/s"),
    )


def elasticity(cells: int, share: float = 1.0) -> Elasticity:
    """Both bodies' compliance, times `share`."""
    part = import_part("fmu_mfbd.reduction.compliance")
    whole = of_mesh("compliance", cells)
    rows = part.film_rows(whole.piston, cells)
    return Elasticity(
        pressure=lambda height: share * part.on_the_skirt(whole, height, rows),
        inertia=share * whole.skirt_inertia,
    )


def in_one_system(cells: int, span: Span, elastic: Elasticity | None = None) -> Curves:
    """Curves of the same angles."""
    return Monolithic(engine(cells), elastic).run(np.radians(np.arange(span.end + 1)))


def distances(
    ours: Mapping[str, np.ndarray], theirs: Curves, span: Span
) -> Iterator[tuple[Quantity, float]]:
    """Every quantity and its root mean square distance over the range of the reference [-], within
    the span.
    """
    for one in QUANTITIES:
        reference = getattr(theirs, one.curve)[span.begin :]
        apart = np.sqrt(np.mean((ours[one.port][span.begin :] - reference) ** 2))
        yield one, float(apart / np.ptp(reference))


def rows(case: str, ours: Mapping[str, np.ndarray], theirs: Curves, span: Span) -> Iterator[Check]:
    """A check for each quantity."""
    for one, apart in distances(ours, theirs, span):
        what = f"{one.port.split('.')[1]}, rms difference over range [-]"
        yield at_most(case, what, apart, one.allowed, "monolithic solution", REASON)


def rigid_checks(cells: int) -> Iterator[Check]:
    """Rigid bodies in the first turn on cells x cells."""
    ours = through_fmus(cells, 0, FIRST_TURN)
    theirs = in_one_system(cells, FIRST_TURN)
    case = f"Rigid bodies, {cells} x {cells} cells, first revolution"
    yield from rows(case, ours, theirs, FIRST_TURN)


def checks() -> Iterator[Check]:
    """Rigid bodies on 42 x 42."""
    yield from rigid_checks(42)


def slow_checks() -> Iterator[Check]:
    """Rigid bodies on 82 x 82; flexible ones on 42 x 42, where an error of 5 % in the compliance
    must be seen.
    """
    yield from rigid_checks(82)
    span = SECOND_TURN
    flexible = through_fmus(42, 200, span)
    case = "Flexible bodies, 200 modes per body, 42 x 42 cells, second revolution"
    yield from rows(case, flexible, in_one_system(42, span, elasticity(42)), span)
    softer = list(distances(flexible, in_one_system(42, span, elasticity(42, 1.05)), span))
    yield at_most(
        case,
        "passed comparisons if the compliance is 5 % larger [-]",
        sum(apart <= one.allowed for one, apart in softer),
        len(QUANTITIES) - 1,
        "monolithic solution",
        "the comparison must detect 5 %",
    )
