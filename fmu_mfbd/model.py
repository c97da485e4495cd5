"""The body side as one model: a flexible piston on its crank in a flexible bore, one implicit step at a time."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs

from .generalised_alpha import coefficients, predict
from .piston_motion import Load, imbalance, tangent
from .slider_crank import height, motion


class NotConverged(RuntimeError):
    """The step's equations could not be solved; the message says where and how far it got."""


@dataclass(frozen=True)
class State:
    """Everything that a step starts from; n = 2 + piston modes + block modes.

    Parameters
    ----------
    crank_angle : float
        [rad], 0 at firing top dead centre.
    place, rate, acceleration, auxiliary : ndarray, shape (n,)
        [x_A [m], rocking angle [rad], piston then block modal coordinates [kg^1/2 m]], derivatives in time, and the
        time integrator's auxiliary acceleration.
    """

    crank_angle: float
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
        Constant over the step [rad/s].
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
    film : Film
    gas_area : float
        Area of the bore [m2].
    gas_force : ndarray, shape (k,)
        Modal force of a unit gas force (-y) on the crown [kg^-1/2].
    spectral_radius : float
        Of the time integrator at infinite frequency [-], 0 to 1.
    """

    def __init__(self, piston, block, mechanism, film, gas_area, gas_force, spectral_radius):
        self.piston, self.block, self.mechanism, self.film = piston, block, mechanism, film
        self.gas_area, self.gas_force, self.spectral_radius = gas_area, gas_force, spectral_radius
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
        place, nothing = np.zeros(self.coordinates), np.zeros(self.coordinates)
        place[:2] = lateral, angle
        instant = coefficients(0.0, self.spectral_radius)
        return self._solve(instant, place, nothing, nothing, crank_angle, inputs, nothing, auxiliary=lambda a: a)

    def advance(self, state, inputs, step):
        """One step of the generalised-alpha method; equations hold at its end, with the forces given for its end.

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
        return self._solve(c, place, rate, state.acceleration, state.crank_angle + step * inputs.crank_speed, inputs, auxiliary,
                           auxiliary=lambda a: auxiliary + weight * a)

    def _solve(self, c, place, rate, guess, crank_angle, inputs, _, auxiliary):
        """End accelerations from places and rates predicted without them; then state and outputs."""
        window = self.film.window(height(self.mechanism, 0.0, crank_angle)[0])
        lateral, axial, moment, piston_force, block_force = self.film.generalised(window, inputs.pressure_force, inputs.friction_force)
        gas = inputs.gas_pressure * self.gas_area
        load = Load(lateral, axial - gas, moment + self.film.skirt.pin_offset * gas, piston_force + gas * self.gas_force)
        n = self.flexible.stop
        acceleration = np.empty(self.coordinates)
        acceleration[:n], pin, torque = self._newton(c, load, place[:n], rate[:n], guess[:n], crank_angle, inputs.crank_speed)
        acceleration[n:] = ((block_force - self.block.damping * rate[n:] - self.block.stiffness * place[n:])
                            / (1 + c.rate * self.block.damping + c.place * self.block.stiffness))
        state = State(crank_angle, place + c.place * acceleration, rate + c.rate * acceleration, acceleration, auxiliary(acceleration))
        self._last = (c, load, state, inputs.crank_speed, window)
        return state, self._outputs(state, inputs, window, lateral, (moment, piston_force, block_force), pin, torque)

    def _newton(self, c, load, place, rate, acceleration, crank_angle, crank_speed):
        """Piston accelerations that balance `load`, to round-off: the tangent is exact and nearly constant over a step."""
        arguments = self.piston, self.mechanism, load
        end = lambda a: (place + c.place * a, rate + c.rate * a, a, crank_angle, crank_speed)
        matrix = tangent(*arguments, *end(acceleration), c.rate, c.place)
        scale = np.sqrt(np.abs(np.diagonal(matrix)))
        factor = dgetrf(matrix, overwrite_a=True)[:2]
        self.jacobian_evaluations += 1
        last = np.inf
        for _ in range(30):
            residual, pin_x, pin_y, torque = imbalance(*arguments, *end(acceleration))
            self.residual_evaluations += 1
            change = dgetrs(*factor, residual)[0]
            size, total = np.linalg.norm(scale * change), np.linalg.norm(scale * acceleration)
            if size <= 1e-15 * total or (size >= 0.5 * last and size <= 1e-10 * total) or size == 0.0:
                return acceleration, (pin_x, pin_y), torque
            acceleration, last = acceleration - change, size
        raise NotConverged(f"piston motion at crank angle {crank_angle:.6g} rad: last change of the accelerations {size:.3g}, their size {total:.3g}")

    def _outputs(self, state, inputs, window, lateral, modal, pin, torque):
        """Everything the outside sees (units in `variables.py`), by name."""
        n = self.flexible.stop
        piston, block = state.place[2:n], state.place[n:]
        piston_rate, block_rate = state.rate[2:n], state.rate[n:]
        Y, slope, lever = height(self.mechanism, state.place[0], state.crank_angle)
        climb = slope * state.rate[0] + lever * inputs.crank_speed
        guided = height(self.mechanism, 0.0, state.crank_angle)[2] * inputs.crank_speed
        lift = self.film.lift(window, inputs.pressure_force, block)
        thickness = self.film.thickness(window, *state.place[:2], piston, block)
        sliding = self.film.sliding(window, climb, state.rate[1], piston_rate, block_rate)
        opening = self.film.opening_rate(window, guided, state.rate[0], state.rate[1], piston_rate, block, block_rate)
        moment, piston_force, block_force = modal
        # work of the interface forces, once on the grid and once in the coordinates
        grid = np.sum(inputs.pressure_force * opening), np.sum(inputs.friction_force * sliding)
        own = np.array([lateral * state.rate[0], moment * state.rate[1], climb * inputs.friction_force.sum(), lift * guided])
        own = np.concatenate([own, piston_force * piston_rate, block_force * block_rate])
        scale = np.abs(inputs.pressure_force * opening).sum() + np.abs(inputs.friction_force * sliding).sum()
        return {
            "film_thickness": thickness, "sliding_velocity": sliding, "crank_angle": state.crank_angle, "piston_position": Y,
            "piston_velocity": climb, "lateral_displacement": state.place[0], "rocking_angle": state.place[1],
            "side_force": -lateral, "crank_torque": torque - lift * guided / inputs.crank_speed if inputs.crank_speed else torque,
            "pin_force_x": pin[0], "pin_force_y": pin[1] - lift, "modal_coordinate": state.place[2:].copy(),
            "interface_work_error": abs(sum(grid) - own.sum()) / scale if scale > 0.0 else 0.0,
            "residual_evaluations": self.residual_evaluations, "jacobian_evaluations": self.jacobian_evaluations}

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
        c, load, state, crank_speed, window = self._last
        n = self.flexible.stop
        if len(self._last) == 5:
            pass
        lateral, axial, moment, piston_force, block_force = self.film.generalised(window, pressure_force, friction_force)
        link = motion(self.mechanism, state.place[0], state.rate[0], state.acceleration[0], state.crank_angle, crank_speed)
        matrix = tangent(self.piston, self.mechanism, load, state.place[:n], state.rate[:n], state.acceleration[:n],
                         state.crank_angle, crank_speed, c.rate, c.place)
        right = np.concatenate([[lateral + link[4] * axial, moment], piston_force])
        change = dgetrs(*dgetrf(matrix, overwrite_a=True)[:2], right)[0]                                        # Eq. (D1)
        block = block_force / (1 + c.rate * self.block.damping + c.place * self.block.stiffness)
        climb = (c.rate * link[4] + c.place * link[2] / 2) * change[0]
        opening = self.film._opening(window, *(c.place * change[:2]), c.place * change[2:], c.place * block)
        return opening, self.film.sliding(window, climb, c.rate * change[1], c.rate * change[2:], c.rate * block)
