"""One instant of a piston on a floating pin, as `instant` has it of a tied one: from predicted
motion and forces to accelerations, films and outputs; and its derivative. Nothing is decided here:
the equations stand in `film`, `pin`, `floating_pin` and `slider_crank`.

Films of pin and crank stand in the order of `PIN_SURFACES` and `CRANK_SURFACES`; their fields are
stacked, as the skirt's are.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ..geometry.film import FilmForces, NodalForces
from ..geometry.pin import (
    PIN_SURFACES,
    Bent,
    PinForces,
    PinResultants,
    PinSurface,
    Yielding,
    across,
    axes_of,
    diameters,
    in_axes,
    leaning,
    modal_push,
    opening_of,
    pair,
    power_on_grid,
    resultants_on,
    slope_push,
    turned,
    with_slopes,
    yielded,
)
from ..geometry.pin_shapes import AxisShapes
from ..geometry.surfaces import pin_surface_at, pins_of
from .elimination import Factors, factorise, substitute
from .energy import Ledger
from .floating_pin import (
    BOSS_X,
    BOSS_Y,
    EYE_X,
    EYE_Y,
    SPIN,
    Bodies,
    Lack,
    Layout,
    PinFilms,
    Pushes,
    elastic_energy,
    eye_motion,
    imbalance,
    is_held,
    layout,
    of_eye,
    of_modes,
    of_shapes,
    on_rod,
    play_at,
    pushed,
    shift_of,
    tangent,
)
from .generalised_alpha import Coefficients, Motion, predict
from .impact import Inertia, limit_memory
from .instant import Instant, load_of
from .piston_motion import LATERAL, RIGID, ROCKING, Load
from .response import Response, StepEnd
from .skirt_films import (
    Change,
    FilmChange,
    Guided,
    forces_by_film,
    skirt_changes,
    skirt_films,
    stack,
    together,
)
from .slider_crank import CrankMotion, Mechanism, height, motion, rod_turn
from .system import OtherForces, RingForce, System

PASSES = 30
"""Most iterations of Newton's method; its tangent is exact, three are usual."""

EYE = PIN_SURFACES.index("small_end")
"""Number of the eye's film; those of the bosses come before it, those of the crank after."""


class PinSystem(NamedTuple):
    """Bodies and films of a piston on a floating pin.

    Parameters
    ----------
    system : System
        The same with the pin tied, no mode of it static, the block rigid.
    bodies : Bodies
    surfaces : ndarray
        Films of pin and crank, a block of `geometry.pin_surfaces`.
    inertia, with_rod : ndarray, shape (n, n)
        `floating_pin.inertia` and `inertia_with_rod`.
    """

    system: System
    bodies: Bodies
    surfaces: np.ndarray
    inertia: np.ndarray
    with_rod: np.ndarray


class Shell(NamedTuple):
    """Where the pin, or a journal of the crank, stands in a shell, and how both turn.

    Parameters
    ----------
    axes : ndarray, shape (2, 2)
        R(chi), by the angle that the shell has turned.
    place, velocity : ndarray, shape (2,)
        Of the pin's axis from the shell's, in space [m], [m/s].
    own_turning, turning : float
        chi' of the shell, phi' - chi' of the pin in it [rad/s].
    bent : Bent
        Of the pin, in space; no shapes of a journal of the crank, which stays parallel.
    """

    axes: np.ndarray
    place: np.ndarray
    velocity: np.ndarray
    own_turning: float
    turning: float
    bent: Bent

    def own_place(self) -> np.ndarray:
        """d of Eq. (H6) [m]."""
        return in_axes(self.axes, self.place)


class Solved(NamedTuple):
    """Accelerations that fulfil Eq. (D21), and what goes with them.

    Parameters
    ----------
    end : Motion
    films : PinFilms
    lack : Lack
    factors : Factors
        Of the tangent there.
    evaluations : int
        0 where the equations were not solved.
    change : float
        Of accelerations, in the last pass [m/s2, rad/s2].
    """

    end: Motion
    films: PinFilms
    lack: Lack
    factors: Factors
    evaluations: int
    change: float


class PinScalars(NamedTuple):
    """Scalar outputs of pin, eye and crank, as `variables` names and describes them; 0 of what is
    not there.
    """

    pin_displacement_x: float
    pin_displacement_y: float
    small_end_displacement_x: float
    small_end_displacement_y: float
    pin_angle: float
    pin_rotation_speed: float
    small_end_force_x: float
    small_end_force_y: float
    small_end_friction_moment: float
    pin_tilt_x: float
    pin_tilt_y: float
    pin_bending_x: float
    pin_bending_y: float
    small_end_widening_across: float
    small_end_widening_along: float
    big_end_displacement_x: float
    big_end_displacement_y: float
    big_end_force_x: float
    big_end_force_y: float
    big_end_friction_moment: float
    main_bearing_displacement_x: float
    main_bearing_displacement_y: float
    main_bearing_force_x: float
    main_bearing_force_y: float
    main_bearing_friction_moment: float


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
    factors : Factors
        Of the tangent of Eq. (D21), for derivatives.
    """

    now: Instant
    film_thickness: np.ndarray
    circumferential_velocity: np.ndarray
    work_error: np.ndarray
    scalars: PinScalars
    factors: Factors


# ---- shells


@compilable
def shell_of(mechanism: Mechanism, first: Layout, now: Motion, crank: CrankMotion, k: int) -> Shell:
    """Of the k-th film of pin and crank."""
    position = now.position
    velocity = now.velocity
    if k < EYE:
        return Shell(
            turned(position[ROCKING]),
            pair(position[BOSS_X], position[BOSS_Y]),
            pair(velocity[BOSS_X], velocity[BOSS_Y]),
            velocity[ROCKING],
            velocity[SPIN] - velocity[ROCKING],
            Bent(of_shapes(first, position), of_shapes(first, velocity)),
        )
    eye = eye_motion(first, now)
    rod = rod_turn(mechanism, eye.position, eye.velocity, crank.angle, crank.speed)
    aside = mechanism.offset + eye.position + mechanism.crank_radius * np.sin(crank.angle)
    sine = -aside / mechanism.rod_length  # Eq. (K3)
    axes = axes_of(np.sqrt(1.0 - sine**2), sine)
    if k == EYE:
        return Shell(
            axes,
            pair(position[EYE_X], position[EYE_Y]),
            pair(velocity[EYE_X], velocity[EYE_Y]),
            rod.velocity,
            velocity[SPIN] - rod.velocity,
            Bent(of_shapes(first, position), of_shapes(first, velocity)),
        )
    parallel = Bent(np.zeros((0, 2)), np.zeros((0, 2)))
    if k == _big_end(first):
        at = first.big_end
        place = play_at(at, position)
        moved = play_at(at, velocity)
        turning = crank.speed - rod.velocity
        return Shell(axes, place, moved, rod.velocity, turning, parallel)
    at = first.main_bearing
    upright = axes_of(1.0, 0.0)
    place = play_at(at, position)
    return Shell(upright, place, play_at(at, velocity), 0.0, crank.speed, parallel)


@compilable
def _big_end(first):
    """Number of the big end's film, -1 without it."""
    return EYE + 1 if first.big_end >= 0 else -1


@compilable
def turned_back(shell: Shell, place: np.ndarray, change: np.ndarray, turn: float) -> np.ndarray:
    """Change, in the axes of a shell that turns, of vectors in space, (n, 2): R^T (v' - w Z v)."""
    out = np.empty(place.shape)
    for k in range(len(place)):
        aside = across(place[k])
        moved = pair(change[k, 0] - turn * aside[0], change[k, 1] - turn * aside[1])
        own = in_axes(shell.axes, moved)
        out[k, 0] = own[0]
        out[k, 1] = own[1]
    return out


@compilable
def own_velocity(shell: Shell) -> np.ndarray:
    """d' in the axes of the shell [m/s]."""
    aside = across(shell.place)
    turn = shell.own_turning
    moved = pair(shell.velocity[0] - turn * aside[0], shell.velocity[1] - turn * aside[1])
    return in_axes(shell.axes, moved)


@compilable
def own_bent(shell: Shell) -> Bent:
    """How the pin tilts and bends in the axes of the shell."""
    bent = shell.bent
    still = np.zeros(bent.position.shape)
    return Bent(
        turned_back(shell, still, bent.position, 0.0),
        turned_back(shell, bent.position, bent.velocity, shell.own_turning),
    )


@compilable
def shell_modes_of(first: Layout, coordinates: np.ndarray, k: int) -> np.ndarray:
    """Modal coordinates by which the shell of film k yields."""
    if k < EYE:
        return of_modes(first, coordinates)
    if k == EYE:
        return of_eye(first, coordinates)
    return coordinates[:0]


# ---- forces


@compilable
def on_film(surface: PinSurface, forces: PinForces, first: int) -> PinForces:
    """Return the forces of a film, which begin with `first` of stacked ones."""
    last = first + surface.outward.shape[1] * len(surface.clearance)
    return PinForces(forces.pressure[first:last], forces.circumferential[first:last])


@compilable
def resultants_of(
    surface: PinSurface, forces: PinForces, shell: Shell, modal: np.ndarray
) -> PinResultants:
    """What a film does, its shell yielding by modal coordinates."""
    bent = shell.bent.position
    found = resultants_on(surface, forces, shell.place, shell.axes, bent)
    push = slope_push(surface, forces.pressure)
    moment = 0.0
    for m in range(len(push)):
        moment += push[m] * modal[m]
    return with_slopes(found, moment)


@compilable
def added(one: PinResultants, other: PinResultants) -> PinResultants:
    """Of two films of the same pin."""
    shapes = np.empty(one.on_shapes.shape)
    for k in range(len(shapes)):
        for way in range(2):
            shapes[k, way] = one.on_shapes[k, way] + other.on_shapes[k, way]
    return PinResultants(
        pair(one.force[0] + other.force[0], one.force[1] + other.force[1]),
        one.on_pin + other.on_pin,
        one.on_shell + other.on_shell,
        shapes,
    )


@compilable
def no_film(shapes: int) -> PinResultants:
    """Of a film that is not there."""
    return PinResultants(np.zeros(2), 0.0, 0.0, np.zeros((shapes, 2)))


class OnModes(NamedTuple):
    """Moments on the pin by the slopes of all bosses and of the eye (Eq. (G5)), by modal
    coordinate; forces of the films in bosses on the piston's modes, in the eye on its own
    (Eq. (G6)).
    """

    slope_push: np.ndarray
    eye_slope_push: np.ndarray
    on_piston: np.ndarray
    on_eye: np.ndarray


@compilable
def on_modes_of(surfaces: np.ndarray, first: Layout, forces: PinForces) -> OnModes:
    """What the films do by the modes of their shells; `surfaces` as in `PinSystem`."""
    k = first.shapes - first.modes
    m = first.crank - first.eye
    out = OnModes(np.zeros(k), np.zeros(m), np.zeros(k), np.zeros(m))
    cell = 0
    for film in range(EYE + 1):
        surface = pin_surface_at(surfaces, film)
        own = on_film(surface, forces, cell)
        cell += len(own.pressure)
        slopes = slope_push(surface, own.pressure)
        pushes = modal_push(surface, own)
        for n in range(len(slopes)):
            if film < EYE:
                out.slope_push[n] += slopes[n]
                out.on_piston[n] += pushes[n]
            else:
                out.eye_slope_push[n] += slopes[n]
                out.on_eye[n] += pushes[n]
    return out


@compilable
def films_at(
    surfaces: np.ndarray,
    mechanism: Mechanism,
    first: Layout,
    forces: PinForces,
    now: Motion,
    crank: CrankMotion,
    by: OnModes,
) -> PinFilms:
    """What the films do with their shells where a motion has them; both bosses as one. `surfaces`
    as in `PinSystem`.
    """
    shapes = (first.eye - first.shapes) // 2
    both = no_film(shapes)
    eye = no_film(shapes)
    big_end = no_film(0)
    main_bearing = no_film(0)
    cell = 0
    for k in range(pins_of(surfaces)):
        surface = pin_surface_at(surfaces, k)
        shell = shell_of(mechanism, first, now, crank, k)
        own = on_film(surface, forces, cell)
        cell += len(own.pressure)
        found = resultants_of(surface, own, shell, shell_modes_of(first, now.position, k))
        if k < EYE:
            both = added(both, found)
        elif k == EYE:
            eye = found
        elif k == _big_end(first):
            big_end = found
        else:
            main_bearing = found
    return PinFilms(both, eye, by.slope_push, by.eye_slope_push, by.on_eye, big_end, main_bearing)


@compilable
def _along_crank(films, crank, rod_turning):
    """Power of the films on what the crank drives [W]."""
    on_crank = films.big_end.on_pin + films.main_bearing.on_pin
    return on_rod(films) * rod_turning + on_crank * crank.speed


# ---- a step


class Reach(NamedTuple):
    """What an end acceleration of 1 adds to each coordinate's velocity [s] and position [s2] at the
    end of a step, shape (7 + k + 2 n,).
    """

    velocity: np.ndarray
    position: np.ndarray


@compilable
def reach_of(c: Coefficients, n: int) -> Reach:
    """Of n coordinates in a step (Eq. (N9))."""
    out = Reach(np.empty(n), np.empty(n))
    for k in range(n):
        # Eq. (N9)
        out.velocity[k] = c.step if is_held(k) else c.to_velocity
        out.position[k] = c.step**2 if is_held(k) else c.to_position
    return out


class Predicted(NamedTuple):
    """Where a step ends without accelerations: position, velocity, auxiliary acceleration."""

    position: np.ndarray
    velocity: np.ndarray
    auxiliary: np.ndarray


@compilable
def predicted_of(c: Coefficients, before: Motion, auxiliary: np.ndarray) -> Predicted:
    """Where a step ends without accelerations.

    Eq. (N9):  x_A, rocking angle and phi by Eq. (N2), a, e, b, m, modes and shapes by Eq. (N8)

    Films hold the pin within its play, springs the modes that bend away from it: what inertia
    does there is over within microseconds, and a method that remembers it rings.
    """
    found = predict(c, before, auxiliary)
    for k in range(len(found.position)):
        if is_held(k):
            # Eq. (N9)
            found.position[k] = before.position[k] + c.step * before.velocity[k]
            found.velocity[k] = before.velocity[k]
    return Predicted(found.position, found.velocity, found.auxiliary)


@compilable
def largest(values: np.ndarray) -> float:
    """Of the absolute values; nan where one is."""
    found = 0.0
    for k in range(len(values)):
        if np.isnan(values[k]):
            return np.nan
        found = max(found, abs(values[k]))
    return found


@compilable
def solved(
    of: PinSystem,
    predicted: Predicted,
    begun: np.ndarray,
    reach: Reach,
    load: Load,
    crank: CrankMotion,
    forces: PinForces,
    by: OnModes,
) -> Solved:
    """Accelerations that fulfil Eq. (D21) at the end of a step, by Newton's method, from where
    the step ends without any and from those at its beginning.
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
    return Solved(end, films, lack, factors, evaluations, change)


@compilable
def _of_skirt(first, coordinates):
    """Coordinates of the skirt's film: x_A, rocking angle, modes."""
    modal = of_modes(first, coordinates)
    out = np.empty(RIGID + len(modal))
    for k in range(RIGID):
        out[k] = coordinates[k]
    for k in range(len(modal)):
        out[RIGID + k] = modal[k]
    return out


@compilable
def lifted(first: Layout, coordinates: np.ndarray) -> float:
    """By which play lifts A (Eqs. (K16), (K25)) [m], or its change."""
    return coordinates[EYE_Y] - coordinates[BOSS_Y] + shift_of(first, coordinates)[1]


@compilable
def generalised_forces(
    first: Layout, skirt: FilmForces, films: PinFilms, modal: np.ndarray
) -> np.ndarray:
    """Generalised forces of all films, but for what they do along the driven motion,
    (7 + k + 2 n,); `modal` those on the modes.
    """
    out = np.empty(first.size)
    out[LATERAL] = skirt.lateral
    out[ROCKING] = skirt.moment + films.bosses.on_shell
    out[BOSS_X] = films.bosses.force[0]
    out[BOSS_Y] = films.bosses.force[1]
    out[EYE_X] = films.eye.force[0]
    out[EYE_Y] = films.eye.force[1]
    out[SPIN] = films.bosses.on_pin + films.eye.on_pin
    for k in range(len(modal)):
        out[first.modes + k] = modal[k]
    n = (first.eye - first.shapes) // 2
    for k in range(n):
        for way in range(2):
            push = films.bosses.on_shapes[k, way] + films.eye.on_shapes[k, way]
            out[first.shapes + way * n + k] = push
    for k in range(len(films.on_eye)):
        out[first.eye + k] = films.on_eye[k]
    for way in range(2):
        if first.big_end >= 0:
            out[first.big_end + way] = films.big_end.force[way]
        if first.main_bearing >= 0:
            out[first.main_bearing + way] = films.main_bearing.force[way]
    return out


@compilable
def product(matrix: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Of a symmetric matrix and a vector, in loops: the same bits everywhere."""
    n = len(vector)
    out = np.zeros(n)
    for j in range(n):
        for i in range(n):
            out[i] += matrix[j, i] * vector[j]
    return out


@compilable
def scalar_product(a: np.ndarray, b: np.ndarray) -> float:
    """a . b, in a loop."""
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total


@compilable
def _ledger(of, before, kept, end, forces, driven):
    """Energies as in `energy`, by the inertia of Eqs. (D22), (D35)."""
    n = len(end.position)
    way = np.empty(n)
    mean = np.empty(n)
    for k in range(n):
        way[k] = end.position[k] - before.position[k]
        mean[k] = (before.acceleration[k] + end.acceleration[k]) / 2
    first = scalar_product(before.velocity, product(of.with_rod, before.velocity))
    last = scalar_product(kept.velocity, product(of.with_rod, kept.velocity))
    moving = scalar_product(kept.velocity, product(of.inertia, kept.velocity))
    return Ledger(
        kinetic=moving / 2,
        elastic=elastic_energy(of.bodies, kept.position),
        film_work=scalar_product(forces, way) + driven,  # Eq. (D11)
        error=(last - first) / 2 - scalar_product(way, product(of.with_rod, mean)),  # Eq. (D10)
        axial_work=driven,
        accounted=last / 2,
    )


@compilable
def _work_error(first, surface, forces, shell, end, k):
    """Power of a film on the grid (Eq. (G4)) minus that in the coordinates, relative [-]."""
    modal = shell_modes_of(first, end.position, k)
    modal_velocity = shell_modes_of(first, end.velocity, k)
    found = resultants_of(surface, forces, shell, modal)
    place = in_axes(shell.axes, shell.place)
    on_grid = power_on_grid(
        surface,
        forces,
        place,
        own_velocity(shell),
        shell.turning,
        Yielding(modal, modal_velocity),
        own_bent(shell),
    )
    moving = found.force[0] * shell.velocity[0] + found.force[1] * shell.velocity[1]
    shell_turns = found.on_shell * shell.own_turning
    pin_turns = found.on_pin * (shell.own_turning + shell.turning)
    yields = 0.0
    push = modal_push(surface, forces)
    for m in range(len(push)):
        yields += push[m] * modal_velocity[m]
    bends = 0.0
    for m in range(len(found.on_shapes)):
        for way in range(2):
            bends += found.on_shapes[m, way] * shell.bent.velocity[m, way]
    in_coordinates = moving + shell_turns + yields + bends + pin_turns
    size = on_grid.size + abs(moving) + abs(shell_turns) + abs(yields) + abs(bends) + abs(pin_turns)
    return abs(on_grid.power - in_coordinates) / size if size > 0.0 else 0.0


@compilable
def gap_of(
    first: Layout, surface: PinSurface, shell: Shell, coordinates: np.ndarray, k: int
) -> np.ndarray:
    """Film thickness of film k, (c, a) [m]."""
    gap = opening_of(surface, in_axes(shell.axes, shell.place))
    opened = yielded(surface, shell_modes_of(first, coordinates, k))
    leans = leaning(surface, own_bent(shell).position)
    around, along = gap.shape
    for i in range(around):
        for j in range(along):
            gap[i, j] = surface.clearance[j] + gap[i, j] + opened[i, j] + leans[i, j]
    return gap


@compilable
def pin_scalars(
    shapes: AxisShapes, in_eye: PinSurface, first: Layout, now: Motion, films: PinFilms
) -> PinScalars:
    """Scalar outputs at an instant; `in_eye`: the eye's film, `now`: as it is kept."""
    position = now.position
    tilt = np.zeros(2)
    sag = np.zeros(2)
    bent = of_shapes(first, position)
    for k in range(len(bent)):
        for way in range(2):
            tilt[way] += shapes.slope[k] * bent[k, way]
            sag[way] += shapes.sag[k] * bent[k, way]
    opened = yielded(in_eye, of_eye(first, position))
    wider = diameters(opened)
    crank_pin = play_at(first.big_end, position)
    journal = play_at(first.main_bearing, position)
    return PinScalars(
        pin_displacement_x=position[BOSS_X],
        pin_displacement_y=position[BOSS_Y],
        small_end_displacement_x=position[EYE_X],
        small_end_displacement_y=position[EYE_Y],
        pin_angle=position[SPIN],
        pin_rotation_speed=now.velocity[SPIN],
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
        main_bearing_displacement_x=journal[0],
        main_bearing_displacement_y=journal[1],
        main_bearing_force_x=-films.main_bearing.force[0],
        main_bearing_force_y=-films.main_bearing.force[1],
        main_bearing_friction_moment=films.main_bearing.on_shell,
    )


class PinFilmsNow(NamedTuple):
    """All films of pin and crank at an instant.

    Parameters
    ----------
    film_thickness, circumferential_velocity, work_error
        As of `PinInstant`.
    friction_power : float
        Of the films of the pin [W].
    rod_turning : float
        Angular velocity of the rod [rad/s].
    """

    film_thickness: np.ndarray
    circumferential_velocity: np.ndarray
    work_error: np.ndarray
    friction_power: float
    rod_turning: float


@compilable
def pin_films(of: PinSystem, forces: PinForces, end: Motion, crank: CrankMotion) -> PinFilmsNow:
    """Return all films of pin and crank at an instant."""
    at = layout(of.bodies)
    cells = len(forces.pressure)
    gaps = np.empty(cells)
    around = np.empty(cells)
    errors = np.empty(pins_of(of.surfaces))
    friction_power = 0.0
    rod_turning = 0.0
    first = 0
    for k in range(len(errors)):
        surface = pin_surface_at(of.surfaces, k)
        shell = shell_of(of.bodies.mechanism, at, end, crank, k)
        own = on_film(surface, forces, first)
        last = first + len(own.pressure)
        stack(gaps, first, gap_of(at, surface, shell, end.position, k))
        for cell in range(first, last):
            around[cell] = surface.radius * shell.turning  # Eq. (H7)
        errors[k] = _work_error(at, surface, own, shell, end, k)
        if k <= EYE:
            yields = shell_modes_of(at, end.position, k)
            friction_power -= shell.turning * resultants_of(surface, own, shell, yields).on_pin
        if k == EYE:
            rod_turning = shell.own_turning
        first = last
    return PinFilmsNow(gaps, around, errors, friction_power, rod_turning)


@compiled
def end_of_pin_step(
    of: PinSystem,
    c: Coefficients,
    before: Motion,
    auxiliary: np.ndarray,
    crank: CrankMotion,
    others: OtherForces,
    skirt_forces: NodalForces,
    forces: PinForces,
) -> PinInstant:
    """One step, as `instant.end_of_step`: accelerations at its end that fulfil Eq. (D21) with the
    forces there, and everything that follows from them.

    Parameters
    ----------
    of : PinSystem
    c : Coefficients
    before : Motion
        Of all coordinates at the start of the step, (7 + k + 2 n,).
    auxiliary : ndarray, shape (7 + k + 2 n,)
        Auxiliary acceleration at the start of the step.
    crank : CrankMotion
        At its end.
    others : OtherForces
        At its end.
    skirt_forces : NodalForces
        On all film grids of the skirt at its end, stacked [N].
    forces : PinForces
        On all those of pin and crank, stacked [N].

    Returns
    -------
    PinInstant
    """
    system = of.system
    bodies = of.bodies
    mechanism = system.mechanism
    n = len(before.position)
    upright = height(mechanism, 0.0, crank.angle)
    guided = Guided(upright.height, upright.lever * crank.speed)
    parts = forces_by_film(system, guided.height, skirt_forces)
    skirt = together(parts)
    at = layout(bodies)
    by = on_modes_of(of.surfaces, at, forces)
    on_modes = np.empty(len(by.on_piston))
    modal = np.empty(len(by.on_piston))
    for k in range(len(modal)):
        on_modes[k] = skirt.piston[k] + by.on_piston[k]
        modal[k] = on_modes[k] + others.gas * system.gas_force[k]
    load = load_of(system, skirt, others, modal)
    predicted = predicted_of(c, before, auxiliary)
    reach = reach_of(c, n)
    found = solved(of, predicted, before.acceleration, reach, load, crank, forces, by)
    end = found.end
    carried = predicted.auxiliary
    for k in range(n):
        carried[k] = 0.0 if is_held(k) else carried[k] + c.to_auxiliary * end.acceleration[k]
    kept = Motion(end.position, end.velocity.copy(), end.acceleration.copy())
    piston = bodies.piston
    rigid = Inertia(piston.mass + mechanism.pin_mass, piston.S[1], piston.I0)
    impact = limit_memory(rigid, before, kept, carried, c.step)

    eye = eye_motion(at, end)
    now = height(mechanism, eye.position, crank.angle)
    axial_velocity = now.slope * eye.velocity + now.lever * crank.speed
    axial_velocity += lifted(at, end.velocity)
    on_skirt = skirt_films(
        system,
        guided,
        skirt_forces,
        parts,
        axial_velocity,
        _of_skirt(at, end.position),
        _of_skirt(at, end.velocity),
    )
    on_pins = pin_films(of, forces, end, crank)
    films = found.films
    driven = skirt.axial * axial_velocity + on_skirt.on_slopes * guided.velocity
    driven += _along_crank(films, crank, on_pins.rod_turning)
    all_forces = generalised_forces(at, skirt, films, on_modes)
    others_now = product(of.with_rod, end.acceleration)
    for k in range(n):
        others_now[k] -= all_forces[k]  # Eq. (D15)
    return PinInstant(
        Instant(
            position=end.position,
            velocity=end.velocity,
            acceleration=end.acceleration,
            kept_velocity=kept.velocity,
            kept_acceleration=kept.acceleration,
            auxiliary=carried,
            impact=impact,
            ledger=_ledger(of, before, kept, end, all_forces, c.step * driven),
            other_forces=others_now,
            guided=guided.height,
            load=load,
            side_force=-skirt.lateral,
            film_thickness=on_skirt.film_thickness,
            sliding_velocity=on_skirt.sliding_velocity,
            piston_position=now.height + lifted(at, end.position),
            piston_velocity=axial_velocity,
            pin_x=found.lack.on_piston[0],
            pin_y=found.lack.on_piston[1] - on_skirt.on_slopes,
            pin_moment=films.bosses.on_shell,
            torque=found.lack.torque - on_skirt.on_slopes * upright.lever,
            pin_friction_power=on_pins.friction_power,
            work_error=on_skirt.work_error,
            evaluations=found.evaluations,
            tangents=found.evaluations,
            change=found.change,
        ),
        on_pins.film_thickness,
        on_pins.circumferential_velocity,
        on_pins.work_error,
        pin_scalars(bodies.shapes, pin_surface_at(of.surfaces, EYE), at, kept, films),
        found.factors,
    )


# ---- its derivative


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


class ShellChange(NamedTuple):
    """Change of a pin's place in space (2,) [m], of its shell's angle [rad], and of the speed at
    which it turns in that [rad/s].
    """

    place: np.ndarray
    turn: float
    turning: float


@compilable
def _shell_change(mechanism, first, end, moved, crank, k):
    """Of film k with a change of the motion."""
    place = moved.position
    speed = moved.velocity
    if k < EYE:
        boss = pair(place[BOSS_X], place[BOSS_Y])
        return ShellChange(boss, place[ROCKING], speed[SPIN] - speed[ROCKING])
    now = eye_motion(first, end)
    rod = rod_turn(mechanism, now.position, now.velocity, crank.angle, crank.speed)
    eye = eye_motion(first, moved)
    turn = rod.slope * eye.position
    turning = rod.slope * eye.velocity + rod.velocity_slope * eye.position
    if k == EYE:
        return ShellChange(pair(place[EYE_X], place[EYE_Y]), turn, speed[SPIN] - turning)
    if k == _big_end(first):
        return ShellChange(play_at(first.big_end, place), turn, -turning)
    return ShellChange(play_at(first.main_bearing, place), 0.0, 0.0)


@compilable
def pin_changes(of: PinSystem, end: Motion, moved: Motion, crank: CrankMotion) -> FilmChange:
    """Return the change of all films of pin and crank with a change of the motion."""
    at = layout(of.bodies)
    cells = 0
    for k in range(pins_of(of.surfaces)):
        surface = pin_surface_at(of.surfaces, k)
        cells += surface.outward.shape[1] * len(surface.clearance)
    gaps = np.empty(cells)
    velocities = np.empty(cells)
    first = 0
    for k in range(pins_of(of.surfaces)):
        surface = pin_surface_at(of.surfaces, k)
        shell = shell_of(of.bodies.mechanism, at, end, crank, k)
        by_motion = _shell_change(of.bodies.mechanism, at, end, moved, crank, k)
        aside = across(shell.place)
        turn = by_motion.turn
        way = in_axes(
            shell.axes,
            pair(by_motion.place[0] - turn * aside[0], by_motion.place[1] - turn * aside[1]),
        )
        gap = opening_of(surface, way)
        opened = yielded(surface, shell_modes_of(at, moved.position, k))
        leans = np.zeros(gap.shape)
        if surface.axis.shape[1] > 0:
            more = of_shapes(at, moved.position)
            leans = leaning(surface, turned_back(shell, shell.bent.position, more, turn))
        around, along = gap.shape
        for i in range(around):
            for j in range(along):
                gaps[first + i * along + j] = gap[i, j] + opened[i, j] + leans[i, j]
                velocities[first + i * along + j] = surface.radius * by_motion.turning
        first += gap.size
    return FilmChange(gaps, velocities)


@compiled
def respond_pin(
    of: PinSystem,
    last: StepEnd,
    skirt_forces: NodalForces,
    rings: RingForce,
    forces: PinForces,
) -> PinResponse:
    """Change of films and motion at the end of a step with the forces at its end.

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
    modal = np.empty(len(by.on_piston))
    for k in range(len(modal)):
        modal[k] = skirt.piston[k] + by.on_piston[k]
    arm = system.pin_offset + end.position[LATERAL]
    changes = Pushes(
        skirt.lateral + rings.lateral,
        skirt.axial + rings.axial,
        skirt.moment + rings.moment - rings.axial * arm,  # Eq. (D8)
        modal,
    )
    now = eye_motion(at, end)
    link = motion(mechanism, now, crank)
    rod = rod_turn(mechanism, now.position, now.velocity, crank.angle, crank.speed)
    right = pushed(at, link, rod, films, changes)
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
            skirt.lateral + rings.lateral,
            skirt.axial + rings.axial,
            skirt.moment + rings.moment - rings.axial * system.pin_offset,
        ),
        on_pins.film_thickness,
        on_pins.sliding_velocity,
    )
