"""The derivative at the end of a step of a piston on a floating pin."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..geometry.film import NodalForces
from ..geometry.pin import PinForces
from ..mechanism.cylinder import BODY
from ..mechanism.equations import pushed_forces
from ..mechanism.loads import loads_at
from ..mechanism.motion import changes_along, motion_changes
from ..mechanism.solution import solve_coupled
from .bdf2 import reach_of
from .block_force import BlockForce, block_force
from .carrier import Carrier
from .floating_frame import Y
from .generalised_alpha import Motion
from .pin_films import PinSystem, held_forces, pin_changes
from .pin_instant import of_skirt, on_modes
from .piston_motion import LATERAL, RIGID, ROCKING
from .response import Response, StepEnd, load_change
from .skirt_films import Change, forces_by_film, skirt_changes, together
from .system import RingForce


class PinResponse(NamedTuple):
    """Change of the films' geometry and of the motion.

    Parameters
    ----------
    change : Response
        Of piston and skirt.
    film_thickness, circumferential_velocity : ndarray, shape (cells,)
        Of all films of pin and crank, stacked [m], [m/s].
    on_block : BlockForce
    """

    change: Response
    film_thickness: np.ndarray
    circumferential_velocity: np.ndarray
    on_block: BlockForce


@compiled
def respond_pin(
    of: PinSystem,
    last: StepEnd,
    skirt_forces: NodalForces,
    rings: RingForce,
    forces: PinForces,
    carrier: Carrier,
) -> PinResponse:
    """Return the change at the end of a step with the forces there and the block's motion.

    Eq. (D23):  J dq'' = -dr,   dq = c2 dq'',   dq' = c1 dq''       J, r of Eq. (D61)
    Eq. (D20):  dF = F_Q dQ + F_q'' dq''       F of Eq. (D25)

    Parameters
    ----------
    of : PinSystem
    last : StepEnd
    skirt_forces, rings, forces, carrier
        Directions; nodal forces stacked [N].

    Returns
    -------
    PinResponse
    """
    system, chain = of.system, of.chain
    end, guided, own = last.now, last.guided, last.linear
    n = len(end.position)
    skirt = together(forces_by_film(system, guided, skirt_forces))
    change = load_change(system, skirt, rings, on_modes(skirt), carrier)
    at, block = own.forces.motion, own.forces.inertia.carrier
    by = reach_of(last.coefficients, of.kinds)
    loads = loads_at(chain, held_forces(of, change, forces), at, end)
    pushed = pushed_forces(chain, own.forces, end, loads, carrier)
    # Eq. (D23)
    acceleration = solve_coupled(chain.bodies, at, block, by, own.factors, pushed.residual)
    moved = Motion(np.empty(n), np.empty(n), acceleration)
    for k in range(n):
        acceleration[k] = -acceleration[k]
        moved.position[k] = by.position[k] * acceleration[k]
        moved.velocity[k] = by.velocity[k] * acceleration[k]
    bodies = changes_along(motion_changes(chain.joints, at, by), acceleration)
    rising = bodies.velocity[BODY.piston, Y]
    on_block = own.on_block @ acceleration
    for k in range(len(on_block)):
        on_block[k] += pushed.on_block[k]  # Eq. (D20)
    place, speed = of_skirt(of, moved.position), of_skirt(of, moved.velocity)
    first = RIGID + len(skirt.piston)
    piston = Change(place[:first], speed[:first])
    bore = Change(place[first:], speed[first:])
    on_skirt = skirt_changes(system, guided, rising, piston, bore)
    on_pins = pin_changes(of, at, end, moved, bodies)
    return PinResponse(
        Response(
            on_skirt.film_thickness,
            on_skirt.sliding_velocity,
            moved.velocity[LATERAL],
            moved.velocity[ROCKING],
            rising,
            acceleration,
            change,
        ),
        on_pins.film_thickness,
        on_pins.sliding_velocity,
        block_force(change, on_block),
    )
