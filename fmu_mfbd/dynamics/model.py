"""Model of the bodies: a flexible piston on its crank in a flexible bore, by implicit steps."""

from copy import copy
from dataclasses import dataclass, field, replace
from math import prod
from typing import Any

import numpy as np

from ...master.fmi.noted import none_yet, sentences_of
from ..geometry.film import NodalForces
from ..geometry.pin import PinForces
from ..geometry.surfaces import each_of, each_pin_of
from ..mechanism.bdf2 import STATIC
from ..mechanism.carrier import FIXED, BlockMotion
from ..mechanism.generalised_alpha import Coefficients, coefficients
from ..mechanism.piston_motion import LATERAL, ROCKING
from ..mechanism.slider_crank import CrankMotion, height
from . import nearby
from .bore_from_outside import OutsideBore, deflected, film_on_bore, gas_on_wall, opening_changes
from .build_options import BuildOptions, FilmGrid
from .contradictions import FAULTS
from .half_films import check_even, check_half, is_half
from .instant import Instant, of_bearings, slides_at
from .parameters import REFERENCE, Damping
from .pin_outputs import PIN_NAMES
from .response import Response, StepInputs
from .state import PistonState, problem_of, step_coefficients
from .step import (
    START_PASSES,
    BodyModel,
    StepResult,
    at_rest,
    coordinates_of,
    crank_after,
    crank_at_start,
    instant_of,
    is_started,
    modes_of,
    others_at,
    response_to,
    result_of,
    set_damping,
    warning_of,
)
from .system import NO_RINGS, RingForce, StepProblem
from .thermal_growth import FieldInputs, warm_walls

MOTION = ("lateral_velocity", "rocking_velocity", "piston_velocity")
"""Scalar outputs with derivatives, in addition to the fields of films."""

ON_BLOCK = ("force_on_block_x", "force_on_block_y", "moment_on_block")
"""Outputs with derivatives if the block is mounted."""

BEARINGS = ("main_bearing_force_x", "main_bearing_force_y")
"""Forces of the main bearing on the block."""

ON_FLEXIBLE_BLOCK = (*BEARINGS, "force_on_bore", "force_on_deck")
"""Further outputs with derivatives if the mounted block deflects."""

OIL = "oil_temperature"
"""Output field of a film whose walls have temperatures. Forces do not change it."""

NO_FIELD = np.zeros(0)
"""Temperature of a wall without a field input."""

LOCKED_STIFFNESS = 1e30
"""Factor of the stiffness of quasi-static modes that locks them."""

NOT_CARRIED = np.zeros(len(BlockMotion._fields))
"""No change of the block's motion."""


class MotionNotSolved(RuntimeError):
    """The equations of a step were not solved. The message states time, residual and position."""


@dataclass(frozen=True)
class Inputs:
    """Inputs at the end of a step.

    Parameters
    ----------
    crank_speed : float
        At the end of the step, linear within it [rad/s]; a free crank heeds it at the start only, a
        tabled one never.
    gas_pressure : float
        On the crown, gauge [Pa].
    load_torque : float
        On a free crank [N m].
    crankcase_pressure : float
        Below the piston, gauge [Pa].
    pressure_force, friction_force : ndarray, shape (c, a), or of several surfaces (cells,)
        On the film grid, of several surfaces stacked [N].
    rings : RingForce
    land_pressure : float
        Between the rings, gauge [Pa].
    pins : tuple of PinForces
        Forces of the films of a floating pin.
    carrier : BlockMotion
        Motion of a mounted block.
    bore_deflection : ndarray, shape (n, s)
        Radial deflection of the bore if another participant gives it [m].
    piston_temperature, bore_temperature : float
        [K]
    skirt_field, bore_field : ndarray
        Temperatures of the walls that have a field input, as of `FieldInputs` [K].
    """

    crank_speed: float
    gas_pressure: float
    pressure_force: np.ndarray
    friction_force: np.ndarray
    rings: RingForce = NO_RINGS
    land_pressure: float = 0.0
    pins: tuple[PinForces, ...] = ()
    carrier: BlockMotion = FIXED
    bore_deflection: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))
    load_torque: float = 0.0
    crankcase_pressure: float = 0.0
    piston_temperature: float = REFERENCE
    bore_temperature: float = REFERENCE
    skirt_field: np.ndarray = field(default_factory=lambda: NO_FIELD)
    bore_field: np.ndarray = field(default_factory=lambda: NO_FIELD)


class PistonInBore:
    """Flexible piston, rod and crank, flexible block, and all films between them.

    The pin floats if it has films.

    Parameters
    ----------
    model : BodyModel
    options : BuildOptions
        Names and shapes of the films' fields, and absent outputs.
    outside : OutsideBore, optional
        Interpolation of a bore deflection that another participant gives.
    """

    IN_SPACE = False
    """Whether the piston also moves across the plane of the crank."""

    def __init__(self, model: BodyModel, options: BuildOptions, outside: OutsideBore | None = None):
        self.model = model
        self.films = options.film_grids()
        self.grids = options.pin_grids()
        self.absent = options.absent_parts()
        self.slides = options.slides
        self.outside = outside
        self.system = system = model.parts
        self.film_surfaces = each_of(system.surfaces)
        self.has_half_films = is_half(self.film_surfaces[0])
        self.is_warm = bool(options.temperatures)
        self.pins = each_pin_of(system.pin_surfaces)
        self.chain = system.chain
        self.coordinates = coordinates_of(model)
        self.residual_evaluations = 0
        self.jacobian_evaluations = 0

    def damp(self, damping: Damping) -> None:
        """Set the damping of all modes, from the next step on."""
        set_damping(self.model, damping)

    def start(
        self, crank_angle: float, lateral: float, angle: float, inputs: Inputs
    ) -> tuple[PistonState, dict]:
        """Return the state at rest, undeformed, at a given position.

        Its accelerations follow from the forces of `inputs`.

        Parameters
        ----------
        crank_angle, lateral, angle : float
            [rad], x_A [m], rocking angle [rad].
        inputs : Inputs

        Returns
        -------
        PistonState, dict
            And its outputs.
        """
        position = np.zeros(self.coordinates)
        position[LATERAL] = lateral
        position[ROCKING] = angle
        return self.start_moving(crank_angle, position, np.zeros(self.coordinates), inputs)

    def start_moving(
        self, crank_angle: float, position: np.ndarray, velocity: np.ndarray, inputs: Inputs
    ) -> tuple[PistonState, dict]:
        """Return the state at a given motion; accelerations follow from the forces of `inputs`.

        Parameters
        ----------
        crank_angle : float
            [rad]
        position, velocity : ndarray, shape (n,)
            As in `PistonState`.
        inputs : Inputs

        Returns
        -------
        PistonState, dict
            And its outputs.
        """
        settings = self.model.settings
        crank = crank_at_start(self.model, crank_angle, inputs.crank_speed)
        now = coefficients(0.0, settings.spectral_radius)
        for _ in range(START_PASSES):
            before = at_rest(crank, position, velocity)
            state, outputs = self._solve(now, before, crank, 0.0, inputs)
            if is_started(settings, crank, state):
                break
            crank = crank._replace(acceleration=state.crank_acceleration)
        if self.outside:
            state = state._replace(bore_deflection=inputs.bore_deflection)
        return state, outputs

    def unyielding(self) -> "PistonInBore":
        """Return the same model without deformation of the modes that follow statically."""
        chain = self.chain
        static = self.system.kinds[chain.joints.tip.shape[1] :] == STATIC
        stiffness = np.where(static, LOCKED_STIFFNESS, 1.0) * chain.bodies.stiffness
        stiff = chain._replace(bodies=chain.bodies._replace(stiffness=stiffness))
        model = copy(self)
        model.model = self.model._replace(parts=self.system._replace(chain=stiff))
        return model

    def advance(self, state: PistonState, inputs: Inputs, step: float) -> tuple[PistonState, dict]:
        """Take one step of the generalised-alpha method; the first two are backward Euler.

        The equations hold at the end of the step, with the forces at its end.

        Parameters
        ----------
        state : PistonState
        inputs : Inputs
        step : float
            [s], > 0.

        Returns
        -------
        PistonState, dict
            The new state and the outputs at its time.

        Raises
        ------
        MotionNotSolved
        """
        crank = crank_after(self.model, state, step, inputs.crank_speed)
        if not np.isfinite(crank.angle):
            raise MotionNotSolved(f"crank angle = {crank.angle:g} rad: must be finite")
        c = step_coefficients(state, step, self.model.settings.spectral_radius)
        end, outputs = self._solve(c, state, crank, state.time + step, inputs)
        if self.outside:
            taken = self._taken_by_bore(self.outside, state, inputs) / step
            outputs["received_power"] += taken
            outputs["film_power"] += taken
            end = end._replace(bore_deflection=inputs.bore_deflection)
        return end, outputs

    def advance_nearby(
        self, state: PistonState, inputs: Inputs, step: float
    ) -> tuple[PistonState, dict]:
        """Return what `advance` returns, by one kernel, without a derivative of the step."""
        if self.outside or self.is_warm or self.IN_SPACE:
            return self.advance(state, inputs, step)
        result = nearby.advance.dispatcher(self.model, state, stacked(inputs), step)
        if not result.instant.evaluations:
            raise MotionNotSolved("the motion next to that of a step was not solved")
        return result.state, self._outputs(result)

    def _solve(
        self,
        c: Coefficients,
        before: PistonState,
        crank: CrankMotion,
        time: float,
        inputs: Inputs,
    ) -> tuple[PistonState, dict]:
        """Return state and outputs that solve the equations of motion a step after `before`."""
        self._reject_unused(inputs)
        step_inputs = stacked(inputs)
        model = self.model
        if len(step_inputs.fields.skirt) or len(step_inputs.fields.bore):
            walls = self.system.surfaces, model.cold, model.radii, model.settings
            warm_walls(*walls, step_inputs.fields)
        others = others_at(self.model, step_inputs, crank)
        step = problem_of(c, before, crank, others)
        now = self._instant(step, step_inputs, inputs)
        if not now.evaluations:
            raise MotionNotSolved(
                f"piston motion at crank angle {crank.angle:.6g} rad: Newton's method finds no "
                f"accelerations; their last relative change is {now.change:.3g} (nan: diverged)"
            )
        if odd := self.odd_forces(step_inputs):
            raise MotionNotSolved("; ".join(odd))
        self.residual_evaluations += now.evaluations
        self.jacobian_evaluations += now.tangents
        result = result_of(self.model, before, step, time, now, step_inputs)
        self._last, self._pressure = result.last, step_inputs.skirt.pressure
        outputs = self._outputs(result)
        if self.outside:
            on_bore = self._film_on_bore(self.outside, inputs.pressure_force)
            outputs |= {
                "force_on_bore": on_bore + gas_on_wall(self.outside, now.guide_height, others.wall),
                "force_on_deck": others.gas,
            }
        return result.state, outputs

    def warning(self, inputs: Inputs) -> str:
        """Return the warning about inputs that add up or have no effect, empty without one."""
        number = warning_of(self.model, stacked(inputs))
        return FAULTS[int(number)] if number >= 0.0 else ""

    def half_faults(self) -> list[str]:
        """Return the fault that one half of the films is demanded, and that they are whole."""
        noted = none_yet()
        check_half(self.system.surfaces, self.model.settings, noted)
        return sentences_of(noted, FAULTS)

    def odd_forces(self, inputs: StepInputs) -> list[str]:
        """Return faults of forces on half films that are not their own mirror image."""
        if not self.has_half_films:
            return []
        noted = none_yet()
        check_even(self.system.surfaces, inputs.skirt, noted)
        return sentences_of(noted, FAULTS)

    def _reject_unused(self, inputs: Inputs) -> None:
        """Raise ValueError for inputs that this mechanism would ignore."""
        faults = []
        if inputs.carrier != FIXED and self.IN_SPACE:
            got = inputs.carrier
            faults.append(f"carrier: expected a fixed block with motion in space, got {got}")
        if len(inputs.pins) != len(self.pins):
            faults.append(f"pins: expected {len(self.pins)} films, got {len(inputs.pins)}")
        if inputs.bore_deflection.any() and not self.outside:
            faults.append("bore_deflection: expected none without bore_from_outside, got a field")
        if faults:
            raise ValueError("\n".join(faults))

    def _instant(self, step: StepProblem, step_inputs: StepInputs, inputs: Inputs) -> Instant:
        """Return everything at the end of a step."""
        self._deflected = self.model
        if self.outside:
            wider = deflected(self.system, self.outside, inputs.bore_deflection)
            self._deflected = self.model._replace(parts=wider)
        return instant_of(self._deflected, step, step_inputs)

    def _film_on_bore(self, outside: OutsideBore, pressure_force: np.ndarray) -> np.ndarray:
        """Return the forces of all films on the bore's grid at the end of the last step [N]."""
        surfaces, guide_height = self.film_surfaces, self._last.guide_height
        return film_on_bore(outside, surfaces, guide_height, np.ravel(pressure_force))

    def _taken_by_bore(self, outside: OutsideBore, before: PistonState, inputs: Inputs) -> float:
        """Return the energy that a bore deflected from outside took from the films in a step [J].

        Eq. (D50):  W = F_W . (w_1 - w_0),   as Eq. (D11), forces at the end along the way
        """
        travel = inputs.bore_deflection - before.bore_deflection
        force = self._film_on_bore(outside, inputs.pressure_force)
        return float(np.sum(force * travel))  # Eq. (D50)

    def _outputs(self, result: StepResult) -> dict[str, Any]:
        """Return all outputs by name; `variables.py` has their units."""
        now = result.instant
        first, last = modes_of(self.model)
        errors = zip((*self.films, *self.grids), (*now.films.work_error, *now.pin_work_error))
        outputs = {
            **by_film(self.films, "film_thickness", now.films.film_thickness),
            **by_film(self.films, "sliding_velocity", now.films.sliding_velocity),
            **(by_film(self.films, OIL, result.oil_temperature) if self.is_warm else {}),
            **by_film(self.grids, "film_thickness", now.pin_film_thickness),
            **by_film(self.grids, "circumferential_velocity", now.circumferential_velocity),
            **{f"{one.prefix}sliding_velocity": np.zeros(one.shape) for one in self.grids},
            **{f"{one.prefix}interface_work_error": float(error) for one, error in errors},
            **result.scalars._asdict(),
            **now.on_block._asdict(),
            "residual_evaluations": self.residual_evaluations,
            "jacobian_evaluations": self.jacobian_evaluations,
        }
        if last > first:
            outputs["modal_coordinate"] = now.end.position[first:last].copy()
            outputs["modal_velocity"] = now.next_start.velocity[first:last].copy()
        outputs |= zip(self.slides, slides_at(self.system, now.end.position, len(self.slides)))
        if self.pins or self.slides:
            outputs["bearing_coordinate"] = of_bearings(self.system, now.end.position)
            outputs["bearing_velocity"] = of_bearings(self.system, now.next_start.velocity)
        of_pin = zip(PIN_NAMES, now.pin_scalars.tolist()) if self.pins else ()
        return outputs | {k: v for k, v in of_pin if not k.startswith(self.absent)}

    def directional_derivative(
        self,
        pressure_force: np.ndarray,
        friction_force: np.ndarray,
        rings: RingForce = NO_RINGS,
        carried: np.ndarray = NOT_CARRIED,
        *,
        pins: tuple[PinForces, ...] = (),
    ) -> dict[str, np.ndarray | float]:
        """Return the change of outputs with the forces at the end of the last step.

        These are films, motion and the forces on a mounted block (Eq. (D23)).

        Parameters
        ----------
        pressure_force, friction_force : ndarray
            Direction, as in `Inputs` [N].
        rings : RingForce
            Direction.
        carried : ndarray, shape (4,)
            Direction of a mounted block's motion, as `BlockMotion` has it.
        pins : tuple of PinForces
            Directions, of all films of the pin [N].

        Returns
        -------
        dict of str to ndarray or float
            By output.
        """
        seed_inputs = Inputs(0.0, 0.0, pressure_force, friction_force, rings, pins=pins)
        self._reject_unused(replace(seed_inputs, carrier=BlockMotion(*carried)))
        seeds = stacked(seed_inputs)
        change = self._response(seeds, carried)
        products = {
            **by_film(self.films, "film_thickness", change.film_thickness),
            **by_film(self.films, "sliding_velocity", change.sliding_velocity),
            **{name: getattr(change, name) for name in MOTION},
            **by_film(self.grids, "film_thickness", change.pin_film_thickness),
            **by_film(self.grids, "circumferential_velocity", change.circumferential_velocity),
        }
        if self.is_warm:
            products |= {f"{one.prefix}{OIL}": np.zeros(one.shape) for one in self.films}
        if self.model.mounted:
            names = (*ON_BLOCK, *BEARINGS) if self.outside else ON_BLOCK
            products |= {name: getattr(change.on_block, name) for name in names}
        if self.outside:
            products["force_on_bore"] = self._film_on_bore(self.outside, pressure_force)
            products["force_on_deck"] = 0.0
        return products

    def _response(self, seeds: StepInputs, carried: np.ndarray) -> Response:
        """Return the change of films and motion with forces and the block's motion (4,)."""
        return response_to(self._deflected, self._last, seeds, carried)

    def widened(self, bore_deflection: np.ndarray) -> dict[str, np.ndarray]:
        """Return the change of outputs with a bore's deflection from outside, by output.

        The deflection is (n, s) [m]. At the end of the last step it changes film thickness, and the
        moment on the block and the force of the main bearing by slopes of the bore (Eq. (D70)).
        """
        assert self.outside
        surfaces, last = self.film_surfaces, self._last
        wider, slopes = opening_changes(self.outside, surfaces, last.guide_height, bore_deflection)
        change: dict[str, Any] = by_film(self.films, "film_thickness", wider)
        if self.model.mounted:
            lever = height(self.system.mechanism, 0.0, last.crank.angle).lever
            pushed = float(self._pressure @ slopes)
            change["moment_on_block"] = -lever * pushed  # Eq. (D70)
            change["main_bearing_force_y"] = pushed
        return change


def by_film(grids: tuple[FilmGrid, ...], name: str, stacked: np.ndarray) -> dict[str, np.ndarray]:
    """Return a stacked field of all films as one field for each, by name."""
    fields = {}
    first = 0
    for grid in grids:
        last = first + prod(grid.shape)
        fields[f"{grid.prefix}{name}"] = stacked[first:last].reshape(grid.shape)
        first = last
    return fields


def stacked(inputs: Inputs) -> StepInputs:
    """Return inputs for kernels, their films one after another."""
    none = [np.zeros(0)] * len(PinForces._fields)
    fields = ([np.ravel(one) for one in field] for field in zip(*inputs.pins))
    return StepInputs(
        crank_speed=inputs.crank_speed,
        load_torque=inputs.load_torque,
        gas_pressure=inputs.gas_pressure,
        crankcase_pressure=inputs.crankcase_pressure,
        land_pressure=inputs.land_pressure,
        skirt=NodalForces(np.ravel(inputs.pressure_force), np.ravel(inputs.friction_force)),
        pins=PinForces(*map(np.concatenate, fields)) if inputs.pins else PinForces(*none),
        rings=inputs.rings,
        carrier=inputs.carrier,
        piston_temperature=inputs.piston_temperature,
        bore_temperature=inputs.bore_temperature,
        fields=FieldInputs(np.ravel(inputs.skirt_field), np.ravel(inputs.bore_field)),
    )
