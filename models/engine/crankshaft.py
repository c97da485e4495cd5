"""A crankshaft with flywheel as an FMU: turns under what the piston takes or gives, and a load."""

from dataclasses import dataclass

from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import Variable


@dataclass(frozen=True)
class State:
    """Angular speed [rad/s]."""

    speed: float


class Crankshaft(FieldSlave):
    """Eq. (U2):  J dw/dt = -T - L,   T: torque that the crank drive takes, L: load."""

    name, description, state_type = "crankshaft", "Crankshaft with flywheel and load", State

    @staticmethod
    def variables(options):
        return [
            Variable(
                "crank_torque",
                "N.m",
                "input",
                "T, torque that drives the crank at its present speed",
                0.0,
            ),
            Variable("load_torque", "N.m", "input", "L", 0.0),
            Variable("inertia", "kg.m2", "parameter", "J", 0.01, minimum=1e-6, maximum=1e6),
            Variable("start_speed", "rad/s", "parameter", "Speed at the start", 628.3185307179587),
            Variable("crank_speed", "rad/s", "output", "w", nominal=100.0),
        ]

    def start(self, values):
        return State(values["start_speed"]), {"crank_speed": values["start_speed"]}

    def advance(self, state, values, time, step):
        speed = (
            state.speed
            - (values["crank_torque"] + values["load_torque"]) / values["inertia"] * step
        )  # Eq. (U2)
        return State(speed), {"crank_speed": speed}
