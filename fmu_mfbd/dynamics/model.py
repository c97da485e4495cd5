"""The body side as one model: a flexible piston on its crank in a flexible bore, one implicit step
at a time.
"""

from dataclasses import dataclass, replace

import numpy as np

from .generalised_alpha import coefficients
from .instant import balance, linearise, response
from .piston_motion import imbalance
from .speed_table import SpeedTable, crank_motion
from .tables import gas_pressure


class NotConverged(RuntimeError):
    """The step's equations could not be solved; the message says where and how far it got."""


@dataclass(frozen=True)
class State:
    """Everything that a step starts from; n = 2 + piston modes + block modes.

    Parameters
    ----------
    time : float
        Since the start [s].
    crank_angle, crank_speed, crank_acceleration : float
        [rad], 0 at firing top dead centre; [rad/s]; [rad/s2].
    crank_jerk : float
        By which the acceleration of a free crank changed over the last step [rad/s3]; 0 for
        another.
    place, rate, acceleration, auxiliary : ndarray, shape (n,)
        [x_A [m], rocking angle [rad], piston then block modal coordinates [kg^1/2 m]], derivatives
        in time, and the time integrator's auxiliary acceleration.
    """

    time: float
    crank_angle: float
    crank_speed: float
    crank_acceleration: float
    crank_jerk: float
    place: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    auxiliary: np.ndarray


@dataclass(frozen=True)
class Inputs:
    """What acts at the end of a step.

    Parameters
    ----------
    crank_speed : float
        At the end of the step, linear within it [rad/s]; a free crank heeds it at the start only, a
        tabled one never.
    gas_pressure : float
        On the crown, gauge [Pa].
    pressure_force, friction_force : ndarray, shape (c, a)
        On the skirt grid [N].
    """

    crank_speed: float
    gas_pressure: float
    pressure_force: np.ndarray
    friction_force: np.ndarray


@dataclass(frozen=True)
class Crank:
    """How the crank turns.

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

    def begin(self, angle, speed):
        """Angle, speed and acceleration at time 0 [rad, rad/s, rad/s2]."""
        return crank_motion(self.table, angle, 0.0, 0.0) if self.table else (angle, speed, 0.0)

    def turn(self, state, step, speed):
        """Angle, speed and acceleration a step [s] after a state, `speed` being the input's at its
        end.

        Eq. (M3), free:  phi + h w + h^2 w'/2 + h^3 w''/6,   w + h w' + h^2 w''/2,   w' + h w''        order 2 in the step
        """
        if self.table:
            return crank_motion(self.table, state.crank_angle, state.time, step)
        if self.free:
            turn = state.crank_acceleration + step * state.crank_jerk  # Eq. (M3)
            end = state.crank_speed + step * (state.crank_acceleration + turn) / 2
            mean = state.crank_speed + step * (2 * state.crank_acceleration + turn) / 6
            return state.crank_angle + step * mean, end, turn
        turn = (speed - state.crank_speed) / step
        return state.crank_angle + step * (state.crank_speed + speed) / 2, speed, turn


class PistonInBore:
    """Flexible piston, rigid rod and crank at given speed, flexible block, and the film's geometry
    between them.

    Parameters
    ----------
    system : System
    crank : Crank
    gas_area : float
        Area of the bore [m2].
    spectral_radius : float
        Of the time integrator at infinite frequency [-], 0 to 1.
    gas_table : GasTable, optional
        Gas pressure over crank angle, added to the input.
    """

    def __init__(self, system, crank, gas_area, spectral_radius, gas_table=None):
        self.system, self.crank = system, crank
        self.gas_area, self.spectral_radius, self.gas_table = gas_area, spectral_radius, gas_table
        self.moving = 2 + len(
            system.piston.stiffness
        )  # coordinates of the piston that have inertia
        self.coordinates = 2 + system.skirt.radial.modes + system.bore.radial.modes
        self.residual_evaluations = self.jacobian_evaluations = 0

    def start(self, crank_angle, lateral, angle, inputs):
        """State at rest, undeformed, at the given place, with the accelerations that the forces of
        `inputs` ask for.

        Parameters
        ----------
        crank_angle, lateral, angle : float
            [rad], x_A [m], rocking angle [rad].
        inputs : Inputs

        Returns
        -------
        State, dict
            And its outputs.
        """
        place = np.zeros(self.coordinates)
        place[:2] = lateral, angle
        return self.start_moving(crank_angle, place, np.zeros(self.coordinates), inputs)

    def start_moving(self, crank_angle, place, rate, inputs):
        """State at a given motion, with the accelerations that the forces of `inputs` ask for.

        Parameters
        ----------
        crank_angle : float
            [rad]
        place, rate : ndarray, shape (n,)
            As in `State`.
        inputs : Inputs

        Returns
        -------
        State, dict
            And its outputs.
        """
        state, outputs = self._settle(
            coefficients(0.0, self.spectral_radius),
            (place, rate, 0 * place, 0 * place),
            0.0,
            self.crank.begin(crank_angle, inputs.crank_speed),
            inputs,
        )
        return replace(state, auxiliary=state.acceleration), outputs

    def advance(self, state, inputs, step):
        """One step of the generalised-alpha method; equations hold at its end, with the forces
        given for its end.

        The crank follows its table; without one it turns with constant acceleration over the step,
        which the input's change asks for; free, it goes on as its torques asked for up to the start
        of the step (Eq. (M3)).

        Parameters
        ----------
        state : State
        inputs : Inputs
        step : float
            [s], > 0.

        Returns
        -------
        State, dict
            The new state and the outputs at its time.

        Raises
        ------
        NotConverged
        """
        c = coefficients(step, self.spectral_radius)
        end, outputs = self._settle(
            c,
            (state.place, state.rate, state.acceleration, state.auxiliary),
            state.time + step,
            self.crank.turn(state, step, inputs.crank_speed),
            inputs,
        )
        if self.crank.free:
            end = replace(
                end, crank_jerk=(end.crank_acceleration - state.crank_acceleration) / step
            )
        return end, outputs

    def _settle(self, c, before, time, crank, inputs):
        """State and outputs whose accelerations balance the forces, a step after the motion
        `before`.
        """
        gas = self.gas_area * (
            inputs.gas_pressure
            + (gas_pressure(self.gas_table, crank[0]) if self.gas_table else 0.0)
        )
        now = balance(
            self.system, c, before, crank, gas, inputs.pressure_force, inputs.friction_force
        )
        if not now.evaluations:
            raise NotConverged(
                f"piston motion at crank angle {crank[0]:.6g} rad: relative change of "
                f"the accelerations stays at {now.size:.3g}"
            )
        self.residual_evaluations += now.evaluations
        self.jacobian_evaluations += now.tangents
        state = State(time, *crank, 0.0, now.place, now.rate, now.acceleration, now.auxiliary)
        self._last, self._linear = (c, now.load, state, crank, now.window), None
        outputs = self._outputs(now, crank)
        if self.crank.free:
            outputs["crank_torque"], freed = self._release(now.load, state, outputs["crank_torque"])
            state = replace(state, crank_acceleration=freed)
        return state, outputs

    def _release(self, load, state, torque):
        """Torque on a free crank (minus its load) and the acceleration at which its torques
        balance.

        Eq. (M2):  torque(w') + load_torque = 0,   torque linear in w'
        """
        n, crank = self.moving, (state.crank_angle, state.crank_speed)
        now = state.place[:n], state.rate[:n], state.acceleration[:n]
        turns = state.crank_acceleration + 1.0, state.crank_acceleration
        more, same = (
            imbalance(self.system.piston, self.system.mechanism, load, *now, *crank, turn)[4]
            for turn in turns
        )
        inertia = more - same + self.crank.inertia
        return -self.crank.load_torque, state.crank_acceleration - (
            torque + self.crank.load_torque
        ) / inertia  # Eq. (M2)

    def _outputs(self, now, crank):
        """Everything the outside sees (units in `variables.py`), by name."""
        outputs = {
            "film_thickness": now.film_thickness,
            "sliding_velocity": now.sliding_velocity,
            "crank_angle": crank[0],
            "rotation_speed": crank[1],
            "piston_position": now.position,
            "piston_velocity": now.velocity,
            "lateral_displacement": now.place[0],
            "rocking_angle": now.place[1],
            "lateral_velocity": now.rate[0],
            "rocking_velocity": now.rate[1],
            "side_force": -now.load.lateral,
            "crank_torque": now.torque + self.crank.inertia * crank[2],
            "pin_force_x": now.pin_x,
            "pin_force_y": now.pin_y,
            "pin_friction_moment": now.pin_moment,
            "interface_work_error": now.work_error,
            "residual_evaluations": self.residual_evaluations,
            "jacobian_evaluations": self.jacobian_evaluations,
        }
        modal = {"modal_coordinate": now.place[2:].copy(), "modal_velocity": now.rate[2:].copy()}
        return outputs | (modal if self.coordinates > 2 else {})

    def directional_derivative(self, pressure_force, friction_force):
        """Change of film thickness and sliding velocity at the end of the last step with the forces
        at its end (Eq. (D1)).

        Parameters
        ----------
        pressure_force, friction_force : ndarray, shape (c, a)
            Direction [N].

        Returns
        -------
        film_thickness, sliding_velocity : ndarray, shape (c, a)
            [m], [m/s]
        """
        c, load, state, crank, window = self._last
        if self._linear is None:
            n = self.moving
            self._linear = linearise(
                self.system,
                load,
                state.place[:n],
                state.rate[:n],
                state.acceleration[:n],
                crank,
                c.rate,
                c.place,
            )
            self.jacobian_evaluations += 1
        return response(self.system, window, c, self._linear, pressure_force, friction_force)
