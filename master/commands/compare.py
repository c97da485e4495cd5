"""`piston-cosim compare`."""

from pathlib import Path
from typing import Annotated

import numpy as np
from cyclopts import Parameter
from rich.markup import escape
from rich.table import Column, Table

from ..fmi.errors import BadInput
from ..results import compare as curves
from .common import Changes, console, draw_pictures, open_runs, parse_change, say

Models = Annotated[list[str], Parameter(negative=())]


def command(
    *files: Path,
    x: str | None = None,
    y: list[str] = [],
    period: str | None = None,
    measured: Path | None = None,
    output: Path | None = None,
    lubrication: Models = [],
    set_: Changes = [],
):
    """Score curves: runs against the first, the last cycle against the one before, or runs against
    a measured file.

    Printed are the ratio of ranges (amplitude), the shift (phase, positive = later) and the
    rms difference over the reference's range. With --lubrication, a case is run with each of the
    models named, and they are held against the first by what the contract says of the role: film,
    load and friction; by iterations and time; with pictures.

    Example: piston-cosim compare results/fired_motorcycle/flexible.h5 --period "720 deg"

    Example: piston-cosim compare numerical_example --lubrication jfo --lubrication gumbel
    --lubrication film.fmu

    Parameters
    ----------
    files
        Results files; with --lubrication, a case.
    x
        Abscissa, participant.variable; by default that of the case's first picture.
    y
        Curves, likewise; several allowed.
    period
        Hold each run's last period against the one before it.
    measured
        CSV file headed "participant.variable [unit]", the abscissa first; the runs are scored
        against it and drawn with it, and with bands where columns "participant.variable low [unit]"
        and "... high [unit]" give them.
    output
        Picture of runs and measured points (default measured.png); with --lubrication the folder
        for results.
    lubrication
        An FMU, or a cavitation model of the case's own FMU; two or more. Where several participants
        are lubrication, PARTICIPANT=FMU or PARTICIPANT=MODEL. Wall times are fair from the second
        call on: the first one compiles.
    set_
        Change of the case that is run, KEY=VALUE.
    """
    if lubrication:
        hold_models_together(
            *files, role="lubrication", models=lubrication, changes=set_, folder=output
        )
        return
    case, runs = open_runs(files)
    lines = [picture for picture in case.pictures if picture.kind == "lines"]
    if not lines and not (x and y):
        raise BadInput("the case has no picture with lines: give --x and --y")
    x = x or lines[0].x
    y = y or [port for panel in lines[0].y for port in panel]
    assert x is not None  # a picture with lines has one
    if measured:
        columns = curves.read_measured(measured)
        x = next(iter(columns))
        rows = curves.against_measured(runs, columns)
        drawn = curves.draw_measured(runs, columns, output or Path("measured.png"))
        console.print(f"picture  {drawn}", highlight=False, soft_wrap=True)
    elif period:
        rows = curves.against_last_cycle(case, runs, x, y, period)
    elif len(runs) > 1:
        rows = curves.against_first(runs, x, y)
    else:
        raise BadInput("one run alone: give --period or --measured, or a second run")
    print_scores(rows, next(iter(runs.values())).series(x).unit)


def print_scores(rows, unit):
    """Table of scores; the phase is in the SI `unit` of the abscissa, of angles in degrees."""
    shown, factor = ("deg", np.degrees(1.0)) if unit == "rad" else (unit, 1.0)
    table = Table("run", "curve", "amplitude [-]", escape(f"phase [{shown}]"), "rms [-]", box=None)
    for label, port, scored in rows:
        phase = f"{scored.phase * factor:+.4g}"
        table.add_row(label, port, f"{scored.amplitude:.4f}", phase, f"{scored.rms:.4f}")
    console.print(table)


def hold_models_together(case, *more, role, models, changes, folder):
    """Run a case with each model in a role; print and draw what tells them apart."""
    from ..case.schema import check_case, find_case, read_tree
    from ..results.file import Results
    from ..results.rivals import draw_rivals, exchange, measures, rivals_of, rows_of
    from ..runs.console import watching
    from ..runs.run import run
    from .run import open_all

    faults = [
        f"--{role} {model}: no such file"
        for model in models
        if model.endswith(".fmu")
        and not Path(model).is_file()
        and not Path(model.partition("=")[2]).is_file()
    ]
    if more or len(models) < 2:
        faults.append(f"give one case and two or more times --{role}")
    if faults:
        raise BadInput(faults)
    path = find_case(str(case))
    rivals = rivals_of(read_tree(path, [parse_change(text) for text in changes]), role, models)
    for label, keys in rivals.left_out.items():
        if keys:
            say(f"{label} has no variable for, and goes without: {', '.join(keys)}")
    cases = {label: check_case(tree, path) for label, tree in rivals.trees.items()}
    folder = folder or Path("results") / f"{path.parent.name}_models"
    summaries = {}
    runs = {}
    for label, system in open_all(cases, path.parent).items():
        output = folder / f"{label}.h5"
        with watching(console, label) as watch:
            summaries[label] = run(system, cases[label], rivals.trees[label], output, watch)
        runs[label] = Results(output)
    exchanged = {label: exchange(results, rivals.ports) for label, results in runs.items()}
    print_measures(rows_of(role), measures(role, exchanged, summaries))
    iterations = {
        label: (results.time, results.series("coupling.iterations").values)
        for label, results in runs.items()
    }
    draw_rivals(role, exchanged, iterations, folder / "models.png")
    console.print(f"picture  {folder / 'models.png'}", highlight=False, soft_wrap=True)
    draw_pictures(check_case(rivals.common, path), runs, folder)


def print_measures(names, values):
    """Table of the models' measures, a column each; beside a value how far it is from the first
    model's.
    """
    table = Table(Column(no_wrap=True), *values, box=None)
    first = next(iter(values.values()))
    for k, (name, unit) in enumerate(names.items()):
        cells = [f"{first[k]:.5g}"]
        for row in list(values.values())[1:]:
            cells.append(
                f"{row[k]:.5g}"
                + (f"  ({100 * (row[k] / first[k] - 1):+.1f} %)" if first[k] else "")
            )
        table.add_row(escape(f"{name} [{unit}]" if unit else name), *cells)
    console.print(table)
