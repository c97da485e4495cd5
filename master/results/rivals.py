"""Comparison of FMUs of one role in one case: exchanged fields and cost.

The contract lists the curves to compare for each role (`Curve`).
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..case.contract import Curve, contract, fmu_of_model, replaced_participant, swap
from ..fmi.errors import BadInput
from ..fmi.quantities import pint_unit, registry
from .charts import Chart, draw_charts
from .charts import Curve as Drawn
from .figures import save
from .file import Results
from .judgement import mean_over
from .pictures import labelled, unit_shown

CELLS = {"min": np.min, "sum": np.sum}
"""Functions that reduce the cells of a field to one number."""


INSTANTS = {
    "min": lambda time, values: values.min(),
    "mean": mean_over,
    "rms": lambda time, values: np.sqrt(mean_over(time, values**2)),
    "mean size": lambda time, values: mean_over(time, np.abs(values)),
}
"""Functions that reduce a curve to one number."""

COST = {
    "iterations a step, mean": ("mean_iterations", ""),
    "iterations a step, most": ("max_iterations", ""),
    "wall time": ("wall_time_s", "s"),
}
"""Row of the table -> summary entry and its unit."""


@dataclass(frozen=True)
class Rivals:
    """A case with each of several models as one participant.

    trees : the case's TOML tree by model (file name without suffix, or model); common : a tree
    whose pictures all models can draw; left_out : keys of variables that an FMU lacks, by model;
    ports : exchanged fields of the role, by name.
    """

    role: str
    trees: dict[str, dict]
    common: dict
    left_out: dict[str, list[str]]
    ports: dict[str, str]


def rivals_of(
    tree: dict, role: str, models: list[str], say: Callable[[str], None] = lambda text: None
) -> Rivals:
    """Return the case with each model.

    Parameters
    ----------
    tree : dict
        TOML tree of the case.
    role : str
        Role in the contract.
    models : list of str
        Each is an FMU (*.fmu), a model class FILE.py:CLASS, or a model of the case's own FMU. In a
        case with several participants of the role, "PARTICIPANT=" precedes it.

    Raises
    ------
    BadInput
        If they are for different participants, or the role's own FMU has no choice of models.
    """
    pairs = [replaced_participant(tree, role, model) for model in models]
    if len({name for name, _ in pairs}) > 1:
        names = " and ".join(dict.fromkeys(name for name, _ in pairs))
        raise BadInput(f"--{role}: expected models of one participant, got {names}")
    name = pairs[0][0]
    parameter = contract()[role].model_parameter
    trees = {}
    left_out = {}
    common = tree
    for _, model in pairs:
        if model.endswith(".fmu") or ".py:" in model:
            fmu = fmu_of_model(role, model, tree["participants"][name], say)
            label = Path(model).stem if fmu == Path(model) else model.rpartition(":")[2]
            trees[label], left_out[label] = swap(tree, name, fmu)
            common, _ = swap(common, name, fmu)
        elif parameter is None:
            raise BadInput(f"--{role}: expected an FMU or FILE.py:CLASS, got {model!r}")
        else:
            own = tree["participants"][name]
            parameters = own.get("parameters", {}) | {parameter: model}
            trees[model] = tree | {
                "participants": tree["participants"] | {name: own | {"parameters": parameters}}
            }
    ports = exchanged(tree, role, name)
    for label, each in trees.items():
        record = each.get("record", {})
        fields = list(dict.fromkeys([*record.get("fields", []), *ports.values()]))
        # every model reaches these instants, whatever its steps
        every = each["time"]["step"]
        trees[label] = each | {"record": record | {"fields": fields, "every": every}}
    return Rivals(role, trees, common, left_out, ports)


def exchanged(tree: dict, role: str, name: str) -> dict[str, str]:
    """Return the fields that participant `name` exchanges in its role, by name in the contract.

    Each value is the participant.variable that records the field at its source.
    """
    terms = contract()[role]
    sources = {wire["to"]: wire["from"] for wire in tree["wires"]}
    wired = {*sources, *sources.values()}

    def port(field):
        around = f"{name}.{terms.around.get(field)}"
        own = f"{name}.{field}"
        return around if around in wired and own not in wired else own

    inputs = {field: port(field) for field in terms.inputs["field"]}
    outputs = {field: port(field) for field in terms.outputs["field"]}
    return {field: sources.get(port, port) for field, port in inputs.items()} | outputs


@dataclass(frozen=True)
class Exchange:
    """Exchange of a run: instants [s], shape (n,), fields by name, shape (n, ...), in SI."""

    time: np.ndarray
    fields: dict[str, np.ndarray]
    units: dict[str, str]


def exchange(results: Results, ports: dict[str, str]) -> Exchange:
    """Return the exchanged fields of a run."""
    return Exchange(
        results.instants,
        {name: results.dataset(port)[:] for name, port in ports.items()},
        {name: results.dataset(port).attrs["unit"] for name, port in ports.items()},
    )


def drawn(curve: Curve, one: Exchange, first: Exchange) -> tuple[np.ndarray, np.ndarray]:
    """Return instants [s] and values of a curve, in its unit.

    Eq. (X5):  y(t) = factor C(f_1 f_2 ..) over the cells,   C the minimum or the sum, or for a
               distance the root mean square of f_1 - (f_1 of the first) at common instants
    """
    si = " * ".join(pint_unit(one.units[name]) for name in curve.fields)
    scale = curve.factor * registry().Quantity(1.0, si).to(curve.unit).magnitude
    if curve.cells == "distance":
        time, apart = distance(one, first, curve.fields[0])
        return time, scale * apart
    product = np.prod([one.fields[name] for name in curve.fields], axis=0)
    # Eq. (X5)
    return one.time, scale * CELLS[curve.cells](product, axis=tuple(range(1, product.ndim)))


def distance(one: Exchange, first: Exchange, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return common instants [s], and the root mean square difference of a field over its cells."""
    shared, here, there = np.intersect1d(one.time, first.time, return_indices=True)
    apart = one.fields[name][here] - first.fields[name][there]
    return shared, np.sqrt(np.mean(apart**2, axis=tuple(range(1, apart.ndim))))


def measures(
    role: str, runs: dict[str, Exchange], summaries: dict[str, dict]
) -> dict[str, list[float]]:
    """Return the values of the rows of `rows_of`, for every model.

    Parameters
    ----------
    role : str
    runs, summaries : dict
        Exchange and summary of the run by model. The first model is the reference.
    """
    first = next(iter(runs.values()))
    return {
        label: [
            *(
                float(INSTANTS[curve.instants](*drawn(curve, one, first)))
                for curve in contract()[role].curves
            ),
            *(summaries[label][key] for key, _ in COST.values()),
        ]
        for label, one in runs.items()
    }


def rows_of(role: str) -> dict[str, str]:
    """Return the rows of the table of measures, and their units."""
    curves = {curve.number: curve.unit for curve in contract()[role].curves}
    return curves | {name: unit for name, (_, unit) in COST.items()}


def draw_rivals(
    role: str,
    runs: dict[str, Exchange],
    iterations: dict[str, tuple[np.ndarray, np.ndarray]],
    path: Path,
) -> None:
    """Draw the role's curves and iterations over time, with all models in each panel.

    Parameters
    ----------
    role : str
    runs : dict
        Exchange by model.
    iterations : dict
        Instants [s] and iterations of each step, by model.
    path : Path
        The PNG file.
    """
    first = next(iter(runs.values()))
    charts = []
    for curve in contract()[role].curves:
        if curve.title:
            courses = {label: drawn(curve, one, first) for label, one in runs.items()}
            title = labelled(curve.title, unit_shown(curve.unit, None))
            charts.append(_chart(title, courses))
    steps = {label: (time[1:], count[1:]) for label, (time, count) in iterations.items()}
    save(draw_charts([*charts, _chart("iterations", steps)], 1.9), path)


def _chart(title, courses):
    """Return a chart of values over time [s] by model, without those that are zero."""
    curves = [
        Drawn(label, k, 1e3 * time, values)
        for k, (label, (time, values)) in enumerate(courses.items())
        if values.any()  # the distance of the first model is zero
    ]
    return Chart(title, "time [ms]", "", curves)
