"""Gas pressure over crank angle as an FMU: compression, combustion, expansion, and an open cycle at
ambient pressure.
"""

from dataclasses import dataclass

import numpy as np

from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import Variable

CLOSES, OPENS = (
    np.radians(-150.0),
    np.radians(130.0),
)  # inlet closes, exhaust opens; 0 = firing top dead centre
AMBIENT = 1.0e5  # Pa


@dataclass(frozen=True)
class State:
    """Nothing is remembered: pressure follows from the angle."""


class GasPressure(FieldSlave):
    """Fired cycle from a motored one.

    Eq. (U1):  p = p0 (V_ivc / V)^1.33 (1 + R x),   x = 1 - exp(-5 ((a - a0) / da)^3),   a0 = -15 deg, da = 60 deg

    R is the final rise over the motored pressure (pressure ratio, [Matekunas1983]), x the burnt
    fraction (Wiebe).
    """

    name, description, state_type = "gas_pressure", "Gas pressure over crank angle", State

    @staticmethod
    def variables(options):
        return [
            Variable("crank_angle", "rad", "input", "0 = firing top dead centre", 0.0),
            Variable(
                "crank_radius",
                "m",
                "parameter",
                "Crank radius",
                24.75e-3,
                minimum=1e-3,
                maximum=1.0,
            ),
            Variable("rod_length", "m", "parameter", "Rod length", 0.1, minimum=1e-2, maximum=5.0),
            Variable(
                "compression_ratio",
                "1",
                "parameter",
                "Compression ratio",
                9.0,
                minimum=2.0,
                maximum=25.0,
            ),
            Variable(
                "pressure_rise", "1", "parameter", "R, 0 = motored", 2.5, minimum=0.0, maximum=10.0
            ),
            Variable("gas_pressure", "Pa", "output", "Gauge pressure on the crown", nominal=1e6),
        ]

    def start(self, values):
        return State(), self._outputs(values)

    def advance(self, state, values, time, step):
        return state, self._outputs(values)

    def _outputs(self, values):
        angle = (values["crank_angle"] + 2 * np.pi) % (4 * np.pi) - 2 * np.pi
        if not CLOSES < angle < OPENS:
            return {"gas_pressure": 0.0}
        burnt = 1 - np.exp(-5 * max((angle + np.radians(15)) / np.radians(60), 0.0) ** 3)
        motored = AMBIENT * (volume(CLOSES, values) / volume(angle, values)) ** 1.33
        return {
            "gas_pressure": motored * (1 + values["pressure_rise"] * burnt) - AMBIENT
        }  # Eq. (U1)


def volume(angle, values):
    """Cylinder volume over piston area [m]."""
    r, rod = values["crank_radius"], values["rod_length"]
    travel = r * (1 - np.cos(angle)) + rod - np.sqrt(rod**2 - (r * np.sin(angle)) ** 2)
    return 2 * r / (values["compression_ratio"] - 1) + travel
