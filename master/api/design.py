"""Sensitivities of a case in Python."""

import logging
from collections.abc import Mapping
from pathlib import Path

from ..case.checked import check_case
from ..engine.measures import directions
from ..fmi.errors import BadInput, for_all
from ..runs.design_space import DesignSpace, number_of
from ..runs.pool import LocalPool
from ..runs.sensitivities import Runs, Sensitivity, use_of
from ..runs.sensitivities import sensitivities as sensitivities_of
from .cases import Case

log = logging.getLogger("piston_cosim")


def sensitivities(
    case: Case,
    by: Mapping[str, str | None],
    output: str | Path | None = None,
    workers: int | None = None,
) -> list[Sensitivity]:
    """Return how the main results of a case change with its numbers.

    Every number has two runs, with a step up and a step down.

    Parameters
    ----------
    case : Case
        Case from a file.
    by : mapping
        Key, dotted or short -> step with its unit. None: 2 % of the value.
    output : path, optional
        Folder of the runs. Default: results/sensitivities_NAME. Finished runs are reused.
    workers : int, optional
        Number of processes. Default: number of processors. A script that calls this needs
        `if __name__ == "__main__":` around it, as with all of Python's processes.

    Returns
    -------
    list of Sensitivity
        For each number and figure: `figure` (a column of a sweep), `variable`, `value` of the
        figure, its `change` with the step and the `spread` of that, in the SI unit at the end of
        the figure's name. `is_resolved` says whether the change is larger than its spread. Runs
        that failed have none; the logger "piston_cosim" reports them.

    Raises
    ------
    BadInput
        With every unknown key and every step of another unit, and if the case itself fails.
    """
    if case.own:
        raise BadInput(f"participants: expected FMUs in runs, got objects {', '.join(case.own)}")
    folder = Path(output or Path("results") / f"sensitivities_{case.name}").absolute()
    texts = [key if step is None else f"{key}={step}" for key, step in by.items()]
    numbers = for_all(lambda text: number_of(case.tree, text, case.path.parent, "by"), texts)
    with use_of(folder), LocalPool(workers) as executor:
        runs = Runs(case.tree, case.path, DesignSpace(tuple(numbers)), folder, executor)
        known, failed = sensitivities_of(runs, [*directions(check_case(case.tree, case.path))])
    for row in failed:
        log.warning("a run failed: %s", row["message"])
    return known
