"""End of a step of a piston on a floating pin, the counterpart of `instant`.

The equations are in `film`, `pin`, `floating_pin` and `slider_crank`.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.film import NodalForces
from ..geometry.pin import PinForces, diameters, yielded
from ..geometry.pin_shapes import AxisShapes
from ..geometry.surfaces import pin_surface_at, pins_of
from .bdf2 import Reach, auxiliary_after, limit_plays, predicted_of, reach_of
from .block_force import BlockForce, all_on_block
from .carrier import FIXED
from .elimination import LUFactors, factorise, substitute
from .energy import Momenta, energy_ledger, mean_acceleration, other_forces
from .floating_pin import (
    PinFilms,
    PinImbalance,
    generalised_forces,
    imbalance,
    on_rod,
)
from .generalised_alpha import Motion, Prediction
from .impact import limit_memory
from .instant import Instant, load_of, rigid_piston, with_gas
from .pin_coordinates import (
    PIN,
    Layout,
    _of_skirt,
    eye_motion,
    layout,
    lifted,
    of_shapes,
    play_at,
)
from .pin_films import OnModes, PinSystem, films_at, on_modes_of, pin_films, total
from .pin_inertia import elastic_energy
from .pin_shells import EYE, _big_end, shell_modes_of
from .pin_tangent import tangent
from .piston_motion import LATERAL, Load
from .skirt_films import AxialMotion, forces_by_film, skirt_films, together
from .slider_crank import CrankMotion, height
from .system import StepProblem

PASSES = 30
"""Most iterations of Newton's method; its tangent is exact, three are usual."""


class PinSolution(NamedTuple):
    """Accelerations that fulfil Eq. (D21), and what goes with them.

    Parameters
    ----------
    end : Motion
    films : PinFilms
    lack : PinImbalance
    factors : LUFactors
        Of the tangent there.
    evaluations : int
        0 where the equations were not solved.
    change : float
        Of accelerations, in the last pass [m/s2, rad/s2].
    """

    end: Motion
    films: PinFilms
    lack: PinImbalance
    factors: LUFactors
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
    factors : LUFactors
        Of the tangent of Eq. (D21), for derivatives.
    on_block : BlockForce
    """

    now: Instant
    film_thickness: np.ndarray
    circumferential_velocity: np.ndarray
    work_error: np.ndarray
    scalars: PinScalars
    factors: LUFactors
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
    reach: Reach,
    load: Load,
    crank: CrankMotion,
    forces: PinForces,
    by: OnModes,
) -> PinSolution:
    """Solve Eq. (D21) for the accelerations at the end of a step, by Newton's method.

    The iteration starts from zero accelerations and from those at the beginning of the step.
    """
    bodies = of.bodies
    first = layout(bodies)
    mechanism = bodies.mechanism
    n = len(begun)
    end = Motion(np.empty(n), np.empty(n), begun.copy())
    change = np.inf
    evaluations = 0
    for evaluation in range(1, PASSES + 1):
        for k in range(n):
            end.position[k] = predicted.position[k] + reach.position[k] * end.acceleration[k]
            end.velocity[k] = predicted.velocity[k] + reach.velocity[k] * end.acceleration[k]
        films = films_at(of.surfaces, mechanism, first, forces, end, crank, by)
        lack = imbalance(bodies, load, end, crank, films)
        slope = tangent(bodies, load, end, films, lack, reach.velocity, reach.position)
        factors = factorise(slope)
        step = substitute(factors, lack.residual)
        size = largest(end.acceleration)
        left = largest(step)
        # what grows again, or does not fall by ten, is round-off of forces that cancel
        ends = left <= 1e-13 * size or (change <= 1e-7 * size and left >= 0.1 * change)
        change = left
        if ends:
            evaluations = evaluation
            break
        for k in range(n):
            end.acceleration[k] -= step[k]
    return PinSolution(end, films, lack, factors, evaluations, change)


@compilable
def product(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return the product of a symmetric matrix and a vector, by loops: the same bits everywhere."""
    n = len(vector)
    out = np.zeros(n)
    for j in range(n):
        for i in range(n):
            out[i] += matrix[j, i] * vector[j]
    return out


@compilable
def _widened(surfaces, first, position, k):
    """Return the changes of diameter of the shell of film k, 0 without this film."""
    if k < 0:
        return 0.0, 0.0
    return diameters(yielded(pin_surface_at(surfaces, k), shell_modes_of(first, position, k)))


@compilable
def pin_scalars(
    shapes: AxisShapes, surfaces: np.ndarray, first: Layout, now: Motion, films: PinFilms
) -> PinScalars:
    """Return the scalar outputs at an instant; `surfaces` are those of `PinSystem`."""
    position = now.position
    tilt = np.zeros(2)
    sag = np.zeros(2)
    bent = of_shapes(first, position)
    for k in range(len(bent)):
        for way in range(2):
            tilt[way] += shapes.slope[k] * bent[k, way]
            sag[way] += shapes.sag[k] * bent[k, way]
    wider = _widened(surfaces, first, position, EYE)
    big_end = _widened(surfaces, first, position, _big_end(first))
    last = pins_of(surfaces) - 1
    main = _widened(surfaces, first, position, last if first.main_bearing >= 0 else -1)
    crank_pin = play_at(first.big_end, position)
    journal = play_at(first.main_bearing, position)
    return PinScalars(
        pin_displacement_x=position[PIN.boss_x],
        pin_displacement_y=position[PIN.boss_y],
        small_end_displacement_x=position[PIN.eye_x],
        small_end_displacement_y=position[PIN.eye_y],
        pin_angle=position[PIN.spin],
        pin_rotation_speed=now.velocity[PIN.spin],
        small_end_force_x=-films.eye.force[0],
        small_end_force_y=-films.eye.force[1],
        small_end_friction_moment=films.eye.on_shell,
        pin_tilt_x=tilt[0],
        pin_tilt_y=tilt[1],
        pin_bending_x=sag[0],
        pin_bending_y=sag[1],
        small_end_widening_across=wider[0],
        small_end_widening_along=wider[1],
        big_end_displacement_x=crank_pin[0],
        big_end_displacement_y=crank_pin[1],
        big_end_force_x=-films.big_end.force[0],
        big_end_force_y=-films.big_end.force[1],
        big_end_friction_moment=films.big_end.on_shell,
        big_end_widening_across=big_end[0],
        big_end_widening_along=big_end[1],
        main_bearing_displacement_x=journal[0],
        main_bearing_displacement_y=journal[1],
        main_bearing_force_x=-films.main_bearing.force[0],
        main_bearing_force_y=-films.main_bearing.force[1],
        main_bearing_friction_moment=films.main_bearing.on_shell,
        main_bearing_widening_x=main[0],
        main_bearing_widening_y=main[1],
    )


@compilable
def _axial_motion(mechanism, first, end, crank):
    """Return the motion of A along the bore."""
    eye = eye_motion(first, end)
    now = height(mechanism, eye.position, crank.angle)
    velocity = now.slope * eye.velocity + now.lever * crank.speed
    return AxialMotion(
        now.height + lifted(first, end.position), velocity + lifted(first, end.velocity)
    )


@compilable
def _block_force(mechanism, first, load, end, axial, films, lack):
    """Return the forces on the block.

    Eq. (D54):  F_b of Eq. (D25) with N - m_r G_x'' - m_c m_x'' - U u_x'' and
                -T - m_r G_y'' - m_c m_y'' - U u_y'' of Eq. (D21), or -O of a film;
                M of Eq. (D25) + its moment on the main bearing
    """
    x, y = lack.on_bearings
    if first.main_bearing >= 0:
        x, y = -films.main_bearing.force[0], -films.main_bearing.force[1]
    lateral = end.position[LATERAL]
    on = all_on_block(load, lateral, mechanism.offset + lateral, axial.height, x, y)
    moment = on.moment_on_block + films.main_bearing.on_shell
    # Eq. (D54)
    return BlockForce(on.force_on_block_x, on.force_on_block_y, moment, x, y)


@compiled
def end_of_pin_step(
    of: PinSystem, step: StepProblem, skirt_forces: NodalForces, forces: PinForces
) -> PinInstant:
    """Solve the end of a step, as `instant.end_of_step`: accelerations that fulfil Eq. (D21).

    Parameters
    ----------
    of : PinSystem
    step : StepProblem
        Of 7 + k + 2 n coordinates.
    skirt_forces : NodalForces
        On all film grids of the skirt at its end, stacked [N].
    forces : PinForces
        On all those of pin and crank, stacked [N].

    Returns
    -------
    PinInstant
    """
    c, before, auxiliary, mean_velocity, crank, others = step
    system = of.system
    bodies = of.bodies
    mechanism = system.mechanism
    upright = height(mechanism, 0.0, crank.angle)
    guided = AxialMotion(upright.height, upright.lever * crank.speed)
    parts = forces_by_film(system, guided.height, skirt_forces)
    skirt = together(parts)
    at = layout(bodies)
    by = on_modes_of(of.surfaces, at, forces)
    on_modes = total(skirt.piston, by.on_piston)
    modal = with_gas(system, on_modes, others.gas)
    load = load_of(system, skirt, others, modal)
    predicted = predicted_of(c, before, auxiliary, mean_velocity)
    reach = reach_of(c, len(before.position))
    found = solved(of, predicted, before.acceleration, reach, load, crank, forces, by)
    end = found.end
    carried = auxiliary_after(c, predicted, before, end)
    kept = Motion(end.position, end.velocity.copy(), end.acceleration.copy())
    limit_memory(rigid_piston(system, 0.0), before, kept, carried, c.step)
    limit_plays(at, before, kept, carried, c.step)

    axial = _axial_motion(mechanism, at, end, crank)
    on_skirt = skirt_films(
        system,
        guided,
        skirt_forces,
        parts,
        axial.velocity,
        _of_skirt(at, end.position),
        _of_skirt(at, end.velocity),
    )
    on_pins = pin_films(of, forces, end, crank)
    films = found.films
    driven = skirt.axial * axial.velocity + on_skirt.on_slopes * guided.velocity
    driven += on_rod(films) * on_pins.rod_turning  # and on what the crank drives
    driven += (films.big_end.on_pin + films.main_bearing.on_pin) * crank.speed
    pushes = Load(skirt.lateral, skirt.axial, skirt.moment, 0.0, on_modes, FIXED)
    all_forces = generalised_forces(at, films, pushes)
    momenta = Momenta(
        product(of.with_rod, before.velocity),
        product(of.with_rod, kept.velocity),
        product(of.with_rod, mean_acceleration(before, end)),
        product(of.inertia, kept.velocity),
    )
    elastic = elastic_energy(bodies, kept.position)
    return PinInstant(
        Instant(
            end=end,
            kept=kept,
            auxiliary=carried,
            ledger=energy_ledger(before, kept, end, momenta, all_forces, c.step * driven, elastic),
            other_forces=other_forces(product(of.with_rod, end.acceleration), all_forces),
            next_other_forces=other_forces(product(of.with_rod, kept.acceleration), all_forces),
            guided=guided.height,
            load=load,
            side_force=-skirt.lateral,
            films=on_skirt,
            axial=axial,
            pin_x=found.lack.on_piston[0],
            pin_y=found.lack.on_piston[1] - on_skirt.on_slopes,
            pin_moment=films.bosses.on_shell,
            torque=found.lack.torque - on_skirt.on_slopes * upright.lever,
            pin_friction_power=on_pins.friction_power,
            evaluations=found.evaluations,
            tangents=found.evaluations,
            change=found.change,
        ),
        on_pins.film_thickness,
        on_pins.circumferential_velocity,
        on_pins.work_error,
        pin_scalars(bodies.shapes, of.surfaces, at, kept, films),
        found.factors,
        _block_force(mechanism, at, load, end, axial, films, found.lack),
    )
