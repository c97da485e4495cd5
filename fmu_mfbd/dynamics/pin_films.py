"""All films of pin and crank: forces on the bodies, thickness, velocity, and what changes them.

Films stand in the order of `PIN_SURFACES` and `CRANK_SURFACES`; their fields are stacked, as the
skirt's are.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Matrix, Vector
from ..geometry.pin import (
    ModeMotion,
    PinForces,
    PinResultants,
    PinSurface,
    across,
    in_axes,
    modal_push,
    opening_of,
    pair,
    power_on_grid,
    resultants_on,
    slope_push,
    yielded,
)
from ..geometry.surfaces import pin_surface_at, pins_of
from .floating_pin import PinFilms, no_film
from .generalised_alpha import Motion
from .pin_coordinates import Layout, PinBodies, layout, of_shapes
from .pin_shells import (
    EYE,
    Shell,
    _big_end,
    _shell_change,
    first_mode,
    own_bent,
    own_velocity,
    shell_modes_of,
    shell_of,
    turned_back,
)
from .skirt_films import FilmChange, stack
from .slider_crank import CrankMotion, Mechanism
from .system import BodySystem


class PinSystem(NamedTuple):
    """Bodies and films of a piston; without films of the pin, the pin is tied.

    Parameters
    ----------
    system : BodySystem
        The same with the pin tied. If the pin floats, no mode is static, and the block is rigid.
    bodies : PinBodies
    surfaces : ndarray
        Films of pin and crank, a block of `geometry.pin_surfaces`.
    inertia, with_rod : ndarray, shape (n, n)
        `pin_tangent.inertia` without and with the rod; (0, 0) if the pin is tied.
    """

    system: BodySystem
    bodies: PinBodies
    surfaces: Vector
    inertia: Matrix
    with_rod: Matrix


@compilable
def on_film(surface: PinSurface, forces: PinForces, first: int) -> PinForces:
    """Return the forces of a film, which begin with `first` of stacked ones."""
    last = first + surface.outward.shape[1] * len(surface.clearance)
    return PinForces(forces.pressure[first:last], forces.circumferential[first:last])


@compilable
def resultants_of(
    surface: PinSurface, forces: PinForces, shell: Shell, modal: np.ndarray
) -> PinResultants:
    """Return the resultants of a film whose shell deflects by modal coordinates."""
    bent = shell.bent.position
    found = resultants_on(surface, forces, shell.place, shell.axes, bent)
    push = slope_push(surface, forces.pressure)
    moment = 0.0
    for m in range(len(push)):
        moment += push[m] * modal[m]
    on_pin = found.on_pin + moment
    return PinResultants(found.force, on_pin, found.on_shell - moment, found.on_shapes)


@compilable
def added(one: PinResultants, other: PinResultants) -> PinResultants:
    """Return the sum of the resultants of two films of a pin."""
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


class OnModes(NamedTuple):
    """Loads of the films of pin and crank by the modes of their shells.

    Moments on pin and crank come from the slopes of bosses and other shells (Eq. (G5)), by modal
    coordinate. Forces act on the piston's modes and on those of the shells (Eq. (G6)).
    """

    slope_push: np.ndarray
    shell_slope_push: np.ndarray
    on_piston: np.ndarray
    on_shells: np.ndarray


@compilable
def on_modes_of(surfaces: np.ndarray, first: Layout, forces: PinForces) -> OnModes:
    """Return the loads of the films by the modes of their shells; `surfaces` as in `PinSystem`."""
    k = first.shapes - first.modes
    m = first.crank - first.eye
    out = OnModes(np.zeros(k), np.zeros(m), np.zeros(k), np.zeros(m))
    cell = 0
    for film in range(pins_of(surfaces)):
        surface = pin_surface_at(surfaces, film)
        own = on_film(surface, forces, cell)
        cell += len(own.pressure)
        slopes = slope_push(surface, own.pressure)
        pushes = modal_push(surface, own)
        begins = first_mode(first, film) - first.eye
        for n in range(len(slopes)):
            if film < EYE:
                out.slope_push[n] += slopes[n]
                out.on_piston[n] += pushes[n]
            else:
                out.shell_slope_push[begins + n] += slopes[n]
                out.on_shells[begins + n] += pushes[n]
    return out


@compilable
def total(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the sum of two arrays of one axis, in a loop."""
    out = np.empty(len(a))
    for k in range(len(a)):
        out[k] = a[k] + b[k]
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
    """Return the resultants of all films of the pin in a motion, both bosses as one.

    `surfaces` are those of `PinSystem`.
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
    slopes, pushes = by.shell_slope_push, by.on_shells
    return PinFilms(both, eye, by.slope_push, slopes, pushes, big_end, main_bearing)


@compilable
def _work_error(first, surface, forces, shell, end, k):
    """Return the relative power error of a film, on the grid (Eq. (G4)) and in coordinates [-]."""
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
        ModeMotion(modal, modal_velocity),
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
    """Return the film thickness of film k, (c, a) [m]."""
    gap = opening_of(surface, in_axes(shell.axes, shell.place), own_bent(shell).position)
    opened = yielded(surface, shell_modes_of(first, coordinates, k))
    around, along = gap.shape
    for i in range(around):
        for j in range(along):
            gap[i, j] = surface.clearance[j] + gap[i, j] + opened[i, j]
    return gap


class PinFilmState(NamedTuple):
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
def pin_films(of: PinSystem, forces: PinForces, end: Motion, crank: CrankMotion) -> PinFilmState:
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
    return PinFilmState(gaps, around, errors, friction_power, rod_turning)


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
        more = of_shapes(at, moved.position)
        gap = opening_of(surface, way, turned_back(shell, shell.bent.position, more, turn))
        opened = yielded(surface, shell_modes_of(at, moved.position, k))
        around, along = gap.shape
        for i in range(around):
            for j in range(along):
                gaps[first + i * along + j] = gap[i, j] + opened[i, j]
                velocities[first + i * along + j] = surface.radius * by_motion.turning
        first += gap.size
    return FilmChange(gaps, velocities)
