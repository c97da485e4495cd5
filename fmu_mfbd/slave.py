"""The body FMU: a table of variables and a step."""

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from pythonfmu.enums import Fmi2Status

from ..master.fmi.errors import BadInput, Discard
from ..master.fmi.slave import FieldSlave
from ..master.fmi.variables import Variable
from . import variables as table
from .dynamics.assembly import load_bodies, model_of
from .dynamics.build_options import BuildOptions
from .dynamics.model import (
    MOTION,
    NO_FIELD,
    NOT_CARRIED,
    OIL,
    ON_BLOCK,
    ON_FLEXIBLE_BLOCK,
    Inputs,
    MotionNotSolved,
    PistonInBore,
    stacked,
)
from .dynamics.model_faults import faults
from .dynamics.parameters import (
    ELEMENT_PARAMETERS,
    REFERENCE,
    TUNABLE,
    Damping,
    Parameters,
    parameters_from,
)
from .dynamics.state import PistonState
from .dynamics.system import RingForce
from .geometry.pin import PinForces
from .mechanism.carrier import FIXED, BlockMotion
from .mechanism.piston_motion import RIGID
from .variables import BLOCK, FILM, FORCES, PIN_FILM, PIN_FORCES, RINGS, WALL_FIELDS, WALL_LEVELS

BORE = "bore_deflection"
"""Input field of a bore whose deflection comes from another participant."""


class Mfbd(FieldSlave):
    """Flexible piston and cylinder block on a rigid slider-crank, reduced from finite elements."""

    name = "fmu_mfbd"
    description = (
        "Flexible piston and cylinder block on a rigid slider-crank, reduced from finite elements"
    )
    state_type = PistonState
    _warned: str = ""

    @cached_property
    def built(self) -> BuildOptions:
        """Return the content of build.json."""
        return BuildOptions.from_json(self.options)

    @cached_property
    def derivative_inputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the names of forces of films and rings, and of the motion of a mounted block."""
        block = BLOCK if self.built.mounted else ()
        bore = (BORE,) if self.built.block.bore_from_outside else ()
        return (*self._of_films(FORCES), *self._of_pins(PIN_FORCES), *RINGS, *block, *bore)

    @cached_property
    def derivative_outputs(self):  # pyright: ignore[reportIncompatibleVariableOverride]
        """Return the names of fields of films, of motion and of forces on a mounted block."""
        skirt = self._of_films(FILM)
        block = ON_BLOCK if self.built.mounted else ()
        bore = ON_FLEXIBLE_BLOCK if self.built.block.bore_from_outside else ()
        oil = self._of_films((OIL,)) if self.built.temperatures else ()
        return (*skirt, *self._of_pins(PIN_FILM), *MOTION, *block, *bore, *oil)

    @cached_property
    def force_fields(self) -> dict[str, list[str]]:
        """Return the variables of all film surfaces of the skirt, by each of `FORCES`."""
        return {name: self._of_films((name,)) for name in FORCES}

    def _of_films(self, names: tuple[str, ...]) -> list[str]:
        """Return the variables of these names of all film surfaces of the skirt."""
        return [f"{film.prefix}{name}" for film in self.built.film_grids() for name in names]

    def _of_pins(self, names: tuple[str, ...]) -> list[str]:
        """Return the variables of these names of all films of a floating pin."""
        return [f"{film.prefix}{name}" for film in self.built.pin_grids() for name in names]

    @staticmethod
    def variables(options: dict[str, Any]) -> list[Variable]:
        """Return the variables for the options of build.json."""
        return table.variables(BuildOptions.from_json(options))

    def start(self, values: dict[str, Any]) -> tuple[PistonState, dict[str, Any]]:
        """Load the reduced bodies and start at rest, or with the motion of the build table.

        Returns (state, outputs).
        """
        options = self.built
        self._warned = ""
        parameters = parameters_from(Parameters, values)
        kinds = [*table.own_parameters(options), *ELEMENT_PARAMETERS]
        own = [parameters_from(kind, values) for kind in kinds]
        bodies = load_bodies(self.resources, options)
        if wrong := faults(bodies, options, parameters, own):
            raise BadInput(wrong)
        self.model = model_of(bodies, options, parameters, own)
        if parameters.film_symmetry == "automatic" and self.model.odd_forces(
            stacked(self._inputs(values))
        ):
            whole = replace(parameters, film_symmetry="none")
            self.model = model_of(bodies, options, whole, own)
        if wrong := self.model.half_faults():
            raise BadInput(wrong)
        self._damping = Damping(*(values[name] for name in TUNABLE))
        try:
            state, outputs = self._begin(self.model, parameters, values)
            _, straight = self._begin(self.model.unyielding(), parameters, values)
        except MotionNotSolved as error:
            raise BadInput(f"start: {error}") from None
        gaps = self._of_films(("film_thickness",))
        self._log_bend(max(np.abs(outputs[gap] - straight[gap]).max() for gap in gaps))
        return state, outputs

    def _log_bend(self, bend: float) -> None:
        """Log the change of the gap at the start by modes without inertia [m].

        A film starts with the oil of this gap. Modes with inertia start undeformed and squeeze oil
        out.
        """
        if bend > 0.0:
            self.log(
                "Modes above quasi_static_frequency change the gap at the start by up to "
                f"{bend:.3g} m. A full film then starts with the oil of the changed gap, which "
                "affects motion and film of the first strokes.",
                Fmi2Status.warning,
            )

    def _begin(
        self, model: PistonInBore, parameters: Parameters, values: dict[str, Any]
    ) -> tuple[PistonState, dict[str, Any]]:
        """Return state and outputs at the start."""
        begin = self.built.start
        if not begin:
            return model.start(
                parameters.start_crank_angle,
                parameters.start_lateral_displacement,
                parameters.start_rocking_angle,
                self._inputs(values),
            )
        if parameters.crank_free:
            values = values | {"crank_speed": begin.rotation_speed}
        joints = model.chain.joints.tip.shape[1] - RIGID
        return model.start_moving(
            begin.crank_angle,
            begin.position(joints),
            begin.velocity(joints),
            self._inputs(values),
        )

    def advance(
        self, state: PistonState, values: dict[str, Any], time: float, step: float
    ) -> tuple[PistonState, dict[str, Any]]:
        """Take a step; returns (state, outputs)."""
        inputs = self._inputs(values)
        if (warning := self.model.warning(inputs)) not in ("", self._warned):
            self._warned = warning
            self.log(warning, Fmi2Status.warning)
        damping = Damping(*(values[name] for name in TUNABLE))
        if damping != self._damping:
            self._damping = damping
            self.model.damp(damping)
        try:
            return self.model.advance(state, inputs, step)
        except MotionNotSolved as error:
            raise Discard(str(error)) from None

    def advance_nearby(
        self, base: Any, state: PistonState, values: dict[str, Any], time: float, step: float
    ) -> tuple[PistonState, dict[str, Any]]:
        """Return what `advance` returns, by `PistonInBore.advance_nearby`."""
        try:
            return self.model.advance_nearby(state, self._inputs(values), step)
        except MotionNotSolved as error:
            raise Discard(str(error)) from None

    def directional_derivative(self, seeds: dict[str, np.ndarray]) -> dict[str, np.ndarray | float]:
        """Return the product of the step map's derivative with the seed fields."""
        pressure, friction = (self._stacked(seeds, name) for name in FORCES)
        rings = _rings(seeds)
        carried = NOT_CARRIED
        if self.built.mounted:
            carried = np.array([float(seeds[name]) for name in BLOCK])
        change = self.model.directional_derivative(
            pressure, friction, rings, carried, pins=self._pins(seeds)
        )
        if self.built.block.bore_from_outside:
            widened = self.model.widened(seeds[BORE])
            change |= {name: change[name] + opened for name, opened in widened.items()}
        return change

    def _inputs(self, values: dict[str, Any]) -> Inputs:
        pressure, friction = (self._stacked(values, name) for name in FORCES)
        skirt, bore = (float(values.get(name, REFERENCE)) for name in WALL_LEVELS.values())
        return Inputs(
            values["crank_speed"],
            values["gas_pressure"],
            pressure,
            friction,
            _rings(values),
            float(values["land_pressure"]),
            self._pins(values),
            BlockMotion(*(float(values[name]) for name in BLOCK)) if self.built.mounted else FIXED,
            np.asarray(values.get(BORE, np.zeros((0, 0)))),
            float(values["load_torque"]),
            float(values["crankcase_pressure"]),
            skirt,
            bore,
            *(self._wall_field(values, name) for name in WALL_FIELDS.values()),
        )

    def _wall_field(self, values: dict[str, Any], name: str) -> np.ndarray:
        """Return the temperature of a wall on its whole grid, empty if there is no such input."""
        ports = dict.fromkeys((name, *self._of_films((name,))))  # a single film has no prefix
        fields = [values[port] for port in ports if port in values]
        return np.concatenate([one.ravel() for one in fields]) if fields else NO_FIELD

    def _pins(self, values: dict[str, Any]) -> tuple[PinForces, ...]:
        """Return the forces of the films of a floating pin."""
        return tuple(
            PinForces(*(values[f"{film.prefix}{name}"] for name in PIN_FORCES))
            for film in self.built.pin_grids()
        )

    def _stacked(self, values: dict[str, Any], name: str) -> np.ndarray:
        """Return a field of all film surfaces, their cells one after another."""
        return np.concatenate([values[field].ravel() for field in self.force_fields[name]])


def _rings(values: dict[str, Any]) -> RingForce:
    return RingForce(*(float(values[name]) for name in RINGS))
