"""A mass and a spring as slaves.

Eq. (X2):  m dv/dt = F,  du/dt = v   backward Euler, m = 1 kg;   F = -k u, k = 100 N/m
"""

from dataclasses import dataclass

from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import Variable


@dataclass(frozen=True)
class State:
    displacement: float
    velocity: float


class Mass(FieldSlave):
    name, description, state_type = "mass", "A mass", State

    @staticmethod
    def variables(options):
        return [
            Variable("force", "N", "input", "Force", 0.0, nominal=1.0),
            Variable("displacement", "m", "output", "Displacement", 0.0, nominal=1.0),
        ]

    def start(self, values):
        return State(0.1, 0.0), {"displacement": 0.1}

    def advance(self, state, values, time, step):
        velocity = state.velocity + step * values["force"]  # Eq. (X2)
        after = State(state.displacement + step * velocity, velocity)
        return after, {"displacement": after.displacement}


class Spring(FieldSlave):
    name, description, state_type = "spring", "A spring", State

    @staticmethod
    def variables(options):
        return [
            Variable("displacement", "m", "input", "Displacement", 0.1, nominal=1.0),
            Variable("force", "N", "output", "Force", 0.0, nominal=1.0),
        ]

    def start(self, values):
        return State(0.0, 0.0), {"force": -100 * values["displacement"]}

    def advance(self, state, values, time, step):
        return state, {"force": -100 * values["displacement"]}  # Eq. (X2)
