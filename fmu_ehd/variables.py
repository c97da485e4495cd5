"""The variables of the lubrication FMU, each declared once.

In a bearing, skirt and bore are journal and shell. The grid of the film is fixed to the shell.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import Annotated, Any, NamedTuple, get_type_hints

import numpy as np

from ..master.fmi.texts import description
from ..master.fmi.variables import Variable, constant, input_variable, output_variable
from .common.declaration import variables_of
from .laws.oil import Oil
from .parameters import TUNABLE, Parameters, is_of
from .state import Fields, Scalars

CONTRACT_VERSION = 2

OIL_VARIABLES = variables_of(Oil)
FILM_VARIABLES = variables_of(Parameters)
CONDITION_VARIABLES = variables_of(Parameters, condition=True)  # may be inputs

KELVIN = next(
    (v.minimum, v.maximum) for v in CONDITION_VARIABLES if v.name == "oil_temperature_lower_edge"
)

DERIVATIVE_INPUTS = ("film_thickness", "sliding_velocity")
DERIVATIVE_OUTPUTS = ("nodal_pressure_force", "nodal_friction_force")
# a bearing's, beside these
TURNING_INPUT = "circumferential_velocity"
TURNING_OUTPUT = "nodal_circumferential_force"


def variables(
    shape: tuple[int, int],
    inputs: Collection[str] = (),
    starts: Mapping[str, float | str] | None = None,
    surface: str = "skirt",
) -> list[Variable]:
    """Return the variable table of the FMU for a grid.

    Parameters
    ----------
    shape : tuple of int
        (n_circumferential, n_axial).
    inputs : collection of str
        Names in `CONDITION_VARIABLES` that are inputs instead of tunable parameters;
        "oil_temperature" adds a field input that replaces the two edge temperatures.
    starts : mapping, optional
        Start values of parameters, in place of the defaults (an oil of the library).
    surface : str
        One of `parameters.SURFACES`.

    Returns
    -------
    list of master.fmi.variables.Variable
    """
    conditions = [
        replace(v, causality="input") if v.name in inputs else replace(v, tunable=True)
        for v in CONDITION_VARIABLES
    ]
    if "oil_temperature" in inputs:
        conditions.append(
            input_variable(
                "oil_temperature", "K", "Oil temperature", 373.15, 373.15, shape, limits=KELVIN
            )
        )
    parameters = [
        replace(v, start=(starts or {}).get(v.name, v.start), tunable=v.name in TUNABLE)
        for v in film_variables(surface) + OIL_VARIABLES
    ]
    exchanged = _motions(shape) | {v.name: v for v in declared_outputs(Fields, shape)}
    turning = (TURNING_INPUT, TURNING_OUTPUT) if surface == "bearing" else ()
    return [
        constant("n_circumferential", shape[0], "Number of cells around the skirt"),
        constant("n_axial", shape[1], "Number of cells along the skirt"),
        constant("contract_version", CONTRACT_VERSION, "Version of the lubrication contract"),
        *parameters,
        *conditions,
        *(exchanged[name] for name in DERIVATIVE_INPUTS + DERIVATIVE_OUTPUTS),
        *(exchanged[name] for name in turning),
        *(exchanged[name] for name in ("pressure", "asperity_pressure", "film_fraction")),
        *(v for v in SUMMARY if is_of(surface, v.name)),
    ]


def film_variables(surface: str) -> list[Variable]:
    """Return the parameters of a film that are no conditions, for one of `parameters.SURFACES`."""
    return [v for v in FILM_VARIABLES if is_of(surface, v.name)]


class Motions(NamedTuple):
    """Motions of the surface: unit, start and nominal value."""

    film_thickness: Annotated[np.ndarray, "m", 1e-5, 1e-5]
    """Radial distance from skirt to bore at the end of the step; negative where they overlap."""
    sliding_velocity: Annotated[np.ndarray, "m/s", 0.0, 1.0]
    """Axial velocity of the skirt relative to the bore at the end of the step."""
    circumferential_velocity: Annotated[np.ndarray, "m/s", 0.0, 1.0]
    """Circumferential velocity of the journal relative to the shell at the end of the step,
    positive with ascending i.
    """


def _rows_of(kind: type) -> Iterator[tuple[Any, ...]]:
    """Yield name, unit, description and numbers of the members of a named tuple."""
    for name, hint in get_type_hints(kind, include_extras=True).items():
        unit, *numbers = hint.__metadata__
        yield name, unit, description(kind, name), *numbers


def _motions(shape: tuple[int, int]) -> dict[str, Variable]:
    """Return the motions of the surface, by name."""
    return {row[0]: input_variable(*row, shape=shape) for row in _rows_of(Motions)}


def declared_outputs(kind: type, shape: tuple[int, ...] = ()) -> list[Variable]:
    """Return the outputs that `step.Fields` or `step.Scalars` declare."""
    return [
        output_variable(*row, shape=shape, start=STARTS.get(row[0], 0.0)) for row in _rows_of(kind)
    ]


STARTS = {"film_fraction": 1.0}
"""Start values of outputs other than 0."""
SUMMARY = declared_outputs(Scalars)
"""Outputs that sum the film up, that of bearings last."""
SUMMARY.insert(
    -1,
    output_variable("solver_iterations", "1", "Number of factorisations in the last step", start=0),
)
