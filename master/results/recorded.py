"""Reading of a results file; `runs.recorder` describes its layout."""

import json
from copy import copy
from functools import cached_property
from math import floor
from pathlib import Path
from typing import Any, NamedTuple, Self
from warnings import warn

import h5py
import numpy as np

from ..case.checked import check_case
from ..case.contract import envelope_kinds
from ..fmi.errors import BadInput, unknown
from .coordinates import crank_angle_port


class Series(NamedTuple):
    """Scalar output over the macro steps, shape (rows,), in its SI unit."""

    values: np.ndarray
    unit: str
    description: str

    def __repr__(self) -> str:
        return f"<Series {self.description}: {_span(self.values, self.unit)}>"


class RecordedField(NamedTuple):
    """Field at the instant `time` [s], in its SI unit."""

    values: np.ndarray
    time: float
    unit: str
    description: str

    def __repr__(self) -> str:
        return f"<RecordedField {self.description}: {_span(self.values, self.unit)}>"


class Envelope(NamedTuple):
    """Extreme value of every cell of a field over the last period, in its SI unit.

    kind : "min" or "max"; every_step : whether it covers all accepted macro steps, or only
    recorded instants.
    """

    values: np.ndarray
    kind: str
    unit: str
    description: str
    every_step: bool


def _span(values: np.ndarray, unit: str) -> str:
    """Return the shape and the range of values with their unit."""
    if not values.size:
        return "no values"
    if values.dtype.kind == "O":
        return f"{values.size} texts"
    shape = " x ".join(map(str, values.shape))
    return f"{shape} values from {values.min():.4g} to {values.max():.4g} {unit}".rstrip()


class TrimmedDataset:
    """Rows of an h5py.Dataset from `first` on, read when it is sliced."""

    def __init__(self, dataset: Any, first: int):
        self._dataset, self._first = dataset, first
        self.attrs, self.dtype = dataset.attrs, dataset.dtype
        self.shape = (dataset.shape[0] - first, *dataset.shape[1:])
        self.ndim = dataset.ndim

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> np.ndarray:
        rows, *others = key if isinstance(key, tuple) else (key,)
        if isinstance(rows, slice):
            begin, end, step = rows.indices(len(self))
            rows = slice(begin + self._first, end + self._first, step)
        else:
            rows = np.arange(len(self))[rows] + self._first
        return self._dataset[(rows, *others)]


ROW_TOLERANCE = 1e-6
"""Share of a period by which a row may miss its beginning due to round-off."""
SLASH = "\u2215"
"""Character that replaces / in the names of datasets, because HDF5 uses / for groups."""
NAMELESS = {"": "\u2205", ".": "\u2024"}
"""Names of variables that HDF5 does not allow, and the names of their datasets."""


def dataset_path(port: str) -> str:
    """Return the path of "participant.name" or "time" in a results file."""
    owner, dot, name = port.partition(".")
    return f"{owner}/{NAMELESS.get(name, name.replace('/', SLASH))}" if dot else owner


SIGNATURE = b"\x89HDF\r\n\x1a\n"
END = slice(28, 36)
"""First bytes of an HDF5 file, and position of its length at the last writing."""


def open_unfinished(path: Path) -> Any:
    """Open a results file for reading that is being written, or whose run was killed.

    Raises `OSError` if it is shorter than its header states, because HDF5 would read a truncated
    file forever.
    """
    with open(path, "rb") as file:
        head = file.read(END.stop)
    size, least = path.stat().st_size, int.from_bytes(head[END], "little")
    if head.startswith(SIGNATURE) and size < least:
        raise OSError(f"truncated: {size} bytes are left of at least {least}")
    return h5py.File(path, "r", libver="latest", swmr=True)


def _port(path: str) -> str:
    owner, slash, name = path.partition("/")
    names = {written: allowed for allowed, written in NAMELESS.items()}
    return f"{owner}.{names.get(name, name.replace(SLASH, '/'))}" if slash else owner


class Recorded:
    """Recorded data of a run as arrays in SI with their units; see `file.Results`."""

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self.file: Any = (
            open_unfinished(self.path)
            if self.path.suffix == ".partial"
            else h5py.File(self.path, "r", libver="latest")
        )
        written = json.loads(self.file.attrs.get("period", "{}"))
        self.period: float = written.get("length", 0.0)
        self._turning: list[str] = written.get("turning", [])
        self._times: np.ndarray = self.file["time"][:]
        self._first_row = 0
        self._zero_row = 0  # whole periods before the shown ones: times and angles count from there
        if shown := written.get("shown"):
            self._show(shown)
            passed = (self._times[self._first_row] - self._times[0]) / self.period
            self._zero_row = self._row(self._times[0] + floor(passed + ROW_TOLERANCE) * self.period)

    def _row(self, time: float) -> int:
        """Return the first row at or after a time of the file [s], within round-off."""
        return int(np.searchsorted(self._times, time - ROW_TOLERANCE * self.period))

    def _show(self, periods: int):
        """Show the last periods, or the whole run if it is shorter than one."""
        begin, end = self._times[0], self._times[-1]
        cycles = floor((end - begin) / self.period + ROW_TOLERANCE)
        self._first_row = self._row(end - min(periods, cycles) * self.period) if cycles else 0

    @property
    def last(self) -> Self:
        """The last period of the times shown; the whole run if it has no period."""
        if not self.period or len(self._times) < 2:
            return self
        view = copy(self)
        view._show(1)
        return view

    @property
    def whole(self) -> Self:
        """The whole run from its start."""
        view = copy(self)
        view._first_row = view._zero_row = 0
        return view

    @property
    def time(self) -> np.ndarray:
        """End of every macro step shown, the start first, shape (rows,) [s]."""
        return self._times[self._first_row :] - self._shift

    @property
    def _shift(self) -> float:
        return float(self._times[self._zero_row] - self._times[0]) if self._zero_row else 0.0

    @property
    def title(self) -> str:
        """Title of the case."""
        return self.file.attrs["title"]

    @property
    def case(self) -> dict[str, Any]:
        """Resolved TOML tree of the run."""
        return json.loads(self.file.attrs["case"])

    @property
    def summary(self) -> dict[str, Any] | None:
        """Summary of a finished run; None if the run has not finished."""
        return json.loads(self.file.attrs["summary"]) if "summary" in self.file.attrs else None

    def series(self, port: str) -> Series:
        """Return a scalar output over the macro steps: (values, unit, description).

        Values are floats, 64-bit integers, or texts.

        Raises
        ------
        BadInput
            If the run has no such output.
        """
        if port not in {"time", *self._scalars}:
            hint = "read it by dataset" if port in self.recorded else ""
            raise BadInput(f"port: {unknown('scalar output', port, self._scalars, hint)}")
        dataset = self.file[dataset_path(port)]
        is_text = h5py.check_string_dtype(dataset.dtype)
        stored = dataset.asstr(errors="surrogateescape") if is_text else dataset
        values = stored[self._first_row :]
        if port in self._turning and self._zero_row:
            values = values - (dataset[self._zero_row] - dataset[0])
        return Series(values, dataset.attrs["unit"], dataset.attrs["description"])

    @property
    def crank_angle(self) -> np.ndarray | None:
        """Crank angle at `time`, shape (rows,) [rad]; None if the case has none."""
        port = crank_angle_port(self._checked)
        return self.series(port).values if port in self.ports else None

    @cached_property
    def _checked(self) -> Any:
        return check_case(self.case, self.path)

    @cached_property
    def ports(self) -> list[str]:
        """All scalar outputs that are numbers, "participant.name", and "coupling.name"."""
        return [name for name, is_text in self._scalars.items() if not is_text]

    @property
    def texts(self) -> list[str]:
        """All scalar outputs that are texts, "participant.name"."""
        return [name for name, is_text in self._scalars.items() if is_text]

    @cached_property
    def _scalars(self) -> dict[str, bool]:
        """Scalar outputs, and whether they are texts."""
        is_text: dict[str, bool] = {}

        def note(name, item):
            if isinstance(item, h5py.Dataset):
                is_text[_port(name)] = h5py.check_string_dtype(item.dtype) is not None

        self.file.visititems(note)
        del is_text["time"]
        groups = ("fields.", "envelopes.")
        return {name: text for name, text in is_text.items() if not name.startswith(groups)}

    def structured(self) -> np.ndarray:
        """Return all scalar outputs in FMPy's format of results.

        Returns
        -------
        ndarray, shape (rows,)
            Structured: a field "time" [s], and one for every port in SI, for `fmpy.util.write_csv`
            and
            `plot_result`.
        """
        columns = {"time": self.time} | {port: self.series(port).values for port in self.ports}
        table = np.empty(len(self.time), [(name, one.dtype) for name, one in columns.items()])
        for name, values in columns.items():
            table[name] = values
        return table

    @property
    def instants(self) -> np.ndarray:
        """Instants of the recorded fields [s]."""
        return self.file["fields/time"][self._first_instant :] - self._shift

    @property
    def _first_instant(self) -> int:
        """Index of the first recorded instant that is shown."""
        if not self._first_row:
            return 0
        since = self._times[self._first_row] - ROW_TOLERANCE * self.period
        return int(np.searchsorted(self.file["fields/time"][:], since))

    @property
    def recorded(self) -> list[str]:
        """All fields with an instant that is shown, "participant.name"."""
        if not len(self.instants):
            return []
        groups = {
            owner: group
            for owner, group in self.file["fields"].items()
            if isinstance(group, h5py.Group)
        }
        return [_port(f"{owner}/{name}") for owner, group in groups.items() for name in group]

    def existing_cells(self, port: str) -> np.ndarray | None:
        """Return whether each cell of a field exists, shape (n, m); None if all do, or if unknown.

        A film has no cells where its surface is cut out. The values recorded there have no meaning.
        """
        masks = json.loads(self.file.attrs.get("masks", "{}"))
        owners = [port.partition(".")[0], *self._checked.axes_of(port).participants]
        mask = next((masks[name] for name in owners if name in masks), None)
        path = dataset_path(port)
        shapes = [
            self.file[f"{group}/{path}"].shape
            for group in ("fields", "envelopes")
            if f"{group}/{path}" in self.file
        ]
        if mask is None or not any(shape[-2:] == np.shape(mask) for shape in shapes):
            return None
        return np.array(mask, dtype=bool)

    def there(self, port: str) -> np.ndarray | None:
        """Return `existing_cells(port)`. Deprecated."""
        warn("Results.there: use existing_cells", DeprecationWarning, stacklevel=2)
        return self.existing_cells(port)

    def dataset(self, port: str) -> Any:
        """Return a recorded field at all instants shown, shape (instants, *shape).

        It is sliced like an h5py.Dataset, and read when it is sliced.
        """
        dataset = self.file["fields/" + dataset_path(port)]
        return TrimmedDataset(dataset, self._first_instant) if self._first_row else dataset

    def field(self, port: str, time: float) -> RecordedField:
        """Return the recorded field nearest to `time` [s]; raise `BadInput` for an unknown one."""
        if port not in self.recorded:
            raise BadInput(f"port: {unknown('recorded field', port, self.recorded)}")
        dataset = self.dataset(port)
        instants = self.instants
        k = int(np.argmin(np.abs(instants - time)))
        unit = dataset.attrs["unit"]
        return RecordedField(dataset[k], float(instants[k]), unit, dataset.attrs["description"])

    def envelope(self, port: str) -> Envelope | None:
        """Return the extremes of every cell of a field over the last period; None if unknown.

        If the file has no envelopes, as in an unfinished run, they are those of the recorded
        instants.
        """
        if (path := f"envelopes/{dataset_path(port)}") in self.file:
            dataset = self.file[path]
            attributes = (dataset.attrs[name] for name in ("kind", "unit", "description"))
            return Envelope(dataset[()], *attributes, every_step=True)
        kind = envelope_kinds(self.case).get(port)
        if kind is None or port not in self.recorded:
            return None
        field = self.last.dataset(port)
        attributes = (field.attrs[name] for name in ("unit", "description"))
        values = {"min": np.min, "max": np.max}[kind](field[:], axis=0)
        return Envelope(values, kind, *attributes, every_step=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.path.name}: {self.title}, {len(self.time)} rows>"

    def close(self) -> None:
        """Close the file."""
        self.file.close()


def add_to_summary(path: Path, entries: dict[str, Any]) -> None:
    """Add entries to the summary of a finished run."""
    with h5py.File(path, "a", libver="latest") as file:
        summary = json.loads(str(file.attrs["summary"])) | entries
        file.attrs["summary"] = json.dumps(summary)
