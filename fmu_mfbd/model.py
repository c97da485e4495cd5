"""The body side as one model: a flexible piston on its crank in a flexible bore, one implicit step at a time."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

from .film import film_now, generalised, opening, sliding, window_at
from .generalised_alpha import coefficients, predict
from .piston_motion import Load, imbalance, settle, tangent
from .slider_crank import height, motion
from .tables import gas_pressure


class NotConverged(RuntimeError):
    """The step's equations could not be solved; the message says where and how far it got."""


@dataclass(frozen=True)
class State:
    """Everything that a step starts from; n = 2 + piston modes + block modes.

    Parameters
    ----------
    crank_angle, crank_speed, crank_acceleration : float
        [rad], 0 at firing top dead centre; [rad/s]; [rad/s2].
    place, rate, acceleration, auxiliary : ndarray, shape (n,)
        [x_A [m], rocking angle [rad], piston then block modal coordinates [kg^1/2 m]], derivatives in time, and the
        time integrator's auxiliary acceleration.
    """

    crank_angle: float
    crank_speed: float
    crank_acceleration: float
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
        At the end of the step, linear within it [rad/s]; a free crank heeds it at the start only.
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
    """

    free: bool
    inertia: float
    load_torque: float


@dataclass(frozen=True)
class Block:
    """Modal springs of the cylinder block: stiffness omega^2 [rad2/s2] and damping 2 zeta omega [rad/s], shapes (k',)."""

    stiffness: np.ndarray
    damping: np.ndarray


class PistonInBore:
    """Flexible piston, rigid rod and crank at given speed, flexible block, and the film's geometry between them.

    Parameters
    ----------
    piston : FlexibleBody
    block : Block
    mechanism : Mechanism
    crank : Crank
    skirt : Skirt
    bore : Bore
    gas_area : float
        Area of the bore [m2].
    gas_force : ndarray, shape (k,)
        Modal force of a unit gas force (-y) on the crown [kg^-1/2].
    spectral_radius : float
        Of the time integrator at infinite frequency [-], 0 to 1.
    gas_table : dict, optional
        Gas pressure over crank angle (`tables.gas_table`), added to the input.
    """

    def __init__(self, piston, block, mechanism, crank, skirt, bore, gas_area, gas_force, spectral_radius, gas_table=None):
        self.piston, self.block, self.mechanism, self.crank, self.skirt, self.bore = piston, block, mechanism, crank, skirt, bore
        self.gas_area, self.gas_force, self.spectral_radius, self.gas_table = gas_area, gas_force, spectral_radius, gas_table
        self.flexible = slice(2, 2 + len(piston.stiffness))
        self.coordinates = 2 + len(piston.stiffness) + len(block.stiffness)
        self.residual_evaluations = self.jacobian_evaluations = 0

    def start(self, crank_angle, lateral, angle, inputs):
        """State at rest, undeformed, at the given place, with the accelerations that the forces of `inputs` ask for.

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
        nothing = np.zeros(self.coordinates)
        place = nothing.copy()
        place[:2] = lateral, angle
        return self._settle(coefficients(0.0, self.spectral_radius), place, nothing, nothing, nothing, 1.0,
                            (crank_angle, inputs.crank_speed, 0.0), inputs)

    def advance(self, state, inputs, step):
        """One step of the generalised-alpha method; equations hold at its end, with the forces given for its end.

        The crank turns with constant acceleration over the step: what the input's change asks for, or, free, what its torques ask for at
        the start of the step (order 1 in the step, for this slow motion alone).

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
        place, rate, auxiliary = predict(c, state.place, state.rate, state.acceleration, state.auxiliary)
        weight = (1 - c.alpha_f) / (1 - c.alpha_m)
        turn = state.crank_acceleration if self.crank.free else (inputs.crank_speed - state.crank_speed) / step
        speed = state.crank_speed + step * turn if self.crank.free else inputs.crank_speed
        crank = state.crank_angle + step * (state.crank_speed + speed) / 2, speed, turn
        return self._settle(c, place, rate, state.acceleration, auxiliary, weight, crank, inputs)

    def _settle(self, c, place, rate, guess, auxiliary, weight, crank, inputs):
        """State and outputs whose accelerations balance the forces; places and rates come predicted without these accelerations."""
        crank_angle, crank_speed, _ = crank
        window = window_at(self.bore.lowest, self.bore.spacing, height(self.mechanism, 0.0, crank_angle)[0] + self.skirt.height)
        forces = generalised(self.skirt, self.bore, window, inputs.pressure_force, inputs.friction_force)
        gas = self.gas_area * (inputs.gas_pressure + (gas_pressure(self.gas_table, crank_angle) if self.gas_table else 0.0))
        load = Load(forces.lateral, forces.axial - gas, forces.moment + self.skirt.pin_offset * gas, forces.piston + gas * self.gas_force)
        n = self.flexible.stop
        acceleration = np.empty(self.coordinates)
        acceleration[:n], pin_x, pin_y, torque, evaluations, size = settle(
            self.piston, self.mechanism, load, place[:n], rate[:n], guess[:n], *crank, c.rate, c.place)
        if not evaluations:
            raise NotConverged(f"piston motion at crank angle {crank_angle:.6g} rad: relative change of the accelerations stays at {size:.3g}")
        self.residual_evaluations += evaluations
        self.jacobian_evaluations += 1
        acceleration[n:] = ((forces.block - self.block.damping * rate[n:] - self.block.stiffness * place[n:])
                            / (1 + c.rate * self.block.damping + c.place * self.block.stiffness))
        state = State(*crank, place + c.place * acceleration, rate + c.rate * acceleration, acceleration, auxiliary + weight * acceleration)
        self._last, self._factor = (c, load, state, crank, window), None
        outputs = self._outputs(state, inputs, window, forces, (pin_x, pin_y), torque)
        if self.crank.free:
            outputs["crank_torque"], freed = self._release(load, state, outputs["crank_torque"])
            state = replace(state, crank_acceleration=freed)
        return state, outputs

    def _release(self, load, state, torque):
        """Torque on a free crank (minus its load) and the acceleration at which its torques balance.

        Eq. (M2):  torque(w') + load_torque = 0,   torque linear in w'
        """
        n, crank = self.flexible.stop, (state.crank_angle, state.crank_speed)
        motion_now = state.place[:n], state.rate[:n], state.acceleration[:n]
        one, none = (imbalance(self.piston, self.mechanism, load, *motion_now, *crank, turn)[3] for turn in (1.0, 0.0))
        inertia = one - none + self.crank.inertia
        return -self.crank.load_torque, state.crank_acceleration - (torque + self.crank.load_torque) / inertia    # Eq. (M2)

    def _outputs(self, state, inputs, window, forces, pin, torque):
        """Everything the outside sees (units in `variables.py`), by name."""
        n = self.flexible.stop
        Y, slope, lever = height(self.mechanism, state.place[0], state.crank_angle)
        climb = slope * state.rate[0] + lever * state.crank_speed
        guided = height(self.mechanism, 0.0, state.crank_angle)[2]
        thickness, velocity, lift, power, size = film_now(
            self.skirt, self.bore, window, (inputs.pressure_force, inputs.friction_force), climb, guided * state.crank_speed,
            state.place, state.rate)
        own = np.concatenate([[forces.lateral * state.rate[0], forces.axial * climb, forces.moment * state.rate[1],
                               lift * guided * state.crank_speed], forces.piston * state.rate[2:n], forces.block * state.rate[n:]])
        size += np.abs(own).sum()
        outputs = {
            "film_thickness": thickness, "sliding_velocity": velocity, "crank_angle": state.crank_angle, "piston_position": Y,
            "piston_velocity": climb, "lateral_displacement": state.place[0], "rocking_angle": state.place[1],
            "side_force": -forces.lateral, "crank_torque": torque - lift * guided + self.crank.inertia * state.crank_acceleration,
            "rotation_speed": state.crank_speed, "pin_force_x": pin[0], "pin_force_y": pin[1] - lift,
            "interface_work_error": abs(power - own.sum()) / size if size > 0.0 else 0.0,
            "residual_evaluations": self.residual_evaluations, "jacobian_evaluations": self.jacobian_evaluations}
        return outputs | ({"modal_coordinate": state.place[2:].copy()} if self.coordinates > 2 else {})

    def directional_derivative(self, pressure_force, friction_force):
        """Change of film thickness and sliding velocity at the end of the last step with the forces at its end.

        Eq. (D1):  J d(acceleration) = dQ,   d(place) = c2 d(acceleration),  d(rate) = c1 d(acceleration)

        Parameters
        ----------
        pressure_force, friction_force : ndarray, shape (c, a)
            Direction [N].

        Returns
        -------
        film_thickness, sliding_velocity : ndarray, shape (c, a)
            [m], [m/s]
        """
        c, _, state, crank, window = self._last
        film = self.skirt, self.bore, window
        forces = generalised(*film, pressure_force, friction_force)
        link = motion(self.mechanism, state.place[0], state.rate[0], state.acceleration[0], *crank)
        right = np.concatenate([[forces.lateral + link[4] * forces.axial, forces.moment], forces.piston])
        piston = dgetrs(*self._factorised(), right)[0]                                                          # Eq. (D1)
        block = forces.block / (1 + c.rate * self.block.damping + c.place * self.block.stiffness)
        climb = (c.rate * link[4] + c.place * link[2] / 2) * piston[0]
        return (opening(*film, *(c.place * piston[:2]), c.place * piston[2:], c.place * block),
                sliding(*film, climb, c.rate * piston[1], c.rate * piston[2:], c.rate * block))

    def _factorised(self):
        """The tangent at the end of the last step, factorised when it is first asked for."""
        if self._factor is None:
            c, load, state, crank, _ = self._last
            n = self.flexible.stop
            matrix = tangent(self.piston, self.mechanism, load, state.place[:n], state.rate[:n], state.acceleration[:n], *crank,
                             c.rate, c.place)
            self.jacobian_evaluations += 1
            self._factor = dgetrf(matrix, overwrite_a=True)[:2]
        return self._factor

