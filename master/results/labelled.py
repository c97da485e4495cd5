"""Results with named dimensions: an xarray dataset or a pandas table."""

from importlib import import_module
from typing import Any

import numpy as np

from ..case.schema import Case
from ..coupling.wiring import port_of
from ..fmi.errors import BadInput
from .coordinates import INSTANT, crank_angle_port, dimensions, distinct, names_taken
from .recorded import Recorded


def _library(name: str) -> Any:
    """Return an optional library; raise `BadInput` if it is not installed."""
    try:
        return import_module(name)
    except ImportError:
        raise BadInput(
            f"{name}: expected it installed, got nothing; run pip install 'piston-cosim[xarray]'"
        ) from None


def to_xarray(results: Recorded, case: Case) -> Any:
    """Return the dataset of `Results.to_xarray`."""
    xarray = _library("xarray")
    angle = crank_angle_port(case)
    coordinates = {"time": ("time", results.time, {"units": "s", "long_name": "time"})}
    variables = {}
    for port in (*results.ports, *results.texts):
        values, unit, description = results.series(port)
        variables[port] = ("time", values, {"units": unit, "long_name": description})
    if angle in variables:
        coordinates["crank_angle"] = variables[angle]
    if not results.recorded:
        return xarray.Dataset(variables, coordinates, {"title": results.title})
    instants = results.instants
    coordinates[INSTANT] = (INSTANT, instants, {"units": "s", "long_name": "time of the fields"})
    if angle in variables:
        _, values, words = variables[angle]
        at = np.searchsorted(results.time, instants)
        coordinates["instant_crank_angle"] = (INSTANT, values[at], words)
    names = names_taken(results.case["participants"])
    for port in results.recorded:
        dataset = results.dataset(port)
        owner, _ = port_of(port)
        named = [distinct(names, one, owner) for one in dimensions(case, port, dataset.shape[1:])]
        for one in named:
            words = {"units": one.unit, "long_name": one.description}
            coordinates[one.name] = (one.name, one.positions, words)
        words = {"units": dataset.attrs["unit"], "long_name": dataset.attrs["description"]}
        variables[port] = ((INSTANT, *(one.name for one in named)), dataset[:], words)
    return xarray.Dataset(variables, coordinates, {"title": results.title})


def to_dataframe(results: Recorded) -> Any:
    """Return the table of `Results.to_dataframe`."""
    pandas = _library("pandas")
    series = {port: results.series(port) for port in (*results.ports, *results.texts)}
    table = pandas.DataFrame(
        {port: values for port, (values, _, _) in series.items()},
        index=pandas.Index(results.time, name="time"),
    )
    table.attrs["units"] = {"time": "s"} | {port: unit for port, (_, unit, _) in series.items()}
    return table
