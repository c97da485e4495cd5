"""The body FMU: a table of variables and a step."""

import numpy as np

from ..master.fmi.errors import BadInput, Discard
from ..master.fmi.slave import FieldSlave
from . import variables as table
from .dynamics.assembly import assemble, faults
from .dynamics.model import Inputs, NotConverged, State


class Mfbd(FieldSlave):
    """Flexible piston and cylinder block on a rigid slider-crank, reduced from finite elements."""

    name = "fmu_mfbd"
    description = (
        "Flexible piston and cylinder block on a rigid slider-crank, reduced from finite elements"
    )
    state_type = State
    derivative_inputs = ("nodal_pressure_force", "nodal_friction_force")
    derivative_outputs = ("film_thickness", "sliding_velocity")

    @staticmethod
    def variables(options):
        """The table of variables for the options of build.json."""
        return table.variables(options)

    def start(self, values):
        """Load the reduced bodies and put the piston at its place, at rest; returns (state,
        outputs).
        """
        piston, block = (
            dict(np.load(self.resources / self.options["files"][name]))
            for name in ("piston", "block")
        )
        wrong = faults(values, piston, block, self.options)
        if wrong:
            raise BadInput(wrong)
        self.model = assemble(piston, block, self.options, values)
        if self.options["start"]:
            return self._start_moving(self.options["start"], values)
        return self.model.start(
            values["start_crank_angle"],
            values["start_lateral_displacement"],
            values["start_rocking_angle"],
            self._inputs(values),
        )

    def _start_moving(self, found, values):
        """State and outputs from the outputs that a run had at some instant
        (`start_state.read_start`).
        """
        place, rate = (
            np.array([found[f"lateral_{one}"], found[f"rocking_{two}"], *found[f"modal_{three}"]])
            for one, two, three in (
                ("displacement", "angle", "coordinate"),
                ("velocity", "velocity", "velocity"),
            )
        )
        inputs = self._inputs(
            values | ({"crank_speed": found["rotation_speed"]} if values["crank_free"] else {})
        )
        return self.model.start_moving(found["crank_angle"], place, rate, inputs)

    def advance(self, state, values, time, step):
        """One step; returns (state, outputs)."""
        try:
            return self.model.advance(state, self._inputs(values), step)
        except NotConverged as error:
            raise Discard(str(error)) from None

    def directional_derivative(self, seeds):
        """Product of the step map's derivative with the seed fields."""
        film, sliding = self.model.directional_derivative(
            *(seeds[name] for name in self.derivative_inputs)
        )
        return {"film_thickness": film, "sliding_velocity": sliding}

    def _inputs(self, values):
        return Inputs(
            values["crank_speed"],
            values["gas_pressure"],
            values["nodal_pressure_force"],
            values["nodal_friction_force"],
        )
