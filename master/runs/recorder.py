"""Results file: HDF5 with units, the resolved case inside, readable up to the last step whatever
happens to the run.

Layout
    /                       attributes: title, case (resolved TOML tree as JSON), versions,
                            derivatives (of the participants that offer any: their own, or why
                            differences are taken), summary (JSON, when finished)
    /time                   end of every macro step [s]
    /<participant>/<name>   all scalar outputs, one value a step; attributes unit, description
    /coupling/<name>        iterations, derivative_products, residual (largest residual / tolerance)
    /fields/time            instants of the recorded fields [s]
    /fields/<participant>/<name>   shape (instants, *field shape)
"""

import json
import os
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ..coupling.wiring import port_of
from ..fmi.errors import BadInput
from ..results.file import dataset_path

ROOM = 2**18
"""Bytes that HDF5 may need for its own bookkeeping between two looks at the room on the disk."""


class CannotWrite(RuntimeError):
    """A file of the run cannot be written: the disk is full, or it is not ours."""


@contextmanager
def writing(path):
    """What the system says while writing `path` becomes CannotWrite."""
    try:
        yield
    except OSError as error:
        raise CannotWrite(f"{path} cannot be written: {error.strerror or error}") from error


def reserve(path, size):
    """Take room for a file of so many bytes on the disk; CannotWrite if it is not there."""
    with writing(path), open(path, "ab", buffering=0) as file:
        os.posix_fallocate(file.fileno(), 0, size)


class Recorder:
    """Writes `<path>` as `<path>.partial` while the run goes on, `flush_every` rows at a time.

    Parameters
    ----------
    path : Path
    participants : dict of str to Participant
    record : case.Record
    attributes : dict of str to str
        Goes to the root.
    rows : int
        So many rows of an interrupted run's partial file are kept.
    """

    def __init__(self, path, participants, record, attributes, rows=0, flush_every=20):
        self.path = Path(path)
        self.partial = Path(f"{path}.partial")
        self.participants = participants
        self.record = record
        self.flush_every = flush_every
        self.path.parent.mkdir(parents=True, exist_ok=True)
        fresh = self.partial.with_name(self.partial.name + ".new")
        taken_over = self.partial.stat().st_size if rows else 0
        # a full disk shows here: a write that fails is more than HDF5 can cope with
        reserve(fresh, ROOM + taken_over)
        self.file: Any = h5py.File(fresh, "w", libver="latest")
        self.file.attrs.update(attributes)
        self.scalars = {
            name: [
                f
                for f in p.fields.values()
                if f.causality == "output" and not f.shape and f.type not in ("String", "Binary")
            ]
            for name, p in participants.items()
        }
        self.rows = rows
        self._make_datasets()
        self._waiting: dict[str, list] = {}
        self._reserved = 0
        self._need = ROOM + self._largest_growth()
        self._reserve(fresh, taken_over)
        if rows:
            self._take_over()
        os.replace(fresh, self.partial)
        self.file.swmr_mode = True

    def _make_datasets(self):
        self._series("time", "s", "end of the macro step")
        for name, fields in self.scalars.items():
            for field in fields:
                self._series(dataset_path(f"{name}.{field.name}"), field.unit, field.description)
        for name, text in (
            ("iterations", "evaluations of the macro step"),
            ("derivative_products", "directional derivatives"),
            ("residual", "largest residual / tolerance of the accepted step"),
        ):
            self._series(f"coupling/{name}", "1", text)
        self._series("fields/time", "s", "instants of the recorded fields")
        for port in self.record.fields:
            owner, name = port_of(port)
            field = self.participants[owner].fields[name]
            self._series(f"fields/{dataset_path(port)}", field.unit, field.description, field.shape)

    def _series(self, name, unit, description, shape=()):
        chunk = (1, *shape) if shape else (1024,)
        dataset = self.file.create_dataset(
            name,
            (0, *shape),
            maxshape=(None, *shape),
            dtype=float,
            chunks=chunk,
            compression="lzf" if shape else None,
        )
        dataset.attrs.update({"unit": unit, "description": description})

    def _take_over(self):
        """Copy the first rows of the interrupted run; its file may lack the mark of having been
        closed.
        """
        try:
            before = h5py.File(self.partial, "r", libver="latest", swmr=True)
        except OSError as error:
            raise BadInput(f"{self.partial}: is damaged: {error}") from None
        with before as file:
            old: Any = file
            instants = -(-self.rows // self.record.every)

            def copy(name, dataset):
                if isinstance(dataset, h5py.Dataset):
                    count = instants if name.startswith("fields/") else self.rows
                    dataset.resize(count, axis=0)
                    dataset[...] = old[name][:count]

            try:
                self.file.visititems(copy)
            except (KeyError, TypeError, ValueError, AttributeError):
                raise BadInput(
                    f"{self.partial}: does not hold the first {self.rows} rows of this run"
                ) from None

    def _largest_growth(self):
        """Bytes by which a flush may lengthen the file: rows of fields and a chunk of each
        series.
        """
        datasets = []
        self.file.visititems(
            lambda name, item: datasets.append(item) if isinstance(item, h5py.Dataset) else None
        )
        waiting = [self.flush_every + 1 if len(item.shape) > 1 else 1 for item in datasets]
        return sum(
            count * item.dtype.itemsize * int(np.prod(item.chunks))
            for count, item in zip(waiting, datasets)
        )

    def _reserve(self, path, more=0):
        """Take room for what comes next, and `more` bytes, before HDF5 needs it: after a failed
        write it cannot even close.
        """
        end = self.file.id.get_filesize() + self._need + more
        if end > self._reserved:
            self._reserved = end + self._need
            reserve(path, self._reserved)

    def flush(self):
        """Bring all rows to the disk; CannotWrite where it is full, the rows since the last time
        are lost then.
        """
        waiting = self._waiting
        self._waiting = {}
        self._reserve(self.partial)
        for name, rows in waiting.items():
            dataset = self.file[name]
            dataset.resize(dataset.shape[0] + len(rows), axis=0)
            dataset[-len(rows) :] = rows
        self.file.flush()

    def _append(self, name, value):
        self._waiting.setdefault(name, []).append(value)

    def write(self, time, solution=None):
        """Add a row for `time` [s] from the participants' outputs as they are now; it waits in
        memory for the next `flush`.
        """
        values = {
            name: self.participants[name].get_many([f.name for f in fields])
            for name, fields in self.scalars.items()
        }
        self._append("time", time)
        for name, row in values.items():
            for key, value in row.items():
                self._append(dataset_path(f"{name}.{key}"), value)
        self._append("coupling/iterations", solution.iterations if solution else 0)
        self._append("coupling/derivative_products", solution.products if solution else 0)
        self._append("coupling/residual", solution.history[-1] if solution else 0.0)
        if self.rows % self.record.every == 0:
            self._append("fields/time", time)
            for port in self.record.fields:
                owner, name = port_of(port)
                self._append(f"fields/{dataset_path(port)}", self.participants[owner].get(name))
        self.rows += 1
        if self.rows % self.flush_every == 0:
            self.flush()
        return values

    def finish(self, summary):
        """Close, add the summary and give the file its final name."""
        self.flush()
        self.close()
        with h5py.File(self.partial, "a") as file:
            file.attrs["summary"] = json.dumps(summary)
        os.replace(self.partial, self.path)

    def close(self):
        """Close; the partial file stays."""
        if self.file:
            with suppress(CannotWrite):
                self.flush()
            self.file.close()
            self.file = None
