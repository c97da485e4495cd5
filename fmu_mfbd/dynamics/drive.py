"""What a step says around `instant.end_of_step`: what acts on the piston beside the film, and what
the outside sees. Called by the model and by the native FMU alike.
"""

from typing import NamedTuple

from ...master.fmi.compiled import compilable
from .carrier import Carrier
from .gas_on_bore import WallPressures
from .instant import Instant, OtherForces, RingForce, System
from .piston_motion import LATERAL, ROCKING
from .slider_crank import CrankMotion, PistonLoad, side_force_demand


class Scalars(NamedTuple):
    """Scalar outputs, as `variables.outputs` names and describes them."""

    crank_angle: float
    rotation_speed: float
    piston_position: float
    piston_velocity: float
    lateral_displacement: float
    rocking_angle: float
    lateral_velocity: float
    rocking_velocity: float
    side_force: float
    crank_torque: float
    pin_force_x: float
    pin_force_y: float
    pin_friction_moment: float
    pin_friction_power: float
    kinetic_energy: float
    elastic_energy: float
    film_work: float
    energy_error: float
    energy_gain: float
    energy_size: float


@compilable
def others_of(
    gas_area: float, pressure: float, rings: RingForce, land_pressure: float, carrier: Carrier
) -> OtherForces:
    """What acts beside the film and the pin, of gas [m2], [Pa], rings, and the block's motion."""
    return OtherForces(gas_area * pressure, rings, WallPressures(pressure, land_pressure), carrier)


@compilable
def demand_of(system: System, others: OtherForces, crank: CrankMotion) -> float:
    """Side force [N] that gas, rings and inertia ask for (Eq. (K11))."""
    mass = system.piston.mass + system.mechanism.pin_mass
    load = PistonLoad(mass, others.gas, others.rings.lateral, others.rings.axial)
    return side_force_demand(system.mechanism, load, crank)


@compilable
def scalars_of(now: Instant, crank: CrankMotion, crank_inertia: float) -> Scalars:
    """Scalar outputs at an instant; `energy_gain` and `energy_size` before `account`."""
    return Scalars(
        crank_angle=crank.angle,
        rotation_speed=crank.speed,
        piston_position=now.piston_position,
        piston_velocity=now.piston_velocity,
        lateral_displacement=now.position[LATERAL],
        rocking_angle=now.position[ROCKING],
        lateral_velocity=now.kept_velocity[LATERAL],
        rocking_velocity=now.kept_velocity[ROCKING],
        side_force=now.side_force,
        crank_torque=now.torque + crank_inertia * crank.acceleration,
        pin_force_x=now.pin_x,
        pin_force_y=now.pin_y,
        pin_friction_moment=now.pin_moment,
        pin_friction_power=now.pin_friction_power,
        kinetic_energy=now.ledger.kinetic,
        elastic_energy=now.ledger.elastic,
        film_work=now.ledger.film_work,
        energy_error=now.ledger.error,
        energy_gain=now.ledger.axial_work,
        energy_size=now.ledger.accounted,
    )
