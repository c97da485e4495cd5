"""`piston-cosim compare`."""

from pathlib import Path

from rich.table import Table

from .. import compare as curves
from ..fmi.errors import BadInput
from .common import console, open_runs


def command(*files: Path, x: str | None = None, y: list[str] = [], period: str | None = None, measured: Path | None = None,
            output: Path = Path("measured.png")):
    """Score curves: runs against the first, the last cycle against the one before, or runs against a measured file.

    Printed are the ratio of ranges (amplitude), the shift (phase, in SI, positive = later) and the rms difference over the
    reference's range.

    Example: piston-cosim compare results/fired_motorcycle/flexible.h5 --period "720 deg"

    Parameters
    ----------
    files
        Results files.
    x, y
        Abscissa and curves, participant.variable; by default those of the case's first picture.
    period
        Hold each run's last period against the one before it.
    measured
        CSV file headed "participant.variable [unit]", the abscissa first; the runs are scored against it and drawn with it.
    output
        Picture of runs and measured points.
    """
    case, runs = open_runs(files)
    lines = [picture for picture in case.pictures if picture.kind == "lines"]
    if not lines and not (x and y):
        raise BadInput("the case has no picture with lines: give --x and --y")
    x, y = x or lines[0].x, y or [port for panel in lines[0].y for port in panel]
    if measured:
        table = curves.read_measured(measured)
        rows = curves.against_measured(runs, table)
        console.print(f"picture  {curves.draw_measured(runs, table, output)}", highlight=False, soft_wrap=True)
    elif period:
        rows = curves.against_last_cycle(case, runs, x, y, period)
    elif len(runs) > 1:
        rows = curves.against_first(runs, x, y)
    else:
        raise BadInput("one run alone: give --period or --measured, or a second run")
    table = Table("run", "curve", "amplitude [-]", "phase", "rms [-]", box=None)
    for label, port, found in rows:
        table.add_row(label, port, f"{found['amplitude']:.4f}", f"{found['phase']:+.4g}", f"{found['rms']:.4f}")
    console.print(table)
