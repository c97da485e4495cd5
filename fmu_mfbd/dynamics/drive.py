"""Scalar outputs of a step of the bodies: their declarations and values."""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.surfaces import count_of, surface_at
from ..mechanism.chain import Bodies
from ..mechanism.piston_motion import LATERAL, ROCKING
from ..mechanism.slider_crank import side_force_demand
from .account import EnergyAccount
from .instant import Instant
from .system import BodySystem, StepProblem, rigid_piston


class Scalars(NamedTuple):
    """Scalar outputs, each declared once: unit and nominal value."""

    crank_angle: Annotated[float, "rad", 1.0]
    """Crank angle, 0 at firing top dead centre."""
    rotation_speed: Annotated[float, "rad/s", 300.0]
    """Current speed of the crank."""
    piston_position: Annotated[float, "m", 0.1]
    """Height of pin point A above the crank axis."""
    piston_velocity: Annotated[float, "m/s", 10.0]
    """Velocity of pin point A towards the head."""
    lateral_displacement: Annotated[float, "m", 1e-5]
    """Displacement of pin point A from its concentric position towards the thrust side."""
    rocking_angle: Annotated[float, "rad", 1e-3]
    """Rotation of the piston about the pin axis +z."""
    lateral_velocity: Annotated[float, "m/s", 0.01]
    """Velocity of pin point A towards the thrust side."""
    rocking_velocity: Annotated[float, "rad/s", 1.0]
    """Angular velocity of the piston about the pin axis +z."""
    side_force: Annotated[float, "N", 1e3]
    """Force of the piston on the bore through the film, positive on the thrust side."""
    crank_torque: Annotated[float, "N.m", 10.0]
    """Torque of the drive on the crank in its direction of rotation."""
    effective_inertia: Annotated[float, "kg.m2", 0.01]
    """Moment of inertia of crank and of all that it moves about its axis, with a rigid piston."""
    pin_force_x: Annotated[float, "N", 1e3]
    """Force of the pin on the piston along x."""
    pin_force_y: Annotated[float, "N", 1e3]
    """Force of the pin on the piston along y."""
    pin_friction_moment: Annotated[float, "N.m", 0.1]
    """Friction moment of the pin on the piston about +z."""
    pin_friction_power: Annotated[float, "W", 10.0]
    """Friction power at the pin."""
    element_power: Annotated[float, "W", 10.0]
    """Power of all force elements, such as land_contact, on both of their bodies."""
    kinetic_energy: Annotated[float, "J", 1e-3]
    """Kinetic energy of the motion across the bore, including rocking and modes."""
    piston_kinetic_energy: Annotated[float, "J", 1e-3]
    """Kinetic energy of the piston alone in lateral translation and rocking."""
    lower_edge_velocity: Annotated[float, "m/s", 1e-2]
    """Velocity of the lower edge of the films on the skirt towards the thrust side."""
    upper_edge_velocity: Annotated[float, "m/s", 1e-2]
    """Velocity of the upper edge of the films on the skirt towards the thrust side."""
    elastic_energy: Annotated[float, "J", 1e-3]
    """Elastic energy of all modes."""
    film_power: Annotated[float, "W", 100.0]
    """Power of the film on the bodies, mean over the step."""
    power_error: Annotated[float, "W", 1.0]
    """Power that time integration creates in the motion across the bore, mean over the step;
    negative: lost.
    """
    received_power: Annotated[float, "W", 100.0]
    """Power that the bodies received from the film, mean over the step, computed from their motion.
    """
    energy_size: Annotated[float, "J", 1e-3]
    """Kinetic energy across the bore, including the rod; larger value of both ends of the step."""
    power_size: Annotated[float, "W", 100.0]
    """Sum of the sizes of the powers exchanged with forces other than the film, mean over the step.
    """
    thermal_opening: Annotated[float, "m", 1e-5]
    """Change of the film thickness on the skirt with piston_temperature and bore_temperature."""
    longest_step: Annotated[float, "s", 1e-3]
    """Longest step that resolves the motion across the bore; if it is shorter than the last step,
    that step can be repeated in parts.
    """
    side_force_demand: Annotated[float, "N", 1e3]
    """Side-force demand of gas, rings and inertia, for a rigid piston in the middle of the bore."""
    cylinder_pressure: Annotated[float, "Pa", 1e6]
    """Current gauge pressure on the crown."""


@compilable
def piston_kinetic_energy(bodies: Bodies, velocity: float, rocking_velocity: float) -> float:
    """Return the kinetic energy of the piston alone in lateral translation and rocking [J].

    Eq. (K27):  E = (m v^2 + I w^2)/2,   v = v_A - w S_y/m,   I = I_A - (S_x^2 + S_y^2)/m
                v at the centre of mass, w the rocking velocity, S and I_A about A

    Parameters
    ----------
    bodies : Bodies
        The last of them is the piston.
    velocity : float
        Lateral velocity of A [m/s].
    rocking_velocity : float
        [rad/s]
    """
    m, S = bodies.mass[-1], bodies.S[-1]
    at_centre = velocity - rocking_velocity * S[1] / m
    inertia = bodies.I0[-1] - (S[0] ** 2 + S[1] ** 2) / m
    return (m * at_centre**2 + inertia * rocking_velocity**2) / 2  # Eq. (K27)


@compilable
def skirt_edges(surfaces: np.ndarray) -> tuple[float, float]:
    """Return the heights of the lower and the upper edge of all films on the skirt above A [m]."""
    low, high = np.inf, -np.inf
    for k in range(count_of(surfaces)):
        height = surface_at(surfaces, k).skirt.height
        last = len(height) - 1
        half = (height[last] - height[0]) / (2 * max(last, 1))
        low = min(low, height[0] - half)
        high = max(high, height[last] + half)
    return low, high


@compilable
def scalars_of(
    now: Instant,
    problem: StepProblem,
    drive: tuple[float, float],
    energy: EnergyAccount,
    system: BodySystem,
    warm: tuple[float, float],
) -> Scalars:
    """Return the scalar outputs at an instant, the end of a step, or a start with step 0.

    `drive` contains torque [N m] and effective inertia [kg m2]. `warm` contains the change of the
    film thickness with temperatures [m] and the work of the films on the growing walls [J].
    """
    step, crank, others = problem.coefficients.step, problem.crank, problem.others
    per_second = 1.0 / step if step > 0.0 else 0.0
    torque, inertia = drive
    opening, warm_work = warm
    lateral, rocking = now.next_start.velocity[LATERAL], now.next_start.velocity[ROCKING]
    lower, upper = skirt_edges(system.surfaces)
    mass = rigid_piston(system).mass
    return Scalars(
        crank_angle=crank.angle,
        rotation_speed=crank.speed,
        piston_position=now.axial.height,
        piston_velocity=now.axial.velocity,
        lateral_displacement=now.end.position[LATERAL],
        rocking_angle=now.end.position[ROCKING],
        lateral_velocity=lateral,
        rocking_velocity=rocking,
        side_force=now.side_force,
        crank_torque=torque,
        effective_inertia=inertia,
        pin_force_x=now.pin_x,
        pin_force_y=now.pin_y,
        pin_friction_moment=now.pin_moment,
        pin_friction_power=now.pin_friction_power,
        element_power=now.element_power,
        kinetic_energy=now.ledger.kinetic,
        piston_kinetic_energy=piston_kinetic_energy(system.chain.bodies, lateral, rocking),
        lower_edge_velocity=lateral - rocking * lower,
        upper_edge_velocity=lateral - rocking * upper,
        elastic_energy=now.ledger.elastic,
        film_power=per_second * (now.ledger.film_work + warm_work),
        power_error=per_second * now.ledger.error,
        received_power=per_second * (energy.gain + warm_work),
        energy_size=energy.kinetic,
        power_size=per_second * energy.exchanged,
        thermal_opening=opening,
        longest_step=now.longest_step,
        side_force_demand=side_force_demand(system.mechanism, mass, others, crank),
        cylinder_pressure=others.wall.chamber,
    )
