"""The derivative at the end of a step."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.film import FilmForces, NodalForces
from ..geometry.pin import PinForces
from ..mechanism.bdf2 import reach_of
from ..mechanism.carrier import BlockMotion
from ..mechanism.cylinder import piston_of
from ..mechanism.derivative import pushed_forces
from ..mechanism.floating_frame import TURN, Y
from ..mechanism.generalised_alpha import Coefficients, Motion
from ..mechanism.laws import from_block_changes
from ..mechanism.loads import loads_at
from ..mechanism.motion import MotionChanges, changes_along, motion_changes
from ..mechanism.piston_motion import LATERAL, RIGID, ROCKING, Load
from ..mechanism.slider_crank import CrankMotion
from ..mechanism.solution import Linearisation, solve_coupled, substitute_chain
from .block_force import BlockForce, block_force
from .instant import of_skirt
from .pin_films import applied_forces, film_pushes, pin_changes
from .skirt_films import FilmChange, forces_by_film, skirt_changes, skirt_slopes, total_forces
from .system import BodySystem, RingForce
from .thermal_growth import FieldInputs


class StepEnd(NamedTuple):
    """End of a step, for derivatives.

    Parameters
    ----------
    coefficients : Coefficients
    guide_height : float
        Height at which the bore is read [m].
    now : Motion
        Motion in all coordinates.
    crank : CrankMotion
    linear : Linearisation
    """

    coefficients: Coefficients
    guide_height: float
    now: Motion
    crank: CrankMotion
    linear: Linearisation


class StepInputs(NamedTuple):
    """Inputs at the end of a step, or seeds of a derivative.

    Parameters
    ----------
    crank_speed, load_torque : float
        [rad/s], [N m].
    gas_pressure, crankcase_pressure, land_pressure : float
        Gauge pressures on the crown, below the piston and between the rings [Pa].
    skirt, pins : NodalForces, PinForces
        Nodal forces of all films, stacked [N].
    rings : RingForce
    carrier : BlockMotion
        Motion of a mounted block.
    piston_temperature, bore_temperature : float
        [K]
    fields : FieldInputs
        Temperatures of the walls.
    """

    crank_speed: float
    load_torque: float
    gas_pressure: float
    crankcase_pressure: float
    land_pressure: float
    skirt: NodalForces
    pins: PinForces
    rings: RingForce
    carrier: BlockMotion
    piston_temperature: float
    bore_temperature: float
    fields: FieldInputs


FIELDS = ("skirt", "pins", "rings", "carrier", "fields")
"""Members of `StepInputs` that are not numbers."""


class Response(NamedTuple):
    """Change of the films' geometry, of the motion and of the forces on the block.

    Parameters
    ----------
    film_thickness, sliding_velocity : ndarray, shape (cells,)
        Fields of all surfaces of the skirt, stacked [m], [m/s].
    lateral_velocity, rocking_velocity, piston_velocity : float
        [m/s], [rad/s], [m/s]
    pin_film_thickness, circumferential_velocity : ndarray, shape (pin cells,)
        Fields of all films of pin and crank, stacked [m], [m/s].
    on_block : BlockForce
    """

    film_thickness: np.ndarray
    sliding_velocity: np.ndarray
    lateral_velocity: float
    rocking_velocity: float
    piston_velocity: float
    pin_film_thickness: np.ndarray
    circumferential_velocity: np.ndarray
    on_block: BlockForce


@compilable
def load_change(system: BodySystem, films: FilmForces, rings: RingForce) -> Load:
    """Return the change of the load on the piston with films and rings."""
    return Load(
        films.push[LATERAL] + rings.lateral,
        films.axial + rings.axial,
        films.push[ROCKING] + rings.moment - rings.axial * system.pin_offset,  # Eq. (D8)
        -rings.axial,
        films.push[RIGID:],
    )


class PushedMotion(NamedTuple):
    """Change of the motion with forces and the block's motion.

    Parameters
    ----------
    acceleration : ndarray, shape (n,)
        Accelerations of all coordinates.
    load : Load
        On the piston.
    on_block : ndarray, shape (3,)
        Without the part of the acceleration.
    """

    acceleration: np.ndarray
    load: Load
    on_block: np.ndarray


class MovedFilms(NamedTuple):
    """Change of motion and films with the coordinates.

    Parameters
    ----------
    moved : Motion
        Change of the motion in all coordinates.
    bodies : MotionChanges
    rising : float
        Change of the piston's velocity [m/s].
    skirt, pins : FilmChange
        Changes of all films, stacked.
    """

    moved: Motion
    bodies: MotionChanges
    rising: float
    skirt: FilmChange
    pins: FilmChange


@compiled
def pushed_motion(
    of: BodySystem,
    last: StepEnd,
    seeds: StepInputs,
    carrier: BlockMotion,
    is_exact: bool,
) -> PushedMotion:
    """Return the change of the motion at the end of a step with the forces there.

    Eq. (D23):  J dq'' = -dr,   dq = c2 dq'',   dq' = c1 dq''       J, r of Eq. (D61)

    Parameters
    ----------
    of : BodySystem
    last : StepEnd
    seeds, carrier : StepInputs, BlockMotion
        Directions of forces and of the block's motion.
    is_exact : bool
        Else modes do not slide along the skirt's films and are not coupled (Eq. (D4)), as in
        products of an iteration whose fixed point does not depend on them.
    """
    chain, own = of.chain, last.linear
    skirt = total_forces(forces_by_film(of, last.guide_height, seeds.skirt, is_exact))
    change = load_change(of, skirt, seeds.rings)
    at, block = own.forces.motion, own.forces.inertia.carrier
    by = reach_of(last.coefficients, of.kinds)
    applied = applied_forces(of, change, seeds.pins, film_pushes(of, seeds.pins))
    loads = loads_at(chain, applied, at, last.now)
    pushed = pushed_forces(chain, own.forces, last.now, loads, carrier)
    # Eq. (D23)
    if is_exact:
        acceleration = -solve_coupled(chain.bodies, at, block, by, own.factors, pushed.residual)
    else:
        acceleration = -substitute_chain(own.factors, pushed.residual)
    return PushedMotion(acceleration, change, pushed.on_block)


@compiled
def moved_films(
    of: BodySystem, last: StepEnd, acceleration: np.ndarray, is_exact: bool
) -> MovedFilms:
    """Return the change of motion and films at the end of a step with accelerations (n,).

    `is_exact` as of `pushed_motion`.
    """
    chain, at = of.chain, last.linear.forces.motion
    by = reach_of(last.coefficients, of.kinds)
    moved = Motion(by.position * acceleration, by.velocity * acceleration, acceleration)
    bodies = changes_along(motion_changes(chain.joints, at, by), acceleration)
    rising = bodies.velocity[piston_of(chain), Y, 0]
    place, speed = of_skirt(of, moved.position), of_skirt(of, moved.velocity)
    for k in range(RIGID, len(speed) if not is_exact else RIGID):
        speed[k] = 0.0
    return MovedFilms(
        moved=moved,
        bodies=bodies,
        rising=rising,
        skirt=skirt_changes(of, last.guide_height, rising, place, speed),
        pins=pin_changes(of, at, last.now, moved, bodies),
    )


@compiled
def response(
    of: BodySystem,
    last: StepEnd,
    seeds: StepInputs,
    carrier: BlockMotion,
    lever: float,
) -> Response:
    """Return the change at the end of a step with the forces there and the block's motion.

    Eq. (D20):  dF = F_Q dQ + F_q'' dq''       F of Eq. (D25)

    Parameters
    ----------
    of : BodySystem
    last : StepEnd
    seeds, carrier : StepInputs, BlockMotion
        Directions of forces and of the block's motion.
    lever : float
        dY_0/dphi of Eq. (D70), 0 if nobody reads the moment on the block [m].

    Returns
    -------
    Response
    """
    own, chain = last.linear, of.chain
    pushed = pushed_motion(of, last, seeds, carrier, True)
    films = moved_films(of, last, pushed.acceleration, True)
    on_block = own.on_block @ pushed.acceleration
    for k in range(len(on_block)):
        on_block[k] += pushed.on_block[k]  # Eq. (D20)
    from_walls = np.zeros(2)
    if len(chain.laws.kind) > 0:
        at = own.forces.motion
        from_walls = from_block_changes(chain.elements, own.law_slopes, at, films.bodies)
    if lever != 0.0:
        first = RIGID + len(of.gas_force)
        slopes = skirt_slopes(of, last.guide_height, seeds.skirt.pressure)
        pushed_along = slopes.undeformed + slopes.modal @ of_skirt(of, last.now.position)[first:]
        on_block[TURN] -= lever * pushed_along  # Eq. (D70)
        from_walls[Y] += pushed_along
    return Response(
        film_thickness=films.skirt.film_thickness,
        sliding_velocity=films.skirt.sliding_velocity,
        lateral_velocity=films.moved.velocity[LATERAL],
        rocking_velocity=films.moved.velocity[ROCKING],
        piston_velocity=films.rising,
        pin_film_thickness=films.pins.film_thickness,
        circumferential_velocity=films.pins.sliding_velocity,
        on_block=block_force(pushed.load, from_walls, on_block),
    )
