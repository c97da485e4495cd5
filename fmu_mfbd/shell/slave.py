"""The shell's FMU: a table of variables and a step."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from ...master.fmi.slave import FieldSlave
from ...master.fmi.variables import Variable, input_variable
from ..dynamics.bearing_shell import LoadedShell, SupportLoad
from ..geometry.pin import PinForces
from ..reduction.reduced_body import ReducedShell, load
from ..variables import PIN_FORCES, PinInputs, declared


class ShellState(NamedTuple):
    """Modal coordinates of the shell, (k,) [kg^1/2 m]."""

    coordinates: np.ndarray


class ShellOutputs(NamedTuple):
    """Outputs of a shell besides `SupportLoad`: unit and nominal value."""

    bore_deflection: Annotated[np.ndarray, "m", 1e-5]
    """Outward deflection of the bore."""
    largest_deflection: Annotated[float, "m", 1e-5]
    """Largest deflection of the bore."""
    widening_x: Annotated[float, "m", 1e-5]
    """Change of the diameter at mid-length along x."""
    widening_y: Annotated[float, "m", 1e-5]
    """Change of the diameter at mid-length along y."""
    elastic_energy: Annotated[float, "J", 1e-3]
    """Elastic energy of the shell."""


class Shell(FieldSlave):
    """Elastic shell of a bearing, reduced from finite elements."""

    name = "fmu_shell"
    description = "Elastic shell of a bearing, reduced from finite elements"
    state_type = ShellState
    derivative_inputs = PIN_FORCES
    derivative_outputs = ("bore_deflection",)

    @staticmethod
    def variables(options: dict[str, Any]) -> list[Variable]:
        """Return the variables for the options of build.json."""
        grid = tuple(options["grid"])
        forces = declared(PinInputs, input_variable, shape=grid, absent=("nodal_friction",))
        return [*forces, *declared(ShellOutputs, shape=grid), *declared(SupportLoad)]

    def start(self, values: dict[str, Any]) -> tuple[ShellState, dict[str, Any]]:
        """Load the reduced shell, under the forces at the start."""
        self.model = LoadedShell(load(ReducedShell, self.resources / self.options["file"]))
        return self._under(values)

    def advance(
        self, state: ShellState, values: dict[str, Any], time: float, step: float
    ) -> tuple[ShellState, dict[str, Any]]:
        """Take a step; returns (state, outputs)."""
        return self._under(values)

    def directional_derivative(self, seeds: dict[str, Any]) -> dict[str, Any]:
        """Return the deflection under the seed fields, because the shell is linear."""
        return {"bore_deflection": self.model.deflection(self.model.coordinates(_forces(seeds)))}

    def _under(self, values: dict[str, Any]) -> tuple[ShellState, dict[str, Any]]:
        """Return state and outputs under the forces of the film."""
        model, forces = self.model, _forces(values)
        q = model.coordinates(forces)
        opened = model.deflection(q)
        outputs = ShellOutputs(opened, np.abs(opened).max(), *model.widening(q), model.energy(q))
        return ShellState(q), outputs._asdict() | model.on_support(forces, q)._asdict()


def _forces(values: dict[str, Any]) -> PinForces:
    """Return the nodal forces of the film."""
    return PinForces(*(values[name] for name in PIN_FORCES))
