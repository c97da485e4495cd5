"""`piston-cosim calibrate`."""

import csv
from pathlib import Path

import numpy as np
from rich.table import Table

from ..fmi.errors import for_all
from ..fmi.quantities import numbers_text
from ..results.compare import deviations, have_bands, outside_text, read_measured
from ..results.file import Results
from ..runs.calibration import calibrate
from ..runs.design_space import DesignSpace, range_of
from ..runs.pool import LocalPool
from ..runs.sensitivities import Runs, use_of
from .common import Changes, Only, OutputFolder, Workers, changed_case, console, print_line, say


def command(
    case: str,
    /,
    *,
    measured: Path,
    vary: list[str],
    set_: Changes = [],
    only: Only = None,
    output: OutputFolder | None = None,
    workers: Workers | None = None,
):
    """Fit numbers of a case to measured curves.

    The command prints each number with its interval at 95 %, and the numbers that the measurement
    cannot tell apart. It writes them to calibration.csv, and the results of the case and of the
    fit. A repeated call reuses finished runs.

    Example: piston-cosim calibrate data_sheet --measured bench.csv
    --vary "viscosity=4 mPa s..14 mPa s"

    Parameters
    ----------
    case
        Name of a case, its folder or its file. `piston-cosim list` prints the names.
    measured
        CSV file of measured curves, as for `results report --measured`. A band counts as two
        standard deviations; all curves need one, or none.
    vary
        KEY=LOW..HIGH, repeatable: number to fit. Keys joined by + have one value.
    set_
        Change of the case in all runs, KEY=VALUE; repeatable.
    only
        Variant of the case to run. Default: the case itself.
    output
        Folder. Default: results/calibrate_CASE. Finished runs in it are reused.
    workers
        Number of processes. Default: the number of processors.
    """
    path, _, tree, folder = changed_case(case, set_, only, output, "calibrate")
    columns = read_measured(measured)
    ranges = for_all(lambda text: range_of(tree, text, path.parent, "--vary"), vary)
    numbers = [number for number, *_ in ranges]
    bounds = [(low, high) for _, low, high in ranges]
    has_bands = have_bands(columns)
    with use_of(folder), LocalPool(workers) as executor:
        runs = Runs(tree, path, DesignSpace(tuple(numbers)), folder, executor)

        def residuals(designs):
            shown = []
            for row in runs.rows(designs):
                if row["status"] == "done":
                    with Results(row["results"]) as results:
                        shown.append(deviations(results.last, columns))
                else:
                    say(f"a run failed: {row['message']}")
                    shown.append(None)
            if len(shown) == 1 and shown[0] is not None and shown[0].size:
                print_line(f"rms deviation {np.sqrt(np.mean(shown[0] ** 2)):.4g}")
            return shown

        fit = calibrate(residuals, bounds, has_bands)
        before, after = runs.rows([np.zeros(len(numbers)), fit.shares])
    _print(numbers, fit)
    with Results(before["results"]) as results:
        if text := outside_text(results.last, columns):
            say(text)
    for number, share, ends in zip(numbers, fit.shares, bounds):
        if np.abs(np.subtract(ends, share)).min() < AT_END:
            say(f"warning: {number.name} ends at an end of its range; its interval does not count")
    for name, row in (("case", before), ("result", after)):
        print_line(f"results  {name}: {row['results']}")
    with open(folder / "calibration.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["number", "value", "half width at 95 %", "unit"])
        for number, share, half in zip(numbers, fit.shares, fit.half_widths):
            value = number.value + share * number.scale
            writer.writerow([number.name, value, half * number.scale, number.unit])
    print_line(f"table    {folder / 'calibration.csv'}")


AT_END = 1e-3
"""Distance in shares up to which a number is at an end of its range."""


def _print(numbers, fit):
    """Print the fitted numbers, what cannot be told apart, and both deviations."""
    table = Table("", "case", "fit, 95 %", box=None, pad_edge=False)
    for number, share, half in zip(numbers, fit.shares, fit.half_widths):
        value = number.value + share * number.scale
        text = numbers_text(value, half * number.scale) if np.isfinite(half) else "not determined"
        table.add_row(
            number.name, f"{number.value:.6g} {number.unit}", f"{text} {number.unit}".strip()
        )
    console.print(table, highlight=False, markup=False)
    for i, k, related in fit.alike:
        names = f"{numbers[i].name} and {numbers[k].name}"
        say(f"warning: the measurement cannot tell {names} apart (correlation {related:+.3f})")
    print_line(f"rms deviation {fit.before:.4g} of the case, {fit.after:.4g} of the fit")
