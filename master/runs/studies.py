"""Studies: a handful of runs of one case, held against one of them, with what each has cost."""

import csv
from itertools import cycle
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from ..case.schema import check_case, read_tree
from ..fmi.errors import BadInput
from ..results.compare import score
from ..results.file import Results
from ..results.pictures import PALETTE, labelled, name_of, scaled
from .sweep import Point

COST = (
    "mean_iterations",
    "residual_evaluations",
    "jacobian_evaluations",
    "derivative_products",
    "wall_time_s",
)


def study_points(path, changes, name):
    """The study `name` of a case, and its points with their resolved trees.

    Raises
    ------
    BadInput
        If there is no such study, or with every fault of every point.
    """
    case = check_case(read_tree(path, changes), path)
    if name not in case.studies:
        raise BadInput(f"no study {name!r}: the case has {', '.join(case.studies) or 'none'}")
    study = case.studies[name]
    points = []
    faults = []
    for label, made in study.points.items():
        try:
            tree = read_tree(path, [*study.set.items(), *made.items(), *changes])
            check_case(tree, path)
            points.append(Point({"run": label}, tree))
        except BadInput as error:
            faults += [fault for fault in error.faults if fault not in faults]
    if faults:
        raise BadInput(faults)
    return case, study, points


def open_points(points, rows, folder):
    """Results of the points that are done, by label."""
    return {
        row["run"]: Results(Path(folder) / "runs" / f"{point.name}.h5")
        for point, row in zip(points, rows)
        if row["status"] == "done"
    }


def study_table(study, case, rows, runs):
    """A row a run: cost, the case's summary entries, and for every curve the rms difference to the
    reference over its range.

    Raises
    ------
    BadInput
        If the reference itself has not been done.
    """
    if study.reference not in runs:
        why = "; ".join(row["message"] for row in rows if row["run"] == study.reference)
        raise BadInput(f"the reference {study.reference!r} has not finished: {why}")
    reference = runs[study.reference]
    table = []
    for row in rows:
        entry = {key: row.get(key, "") for key in ("run", "status", *COST, *case.summary)}
        for port in study.curves if row["run"] in runs else ():
            results = runs[row["run"]]
            entry[f"rms {port}"] = score(
                *_curve(results, study.x, port), *_curve(reference, study.x, port)
            ).rms
        table.append(entry)
    return table


def _curve(results, x, y):
    return results.series(x).values, results.series(y).values


def write_table(table, path):
    """CSV of rows that may lack columns."""
    names = list(dict.fromkeys(name for row in table for name in row))
    with open(path, "w", newline="") as file:
        csv.writer(file).writerows(
            [names] + [[row.get(name, "") for name in names] for row in table]
        )
    return path


def draw_study(study, case, table, runs, path):
    """Left the curves of all runs, right their rms distance from the reference."""
    units = {port: unit for picture in case.pictures for port, unit in picture.units.items()}
    figure, panels = plt.subplots(
        len(study.curves),
        2,
        squeeze=False,
        sharex="col",
        layout="constrained",
        figsize=(13, 1 + 2.6 * len(study.curves)),
        width_ratios=(3, 1),
    )
    x_unit = ""
    for (left, right), port in zip(panels, study.curves):
        unit = ""
        for colour, (label, results) in zip(cycle(PALETTE), runs.items()):
            known = results.series(study.x)
            value = results.series(port)
            x, x_unit = scaled(known.values, known.unit, units.get(study.x))
            y, unit = scaled(value.values, value.unit, units.get(port))
            left.plot(x, y, color=colour, lw=1.1, label=label)
            distance = next(row[f"rms {port}"] for row in table if row["run"] == label)
            right.plot([label], [distance if distance > 0 else np.nan], "o", color=colour)
        left.set_ylabel(labelled(name_of(port), unit), fontsize="small")
        right.set_yscale("log")
        right.tick_params(axis="x", rotation=60, labelsize="small")
        right.set_title(f"rms / range, from {study.reference}", fontsize="small")
        for panel in (left, right):
            panel.grid(alpha=0.3)
    panels[-1, 0].set_xlabel(labelled(name_of(study.x), x_unit))
    panels[0, 0].legend(fontsize="small", frameon=False, ncols=2)
    figure.suptitle(study.title)
    figure.savefig(path, dpi=120)
    plt.close(figure)
    return path


def draw_cost(title, table, path):
    """Bars of what each run has cost, a panel per counter, in the order of the study."""
    rows = [row for row in table if row.get(COST[0], "") != ""][::-1]
    counted = [key for key in COST if any(row[key] for row in rows)]
    figure, panels = plt.subplots(
        1,
        len(counted),
        sharey=True,
        squeeze=False,
        layout="constrained",
        figsize=(14, 1.2 + 0.32 * len(rows)),
    )
    for panel, key, colour in zip(panels[0], counted, PALETTE):
        bars = panel.barh([row["run"] for row in rows], [row[key] for row in rows], color=colour)
        panel.bar_label(bars, fmt="{:,.4g}", padding=3, fontsize="small")
        panel.margins(x=0.28)
        panel.set_title(key.replace("_", " "), fontsize="medium")
        panel.spines[["top", "right"]].set_visible(False)
    figure.suptitle(title)
    figure.savefig(path, dpi=120)
    plt.close(figure)
    return path
