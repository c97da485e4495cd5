"""End of a run: summary entries that need its results file."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..engine.truncation import state_truncation


def complete(
    tree: dict[str, Any],
    folder: Path,
    output: Path,
    progress: Callable[[str], object],
    uncertainty: bool = False,
) -> dict[str, float | str]:
    """Add the truncation error, and uncertainties if wanted, to the summary of a finished run.

    Parameters
    ----------
    tree, folder
        TOML tree of the run's case, and the folder of its paths.
    output : Path
        Results file of the run.
    progress : callable
        Called with messages.
    uncertainty : bool
        Compute the uncertainty of the main results from a second grid and doubled steps.

    Returns
    -------
    dict of str to float or str
        Added entries, see `state_truncation` and `state_uncertainty`.
    """
    added = state_truncation(tree, folder, output, progress)
    if uncertainty:
        from .uncertainty import state_uncertainty  # slow to import

        progress(f"{output.stem}: computing uncertainties from a second grid and doubled steps")
        added |= state_uncertainty(tree, folder, output, progress)
    return added
