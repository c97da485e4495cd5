"""The derivative at the end of a step of a piston on a floating pin."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..geometry.film import NodalForces
from ..geometry.pin import PinForces
from ..mechanism.cylinder import BODY
from ..mechanism.equations import load_rows
from ..mechanism.loads import loads_at
from ..mechanism.motion import chain_motion, changes_along, motion_changes
from ..mechanism.solution import solve_coupled
from .bdf2 import reach_of
from .carrier import FIXED
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
    """

    change: Response
    film_thickness: np.ndarray
    circumferential_velocity: np.ndarray


@compiled
def respond_pin(
    of: PinSystem,
    last: StepEnd,
    skirt_forces: NodalForces,
    rings: RingForce,
    forces: PinForces,
) -> PinResponse:
    """Return the change of films and motion at the end of a step with the forces there.

    Eq. (D23):  J dq'' = -dr,   dq = c2 dq'',   dq' = c1 dq''       J, r of Eq. (D61)

    Parameters
    ----------
    of : PinSystem
    last : StepEnd
    skirt_forces, rings, forces
        Directions; nodal forces stacked [N].

    Returns
    -------
    PinResponse
    """
    system, chain = of.system, of.chain
    end, guided, carrier = last.now, last.guided, last.load.carrier
    n = len(end.position)
    skirt = together(forces_by_film(system, guided, skirt_forces))
    change = load_change(system, skirt, rings, on_modes(skirt), FIXED)
    at = chain_motion(chain.joints, end, last.crank)
    by = reach_of(last.coefficients, of.kinds)
    right = load_rows(chain, loads_at(chain, held_forces(of, change, forces), at, end), at)
    # Eq. (D23)
    acceleration = solve_coupled(chain.bodies, at, carrier, by, last.factors, right)
    moved = Motion(np.empty(n), np.empty(n), acceleration)
    for k in range(n):
        acceleration[k] = -acceleration[k]
        moved.position[k] = by.position[k] * acceleration[k]
        moved.velocity[k] = by.velocity[k] * acceleration[k]
    bodies = changes_along(motion_changes(chain.joints, at, by), acceleration)
    rising = bodies.velocity[BODY.piston, Y]
    place, speed = of_skirt(of, moved.position), of_skirt(of, moved.velocity)
    first = RIGID + len(skirt.piston)
    piston = Change(place[:first], speed[:first])
    block = Change(place[first:], speed[first:])
    on_skirt = skirt_changes(system, guided, rising, piston, block)
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
    )
