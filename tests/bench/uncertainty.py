"""Uncertainties next to true errors: closed forms of films, and engines against finer runs.

    python tests/bench/uncertainty.py                    the films: seconds
    python tests/bench/uncertainty.py --engines FOLDER   also two rigid engines against grids and
                                                         steps four times finer: a minute

FOLDER keeps the runs of the engines.

A line has the figure, its uncertainty from a second grid and doubled steps, its true error with the
ratio of both, and the estimate from the run alone over that uncertainty. The last lines count.
"""

import argparse
import shutil
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

import piston_cosim as pc
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.engine.measures import measures
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.uncertainty import COARSER, GRID_SAFETY, state_uncertainty
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


class Row(NamedTuple):
    """True error, uncertainty and estimate of a figure, relative to its value, None if unknown."""

    name: str
    error: float | None
    uncertainty: float
    estimate: float | None = None


def of_grids(name, solve, cells, exact) -> Iterator[Row]:
    """Yield the rows of a film on `cells`, with the uncertainty of Eq. (X48) from a second grid."""
    own, second = solve(cells), solve(2 * round(cells / COARSER / 2))
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
    """Yield the figures of two rigid engines against finer grids and steps, then those of three."""
    one_period = {"time.stop": "360 deg"}
    yield from _engine(folder, "data_sheet", None, {}, finer=True)
    yield from _engine(folder, "numerical_example", "rigid", one_period, finer=True)
    yield from _engine(folder, "data_sheet", None, {})
    yield from _engine(folder, "numerical_example", "rigid", {})
    yield from _engine(folder, "fired_motorcycle", "rigid", {"time.stop": "720 deg"})


def _engine(folder, name, variant, changes, finer=False) -> Iterator[Row]:
    """Yield the figures of an engine, with true errors on the coarse grid, else with estimates."""
    case = pc.open_case(name, changes, variant)
    cells = GRID if finer else USUAL
    file, reference = (folder / f"{name}_{count}.h5" for count in (cells, FINER * cells))
    tree = _run(case, cells, STEP, file)
    if finer:
        _run(case, FINER * cells, STEP / FINER, reference)
    with tempfile.TemporaryDirectory() as scratch:
        computed = Path(shutil.copy(file, scratch))
        state_uncertainty(tree, case.path.parent, computed, lambda line: None)
        estimates, found = _figures(file), _figures(computed)
    known = _figures(reference) if finer else {}
    for key, one in found.items():
        spread, size = one.uncertainty.value, abs(one.value)
        if not spread or not size:
            continue
        if key in known:
            yield Row(f"{name} {key}", abs(one.value - known[key].value) / size, spread / size)
        elif not finer:
            estimate = estimates[key].uncertainty.value / size
            yield Row(f"{name} {key}", None, spread / size, estimate)


def _run(case, cells, step, file):
    """Run a case on a grid unless its file exists; return its tree."""
    grids = {f"participants.{one}.build.grid": [cells, cells] for one in ("bodies", "ehd")}
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
    rows = [*films(), *(engines(folder) if folder else ())]
    for row in rows:
        error, estimate = row.error, row.estimate
        shown = f"{row.name:60s} {row.uncertainty:9.2%}"
        if error is not None:
            ratio = row.uncertainty / error if error else np.inf
            shown += f" {error:9.2%} {ratio:8.2f} {'inside' if ratio >= 1.0 else 'OUTSIDE'}"
        if estimate is not None:
            shown += f" {estimate / row.uncertainty:37.2f}"
        print(shown)
    known = [row for row in rows if row.error is not None]
    inside = sum(row.error <= row.uncertainty for row in known)
    median = np.median([row.uncertainty / row.error for row in known if row.error])
    print(f"inside: {inside} of {len(known)}, median of uncertainty over error: {median:.2f}")
    ratios = [row.estimate / row.uncertainty for row in rows if row.estimate is not None]
    within = sum(1 / 3 <= ratio <= 3 * (1 + 1e-9) for ratio in ratios)
    print(f"estimates within a factor of 3 of the uncertainty: {within} of {len(ratios)}")


if __name__ == "__main__":
    main()
