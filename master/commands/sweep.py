"""`piston-cosim sweep`."""

import sys
from contextlib import ExitStack
from typing import Annotated

from cyclopts import Parameter

from ..case.checked import check_case
from ..engine.measures import directions
from ..fmi.errors import BadInput, for_all
from ..fmi.quantities import positive_si
from ..runs import sweep as sweeps
from ..runs.pool import LocalPool
from ..runs.working import working
from .app import say_faults
from .common import (
    Changes,
    Only,
    OutputFolder,
    Workers,
    changed_case,
    console,
    page_of,
    print_compared,
    print_line,
    say,
    warn_of_estimates,
)


def command(
    case: str,
    /,
    *,
    vary: list[str],
    set_: Changes = [],
    only: Only = None,
    output: OutputFolder | None = None,
    workers: Workers | None = None,
    dask: str | None = None,
    time_limit: str | None = None,
    reports: bool = False,
    uncertainty: Annotated[bool, Parameter(negative=())] = False,
):
    """Run a case over values of its keys.

    The command writes one row per run to sweep.csv, and the page sweep.html with Pareto front,
    parallel coordinates and response surface. A second sweep in the same folder becomes
    sweep_2. The table has the uncertainty of each main result, and the worst check. If there are
    two points, the command also prints their comparison.

    A repeated call continues where the first stopped and repeats failed points. A failed point is a
    row with its reason, and the exit code is then 1.

    Example: piston-cosim sweep fired_motorcycle --vary radial_clearance=10um..60um:6
    --vary "ovality=100um;200um"

    Parameters
    ----------
    case
        Name of a case, its folder or its file. `piston-cosim list` prints the names.
    vary
        KEY=LOW..HIGH:COUNT or KEY=VALUE;VALUE, repeatable. KEY is a dotted path or its last part.
        Keys joined by + change together.
    set_
        Change of the case in all runs, KEY=VALUE; repeatable.
    only
        Variant of the case to run. Default: the case itself.
    output
        Folder. Default: results/sweep_CASE.
    workers
        Number of local processes. Default: the number of processors.
    dask
        Address of a Dask scheduler that replaces the local processes, tls://HOST:PORT. Its workers
        must see the same folders. Everyone who reaches a tcp:// scheduler can run code.
    reports
        Write a report of every finished point and link it from the page. A report takes seconds and
        2 MB or more.
    uncertainty
        Compute the uncertainties from a second grid and doubled steps, which takes up to 0.8 of the
        time of each run. Default: estimates from each run alone.
    time_limit
        Maximum time per point, e.g. "20 min". Local processes only.
    """
    if dask and time_limit:
        raise BadInput("--time-limit: expected nothing with --dask, got a time")
    limit = positive_si("--time-limit", time_limit, "s") if time_limit else None
    if dask and not dask.startswith("tls://"):
        say(f"warning: --dask {dask}: no TLS, everyone who reaches it can run code; use tls://")
    path, changes, tree, folder = changed_case(case, set_, only, output, "sweep")
    axes = for_all(lambda text: sweeps.parse_axis(text, tree, path.parent), vary)
    varied = [key for axis in axes for key in axis.keys]
    for key in sorted({one for one in varied if varied.count(one) > 1}):
        raise BadInput(f"--vary: expected different keys, got {key} twice")
    points = sweeps.all_points(path, changes, axes)
    if uncertainty:
        warn_of_estimates({"first point": points[0].tree}, path.parent)
    table = sweeps.table_for(folder, points)
    if table.stem != "sweep":
        say(f"{folder}: holds the table of another sweep; this one's is {table.name}")
    sweeps.build_all(sweeps.unfinished(points, folder, uncertainty), path.parent, say)

    def watch(row, done, total):
        shown = "  ".join(f"{axis.name.split('.')[-1]} {row[axis.name]}" for axis in axes)
        print_line(f"{done}/{total}  {row['status']:9s}  {shown}  {row['message']}", markup=False)

    try:
        with sweeps.dask_executor(dask) if dask else LocalPool(workers, limit) as executor:
            rows = sweeps.sweep(points, path.parent, folder, executor, watch, uncertainty)
    except KeyboardInterrupt:
        say("finished points are saved; repeat the call to continue")
        raise
    print_line(f"table    {table}")
    is_pair = len(rows) == 2 and all(row["status"] == "done" for row in rows)
    sentence = _compare(points, folder) if is_pair else ""
    by_name = directions(check_case(tree, path))
    with working(console, "drawing the page"):
        page = _page(path, points, rows, axes, by_name, table, reports, sentence)
    print_line(f"page     {page}")
    failed = [row for row in rows if row["status"] != "done"]
    if failed:
        say_faults(
            f"{len(failed)} of {len(rows)} points failed:[/] call again to try them again", []
        )
        sys.exit(2 if all(row["status"] == "bad input" for row in rows) else 1)


def _compare(points, folder):
    """Print the comparison of two points, and return its headline, "" for two points of one run."""
    from ..results.file import Results

    with ExitStack() as opened:
        files = [folder / "runs" / f"{point.name}.h5" for point in points]
        runs = {file.stem: opened.enter_context(Results(file)) for file in files}
        return print_compared(runs) if len(runs) == 2 else ""


def _page(path, points, rows, axes, wanted, table, reports, sentence):
    """Write the page of the sweep and the missing reports of its points."""
    from ..results.file import Results
    from ..results.sweep_page import SweptPoint, write_sweep_page

    folder = table.parent
    swept = []
    for point, row in zip(points, rows):
        file = folder / "runs" / f"{point.name}.h5"
        page = folder / "reports" / point.name / "report.html"
        is_missing = reports and not page.is_file()
        if row["status"] == "done" and file.is_file() and is_missing:
            with Results(file) as results:
                case, runs = check_case(results.case, file), {point.name: results}
                page_of(case, runs, page.parent, source=str(path))
        link = page.relative_to(folder).as_posix() if page.is_file() else ""
        swept.append(SweptPoint(row, link))
    varied = [axis.name for axis in axes]
    return write_sweep_page(swept, varied, wanted, table.with_suffix(".html"), sentence)
