"""`piston-cosim results report`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ...fmi.errors import BadInput
from ...results.compare import check_measured, measured_section, read_measured
from ..common import console, open_runs, page_of


def command(
    *files: Path,
    output: Path = Path("report"),
    notes: Path | None = None,
    study: Annotated[list[Path], Parameter(negative=())] = [],
    measured: Path | None = None,
    case: str | None = None,
):
    """Write one self-contained HTML page about one or several runs, and its figures as PNG and SVG.

    Example: piston-cosim results report results/fired_motorcycle/flexible.h5
    results/fired_motorcycle/rigid.h5 --output report

    Parameters
    ----------
    files
        Results files; the first one's case says what is shown.
    output
        Folder for report.html and the figures.
    notes
        Markdown file shown on the page, for example the case's README with the sources of its
        numbers.
    study
        Tables of studies to show, results/study_CASE_NAME/study.csv; several allowed.
    measured
        CSV file headed "participant.variable [unit]", the abscissa first; columns "participant.
        variable low [unit]" and "... high [unit]" give a band. Charts of runs, points and bands.
    case
        Case whose folder the paths of meshes start from, for the bodies in motion; default the case
        named as the folder of the results, or the one that comes with the tool and has the title of
        the run's. Where meshes are not found there, the page has no bodies.
    """
    described, runs = open_runs(files)
    ahead = []
    if measured:
        columns = read_measured(measured)
        check_measured(runs, columns)
        ahead = [measured_section(runs, columns)]
    missing = [f"--study {path}: no such file" for path in study if not path.is_file()]
    if missing:
        raise BadInput(missing)
    with console.status("drawing the page"):
        text = notes.read_text() if notes else ""
        page = page_of(described, runs, output, source=case, notes=text, studies=study, ahead=ahead)
    console.print(f"report   {page}", highlight=False, soft_wrap=True)
