"""Model of the bodies: a flexible piston on its crank in a flexible bore, by implicit steps."""

from copy import copy
from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from math import prod

import numpy as np

from ..geometry.film import NodalForces
from ..geometry.pin import PinForces
from ..geometry.surfaces import each_of
from .account import account
from .block_force import by_carrier, carried_force, force_at, force_change
from .bore_from_outside import OutsideBore, deflected, film_on_bore, gas_on_wall, seen
from .build_options import FilmGrid
from .carrier import FIXED, Carrier
from .drive import End, demand_of, others_of, scalars_of
from .elimination import LUFactors, no_factors
from .generalised_alpha import Coefficients, Motion, coefficients
from .instant import Instant, end_of_step
from .piston_motion import LATERAL, RIGID, ROCKING, imbalance
from .response import Response, linearise, response, step_end
from .slider_crank import CrankMotion, driven
from .speed_table import SpeedTable, crank_motion
from .state import PistonState, crank_of, motion_of, state_at, step_coefficients
from .system import NO_RINGS, BodySystem, RingForce, StepProblem
from .tables import GasTable, gas_pressure

MOTION = ("lateral_velocity", "rocking_velocity", "piston_velocity")
"""Scalar outputs whose derivatives are known beside those of the films' fields."""

ON_BLOCK = ("force_on_block_x", "force_on_block_y", "moment_on_block")
"""Outputs of a mounted block whose derivatives are known."""

BEARINGS = ("main_bearing_force_x", "main_bearing_force_y")
"""Likewise, beside those, of one that deflects."""

ON_FLEXIBLE_BLOCK = (*BEARINGS, "force_on_bore", "force_on_deck")
"""All that are known beside those."""

NOT_CARRIED = np.zeros(len(Carrier._fields))
"""No change of the block's motion."""

START_PASSES = 40
"""Most passes to the start of a free crank; each gains a digit or more."""


class MotionNotSolved(RuntimeError):
    """The step's equations could not be solved; the message says where and how far it got."""


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
    pressure_force, friction_force : ndarray, shape (c, a), or of several surfaces (cells,)
        On the film grid, of several surfaces stacked [N].
    rings : RingForce
    land_pressure : float
        Between the rings, gauge [Pa].
    pins : tuple of PinForces
        Of the films of a floating pin.
    carrier : Carrier
        Motion of a mounted block.
    bore_deflection : ndarray, shape (n, s)
        Of a bore whose deflection comes from outside [m].
    """

    crank_speed: float
    gas_pressure: float
    pressure_force: np.ndarray
    friction_force: np.ndarray
    rings: RingForce = NO_RINGS
    land_pressure: float = 0.0
    pins: tuple[PinForces, ...] = ()
    carrier: Carrier = FIXED
    bore_deflection: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))


@dataclass(frozen=True)
class Crank:
    """Motion of the crank.

    Parameters
    ----------
    free : bool
        Driven by the forces alone, instead of at given speed.
    inertia : float
        Of crank, flywheel and what they drive [kg m2], > 0 for a free crank.
    load_torque : float
        That a free crank works against [N m].
    table : SpeedTable, optional
        Speed over time or angle, for a crank that is not free.
    """

    free: bool
    inertia: float
    load_torque: float
    table: SpeedTable | None = None

    def begin(self, angle: float, speed: float) -> CrankMotion:
        """Return the motion of the crank at time 0, from angle [rad] and input speed [rad/s]."""
        if self.table:
            return crank_motion(self.table, angle, 0.0, 0.0)
        return CrankMotion(angle, speed, 0.0)

    def turn(self, state: PistonState, step: float, speed: float) -> CrankMotion:
        """Return the motion of the crank a step [s] after a state.

        `speed` is the input at the end of the step [rad/s].

        Eq. (K8):  free, order 2 in the step:  phi + h w + h^2 w'/2 + h^3 w''/6
                   w + h w' + h^2 w''/2,  w' + h w''
        """
        if self.table:
            return crank_motion(self.table, state.crank_angle, state.time, step)
        if self.free:
            # Eq. (K8)
            before = state.crank_acceleration
            after = before + step * state.crank_jerk
            speed = state.crank_speed + step * (before + after) / 2
            mean_speed = state.crank_speed + step * (2 * before + after) / 6
            return CrankMotion(state.crank_angle + step * mean_speed, speed, after)
        return driven(crank_of(state), step, speed)


def on_skirt(pressure: np.ndarray, friction: np.ndarray) -> NodalForces:
    """Return the forces of all films of the skirt, stacked."""
    return NodalForces(np.ravel(pressure), np.ravel(friction))


class PistonInBore:
    """Flexible piston, rigid rod and crank, flexible block, and any number of films between them.

    Parameters
    ----------
    system : BodySystem
    crank : Crank
    gas_area : float
        Area of the bore [m2].
    spectral_radius : float
        Of the time integrator at infinite frequency [-], 0 to 1.
    gas_table : GasTable, optional
        Gas pressure over crank angle, added to the input.
    films : tuple of FilmGrid
        Names and shapes of the surfaces' fields, in the order of `system.surfaces`.
    crank_unbalance : float, optional
        Of a mounted block's crank [kg m]; None: the block does not move.
    outside : OutsideBore, optional
        How a bore is read whose deflection comes from outside.
    """

    def __init__(
        self,
        system: BodySystem,
        crank: Crank,
        gas_area: float,
        spectral_radius: float,
        gas_table: GasTable | None,
        films: tuple[FilmGrid, ...],
        crank_unbalance: float | None = None,
        *,
        outside: OutsideBore | None = None,
    ):
        self.system = system
        self.crank = crank
        self.gas_area = gas_area
        self.spectral_radius = spectral_radius
        self.gas_table = gas_table
        self.films = films
        ends = accumulate((prod(film.shape) for film in films), initial=0)
        self.cells = [slice(*pair) for pair in pairwise(ends)]
        self.film_surfaces = each_of(system.surfaces)
        self.crank_unbalance = crank_unbalance
        self.outside = outside
        self.moving = RIGID + len(system.piston.stiffness)  # of the piston, with inertia
        self.modes = (
            len(system.gas_force) + len(system.block.stiffness) + len(system.block_static.stiffness)
        )
        self.coordinates = RIGID + self.modes
        self.residual_evaluations = 0
        self.jacobian_evaluations = 0

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
        crank = self.crank.begin(crank_angle, inputs.crank_speed)
        at_rest = np.zeros_like(position)
        start = Motion(position, velocity, at_rest)
        now = coefficients(0.0, self.spectral_radius)
        for _ in range(START_PASSES):
            state, outputs = self._solve(now, start, at_rest, End(crank, 0.0, 0), inputs)
            # Eq. (K9) holds the piston's accelerations, which change with the crank's
            change = state.crank_acceleration - crank.acceleration
            if not self.crank.free or abs(change) <= 1e-12 * abs(state.crank_acceleration):
                break
            crank = crank._replace(acceleration=state.crank_acceleration)
        if self.outside:
            state = state._replace(bore_deflection=inputs.bore_deflection)
        return state, outputs

    def unyielding(self) -> "PistonInBore":
        """Return the same model without deformation of the modes that follow statically."""
        system = self.system
        held = [
            modes._replace(stiffness=np.full_like(modes.stiffness, np.inf))
            for modes in (system.piston_static, system.block_static)
        ]
        model = copy(self)
        piston, block = held
        model.system = system._replace(piston_static=piston, block_static=block)
        return model

    def advance(self, state: PistonState, inputs: Inputs, step: float) -> tuple[PistonState, dict]:
        """Take one step of the generalised-alpha method; the first two are backward Euler.

        The equations hold at the end of the step, with the forces at its end.

        The crank follows its table; without one it turns with constant acceleration over the step,
        which the input's change asks for; free, it goes on as its torques asked for up to the start
        of the step (Eq. (K8)).

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
        crank = self.crank.turn(state, step, inputs.crank_speed)
        if not np.isfinite(crank.angle):
            raise MotionNotSolved(f"crank angle = {crank.angle:g} rad: must be finite")
        end, outputs = self._solve(
            step_coefficients(state, step, self.spectral_radius),
            motion_of(state),
            state.auxiliary,
            End(crank, state.time + step, state.steps + 1),
            inputs,
        )
        found = account(
            (state.kinetic, end.kinetic),
            end.position - state.position,
            (state.other_forces, end.other_forces),
            outputs["energy_gain"],
        )
        outputs |= {"energy_gain": found.gain, "energy_size": found.size}
        if self.outside:
            taken = self._taken_by_bore(self.outside, state, inputs)
            outputs["energy_gain"] += taken
            outputs["film_work"] += taken
            end = end._replace(bore_deflection=inputs.bore_deflection)
        if self.crank.free:
            jerk = (end.crank_acceleration - state.crank_acceleration) / step
            end = end._replace(crank_jerk=jerk)
        return end, outputs

    def _solve(
        self, c: Coefficients, before: Motion, auxiliary: np.ndarray, at: End, inputs: Inputs
    ) -> tuple[PistonState, dict]:
        """Return state and outputs that solve the equations of motion a step after `before`.

        `auxiliary` is the auxiliary acceleration of that motion.
        """
        crank = at.crank
        pressure = inputs.gas_pressure
        if self.gas_table:
            pressure = pressure + gas_pressure(self.gas_table, crank.angle)
        others = others_of(
            self.gas_area, pressure, inputs.rings, inputs.land_pressure, inputs.carrier
        )
        now, factors = self._instant(StepProblem(c, before, auxiliary, crank, others), inputs)
        if not now.evaluations:
            raise MotionNotSolved(
                f"piston motion at crank angle {crank.angle:.6g} rad: Newton's method finds no "
                f"accelerations; their last relative change is {now.change:.3g} (nan: diverged)"
            )
        self.residual_evaluations += now.evaluations
        self.jacobian_evaluations += now.tangents
        state = state_at(now, crank, at.time, at.steps)
        self._last = step_end(c, now, crank, self.moving, factors)
        self._linear = self._columns = None
        outputs = self._outputs(now, crank) | {
            "cylinder_pressure": pressure,
            "side_force_demand": demand_of(self.system, others, crank),
        }
        if self.crank_unbalance is not None:
            outputs |= self._on_block()
        if self.outside:
            on_bore = self._film_on_bore(self.outside, inputs.pressure_force)
            outputs |= {
                "force_on_bore": on_bore + gas_on_wall(self.outside, now.guided, others.wall),
                "force_on_deck": others.gas,
            }
        if self.crank.free:
            freed = self._release(crank, outputs["crank_torque"])
            outputs["crank_torque"] = -self.crank.load_torque
            state = state._replace(crank_acceleration=freed)
        return state, outputs

    def _instant(self, step: StepProblem, inputs: Inputs) -> tuple[Instant, LUFactors]:
        """Return everything at the end of a step."""
        forces = on_skirt(inputs.pressure_force, inputs.friction_force)
        system = self.system
        if self.outside:
            system = deflected(system, self.outside, inputs.bore_deflection)
        return end_of_step(system, step, forces), no_factors()

    def _film_on_bore(self, outside: OutsideBore, pressure_force: np.ndarray) -> np.ndarray:
        """Return the forces of all films on the bore's grid at the end of the last step [N]."""
        surfaces, guided = self.film_surfaces, self._last.guided
        return film_on_bore(outside, surfaces, guided, np.ravel(pressure_force))

    def _taken_by_bore(self, outside: OutsideBore, before: PistonState, inputs: Inputs) -> float:
        """Return the energy that a bore deflected from outside took from the films in a step [J].

        Eq. (D50):  W = F_W . (w_1 - w_0),   as Eq. (D11), forces at the end along the way
        """
        way = inputs.bore_deflection - before.bore_deflection
        force = self._film_on_bore(outside, inputs.pressure_force)
        return float(np.sum(force * way))  # Eq. (D50)

    def _release(self, crank, torque):
        """Return the acceleration at which the torques on a free crank balance [rad/s2].

        Eq. (K9):  torque(w') + load_torque = 0,   torque linear in w'
        """
        inertia = self._torque(crank._replace(acceleration=crank.acceleration + 1.0))
        inertia = inertia - self._torque(crank) + self.crank.inertia
        return crank.acceleration - (torque + self.crank.load_torque) / inertia  # Eq. (K9)

    def _torque(self, crank):
        """Return the torque of the drive for a motion of the crank after the last step [N m]."""
        last, system = self._last, self.system
        return imbalance(system.piston, system.mechanism, last.load, last.now, crank).torque

    def _outputs(self, now: Instant, crank: CrankMotion) -> dict:
        """Return all outputs by name; `variables.py` has their units."""
        outputs = {
            **self._by_film("film_thickness", now.films.film_thickness),
            **self._by_film("sliding_velocity", now.films.sliding_velocity),
            **{
                f"{film.prefix}interface_work_error": error
                for film, error in zip(self.films, now.films.work_error)
            },
            **scalars_of(
                now, crank, self.crank.inertia, self.system.piston, self.system.surfaces
            )._asdict(),
            "residual_evaluations": self.residual_evaluations,
            "jacobian_evaluations": self.jacobian_evaluations,
        }
        if self.modes:
            outputs["modal_coordinate"] = now.end.position[RIGID:].copy()
            outputs["modal_velocity"] = now.kept.velocity[RIGID:].copy()
        return outputs

    def _on_block(self):
        """Return the forces on a mounted block, by output."""
        return force_at(self.system, self.crank_unbalance or 0.0, self._last)._asdict()

    def _carried_force(self, carried: np.ndarray) -> np.ndarray:
        """Return the change of the forces on the piston with the block's motion."""
        if self._columns is None:
            self._columns = by_carrier(self.system, self._last)
        return carried_force(self._columns, carried)

    def _block_force_change(self, change: Response, carried: np.ndarray) -> dict[str, float]:
        """Return the change of the forces on the block, by output."""
        names = (*ON_BLOCK, *BEARINGS) if self.outside else ON_BLOCK
        unbalance = self.crank_unbalance or 0.0
        found = force_change(self.system, unbalance, self._last, change, carried)
        return dict(zip(names, found))

    def _by_film(self, name: str, stacked: np.ndarray) -> dict[str, np.ndarray]:
        """Return a stacked field of all surfaces as one field for each, by name."""
        return {
            f"{film.prefix}{name}": stacked[cells].reshape(film.shape)
            for film, cells in zip(self.films, self.cells)
        }

    def directional_derivative(
        self,
        pressure_force: np.ndarray,
        friction_force: np.ndarray,
        rings: RingForce = NO_RINGS,
        carried: np.ndarray = NOT_CARRIED,
    ) -> dict[str, np.ndarray | float]:
        """Return the change of outputs with the forces at the end of the last step (Eq. (D7)).

        These are film, motion and the forces on a mounted block.

        Parameters
        ----------
        pressure_force, friction_force : ndarray
            Direction, as in `Inputs` [N].
        rings : RingForce
            Direction.
        carried : ndarray, shape (4,)
            Direction of a mounted block's motion, as `Carrier` has it.

        Returns
        -------
        dict of str to ndarray or float
            By output.
        """
        last = self._last
        mounted = self.crank_unbalance is not None
        if self._linear is None:
            self._linear = linearise(self.system, last)
            self.jacobian_evaluations += 1
        change = response(
            self.system,
            last.guided,
            self._linear,
            on_skirt(pressure_force, friction_force),
            rings,
            self._carried_force(carried) if mounted else np.zeros(self.moving),
        )
        on_block: dict[str, np.ndarray | float] = {}
        if mounted:
            on_block |= self._block_force_change(change, carried)
        if self.outside:
            on_block["force_on_bore"] = self._film_on_bore(self.outside, pressure_force)
            on_block["force_on_deck"] = 0.0
        return {
            **on_block,
            **self._by_film("film_thickness", change.film_thickness),
            **self._by_film("sliding_velocity", change.sliding_velocity),
            **{name: getattr(change, name) for name in MOTION},
        }

    def widened(self, bore_deflection: np.ndarray) -> dict[str, np.ndarray]:
        """Return the change of film thickness with a bore's deflection from outside, by output.

        The deflection is (n, s) [m]. At the end of the last step nothing else changes with it.
        """
        assert self.outside
        surfaces, guided = self.film_surfaces, self._last.guided
        return self._by_film(
            "film_thickness", seen(self.outside, surfaces, guided, bore_deflection)
        )
