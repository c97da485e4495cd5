"""`piston-cosim sweep`."""

import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..case.schema import find_case, read_tree
from ..fmi.errors import BadInput
from ..fmi.quantities import duration
from ..results.sweep_pictures import draw_sweep
from ..runs import sweep as sweeps
from .app import say_faults
from .common import Changes, console, page_of, parse_change, say, variant_trees


def command(
    case: str,
    *,
    vary: Annotated[list[str], Parameter(negative=())],
    set_: Changes = [],
    only: str | None = None,
    output: Path | None = None,
    workers: int | None = None,
    dask: str | None = None,
    time_limit: str | None = None,
    reports: bool = False,
):
    """Run a case many times over values of its keys: one row a run in sweep.csv, a picture, and
    sweep.html, a page with Pareto front, parallel coordinates and response surface; of another
    sweep in the same folder all are kept, and these are sweep_2 and so on.

    Stopped and started again, it goes on where it was, and tries again what has failed. Points that
    fail are rows with their reason, and the exit code is 1 then.

    Example: piston-cosim sweep fired_motorcycle --vary radial_clearance=10um..60um:6 --vary
    ovality=100um;200um

    Parameters
    ----------
    case
        Name of a case, its folder, or a case file.
    vary
        KEY=LOW..HIGH:COUNT or KEY=VALUE;VALUE, the key's dotted path or its last part; keys joined
        by + go together.
    set_
        Change of the case in all runs, KEY=VALUE.
    only
        This variant of the case instead of the case itself.
    output
        Folder; default results/sweep_CASE.
    workers
        Local processes, by default one a processor.
    dask
        Address of a Dask scheduler, tls://HOST:PORT, whose workers see the same folders, instead of
        local processes. tcp:// works too, but anyone who reaches the scheduler can then run code.
    reports
        Write a report of every point that is done, to which the points of the page lead. Each takes
        seconds and 2 MB or more, so not by default: called again with it, a sweep that is done runs
        nothing and gets its reports.
    time_limit
        Longest time for one point, for example "20 min"; it fails then. Of local processes only.
    """
    limit = _seconds(time_limit, dask)
    if dask and not dask.startswith("tls://"):
        say(f"warning: --dask {dask}: no TLS, everyone who reaches it can run code; use tls://")
    path = find_case(case)
    changes = [parse_change(text) for text in set_]
    tree = read_tree(path, changes)
    if only:
        variant_trees(path, changes, only, say)
        changes = [*tree.get("variants", {}).get(only, {}).items(), *changes]
    axes = [sweeps.parse_axis(text, tree, path.parent) for text in vary]
    points = sweeps.all_points(path, changes, axes)
    folder = Path(
        output
        or Path("results") / f"sweep_{path.parent.name if path.name == 'case.toml' else path.stem}"
    )
    folder = folder.absolute()
    table = sweeps.table_for(folder, points)
    if table.stem != "sweep":
        say(f"{folder}: holds the table of another sweep; this one's is {table.name}")
    sweeps.build_all(sweeps.unfinished(points, folder), path.parent, say)

    def watch(row, done, total):
        shown = "  ".join(f"{axis.name.split('.')[-1]} {row[axis.name]}" for axis in axes)
        console.print(
            f"{done}/{total}  {row['status']:9s}  {shown}  {row['message']}",
            markup=False,
            highlight=False,
            soft_wrap=True,
        )

    with sweeps.dask_executor(dask) if dask else sweeps.local_executor(workers, limit) as executor:
        rows = sweeps.sweep(points, path.parent, folder, executor, watch)
    console.print(f"table    {table}", highlight=False, soft_wrap=True)
    picture = draw_sweep(rows, axes, tree.get("summary", {}), table.with_suffix(".png"))
    console.print(f"picture  {picture}", highlight=False, soft_wrap=True)
    with console.status("drawing the page"):
        page = _page(path, points, rows, axes, [*tree.get("summary", {})], table, reports)
    console.print(f"page     {page}", highlight=False, soft_wrap=True)
    failed = [row for row in rows if row["status"] != "done"]
    if failed:
        say_faults(
            f"{len(failed)} of {len(rows)} points failed:[/] call again to try them again", []
        )
        sys.exit(2 if all(row["status"] == "bad input" for row in rows) else 1)


def _page(path, points, rows, axes, weighed, table, reports):
    """The page of the sweep, and the reports of its points that are not there yet."""
    from ..case.schema import check_case
    from ..engine.headlines import measures
    from ..results.file import Results
    from ..results.sweep_page import SweptPoint, write_sweep_page

    folder = table.parent
    swept = []
    for point, row in zip(points, rows):
        file = folder / "runs" / f"{point.name}.h5"
        page = folder / "reports" / point.name / "report.html"
        measured = {}
        if row["status"] == "done" and file.is_file():
            with Results(file) as results:
                measured = measures(results)
                if reports and not page.is_file():
                    case, runs = check_case(results.case, file), {point.name: results}
                    page_of(case, runs, page.parent, source=str(path), figures=False)
        link = page.relative_to(folder).as_posix() if page.is_file() else ""
        weighed = [*weighed, *measured]
        swept.append(SweptPoint(row | measured, link))
    varied = [axis.name for axis in axes]
    return write_sweep_page(swept, varied, weighed, table.with_suffix(".html"))


def _seconds(time_limit, dask):
    """The time limit [s]; None without one."""
    if time_limit is None:
        return None
    if dask:
        raise BadInput("--time-limit: is of local processes only, not of --dask")
    return duration("--time-limit", time_limit)
