"""Sweep: runs of one case over values of its keys, one row of a table for each run.

The runs use local processes or any other executor.
"""

import csv
import hashlib
import io
import itertools
import json
import tomllib
from collections.abc import Callable
from concurrent.futures import as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..case.changes import whole_key
from ..case.checked import check_case
from ..case.given import build_options
from ..case.reading import read_tree
from ..case.tables import with_effect
from ..fmi.cache import write_whole
from ..fmi.errors import BadInput, Stopped, for_all
from ..fmi.quantities import are_compatible, one_micro, quantity
from .lock import sole_writer
from .recorder import writing


@dataclass(frozen=True)
class Axis:
    """Axis of a sweep: dotted keys of the case that have the same value, and the values."""

    name: str
    keys: tuple
    values: tuple


AXIS_FORMS = "KEY=LOW..HIGH:COUNT or KEY=VALUE;VALUE"
MOST_VALUES = 100_000
"""Maximum number of values in a range."""


def parse_axis(text, tree, folder=Path()):
    """Return the axis of "KEY=LOW..HIGH:COUNT" or "KEY=VALUE;VALUE".

    Keys joined by "+" have the same value. `folder` is that of the case.

    Raises
    ------
    BadInput
        With the fault of the text.
    """
    name, sign, rest = text.partition("=")
    if not sign or not rest:
        raise BadInput(f"--vary: expected {AXIS_FORMS}, got {text!r}")
    try:
        keys = tuple(whole_key(tree, key.strip(), folder) for key in name.split("+"))
    except BadInput as error:
        raise BadInput([f"--vary {line}" for line in error.faults]) from None
    values = _range(text, rest) if ".." in rest else tuple(_plain(part) for part in rest.split(";"))
    return Axis(name.strip(), keys, values)


def _plain(text):
    """Return the TOML value of a text, or the text if it is none."""
    try:
        return tomllib.loads(f"v = {text}")["v"]
    except tomllib.TOMLDecodeError:
        return text.strip()


def _range(text, rest):
    ends, _, count = rest.rpartition(":")
    low, _, high = ends.partition("..")
    if count.strip().isdecimal() and not 2 <= int(count) <= MOST_VALUES:
        raise BadInput(f"--vary: expected 2 to {MOST_VALUES} values in a range, got {count}")
    try:
        number, first, last = int(count), quantity(low), quantity(high)
        if not are_compatible(first.units, last.units):
            raise ValueError(high)
        points = np.linspace(first.magnitude, last.to(first.units).magnitude, number)
    except ValueError:
        raise BadInput(
            f"--vary: expected {AXIS_FORMS}, got {text!r}; give both ends in units of one kind"
        ) from None
    unit = one_micro(f"{first.units:~}").replace("\N{MICRO SIGN}", "u")
    return tuple(f"{value:.10g} {unit}".strip() for value in points)


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
    """Return all combinations of the axes; raise `BadInput` with every fault of every tree."""
    _check_values(path, changes, axes)
    runs = []
    for values in itertools.product(*(axis.values for axis in axes)):
        made = [(key, value) for axis, value in zip(axes, values) for key in axis.keys]
        named = {axis.name: value for axis, value in zip(axes, values)}
        runs.append((named, [*changes, *made]))
    return resolved(path, runs)


def _check_values(path, changes, axes):
    """Raise `BadInput` with the faults of single values that are found before a run.

    For axes with many values, both ends are checked.
    """
    from ..case.ahead import faults_ahead  # slow to import

    def check(pair):
        axis, value = pair
        tree = read_tree(path, [*changes, *((key, value) for key in axis.keys)])
        if faults := faults_ahead(check_case(tree, path), Path(path).parent):
            raise BadInput(faults)

    ends = [
        (axis, value)
        for axis in axes
        for value in axis.values[:: 1 if len(axis.values) <= MOST_CHECKED else len(axis.values) - 1]
    ]
    for_all(check, ends)


MOST_CHECKED = 20
"""Number of values of an axis up to which all are checked before a sweep."""


def resolved(path, runs):
    """Return points from pairs of their values and the changes of the case.

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


COMPUTED = "second_grid"
"""Column of points whose uncertainties come from a second grid and doubled steps."""


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
    from ..engine.uncertainty import PART
    from .completed import complete_run

    try:
        case = check_case(tree, case_folder)
        system = open_system(case, Path(case_folder), _silent)
        how = {"say": _silent, "uncertainty": uncertainty}
        summary = complete_run(system, case, tree, Path(output), **how)
        shown = f"{PART}reason", f"{PART}kept"
        entries = {k: v for k, v in summary.items() if not k.startswith(PART) or k in shown}
        measured = row_of(case, Path(output)) | ({COMPUTED: True} if uncertainty else {})
        return {"status": "done", "message": ""} | measured | entries
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

    def keep(rows, ended):
        with writing(table):
            write_table([_record(points[n], rows[n]) for n in sorted(rows)], table)
        for done, k in enumerate(ended, len(rows) - len(ended) + 1):
            watch(points[k].values | rows[k], done, len(points))

    runs = Path(folder) / "runs"
    with writing(table):
        rows = rows_of(points, case_folder, runs, executor, keep, uncertainty)
    records = [_record(point, row) for point, row in zip(points, rows)]
    with writing(table):
        write_table(records, table)
    return records


def rows_of(points, case_folder, runs, executor, keep=lambda rows, ended: None, uncertainty=False):
    """Return the row of each point, from the folder `runs` or from a run.

    `keep` is called with all rows so far, by number of the point, and the numbers of those whose
    run has just ended. Points with the same name share one run.
    """
    with writing(runs):
        runs.mkdir(parents=True, exist_ok=True)
    known = (_done(runs / f"{point.name}.json", _needed(uncertainty)) for point in points)
    rows = {k: row for k, row in enumerate(known) if row}
    twins: dict[str, list[int]] = {}
    for k, point in enumerate(points):
        if k not in rows:
            twins.setdefault(point.name, []).append(k)
    waiting = {
        executor.submit(
            run_point,
            p.tree,
            str(case_folder),
            str((runs / f"{p.name}.h5").resolve()),
            *([True] if uncertainty else []),
        ): own
        for own in twins.values()
        for p in [points[own[0]]]
    }
    for future in as_completed(waiting):
        own = waiting[future]
        row = _row(future)
        rows |= dict.fromkeys(own, row)
        write_whole(runs / f"{points[own[0]].name}.json", json.dumps(row).encode())
        keep(rows, own)
    return [rows[k] for k in range(len(points))]


def table_for(folder, points):
    """Return the path of the table of these points.

    It is `<folder>/sweep.csv`, or sweep_2.csv and so on if that contains other rows. A sweep
    that is continued or extended uses the same file.
    """
    names = {_record(point, {})["results"] for point in points}
    axes = set(points[0].values) if points else set()
    for number in itertools.count(1):
        path = Path(folder) / ("sweep.csv" if number == 1 else f"sweep_{number}.csv")
        if not path.exists() or _belongs(path, axes, names):
            return path
    raise AssertionError


def _belongs(path, axes, names):
    """Return whether a table has these axes, and only rows of these runs."""
    with open(path, newline="") as file:
        reader = csv.DictReader(file)
        heads = list(reader.fieldnames or ())
        rows = list(reader)
    before = heads[: heads.index("results")] if "results" in heads else []
    return set(before) == axes and all(row["results"] in names for row in rows)


def _needed(uncertainty):
    """Return the entries of a row without which a point has to run again."""
    return (COMPUTED,) if uncertainty else ()


def _done(path, needed):
    """Return the row of a finished point, None if it has not run, has failed or is damaged.

    `needed` : entries without which it has to run again.
    """
    try:
        row = json.loads(path.read_text())
        return row if row["status"] == "done" and {*needed} <= row.keys() else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _row(future):
    """Return the result of a run; if its process died, a failed row."""
    error = future.exception()
    return (
        future.result()
        if error is None
        else {"status": "failed", "message": f"{type(error).__name__}: {error}"}
    )


def _record(point, row):
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
    """Return the points that `sweep` would run, as they are not finished in `folder`.

    A row belongs to the content of the case, not to the version of the code.
    """
    runs = Path(folder) / "runs"
    return [p for p in points if not _done(runs / f"{p.name}.json", _needed(uncertainty))]


def build_all(points: list[Point], case_folder: Path, progress: Callable[[str], object]) -> None:
    """Build every FMU of the points once, before processes compete for it.

    Faults are reported in the rows.
    """
    from ..case.ahead import ahead  # slow to import
    from ..case.machine_code import native_choice
    from ..case.opening import path_of_fmu

    wanted = {}
    for point in points:
        case = check_case(point.tree, case_folder)
        builds = build_options(case, case_folder, progress)
        native, _ = native_choice(case, case_folder, ahead(case, case_folder).parameters)
        for name, table in case.participants.items():
            if table.package:
                one = table, builds[name], name in native
                wanted[json.dumps([table.package, *one[1:]], sort_keys=True)] = one
    for table, build, is_native in wanted.values():
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
