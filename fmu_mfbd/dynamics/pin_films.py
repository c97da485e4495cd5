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
    in_axes,
    modal_push,
    opening_of,
    power_on_grid,
    resultants_at,
    resultants_on,
    slope_push,
    yielded,
)
from ..geometry.surfaces import pin_surface_at, pins_of
from .floating_pin import PinFilms, no_films
from .generalised_alpha import Motion
from .pin_coordinates import EYE, Layout, PinBodies, coordinates_of_film, layout, of_shapes
from .pin_shells import (
    Shell,
    in_turning_axes,
    own_bent,
    own_velocity,
    shell_change,
    shell_modes_of,
    shell_of,
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
def own_films(surfaces: np.ndarray, first: Layout, forces: PinForces) -> PinFilms:
    """Return the resultants of nodal forces in the axes of the shells, for pins amid rigid shells.

    A step's motion does not change them; `surfaces` as in `PinSystem`.
    """
    out = no_films(first, pins_of(surfaces))
    cell = 0
    for k in range(pins_of(surfaces)):
        surface = pin_surface_at(surfaces, k)
        own = on_film(surface, forces, cell)
        cell += len(own.pressure)
        _put(out, k, resultants_on(surface, own))
        slopes = slope_push(surface, own.pressure)
        pushes = modal_push(surface, own)
        mode = coordinates_of_film(first, k).mode
        for m in range(len(pushes)):
            out.slope_push[k, mode + m] = slopes[m]
            out.push[mode + m] += pushes[m]
    return out


@compilable
def _put(films, k, found):
    """Put the resultants of film k among those of all."""
    films.on_pin[k] = found.on_pin
    films.on_shell[k] = found.on_shell
    for way in range(2):
        films.force[k, way] = found.force[way]
        for m in range(len(found.on_shapes)):
            films.on_shapes[k, m, way] = found.on_shapes[m, way]


@compilable
def films_at(
    mechanism: Mechanism, first: Layout, own: PinFilms, now: Motion, crank: CrankMotion
) -> PinFilms:
    """Return the resultants of all films in space in a motion, from `own_films`."""
    none = no_films(first, len(own.force))
    out = PinFilms(none.force, none.on_pin, none.on_shell, none.on_shapes, own.push, own.slope_push)
    for k in range(len(own.force)):
        shell = shell_of(mechanism, first, now, crank, k)
        bent = shell.bent.position
        on_shell = own.on_shell[k]
        for c in range(first.size):
            on_shell -= own.slope_push[k, c] * now.position[c]
        held = PinResultants(own.force[k], 0.0, on_shell, own.on_shapes[k, : len(bent)])
        _put(out, k, resultants_at(held, shell.place, shell.axes, bent))
    return out


@compilable
def _work_error(first, surface, forces, films, shell, end, k):
    """Return the relative power error of a film, on the grid (Eq. (G4)) and in coordinates [-]."""
    modal = shell_modes_of(first, end.position, k)
    modal_velocity = shell_modes_of(first, end.velocity, k)
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
    moving = films.force[k, 0] * shell.velocity[0] + films.force[k, 1] * shell.velocity[1]
    shell_turns = films.on_shell[k] * shell.own_turning
    pin_turns = films.on_pin[k] * (shell.own_turning + shell.turning)
    yields = 0.0
    push = modal_push(surface, forces)
    for m in range(len(push)):
        yields += push[m] * modal_velocity[m]
    bends = 0.0
    for m in range(len(shell.bent.velocity)):
        for way in range(2):
            bends += films.on_shapes[k, m, way] * shell.bent.velocity[m, way]
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
def pin_films(
    of: PinSystem, forces: PinForces, films: PinFilms, end: Motion, crank: CrankMotion
) -> PinFilmState:
    """Return all films of pin and crank at an instant; `films` are their resultants."""
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
        errors[k] = _work_error(at, surface, own, films, shell, end, k)
        if k <= EYE:
            friction_power -= shell.turning * films.on_pin[k]
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
        by_motion = shell_change(of.bodies.mechanism, at, end, moved, crank, k)
        way = in_turning_axes(shell.axes, shell.place, by_motion.place, by_motion.turn)
        more = of_shapes(at, moved.position)
        bent = shell.bent.position
        bends = np.empty(bent.shape)
        for n in range(len(bent)):
            bend = in_turning_axes(shell.axes, bent[n], more[n], by_motion.turn)
            bends[n, 0] = bend[0]
            bends[n, 1] = bend[1]
        gap = opening_of(surface, way, bends)
        opened = yielded(surface, shell_modes_of(at, moved.position, k))
        around, along = gap.shape
        for i in range(around):
            for j in range(along):
                gaps[first + i * along + j] = gap[i, j] + opened[i, j]
                velocities[first + i * along + j] = surface.radius * by_motion.turning
        first += gap.size
    return FilmChange(gaps, velocities)
