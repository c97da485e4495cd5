"""Uncertainty of the figures of a finished run from a second grid and longer steps.

One or two more runs of the case continue from its last settled state: one on a coarser grid, and
one on that grid with doubled steps. The first takes 0.8 of the time of a period of 40 x 40 cells,
and the second 0.5. A run of one or two periods has the second alone, so that the whole takes at
most 1.7 times as long.
"""

import json
import tempfile
from collections.abc import Callable
from copy import deepcopy
from math import sqrt
from pathlib import Path
from typing import Any

from ..case.checked import check_case
from ..case.contract import players
from ..case.system import open_system
from ..engine.measures import Measures, measures
from ..engine.uncertainty import entry_of
from ..fmi.errors import BadInput, Stopped
from ..fmi.quantities import are_compatible, quantity
from ..results.file import Results
from ..results.recorded import add_to_summary
from .run import run

COARSER = sqrt(2.0)
"""Cells of the grid over those of the second one, in each direction."""
LONGER = 2.0
"""Steps of the third run over those of the others."""
GRID_SAFETY, STEP_SAFETY = 3.0, 1.25
"""Factors of safety on differences between two grids and between two steps [Roache1994]. With grids
in the ratio of 1.41, 3 is the factor of an order of 2 with the safety 3, and that of an order of 1
with the safety 1.25. With doubled steps, 1.25 is the factor of an order of 1 with the safety 1.25,
and exceeds that of an order of 2 with the safety 3."""
SHARE, LEAD = 3, 0.25
"""Periods of the run for each whole period of a further one, and the part of a period before these.
The film starts full, and the lead forgets it."""
Trees = Callable[[], list[dict[str, Any]]]
"""Function that returns the trees of further runs."""
START = ("crank_angle", "rotation_speed", "lateral_displacement", "rocking_angle")
"""Outputs of bodies that a start needs, with the velocities of the last two."""


def state_uncertainty(
    tree: dict[str, Any], folder: Path, output: Path, progress: Callable[[str], object]
) -> dict[str, float | str]:
    """Add the uncertainty from grid and step to the summary of a finished run.

    Eq. (X48):  u_grid = 3 (f - f_grid),   u_step = 1.25 (f_grid - f_both)
                f is a figure of the run, f_grid that on the second grid, f_both that on the second
                grid with doubled steps; the sign tells errors that two runs share

    Without f_grid, u_grid is 3 (f - f_both), which contains the step. Doubled steps and 1.41 times
    the cell size double the errors of first order in time and of second order in space alike.

    Parameters
    ----------
    tree, folder
        TOML tree of the run's case, and the folder of its paths.
    output : Path
        Results file of the run.
    progress : callable
        Called with messages.

    Returns
    -------
    dict of str to float or str
        Added entries `uncertainty_CAUSE_NAME` in SI, or `uncertainty_reason` if there are none.

    References
    ----------
    [Roache1994]
    """
    entries: dict[str, float | str] = {}
    with Results(output) as results, tempfile.TemporaryDirectory() as scratch:
        own = measures(check_case(results.case, folder), results)
        for trees in attempts(tree, results, Path(scratch)):
            try:
                found = [
                    _measured(one, folder, Path(scratch) / f"{k}.h5", progress)
                    for k, one in enumerate(trees())
                ]
            except (BadInput, Stopped) as why:
                entries = {"uncertainty_reason": str(why).splitlines()[0]}
            else:
                entries = {**differences(own, *found)}
                break
    add_to_summary(output, entries)
    return entries


def attempts(tree: dict[str, Any], results: Results, scratch: Path) -> list[Trees]:
    """Return functions that return the trees of further runs, each for use if those before fail.

    A start does not fit other modes, so that flexible bodies begin again as their case does.
    """
    base = continued(tree, results, scratch)
    whole: Trees = lambda: [longer(coarser(tree))]  # noqa: E731
    if base is tree:
        return [whole]
    both = [coarser] if _periods(results) >= SHARE else []
    return [lambda: [*(make(base) for make in both), longer(coarser(base))], whole]


def differences(own: Measures, *others: Measures) -> dict[str, float]:
    """Return the uncertainties of measures by Eq. (X48), as entries of the summary.

    `others` are the measures on the second grid, if there are two, and those with doubled steps.
    """
    entries: dict[str, float] = {}
    for one in own.estimated:
        found = [table.of(one.key, one.owner) for table in others]
        values = [other.value for other in found if other]
        if len(values) < len(others):
            continue
        entries[entry_of("grid", one.name)] = GRID_SAFETY * (one.value - values[0])  # Eq. (X48)
        if len(values) > 1:
            entries[entry_of("step", one.name)] = STEP_SAFETY * (values[0] - values[1])
    return entries


def _periods(results):
    """Return the number of periods of a finished run."""
    return (results.summary or {}).get("periods", 0)


def coarser(tree: dict[str, Any]) -> dict[str, Any]:
    """Return the tree with fewer cells, an even number around.

    Raises `BadInput` if a film has no grid, or a body has several film surfaces.
    """
    made = deepcopy(tree)
    builds = [table.get("build", {}) for table in made["participants"].values()]
    if any("film_surfaces" in build for build in builds):
        raise BadInput("expected one film surface of a body, got several")
    films = players(tree, "lubrication")
    lacking = [name for name in films if "grid" not in tree["participants"][name].get("build", {})]
    if lacking or not films:
        got = (
            f"none in {', '.join(lacking)}" if lacking else 'no participant with role "lubrication"'
        )
        raise BadInput(f"expected films with build.grid, got {got}")
    for build in builds:
        if "grid" in build:
            build["grid"] = [max(4, 2 * round(n / COARSER / 2)) for n in build["grid"]]
    return made


def longer(tree: dict[str, Any]) -> dict[str, Any]:
    """Return the tree with longer macro steps."""
    made = deepcopy(tree)
    time = made["time"]
    time |= {key: _times(time[key], LONGER) for key in ("step", "smallest_step") if key in time}
    return made


def _times(text, factor):
    """Return a quantity times a number."""
    one = quantity(text)
    return f"{factor * one.magnitude:.12g} {one.units:~}"


def continued(tree, results, scratch):
    """Return the tree of a run from the last settled state; the whole run if it has one period."""
    periods = _periods(results)
    case = check_case(tree, scratch)
    if periods < 2 or not case.time.until_periodic or not case.period:
        return tree
    made = deepcopy(tree)
    for name in players(tree, "bodies"):
        ports = [port for port in results.ports if port.startswith(f"{name}.")]
        values = {port.partition(".")[2]: results.series(port).values[-1] for port in ports}
        if not {*START} <= {*values} or "build" not in made["participants"][name]:
            return tree
        path = scratch / f"{name}.json"
        path.write_text(json.dumps({key: value.tolist() for key, value in values.items()}))
        made["participants"][name]["build"]["start"] = str(path)
    count = max(1, periods // SHARE) + lead(case.period, case.time.step)
    made["time"]["stop"] = _times(case.period, count)
    return made


def lead(period: str, step: str) -> float:
    """Return the part of a period before the whole ones, a multiple of the longer macro step."""
    whole, one = quantity(period), quantity(step)
    if not are_compatible(whole.units, one.units):
        return 1.0
    steps = whole.to(one.units).magnitude / (LONGER * one.magnitude)
    return round(LEAD * steps) / steps


def _measured(tree, folder, output, progress):
    """Return the measures of a run of a tree."""
    case = check_case(tree, folder)
    run(open_system(case, folder, progress), case, tree, output)
    with Results(output) as results:
        return measures(case, results)
