"""One instant of the whole body side in compiled code: from predicted motion and forces to
accelerations, film and outputs; and its derivative. Nothing is decided here: the equations stand in
`film`, `piston_motion` and `slider_crank`.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.arrays import Matrix, Vector
from ..geometry.film import (
    FilmForces,
    FilmState,
    FilmSurface,
    NodalForces,
    Window,
    film_now,
    generalised,
    opening,
    sliding,
    window_at,
)
from ..geometry.surfaces import count_of, surface_at
from .carrier import FIXED, Carrier, carried
from .elimination import Factors
from .energy import (
    Ledger,
    Moving,
    elastic_energy,
    energy_error,
    film_work,
    motion_product,
    other_forces,
)
from .floating_frame import Arrow, FlexibleBody, mode_coupling
from .gas_on_bore import BoreWall, WallPressures, wall_forces
from .generalised_alpha import Coefficients, Motion, Prediction, predict
from .impact import Inertia, limit_memory
from .modal_damping import ModalSprings
from .pin_friction import friction_moment
from .piston_motion import (
    LATERAL,
    RIGID,
    ROCKING,
    Load,
    end_accelerations,
    imbalance,
    lateral_motion,
    solve_coupled,
    tangent,
)
from .quasi_static import STILL, Ride, StaticModes, static_coordinates
from .slider_crank import CrankMotion, Mechanism, carried_mass, height, motion, rod_turn

ACROSS, ALONG, ABOUT, RESULTANTS = range(4)
"""Generalised forces of a film: lateral, axial, moment; those on modes follow."""


class System(NamedTuple):
    """Both bodies, the mechanism and the geometry of all films.

    Of each body, the modes that move and, after them, those that follow statically. gas_force (k +
    s,) is the modal force of a unit gas force on the crown [kg^-1/2], pin_offset x of A from the
    skirt's axis [m]. All film surfaces are one block (`geometry.surfaces`). Fields of all of them
    are stacked: the cells of the first, (c, a) in C order, then those of the second.
    """

    piston: FlexibleBody
    piston_static: StaticModes
    block: ModalSprings
    block_static: StaticModes
    mechanism: Mechanism
    surfaces: Vector
    pin_offset: float
    gas_force: Vector
    wall: BoreWall


class RingForce(NamedTuple):
    """What the rings do to the piston.

    lateral : float
        Along x, towards the thrust side [N].
    axial : float
        Along y, towards the head, on the bore's axis [N].
    moment : float
        About A, about +z, beside that of `axial` [N m].
    """

    lateral: float
    axial: float
    moment: float


NO_RINGS = RingForce(0.0, 0.0, 0.0)


class OtherForces(NamedTuple):
    """What acts on the piston beside the film and the pin.

    gas : float
        Along -y on the crown [N].
    rings : RingForce
    wall : WallPressures
        Of gas on the bore.
    carrier : Carrier
        Motion of the block.
    """

    gas: float
    rings: RingForce
    wall: WallPressures
    carrier: Carrier = FIXED


class Instant(NamedTuple):
    """Motion, forces and film at an instant.

    Parameters
    ----------
    position, velocity, acceleration : ndarray, shape (n,)
        Of all coordinates: [x_A [m], rocking angle [rad], piston then block modal coordinates
        [kg^1/2 m]], and derivatives in time.
    kept_velocity, kept_acceleration, auxiliary : ndarray, shape (n,)
        What the next step starts from; those of the end but after an impact (Eq. (N7)), and the
        time integrator's auxiliary acceleration.
    impact : bool
        Whether the step was an impact.
    ledger : Ledger
        Energy across the bore.
    other_forces : ndarray, shape (n,)
        All but the film's and the rod's inertia, on the motion across the bore.
    guided : float
        Height at which the bore is read: that of A when x_A = 0 [m].
    load : Load
        On the piston, all but the pin's.
    side_force : float
        Of the piston on the bore through all films [N].
    film_thickness, sliding_velocity : ndarray, shape (cells,)
        Of all surfaces, stacked [m], [m/s].
    piston_position, piston_velocity : float
        Height of A [m] and its velocity [m/s].
    pin_x, pin_y, pin_moment, torque : float
        Pin force on the piston [N], friction of the pin on it [N m], drive torque on the crank
        without its own inertia [N m].
    pin_friction_power : float
        What that friction turns into heat [W].
    work_error : ndarray, shape (surfaces,)
        `work_error` of each film [-].
    evaluations, tangents, change : int, int, float
        As of `piston_motion.Solution`.
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    kept_velocity: np.ndarray
    kept_acceleration: np.ndarray
    auxiliary: np.ndarray
    impact: bool
    ledger: Ledger
    other_forces: np.ndarray
    guided: float
    load: Load
    side_force: float
    film_thickness: np.ndarray
    sliding_velocity: np.ndarray
    piston_position: float
    piston_velocity: float
    pin_x: float
    pin_y: float
    pin_moment: float
    torque: float
    pin_friction_power: float
    work_error: np.ndarray
    evaluations: int
    tangents: int
    change: float


@compiled
def end_of_step(
    system: System,
    c: Coefficients,
    before: Motion,
    auxiliary: np.ndarray,
    crank: CrankMotion,
    others: OtherForces,
    pressure_force: np.ndarray,
    friction_force: np.ndarray,
) -> Instant:
    """One step: accelerations at its end that fulfil the equations of motion with the forces there,
    and everything that follows from them.

    Eq. (D8):  moment about A = (gas - F_y)(pin offset + x_A) + M

    The rings seal against the bore and float in their grooves: the gas, and F_y that the rings rub
    with, act along the bore's axis, wherever the piston stands and however it leans, and A stands
    at pin offset + x_A from it. An even pressure in a land pushes the rings on either side of it
    along that axis with equal and opposite forces, and has no part in it. M is the moment of what
    the rings do across the bore. Rings push a rigid piston: its modes feel the film and the gas on
    the crown alone, those of the block the film and the gas on the wall (Eq. (D18)).

    Parameters
    ----------
    system : System
    c : Coefficients
    before : Motion
        Of all coordinates at the start of the step.
    auxiliary : ndarray, shape (n,)
        Auxiliary acceleration at the start of the step.
    crank : CrankMotion
        At its end.
    others : OtherForces
        At its end.
    pressure_force, friction_force : ndarray, shape (cells,)
        On all film grids at its end, stacked [N].

    Returns
    -------
    Instant
    """
    mechanism = system.mechanism
    n = RIGID + len(system.piston.stiffness)
    predicted = predict(c, before, auxiliary)
    guided = height(mechanism, 0.0, crank.angle)  # the bore is read where A stands when x_A = 0
    guided_velocity = guided.lever * crank.speed
    parts = forces_by_film(system, guided.height, pressure_force, friction_force)
    film_forces = together(system, parts)
    push = _piston_push(system, film_forces, others.gas)
    block_push = film_forces.block + wall_forces(system.wall, guided.height, others.wall)
    rings = others.rings
    guided_force = others.gas - rings.axial
    load = Load(
        lateral=film_forces.lateral + rings.lateral,
        axial=film_forces.axial - guided_force,
        moment=film_forces.moment + system.pin_offset * guided_force + rings.moment,  # Eq. (D8)
        guided=guided_force,
        modal=push[: n - RIGID],
        carrier=others.carrier,
    )
    own = end_accelerations(
        system.piston,
        mechanism,
        load,
        Prediction(predicted.position[:n], predicted.velocity[:n], predicted.auxiliary[:n]),
        before.acceleration[:n],
        crank,
        c.to_velocity,
        c.to_position,
    )
    end = _moving(system, c, predicted, own.acceleration, block_push)
    ride = _frame_ride(mechanism, others.carrier, end, crank)
    _follow_statically(system, c, before.position, end, push, block_push, ride)
    _advance_auxiliary(c, predicted.auxiliary, end.acceleration)
    moving = _moving_bodies(system, 0.0)
    kept = Motion(end.position, end.velocity.copy(), end.acceleration.copy())
    impact = limit_memory(moving.rigid, before, kept, predicted.auxiliary, c.step)

    rod = rod_turn(
        mechanism, end.position[LATERAL], end.velocity[LATERAL], crank.angle, crank.speed
    )
    now = height(mechanism, end.position[LATERAL], crank.angle)
    axial_velocity = now.slope * end.velocity[LATERAL] + now.lever * crank.speed
    thickness = np.empty(len(pressure_force))
    sliding_velocity = np.empty(len(pressure_force))
    transfer_error = np.empty(len(parts))
    on_slopes = 0.0  # axial force of pressure on bores that are not straight
    first = 0
    for k in range(count_of(system.surfaces)):
        surface = surface_at(system.surfaces, k)
        last = first + surface.skirt.gap.size
        film = film_now(
            surface.skirt,
            surface.bore,
            window_of(surface, guided.height),
            _nodal(surface, pressure_force[first:last], friction_force[first:last]),
            axial_velocity,
            guided_velocity,
            end.position,
            end.velocity,
        )
        stack(thickness, first, film.film_thickness)
        stack(sliding_velocity, first, film.sliding_velocity)
        transfer_error[k] = work_error(
            part_of(system, parts, k), film, axial_velocity, guided_velocity, end.velocity
        )
        on_slopes += film.axial_force
        first = last
    with_rod = _moving_bodies(system, carried_mass(mechanism))
    axial_power = film_forces.axial * axial_velocity + on_slopes * guided_velocity
    axial_work = c.step * axial_power
    ledger = Ledger(
        kinetic=motion_product(moving, kept.velocity, kept.velocity) / 2,
        elastic=elastic_energy(moving, end.position),
        film_work=film_work(film_forces, before.position, end.position, axial_work),
        error=energy_error(with_rod, before, kept, end),
        axial_work=axial_work,
        accounted=motion_product(with_rod, kept.velocity, kept.velocity) / 2,
    )
    return Instant(
        position=end.position,
        velocity=end.velocity,
        acceleration=end.acceleration,
        kept_velocity=kept.velocity,
        kept_acceleration=kept.acceleration,
        auxiliary=predicted.auxiliary,
        impact=impact,
        ledger=ledger,
        other_forces=other_forces(with_rod, end.acceleration, film_forces),
        guided=guided.height,
        load=load,
        side_force=-film_forces.lateral,
        film_thickness=thickness,
        sliding_velocity=sliding_velocity,
        piston_position=now.height,
        piston_velocity=axial_velocity,
        pin_x=own.pin_x,
        pin_y=own.pin_y - on_slopes,
        pin_moment=own.pin_moment,
        torque=own.torque - on_slopes * guided.lever,
        pin_friction_power=own.pin_moment * (rod.velocity - end.velocity[ROCKING]),
        work_error=transfer_error,
        evaluations=own.evaluations,
        tangents=own.tangents,
        change=own.change,
    )


@compiled
def _nodal(surface, pressure_force, friction_force):
    """A surface's part of stacked forces, on its grid."""
    shape = surface.skirt.gap.shape
    return NodalForces(pressure_force.reshape(shape), friction_force.reshape(shape))


@compiled
def stack(stacked, first, field):
    """Put a field at its place among those of all surfaces, in a loop."""
    rows, columns = field.shape
    for i in range(rows):
        for j in range(columns):
            stacked[first + i * columns + j] = field[i, j]


@compiled
def window_of(surface: FilmSurface, guided: float) -> Window:
    """Where a surface stands in the bore that is read at a height [m]."""
    return window_at(surface.bore.lowest, surface.bore.spacing, guided, surface.skirt.height)


@compiled
def forces_by_film(
    system: System, guided: float, pressure_force: np.ndarray, friction_force: np.ndarray
) -> np.ndarray:
    """Generalised forces of each film, one row a surface, (s, 3 + k + k'), see `part_of`.

    Parameters
    ----------
    system : System
    guided : float
        Height at which the bore is read [m].
    pressure_force, friction_force : ndarray, shape (cells,)
        Stacked [N].
    """
    modes = len(system.gas_force)
    of_block = len(system.block.stiffness) + len(system.block_static.stiffness)
    films = count_of(system.surfaces)
    parts = np.empty((films, RESULTANTS + modes + of_block))
    first = 0
    for s in range(films):
        surface = surface_at(system.surfaces, s)
        last = first + surface.skirt.gap.size
        nodal = _nodal(surface, pressure_force[first:last], friction_force[first:last])
        part = generalised(surface.skirt, surface.bore, window_of(surface, guided), nodal)
        parts[s, ACROSS] = part.lateral
        parts[s, ALONG] = part.axial
        parts[s, ABOUT] = part.moment
        for k in range(modes):
            parts[s, RESULTANTS + k] = part.piston[k]
        for k in range(of_block):
            parts[s, RESULTANTS + modes + k] = part.block[k]
        first = last
    return parts


@compiled
def part_of(system: System, parts: np.ndarray, s: int) -> FilmForces:
    """Generalised forces of a film, from `forces_by_film`."""
    one = parts[s]
    modes = RESULTANTS + len(system.gas_force)
    return FilmForces(one[ACROSS], one[ALONG], one[ABOUT], one[RESULTANTS:modes], one[modes:])


@compiled
def together(system: System, parts: np.ndarray) -> FilmForces:
    """Generalised forces of all films.

    Eq. (G2):  Q = sum_s Q_s        s the film surfaces of the body: virtual work adds

    Parameters
    ----------
    system : System
    parts : ndarray
        As `forces_by_film` gives them.
    """
    total = np.zeros((1, parts.shape[1]))
    for s in range(len(parts)):
        for k in range(parts.shape[1]):
            total[0, k] += parts[s, k]  # Eq. (G2)
    return part_of(system, total, 0)


@compiled
def _piston_push(system, film_forces, gas):
    """Modal forces of film and gas on the piston, of all its modes."""
    push = film_forces.piston.copy()
    for k in range(len(push)):
        push[k] += gas * system.gas_force[k]
    return push


@compiled
def _moving_bodies(system, carried):
    """What has inertia across the bore; `carried` is the mass that x_A moves beside [kg]."""
    piston = system.piston
    mass = piston.mass + system.mechanism.pin_mass + carried
    rigid = Inertia(mass, piston.S[1], piston.I0)
    first = RIGID + len(piston.stiffness) + len(system.piston_static.stiffness)
    return Moving(piston, rigid, first, system.block.stiffness)


@compiled
def _moving(system, c, predicted, own, block_force):
    """Motion of all coordinates at the end of a step, static modes as if at rest.

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
def _advance_auxiliary(c, auxiliary, acceleration):
    """Add the end accelerations' part to the predicted auxiliary acceleration."""
    for k in range(len(auxiliary)):
        auxiliary[k] += c.to_auxiliary * acceleration[k]


@compiled
def _follow_statically(system, c, position_before, end, push, block_force, ride):
    """Put the static modes of both bodies where their loads at the end of a step hold them.

    `push` and `block_force` are the modal forces on piston and block.
    """
    moving = len(system.piston.stiffness)
    if len(system.piston_static.stiffness):
        q = static_coordinates(system.piston_static, push[moving:], ride)
        _follow(end.position, end.velocity, position_before, q, RIGID + moving, c.step)
    moving = len(system.block.stiffness)
    first = RIGID + len(push) + moving
    q = static_coordinates(system.block_static, block_force[moving:], STILL)
    _follow(end.position, end.velocity, position_before, q, first, c.step)


@compiled
def _frame_ride(mechanism, carrier, now, crank):
    """How the piston's frame moves, as its static modes feel it."""
    lateral = lateral_motion(now)
    axial = motion(mechanism, lateral, crank).axial_acceleration
    added = carried(mechanism, carrier, lateral, crank)
    angle = now.position[ROCKING]
    x, y = in_frame(lateral.acceleration + added.x, axial + added.y, angle)
    spin = now.velocity[ROCKING] + carrier.w
    return Ride(x, y, now.acceleration[ROCKING] + carrier.alpha, spin**2)


@compiled
def work_error(
    forces: FilmForces,
    film: FilmState,
    axial_velocity: float,
    guided_velocity: float,
    velocity: np.ndarray,
) -> float:
    """Power of the interface forces on the grid minus that in the coordinates, by the sum of all
    terms' sizes [-]. Both describe the same work, so that anything above round-off is an error in
    the transfer of forces.

    Parameters
    ----------
    forces : FilmForces
    film : FilmState
    axial_velocity, guided_velocity : float
        Velocity of A, and of the height at which the bore is read [m/s].
    velocity : ndarray, shape (n,)
        Of all coordinates.
    """
    work = forces.axial * axial_velocity + film.axial_force * guided_velocity
    size = abs(forces.axial * axial_velocity) + abs(film.axial_force * guided_velocity)
    size += film.power_size
    first = RIGID + len(forces.piston)
    for k in range(len(velocity)):
        if k == LATERAL:
            force = forces.lateral
        elif k == ROCKING:
            force = forces.moment
        elif k < first:
            force = forces.piston[k - RIGID]
        else:
            force = forces.block[k - first]
        work += force * velocity[k]
        size += abs(force * velocity[k])
    return abs(film.power - work) / size if size > 0.0 else 0.0


@compiled
def in_frame(ax: float, ay: float, angle: float) -> tuple[float, float]:
    """A vector's components in a frame turned by an angle [rad]."""
    c = np.cos(angle)
    s = np.sin(angle)
    return c * ax + s * ay, -s * ax + c * ay


@compiled
def _follow(position, velocity, position_before, q, first, step):
    """Put static modes at their coordinates from `first` on; their velocity is the mean one over
    the step, 0 at the start.
    """
    for k in range(len(q)):
        position[first + k] = q[k]
        velocity[first + k] = (q[k] - position_before[first + k]) / step if step > 0.0 else 0.0


class StepEnd(NamedTuple):
    """What derivatives at the end of a step, and forces on the block, follow from.

    Parameters
    ----------
    coefficients : Coefficients
    guided : float
        Height at which the bore is read [m].
    load : Load
    now : Motion
        Of the piston's moving coordinates, with a floating pin of all.
    crank : CrankMotion
    factors : Factors
        Of the tangent of Eq. (D21) of a floating pin.
    """

    coefficients: Coefficients
    guided: float
    load: Load
    now: Motion
    crank: CrankMotion
    factors: Factors


@compilable
def step_end(
    c: Coefficients, now: Instant, crank: CrankMotion, moving: int, factors: Factors
) -> StepEnd:
    """Return what is kept of a step's end, of so many coordinates."""
    motion = Motion(now.position[:moving], now.velocity[:moving], now.acceleration[:moving])
    return StepEnd(c, now.guided, now.load, motion, crank, factors)


class Linear(NamedTuple):
    """The piston's motion at the end of a step, linearised.

    Parameters
    ----------
    arrow : Arrow
    coupling : ndarray, shape (k, k)
        Together the tangent J (`floating_frame.mode_coupling`).
    slope : float
        dY/dx_A [-].
    axial_velocity_slope : float
        Change of A's velocity along y with x_A [1/s].
    arm : float
        Of A from the bore's axis, pin offset + x_A [m].
    rod_slope : float
        dpsi/dx_A [1/m].
    friction_x, friction_y : float
        Change of the pin's friction moment with the pin force [m].
    x_by_lateral, y_by_lateral : float
        Change of A's acceleration in the body frame with x_A'' [-].
    x_by_rocking, y_by_rocking, spin_by_rocking : float
        Change of the same [m] and of w^2 [-] with the angular acceleration.
    step, to_velocity, to_position : float
        As of `Coefficients`.
    """

    arrow: Arrow
    coupling: Matrix
    slope: float
    axial_velocity_slope: float
    arm: float
    rod_slope: float
    friction_x: float
    friction_y: float
    x_by_lateral: float
    y_by_lateral: float
    x_by_rocking: float
    y_by_rocking: float
    spin_by_rocking: float
    step: float
    to_velocity: float
    to_position: float


@compiled
def linearise(system: System, last: StepEnd) -> Linear:
    """Return the piston's motion linearised about the end of a step."""
    piston = system.piston
    mechanism = system.mechanism
    load, now, crank = last.load, last.now, last.crank
    c1 = last.coefficients.to_velocity
    c2 = last.coefficients.to_position
    lateral = lateral_motion(now)
    angle = now.position[ROCKING]
    slip = now.velocity[ROCKING]
    w = slip + load.carrier.w
    pin = imbalance(piston, mechanism, load, now, crank)
    rod = rod_turn(mechanism, lateral.position, lateral.velocity, crank.angle, crank.speed)
    friction = friction_moment(mechanism.friction, pin.pin_x, pin.pin_y, slip - rod.velocity)
    link = motion(mechanism, lateral, crank)
    added = carried(mechanism, load.carrier, lateral, crank)
    across = lateral.acceleration + added.x
    ax, ay = in_frame(across, link.axial_acceleration + added.y, angle)
    alpha = now.acceleration[ROCKING] + load.carrier.alpha
    axial = link.axial_by_acceleration + c1 * link.axial_by_velocity + c2 * link.axial_by_position
    x, y = in_frame(1.0, axial, angle)
    return Linear(
        arrow=tangent(piston, mechanism, load, now, crank, c1, c2),
        coupling=mode_coupling(piston, alpha, w, c1, c2),
        slope=link.slope,
        axial_velocity_slope=link.axial_by_velocity / 2,
        arm=system.pin_offset + lateral.position,
        rod_slope=rod.slope,
        friction_x=friction.by_x,
        friction_y=friction.by_y,
        x_by_lateral=x,
        y_by_lateral=y,
        x_by_rocking=c2 * ay,
        y_by_rocking=-c2 * ax,
        spin_by_rocking=2 * w * c1,
        step=last.coefficients.step,
        to_velocity=c1,
        to_position=c2,
    )


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
    lateral, axial, moment : float
        Of films and rings on the piston, the moment about A [N], [N m].
    """

    film_thickness: np.ndarray
    sliding_velocity: np.ndarray
    lateral_velocity: float
    rocking_velocity: float
    piston_velocity: float
    acceleration: np.ndarray
    lateral: float
    axial: float
    moment: float


class Change(NamedTuple):
    """Changes of coordinates and their velocities at the end of a step, shape (k,)."""

    position: np.ndarray
    velocity: np.ndarray


@compiled
def response(
    system: System,
    guided: float,
    linear: Linear,
    pressure_force: np.ndarray,
    friction_force: np.ndarray,
    rings: RingForce,
    carried_force: np.ndarray,
) -> Response:
    """Change of film and motion at the end of a step with the forces at its end.

    Eq. (D7):  J d(acceleration) = dQ
               d(position) = c2 d(acceleration),  d(velocity) = c1 d(acceleration)
               static modes by Eq. (D6)

    Parameters
    ----------
    system : System
    guided : float
        Height at which the bore is read [m].
    linear : Linear
    pressure_force, friction_force : ndarray, shape (cells,)
        Direction, stacked [N].
    rings : RingForce
        Direction.
    carried_force : ndarray, shape (2 + k,)
        What else changes dQ: the block's motion.

    Returns
    -------
    Response
    """
    parts = forces_by_film(system, guided, pressure_force, friction_force)
    film_forces = together(system, parts)
    acceleration = solve_coupled(  # Eq. (D7)
        linear.arrow, linear.coupling, _right_side(linear, film_forces, rings, carried_force)
    )
    lateral = acceleration[LATERAL]
    axial_slope = (
        linear.to_velocity * linear.slope + linear.to_position * linear.axial_velocity_slope
    )
    piston = _piston_change(system, linear, acceleration, film_forces.piston)
    block = _block_change(system, linear, film_forces.block)
    thickness = np.empty(len(pressure_force))
    sliding_velocity = np.empty(len(pressure_force))
    first = 0
    for s in range(count_of(system.surfaces)):
        surface = surface_at(system.surfaces, s)
        window = window_of(surface, guided)
        opened = opening(
            surface.skirt,
            surface.bore,
            window,
            piston.position[LATERAL],
            piston.position[ROCKING],
            piston.position[RIGID:],
            block.position,
        )
        slid = sliding(
            surface.skirt,
            surface.bore,
            window,
            axial_slope * lateral,
            piston.velocity[ROCKING],
            piston.velocity[RIGID:],
            block.velocity,
        )
        stack(thickness, first, opened)
        stack(sliding_velocity, first, slid)
        first += surface.skirt.gap.size
    return Response(
        thickness,
        sliding_velocity,
        piston.velocity[LATERAL],
        piston.velocity[ROCKING],
        axial_slope * lateral,
        acceleration,
        film_forces.lateral + rings.lateral,
        film_forces.axial + rings.axial,
        film_forces.moment + rings.moment - rings.axial * system.pin_offset,
    )


@compiled
def _right_side(linear, forces, rings, carried_force):
    """dQ of Eq. (D7) on the piston's moving coordinates: the pin carries what film and rings do
    not; and what the block's motion adds.
    """
    lateral = forces.lateral + rings.lateral
    axial = forces.axial + rings.axial
    moment = forces.moment + rings.moment - rings.axial * linear.arm  # Eq. (D8)
    rubbing = -linear.friction_x * lateral - linear.friction_y * axial
    modes = len(linear.arrow.diagonal)
    right = np.empty(RIGID + modes)
    right[LATERAL] = lateral + linear.slope * axial - linear.rod_slope * rubbing
    right[ROCKING] = moment + rubbing
    for k in range(modes):
        right[RIGID + k] = forces.piston[k]
    for k in range(len(right)):
        right[k] += carried_force[k]
    return right


@compiled
def _piston_change(system, linear, acceleration, force):
    """Changes of the piston's coordinates, static modes included, with those of its accelerations
    and modal forces.
    """
    moving = len(system.piston.stiffness)
    out = _changes(linear, acceleration, RIGID + len(force))
    ride = ridden(linear, acceleration[LATERAL], acceleration[ROCKING])
    q = static_coordinates(system.piston_static, force[moving:], ride)
    before = np.zeros(len(out.position))
    _follow(out.position, out.velocity, before, q, RIGID + moving, linear.step)
    return out


@compiled
def _block_change(system, linear, force):
    """Changes of the block's coordinates, static modes included, with those of its modal forces."""
    block = system.block
    moving = len(block.stiffness)
    acceleration = np.empty(moving)
    for k in range(moving):
        damper = linear.to_velocity * block.damping[k]
        spring = linear.to_position * block.stiffness[k]
        inertia = 1 + damper + spring
        acceleration[k] = force[k] / inertia
    out = _changes(linear, acceleration, len(force))
    q = static_coordinates(system.block_static, force[moving:], STILL)
    _follow(out.position, out.velocity, np.zeros(len(out.position)), q, moving, linear.step)
    return out


@compiled
def ridden(linear: Linear, lateral: float, rocking: float) -> Ride:
    """Change of the frame's motion with changes of x_A'' [m/s2] and of the angular acceleration
    [rad/s2].
    """
    x = linear.x_by_lateral * lateral + linear.x_by_rocking * rocking
    y = linear.y_by_lateral * lateral + linear.y_by_rocking * rocking
    return Ride(x, y, rocking, linear.spin_by_rocking * rocking)


@compiled
def _changes(linear, acceleration, size):
    """Changes of positions and velocities at the end of a step with changes of accelerations there;
    zeros up to `size`.
    """
    out = Change(np.zeros(size), np.zeros(size))
    for k in range(len(acceleration)):
        out.position[k] = linear.to_position * acceleration[k]
        out.velocity[k] = linear.to_velocity * acceleration[k]
    return out
