"""Results with numbers by hand, in files and in memory."""

import json

import h5py
import numpy as np

from piston_cosim.master.results.file import Results
from piston_cosim.master.results.recorded import Series


class Held(np.ndarray):
    """An array with a dataset's attributes."""

    attrs: dict


class InMemory:
    """Results of one period in memory.

    All are of one case: `series` is {port: (values, unit)} at every time, `fields` at the instants.
    """

    period = 0.0

    def __init__(self, time, series, fields=(), case=None):
        self.time = self.instants = np.array(time)
        self.known, self.fields, self.case = dict(series), dict(fields), case
        self.summary, self.envelopes = {}, {}
        self.envelope = self.envelopes.get
        self.last = self.whole = self

    ports = property(lambda self: list(self.known))
    recorded = property(lambda self: list(self.fields))

    def series(self, port):
        values, unit = self.known[port]
        return Series(np.array(values), unit, "")

    def dataset(self, port):
        values, unit = self.fields[port]
        held = np.array(values).view(Held)
        held.attrs = {"unit": unit}
        return held

    def existing_cells(self, port):
        return None


def coupling(rows):
    """Series of the coupling."""
    names = ("iterations", "derivative_products", "residual")
    return {f"coupling.{name}": (np.full(rows, 0.5), "1") for name in names}


def write_results(path, time, series=(), fields=(), instants=None, **said):
    """Results of {port: (values, unit)} at every time and {field: (values, unit)} at the instants.

    `said` are the attributes of the file.
    """
    with h5py.File(path, "w") as file:
        for name, one in said.items():
            file.attrs[name] = one if isinstance(one, str) else json.dumps(one)
        file["time"] = time
        if instants is not None:
            file["fields/time"] = instants
        fields = {f"fields/{name}": one for name, one in dict(fields).items()}
        for name, (values, unit) in (dict(series) | fields).items():
            name = name.replace(".", "/")
            file[name] = values
            file[name].attrs.update({"unit": unit, "description": name})
    return Results(path)
