"""First-order lag by backward Euler, in Python.

Eq. (X14):  (1 + H) x' = x + H (gain tanh(u) + load);   x = 1 at the start
"""

from dataclasses import dataclass
from math import tanh

from piston_cosim.master.fmi.errors import Discard
from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import input_variable, output_variable, parameter


@dataclass(frozen=True)
class State:
    x: float


class Lag(FieldSlave):
    """Lag; steps longer than `longest` [s] are discarded."""

    name = "lag"
    description = "First-order lag"
    state_type = State
    derivative_inputs = ("u",)
    derivative_outputs = ("x",)

    @staticmethod
    def variables(options):
        return [
            parameter("gain", "1", "Gain", 1.0),
            parameter("longest", "s", "Longest step", 1.0),
            input_variable("u", "1", "Input", 0.0, 1.0),
            input_variable("load", "1", "Load", 0.0, 1.0),
            output_variable("x", "1", "Output", 1.0, start=1.0),
        ]

    def start(self, values):
        return State(1.0), {"x": 1.0}

    def advance(self, state, values, time, step):
        if step > values["longest"]:
            raise Discard(f"step of {step:g} s is too long")
        u, gain = float(values["u"]), values["gain"]
        x = (state.x + step * (gain * tanh(u) + float(values["load"]))) / (1.0 + step)
        self.slope = step * gain * (1.0 - tanh(u) ** 2) / (1.0 + step)
        return State(x), {"x": x}

    def directional_derivative(self, seeds):
        return {"x": self.slope * seeds["u"]}
