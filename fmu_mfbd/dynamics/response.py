"""The derivative at the end of a step of a piston whose pin is tied."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.film import FilmForces, NodalForces
from ..mechanism.equations import (
    ChainDerivative,
    ChainForces,
    PushedForces,
    chain_derivative,
    pushed_forces,
)
from ..mechanism.inertia import ALPHA, AX, AY, W
from ..mechanism.motion import Increments, increments_of
from ..mechanism.solution import Linearisation, factorise_chain, solve_coupled
from ..mechanism.tied_pin import PISTON, loads_of, tied_forces
from .carrier import Carrier
from .floating_frame import Y
from .generalised_alpha import Coefficients, Motion
from .piston_motion import LATERAL, RIGID, ROCKING, Load
from .quasi_static import STILL, FrameAcceleration, follow, static_coordinates
from .skirt_films import Change, forces_by_film, skirt_changes, together
from .slider_crank import CrankMotion
from .system import BodySystem, RingForce


class StepEnd(NamedTuple):
    """End of a step, for derivatives and for forces on the block.

    Parameters
    ----------
    coefficients : Coefficients
    guided : float
        Height at which the bore is read [m].
    load : Load
    now : Motion
        Of the piston's moving coordinates, with a floating pin of all.
    crank : CrankMotion
    linear : Linearisation
        Of a floating pin.
    """

    coefficients: Coefficients
    guided: float
    load: Load
    now: Motion
    crank: CrankMotion
    linear: Linearisation


class Sensitivity(NamedTuple):
    """Forces in the chain at the end of a step, their derivative, and their change with loads.

    The derivative is by end accelerations, which change the motion by `by`.
    """

    forces: ChainForces
    by: Increments
    derivative: ChainDerivative
    pushed: PushedForces


@compilable
def sensitivity(system: BodySystem, last: StepEnd, change: Load, carrier: Carrier) -> Sensitivity:
    """Return the sensitivity of the end of a step to a change of load and motion of the block."""
    loads, chain = loads_of(last.load), system.chain
    forces = tied_forces(chain, last.load, last.now, last.crank)
    by = increments_of(last.coefficients, len(last.now.position))
    derivative = chain_derivative(chain, loads, last.now, forces, by)
    pushed = pushed_forces(chain, forces, last.now, loads_of(change), carrier)
    return Sensitivity(forces, by, derivative, pushed)


class Response(NamedTuple):
    """Change of the films' geometry and of the piston's motion.

    Parameters
    ----------
    film_thickness, sliding_velocity : ndarray, shape (cells,)
        Of all surfaces, stacked [m], [m/s].
    lateral_velocity, rocking_velocity, piston_velocity : float
        [m/s], [rad/s], [m/s]
    acceleration : ndarray, shape (2 + k,)
        Of the piston's moving coordinates [m/s2], [rad/s2], [kg^1/2 m/s2].
    load : Load
        Of the films and rings on the piston, and of the motion of the block.
    """

    film_thickness: np.ndarray
    sliding_velocity: np.ndarray
    lateral_velocity: float
    rocking_velocity: float
    piston_velocity: float
    acceleration: np.ndarray
    load: Load


@compilable
def load_change(
    system: BodySystem, films: FilmForces, rings: RingForce, modal: np.ndarray, carrier: Carrier
) -> Load:
    """Return the change of the load on the piston with films, rings and the block's motion."""
    return Load(
        films.lateral + rings.lateral,
        films.axial + rings.axial,
        films.moment + rings.moment - rings.axial * system.pin_offset,  # Eq. (D8)
        -rings.axial,
        modal,
        carrier,
    )


@compiled
def response(
    system: BodySystem,
    last: StepEnd,
    forces: NodalForces,
    rings: RingForce,
    carrier: Carrier,
) -> Response:
    """Return the change of film and motion at the end of a step with the forces there.

    Eq. (D7):  J d(acceleration) = -dr
               d(position) = c2 d(acceleration),  d(velocity) = c1 d(acceleration)
               J and r of Eq. (D61), static modes by Eq. (D6)

    Parameters
    ----------
    system : BodySystem
    last : StepEnd
    linear : Linearisation
    forces : NodalForces
        Direction, stacked [N].
    rings : RingForce
        Direction.
    carrier : Carrier
        Direction of the motion of a mounted block.

    Returns
    -------
    Response
    """
    film_forces = together(forces_by_film(system, last.guided, forces))
    moving = len(system.piston.stiffness)
    change = load_change(system, film_forces, rings, film_forces.piston[:moving], carrier)
    own, by, derivative, pushed = sensitivity(system, last, change, carrier)
    # Eq. (D7)
    factors = factorise_chain(derivative.arrow)
    bodies, block = system.chain.bodies, own.inertia.carrier
    acceleration = solve_coupled(bodies, own.motion, block, by, factors, pushed.residual)
    for k in range(len(acceleration)):
        acceleration[k] = -acceleration[k]
    frame = pushed.frames[PISTON, :, 0].copy()
    rising = 0.0
    for j in range(RIGID):
        rising += derivative.motion.velocity[PISTON, Y, j] * acceleration[j]
        for k in range(len(frame)):
            frame[k] += derivative.frames[PISTON, k, j] * acceleration[j]
    c = last.coefficients
    spin = 2 * own.inertia.frames[PISTON, W] * frame[W]
    ride = FrameAcceleration(frame[AX], frame[AY], frame[ALPHA], spin)
    piston = _piston_change(system, c, acceleration, film_forces.piston, ride)
    block = _block_change(system, c, film_forces.block)
    films = skirt_changes(system, last.guided, rising, piston, block)
    return Response(
        films.film_thickness,
        films.sliding_velocity,
        piston.velocity[LATERAL],
        piston.velocity[ROCKING],
        rising,
        acceleration,
        change,
    )


@compiled
def _piston_change(system, c, acceleration, force, ride):
    """Return the changes of the piston's coordinates, static modes included.

    They follow from changes of accelerations, modal forces and the motion of the frame.
    """
    moving = len(system.piston.stiffness)
    out = _changes(c, acceleration, RIGID + len(force))
    q = static_coordinates(system.piston_static, force[moving:], ride)
    before = np.zeros(len(out.position))
    follow(out.position, out.velocity, before, q, RIGID + moving, c.step)
    return out


@compiled
def _block_change(system, c, force):
    """Return the changes of all coordinates of the block with its modal forces."""
    block = system.block
    moving = len(block.stiffness)
    acceleration = np.empty(moving)
    for k in range(moving):
        inertia = 1 + c.to_velocity * block.damping[k] + c.to_position * block.stiffness[k]
        acceleration[k] = force[k] / inertia
    out = _changes(c, acceleration, len(force))
    q = static_coordinates(system.block_static, force[moving:], STILL)
    follow(out.position, out.velocity, np.zeros(len(out.position)), q, moving, c.step)
    return out


@compiled
def _changes(c, acceleration, size):
    """Return the changes of positions and velocities at the end of a step with accelerations there.

    They have zeros up to `size`.
    """
    out = Change(np.zeros(size), np.zeros(size))
    for k in range(len(acceleration)):
        out.position[k] = c.to_position * acceleration[k]
        out.velocity[k] = c.to_velocity * acceleration[k]
    return out
