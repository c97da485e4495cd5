"""Gas pressure over crank angle as an FMU: compression, combustion, expansion, open cycle.

The open cycle is at ambient pressure.
"""

from dataclasses import dataclass

import numpy as np

from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import input_variable, output_variable, parameter

# crank angles, 0 = firing top dead centre
CLOSES = np.radians(-150.0)  # inlet
OPENS = np.radians(130.0)  # exhaust
AMBIENT = 1.0e5  # Pa


@dataclass(frozen=True)
class GasPressureState:
    """Empty state, because the pressure follows from the angle."""


class GasPressure(FieldSlave):
    """Fired cycle from a motored one.

    Eq. (U1):  p = p0 (V_ivc / V)^1.33 (1 + R x),   x = 1 - exp(-5 ((a - a0) / da)^3),
               a0 = -15 deg, da = 60 deg

    R is the final rise over the motored pressure (pressure ratio, [Matekunas1983]), x the burnt
    fraction (Wiebe).
    """

    name, description, state_type = (
        "gas_pressure",
        "Gas pressure over crank angle",
        GasPressureState,
    )

    @staticmethod
    def variables(options):
        return [
            input_variable("crank_angle", "rad", "Crank angle, 0 at firing top dead centre"),
            parameter("crank_radius", "m", "Crank radius", 24.75e-3, 1e-3, 1.0),
            parameter("rod_length", "m", "Rod length", 0.1, 1e-2, 5.0),
            parameter("compression_ratio", "1", "Compression ratio", 9.0, 2.0, 25.0),
            parameter("pressure_rise", "1", "Pressure rise R; 0: motored", 2.5, 0.0, 10.0),
            output_variable("gas_pressure", "Pa", "Gauge pressure on the crown", 1e6),
        ]

    def start(self, values):
        return GasPressureState(), self._outputs(values)

    def advance(self, state, values, time, step):
        return state, self._outputs(values)

    def _outputs(self, values):
        angle = (values["crank_angle"] + 2 * np.pi) % (4 * np.pi) - 2 * np.pi
        if not CLOSES < angle < OPENS:
            return {"gas_pressure": 0.0}
        burnt = 1 - np.exp(-5 * max((angle + np.radians(15)) / np.radians(60), 0.0) ** 3)
        motored = AMBIENT * (volume(CLOSES, values) / volume(angle, values)) ** 1.33
        # Eq. (U1)
        return {"gas_pressure": motored * (1 + values["pressure_rise"] * burnt) - AMBIENT}


def volume(angle, values):
    """Return the cylinder volume over piston area [m]."""
    r, rod = values["crank_radius"], values["rod_length"]
    travel = r * (1 - np.cos(angle)) + rod - np.sqrt(rod**2 - (r * np.sin(angle)) ** 2)
    return 2 * r / (values["compression_ratio"] - 1) + travel
