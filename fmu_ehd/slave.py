"""The lubrication FMU: the variable table and a step."""

from collections.abc import Mapping
from typing import Any

from pythonfmu.enums import Fmi2Status

from ..master.fmi.errors import BadInput, Discard
from ..master.fmi.slave import FieldSlave
from ..master.fmi.variables import Variable
from .common.faults import NotConverged
from .model import LubricationModel
from .options import BuildOptions
from .parameters import TUNABLE, faults, numbers_of, parameters_of
from .state import Memory
from .variables import (
    DERIVATIVE_INPUTS,
    DERIVATIVE_OUTPUTS,
    TURNING_INPUT,
    TURNING_OUTPUT,
    variables,
)


class Ehd(FieldSlave):
    """Transient lubrication of a piston skirt or a journal bearing.

    Mass-conserving cavitation, asperity contact, friction.
    """

    name = "fmu_ehd"
    description = "Transient elastohydrodynamic lubrication of a piston skirt"
    state_type = Memory
    slow_state = ("layer.bore",)
    _remarked: frozenset[str] = frozenset()

    @property
    def derivative_inputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """Motions of the surface."""
        return DERIVATIVE_INPUTS + ((TURNING_INPUT,) if self._bearing else ())

    @property
    def derivative_outputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """Nodal forces."""
        return DERIVATIVE_OUTPUTS + ((TURNING_OUTPUT,) if self._bearing else ())

    @property
    def _bearing(self):
        return self.options.get("surface") == "bearing"

    @staticmethod
    def variables(options: Mapping[str, Any]) -> list[Variable]:
        """Return the variables for grid, oil and inputs of `options`, the content of build.json."""
        built = BuildOptions.read(options)
        return variables(built.grid, built.inputs, built.oil, built.surface)

    def start(self, values: Mapping[str, Any]) -> tuple[Memory, dict[str, Any]]:
        """Build the model; state and outputs of a full film."""
        built = BuildOptions.read(self.options)
        parameters = parameters_of(
            values, shape=built.grid, open_cells=built.open_cells, surface=built.surface
        )
        contradictions = faults(parameters)
        if contradictions:
            raise BadInput(contradictions)
        self.built = built
        self.model = LubricationModel(parameters)
        try:
            state, outputs = self.model.start(
                values["film_thickness"],
                values["sliding_velocity"],
                values.get(TURNING_INPUT),
                **self._conditions(values),
            )
        except NotConverged as trouble:
            raise BadInput(str(trouble)) from None
        self._log_remark()
        return state, outputs

    def advance(
        self, state: Memory, values: Mapping[str, Any], time: float, step: float
    ) -> tuple[Memory, dict[str, Any]]:
        """Take one step; discard it if the film has no solution."""
        try:
            state, outputs = self.model.advance(
                state,
                values["film_thickness"],
                values["sliding_velocity"],
                step,
                values.get(TURNING_INPUT),
                **self._conditions(values),
            )
        except NotConverged as trouble:
            raise Discard(f"lubrication step to t = {time + step:g} s: {trouble}") from None
        self._log_remark()
        return state, outputs

    @property
    def no_nearby_step(self) -> str:
        """Return why the film has no step next to a solved one, or ""."""
        model = self.model.fixed.domain.model
        if self.model.fixed.surfaces.compliance > 0.0:
            return "a film under a coating has no forward sensitivities"
        if not model.conserving and (model.switching or model.clipping):
            return "a cavitation model that loses oil has no forward sensitivities"
        return ""

    def advance_nearby(
        self, base: "Ehd", state: Memory, values: Mapping[str, Any], time: float, step: float
    ) -> tuple[Memory, dict[str, Any]]:
        """Take a step next to the last one of `base`, `LubricationModel.advance_nearby`."""
        try:
            return self.model.advance_nearby(
                base.model,
                state,
                values["film_thickness"],
                values["sliding_velocity"],
                step,
                values.get(TURNING_INPUT),
                **self._conditions(values),
            )
        except NotConverged as trouble:
            raise Discard(f"lubrication step to t = {time + step:g} s: {trouble}") from None

    def _log_remark(self):
        """Log the warning of the last start or step, each once."""
        text = self.model.remark
        if text and text not in self._remarked:
            self._remarked |= {text}
            self.log(text, Fmi2Status.warning)

    def _conditions(self, values):
        """Return inputs that replace parameters, and parameters that differ from the start."""
        started = numbers_of(self.model.parameters)
        changed = (n for n in TUNABLE if values[n] != getattr(started, n))
        return {name: values[name] for name in {*self.built.inputs, *changed}}

    def directional_derivative(self, seeds: Mapping[str, Any]) -> dict[str, Any]:
        """Change of both force fields for changed film and velocity at the end of the last step."""
        motions = [seeds[name] for name in self.derivative_inputs]
        return dict(zip(self.derivative_outputs, self.model.tangent(*motions)))
