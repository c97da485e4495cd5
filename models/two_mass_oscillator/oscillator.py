"""One half of the two-mass oscillator: a mass between a wall and the other mass, its motion exact
for the input it is told.

Eq. (U6):  m u'' = -(k_o + k_m) u + k_m v(t),   v the other mass's displacement, within a step a polynomial up to degree 3
Eq. (U7):  u = p + (u0 - p0) cos W s + (u0' - p0')/W sin W s,   W^2 = (k_o + k_m)/m,   p the polynomial that solves (U6):
           W^2 p_j = k_m/m v_j - (j + 2)(j + 1) p_{j+2}   for the coefficients of s^j

The system is that of preCICE's tutorial `oscillator`.
"""

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import Variable


@dataclass(frozen=True)
class State:
    displacement: float  # [m]
    velocity: float  # [m/s]


class Oscillator(FieldSlave):
    """A mass on two springs, Eqs. (U6) and (U7)."""

    name, description, state_type, usual_step = (
        "oscillator",
        "A mass between a wall and another mass",
        State,
        1e-2,
    )
    interpolates_inputs = True

    @staticmethod
    def variables(options):
        return [
            Variable("mass", "kg", "parameter", "Mass", 1.0, minimum=1e-9),
            Variable(
                "outer_stiffness",
                "N/m",
                "parameter",
                "Spring to the wall",
                4 * np.pi**2,
                minimum=0.0,
            ),
            Variable(
                "middle_stiffness",
                "N/m",
                "parameter",
                "Spring to the other mass",
                16 * np.pi**2,
                minimum=1e-9,
            ),
            Variable("start_displacement", "m", "parameter", "Displacement at the start", 0.0),
            Variable(
                "other_displacement",
                "m",
                "input",
                "Displacement of the other mass",
                0.0,
                nominal=1.0,
            ),
            Variable("displacement", "m", "output", "Displacement of the mass", 0.0, nominal=1.0),
            Variable(
                "velocity",
                "m/s",
                "output",
                "Velocity of the mass",
                0.0,
                nominal=1.0,
                derivative_of="displacement",
            ),
        ]

    def start(self, values):
        return published(State(values["start_displacement"], 0.0))

    def advance(self, state, values, time, step):
        other = self.course("other_displacement") / np.array([1, 1, 2, 6])
        frequency = np.sqrt(
            (values["outer_stiffness"] + values["middle_stiffness"]) / values["mass"]
        )
        p = np.zeros(6)
        for j in (3, 2, 1, 0):
            p[j] = (
                values["middle_stiffness"] / values["mass"] * other[j]
                - (j + 2) * (j + 1) * p[j + 2]
            ) / frequency**2
        p, slope = Polynomial(p), Polynomial(p).deriv()
        a, b = state.displacement - p(0.0), (state.velocity - slope(0.0)) / frequency
        cos, sin = np.cos(frequency * step), np.sin(frequency * step)
        return published(
            State(
                float(p(step) + a * cos + b * sin),  # Eq. (U7)
                float(slope(step) + frequency * (b * cos - a * sin)),
            )
        )


def published(state):
    return state, {"displacement": state.displacement, "velocity": state.velocity}
