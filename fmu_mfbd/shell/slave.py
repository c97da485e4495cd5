"""The shell's FMU: a table of variables and a step."""

from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.slave import FieldSlave
from ...master.fmi.variables import Variable
from ..dynamics.bearing_shell import YieldingShell
from ..geometry.pin import PinForces
from ..reduction.reduced_body import ReducedShell, load
from ..variables import PIN_FORCES
from . import variables as table
from .variables import DEFLECTION


class ShellState(NamedTuple):
    """Modal coordinates of the shell, (k,) [kg^1/2 m]."""

    coordinates: np.ndarray


class Shell(FieldSlave):
    """Elastic shell of a bearing, reduced from finite elements."""

    name = "fmu_shell"
    description = "Elastic shell of a bearing, reduced from finite elements"
    state_type = ShellState
    derivative_inputs = PIN_FORCES
    derivative_outputs = (DEFLECTION,)

    @staticmethod
    def variables(options: dict[str, Any]) -> list[Variable]:
        """Return the variables for the options of build.json."""
        around, along = options["grid"]
        return table.variables((around, along))

    def start(self, values: dict[str, Any]) -> tuple[ShellState, dict[str, Any]]:
        """Load the reduced shell, under the forces at the start."""
        self.model = YieldingShell(load(ReducedShell, self.resources / self.options["file"]))
        return self._under(values)

    def advance(
        self, state: ShellState, values: dict[str, Any], time: float, step: float
    ) -> tuple[ShellState, dict[str, Any]]:
        """Take a step; returns (state, outputs)."""
        return self._under(values)

    def directional_derivative(self, seeds: dict[str, Any]) -> dict[str, Any]:
        """Return the deflection under the seed fields, because the shell is linear."""
        model = self.model
        return {DEFLECTION: model.deflection(model.coordinates(_forces(seeds)))}

    def _under(self, values: dict[str, Any]) -> tuple[ShellState, dict[str, Any]]:
        """Return state and outputs under the forces of the film."""
        model, forces = self.model, _forces(values)
        q = model.coordinates(forces)
        opened = model.deflection(q)
        wider_x, wider_y = model.widening(q)
        return ShellState(q), {
            DEFLECTION: opened,
            "largest_deflection": np.abs(opened).max(),
            "widening_x": wider_x,
            "widening_y": wider_y,
            "elastic_energy": model.energy(q),
            **model.on_support(forces, q)._asdict(),
        }


def _forces(values: dict[str, Any]) -> PinForces:
    """Return the nodal forces of the film."""
    return PinForces(*(values[name] for name in PIN_FORCES))
