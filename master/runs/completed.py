"""Run of an opened system with the summary entries that need its results file."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..engine.truncation import state_truncation
from .run import run


def complete_run(
    system: Any,
    case: Any,
    tree: dict[str, Any],
    output: Path,
    *arguments: Any,
    say: Callable[[str], object],
    uncertainty: bool = False,
    **options: Any,
) -> dict[str, Any]:
    """Run a system, and add the truncation error, and uncertainties if wanted, to its summary.

    Parameters
    ----------
    system, case, tree, output, say, *arguments, **options
        As those of `runs.run.run`.
    uncertainty : bool
        Compute the uncertainty of the main results from a second grid and doubled steps.

    Returns
    -------
    dict
        The summary with the entries of `state_truncation` and `state_uncertainty`.
    """
    summary = run(system, case, tree, output, *arguments, say=say, **options)
    where = tree, Path(system.folder), output, say
    summary |= state_truncation(*where)
    if uncertainty:
        from .uncertainty import state_uncertainty  # slow to import

        say(f"{output.stem}: computing uncertainties from a second grid and doubled steps")
        summary |= state_uncertainty(*where)
    return summary
