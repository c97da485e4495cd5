"""`piston-cosim study`."""

from pathlib import Path

from rich.table import Table

from ..case.reading import find_case
from ..results.pictures import draw
from ..runs import studies
from ..runs import sweep as sweeps
from ..runs.pool import LocalPool
from .common import Changes, Format, OutputFolder, Workers, console, parse_changes, say, tell


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
    pictures. It skips runs that an earlier call finished.

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
    folder = output or Path("results") / f"study_{path.parent.name}_{name}"
    sweeps.build_all(sweeps.unfinished(points, folder), path.parent, say)

    def watch(row, done, total):
        tell(f"{done}/{total}  {row['status']:9s}  {row['run']}  {row['message']}", markup=False)

    with LocalPool(workers) as executor:
        rows = sweeps.sweep(points, path.parent, folder, executor, watch)
    runs = studies.open_points(points, rows, folder)
    said = studies.study_rows(chosen, checked, rows, runs)
    costs = {row.run: row.cost._asdict() if row.cost else {} for row in said}
    console.print(_shown(costs, f"{chosen.title}: cost", studies.Cost._fields))
    orders = studies.observed_orders(chosen, said)
    last = {"observed order": orders} if orders else {}
    if chosen.summary:
        values = {row.run: row.summary for row in said} | last
        console.print(_shown(values, "summary [SI]", chosen.summary))
    if chosen.curves:
        distances = {row.run: row.distances for row in said} | last
        title = f"rms distance from {chosen.reference} / its range"
        console.print(_shown(distances, title, chosen.curves))
    missed = {row.run: row.truncation for row in said if row.truncation}
    if missed:
        names = list(dict.fromkeys(name for row in missed.values() for name in row))
        console.print(_shown(missed, "what the modes leave out of the deflection", names))
    tell(f"table    {sweeps.write_table([row.record() for row in said], folder / 'study.csv')}")
    for picture in draw(checked, runs, folder, format):
        tell(f"picture  {picture}")


def _shown(values, title, names):
    """Return a table of the named values of every run; missing values are empty."""
    heads = [name.split(".")[-1].replace("_", " ") for name in names]
    shown = Table("", *heads, box=None, title=title)
    for run, row in values.items():
        shown.add_row(run, *(_digits(row.get(name, "")) for name in names))
    return shown


def _digits(value):
    return value if isinstance(value, str) else f"{value:.4g}"
