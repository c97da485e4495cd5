"""What the modes of flexible bodies leave out of a finished run, by the part that knows them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..fmi.tree import import_part
from ..results.file import add_to_summary

TRUNCATIONS = "fmu_mfbd.truncations"
"""Module with `truncations(options, folder, results, progress)`, called by name."""


def state_truncation(
    tree: dict[str, Any], folder: Path, results: Path, progress: Callable[[str], object]
) -> dict[str, float | str]:
    """Add to a finished run's summary how far the reduced bodies' static deflection under the film
    of that run stands from the whole bodies' (Eq. (J17) of the bodies).

    Parameters
    ----------
    tree, folder
        Of the run's case; its paths begin in `folder`.
    results : Path
    progress : callable
        Takes a sentence now and then.

    Returns
    -------
    dict of str to float or str
        What was added: `truncation_error_NAME` [-] of each flexible body, over all recorded
        instants, `truncation_error_NAME_largest` of the worst one, and `truncation_error_film`
        (Eq. (J34)) if the film thickness was recorded; or `truncation_error`, why it cannot be
        said. Nothing of a case without flexible bodies of the package `fmu_mfbd`.
    """
    package, _, _ = TRUNCATIONS.partition(".")
    builds = [
        table["build"]
        for table in tree.get("participants", {}).values()
        if table.get("package") == package and "build" in table
    ]
    if len(builds) != 1:
        return {}
    (build,) = builds
    entries: dict[str, float | str] = {}
    try:
        part: Any = import_part(TRUNCATIONS)
        found = part.truncations(build, folder, results, progress)
    except ValueError as why:
        entries["truncation_error"] = f"not known: {why}"
    else:
        for name, one in found.bodies.items():
            entries[f"truncation_error_{name}"] = one.error
            entries[f"truncation_error_{name}_largest"] = one.largest
        if found.share_of_film is not None:
            entries["truncation_error_film"] = found.share_of_film
    if entries:
        add_to_summary(results, entries)
    return entries
