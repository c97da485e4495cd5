"""Model class of the tests of the C front: six integrators. Their native entries: front_toy.c."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from piston_cosim.master.fmi.errors import BadInput, Discard
from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import (
    Variable,
    constant,
    input_variable,
    output_variable,
    parameter,
)

SHAPE = (2, 3)
LAWS = ("linear", "square", "cubic")
LARGEST_RATE = 9.0


class State(NamedTuple):
    """Integrals, and the length of the last step [s]."""

    x: np.ndarray
    step: float


class Toy(FieldSlave):
    """x' = rounds (gain u^law + bias) + extra, x = x0 at the start; `count` counts steps."""

    name = "front_toy"
    description = "Six integrators"
    state_type = State

    @property
    def derivative_inputs(self):
        return ("u",)

    @property
    def derivative_outputs(self):
        return ("x", "total")

    @property
    def interpolates_inputs(self):
        return bool(self.options)

    @staticmethod
    def variables(options):
        texts = [Variable("label", "1", "parameter", "Text.", "none")] if options else []
        return [
            constant("cells", 6, "Number of integrators."),
            parameter("gain", "1/s", "Factor of the input.", 2.0, 0.0, 10.0),
            parameter("bias", "1/s", "Constant rate.", 0.0),
            parameter("x0", "1", "Start value.", 0.0),
            replace(parameter("extra", "1/s", "Added rate.", 0.0, -1.0, 1.0), tunable=True),
            Variable("law", "1", "parameter", "Power of the input.", "linear", choices=LAWS),
            parameter("rounds", "1", "Factor of the rate.", 1, 1, 3),
            input_variable("u", "m", "Input.", 0.0, 1.0, SHAPE),
            output_variable("x", "1", "Integrals.", 1.0, SHAPE),
            output_variable("total", "1", "Sum.", 1.0),
            output_variable("count", "1", "Steps.", start=0),
            *texts,
        ]

    def start(self, values):
        if values["x0"] > 100.0:
            raise BadInput(f"x0: expected at most 100 %d, got {values['x0']:g}")
        if values.get("label") == "bad":
            raise BadInput("label: expected another text")
        x = np.full(SHAPE, values["x0"])
        return State(x, 0.0), {"x": x, "total": x.sum()}

    def advance(self, state, values, time, step):
        power = LAWS.index(values["law"]) + 1
        u = values["u"]
        if self.courses:  # the mean over the step
            u = sum(c * step**k / (1, 2, 6, 24)[k] for k, c in enumerate(self.course("u")))
        rate = values["rounds"] * (values["gain"] * u**power + values["bias"]) + values["extra"]
        if np.abs(rate).max() > LARGEST_RATE:
            raise Discard("too fast")
        self.views["count"] += 1
        x = state.x + step * rate
        return State(x, step), {"x": x, "total": x.sum()}

    def directional_derivative(self, seeds):
        step = self.state.step * self.views["gain"] * self.views["rounds"]
        power = self.views["law"].item()
        x = step * power * self.views["u"] ** (power - 1) * seeds["u"]
        return {"x": x, "total": x.sum()}
