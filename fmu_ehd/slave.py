"""The lubrication FMU: the variable table and a step."""

import numpy as np

from ..master.fmi.errors import BadInput, Discard
from ..master.fmi.slave import FieldSlave
from .cavitation import NotConverged
from .model import LubricationModel, State
from .oil import Oil
from .parameters import Parameters, faults
from .variables import (
    CHOICES,
    CONDITIONS,
    DERIVATIVE_INPUTS,
    DERIVATIVE_OUTPUTS,
    FILM,
    OIL,
    variables,
)


class Ehd(FieldSlave):
    """Transient lubrication of a piston skirt: mass-conserving cavitation, asperity contact,
    friction.
    """

    name = "fmu_ehd"
    description = "Transient elastohydrodynamic lubrication of a piston skirt"
    state_type = State
    derivative_inputs = DERIVATIVE_INPUTS
    derivative_outputs = DERIVATIVE_OUTPUTS

    @staticmethod
    def variables(options):
        """Variable table for the grid, the oil and the inputs of `options`."""
        return variables(
            tuple(options["grid"]), not options["no_fields"], options["inputs"], options["oil"]
        )

    def start(self, values):
        """Build the model; state and outputs of a full film."""
        found = [
            f"{name} = {values[name]!r}: allowed are {', '.join(allowed)}"
            for name, allowed in CHOICES.items()
            if values[name] not in allowed
        ]
        if found:
            raise BadInput(found)
        fixed = {v.name: values[v.name] for v in FILM + CONDITIONS}
        parameters = Parameters(
            tuple(self.options["grid"]),
            Oil(**{v.name: values[v.name] for v in OIL}),
            **fixed,
            open_cells=self._open_cells(),
        )
        if found := faults(parameters):
            raise BadInput(found)
        self.model = LubricationModel(parameters)
        try:
            state, outputs = self.model.start(
                values["film_thickness"], values["sliding_velocity"], **self._conditions(values)
            )
        except NotConverged as trouble:
            raise BadInput(str(trouble)) from None
        return state, self._shown(outputs)

    def advance(self, state, values, time, step):
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

    def _open_cells(self):
        """Cut-outs of the mask, None without one."""
        mask = self.options["mask"]
        return None if mask is None else np.array(mask) == 0

    def _conditions(self, values):
        """Inputs that stand in for parameters."""
        return {name: values[name] for name in self.options["inputs"]}

    def directional_derivative(self, seeds):
        """Change of both force fields for changed film and velocity at the end of the last step."""
        return dict(
            zip(
                DERIVATIVE_OUTPUTS, self.model.tangent(*(seeds[name] for name in DERIVATIVE_INPUTS))
            )
        )

    def _shown(self, outputs):
        """Outputs without the diagnostic fields if the FMU was built so."""
        if not self.options["no_fields"]:
            return outputs
        return {
            k: v
            for k, v in outputs.items()
            if k not in ("pressure", "asperity_pressure", "film_fraction")
        }
