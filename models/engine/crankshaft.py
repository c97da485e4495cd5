"""Crankshaft with flywheel as an FMU, driven by the piston and a load."""

from dataclasses import dataclass

from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import input_variable, output_variable, parameter


@dataclass(frozen=True)
class CrankshaftState:
    """Angular speed [rad/s]."""

    speed: float


class Crankshaft(FieldSlave):
    """Crankshaft with flywheel.

    Eq. (U2):  J dw/dt = -T - L,   T: torque that the crank drive takes, L: load.
    """

    name, description, state_type = (
        "crankshaft",
        "Crankshaft with flywheel and load",
        CrankshaftState,
    )

    @staticmethod
    def variables(options):
        return [
            input_variable(
                "crank_torque", "N.m", "Torque T that drives the crank at its current speed"
            ),
            input_variable("load_torque", "N.m", "Load torque L"),
            parameter("inertia", "kg.m2", "Moment of inertia J", 0.01, 1e-6, 1e6),
            parameter("start_speed", "rad/s", "Speed at the start", 628.3185307179587),
            output_variable("crank_speed", "rad/s", "Crank speed w", 100.0),
        ]

    def start(self, values):
        return CrankshaftState(values["start_speed"]), {"crank_speed": values["start_speed"]}

    def advance(self, state, values, time, step):
        torque = values["crank_torque"] + values["load_torque"]
        speed = state.speed - torque / values["inertia"] * step  # Eq. (U2)
        return CrankshaftState(speed), {"crank_speed": speed}
