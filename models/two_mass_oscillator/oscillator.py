"""One half of the two-mass oscillator: a mass between a wall and the other mass.

Its motion is exact for the given input.

Eq. (U6):  m u'' = -(k_o + k_m) u + k_m v(t),
           v the other mass's displacement, within a step a polynomial up to degree 3
Eq. (U7):  u = p + (u0 - p0) cos W s + (u0' - p0')/W sin W s,   W^2 = (k_o + k_m)/m,
           p the polynomial that solves (U6), for the coefficients of s^j
           W^2 p_j = k_m/m v_j - (j + 2)(j + 1) p_{j+2}

The system is that of preCICE's tutorial `oscillator`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from piston_cosim.master.fmi.slave import Experiment, FieldSlave
from piston_cosim.master.fmi.variables import input_variable, output_variable, parameter


@dataclass(frozen=True)
class OscillatorState:
    displacement: float  # [m]
    velocity: float  # [m/s]


class Oscillator(FieldSlave):
    """Mass on two springs, Eqs. (U6) and (U7)."""

    name = "oscillator"
    description = "A mass between a wall and another mass"
    state_type = OscillatorState
    experiment = Experiment(stop=1.0, step=1e-2)
    interpolates_inputs = True

    @staticmethod
    def variables(options):
        return [
            parameter("mass", "kg", "Mass", 1.0, 1e-9),
            parameter("outer_stiffness", "N/m", "Spring to the wall", 4 * np.pi**2, 0.0),
            parameter("middle_stiffness", "N/m", "Spring to the other mass", 16 * np.pi**2, 1e-9),
            parameter("start_displacement", "m", "Displacement at the start", 0.0),
            input_variable("other_displacement", "m", "Displacement of the other mass", 0.0, 1.0),
            output_variable("displacement", "m", "Displacement of the mass", 1.0),
            output_variable(
                "velocity", "m/s", "Velocity of the mass", 1.0, derivative_of="displacement"
            ),
        ]

    def start(self, values):
        return published(OscillatorState(values["start_displacement"], 0.0))

    def advance(self, state, values, time, step):
        coefficients = self.course("other_displacement") / np.array([1, 1, 2, 6])
        coupling = values["middle_stiffness"] / values["mass"]
        frequency = np.sqrt(
            (values["outer_stiffness"] + values["middle_stiffness"]) / values["mass"]
        )
        p = np.zeros(len(coefficients) + 2)
        for j in reversed(range(len(coefficients))):  # the particular solution of Eq. (U6)
            p[j] = (coupling * coefficients[j] - (j + 2) * (j + 1) * p[j + 2]) / frequency**2
        particular = Polynomial(p)
        slope = particular.deriv()
        a = state.displacement - particular(0.0)
        b = (state.velocity - slope(0.0)) / frequency
        cos = np.cos(frequency * step)
        sin = np.sin(frequency * step)
        # Eq. (U7)
        displacement = particular(step) + a * cos + b * sin
        velocity = slope(step) + frequency * (b * cos - a * sin)
        return published(OscillatorState(float(displacement), float(velocity)))


def published(state):
    return state, {"displacement": state.displacement, "velocity": state.velocity}
