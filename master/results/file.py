"""A results file, read; `runs.recorder` says how it is laid out."""

import json
from pathlib import Path

import h5py
import numpy as np


class Results:
    """A results file, read: `time`, `series(port)`, `field(port, time)`, units and descriptions."""

    def __init__(self, path):
        self.path = Path(path)
        self.file = h5py.File(self.path, "r", libver="latest", swmr=self.path.suffix == ".partial")
        self.time = self.file["time"][:]

    @property
    def title(self):
        return self.file.attrs["title"]

    @property
    def case(self):
        """Resolved TOML tree of the run."""
        return json.loads(self.file.attrs["case"])

    @property
    def summary(self):
        """Summary of a finished run, None of one that is not."""
        return json.loads(self.file.attrs["summary"]) if "summary" in self.file.attrs else None

    def series(self, port):
        """Values, unit and description of a scalar output "participant.name"."""
        dataset = self.file[port.replace(".", "/")]
        return dataset[:], dataset.attrs["unit"], dataset.attrs["description"]

    @property
    def ports(self):
        """All scalar outputs, "participant.name", and "coupling.name"."""
        found = []
        self.file.visititems(
            lambda name, item: (
                found.append(name.replace("/", ".")) if isinstance(item, h5py.Dataset) else None
            )
        )
        return [port for port in found if port != "time" and not port.startswith("fields.")]

    def structured(self):
        """All scalar outputs as FMPy hands out results.

        Returns
        -------
        ndarray, shape (rows,)
            Structured: a field "time" [s], and one for every port in SI; `fmpy.util.write_csv` and `plot_result` take it.
        """
        table = np.empty(self.time.size, [("time", float), *((port, float) for port in self.ports)])
        table["time"] = self.time
        for port in self.ports:
            table[port] = self.series(port)[0]
        return table

    def field(self, port, time):
        """Recorded field nearest to `time` [s], its instant [s], unit and description."""
        dataset, instants = (
            self.file["fields/" + port.replace(".", "/")],
            self.file["fields/time"][:],
        )
        k = int(np.argmin(np.abs(instants - time)))
        return dataset[k], float(instants[k]), dataset.attrs["unit"], dataset.attrs["description"]

    def close(self):
        self.file.close()
