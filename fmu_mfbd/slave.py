"""The body FMU: a table of variables and a step."""

from dataclasses import fields
from typing import Any

import numpy as np
from pythonfmu.enums import Fmi2Status

from ..master.fmi.errors import BadInput, Discard
from ..master.fmi.slave import FieldSlave
from ..master.fmi.variables import Variable
from . import variables as table
from .dynamics.assembly import assemble, faults
from .dynamics.build_options import BuildOptions
from .dynamics.instant import Response, RingForce
from .dynamics.model import Inputs, NotConverged, PistonInBore, State
from .dynamics.parameters import Parameters
from .reduction.reduced_body import ReducedBlock, ReducedPiston, load


class Mfbd(FieldSlave):
    """Flexible piston and cylinder block on a rigid slider-crank, reduced from finite elements."""

    name = "fmu_mfbd"
    description = (
        "Flexible piston and cylinder block on a rigid slider-crank, reduced from finite elements"
    )
    state_type = State
    derivative_inputs = (
        "nodal_pressure_force",
        "nodal_friction_force",
        "ring_side_force",
        "ring_axial_force",
        "ring_moment",
    )
    derivative_outputs = Response._fields

    @staticmethod
    def variables(options: dict[str, Any]) -> list[Variable]:
        """The table of variables for the options of build.json."""
        return table.variables(BuildOptions.from_json(options))

    def start(self, values: dict[str, Any]) -> tuple[State, dict[str, Any]]:
        """Load the reduced bodies and begin at rest, or with the motion that the build names;
        returns (state, outputs).
        """
        options = BuildOptions.from_json(self.options)
        parameters = Parameters(**{one.name: values[one.name] for one in fields(Parameters)})
        piston = load(ReducedPiston, self.resources / options.piston.file)
        block = load(ReducedBlock, self.resources / options.block.file)
        wrong = faults(piston, block, options, parameters)
        if wrong:
            raise BadInput(wrong)
        self.model = assemble(piston, block, options, parameters)
        try:
            state, outputs = self._begin(self.model, options, parameters, values)
            _, straight = self._begin(self.model.unyielding(), options, parameters, values)
        except NotConverged as error:
            raise BadInput([f"start: {error}"]) from None
        self._tell_of_bend(np.abs(outputs["film_thickness"] - straight["film_thickness"]).max())
        return state, outputs

    def _tell_of_bend(self, bend: float) -> None:
        """Log by how much modes without inertia bend the gap [m] before a film knows it: it starts
        with the oil of the bent gap, where modes with inertia start straight and press oil out.
        """
        if bend > 0.0:
            self.log(
                f"modes above quasi_static_frequency bend the gap by up to {bend:.3g} m at the "
                "start, and a film that starts full begins with the oil of the bent gap: motion "
                "and thinnest film of the first strokes depend on it",
                Fmi2Status.warning,
            )

    @staticmethod
    def _begin(
        model: PistonInBore,
        options: BuildOptions,
        parameters: Parameters,
        values: dict[str, Any],
    ) -> tuple[State, dict[str, Any]]:
        """State and outputs at the start."""
        if not options.start:
            return model.start(
                parameters.start_crank_angle,
                parameters.start_lateral_displacement,
                parameters.start_rocking_angle,
                _inputs(values),
            )
        if parameters.crank_free:
            values = values | {"crank_speed": options.start.rotation_speed}
        return model.start_moving(
            options.start.crank_angle,
            options.start.position(),
            options.start.velocity(),
            _inputs(values),
        )

    def advance(
        self, state: State, values: dict[str, Any], time: float, step: float
    ) -> tuple[State, dict[str, Any]]:
        """One step; returns (state, outputs)."""
        try:
            return self.model.advance(state, _inputs(values), step)
        except NotConverged as error:
            raise Discard(str(error)) from None

    def directional_derivative(self, seeds: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Product of the step map's derivative with the seed fields."""
        response = self.model.directional_derivative(
            seeds["nodal_pressure_force"], seeds["nodal_friction_force"], _rings(seeds)
        )
        return response._asdict()


def _inputs(values: dict[str, Any]) -> Inputs:
    return Inputs(
        values["crank_speed"],
        values["gas_pressure"],
        values["nodal_pressure_force"],
        values["nodal_friction_force"],
        _rings(values),
        float(values["land_pressure"]),
    )


def _rings(values: dict[str, Any]) -> RingForce:
    names = ("ring_side_force", "ring_axial_force", "ring_moment")
    return RingForce(*(float(values[name]) for name in names))
