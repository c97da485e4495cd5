"""Uncertainty of the figures of a finished run from a second grid and longer steps.

One or two more runs of the case continue from its last settled state: one on a coarser grid, and
one on that grid with doubled steps. The first takes 0.8 of the time of a period of 40 x 40 cells,
and the second 0.5. A run of one or two periods has the second alone, so that the whole takes at
most 1.8 times as long.
"""

import json
import tempfile
from collections.abc import Callable, Container
from copy import deepcopy
from math import gcd
from pathlib import Path
from typing import Any

from ..case.ahead import faults_ahead, run_ahead
from ..case.checked import check_case
from ..case.contract import players
from ..case.system import open_system
from ..engine.measures import Measures, measures
from ..engine.uncertainty import entry_of
from ..fmi.errors import BadInput, Stopped
from ..fmi.quantities import are_compatible, quantity, times
from ..results.file import Results
from ..results.recorded import add_to_summary
from .checkpoint import Interrupted
from .run import run
from .second_grid import GRID_SAFETY, coarser, grid_safety, kept_films, ratio_of

STEP_RATIO = 2
"""Steps of the third run over those of the others, or a little more, see `longer_steps`."""
STEP_SAFETY = 1.25
"""Factor of safety on the difference between two steps [Roache1994]. With doubled steps, it is the
factor of an order of 1 with the safety 1.25, and exceeds that of an order of 2 with the safety 3.
`second_grid.GRID_SAFETY` is the factor of two grids."""
RUN_PERIODS, LEAD_SHARE = 3, 0.25
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
    `grid_safety` replaces the factor 3 if the second grid has another ratio. Without a second grid
    for its film, a figure has the part u_step = 1.25 (f - f_both) only.

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
        Added entries `uncertainty_CAUSE_NAME` in SI, or `uncertainty_reason` if there are none;
        `uncertainty_kept` names films without a second grid.

    Raises
    ------
    Stopped
        If a signal interrupts a further run. The results file is complete then.

    References
    ----------
    [Roache1994]
    """
    entries: dict[str, float | str] = {}
    with Results(output) as results, tempfile.TemporaryDirectory() as scratch:
        own = measures(check_case(results.case, folder), results)
        for trees in attempts(tree, folder, results, Path(scratch)):
            try:
                others = [
                    _measured(one, folder, Path(scratch) / f"{k}.h5", progress)
                    for k, one in enumerate(trees())
                ]
            except Interrupted:
                raise Stopped(
                    "interrupted in a further run for the uncertainties; "
                    f"{output} is complete, with estimates from its run alone"
                ) from None
            except (BadInput, Stopped) as why:
                entries = {"uncertainty_reason": str(why).splitlines()[0]}
            else:
                unrefined = kept_films(tree)
                entries = {
                    **differences(
                        own, *others, safety=grid_safety(ratio_of(tree)), unrefined=unrefined
                    )
                }
                if unrefined:
                    entries["uncertainty_kept"] = ", ".join(sorted(unrefined))
                break
    add_to_summary(output, entries)
    return entries


def reason_ahead(tree: dict[str, Any], folder: Path) -> str:
    """Return why a case allows no further run, "" if nothing is known to prevent it."""
    try:
        faults = faults_ahead(check_case(longest(tree, folder), folder), folder)
    except BadInput as why:
        faults = why.faults
    return faults[0] if faults else ""


def attempts(tree: dict[str, Any], folder: Path, results: Results, scratch: Path) -> list[Trees]:
    """Return functions that return the trees of further runs, each for use if those before fail.

    A start does not fit other modes, so that flexible bodies begin again as their case does.
    """
    base = continued(tree, results, scratch)
    whole: Trees = lambda: [longest(tree, folder)]  # noqa: E731
    if base is tree:
        return [whole]
    both = [coarser] if _periods(results) >= RUN_PERIODS else []
    return [lambda: [*(make(base) for make in both), longest(base, folder)], whole]


def longest(tree: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the tree with fewer cells and longer macro steps."""
    return longer(coarser(tree), longer_steps(tree, folder))


def longer_steps(tree: dict[str, Any], folder: Path) -> float:
    """Return the steps of the third run over those of the case, 2 to 3.

    It is 2 if doubled steps divide the run and its period, and otherwise the smallest factor above,
    for which `STEP_SAFETY` is safe too. Raises `BadInput` if no longer step divides both.
    """
    clock, _ = run_ahead(check_case(tree, folder), folder)
    if clock is None:
        return STEP_RATIO
    total, period = (round(x / clock.step) for x in (clock.stop - clock.start, clock.period))
    common = gcd(total, period if period <= total else 0)
    if common < STEP_RATIO:
        raise BadInput(
            "time.step: expected a longer one that divides run and period, got none for "
            f"{total} and {period} steps"
        )
    return common / (common // STEP_RATIO)


def differences(
    own: Measures, *others: Measures, safety: float = GRID_SAFETY, unrefined: Container[str] = ()
) -> dict[str, float]:
    """Return the uncertainties of measures by Eq. (X48), as entries of the summary.

    `others` are the measures on the second grid, if there are two, and those with doubled steps.
    The films `unrefined` have no second grid.
    """
    entries: dict[str, float] = {}
    for one in own.estimated:
        counterparts = [table.of(one.key, one.owner) for table in others]
        values = [one.value, *(other.value for other in counterparts if other)]
        if len(values) <= len(others):
            continue
        if one.owner not in unrefined:
            entries[entry_of("grid", one.name)] = safety * (one.value - values[1])  # Eq. (X48)
        if one.owner in unrefined or len(others) > 1:
            entries[entry_of("step", one.name)] = STEP_SAFETY * (values[-2] - values[-1])
    return entries


def _periods(results):
    """Return the number of periods of a finished run."""
    return (results.summary or {}).get("periods", 0)


def longer(tree: dict[str, Any], factor: float = STEP_RATIO) -> dict[str, Any]:
    """Return the tree with longer macro steps."""
    changed = deepcopy(tree)
    time = changed["time"]
    time |= {key: times(time[key], factor) for key in ("step", "smallest_step") if key in time}
    return changed


def continued(tree, results, scratch):
    """Return the tree of a run from the last settled state; the whole run if it has one period."""
    periods = _periods(results)
    case = check_case(tree, scratch)
    if periods < 2 or not case.time.until_periodic or not case.period:
        return tree
    changed = deepcopy(tree)
    for name in players(tree, "bodies"):
        ports = [port for port in results.ports if port.startswith(f"{name}.")]
        values = {port.partition(".")[2]: results.series(port).values[-1] for port in ports}
        if not {*START} <= {*values} or "build" not in changed["participants"][name]:
            return tree
        path = scratch / f"{name}.json"
        path.write_text(json.dumps({key: value.tolist() for key, value in values.items()}))
        changed["participants"][name]["build"]["start"] = str(path)
    count = max(1, periods // RUN_PERIODS) + lead(case.period, case.time.step)
    changed["time"]["stop"] = times(case.period, count)
    return changed


def lead(period: str, step: str) -> float:
    """Return the part of a period before the whole ones, a multiple of the longer macro step.

    It is a whole period if doubled steps do not divide the period.
    """
    whole, one = quantity(period), quantity(step)
    if not are_compatible(whole.units, one.units):
        return 1.0
    steps = whole.to(one.units).magnitude / (STEP_RATIO * one.magnitude)
    return round(LEAD_SHARE * steps) / steps if abs(steps - round(steps)) <= 1e-9 * steps else 1.0


def _measured(tree, folder, output, progress):
    """Return the measures of a run of a tree."""
    case = check_case(tree, folder)
    run(open_system(case, folder, progress), case, tree, output)
    with Results(output) as results:
        return measures(case, results)
