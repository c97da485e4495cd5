"""`piston-cosim results compare`."""

from pathlib import Path

import numpy as np
from rich.markup import escape
from rich.table import Table

from ...fmi.errors import BadInput
from ...results import compare as curves
from ...results.charts import Chart, draw_charts
from ...results.figures import save
from ..common import OutputFile, open_runs, tell, wide_console


def command(
    *files: Path,
    x: str | None = None,
    y: list[str] = [],
    measured: Path | None = None,
    output: OutputFile = Path("measured.png"),
):
    """Score curves of results files.

    The reference is the first file or a measurement.

    The table shows the amplitude, phase and rms difference of each curve. The amplitude is a
    ratio of ranges, and a positive phase is a later curve. The rms difference is divided by the
    range of the reference.

    Example: piston-cosim results compare results/fired_motorcycle/flexible.h5 --measured bench.csv

    Parameters
    ----------
    files
        Results files.
    x
        Abscissa, PARTICIPANT.VARIABLE; default: the abscissa of the case's first line picture.
    y
        Curve, PARTICIPANT.VARIABLE; repeatable. Default: the curves of that picture.
    measured
        CSV file of a measurement. Its header is "participant.variable [unit]", abscissa first. The
        columns "participant.variable low [unit]" and "participant.variable high [unit]" are a band.
    output
        Picture of runs and measured points, .png, .svg or .pdf; default: measured.png.
    """
    case, runs = open_runs(files)
    lines = [picture for picture in case.pictures if picture.kind == "lines"]
    if not lines and not (x and y):
        raise BadInput(
            "--x, --y: expected values in a case without a picture of lines, got nothing"
        )
    x = x or lines[0].x
    y = y or [port for panel in lines[0].y for port in panel]
    assert x is not None  # a picture with lines has one
    unit = ""
    if measured:
        section, rows, unit = curves.agreement(runs, curves.read_measured(measured))
        charts = [one for one in section.drawn if isinstance(one, Chart)]
        tell(f"picture  {save(draw_charts(charts), output)}")
    elif len(runs) > 1:
        rows = curves.against_first(runs, x, y)
    else:
        raise BadInput("FILES: expected a second run or --measured, got one run")
    print_scores(rows, unit or next(iter(runs.values())).series(x).unit)


def print_scores(rows, unit):
    """Print the table of scores; the phase is in the `unit` of the abscissa, rad in degrees."""
    shown, factor = ("deg", np.degrees(1.0)) if unit == "rad" else (unit, 1.0)
    heads = ["run", "curve", "amplitude [-]", escape(f"phase [{shown}]"), "rms [-]"]
    banded = any(row.share is not None for row in rows)
    table = Table(*heads, *(["in the band"] if banded else []), box=None)
    for label, port, scored, share in rows:
        phase = f"{scored.phase * factor:+.4g}"
        within = [] if share is None else [f"{share:.0%}"]
        table.add_row(label, port, f"{scored.amplitude:.4f}", phase, f"{scored.rms:.4f}", *within)
    wide_console().print(table)
