"""End of a step of a piston on a floating pin, the counterpart of `instant`.

The equations are in `film`, `pin` and `mechanism`.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.film import FilmForces, NodalForces
from ..geometry.pin import PinForces, diameters, yielded
from ..geometry.surfaces import pin_surface_at
from ..mechanism.chain import Chain, Loads
from ..mechanism.cylinder import BODY, EYE, PIN, film_of
from ..mechanism.equations import chain_derivative, forces_at
from ..mechanism.loads import MOMENT, REACTION, HeldForces, loads_at
from ..mechanism.motion import Increments, chain_motion
from ..mechanism.solution import (
    Linearisation,
    arrow_product,
    factorise_chain,
    solve_coupled,
)
from .bdf2 import STATIC, auxiliary_after, limit_plays, predicted_of, reach_of
from .block_force import BlockForce, block_force
from .carrier import Carrier
from .energy import Momenta, energy_ledger, mean_acceleration, other_forces
from .floating_frame import X, Y
from .gas_on_bore import wall_forces
from .generalised_alpha import Motion, Prediction
from .impact import limit_memory, longest_step
from .instant import Instant, load_of, rigid_piston
from .pin_films import PinSystem, held_forces, pin_films
from .pin_shells import play_at, shapes_of, shell_modes_of
from .piston_motion import LATERAL, RIGID, ROCKING
from .skirt_films import AxialMotion, forces_by_film, skirt_films, together
from .slider_crank import CrankMotion, height
from .system import BodySystem, OtherForces, StepProblem

PASSES = 30
"""Most iterations of Newton's method; its tangent is exact, three are usual."""


class PinSolution(NamedTuple):
    """Motion that fulfils Eq. (D61), and what goes with it.

    Parameters
    ----------
    end : Motion
    loads : Loads
    linear : Linearisation
    evaluations : int
        0 where the equations were not solved.
    change : float
        Of the unknowns, in the last pass [m/s2, rad/s2].
    """

    end: Motion
    loads: Loads
    linear: Linearisation
    evaluations: int
    change: float


def _both(name, unit, description, nominal):
    """Return an output along x and one along y: name, unit, description, nominal value."""
    return [(f"{name}_{axis}", unit, f"{description} along {axis}", nominal) for axis in "xy"]


def _displacement(name, what):
    return _both(f"{name}_displacement", "m", f"Displacement of {what}", 1e-5)


def _force(name, what):
    moment = f"{name}_friction_moment", "N.m", f"Friction moment of {what} about +z", 0.1
    return [*_both(f"{name}_force", "N", f"Force of {what}", 1e3), moment]


BENDING = "Displacement of the floating pin at mid-length from the mean of both ends"
WIDENING = "Change of the diameter of the {} at mid-length, {}"


def _widening(name, directions):
    what = name.replace("_", " ")
    return [
        (f"{name}_widening_{way}", "m", WIDENING.format(what, text), 1e-5)
        for way, text in directions.items()
    ]


BY_ROD = {"across": "across the rod", "along": "along the rod"}
PIN_OUTPUTS = (
    *_displacement("pin", "the pin axis from the axis of the bosses"),
    *_displacement("small_end", "the pin axis from the axis of the small end"),
    ("pin_angle", "rad", "Rotation angle of the pin about +z", 1.0),
    ("pin_rotation_speed", "rad/s", "Angular velocity of the pin about +z", 10.0),
    *_force("small_end", "the pin on the rod"),
    ("pin_tilt_x", "rad", "Tilt of the floating pin in its bosses, dx/dz", 1e-4),
    ("pin_tilt_y", "rad", "Tilt of the floating pin in its bosses, dy/dz", 1e-4),
    *_both("pin_bending", "m", BENDING, 1e-5),
    *_widening("small_end", BY_ROD),
    *_displacement("big_end", "the crank pin from the middle of the rod's big end"),
    *_force("big_end", "the crank pin on the rod"),
    *_widening("big_end", BY_ROD),
    *_displacement("main_bearing", "the main journal from the middle of the main bearing"),
    *_force("main_bearing", "the main journal on the block"),
    *_widening("main_bearing", {"x": "along x", "y": "along y"}),
)
"""Scalar outputs of pin, eye and crank: name, unit, description, nominal value."""

DECLARED = [(name, Annotated[float, *row]) for name, *row in PIN_OUTPUTS]
PinScalars = NamedTuple("PinScalars", DECLARED)
"""Their values, as `drive.Scalars`; 0 if their part is absent."""


class PinInstant(NamedTuple):
    """An instant of a piston on a floating pin.

    Parameters
    ----------
    now : Instant
        Of piston and skirt.
    film_thickness, circumferential_velocity : ndarray, shape (cells,)
        Of all films of pin and crank, stacked [m], [m/s] (Eq. (H7)).
    work_error : ndarray, shape (films,)
        Power of each film on its grid minus that in the coordinates, relative [-].
    scalars : PinScalars
    linear : Linearisation
        For derivatives.
    on_block : BlockForce
    """

    now: Instant
    film_thickness: np.ndarray
    circumferential_velocity: np.ndarray
    work_error: np.ndarray
    scalars: PinScalars
    linear: Linearisation
    on_block: BlockForce


# ---- a step


@compilable
def largest(values: np.ndarray) -> float:
    """Return the largest absolute value, nan if there is one."""
    found = 0.0
    for k in range(len(values)):
        if np.isnan(values[k]):
            return np.nan
        found = max(found, abs(values[k]))
    return found


@compilable
def solved(
    of: PinSystem,
    predicted: Prediction,
    begun: np.ndarray,
    by: Increments,
    held: HeldForces,
    carrier: Carrier,
    crank: CrankMotion,
) -> PinSolution:
    """Solve Eq. (D61) for the unknowns at the end of a step, by Newton's method.

    The iteration starts from the accelerations at the beginning of the step.
    """
    chain = of.chain
    n = len(begun)
    unknown = begun.copy()
    end = Motion(np.empty(n), np.empty(n), np.empty(n))
    change = np.inf
    evaluations = 0
    for evaluation in range(1, PASSES + 1):
        for k in range(n):
            end.position[k] = predicted.position[k] + by.position[k] * unknown[k]
            end.velocity[k] = predicted.velocity[k] + by.velocity[k] * unknown[k]
            end.acceleration[k] = by.acceleration[k] * unknown[k]
        at = chain_motion(chain.joints, end, crank)
        loads = loads_at(chain, held, at, end)
        forces = forces_at(chain, loads, at, end, carrier)
        derivative = chain_derivative(chain, loads, end, forces, by)
        factors = factorise_chain(derivative.arrow)
        step = solve_coupled(chain.bodies, at, carrier, by, factors, forces.residual)
        size = largest(unknown)
        left = largest(step)
        # what grows again, or does not fall by ten, is round-off of forces that cancel
        ends = left <= 1e-13 * size or (change <= 1e-7 * size and left >= 0.1 * change)
        change = left
        if ends:
            evaluations = evaluation
            break
        for k in range(n):
            unknown[k] -= step[k]
    linear = Linearisation(forces, factors, derivative.on_block)
    return PinSolution(end, loads, linear, evaluations, change)


@compilable
def _wrench_of(loads, e):
    """Return the force and the moments of film e, zeros without this film."""
    return loads.wrench[e] if e >= 0 else np.zeros(loads.wrench.shape[1])


@compilable
def _widened(of, position, e):
    """Return the changes of diameter of the shell of film e, 0 without this film."""
    if e < 0:
        return 0.0, 0.0
    return diameters(
        yielded(pin_surface_at(of.surfaces, e), shell_modes_of(of.chain.elements, position, e))
    )


@compilable
def pin_scalars(of: PinSystem, now: Motion, loads: Loads) -> PinScalars:
    """Return the scalar outputs at an instant."""
    position, play = now.position, of.chain.joints.play
    tilt = np.zeros(2)
    sag = np.zeros(2)
    bent = shapes_of(of.chain.elements, position, EYE)
    for k in range(len(bent)):
        for way in range(2):
            tilt[way] += of.shapes.slope[k] * bent[k, way]
            sag[way] += of.shapes.sag[k] * bent[k, way]
    in_big_end, in_main = film_of(of.chain, BODY.rod), film_of(of.chain, BODY.crank)
    eye, big_end, main_bearing = (
        _wrench_of(loads, EYE),
        _wrench_of(loads, in_big_end),
        _wrench_of(loads, in_main),
    )
    wider = _widened(of, position, EYE)
    wider_end = _widened(of, position, in_big_end)
    wider_main = _widened(of, position, in_main)
    crank_pin = play_at(play[BODY.rod], position)
    journal = play_at(play[BODY.crank], position)
    return PinScalars(
        pin_displacement_x=position[PIN.boss_x],
        pin_displacement_y=position[PIN.boss_y],
        small_end_displacement_x=position[PIN.eye_x],
        small_end_displacement_y=position[PIN.eye_y],
        pin_angle=position[PIN.spin],
        pin_rotation_speed=now.velocity[PIN.spin],
        small_end_force_x=-eye[X],
        small_end_force_y=-eye[Y],
        small_end_friction_moment=eye[REACTION],
        pin_tilt_x=tilt[0],
        pin_tilt_y=tilt[1],
        pin_bending_x=sag[0],
        pin_bending_y=sag[1],
        small_end_widening_across=wider[0],
        small_end_widening_along=wider[1],
        big_end_displacement_x=crank_pin[0],
        big_end_displacement_y=crank_pin[1],
        big_end_force_x=-big_end[X],
        big_end_force_y=-big_end[Y],
        big_end_friction_moment=big_end[REACTION],
        big_end_widening_across=wider_end[0],
        big_end_widening_along=wider_end[1],
        main_bearing_displacement_x=journal[0],
        main_bearing_displacement_y=journal[1],
        main_bearing_force_x=-main_bearing[X],
        main_bearing_force_y=-main_bearing[Y],
        main_bearing_friction_moment=main_bearing[REACTION],
        main_bearing_widening_x=wider_main[0],
        main_bearing_widening_y=wider_main[1],
    )


@compilable
def _on_block(chain, load, loads, on_block):
    """Return the forces on the block, that of a film in the main bearing to its last digit."""
    force = block_force(load, on_block)
    film = film_of(chain, BODY.crank)
    if film < 0:
        return force
    x, y = -loads.wrench[film, X], -loads.wrench[film, Y]
    return BlockForce(force.force_on_block_x, force.force_on_block_y, force.moment_on_block, x, y)


@compilable
def coordinate_forces(chain: Chain, loads: Loads, skirt: FilmForces) -> np.ndarray:
    """Return the generalised forces of all films, but for what they do along the driven motion.

    `loads` are those of films alone, `skirt` those of the skirt.
    """
    elements, angle = chain.elements, chain.joints.angle
    m = chain.joints.tip.shape[1]
    out = np.zeros(m + len(loads.modal))
    out[LATERAL], out[ROCKING] = skirt.lateral, skirt.moment
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
def elastic_energy(of: PinSystem, position: np.ndarray) -> float:
    """Return the energy of all modes that have inertia [J]."""
    chain = of.chain
    m = chain.joints.tip.shape[1]
    total = 0.0
    for k in range(len(chain.bodies.stiffness)):
        if of.kinds[m + k] != STATIC:
            total += chain.bodies.stiffness[k] * position[m + k] ** 2 / 2
    return total


@compilable
def _ledger(of, before, kept, end, by_films, driven):
    """Return the energies at the end of a step; `driven` is the work along the driven motion."""
    momenta = Momenta(
        arrow_product(of.with_rod, before.velocity),
        arrow_product(of.with_rod, kept.velocity),
        arrow_product(of.with_rod, mean_acceleration(before, end)),
        arrow_product(of.inertia, kept.velocity),
    )
    elastic = elastic_energy(of, kept.position)
    return energy_ledger(before, kept, end, momenta, by_films, driven, elastic)


@compiled
def end_of_pin_step(
    of: PinSystem, step: StepProblem, skirt_forces: NodalForces, forces: PinForces
) -> PinInstant:
    """Solve the end of a step, as `instant.end_of_step`: accelerations that fulfil Eq. (D61).

    Parameters
    ----------
    of : PinSystem
    step : StepProblem
        Of the coordinates of `cylinder`.
    skirt_forces : NodalForces
        On all film grids of the skirt at its end, stacked [N].
    forces : PinForces
        On all those of pin and crank, stacked [N].

    Returns
    -------
    PinInstant
    """
    c, before, auxiliary, mean_velocity, crank, others = step
    system, chain = of.system, of.chain
    upright = height(system.mechanism, 0.0, crank.angle)
    guided = AxialMotion(upright.height, upright.lever * crank.speed)
    parts = forces_by_film(system, guided.height, skirt_forces)
    skirt = together(parts)
    load = load_of(system, skirt, others, on_modes(skirt))
    held = held_forces(of, load, forces)
    by_gas = gas_on_modes(system, guided.height, others)
    for k in range(len(by_gas)):
        held.modal[k] += by_gas[k]
    predicted = predicted_of(c, before, auxiliary, mean_velocity, of.kinds)
    by = reach_of(c, of.kinds)
    solution = solved(of, predicted, before.acceleration, by, held, others.carrier, crank)
    end, loads, at = solution.end, solution.loads, solution.linear.forces.motion
    carried = auxiliary_after(c, predicted, before, end, of.kinds)
    kept = Motion(end.position, end.velocity.copy(), end.acceleration.copy())
    piston = rigid_piston(system, 0.0)
    longest = longest_step(piston, before, kept, carried, c.step, system.resolution)
    limit_memory(piston, before, kept, carried, c.step)
    limit_plays(chain.joints.play, before, kept, carried, c.step)

    axial = AxialMotion(at.position[BODY.piston, Y], at.velocity[BODY.piston, Y])
    on_skirt = skirt_films(
        system,
        guided,
        skirt_forces,
        parts,
        axial.velocity,
        of_skirt(of, end.position),
        of_skirt(of, end.velocity),
    )
    on_pins = pin_films(of, forces, loads, at, end)
    driven = skirt.axial * axial.velocity + on_skirt.on_slopes * guided.velocity + on_pins.driven
    for k in range(len(by_gas)):
        loads.modal[k] -= by_gas[k]
    push = coordinate_forces(chain, loads, skirt)
    on_pin = np.zeros(loads.wrench.shape[1])
    for e in range(EYE):
        for k in range(len(on_pin)):
            on_pin[k] += loads.wrench[e, k]
    return PinInstant(
        Instant(
            end=end,
            kept=kept,
            auxiliary=carried,
            ledger=_ledger(of, before, kept, end, push, c.step * driven),
            other_forces=other_forces(arrow_product(of.with_rod, end.acceleration), push),
            next_other_forces=other_forces(arrow_product(of.with_rod, kept.acceleration), push),
            guided=guided.height,
            load=load,
            side_force=-skirt.lateral,
            films=on_skirt,
            axial=axial,
            pin_x=-on_pin[X],
            pin_y=-on_pin[Y] - on_skirt.on_slopes,
            pin_moment=on_pin[REACTION],
            torque=solution.linear.forces.torque - on_skirt.on_slopes * upright.lever,
            pin_friction_power=on_pins.friction_power,
            evaluations=solution.evaluations,
            tangents=solution.evaluations,
            change=solution.change,
            longest_step=longest,
        ),
        on_pins.film_thickness,
        on_pins.circumferential_velocity,
        on_pins.work_error,
        pin_scalars(of, kept, loads),
        solution.linear,
        _on_block(chain, load, loads, solution.linear.forces.on_block),
    )


@compilable
def on_modes(skirt: FilmForces) -> np.ndarray:
    """Return the forces of the skirt's films on the modes of piston and block [kg^-1/2 N]."""
    first = len(skirt.piston)
    out = np.empty(first + len(skirt.block))
    for k in range(first):
        out[k] = skirt.piston[k]
    for k in range(len(skirt.block)):
        out[first + k] = skirt.block[k]
    return out


@compilable
def gas_on_modes(system: BodySystem, guided: float, others: OtherForces) -> np.ndarray:
    """Return the forces of gas on the modes of piston and block [kg^-1/2 N].

    `guided` is the height at which the bore is read [m].
    """
    first = len(system.gas_force)
    wall = wall_forces(system.wall, guided, others.wall)
    out = np.empty(first + len(wall))
    for k in range(first):
        out[k] = others.gas * system.gas_force[k]
    for k in range(len(wall)):
        out[first + k] = wall[k]
    return out


@compilable
def of_skirt(of: PinSystem, coordinates: np.ndarray) -> np.ndarray:
    """Return the coordinates of the skirt's films: x_A, rocking angle, modes of piston, block."""
    first = of.chain.joints.tip.shape[1]
    modes = len(of.system.gas_force) + of.system.wall.above.shape[1]
    out = np.empty(RIGID + modes)
    for k in range(RIGID):
        out[k] = coordinates[k]
    for k in range(modes):
        out[RIGID + k] = coordinates[first + k]
    return out
