"""`piston-cosim results report`."""

from pathlib import Path

from ...results.compare import agreement, outside_text, read_measured
from ...runs.working import working
from ..common import OutputFolder, console, open_runs, page_of, print_line


def command(
    *files: Path,
    output: OutputFolder = Path("report"),
    measured: Path | None = None,
    case: str | None = None,
):
    """Write an HTML report about results files.

    The page is one self-contained file. The case of the first file describes what it shows.

    Example: piston-cosim results report results/fired_motorcycle/flexible.h5
    results/fired_motorcycle/rigid.h5 --output report

    Parameters
    ----------
    files
        Results files.
    output
        Folder for report.html.
    measured
        CSV file of a measurement. Its header is "participant.variable [unit]", abscissa first. The
        columns "participant.variable low [unit]" and "participant.variable high [unit]" are a band.
    case
        Case whose folder contains the meshes. Default: the case with the name of the results
        folder, then the shipped case with the title of the run. If the meshes are missing, the page
        shows no bodies.
    """
    described, runs = open_runs(files)
    columns = read_measured(measured) if measured else {}
    compared = agreement(runs, columns) if columns else None
    for results in runs.values() if columns else ():
        if text := outside_text(results, columns):
            print_line(text)
    with working(console, "drawing the page"):
        page = page_of(described, runs, output, source=case, measured=compared)
    print_line(f"report   {page}")
