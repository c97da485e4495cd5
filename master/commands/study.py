"""`piston-cosim study`."""

from math import isnan, nan
from pathlib import Path

from rich.table import Table

from ..case.reading import find_case, name_of_case
from ..fmi.quantities import numbers_text
from ..results.words import entry_shown
from ..runs import studies
from ..runs import sweep as sweeps
from ..runs.pool import LocalPool
from .common import (
    Changes,
    Format,
    OutputFolder,
    Workers,
    console,
    draw_pictures,
    parse_changes,
    print_line,
    say,
)


def command(
    case: str,
    name: str,
    /,
    *,
    set_: Changes = [],
    output: OutputFolder | None = None,
    workers: Workers = 1,
    format: Format = "png",
):
    """Run a study of a case.

    The command prints the cost of each run and its distance from the reference run, and draws
    pictures. If the study has sizes, the command also prints the value to which each summary entry
    tends, with its uncertainty and the observed order. It skips runs that an earlier call finished.

    Example: piston-cosim study numerical_example modes

    Parameters
    ----------
    case
        Name of a case, its folder or its file. `piston-cosim list` prints the names.
    name
        Name of the study: a table `studies.NAME` of the case file.
    set_
        Change of the case in all runs, KEY=VALUE; repeatable. Overrides the study.
    output
        Folder. Default: results/study_CASE_NAME.
    workers
        Number of processes. More than one disturbs the wall times.
    format
        Type of the pictures.
    """
    path = find_case(case)
    checked, chosen, points = studies.study_points(path, parse_changes(set_), name)
    folder = output or Path("results") / f"study_{name_of_case(path)}_{name}"
    sweeps.build_all(sweeps.unfinished(points, folder), path.parent, say)

    def watch(row, done, total):
        print_line(
            f"{done}/{total}  {row['status']:9s}  {row['run']}  {row['message']}", markup=False
        )

    with LocalPool(workers) as executor:
        rows = sweeps.sweep(points, path.parent, folder, executor, watch)
    runs = studies.open_points(points, rows, folder)
    study_rows = studies.study_rows(chosen, checked, rows, runs)
    costs = {row.run: row.cost._asdict() if row.cost else {} for row in study_rows}
    console.print(_shown(costs, f"{chosen.title}: cost", studies.Cost._fields))
    orders = studies.observed_orders(chosen, study_rows)
    last = {"observed order": orders} if orders else {}
    if chosen.summary:
        console.print(_summary(study_rows, chosen.summary, studies.limits(chosen, study_rows)))
    if chosen.curves:
        distances = {row.run: row.distances for row in study_rows} | last
        title = f"rms distance from {chosen.reference} / its range"
        console.print(_shown(distances, title, chosen.curves))
    missed = {row.run: row.truncation for row in study_rows if row.truncation}
    if missed:
        names = list(dict.fromkeys(name for row in missed.values() for name in row))
        console.print(_shown(missed, "what the modes leave out of the deflection", names))
    print_line(
        f"table    {sweeps.write_table([row.record() for row in study_rows], folder / 'study.csv')}"
    )
    draw_pictures(checked, runs, folder, format)


def _summary(said, names, limits):
    """Return the table of summary entries in suitable units, and the limits to which they tend."""
    columns = []
    for name in names:
        values = [row.summary.get(name, nan) for row in said]
        limit = limits.get(name)
        more = [limit.value, limit.uncertainty] if limit else []
        entry = entry_shown(name, [*values, *more])
        cells = ["" if isnan(value) else _digits(value) for value in entry.values[: len(values)]]
        if limit:
            order = "none" if isnan(limit.order) else f"{limit.order:.2g}"
            cells += [numbers_text(*entry.values[len(values) :]), order]
        columns.append((entry.label, cells))
    table = Table("", *(head for head, _ in columns), box=None, title="summary")
    ends = ["extrapolated", "observed order"] if limits else []
    for k, label in enumerate([*(row.run for row in said), *ends]):
        table.add_row(label, *(cells[k] for _, cells in columns))
    return table


def _shown(values, title, names):
    """Return a table of the named values of every run; missing values are empty."""
    heads = [name.split(".")[-1].replace("_", " ") for name in names]
    shown = Table("", *heads, box=None, title=title)
    for run, row in values.items():
        shown.add_row(run, *(_digits(row.get(name, "")) for name in names))
    return shown


def _digits(value):
    return value if isinstance(value, str) else f"{value:.4g}"
