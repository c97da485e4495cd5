"""Results file: HDF5 with units and the resolved case, readable up to the last step.

Layout
    /                       attributes: title, case (resolved TOML tree as JSON), versions,
                            derivatives (of the participants that offer any: "its own", or why
                            differences are used), masks (participant -> rows of cells, 0 for
                            missing cells), period (JSON: length [s], number of periods that
                            readers show, 0 for the whole run, outputs that grow from period to
                            period), summary (JSON) and last_period (its beginning [s]), when
                            finished
    /time                   end of every macro step [s]
    /<participant>/<name>   all scalar outputs, one value per step; attributes unit, description;
                            64-bit integers and texts have their own types, all others are floats
    /coupling/<name>        iterations, derivative_products, residual (largest residual / tolerance)
    /envelopes/<participant>/<name>   extreme value of every cell over the last period (its start
                            and all accepted steps), when finished; attribute kind, "min" or "max"
    /fields/time            instants of the recorded fields [s]
    /fields/crank_angle     at those instants [rad], for a case with a crank
    /fields/<dimension>     positions of the cells of a field: for a skirt angle [deg], height [-]
    /fields/<participant>/<name>   shape (instants, *field shape)

Every dataset has dimension scales: `xarray.open_dataset(file, group="fields/ehd",
engine="h5netcdf")` has time, angle and height as named coordinates.
"""

import json
import os
import time as clock
from collections.abc import Sequence
from contextlib import contextmanager, suppress
from math import floor
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..case.contract import contract
from ..coupling.wiring import port_of
from ..fmi.errors import BadInput, Stopped
from ..results.coordinates import CRANK_ANGLE, crank_angle_port, dimensions, distinct, names_taken
from ..results.recorded import dataset_path, open_unfinished

DISK_MARGIN = 2**18
"""Space that HDF5 may need for its own data between two checks of the disk [bytes]."""


ROWS_PER_CHUNK = 1024
"""Rows of a series in one chunk of the file."""
MOST_RECORDS = 20
"""Maximum number of records of fields in memory."""
LONGEST_WAIT = 1.0
"""Longest time that a row stays in memory during the run [s]."""
TEXT = h5py.string_dtype()
"""Type of attributes and texts."""
UNRECORDED = ("Binary", "Clock")
"""Types that are not recorded."""
LARGEST_CHARACTER = 4
"""Bytes of the longest character in UTF-8."""
LARGEST_INTEGERS = 2**53
"""Largest range of integers that floats represent."""


class CannotWrite(Stopped):
    """File of the run that cannot be written, because of a full disk or missing permission."""

    @classmethod
    def of(cls, path, error):
        """Return the system's error of writing `path` as a sentence."""
        return cls(f"{path} cannot be written: {error.strerror or error}")


@contextmanager
def writing(path):
    """Convert system errors while writing `path` into `CannotWrite`."""
    try:
        yield
    except OSError as error:
        raise CannotWrite.of(path, error) from error


def reserve(path, size):
    """Reserve disk space for a file of this size; raise `CannotWrite` if there is none."""
    with writing(path), open(path, "ab", buffering=0) as file:
        os.posix_fallocate(file.fileno(), 0, size)


TIME_TOLERANCE = 1e-6
"""Share of an interval by which a macro step may miss its multiple due to round-off."""


class Schedule:
    """Rows with which the fields are recorded.

    Parameters
    ----------
    every : int
        Number of macro steps between records, if `interval` is 0.
    begin, interval : float
        Otherwise, a record is at the first row at or after each begin + k interval [s].
    """

    def __init__(self, every: int, begin: float = 0.0, interval: float = 0.0):
        self.every, self.begin, self.interval = every, begin, interval
        self._last = -1

    def instant(self, row: int, time: float) -> float | None:
        """Return the instant of the record of a row [s], None if there is none.

        It is the multiple that `time` reaches, bit for bit the same for all divisions of steps,
        or `time`. Call it for the rows in order.
        """
        if not self.interval:
            return time if row % self.every == 0 else None
        passed = self._passed(time)
        if passed <= self._last:
            return None
        self._last = passed
        multiple = self.begin + passed * self.interval
        return multiple if abs(time - multiple) <= TIME_TOLERANCE * self.interval else time

    def is_due(self, row: int, time: float) -> bool:
        """Return whether a row has a record of the fields."""
        return self._passed(time) > self._last if self.interval else row % self.every == 0

    def _passed(self, time: float) -> int:
        return floor((time - self.begin) / self.interval + TIME_TOLERANCE)


class Recorder:
    """Writer of `<path>`, which is `<path>.partial` during the run.

    It writes the rows of a second together, or after `flush_every` records of fields.

    Parameters
    ----------
    path : Path
    participants : dict of str to Participant
    case : case.Case
        Defines the recorded fields and their axes.
    attributes : dict of str to str
        Attributes of the root.
    schedule : Schedule
        Rows with which fields are recorded.
    rows : int
        Number of rows to keep of an interrupted run's partial file.
    """

    def __init__(self, path, participants, case, attributes, schedule, rows=0):
        self.path = Path(path)
        self.partial = Path(f"{path}.partial")
        self.participants = participants
        self.case = case
        self.schedule = schedule
        self.ports = recorded_ports(case, participants)
        self.flush_every = MOST_RECORDS if self.ports else ROWS_PER_CHUNK
        self.path.parent.mkdir(parents=True, exist_ok=True)
        temporary = self.partial.with_name(self.partial.name + ".new")
        taken_over = self.partial.stat().st_size if rows else 0
        # detect a full disk here, because HDF5 cannot handle a failed write
        reserve(temporary, DISK_MARGIN + taken_over)
        self.file: Any = h5py.File(temporary, "w", libver="latest")
        self.file.attrs.update(attributes)
        self.scalars = {
            name: [
                f
                for f in p.fields.values()
                if f.causality == "output" and not f.shape and f.type not in UNRECORDED
            ]
            for name, p in participants.items()
        }
        self.rows = rows
        self.names = {name: tuple(f.name for f in fields) for name, fields in self.scalars.items()}
        self._listers = [
            _lister(participants[a], names) for a, names in self.names.items() if names
        ]
        ports = [(owner, name) for owner, names in self.names.items() for name in names]
        self.index = {port: k for k, port in enumerate(ports, 1)}
        """Index of an output (participant, variable) in the rows."""
        self._reals = [
            k for (owner, name), k in self.index.items() if self._type(owner, name) == "Real"
        ]
        self._are_all_real = len(self._reals) == len(self.index)
        self._undefined: set[str] = set()
        self._read: tuple[int, tuple[list[Any], Sequence[Any]]] | None = None
        self.crank = self._crank()
        self._make_datasets()
        self._forget()
        self._reserved = 0
        self._need = DISK_MARGIN + self._largest_growth()
        self._reserve(temporary, taken_over)
        if rows:
            self._take_over()
        os.replace(temporary, self.partial)
        self.file.swmr_mode = True
        self.undefined = self.not_finite(self.schedule.begin)
        """Values of outputs that are not finite when the recorder begins: port -> value."""
        self._undefined, self._read = {*self.undefined}, None

    def _crank(self):
        """Return the (participant, output) of the crank angle, None if there is none."""
        port = crank_angle_port(self.case)
        owner, name = port_of(port or "")
        return (owner, name) if name in self.names.get(owner, ()) else None

    def _make_datasets(self):
        self.columns: list[h5py.Dataset] = []
        self.fields: list[h5py.Dataset] = []
        self.time = self._series(self.columns, "time", "s", "end of the macro step")
        self.time.make_scale("time")
        for name, fields in self.scalars.items():
            for field in fields:
                path = dataset_path(f"{name}.{field.name}")
                kind = type_of(field)
                self._series(self.columns, path, field.unit, field.description, kind=kind)
        for name, text in (
            ("iterations", "evaluations of the macro step"),
            ("derivative_products", "directional derivatives"),
            ("residual", "largest residual / tolerance of the accepted step"),
        ):
            self._series(self.columns, f"coupling/{name}", "1", text)
        self.time = self._series(self.fields, "fields/time", "s", "instants of the recorded fields")
        self.time.make_scale("time")
        if self.crank:
            self._series(self.fields, f"fields/{CRANK_ANGLE}", "rad", "crank angle at `time`")
        sizes = names_taken(self.participants)
        for port in self.ports:
            owner, name = port_of(port)
            field = self.participants[owner].fields[name]
            path = f"fields/{dataset_path(port)}"
            texts, kind = (field.unit, field.description), type_of(field)
            dataset = self._series(self.fields, path, *texts, field.shape, kind)
            for k, one in enumerate(dimensions(self.case, port, field.shape), start=1):
                dataset.dims[k].attach_scale(self._scale(distinct(sizes, one, owner)))

    def _scale(self, dimension):
        """Return the dataset with the positions of a dimension, created at its first use."""
        path = f"fields/{dimension.name}"
        if path not in self.file:
            scale = self.file.create_dataset(path, data=dimension.positions)
            scale.attrs.update({"unit": dimension.unit, "description": dimension.description})
            scale.make_scale(dimension.name)
        return self.file[path]

    def _series(self, those, name, unit, description, shape=(), kind: Any = float):
        """Create a dataset along `time`, and add it to `those`."""
        chunk = (1, *shape) if shape else (ROWS_PER_CHUNK,)
        dataset = self.file.create_dataset(
            name,
            (0, *shape),
            maxshape=(None, *shape),
            dtype=kind,
            chunks=chunk,
            compression="lzf" if shape else None,
        )
        _describe(dataset, unit=unit, description=description)
        if name.rpartition("/")[-1] != "time":
            dataset.dims[0].attach_scale(self.time)
        those.append(dataset)
        return dataset

    def _take_over(self):
        """Copy the first rows of the interrupted run, whose file may not be closed properly."""
        try:
            before = open_unfinished(self.partial)
        except OSError:
            raise BadInput(f"{self.partial}: expected results so far, got a damaged file") from None
        with before as file:
            old: Any = file
            due = [self.schedule.instant(k, t) for k, t in enumerate(old["time"][: self.rows])]
            instants = len(due) - due.count(None)

            def copy(name, dataset):
                if isinstance(dataset, h5py.Dataset) and dataset.chunks:
                    count = instants if name.startswith("fields/") else self.rows
                    dataset.resize(count, axis=0)
                    dataset[...] = old[name][:count]

            try:
                self.file.visititems(copy)
            except (KeyError, TypeError, ValueError, AttributeError):
                raise BadInput(
                    f"{self.partial}: expected the first {self.rows} rows of this run, got others"
                ) from None

    def _largest_growth(self):
        """Return the largest growth of the file in a flush: rows of fields, chunks of series."""
        datasets = [*self.columns, *self.fields]
        waiting = [self.flush_every + 1 if len(item.shape) > 1 else 2 for item in datasets]
        return sum(
            count * item.dtype.itemsize * int(np.prod(item.chunks or ()))
            for count, item in zip(waiting, datasets)
        )

    def _reserve(self, path, more=0):
        """Reserve disk space for the next rows and `more` bytes before HDF5 needs it.

        After a failed write, HDF5 cannot even close the file.
        """
        end = self.file.id.get_filesize() + self._need + more
        if end > self._reserved:
            self._reserved = end + self._need
            reserve(path, self._reserved)

    def flush(self):
        """Write all rows to the disk.

        Raises `CannotWrite` if it is full. Then the rows since the last flush are lost.
        """
        waiting = (self.columns, self._waiting), (self.fields, self._instants)
        self._forget()
        columns = [
            (dataset, values[k :: len(datasets)])
            for datasets, values in waiting
            for k, dataset in enumerate(datasets)
            if values
        ]
        self._reserve(self.partial, LARGEST_CHARACTER * sum(_characters(*one) for one in columns))
        for dataset, values in columns:
            _extend(dataset, values)
        self.file.flush()

    def _forget(self):
        """Clear the waiting rows, of which all values are in one list: that is faster."""
        self._waiting: list[Any] = []
        self._instants: list[Any] = []
        self._flushed, self._records = self.rows, 0
        self._flush_at = clock.perf_counter() + LONGEST_WAIT

    def not_finite(self, time):
        """Return the outputs to record at `time` [s] that are not finite: port -> value.

        Those that are `undefined` are omitted until they are finite. If the row of this time is
        written next, it has the values that are read here.
        """
        row, arrays = values = self._values(time)
        self._read = self.rows, values
        reals = row if self._are_all_real else [row[k] for k in self._reals]
        total = sum(reals)
        if total - total == 0.0 and (not arrays or all(map(_are_finite, arrays))):
            if self._undefined:
                self._undefined = set()
            return {}
        names = [f"{owner}.{name}" for owner, name in self.index]
        values = {names[k - 1]: row[k] for k in self._reals} | dict(zip(self.ports, arrays))
        bad: dict[str, float] = {}
        for port, value in values.items():
            cells = np.ravel(value)
            if not (fine := np.isfinite(cells)).all():
                bad[port] = cells[~fine][0]
        self._undefined &= bad.keys()
        return {port: value for port, value in bad.items() if port not in self._undefined}

    def _type(self, owner, name):
        return self.participants[owner].fields[name].type

    def _values(self, time):
        """Return the row at `time` [s] without its counters, and the fields if they are due."""
        row = [time]
        for listed in self._listers:
            row += listed()
        if not self.ports or not self.schedule.is_due(self.rows, time):
            return row, ()
        return row, [self.participants[a].get(b) for a, b in map(port_of, self.ports)]

    def write(self, time, solution=None):
        """Add a row for `time` [s] from the current outputs, and return it.

        The next `flush` writes it.
        """
        known, self._read = self._read, None
        is_known = known is not None and known[0] == self.rows and known[1][0][0] == time
        row, arrays = known[1] if known is not None and is_known else self._values(time)
        if solution:
            history = solution.history
            row += len(history), solution.products, history[-1]
        else:
            row += 0, 0, 0.0
        self._waiting += row
        instant = self.schedule.instant(self.rows, time)
        if instant is not None:
            self._instants.append(instant)
            if self.crank:
                self._instants.append(row[self.index[self.crank]])
            self._instants += arrays
            self._records += 1
        self.rows += 1
        last = self.rows - self._flushed >= ROWS_PER_CHUNK or self._records >= self.flush_every
        if last or clock.perf_counter() > self._flush_at:
            self.flush()
        return row

    def finish(self, summary, last_period, envelopes):
        """Add summary, start of the last period [s] and envelopes; close and rename the file."""
        self.flush()
        self.close()
        extremes = envelopes.values(self.participants)
        more = DISK_MARGIN + sum(values.nbytes for values in extremes.values())
        reserve(self.partial, self.partial.stat().st_size + more)
        with h5py.File(self.partial, "a") as file:
            file.attrs["summary"] = json.dumps(summary)
            file.attrs["last_period"] = last_period
            for port, values in extremes.items():
                owner, name = port_of(port)
                field = self.participants[owner].fields[name]
                dataset = file.create_dataset(f"envelopes/{dataset_path(port)}", data=values)
                attributes = {"unit": field.unit, "description": field.description}
                dataset.attrs.update(attributes | {"kind": envelopes.kinds[port]})
        os.replace(self.partial, self.path)

    def close(self):
        """Close the partial file."""
        if self.file:
            with suppress(CannotWrite):
                self.flush()
            self.file.close()
            self.file = None


def _are_finite(value):
    return bool(np.isfinite(value).all())


def _lister(participant, names):
    """Return a function that lists the values of several scalars."""
    if lister := getattr(participant, "lister", None):
        return lister(names)
    return lambda: list(map(participant.get_many(names).__getitem__, names))


def recorded_ports(case, participants):
    """Return the recorded fields of a run: those of the case, and those that define the state.

    The latter are coordinates and rates of modes and bearings: the `repeats` and `records` of a
    participant's role that have one index, about 60 numbers per instant.
    """
    ports = list(case.record.fields)
    for name, table in case.participants.items():
        terms = contract().get(table.role or "")
        for variable in (*terms.repeats, *terms.records) if terms else ():
            field = participants[name].fields.get(variable)
            port = f"{name}.{variable}"
            if field is not None and len(field.shape) == 1 and port not in ports:
                ports.append(port)
    return ports


def type_of(field) -> Any:
    """Return the HDF5 type of a variable: texts and integers beyond 2^53 keep their values."""
    if field.type == "String":
        return TEXT
    low, high = getattr(field, "whole_numbers", None) or (0, 0)
    if field.type != "Integer" or high - low < LARGEST_INTEGERS:
        return float
    return np.int64 if low else np.uint64


def _describe(dataset, **texts):
    """Set attributes of a new dataset by HDF5's low-level calls.

    h5py writes each under another name and renames it, which takes twice as long.
    """
    kind = h5py.h5t.py_create(TEXT, logical=True)
    for name, text in texts.items():
        place = h5py.h5s.create(h5py.h5s.SCALAR)
        h5py.h5a.create(dataset.id, name.encode(), kind, place).write(np.array(text, dtype=TEXT))


def _characters(dataset, values):
    """Return the number of characters in the values of a column of texts; else 0."""
    return sum(map(len, values)) if h5py.check_string_dtype(dataset.dtype) else 0


def _extend(dataset, values):
    """Append values to a dataset by HDF5's low-level calls.

    h5py takes three times as long for a few numbers, and there are about sixty datasets.
    """
    kind = dataset.dtype
    if h5py.check_string_dtype(kind):
        values = [text.encode(errors="surrogateescape") for text in values]
    rows = np.asarray(values, dtype=kind)
    one = dataset.id
    known, *shape = one.shape
    one.set_extent((known + len(rows), *shape))
    place = one.get_space()
    place.select_hyperslab((known, *(0 for _ in shape)), rows.shape)
    one.write(h5py.h5s.create_simple(rows.shape), place, rows)
