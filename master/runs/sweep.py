"""Sweep: runs of one case over values of its keys, one row of a table for each run.

The runs use local processes or any other executor.
"""

import csv
import hashlib
import io
import itertools
import json
from collections.abc import Callable
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..case.changes import toml_value, whole_keys
from ..case.checked import check_case
from ..case.given import build_options
from ..case.reading import read_tree
from ..case.tables import with_effect
from ..fmi.cache import write_whole
from ..fmi.errors import BadInput, Stopped, for_all
from ..fmi.quantities import are_compatible, quantity, unit_text
from .lock import sole_writer
from .recorder import writing


@dataclass(frozen=True)
class Axis:
    """Axis of a sweep: dotted keys of the case that have the same value, and the values."""

    name: str
    keys: tuple
    values: tuple


AXIS_FORMS = "KEY=LOW..HIGH:COUNT or KEY=VALUE;VALUE"
MOST_VALUES_OF_RANGE = 100_000
"""Maximum number of values in a range."""
MOST_VALUES_CHECKED = 20
"""Number of values of an axis up to which all of them are checked before a sweep."""
SECOND_GRID_COLUMN = "second_grid"
"""Column that is true for points whose uncertainties come from a second grid and doubled steps."""


def parse_axis(text, tree, folder=Path()):
    """Return the axis of "KEY=LOW..HIGH:COUNT" or "KEY=VALUE;VALUE".

    Keys joined by "+" have the same value. `tree` is the TOML tree of the case, in `folder`.

    Raises
    ------
    BadInput
        With the fault of the text.
    """
    name, sign, rest = text.partition("=")
    if not sign or not rest:
        raise BadInput(f"--vary: expected {AXIS_FORMS}, got {text!r}")
    keys = whole_keys(tree, name, folder, "--vary")
    is_range = ".." in rest
    values = _range_values(text, rest) if is_range else tuple(map(toml_value, rest.split(";")))
    return Axis(name.strip(), keys, values)


def _range_values(text, rest):
    """Return the values of `rest`, "LOW..HIGH:COUNT", as texts with the unit of LOW."""
    ends, _, count = rest.rpartition(":")
    low, _, high = ends.partition("..")
    if count.strip().isdecimal() and not 2 <= int(count) <= MOST_VALUES_OF_RANGE:
        raise BadInput(
            f"--vary: expected 2 to {MOST_VALUES_OF_RANGE} values in a range, got {count}"
        )
    try:
        number, first, last = int(count), quantity(low), quantity(high)
        if not are_compatible(first.units, last.units):
            raise ValueError(high)
        points = np.linspace(first.magnitude, last.to(first.units).magnitude, number)
    except ValueError:
        raise BadInput(
            f"--vary: expected {AXIS_FORMS}, got {text!r}; give both ends in units of one kind"
        ) from None
    return tuple(f"{value:.10g} {unit_text(first.units)}".strip() for value in points)


@dataclass(frozen=True)
class Point:
    """One run of a sweep: its values on the axes, its resolved tree, and its name.

    The name is a hash of the content that affects the results.
    """

    values: dict[str, Any]
    tree: dict[str, Any]

    @property
    def name(self):
        text = json.dumps(with_effect(self.tree), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def all_points(path, changes, axes):
    """Return the points of all combinations of values of the axes.

    Parameters
    ----------
    path : Path
        File of the case.
    changes : list of (str, Any)
        Dotted keys and values that all points have in common.
    axes : list of Axis

    Raises
    ------
    BadInput
        With every fault of every tree, without duplicates.
    """
    _check_values(path, changes, axes)
    runs = []
    for values in itertools.product(*(axis.values for axis in axes)):
        axis_changes = [(key, value) for axis, value in zip(axes, values) for key in axis.keys]
        values_by_axis = {axis.name: value for axis, value in zip(axes, values)}
        runs.append((values_by_axis, [*changes, *axis_changes]))
    return checked_points(path, runs)


def _check_values(path, changes, axes):
    """Raise `BadInput` with the faults of single values that are visible before a run.

    If an axis has more than `MOST_VALUES_CHECKED` values, only its first and last are checked.
    """
    from ..case.ahead import faults_ahead  # slow to import

    def check(axis_and_value):
        axis, value = axis_and_value
        tree = read_tree(path, [*changes, *((key, value) for key in axis.keys)])
        if faults := faults_ahead(check_case(tree, path), Path(path).parent):
            raise BadInput(faults)

    def values_to_check(axis):
        few = len(axis.values) <= MOST_VALUES_CHECKED
        return axis.values if few else (axis.values[0], axis.values[-1])

    for_all(check, [(axis, value) for axis in axes for value in values_to_check(axis)])


def checked_points(path, runs):
    """Return a point for each run: a pair of its values by axis, and its changes of the case.

    Raises
    ------
    BadInput
        With every fault of every tree, without duplicates.
    """

    def point(run):
        values, changes = run
        tree = read_tree(path, changes)
        check_case(tree, path)
        return Point(values, tree)

    return for_all(point, runs)


def run_point(tree, case_folder, output, uncertainty=False):
    """Build, run and summarise one point, in any process.

    With `uncertainty`, the uncertainties of its figures come from a second grid and doubled steps.

    Returns
    -------
    dict
        status ("done", "failed" or "bad input") and message. For a finished run also the measures
        of the design with their uncertainties, the summary of the case and the truncation error.
    """
    from ..case.system import open_system
    from ..engine.answer import row_of
    from ..engine.uncertainty import PART_PREFIX
    from .completed import complete_run

    try:
        case = check_case(tree, case_folder)
        output = Path(output)
        system = open_system(case, Path(case_folder), _silent)
        summary = complete_run(system, case, tree, output, say=_silent, uncertainty=uncertainty)
        # the row has the combined uncertainties instead of their parts
        row = {"status": "done", "message": ""} | row_of(case, output)
        if uncertainty:
            row[SECOND_GRID_COLUMN] = True
        texts = f"{PART_PREFIX}reason", f"{PART_PREFIX}kept"
        return row | {
            k: v for k, v in summary.items() if not k.startswith(PART_PREFIX) or k in texts
        }
    except BadInput as error:
        return {"status": "bad input", "message": "; ".join(error.faults)}
    except Stopped as error:  # no convergence, a fault of a participant, a full disk
        return {"status": "failed", "message": str(error).splitlines()[0]}


def _silent(_text):
    pass


def sweep(
    points: list[Point],
    case_folder: Path,
    folder: Path,
    executor: Any,
    watch: Callable[[dict[str, Any], int, int], object] = lambda row, done, total: None,
    uncertainty: bool = False,
) -> list[dict[str, Any]]:
    """Run the unfinished points; write a row for each into the table of `table_for`.

    Parameters
    ----------
    points : list of Point
    case_folder : Path
        Folder of the case.
    folder : Path
        Rows and results are in `<folder>/runs`. Points that an earlier sweep has finished are
        reused. Those that failed are repeated.
    executor : concurrent.futures.Executor
        Runs the points. Its processes must have access to the same folders.
    watch : callable(row, done, total)
        Called after each run with its row and the numbers of finished and of all points.
    uncertainty : bool
        Compute the uncertainty of figures from a second grid and doubled steps.

    Returns
    -------
    list of dict
        The rows in the order of the points; `results` is a path in `folder`.

    Raises
    ------
    BadInput
        If another sweep writes into this folder.
    CannotWrite
        If there is no disk space for the rows. Finished points remain finished.
    """
    with sole_writer(Path(folder) / "sweep.csv"):
        return _sweep(points, case_folder, folder, executor, watch, uncertainty)


def _sweep(points, case_folder, folder, executor, watch, uncertainty):
    table = table_for(folder, points)

    def save_rows(rows, ended):
        with writing(table):
            write_table([_with_values(points[n], rows[n]) for n in sorted(rows)], table)
        for done, k in enumerate(ended, len(rows) - len(ended) + 1):
            watch(points[k].values | rows[k], done, len(points))

    runs = Path(folder) / "runs"
    with writing(table):
        rows = rows_of_points(points, case_folder, runs, executor, save_rows, uncertainty)
    records = [_with_values(point, row) for point, row in zip(points, rows)]
    with writing(table):
        write_table(records, table)
    return records


def rows_of_points(
    points, case_folder, runs, executor, after_run=lambda rows, ended: None, uncertainty=False
):
    """Return the row of each point, from the folder `runs` or from a new run.

    Points with the same name share one run. After each run, `after_run` is called with all rows so
    far, by index of the point, and the indices of the points of this run.
    """
    with writing(runs):
        runs.mkdir(parents=True, exist_ok=True)
    rows = {}
    to_run: dict[str, list[int]] = {}  # name of a run -> indices of its points
    for k, point in enumerate(points):
        if row := _finished_row(runs / f"{point.name}.json", uncertainty):
            rows[k] = row
        else:
            to_run.setdefault(point.name, []).append(k)
    running = {
        executor.submit(
            run_point,
            points[indices[0]].tree,
            str(case_folder),
            str((runs / f"{name}.h5").resolve()),
            *([True] if uncertainty else []),
        ): (name, indices)
        for name, indices in to_run.items()
    }
    for future in as_completed(running):
        name, indices = running[future]
        row = _row_of_run(future)
        rows |= dict.fromkeys(indices, row)
        write_whole(runs / f"{name}.json", json.dumps(row).encode())
        after_run(rows, indices)
    return [rows[k] for k in range(len(points))]


def table_for(folder, points):
    """Return the path of the table of these points.

    It is `<folder>/sweep.csv`, or sweep_2.csv and so on if that contains other rows. A sweep
    that is continued or extended uses the same file.
    """
    results = {_with_values(point, {})["results"] for point in points}
    axes = set(points[0].values) if points else set()
    for number in itertools.count(1):
        path = Path(folder) / ("sweep.csv" if number == 1 else f"sweep_{number}.csv")
        if not path.exists() or _has_only(path, axes, results):
            return path
    raise AssertionError


def _has_only(path, axes, results):
    """Return whether a table has exactly these axes, and only rows of these results files."""
    with open(path, newline="") as file:
        reader = csv.DictReader(file)
        columns = list(reader.fieldnames or ())
        rows = list(reader)
    axis_columns = columns[: columns.index("results")] if "results" in columns else []
    return set(axis_columns) == axes and all(row["results"] in results for row in rows)


def _finished_row(path, uncertainty):
    """Return the row of a finished point, None if the point has to run.

    A point has to run if its row is missing or damaged, or if its run failed. With `uncertainty`,
    it also has to run if its uncertainties are not from a second grid.
    """
    try:
        row = json.loads(path.read_text())
        is_complete = not uncertainty or SECOND_GRID_COLUMN in row
        return row if row["status"] == "done" and is_complete else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _row_of_run(future):
    """Return the result of a run; if its process died, a failed row."""
    error = future.exception()
    if error is not None:
        return {"status": "failed", "message": f"{type(error).__name__}: {error}"}
    return future.result()


def _with_values(point, row):
    """Return the row of a point in the table: values by axis, results file, entries of the run."""
    return point.values | {"results": f"runs/{point.name}.h5"} | row


def write_table(records, path):
    """Write dicts as CSV, with empty cells for missing entries."""
    names = dict.fromkeys(name for record in records for name in record)
    text = io.StringIO(newline="")
    writer = csv.DictWriter(text, names, restval="")
    writer.writeheader()
    writer.writerows(records)
    write_whole(path, text.getvalue().encode())
    return path


def unfinished(points: list[Point], folder: Path, uncertainty: bool = False) -> list[Point]:
    """Return the points that `sweep` would run, because `folder` has no finished row for them.

    A row belongs to the content of the case, not to the version of the code.
    """
    runs = Path(folder) / "runs"
    return [p for p in points if not _finished_row(runs / f"{p.name}.json", uncertainty)]


def build_all(points: list[Point], case_folder: Path, progress: Callable[[str], object]) -> None:
    """Build every FMU of the points once, before processes compete for it.

    Faults are reported in the rows.
    """
    from ..case.ahead import ahead  # slow to import
    from ..case.machine_code import native_choice
    from ..case.opening import path_of_fmu

    fmus = {}  # without duplicates
    for point in points:
        case = check_case(point.tree, case_folder)
        options = build_options(case, case_folder, progress)
        native, _ = native_choice(case, case_folder, ahead(case, case_folder).parameters)
        for name, table in case.participants.items():
            if table.package:
                fmu = table, options[name], name in native
                fmus[json.dumps([table.package, *fmu[1:]], sort_keys=True)] = fmu
    for table, build, is_native in fmus.values():
        try:
            path_of_fmu(table, build, Path(case_folder), progress, is_native)
        except BadInput:
            continue


def dask_executor(address):
    """Return the executor of an existing Dask cluster by its address.

    Raises `BadInput` if dask is not installed or the scheduler does not respond.
    """
    try:
        from dask.distributed import Client

        return Client(address, timeout=10).get_executor(pure=False)
    except ImportError:
        raise BadInput(
            "--dask: expected dask installed, got nothing; run pip install 'dask[distributed]'"
        ) from None
    except (OSError, ValueError):
        raise BadInput(f"--dask: expected a scheduler that answers, got {address!r}") from None
