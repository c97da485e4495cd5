"""Sensitivities of a case in Python."""

import logging
from collections.abc import Mapping
from pathlib import Path

from ..case.checked import check_case
from ..engine.measures import directions
from ..fmi.errors import BadInput, for_all
from ..runs.design_space import DesignSpace, number_of
from ..runs.forward import by_differences, forward_or_differences
from ..runs.pool import LocalPool
from ..runs.sensitivities import Runs, Sensitivity, use_of
from .cases import Case

log = logging.getLogger("piston_cosim")


def sensitivities(
    case: Case,
    by: Mapping[str, str | None],
    output: str | Path | None = None,
    workers: int | None = None,
    *,
    forward: bool = False,
) -> list[Sensitivity]:
    """Return how the main results of a case change with its numbers.

    Every number has two runs, with a step up and a step down. With `forward`, one run has the
    derivatives of all its steps, where the case allows it.

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
    forward : bool
        Use the derivative of one run, in this process. The logger "piston_cosim" reports its
        accuracy and what it holds, or why the case has runs with steps up and down instead. The
        file forward/derivatives.npz in the folder has the derivatives of all scalar outputs.

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
        figures = [*directions(check_case(case.tree, case.path))]
        find = forward_or_differences if forward else by_differences
        known, failed, notes = find(runs, figures)
    for note in notes:
        log.info(note)
    for row in failed:
        log.warning("a run failed: %s", row["message"])
    return known
