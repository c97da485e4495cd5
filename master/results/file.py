"""A results file, read; `runs.recorder` says how it is laid out."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import numpy as np


class Series(NamedTuple):
    """A scalar output over the macro steps, shape (rows,), in its SI unit."""

    values: np.ndarray
    unit: str
    description: str


class RecordedField(NamedTuple):
    """A field at the instant `time` [s], in its SI unit."""

    values: np.ndarray
    time: float
    unit: str
    description: str


SLASH = "\u2215"
"""Stands for / in the names of datasets, where HDF5 would take / for a group."""


def dataset_path(port: str) -> str:
    """Where a results file holds "participant.name"."""
    owner, _, name = port.partition(".")
    return f"{owner}/{name.replace('/', SLASH)}"


def _port(path: str) -> str:
    return path.replace("/", ".", 1).replace(SLASH, "/")


class Results:
    """A results file, read: `time`, `series(port)`, `field(port, time)`, units and descriptions."""

    def __init__(self, path: str | Path):
        self.path = Path(path)
        self.file: Any = h5py.File(
            self.path, "r", libver="latest", swmr=self.path.suffix == ".partial"
        )
        self.time: np.ndarray = self.file["time"][:]

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
        """Summary of a finished run, None of one that is not."""
        return json.loads(self.file.attrs["summary"]) if "summary" in self.file.attrs else None

    def series(self, port: str) -> Series:
        """Scalar output "participant.name"."""
        dataset = self.file[dataset_path(port)]
        return Series(dataset[:], dataset.attrs["unit"], dataset.attrs["description"])

    @property
    def ports(self) -> list[str]:
        """All scalar outputs, "participant.name", and "coupling.name"."""
        names: list[str] = []

        def note(name, item):
            if isinstance(item, h5py.Dataset):
                names.append(_port(name))

        self.file.visititems(note)
        return [name for name in names if name != "time" and not name.startswith("fields.")]

    def structured(self) -> np.ndarray:
        """All scalar outputs as FMPy hands out results.

        Returns
        -------
        ndarray, shape (rows,)
            Structured: a field "time" [s], and one for every port in SI; `fmpy.util.write_csv` and
            `plot_result` take it.
        """
        columns = [("time", float), *((port, float) for port in self.ports)]
        table = np.empty(len(self.time), columns)
        table["time"] = self.time
        for port in self.ports:
            table[port] = self.series(port).values
        return table

    @property
    def instants(self) -> np.ndarray:
        """Instants of the recorded fields [s]."""
        return self.file["fields/time"][:]

    @property
    def recorded(self) -> list[str]:
        """All recorded fields, "participant.name"."""
        groups = {
            owner: group
            for owner, group in self.file["fields"].items()
            if isinstance(group, h5py.Group)
        }
        return [_port(f"{owner}/{name}") for owner, group in groups.items() for name in group]

    def dataset(self, port: str) -> Any:
        """Recorded field at all instants, h5py.Dataset of shape (instants, *shape)."""
        return self.file["fields/" + dataset_path(port)]

    def field(self, port: str, time: float) -> RecordedField:
        """Recorded field nearest to `time` [s]."""
        dataset = self.dataset(port)
        instants = self.instants
        k = int(np.argmin(np.abs(instants - time)))
        unit = dataset.attrs["unit"]
        return RecordedField(dataset[k], float(instants[k]), unit, dataset.attrs["description"])

    def close(self) -> None:
        """Close the file."""
        self.file.close()
