"""Model of a piston whose pin floats, based on `model.PistonInBore`.

It has the films of the pin in both bosses and in the rod's eye, which may be flexible, and those of
the crank. The pin is rigid, or it tilts and bends. Crank, block and the rest of the rod are rigid.
"""

from typing import Any

import numpy as np

from ..geometry.pin import PinForces, PinSurface
from ..geometry.pin_shapes import STRAIGHT, AxisShapes
from ..geometry.surfaces import pins_in_block
from .build_options import FilmGrid
from .elimination import LUFactors
from .instant import Instant
from .modal_damping import ModalSprings
from .model import MOTION, Inputs, PistonInBore, on_skirt
from .pin_coordinates import RIGID_CRANK, RIGID_EYE, Crankshaft, PinBodies, layout, of_eye, of_modes
from .pin_films import PinSystem
from .pin_inertia import inertia, inertia_with_rod
from .pin_instant import end_of_pin_step
from .pin_response import respond_pin
from .slider_crank import CrankMotion
from .system import NO_RINGS, RingForce, StepProblem


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
    absent : tuple of str
        `BuildOptions.absent_parts`, which have no outputs.
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
        *,
        absent: tuple[str, ...] = (),
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
        self.absent = absent

    def _instant(self, step: StepProblem, inputs: Inputs) -> tuple[Instant, LUFactors]:
        """Return everything at the end of a step."""
        skirt = on_skirt(inputs.pressure_force, inputs.friction_force)
        found = self._step = end_of_pin_step(self.floating, step, skirt, stacked(inputs.pins))
        return found.now, found.factors

    def _outputs(self, now: Instant, crank: CrankMotion) -> dict[str, Any]:
        """Return the outputs of the tied pin and those of the floating pin."""
        outputs = super()._outputs(now, crank)
        step = self._step
        for grid, error in zip(self.grids, step.work_error):
            outputs[f"{grid.prefix}sliding_velocity"] = np.zeros(grid.shape)
            outputs[f"{grid.prefix}interface_work_error"] = float(error)
        outputs |= self._by_pin("film_thickness", step.film_thickness)
        outputs |= self._by_pin("circumferential_velocity", step.circumferential_velocity)
        if self.modes:
            outputs["modal_coordinate"] = of_modes(self.layout, now.end.position).copy()
            outputs["modal_velocity"] = of_modes(self.layout, now.kept.velocity).copy()
        if len(self.bodies.eye.stiffness):
            outputs["small_end_modal_coordinate"] = of_eye(self.layout, now.end.position).copy()
            outputs["small_end_modal_velocity"] = of_eye(self.layout, now.kept.velocity).copy()
        scalars = step.scalars._asdict().items()
        return outputs | {
            name: value for name, value in scalars if not name.startswith(self.absent)
        }

    def _by_pin(self, name: str, stacked: np.ndarray) -> dict[str, np.ndarray]:
        """Return a stacked field of all films of pin and crank as one field for each, by name."""
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
        """Return the change of outputs with the forces at the end of the last step (Eq. (D23)).

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
    """Return the forces of all films of pin and crank, their cells one after another."""
    return PinForces(*(np.concatenate([np.ravel(one) for one in field]) for field in zip(*pins)))
