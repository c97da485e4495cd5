"""The lubrication FMU: the variable table and a step."""

from collections.abc import Mapping
from typing import Any

from ..master.fmi.errors import BadInput, Discard
from ..master.fmi.slave import FieldSlave
from ..master.fmi.variables import Variable
from .cavitation import NotConverged
from .model import LubricationModel, State
from .oil import Oil
from .options import BuildOptions
from .parameters import Parameters, faults
from .variables import (
    CONDITION_VARIABLES,
    DERIVATIVE_INPUTS,
    DERIVATIVE_OUTPUTS,
    DIAGNOSTIC_FIELDS,
    FILM_VARIABLES,
    OIL_VARIABLES,
    variables,
)


class Ehd(FieldSlave):
    """Transient lubrication of a piston skirt: mass-conserving cavitation, asperity contact,
    friction.
    """

    name = "fmu_ehd"
    description = "Transient elastohydrodynamic lubrication of a piston skirt"
    state_type = State
    slow_state = ("layer.bore",)
    derivative_inputs = DERIVATIVE_INPUTS
    derivative_outputs = DERIVATIVE_OUTPUTS

    @staticmethod
    def variables(options: Mapping[str, Any]) -> list[Variable]:
        """Variable table for the grid, the oil and the inputs of `options`, build.json."""
        built = BuildOptions.read(options)
        return variables(built.grid, not built.no_fields, built.inputs, built.oil)

    def start(self, values: Mapping[str, Any]) -> tuple[State, dict[str, Any]]:
        """Build the model; state and outputs of a full film."""
        built = BuildOptions.read(self.options)
        parameters = Parameters(
            built.grid,
            Oil(**{v.name: values[v.name] for v in OIL_VARIABLES}),
            open_cells=built.open_cells,
            **{v.name: values[v.name] for v in FILM_VARIABLES + CONDITION_VARIABLES},
        )
        contradictions = faults(parameters)
        if contradictions:
            raise BadInput(contradictions)
        self.built = built
        self.model = LubricationModel(parameters)
        try:
            state, outputs = self.model.start(
                values["film_thickness"], values["sliding_velocity"], **self._conditions(values)
            )
        except NotConverged as trouble:
            raise BadInput(str(trouble)) from None
        return state, self._shown(outputs)

    def advance(
        self, state: State, values: Mapping[str, Any], time: float, step: float
    ) -> tuple[State, dict[str, Any]]:
        """One step; discarded where the film has no solution."""
        try:
            state, outputs = self.model.advance(
                state,
                values["film_thickness"],
                values["sliding_velocity"],
                step,
                **self._conditions(values),
            )
        except NotConverged as trouble:
            raise Discard(f"lubrication step to t = {time + step:g} s: {trouble}") from None
        return state, self._shown(outputs)

    def _conditions(self, values):
        """Inputs that stand in for parameters."""
        return {name: values[name] for name in self.built.inputs}

    def directional_derivative(self, seeds: Mapping[str, Any]) -> dict[str, Any]:
        """Change of both force fields for changed film and velocity at the end of the last step."""
        film, velocity = (seeds[name] for name in DERIVATIVE_INPUTS)
        return dict(zip(DERIVATIVE_OUTPUTS, self.model.tangent(film, velocity)))

    def _shown(self, outputs):
        """Outputs without the diagnostic fields if the FMU was built so."""
        if not self.built.no_fields:
            return outputs
        return {k: v for k, v in outputs.items() if k not in DIAGNOSTIC_FIELDS}
