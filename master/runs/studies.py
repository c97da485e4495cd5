"""Studies: runs of one case compared with a reference run, with the cost of each."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..case.checked import check_case
from ..case.reading import read_tree
from ..fmi.errors import BadInput, unknown
from ..results.compare import score
from ..results.file import Results
from .sweep import checked_points


class Cost(NamedTuple):
    """Cost of a run: iterations per macro step [-], counts, wall time [s]."""

    mean_iterations: float
    residual_evaluations: int
    jacobian_evaluations: int
    derivative_products: int
    wall_time_s: float


@dataclass(frozen=True)
class StudyRow:
    """Results of a run of a study; an unfinished run has only its status.

    summary : the case's own entries, by name, in the SI units of their variables; distances :
    root mean square distance from the reference over its range [-], by curve; truncation : part
    of the deflection that the modes do not represent [-], by summary entry, or why it is
    unknown.
    """

    run: str
    status: str
    cost: Cost | None
    summary: dict[str, float]
    distances: dict[str, float]
    truncation: dict[str, float | str] = field(default_factory=dict)

    def record(self) -> dict[str, Any]:
        """Return a row of the CSV file, name -> value."""
        cost = self.cost._asdict() if self.cost else {}
        distances = {f"rms {port}": value for port, value in self.distances.items()}
        row = cost | self.summary | distances | self.truncation
        return {"run": self.run, "status": self.status} | row


def study_points(path, changes, name):
    """Return the case, its study `name`, and the points of the study with their resolved trees.

    Raises
    ------
    BadInput
        If there is no such study, or with every fault of every point.
    """
    case = check_case(read_tree(path, changes), path)
    if name not in case.studies:
        hint = "" if case.studies else f"; add a table studies.{name}, see `keys studies`"
        raise BadInput(f"study: {unknown('study', name, case.studies)}{hint}")
    study = case.studies[name]
    points = checked_points(
        path,
        [
            ({"run": label}, [*study.set.items(), *changes_of_run.items(), *changes])
            for label, changes_of_run in study.points.items()
        ],
    )
    return case, study, points


def open_points(points, rows, folder):
    """Return the results of finished points, by label."""
    return {
        row["run"]: Results(Path(folder) / "runs" / f"{point.name}.h5")
        for point, row in zip(points, rows)
        if row["status"] == "done"
    }


def study_rows(study, case, rows, runs) -> list[StudyRow]:
    """Return the study row of every row of the sweep.

    Raises
    ------
    BadInput
        If the reference run has not finished.
    """
    if study.reference not in runs:
        why = "; ".join(row["message"] for row in rows if row["run"] == study.reference)
        raise BadInput(f"reference: expected a finished run {study.reference!r}, got {why}")
    reference = runs[study.reference]
    return [
        _study_row(study, case, row, runs[row["run"]], reference)
        if row["run"] in runs
        else StudyRow(row["run"], row["status"], None, {}, {})
        for row in rows
    ]


def _study_row(study, case, row, results, reference):
    distances = {}
    for port in study.curves:
        own = _curve(results, study.x, port)
        distances[port] = score(*own, *_curve(reference, study.x, port)).rms
    return StudyRow(
        run=row["run"],
        status=row["status"],
        cost=Cost(*(row[key] for key in Cost._fields)),
        summary={key: row[key] for key in case.summary},
        distances=distances,
        truncation={key: value for key, value in row.items() if key.startswith("truncation_error")},
    )


class Limit(NamedTuple):
    """Value to which the summary entry of a study tends, its uncertainty, and the observed order.

    The order is NaN if the values do not converge monotonically with one. Then the value is that of
    the finest run.
    """

    value: float
    uncertainty: float
    order: float


SAFETY, SAFETY_WITHOUT = 1.25, 3.0
"""Factors of safety with an observed order and without one [Roache1994]."""


def limits(study, rows) -> dict[str, Limit]:
    """Return the limit of each entry of `study.summary`, from the finest three `study.sizes`.

    Eq. (W5):  u* = u_3 + (u_3 - u_2)/((h_2/h_3)^p - 1),   U = 1.25 |u* - u_3|
               p by Eq. (W4). Without an order, u* = u_3 and U is three times the largest difference
               between two of the three values.

    Returns
    -------
    dict
        Empty if a point has not finished.

    References
    ----------
    [Roache1994]
    """
    labels, size = _sized(study)
    by_name: dict[str, Limit] = {}
    for name, order in observed_orders(study, rows).items():
        if name not in study.summary:
            continue
        values = [_done(rows)[label].summary[name] for label in labels]
        _, middle, fine = values
        if np.isnan(order):
            by_name[name] = Limit(fine, SAFETY_WITHOUT * float(np.ptp(values)), order)
        else:
            *_, before, last = size
            rest = (fine - middle) / ((before / last) ** order - 1.0)  # Eq. (W5)
            by_name[name] = Limit(fine + rest, SAFETY * abs(rest), order)
    return by_name


def observed_orders(study, rows) -> dict[str, float]:
    """Return the observed order p of each entry of `study.summary`, from three `study.sizes`.

    Curves have an order too if the finest point is the reference.

    Eq. (W4):  (u_1 - u_2)/(u_2 - u_3) = (h_1^p - h_2^p)/(h_2^p - h_3^p),   h_1 > h_2 > h_3

    Returns
    -------
    dict
        Empty if a point has not finished. NaN if the values do not converge monotonically with an
        order of 0.01 to 10.
    """
    labels, size = _sized(study)
    done = _done(rows)
    if not labels or any(label not in done for label in labels):
        return {}
    values = {name: [done[label].summary[name] for label in labels] for name in study.summary}
    if labels[-1] == study.reference:
        values |= {port: [done[label].distances[port] for label in labels] for port in study.curves}
    return {name: _order(size, several) for name, several in values.items()}


def _done(rows):
    """Return the rows of finished runs by label."""
    return {row.run: row for row in rows if row.cost}


def _sized(study):
    """Return the labels of a study's sizes, coarsest first, and the sizes over the largest one."""
    labels = sorted(study.sizes, key=study.sizes.__getitem__, reverse=True)
    sizes = np.array([study.sizes[label] for label in labels])
    return labels, sizes / sizes[0] if labels else sizes


def _order(size, values):
    from scipy.optimize import brentq  # slow to import, and most studies have no sizes

    coarse, fine = np.diff(values)

    def defect(p):
        first, last = np.diff(size**p)
        return coarse * last - fine * first  # Eq. (W4)

    if coarse * fine <= 0.0 or defect(0.01) * defect(10.0) >= 0.0:
        return float("nan")
    root: Any = brentq(defect, 0.01, 10.0)
    return float(root)


def _curve(results, x, y):
    return results.series(x).values, results.series(y).values
