"""End of a step of the bodies: from predicted motion and forces to accelerations and outputs.

The equations are in `film`, `pin` and `mechanism.equations`.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.film import FilmForces, NodalForces
from ..geometry.pin import PinForces
from ..mechanism.bdf2 import STATIC, auxiliary_after, limit_plays, predicted_of, reach_of
from ..mechanism.chain import BLOCK, MOMENT, REACTION, Chain, Loads
from ..mechanism.cylinder import BODY, EYE, film_of, floats, piston_of
from ..mechanism.equations import friction_at
from ..mechanism.floating_frame import TURN, X, Y
from ..mechanism.generalised_alpha import Motion
from ..mechanism.impact import limit_memory, longest_step
from ..mechanism.laws import between, from_block, law_power
from ..mechanism.piston_motion import LATERAL, RIGID, ROCKING, Load
from ..mechanism.slider_crank import height
from ..mechanism.solution import Linearisation, solve_motion
from .block_force import BlockForce, block_force
from .energy import EnergyLedger, energy_ledger, other_forces
from .gas_on_bore import wall_forces
from .pin_films import applied_forces, film_pushes, pin_films
from .pin_outputs import pin_scalars
from .skirt_films import AxialMotion, SkirtFilms, forces_by_film, skirt_films, total_forces
from .system import BodySystem, OtherForces, StepProblem, rigid_piston, skirt_modes


class Instant(NamedTuple):
    """Motion, forces and film at an instant.

    Parameters
    ----------
    end : Motion
        All coordinates in the order of `mechanism.cylinder`, and their time derivatives.
    next_start : Motion
        Start of the next step. It differs from `end` only after an impact (Eq. (N7)).
    auxiliary : ndarray, shape (n,)
        The time integrator's auxiliary acceleration.
    ledger : EnergyLedger
        Energy across the bore.
    other_forces : ndarray, shape (n,)
        All but the film's and the rod's inertia, on the motion across the bore.
    next_other_forces : ndarray, shape (n,)
        The same with the acceleration of `next_start`: what acts at the start of the next step.
    guide_height : float
        Height at which the bore is read: that of A when x_A = 0 [m].
    side_force : float
        Force of the piston on the bore through all films [N].
    films : SkirtFilms
    axial : AxialMotion
        Axial motion of A.
    pin_x, pin_y, pin_moment, torque : float
        Pin force on the piston [N], friction of the pin on it [N m], drive torque on the crank
        without its own inertia [N m].
    pin_friction_power : float
        Heat of that friction [W].
    element_power : float
        Power of the force elements with laws (Eq. (D69)) [W].
    evaluations, tangents, change : int, int, float
        As of `mechanism.solution.ChainSolution`.
    longest_step : float
        Eq. (N12) [s].
    pin_film_thickness, circumferential_velocity : ndarray, shape (pin cells,)
        Fields of all films of pin and crank, stacked [m], [m/s] (Eq. (H7)).
    pin_work_error : ndarray, shape (films,)
        Power of each of them on its grid minus that in the coordinates, relative [-].
    pin_scalars : ndarray
        Values of `pin_outputs.PIN_OUTPUTS`.
    linear : Linearisation
        For derivatives.
    on_block : BlockForce
    """

    end: Motion
    next_start: Motion
    auxiliary: np.ndarray
    ledger: EnergyLedger
    other_forces: np.ndarray
    next_other_forces: np.ndarray
    guide_height: float
    side_force: float
    films: SkirtFilms
    axial: AxialMotion
    pin_x: float
    pin_y: float
    pin_moment: float
    torque: float
    pin_friction_power: float
    element_power: float
    evaluations: int
    tangents: int
    change: float
    longest_step: float
    pin_film_thickness: np.ndarray
    circumferential_velocity: np.ndarray
    pin_work_error: np.ndarray
    pin_scalars: np.ndarray
    linear: Linearisation
    on_block: BlockForce


@compiled
def end_of_step(
    of: BodySystem, step: StepProblem, skirt_forces: NodalForces, forces: PinForces
) -> Instant:
    """Solve the equations of motion at the end of a step, with the forces there.

    Parameters
    ----------
    of : BodySystem
    step : StepProblem
        Problem in the coordinates of `mechanism.cylinder`.
    skirt_forces : NodalForces
        On all film grids of the skirt at its end, stacked [N].
    forces : PinForces
        On all those of pin and crank, stacked [N].

    Returns
    -------
    Instant
    """
    c, before, auxiliary, mean_velocity, crank, others = step
    chain = of.chain
    upright = height(of.mechanism, 0.0, crank.angle)
    guide = AxialMotion(upright.height, upright.lever * crank.speed)
    parts = forces_by_film(of, guide.height, skirt_forces)
    skirt = total_forces(parts)
    load = load_of(of, skirt, others)
    pushes = film_pushes(of, forces)
    applied = applied_forces(of, load, forces, pushes)
    by_gas = gas_on_modes(of, guide.height, others)
    for k in range(len(by_gas)):
        applied.modal[k] += by_gas[k]
    predicted = predicted_of(c, before, auxiliary, mean_velocity, of.kinds)
    by = reach_of(c, of.kinds)
    solution = solve_motion(
        chain, applied, predicted, before.acceleration, by, crank, others.carrier
    )
    end, loads, own = solution.now, solution.loads, solution.linear.forces
    at = own.motion
    carried = auxiliary_after(c, predicted, before, end, of.kinds)
    next_start = Motion(end.position, end.velocity.copy(), end.acceleration.copy())
    piston = rigid_piston(of)
    longest = longest_step(piston, before, next_start, carried, c.step, of.resolution)
    limit_memory(piston, before, next_start, carried, c.step)
    limit_plays(chain.elements.play, before, next_start, carried, c.step)

    last = piston_of(chain)
    axial = AxialMotion(at.position[last, Y], at.velocity[last, Y])
    on_skirt = skirt_films(
        of,
        guide,
        skirt_forces,
        parts,
        axial.velocity,
        of_skirt(of, end.position),
        of_skirt(of, end.velocity),
    )
    on_pins = pin_films(of, forces, pushes, loads, at, end)
    driven = skirt.axial * axial.velocity + on_skirt.on_slopes * guide.velocity + on_pins.driven
    for k in range(len(by_gas)):
        loads.modal[k] -= by_gas[k]
    push = coordinate_forces(chain, loads, skirt)
    on_pin, rubbing_power = _pin_force(of, loads, own, on_pins.friction_power)
    elastic, inertia = elastic_energy(of, next_start.position), (of.inertia, of.with_rod)
    ledger = energy_ledger(before, next_start, end, *inertia, push, c.step * driven, elastic)
    by_laws = 0.0
    if len(chain.laws.kind) > 0:
        by_laws = law_power(chain, at, loads)
    return Instant(
        end=end,
        next_start=next_start,
        auxiliary=carried,
        ledger=ledger,
        other_forces=other_forces(of.with_rod, end.acceleration, push),
        next_other_forces=other_forces(of.with_rod, next_start.acceleration, push),
        guide_height=guide.height,
        side_force=-skirt.push[LATERAL],
        films=on_skirt,
        axial=axial,
        pin_x=on_pin[X],
        pin_y=on_pin[Y] - on_skirt.on_slopes,
        pin_moment=on_pin[TURN],
        torque=own.torque - on_skirt.on_slopes * upright.lever,
        pin_friction_power=rubbing_power,
        element_power=by_laws,
        evaluations=solution.evaluations,
        tangents=solution.tangents,
        change=solution.change,
        longest_step=longest,
        pin_film_thickness=on_pins.film_thickness,
        circumferential_velocity=on_pins.circumferential_velocity,
        pin_work_error=on_pins.work_error,
        pin_scalars=pin_scalars(of, next_start, loads, on_pins.widening, on_skirt.on_slopes),
        linear=solution.linear,
        on_block=_on_block(chain, load, loads, own.on_block, on_skirt.on_slopes, upright.lever),
    )


@compilable
def _pin_force(of, loads, own, film_power):
    """Return force and moment of the pin on the piston, (3,), and the heat of its friction [W]."""
    out = np.zeros(3)
    if floats(of.chain):
        for e in range(EYE):
            out[X] -= loads.wrench[e, X]
            out[Y] -= loads.wrench[e, Y]
            out[TURN] += loads.wrench[e, REACTION]
    last, turning, rubbing = piston_of(of.chain), own.motion.velocity, film_power
    if not floats(of.chain):
        out[X], out[Y] = own.joint_wrench[last, X], own.joint_wrench[last, Y]
        out[TURN] = friction_at(of.chain.joints, own.motion, own.joint_wrench, last).moment
        rubbing = out[TURN] * (turning[BODY.rod, TURN] - turning[last, TURN])
    if len(of.chain.laws.kind) > 0:
        by_laws = between(of.chain, loads, last, of.chain.joints.parent[last])
        out[X] += by_laws[X]
        out[Y] += by_laws[Y]
    return out, rubbing


@compilable
def _on_block(chain, load, loads, on_block, on_slopes, lever):
    """Return the forces on the block, that of a film in the main bearing to its last digit.

    Eq. (D70):  M = M_z - F_s dY_0/dphi,   F_by += F_s      M_z of Eq. (D25), F_s of Eq. (H24)

    The bore is read at Y_0(phi). F_s therefore turns the crank against the block, and all joints
    from piston to block pass it on.
    """
    from_walls = from_block(chain, loads) if len(chain.laws.kind) > 0 else np.zeros(2)
    from_walls[Y] += on_slopes
    force = block_force(load, from_walls, on_block)
    x, y = force.main_bearing_force_x, force.main_bearing_force_y
    film = film_of(chain, BLOCK)
    if film >= 0:
        x, y = -loads.wrench[film, X], on_slopes - loads.wrench[film, Y]
    moment = force.moment_on_block - on_slopes * lever  # Eq. (D70)
    return BlockForce(force.force_on_block_x, force.force_on_block_y, moment, x, y)


@compilable
def coordinate_forces(chain: Chain, loads: Loads, skirt: FilmForces) -> np.ndarray:
    """Return the generalised forces of all films, but for what they do along the driven motion.

    `loads` are those of films alone, `skirt` those of the skirt.
    """
    elements, angle = chain.elements, chain.joints.angle
    m = chain.joints.tip.shape[1]
    out = np.zeros(m + len(loads.modal))
    out[LATERAL], out[ROCKING] = skirt.push[LATERAL], skirt.push[ROCKING]
    for e in range(len(elements.acts)):
        wrench, play = loads.wrench[e], elements.play[e]
        if play < 0:
            continue
        out[play] += wrench[X]
        out[play + 1] += wrench[Y]
        if angle[elements.acts[e]] >= 0:
            out[angle[elements.acts[e]]] += wrench[MOMENT]
        if elements.reacts[e] >= 0 and angle[elements.reacts[e]] >= 0:
            out[angle[elements.reacts[e]]] += wrench[REACTION]
    for k in range(len(loads.modal)):
        out[m + k] = loads.modal[k]
    return out


@compilable
def elastic_energy(of: BodySystem, position: np.ndarray) -> float:
    """Return the energy of all modes that have inertia [J]."""
    chain = of.chain
    m = chain.joints.tip.shape[1]
    total = 0.0
    for k in range(len(chain.bodies.stiffness)):
        if of.kinds[m + k] != STATIC:
            total += chain.bodies.stiffness[k] * position[m + k] ** 2 / 2
    return total


@compilable
def load_of(system: BodySystem, films: FilmForces, others: OtherForces) -> Load:
    """Return the load on the piston except that of the pin, and the load of films on modes.

    Eq. (D8):  moment about A = (gas - F_y)(pin offset + x_A) + M

    The rings seal against the bore and float in their grooves. So the gas and the friction F_y of
    the rings act along the bore's axis at any position and angle of the piston. A is at pin offset
    + x_A from this axis. An even pressure in a land pushes the rings on either side of it along the
    axis with equal and opposite forces, whose sum is 0. M is the moment of the forces of the rings
    across the bore. Rings do not load the modes. The film and the gas on the crown load those of
    the piston, and the film and the gas on the wall those of the block (Eq. (D18)).
    """
    rings = others.rings
    axis_force = others.gas - rings.axial
    return Load(
        films.push[LATERAL] + rings.lateral,
        films.axial - axis_force,
        films.push[ROCKING] + system.pin_offset * axis_force + rings.moment,  # Eq. (D8)
        axis_force,
        films.push[RIGID:],
    )


@compilable
def gas_on_modes(system: BodySystem, guide_height: float, others: OtherForces) -> np.ndarray:
    """Return the forces of gas on the modes of piston and block [kg^-1/2 N].

    `guide_height` is the height at which the bore is read [m].
    """
    wall = wall_forces(system.wall, guide_height, others.wall)
    return np.concatenate((others.gas * system.gas_force, wall))


@compilable
def of_skirt(of: BodySystem, coordinates: np.ndarray) -> np.ndarray:
    """Return the coordinates of the skirt's films: x_A, rocking angle, modes of piston, block."""
    first, modes = of.chain.joints.tip.shape[1], skirt_modes(of)
    return np.concatenate((coordinates[:RIGID], coordinates[first : first + modes]))


@compilable
def slides_at(of: BodySystem, coordinates: np.ndarray, count: int) -> np.ndarray:
    """Return the last coordinates of joints, those of `BuildOptions.slides`."""
    last = of.chain.joints.tip.shape[1]
    return coordinates[last - count : last]


@compilable
def of_bearings(of: BodySystem, coordinates: np.ndarray) -> np.ndarray:
    """Return the coordinates of pin, crank and their shells."""
    first, modes = of.chain.joints.tip.shape[1], skirt_modes(of)
    return np.concatenate((coordinates[RIGID:first], coordinates[first + modes :]))
