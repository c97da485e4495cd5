"""The derivative at the end of a step of a piston on a floating pin."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..geometry.film import NodalForces
from ..geometry.pin import PinForces
from .bdf2 import reach_of
from .carrier import FIXED
from .elimination import substitute
from .floating_pin import pushed
from .generalised_alpha import Motion
from .pin_coordinates import _of_skirt, eye_motion, layout, lifted
from .pin_films import PinSystem, films_at, on_modes_of, pin_changes, total
from .piston_motion import LATERAL, ROCKING, Load
from .response import Response, StepEnd, load_change
from .skirt_films import Change, forces_by_film, skirt_changes, together
from .slider_crank import motion
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

    Eq. (D23):  J dq'' = -dr,   dq = c2 dq'',   dq' = c1 dq''       J, r of Eq. (D21)

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
    system = of.system
    bodies = of.bodies
    end = last.now
    crank = last.crank
    guided = last.guided
    n = len(end.position)
    skirt = together(forces_by_film(system, guided, skirt_forces))
    at = layout(bodies)
    mechanism = bodies.mechanism
    by = on_modes_of(of.surfaces, at, forces)
    films = films_at(of.surfaces, mechanism, at, forces, end, crank, by)
    change = load_change(system, skirt, rings, total(skirt.piston, by.on_piston), FIXED)
    moment = change.moment + change.guided * end.position[LATERAL]
    changes = Load(change.lateral, change.axial, moment, 0.0, change.modal, FIXED)
    link = motion(mechanism, eye_motion(at, end), crank)
    right = pushed(at, link, films, changes)
    # Eq. (D23)
    acceleration = substitute(last.factors, right)
    reach = reach_of(last.coefficients, n)
    moved = Motion(np.empty(n), np.empty(n), acceleration)
    for k in range(n):
        acceleration[k] = -acceleration[k]
        moved.position[k] = reach.position[k] * acceleration[k]
        moved.velocity[k] = reach.velocity[k] * acceleration[k]
    eye = eye_motion(at, moved)
    rising = link.slope * eye.velocity + link.axial_by_velocity / 2 * eye.position
    rising += lifted(at, moved.velocity)
    none = np.zeros(0)
    bent = Change(_of_skirt(at, moved.position), _of_skirt(at, moved.velocity))
    on_skirt = skirt_changes(system, guided, rising, bent, Change(none, none))
    on_pins = pin_changes(of, end, moved, crank)
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
