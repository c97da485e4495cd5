"""`piston-cosim study`."""

from pathlib import Path

from rich.table import Table

from ..case.schema import find_case
from ..results.pictures import draw
from ..runs import studies
from ..runs import sweep as sweeps
from .common import Changes, console, parse_change, say


def command(
    case: str, name: str, *, set_: Changes = [], output: Path | None = None, workers: int = 1
):
    """Run a study of a case: a table of cost and of distance from its reference run, and pictures.

    Example: piston-cosim study numerical_example modes

    Parameters
    ----------
    case
        Name of a case, its folder, or a case file.
    name
        Of the study in the case file ([studies.NAME]).
    set_
        Change of the case in all runs, KEY=VALUE; it overrides the study.
    output
        Folder; default results/study_CASE_NAME. What is there from an earlier start is not run
        again.
    workers
        Processes; more than one disturbs the wall times.
    """
    path = find_case(case)
    checked, chosen, points = studies.study_points(
        path, [parse_change(text) for text in set_], name
    )
    folder = output or Path("results") / f"study_{path.parent.name}_{name}"
    sweeps.build_all(sweeps.unfinished(points, folder), path.parent, say)

    def watch(row, done, total):
        console.print(
            f"{done}/{total}  {row['status']:9s}  {row['run']}  {row['message']}",
            markup=False,
            highlight=False,
            soft_wrap=True,
        )

    with sweeps.local_executor(workers) as executor:
        rows = sweeps.sweep(points, path.parent, folder, executor, watch)
    runs = studies.open_points(points, rows, folder)
    table = studies.study_table(chosen, checked, rows, runs)
    distances = [key for row in table for key in row if key.startswith("rms ")]
    console.print(_shown(table, f"{chosen.title}: cost", studies.COST))
    if distances:
        console.print(
            _shown(
                table,
                f"rms distance from {chosen.reference} / its range",
                list(dict.fromkeys(distances)),
            )
        )
    console.print(
        f"table    {studies.write_table(table, folder / 'study.csv')}",
        highlight=False,
        soft_wrap=True,
    )
    drawn = [studies.draw_cost(chosen.title, table, folder / "cost.png")]
    if chosen.curves:
        drawn.append(studies.draw_study(chosen, checked, table, runs, folder / "study.png"))
    for picture in (*drawn, *draw(checked, runs, folder)):
        console.print(f"picture  {picture}", highlight=False, soft_wrap=True)


def _shown(table, title, keys):
    shown = Table(
        "", *(key.split(".")[-1].replace("_", " ") for key in keys), box=None, title=title
    )
    for row in table:
        shown.add_row(
            row["run"], *(f"{row[key]:.4g}" if row.get(key, "") != "" else "" for key in keys)
        )
    return shown
