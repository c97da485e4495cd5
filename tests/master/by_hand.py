"""Results files with numbers by hand."""

import json

import h5py
import numpy as np

from piston_cosim.master.results.file import Results


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
