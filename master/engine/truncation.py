"""Truncation error of the modes of flexible bodies in a finished run."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..fmi.tree import import_part
from ..results.recorded import add_to_summary

TRUNCATIONS = "fmu_mfbd.truncations"
"""Module with `truncations(options, folder, results, progress)`, called by name."""


def state_truncation(
    tree: dict[str, Any], folder: Path, results: Path, progress: Callable[[str], object]
) -> dict[str, float | str]:
    """Add the truncation error of the bodies' static deflection to the summary of a finished run.

    See Eq. (J17) of the bodies.

    Parameters
    ----------
    tree, folder
        TOML tree of the run's case, and the folder of its paths.
    results : Path
    progress : callable
        Called with progress messages.

    Returns
    -------
    dict of str to float or str
        Added entries: `truncation_error_NAME` [-] of each flexible body over all recorded instants,
        `truncation_error_NAME_largest` of the worst instant, and `truncation_error_film`
        (Eq. (J34)) if the film thickness was recorded. `truncation_error_edge` is the error of the
        skirt under a narrow patch at its edge (Eq. (J47)). `odd_part_film` is the odd part of the
        film (Eq. (J49)) if modes assume a symmetric one. `truncation_error` is the reason if the
        error is unknown. Empty for a case without flexible bodies of the package `fmu_mfbd`.
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
        truncations = part.truncations(build, folder, results, progress)
    except ValueError as why:
        entries["truncation_error"] = f"unknown: {why}"
    else:
        for name, one in truncations.bodies.items():
            entries[f"truncation_error_{name}"] = one.error
            entries[f"truncation_error_{name}_largest"] = one.largest
        shares = {
            "truncation_error_film": truncations.share_of_film,
            "truncation_error_edge": truncations.edge_error,
            "odd_part_film": truncations.odd_share,
        }
        entries |= {key: share for key, share in shares.items() if share is not None}
    if entries:
        add_to_summary(results, entries)
    return entries
