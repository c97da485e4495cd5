"""A piston whose pin floats: the model of `model.PistonInBore` with the films of the pin in both
bosses and in the rod's eye, which may yield, and those of the crank in rod and block where it has
any. The pin is rigid or tilts and bends; crank, block and what else there is of the rod are rigid.
"""

from typing import Any, NamedTuple

import numpy as np

from ..geometry.pin import PinForces, PinSurface
from ..geometry.pin_shapes import STRAIGHT, AxisShapes
from ..geometry.surfaces import pins_in_block
from .build_options import FilmGrid
from .elimination import LUFactors
from .generalised_alpha import Motion
from .instant import Instant
from .modal_damping import ModalSprings
from .model import MOTION, Inputs, PistonInBore, on_skirt
from .pin_coordinates import RIGID_CRANK, RIGID_EYE, Crankshaft, PinBodies, layout, of_eye, of_modes
from .pin_films import PinSystem
from .pin_inertia import inertia, inertia_with_rod
from .pin_instant import PinInstant, end_of_pin_step
from .pin_response import respond_pin
from .pin_shells import Shell, shell_of
from .slider_crank import CrankMotion
from .system import NO_RINGS, RingForce, StepProblem

TOLD_BY = {
    "pin_tilt": "shapes",
    "pin_bending": "shapes",
    "small_end_widening": "eye",
    "big_end": "big_end",
    "main_bearing": "main_bearing",
}
"""How names of `PinScalars` begin that not every pin tells, and what tells them."""


class PinEnd(NamedTuple):
    """The end of the last step: where it left everything, what acted there (stacked [N]), and the
    shells of every film of pin and crank.
    """

    step: PinInstant
    forces: PinForces
    end: Motion
    shells: tuple[Shell, ...]


class PistonOnFloatingPin(PistonInBore):
    """Piston, floating pin and rod, and the geometry of the films between them and in the bore.

    Parameters
    ----------
    tied : PistonInBore
        The same without a pin of its own, no mode of it static, the block rigid.
    pins : tuple of PinSurface
        In both bosses and in the rod's eye, then those of the crank; the bosses with the piston's
        modes, if it has any, the eye with its own.
    grids : tuple of FilmGrid
        Names and shapes of their fields.
    spin_inertia : float
        Of the pin about its axis [kg m2].
    shapes : AxisShapes
        In which it tilts and bends; `pins` have their values.
    eye : ModalSprings
        Those of the rod's eye.
    crank : Crankshaft
        What of it has films.
    """

    def __init__(
        self,
        tied: PistonInBore,
        pins: tuple[PinSurface, ...],
        grids: tuple[FilmGrid, ...],
        spin_inertia: float,
        shapes: AxisShapes = STRAIGHT,
        eye: ModalSprings = RIGID_EYE,
        crank: Crankshaft = RIGID_CRANK,
    ):
        vars(self).update(vars(tied))
        mechanism = self.system.mechanism
        self.bodies = PinBodies(self.system.piston, mechanism, spin_inertia, shapes, eye, crank)
        self.layout = layout(self.bodies)
        self.coordinates = self.moving = self.layout.size
        self.inertia = inertia(self.bodies)
        with_rod = inertia_with_rod(self.bodies)
        block = pins_in_block(pins)
        self.floating = PinSystem(self.system, self.bodies, block, self.inertia, with_rod)
        self.pins = pins
        self.grids = grids
        there = {"shapes": len(shapes.mass), "eye": len(eye.stiffness)} | crank._asdict()
        self.left_out = tuple(name for name, what in TOLD_BY.items() if not there[what])

    def _instant(self, step: StepProblem, inputs: Inputs) -> tuple[Instant, LUFactors]:
        """Everything at the end of a step."""
        skirt = on_skirt(inputs.pressure_force, inputs.friction_force)
        forces = stacked(inputs.pins)
        found = end_of_pin_step(self.floating, step, skirt, forces)
        self._step = found, forces
        return found.now, found.factors

    @property
    def _pin(self) -> PinEnd:
        """The end of the last step."""
        step, forces = self._step
        end, crank = self._last.now, self._last.crank
        mechanism = self.bodies.mechanism
        each = range(len(self.pins))
        shells = (shell_of(mechanism, self.layout, end, crank, k) for k in each)
        return PinEnd(step, forces, end, tuple(shells))

    def _outputs(self, now: Instant, crank: CrankMotion) -> dict[str, Any]:
        """Those of the tied pin, and the pin's own."""
        outputs = super()._outputs(now, crank)
        step, _ = self._step
        for grid, error in zip(self.grids, step.work_error):
            outputs[f"{grid.prefix}sliding_velocity"] = np.zeros(grid.shape)
            outputs[f"{grid.prefix}interface_work_error"] = float(error)
        outputs |= self._by_pin("film_thickness", step.film_thickness)
        outputs |= self._by_pin("circumferential_velocity", step.circumferential_velocity)
        if self.modes:
            outputs["modal_coordinate"] = of_modes(self.layout, now.position).copy()
            outputs["modal_velocity"] = of_modes(self.layout, now.kept_velocity).copy()
        if len(self.bodies.eye.stiffness):
            outputs["small_end_modal_coordinate"] = of_eye(self.layout, now.position).copy()
            outputs["small_end_modal_velocity"] = of_eye(self.layout, now.kept_velocity).copy()
        scalars = step.scalars._asdict().items()
        return outputs | {
            name: value for name, value in scalars if not name.startswith(self.left_out)
        }

    def _by_pin(self, name: str, stacked: np.ndarray) -> dict[str, np.ndarray]:
        """A stacked field of all films of pin and crank as one of each, by name."""
        fields = {}
        first = 0
        for grid in self.grids:
            last = first + np.prod(grid.shape)
            fields[f"{grid.prefix}{name}"] = stacked[first:last].reshape(grid.shape)
            first = last
        return fields

    def directional_derivative(
        self,
        pressure_force: np.ndarray,
        friction_force: np.ndarray,
        rings: RingForce = NO_RINGS,
        pins: tuple[PinForces, ...] = (),
    ) -> dict[str, np.ndarray | float]:
        """Change of films and motion at the end of the last step with the forces at its end
        (Eq. (D23)).

        Parameters
        ----------
        pressure_force, friction_force, rings
            As of the tied pin.
        pins : tuple of PinForces
            Directions, of all films of the pin [N].
        """
        found = respond_pin(
            self.floating,
            self._last,
            on_skirt(pressure_force, friction_force),
            rings,
            stacked(pins),
        )
        change = found.change
        return {
            **self._by_film("film_thickness", change.film_thickness),
            **self._by_film("sliding_velocity", change.sliding_velocity),
            **{name: getattr(change, name) for name in MOTION},
            **self._by_pin("film_thickness", found.film_thickness),
            **self._by_pin("circumferential_velocity", found.circumferential_velocity),
        }


def stacked(pins: tuple[PinForces, ...]) -> PinForces:
    """Forces of all films of pin and crank, their cells one after another."""
    return PinForces(*(np.concatenate([np.ravel(one) for one in field]) for field in zip(*pins)))
