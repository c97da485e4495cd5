"""Uncertainties next to true errors: closed forms of films, and engines against finer runs.

    python tests/bench/uncertainty.py                    the films: seconds
    python tests/bench/uncertainty.py --engines FOLDER   also engines on coarse grids, a few of them
                                                         against grids and steps four times finer:
                                                         ten minutes

FOLDER keeps the runs of the engines.

A line has the figure, its uncertainty from a second grid and doubled steps, its true error with the
ratio of both, and the estimate from the run alone over that uncertainty and over the differences of
the runs, which have no least size. The last lines count.
"""

import argparse
import shutil
import tempfile
from collections.abc import Iterator
from functools import partial
from itertools import chain
from math import hypot
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import piston_cosim as pc
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.engine.measures import measures
from piston_cosim.master.engine.uncertainty import entry_of
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.second_grid import COARSENING, GRID_SAFETY
from piston_cosim.master.runs.uncertainty import state_uncertainty
from piston_cosim.tests.verification.cases.film import (
    inclined_pad,
    parabolic_slider,
    parabolic_slider_exact,
    pocket_slider,
    squeeze_plate,
)

FINER = 4
"""Cells in each direction and steps of the reference, over those of the engine."""
GRID, USUAL, STEP = 12, 20, 2.0
"""Cells of the engines with a reference and of the others, and their macro step [deg]."""


BODIES, FILM = "participants.bodies", "participants.ehd"


class Row(NamedTuple):
    """True error, uncertainty, estimate and difference of the runs, relative to the value.

    They are None if unknown; `group` has the factors of the estimate fitted to it, or not.
    """

    name: str
    error: float | None
    uncertainty: float
    estimate: float | None = None
    difference: float | None = None
    group: str = ""


class Engine(NamedTuple):
    """Engine of a case with changes, and cells of its films on the grids of bodies."""

    name: str
    case: str
    variant: str | None = None
    changes: dict[str, Any] = {}
    cells: int = USUAL


RIGID = Engine("numerical_example", "numerical_example", "rigid")
FITTED = (
    Engine("data_sheet", "data_sheet"),
    RIGID,
    Engine("fired_motorcycle", "fired_motorcycle", "rigid", {"time.stop": "720 deg"}),
)
"""Engines of the factors of the estimate."""
SLAP = str(Path(pc.__file__).parent / "models/measured/piston_slap")
HELD_OUT = (
    Engine(
        "data_sheet, fast with thick oil",
        "data_sheet",
        None,
        {
            f"{BODIES}.parameters.crank_speed": "3000 rpm",
            f"{FILM}.parameters.viscosity": "12 mPa s",
        },
    ),
    Engine(
        "data_sheet, tight and straight",
        "data_sheet",
        None,
        {
            f"{BODIES}.parameters.radial_clearance": "25 um",
            f"{BODIES}.parameters.barrel": "10 um",
            f"{BODIES}.parameters.ovality": "60 um",
        },
    ),
    Engine("piston_slap", SLAP),
    Engine("ring_pack", "ring_pack"),
    Engine("twin", "twin"),
    Engine(
        "grooved_skirt",
        "grooved_skirt",
        None,
        {
            f"{BODIES}.build.grid": [20, 20],
            f"{BODIES}.build.film_surfaces": [
                {"name": "lower", "rows": [1, 9]},
                {"name": "upper", "rows": [12, 20]},
            ],
            **{
                f"participants.{side}_film.{key}": value
                for side in ("lower", "upper")
                for key, value in (
                    ("build.grid", [20, 9]),
                    ("parameters.skirt_length", "37.26 mm"),
                )
            },
        },
        0,
    ),
    Engine(
        "floating_pin",
        "floating_pin",
        None,
        {f"{BODIES}.build.grid": [20, 20], "participants.skirt_film.build.grid": [20, 20]},
        0,
    ),
)
"""Engines that no factor was fitted to; those with 0 cells have their grids in the changes."""
FEW_MODES = {f"{BODIES}.build.{body}.modes": 12 for body in ("piston", "block")}
KNOWN = (
    Engine("data_sheet", "data_sheet", cells=GRID),
    RIGID._replace(changes={"time.stop": "360 deg"}, cells=GRID),
    Engine(
        "numerical_example, 12 modes",
        "numerical_example",
        "flexible",
        {"time.stop": "360 deg"} | FEW_MODES,
        GRID,
    ),
)
"""Engines with true errors."""


def of_grids(name, solve, cells, exact) -> Iterator[Row]:
    """Yield the rows of a film on `cells`, with the uncertainty of Eq. (X48) from a second grid."""
    own, second = solve(cells), solve(2 * round(cells / COARSENING / 2))
    for k, (value, other, true) in enumerate(zip(own, second, exact)):
        if true is None:
            continue
        error, spread = abs(value - true), GRID_SAFETY * abs(value - other)
        yield Row(f"{name} {k + 1}", error / abs(true), spread / abs(true))


def films() -> Iterator[Row]:
    """Yield the figures of films with closed forms and series."""
    for ratio in (0.5, 1.0, 2.0):
        twice = 2.0 + ratio
        exact = (
            6.0 / ratio**2 * (np.log1p(ratio) - 2.0 * ratio / twice),
            4.0 * np.log1p(ratio) / ratio - 6.0 / twice,
            3.0 * ratio / (2.0 * (1.0 + ratio) * twice),
        )
        yield from of_grids(f"pad K={ratio:g}", partial(inclined_pad, ratio=ratio), 40, exact)
    for curvature in (0.5, 1.0, 2.0, 10.0):
        exact = parabolic_slider_exact(curvature)
        name = f"parabolic slider c={curvature:g}"
        yield from of_grids(name, partial(parabolic_slider, curvature=curvature), 40, exact)
    yield from of_grids("squeeze plate", squeeze_plate, 20, (0.421731, 0.88404))
    pocket = 5.0020833e-7, 4.212927e-3, 475e3, 2779.753
    yield from of_grids("pocket slider", pocket_slider, 200, pocket)


def engines(folder: Path) -> Iterator[Row]:
    """Yield the figures of engines against finer grids and steps, then those with estimates."""
    for group, members in (("known", KNOWN), ("fitted", FITTED), ("held out", HELD_OUT)):
        for engine in members:
            yield from of_engine(folder, engine, group)


def of_engine(folder: Path, engine: Engine, group: str) -> Iterator[Row]:
    """Yield the figures of an engine, those of the group "known" with true errors."""
    case = pc.open_case(engine.case, engine.changes, engine.variant)
    file = folder / f"{engine.name}_{engine.cells}.h5"
    tree, known = _run(case, engine.cells, STEP, file), {}
    if group == "known":
        reference = folder / f"{engine.name}_{FINER * engine.cells}.h5"
        _run(case, FINER * engine.cells, STEP / FINER, reference)
        known = _figures(reference)
    with tempfile.TemporaryDirectory() as scratch:
        computed = Path(shutil.copy(file, scratch))
        entries = state_uncertainty(tree, case.path.parent, computed, lambda line: None)
        estimates, found = _figures(file), _figures(computed)
    for key, one in found.items():
        spread, size = one.uncertainty.value, abs(one.value)
        if not spread or not size or entry_of("grid", key) not in entries:
            continue
        parts = [entries.get(entry_of(cause, key), 0.0) for cause in ("grid", "step")]
        error = abs(one.value - known[key].value) / size if key in known else None
        yield Row(
            f"{engine.name}: {key}",
            error,
            spread / size,
            estimates[key].uncertainty.value / size,
            hypot(*parts) / size,
            group,
        )


def _run(case, cells, step, file):
    """Run a case on a grid unless its file exists, 0: its own; return its tree."""
    builds = {name: table.get("build", {}) for name, table in case.tree["participants"].items()}
    grids = {
        f"participants.{name}.build.grid": [cells, cells]
        for name, build in builds.items()
        if cells and "grid" in build
    }
    changed = case.changed(grids | {"time.step": f"{step:g} deg"})
    if not file.exists():
        changed.run(file).close()
    return changed.tree


def _figures(path):
    """Return the measures of a results file by name, without repetitions of one figure."""
    with Results(path) as results:
        table = measures(check_case(results.case, path), results)
    skipped = {"mean_friction_power_w_ehd"}
    return {
        one.name: one
        for one in table.estimated
        if one.name not in skipped and not one.key.startswith("largest")
    }


def main():
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--engines", type=Path)
    folder = parser.parse_args().engines
    rows = []
    for row in chain(films(), engines(folder) if folder else ()):
        rows.append(row)
        error, estimate = row.error, row.estimate
        shown = f"{row.name:75s} {row.uncertainty:9.2%}"
        if error is not None:
            ratio = row.uncertainty / error if error else np.inf
            shown += f" {error:9.2%} {ratio:8.2f} {'inside' if ratio >= 1.0 else 'OUTSIDE':7s}"
        if estimate is not None:
            shown += f" {estimate / row.uncertainty:8.2f} {over(estimate, row.difference):8.2f}"
        print(shown, flush=True)
    known = [row for row in rows if row.error is not None]
    inside = sum(row.error <= row.uncertainty for row in known)
    median = np.median([row.uncertainty / row.error for row in known if row.error])
    print(f"inside: {inside} of {len(known)}, median of uncertainty over error: {median:.2f}")
    estimated = [row for row in known if row.estimate is not None]
    inside = sum(row.error <= row.estimate for row in estimated)
    print(f"true errors inside the estimate: {inside} of {len(estimated)}")
    for group in ("fitted", "held out"):
        members = [row for row in rows if row.group == group]
        for word, of in (("uncertainty", "uncertainty"), ("differences of runs", "difference")):
            ratios = [over(row.estimate, getattr(row, of)) for row in members]
            within = sum(1 / 3 <= ratio <= 3 * (1 + 1e-9) for ratio in ratios)
            low = sum(ratio < 1 / 3 for ratio in ratios)
            print(f"{group}, estimate within 3 of {word}: {within} of {len(ratios)}, {low} below")


def over(one: float, other: float) -> float:
    """Return a ratio, infinite for a divisor of 0."""
    return one / other if other else np.inf


if __name__ == "__main__":
    main()
