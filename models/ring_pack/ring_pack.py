"""Ring pack as one participant: forces of the rings on the piston, from its motion and the gas."""

from dataclasses import dataclass
from math import exp, hypot, pi, sqrt

from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import input_variable, output_variable, parameter

PAD = 1.94
"""C of Eq. (U14). A ring face is a flooded plane pad whose gap closes to one half. Its load is
0.1589 eta U b^2/h^2 and its friction 0.7726 eta U b/h per length, so F' = 0.7726/sqrt(0.1589)
sqrt(eta U W')."""


@dataclass(frozen=True)
class RingPackState:
    """Empty state of a quasi-static pack."""


class RingPack(FieldSlave):
    """Quasi-static ring pack: Stribeck friction on the bore, dry friction in the grooves.

    Eq. (U13):   W' = elastic_load + gas_width p
    Eq. (U14):  F_y = -pi D W' [mu_b exp(-|V|/V_s) + C sqrt(eta |V|/W')] V/sqrt(V^2 + V_0^2)
    Eq. (U15):  F_x = -mu_g pi D gas_depth p v/sqrt(v^2 + v_0^2),   v = x_A' - height w
    Eq. (U16):  M = -height F_x

    W' is the load of all rings on the bore per length, p the gauge pressure of the gas, D the
    bore. V is the velocity of the piston, v that of the grooves across the bore, relative to the
    rings. Below V_0 and v_0, dry friction becomes creep. Gas presses the rings on the lower
    flanks of their grooves. Inertia, flutter and blow-by are neglected. Valid for p >= 0 (lower
    values count as 0).
    """

    name, description, state_type = "ring_pack", "Quasi-static piston ring pack", RingPackState

    @staticmethod
    def variables(options):
        return [
            input_variable("cylinder_pressure", "Pa", "Gauge pressure p", 0.0, 1e6),
            input_variable("piston_velocity", "m/s", "Velocity V towards the head", 0.0, 10.0),
            input_variable("lateral_velocity", "m/s", "Lateral velocity of A", 0.0, 1e-2),
            input_variable("rocking_velocity", "rad/s", "Angular velocity of the piston", 0.0, 1.0),
            parameter("bore", "m", "Bore diameter D", 73e-3, 1e-3, 2.0),
            parameter("height", "m", "Height above the pin axis", 25e-3, -1.0, 1.0),
            parameter("elastic_load", "N/m", "Load of all ring tensions", 1000.0, 0.0, 1e6),
            parameter("gas_width", "m", "Width of the gas-loaded faces", 1.5e-3, 0.0, 0.1),
            parameter("gas_depth", "m", "Depth of the gas-loaded flanks", 3e-3, 0.0, 0.1),
            parameter("viscosity", "Pa.s", "Dynamic viscosity eta of the oil", 0.01, 1e-5, 10.0),
            parameter("boundary_friction", "1", "Friction coefficient mu_b", 0.1, 0.0, 1.0),
            parameter("groove_friction", "1", "Friction coefficient mu_g", 0.1, 0.0, 1.0),
            parameter("mixed_velocity", "m/s", "Boundary friction velocity V_s", 0.5, 1e-3, 50.0),
            parameter("creep_velocity", "m/s", "Axial creep velocity V_0", 0.1, 1e-6, 10.0),
            parameter(
                "groove_creep_velocity", "m/s", "Lateral creep velocity v_0", 2e-3, 1e-6, 1.0
            ),
            output_variable("side_force", "N", "Side force F_x on the piston", 1e2),
            output_variable("axial_force", "N", "Axial force F_y on the piston", 1e2),
            output_variable("moment", "N.m", "Moment M on the piston about A", 1.0),
            output_variable("friction_power", "W", "Friction power -F_y V - F_x v", 1e2),
        ]

    def start(self, values):
        return RingPackState(), _forces(values)

    def advance(self, state, values, time, step):
        return state, _forces(values)


def _forces(of):
    """Return the outputs at an instant."""
    pressure = max(of["cylinder_pressure"], 0.0)
    around = pi * of["bore"]
    climb = of["piston_velocity"]
    across = of["lateral_velocity"] - of["height"] * of["rocking_velocity"]
    load = of["elastic_load"] + of["gas_width"] * pressure  # Eq. (U13)
    rubbing = of["boundary_friction"] * exp(-abs(climb) / of["mixed_velocity"]) * load
    shear = PAD * sqrt(of["viscosity"] * abs(climb) * load)
    axial = -around * (rubbing + shear) * climb / hypot(climb, of["creep_velocity"])  # Eq. (U14)
    pressed = around * of["gas_depth"] * pressure
    sliding = across / hypot(across, of["groove_creep_velocity"])
    side = -of["groove_friction"] * pressed * sliding  # Eq. (U15)
    return {
        "side_force": side,
        "axial_force": axial,
        "moment": -of["height"] * side,  # Eq. (U16)
        "friction_power": -axial * climb - side * across,
    }
