"""End of a step of the bodies: from predicted motion and forces to accelerations and outputs.

The equations are in `film` and `mechanism.equations`.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.film import (
    FilmForces,
    NodalForces,
)
from ..mechanism.equations import friction_at
from ..mechanism.inertia import frame_state
from ..mechanism.motion import increments_of
from ..mechanism.solution import solve_motion
from ..mechanism.tied_pin import PISTON, ROD, loads_of
from .block_force import BlockForce, block_force
from .energy import (
    EnergyLedger,
    Momenta,
    MovingBodies,
    elastic_energy,
    energy_ledger,
    mean_acceleration,
    momentum,
    other_forces,
)
from .floating_frame import TURN, X, Y
from .gas_on_bore import wall_forces
from .generalised_alpha import Motion, Prediction, predict
from .impact import Inertia, limit_memory, longest_step
from .piston_motion import RIGID, Load
from .quasi_static import STILL, FrameAcceleration, follow, static_coordinates
from .skirt_films import (
    AxialMotion,
    SkirtFilms,
    by_coordinate,
    forces_by_film,
    skirt_films,
    together,
)
from .slider_crank import carried_mass, height
from .system import BodySystem, OtherForces, StepProblem


class Instant(NamedTuple):
    """Motion, forces and film at an instant.

    Parameters
    ----------
    end : Motion
        Of all coordinates: [x_A [m], rocking angle [rad], piston then block modal coordinates
        [kg^1/2 m]], and derivatives in time.
    kept : Motion
        What the next step starts from: `end` except after an impact (Eq. (N7)).
    auxiliary : ndarray, shape (n,)
        The time integrator's auxiliary acceleration.
    ledger : EnergyLedger
        Energy across the bore.
    other_forces : ndarray, shape (n,)
        All but the film's and the rod's inertia, on the motion across the bore.
    next_other_forces : ndarray, shape (n,)
        The same with the acceleration of `kept`: what acts at the start of the next step.
    guided : float
        Height at which the bore is read: that of A when x_A = 0 [m].
    load : Load
        On the piston, all but the pin's.
    side_force : float
        Of the piston on the bore through all films [N].
    films : SkirtFilms
    axial : AxialMotion
        Of A.
    pin_x, pin_y, pin_moment, torque : float
        Pin force on the piston [N], friction of the pin on it [N m], drive torque on the crank
        without its own inertia [N m].
    pin_friction_power : float
        What that friction turns into heat [W].
    evaluations, tangents, change : int, int, float
        As of `mechanism.solution.ChainSolution`.
    longest_step : float
        Eq. (N12) [s].
    """

    end: Motion
    kept: Motion
    auxiliary: np.ndarray
    ledger: EnergyLedger
    other_forces: np.ndarray
    next_other_forces: np.ndarray
    guided: float
    load: Load
    side_force: float
    films: SkirtFilms
    axial: AxialMotion
    pin_x: float
    pin_y: float
    pin_moment: float
    torque: float
    pin_friction_power: float
    evaluations: int
    tangents: int
    change: float
    longest_step: float


@compiled
def end_of_step(
    system: BodySystem,
    step: StepProblem,
    forces: NodalForces,
) -> tuple[Instant, BlockForce]:
    """Solve the equations of motion at the end of a step, with the forces there.

    Parameters
    ----------
    system : BodySystem
    step : StepProblem
    forces : NodalForces
        On all film grids at its end, stacked [N].

    Returns
    -------
    Instant, BlockForce
    """
    c, before, auxiliary, _, crank, others = step
    mechanism = system.mechanism
    n = RIGID + len(system.piston.stiffness)
    predicted = predict(c, before, auxiliary)
    upright = height(mechanism, 0.0, crank.angle)
    guided = AxialMotion(upright.height, upright.lever * crank.speed)
    parts = forces_by_film(system, guided.height, forces)
    film_forces = together(parts)
    push = with_gas(system, film_forces.piston, others.gas)
    block_push = film_forces.block + wall_forces(system.wall, guided.height, others.wall)
    load = load_of(system, film_forces, others, push[: n - RIGID])
    own = solve_motion(
        system.chain,
        loads_of(load),
        Prediction(predicted.position[:n], predicted.velocity[:n], predicted.auxiliary[:n]),
        before.acceleration[:n],
        increments_of(c, n),
        crank,
        others.carrier,
    )
    at = own.forces.motion
    end = _moving(system, c, predicted, own.now.acceleration, block_push)
    frame = frame_state(own.forces.inertia.frames, PISTON)
    ride = FrameAcceleration(frame.ax, frame.ay, frame.alpha, frame.w**2)
    _follow_statically(system, c, before.position, end, push, block_push, ride)
    for k in range(len(end.acceleration)):
        predicted.auxiliary[k] += c.to_auxiliary * end.acceleration[k]
    moving = _moving_bodies(system, 0.0)
    kept = Motion(end.position, end.velocity.copy(), end.acceleration.copy())
    longest = longest_step(
        moving.rigid, before, kept, predicted.auxiliary, c.step, system.resolution
    )
    limit_memory(moving.rigid, before, kept, predicted.auxiliary, c.step)

    axial = AxialMotion(at.position[PISTON, Y], at.velocity[PISTON, Y])
    films = skirt_films(system, guided, forces, parts, axial.velocity, end.position, end.velocity)
    with_rod = _moving_bodies(system, carried_mass(mechanism))
    axial_power = film_forces.axial * axial.velocity + films.on_slopes * guided.velocity
    by_film = by_coordinate(film_forces)
    momenta = Momenta(
        momentum(with_rod, before.velocity),
        momentum(with_rod, kept.velocity),
        momentum(with_rod, mean_acceleration(before, end)),
        momentum(moving, kept.velocity),
    )
    elastic = elastic_energy(moving, end.position)
    pin = own.forces.joints
    rubbing = friction_at(system.chain.joints, at, pin, PISTON).moment
    instant = Instant(
        end=end,
        kept=kept,
        auxiliary=predicted.auxiliary,
        ledger=energy_ledger(before, kept, end, momenta, by_film, c.step * axial_power, elastic),
        other_forces=other_forces(momentum(with_rod, end.acceleration), by_film),
        next_other_forces=other_forces(momentum(with_rod, kept.acceleration), by_film),
        guided=guided.height,
        load=load,
        side_force=-film_forces.lateral,
        films=films,
        axial=axial,
        pin_x=pin[PISTON, X],
        pin_y=pin[PISTON, Y] - films.on_slopes,
        pin_moment=rubbing,
        torque=own.forces.torque - films.on_slopes * upright.lever,
        pin_friction_power=rubbing * (at.velocity[ROD, TURN] - at.velocity[PISTON, TURN]),
        evaluations=own.evaluations,
        tangents=own.tangents,
        change=own.change,
        longest_step=longest,
    )
    return instant, block_force(load, own.forces.on_block)


@compilable
def load_of(system: BodySystem, films: FilmForces, others: OtherForces, modal: np.ndarray) -> Load:
    """Return the load on the piston, all but the pin's; `modal` on the modes with inertia.

    Eq. (D8):  moment about A = (gas - F_y)(pin offset + x_A) + M

    The rings seal against the bore and float in their grooves: the gas, and F_y that the rings rub
    with, act along the bore's axis, wherever the piston stands and however it leans, and A stands
    at pin offset + x_A from it. An even pressure in a land pushes the rings on either side of it
    along that axis with equal and opposite forces, and has no part in it. M is the moment of what
    the rings do across the bore. Rings push a rigid piston: its modes feel the film and the gas on
    the crown alone, those of the block the film and the gas on the wall (Eq. (D18)).
    """
    rings = others.rings
    guided = others.gas - rings.axial
    return Load(
        films.lateral + rings.lateral,
        films.axial - guided,
        films.moment + system.pin_offset * guided + rings.moment,  # Eq. (D8)
        guided,
        modal,
        others.carrier,
    )


@compiled
def with_gas(system: BodySystem, on_modes: np.ndarray, gas: float) -> np.ndarray:
    """Return the forces on all modes of the piston with that of the gas on the crown [N]."""
    push = on_modes.copy()
    for k in range(len(push)):
        push[k] += gas * system.gas_force[k]
    return push


@compiled
def rigid_piston(system: BodySystem, carried: float) -> Inertia:
    """Return the inertia of piston and pin with the mass that x_A moves beside them [kg]."""
    piston = system.piston
    return Inertia(piston.mass + system.mechanism.pin_mass + carried, piston.S[1], piston.I0)


@compiled
def _moving_bodies(system, carried):
    """Return what has inertia across the bore; `carried` as of `rigid_piston`."""
    piston = system.piston
    first = RIGID + len(piston.stiffness) + len(system.piston_static.stiffness)
    return MovingBodies(piston, rigid_piston(system, carried), first, system.block.stiffness)


@compiled
def _moving(system, c, predicted, own, block_force):
    """Return the motion of all coordinates at the end of a step, static modes at rest.

    `own` are the accelerations of the piston's moving part.
    """
    block = system.block
    n = len(predicted.position)
    first = n - len(block_force)
    end = Motion(np.empty(n), np.empty(n), np.zeros(n))
    for k in range(len(own)):
        end.acceleration[k] = own[k]
    for k in range(len(block.stiffness)):
        resistance = block.damping[k] * predicted.velocity[first + k]
        spring = block.stiffness[k] * predicted.position[first + k]
        inertia = 1 + c.to_velocity * block.damping[k] + c.to_position * block.stiffness[k]
        end.acceleration[first + k] = (block_force[k] - resistance - spring) / inertia
    for k in range(n):
        end.position[k] = predicted.position[k] + c.to_position * end.acceleration[k]
        end.velocity[k] = predicted.velocity[k] + c.to_velocity * end.acceleration[k]
    return end


@compiled
def _follow_statically(system, c, position_before, end, push, block_force, ride):
    """Put the static modes of both bodies where their loads at the end of a step hold them.

    `push` and `block_force` are the modal forces on piston and block.
    """
    moving = len(system.piston.stiffness)
    if len(system.piston_static.stiffness):
        q = static_coordinates(system.piston_static, push[moving:], ride)
        follow(end.position, end.velocity, position_before, q, RIGID + moving, c.step)
    moving = len(system.block.stiffness)
    first = RIGID + len(push) + moving
    q = static_coordinates(system.block_static, block_force[moving:], STILL)
    follow(end.position, end.velocity, position_before, q, first, c.step)
