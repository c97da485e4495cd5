"""The lubrication FMU: the variable table and a step."""

from master.fmi.errors import BadInput, Discard
from master.fmi.slave import FieldSlave

from .cavitation import NotConverged
from .model import LubricationModel, Parameters, State, faults
from .variables import DERIVATIVE_INPUTS, DERIVATIVE_OUTPUTS, PARAMETERS, variables


class Ehd(FieldSlave):
    """Transient lubrication of a piston skirt: mass-conserving cavitation, asperity contact, friction."""

    name = "fmu_ehd"
    description = "Transient elastohydrodynamic lubrication of a piston skirt"
    state_type = State
    derivative_inputs = DERIVATIVE_INPUTS
    derivative_outputs = DERIVATIVE_OUTPUTS

    @staticmethod
    def variables(options):
        """Variable table for the grid of `options`."""
        return variables(tuple(options["grid"]), not options["no_fields"])

    def start(self, values):
        """Build the model; state and outputs of a full film at rest."""
        parameters = Parameters(tuple(self.options["grid"]), **{v.name: values[v.name] for v in PARAMETERS})
        if found := faults(parameters):
            raise BadInput(found)
        self.model = LubricationModel(parameters)
        state, outputs = self.model.start(values["film_thickness"], values["sliding_velocity"])
        return state, self._shown(outputs)

    def advance(self, state, values, time, step):
        """One step; discarded where cavitation does not settle."""
        try:
            state, outputs = self.model.advance(state, values["film_thickness"], values["sliding_velocity"], step)
        except NotConverged as trouble:
            raise Discard(f"lubrication step to t = {time + step:g} s: {trouble}") from None
        return state, self._shown(outputs)

    def directional_derivative(self, seeds):
        """Change of both force fields for changed film and velocity at the end of the last step."""
        return dict(zip(DERIVATIVE_OUTPUTS, self.model.tangent(*(seeds[name] for name in DERIVATIVE_INPUTS))))

    def _shown(self, outputs):
        """Outputs without the diagnostic fields if the FMU was built so."""
        if not self.options["no_fields"]:
            return outputs
        return {k: v for k, v in outputs.items() if k not in ("pressure", "asperity_pressure", "film_fraction")}
