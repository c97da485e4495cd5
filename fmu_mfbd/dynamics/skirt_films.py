"""Films of the skirt at an instant: forces on the bodies, thickness, sliding velocity, changes."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..geometry.film import (
    FilmForces,
    FilmState,
    FilmSurface,
    NodalForces,
    SlopePush,
    Window,
    film_now,
    generalised,
    opening,
    sliding,
    slope_push,
    window_at,
)
from ..geometry.surfaces import count_of, surface_at
from ..mechanism.piston_motion import LATERAL, RIGID, ROCKING
from .system import BodySystem, skirt_modes


class AxialMotion(NamedTuple):
    """Height of a point above the crank axis [m] and its velocity [m/s]."""

    height: float
    velocity: float


@compiled
def cells_of(surface: FilmSurface) -> int:
    """Return the number of cells of a film, of which the grid may have half."""
    return len(surface.skirt.rows) * len(surface.skirt.height)


@compiled
def field_of(surface: FilmSurface, stacked: np.ndarray, first: int) -> np.ndarray:
    """Return a surface's part of a stacked field, which begins with `first`, (n, a)."""
    last = first + cells_of(surface)
    return stacked[first:last].reshape((len(surface.skirt.rows), len(surface.skirt.height)))


@compiled
def _on_grid(surface, force):
    """Return the forces on the grid, sums over both images of a cell, from those on the film."""
    rows = surface.skirt.rows
    c, a = surface.skirt.gap.shape
    if len(rows) == c:
        return force
    out = np.zeros((c, a))
    for k in range(len(rows)):
        i = int(rows[k])
        for j in range(a):
            out[i, j] += force[k, j]
    return out


@compiled
def _nodal(surface, forces, first):
    """Return a surface's part of stacked forces, which begins with `first`, on its grid."""
    pressure = _on_grid(surface, field_of(surface, forces.pressure, first))
    return NodalForces(pressure, _on_grid(surface, field_of(surface, forces.friction, first)))


@compiled
def stack_film(stacked, first, surface, field):
    """Put a field on a surface's grid at its place among those of all films, on all cells."""
    rows = surface.skirt.rows
    columns = field.shape[1]
    for k in range(len(rows)):
        i = int(rows[k])
        for j in range(columns):
            stacked[first + k * columns + j] = field[i, j]


@compiled
def stack(stacked, first, field):
    """Put a field at its place among those of all surfaces, in a loop."""
    rows, columns = field.shape
    for i in range(rows):
        for j in range(columns):
            stacked[first + i * columns + j] = field[i, j]


@compiled
def window_of(surface: FilmSurface, guide_height: float) -> Window:
    """Return the position of a surface in the bore that is read at a height [m]."""
    return window_at(surface.bore.lowest, surface.bore.spacing, guide_height, surface.skirt.height)


class FilmParts(NamedTuple):
    """Generalised forces of each film of the skirt, as of `FilmForces`, one row a surface."""

    axial: np.ndarray
    push: np.ndarray


@compiled
def forces_by_film(
    system: BodySystem, guide_height: float, forces: NodalForces, sliding_modes: bool = True
) -> FilmParts:
    """Return the generalised forces of each film.

    Parameters
    ----------
    system : BodySystem
    guide_height : float
        Height at which the bore is read [m].
    forces : NodalForces
        Stacked [N].
    sliding_modes : bool
        As of `generalised`.
    """
    films = count_of(system.surfaces)
    parts = FilmParts(np.empty(films), np.empty((films, RIGID + skirt_modes(system))))
    first = 0
    for s in range(films):
        surface = surface_at(system.surfaces, s)
        nodal = _nodal(surface, forces, first)
        window = window_of(surface, guide_height)
        part = generalised(surface.skirt, surface.bore, window, nodal, sliding_modes)
        parts.axial[s] = part.axial
        for k in range(len(part.push)):
            parts.push[s, k] = part.push[k]
        first += cells_of(surface)
    return parts


@compiled
def total_forces(parts: FilmParts) -> FilmForces:
    """Return the generalised forces of all films.

    Eq. (G2):  Q = sum_s Q_s        s the film surfaces of the body: virtual work adds
    """
    axial = 0.0
    push = np.zeros(parts.push.shape[1])
    for s in range(len(parts.axial)):
        # Eq. (G2)
        axial += parts.axial[s]
        for k in range(len(push)):
            push[k] += parts.push[s, k]
    return FilmForces(axial, push)


class SkirtFilms(NamedTuple):
    """All films of the skirt at an instant.

    Parameters
    ----------
    film_thickness, sliding_velocity : ndarray, shape (cells,)
        Stacked [m], [m/s].
    work_error : ndarray, shape (surfaces,)
        `work_error` of each film [-].
    on_slopes : float
        Axial force of pressure on bores that are not straight [N].
    """

    film_thickness: np.ndarray
    sliding_velocity: np.ndarray
    work_error: np.ndarray
    on_slopes: float


@compiled
def skirt_films(
    system: BodySystem,
    guide: AxialMotion,
    forces: NodalForces,
    parts: FilmParts,
    axial_velocity: float,
    position: np.ndarray,
    velocity: np.ndarray,
) -> SkirtFilms:
    """Return all films of the skirt at an instant.

    Parameters
    ----------
    system : BodySystem
    guide : AxialMotion
        Axial motion of A for x_A = 0, at which the bore is read.
    forces : NodalForces
        Stacked [N].
    parts : FilmParts
        Parts of these forces.
    axial_velocity : float
        Axial velocity of A [m/s].
    position, velocity : ndarray, shape (n,)
        Coordinates x_A, rocking angle, modes of piston and block, and their rates.
    """
    thickness = np.empty(len(forces.pressure))
    sliding_velocity = np.empty(len(forces.pressure))
    errors = np.empty(len(parts.axial))
    on_slopes = 0.0
    first = 0
    for k in range(len(errors)):
        surface = surface_at(system.surfaces, k)
        film = film_now(
            surface.skirt,
            surface.bore,
            window_of(surface, guide.height),
            _nodal(surface, forces, first),
            axial_velocity,
            guide.velocity,
            position,
            velocity,
        )
        stack_film(thickness, first, surface, film.film_thickness)
        stack_film(sliding_velocity, first, surface, film.sliding_velocity)
        own = FilmForces(parts.axial[k], parts.push[k])
        errors[k] = work_error(own, film, axial_velocity, guide.velocity, velocity)
        on_slopes += film.axial_force
        first += cells_of(surface)
    return SkirtFilms(thickness, sliding_velocity, errors, on_slopes)


@compiled
def skirt_slopes(system: BodySystem, guide_height: float, pressure: np.ndarray) -> SlopePush:
    """Return the axial force of all films on the slopes of the bore.

    Parameters
    ----------
    system : BodySystem
    guide_height : float
        Height at which the bore is read [m].
    pressure : ndarray, shape (cells,)
        Forces, stacked [N].
    """
    undeformed = 0.0
    modal = np.zeros(system.wall.above.shape[1])
    first = 0
    for s in range(count_of(system.surfaces)):
        surface = surface_at(system.surfaces, s)
        field = _on_grid(surface, field_of(surface, pressure, first))
        push = slope_push(surface.bore, window_of(surface, guide_height), field)
        undeformed += push.undeformed
        for k in range(len(modal)):
            modal[k] += push.modal[k]
        first += cells_of(surface)
    return SlopePush(undeformed, modal)


class FilmChange(NamedTuple):
    """Change of thickness [m] and sliding velocity [m/s] of all films, stacked, (cells,)."""

    film_thickness: np.ndarray
    sliding_velocity: np.ndarray


@compiled
def skirt_changes(
    system: BodySystem,
    guide_height: float,
    rising: float,
    position: np.ndarray,
    velocity: np.ndarray,
) -> FilmChange:
    """Return the change of all films of the skirt with the bodies' coordinates.

    Parameters
    ----------
    system : BodySystem
    guide_height : float
        Height at which the bore is read [m].
    rising : float
        Change of A's axial velocity [m/s].
    position, velocity : ndarray, shape (n,)
        Changes of x_A, rocking angle, modes of piston and block.
    """
    films, modes = count_of(system.surfaces), RIGID + len(system.gas_force)
    cells = 0
    for s in range(films):
        cells += cells_of(surface_at(system.surfaces, s))
    out = FilmChange(np.empty(cells), np.empty(cells))
    first = 0
    for s in range(films):
        surface = surface_at(system.surfaces, s)
        window = window_of(surface, guide_height)
        opened = opening(
            surface.skirt,
            surface.bore,
            window,
            position[LATERAL],
            position[ROCKING],
            position[RIGID:modes],
            position[modes:],
        )
        slid = sliding(
            surface.skirt,
            surface.bore,
            window,
            rising,
            velocity[ROCKING],
            velocity[RIGID:modes],
            velocity[modes:],
        )
        stack_film(out.film_thickness, first, surface, opened)
        stack_film(out.sliding_velocity, first, surface, slid)
        first += cells_of(surface)
    return out


@compiled
def work_error(
    forces: FilmForces,
    film: FilmState,
    axial_velocity: float,
    guided_velocity: float,
    velocity: np.ndarray,
) -> float:
    """Return the relative error of the interface power on the grid and in the coordinates [-].

    It is their difference, relative to the sum of the sizes of all terms. Both describe the same
    work, so that anything above round-off is an error in the transfer of forces.

    Parameters
    ----------
    forces : FilmForces
    film : FilmState
    axial_velocity, guided_velocity : float
        Velocity of A, and of the height at which the bore is read [m/s].
    velocity : ndarray, shape (n,)
        Rates of all coordinates.
    """
    work = forces.axial * axial_velocity + film.axial_force * guided_velocity
    size = abs(forces.axial * axial_velocity) + abs(film.axial_force * guided_velocity)
    size += film.power_size
    for k in range(len(velocity)):
        work += forces.push[k] * velocity[k]
        size += abs(forces.push[k] * velocity[k])
    return abs(film.power - work) / size if size > 0.0 else 0.0
