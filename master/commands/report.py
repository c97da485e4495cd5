"""`piston-cosim report`."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from ..engine.answer import answer
from ..engine.sections import special
from ..fmi.errors import BadInput
from ..results.compare import check_measured, measured_section, read_measured
from ..results.report import write_report
from .common import body_skins, console, open_runs


def command(
    *files: Path,
    output: Path = Path("report"),
    notes: Path | None = None,
    study: Annotated[list[Path], Parameter(negative=())] = [],
    measured: Path | None = None,
    case: str | None = None,
):
    """Write one self-contained HTML page about one or several runs, and its figures as PNG and SVG.

    Example: piston-cosim report results/fired_motorcycle/flexible.h5
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
    columns = read_measured(measured) if measured else None
    if columns:
        check_measured(runs, columns)
    missing = [f"--study {path}: no such file" for path in study if not path.is_file()]
    if missing:
        raise BadInput(missing)
    with console.status("drawing the page"):
        answers = {label: answer(described, results) for label, results in runs.items()}
        extra = special(described, runs, body_skins(runs, case))
        if columns:
            extra = replace(extra, sections=[measured_section(runs, columns), *extra.sections])
        text = notes.read_text() if notes else ""
        page = write_report(described, runs, output, text, study, answers, extra)
    console.print(f"report   {page}", highlight=False, soft_wrap=True)
