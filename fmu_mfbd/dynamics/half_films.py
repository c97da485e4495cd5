"""Half of the films of a skirt, if films and bodies are symmetric about the thrust plane.

Kernels and motion are those of the whole films. Only the grids are halves, from the thrust line to
the anti-thrust line. The odd part of a field is half of its difference from its mirror image.
"""

from collections.abc import Sequence

import numpy as np

from ...master.fmi.compiled import compilable, compiled
from ...master.fmi.noted import refuse
from ...master.fmi.odd_cells import first_odd
from ...master.fmi.symmetry import THRUST_PLANE, WHOLE, half_grid, odd_part
from ..geometry.film import BoreSplines, FilmSurface, NodalForces
from ..geometry.modal_field import half_field
from ..geometry.surfaces import count_of, surface_at
from ..reduction.reduced_body import ReducedBody
from .contradictions import FAULT
from .parameters import Settings
from .skirt_films import cells_of, field_of
from .start_state import StartState

ODD_SHAPE = 1e-9
"""Odd part of a profile, a bore or a start that is omitted [m]: a tenth of the tolerance of film
thickness in a coupling."""
ODD_TEMPERATURE = 1e-5
"""Odd part of a temperature that is omitted [K]: a skirt of 50 mm grows by `ODD_SHAPE` with it."""
ODD_MODE = 1e-6
"""Odd part of a mode that is round-off, relative to the mode."""


def half_films(
    films: Sequence[FilmSurface], bodies: Sequence[ReducedBody], start: StartState | None = None
) -> tuple[FilmSurface, ...]:
    """Return one half of the film surfaces in a common bore, () if they are not symmetric.

    Parameters
    ----------
    films : sequence of FilmSurface
        Before `clearance.machined`, whose parameters are symmetric except `pin_tilt`.
    bodies : sequence of ReducedBody
        Piston and block.
    start : StartState, optional
        Motion at the start. Default: undeformed bodies.
    """
    around = len(films[0].skirt.angle)
    bore = films[0].bore
    if around % 2 or any(mirror_error(one, around) > ODD_MODE for one in bodies):
        return ()
    if odd_start(start, bodies, around):
        return ()
    shapes = [bore.shape.T, *(one.skirt.gap for one in films)]
    if any(np.abs(odd_part(shape)).max(initial=0.0) > ODD_SHAPE for shape in shapes):
        return ()
    warm = [bore.temperature.T, *(one.skirt.temperature for one in films)]
    if any(np.abs(odd_part(one)).max() > ODD_TEMPERATURE for one in warm if one.size):
        return ()
    half = _half_bore(bore, around)
    return tuple(FilmSurface(_half_skirt(one.skirt), half) for one in films)


def _half_skirt(skirt):
    """Return one half of the skirt's side."""
    around = len(skirt.angle)
    first, last, rows = half_grid(around)
    return skirt._replace(
        angle=skirt.angle[first:last],
        gap=_even(skirt.gap)[first:last],
        radial=half_field(skirt.radial, around),
        axial=half_field(skirt.axial, around),
        rows=rows.astype(float),
        temperature=_even(skirt.temperature)[first:last],
    )


def _half_bore(bore: BoreSplines, around: int) -> BoreSplines:
    """Return one half of the bore."""
    first, last, _ = half_grid(around)
    return bore._replace(
        radial=half_field(bore.radial, around),
        axial=half_field(bore.axial, around),
        shape=_even(bore.shape, 1)[:, first:last],
        temperature=_even(bore.temperature, 1)[:, first:last],
    )


def _even(field: np.ndarray, axis: int = 0) -> np.ndarray:
    """Return the even part of a field about the thrust plane; a field may have no rows."""
    return field - odd_part(field, axis) if field.size else field


def mirror_error(body: ReducedBody, around: int) -> float:
    """Return how much the compliance of a body's surface differs from its mirror image [-].

    Eq. (J48):  |C - M C M| / |C|,   C = A A^T,   A = R Phi Omega^-1
                |C - M C M|^2 = 2 |A^T A|^2 - 2 |A^T M A|^2      Frobenius norms

    M is the mirror image about the thrust plane. The result is 0 for a rigid body.
    """
    answer = on_cells(body, around) / body.omega
    if not answer.size:
        return 0.0
    image = answer - 2 * odd_part(answer)
    whole, mirrored = (
        float((np.tensordot(answer, one, ([0, 1], [0, 1])) ** 2).sum()) for one in (answer, image)
    )
    return float(np.sqrt(max(0.0, 2 * (1 - mirrored / whole))))  # Eq. (J48)


def odd_start(start: StartState | None, bodies: Sequence[ReducedBody], around: int) -> float:
    """Return the largest odd deflection of a surface in the motion at the start [m].

    A velocity counts as the amplitude of its free vibration. The result is 0 for round-off, and for
    a start of other bodies, which `check_start` rejects.

    Parameters
    ----------
    start : StartState or None
    bodies : sequence of ReducedBody
        Piston and block.
    around : int
        Number of circumferential cells.
    """
    count = sum(len(body.omega) for body in bodies)
    if start is None or {len(start.modal_coordinate), len(start.modal_velocity)} != {count}:
        return 0.0
    largest, first = 0.0, 0
    for body in bodies:
        own = slice(first, first + len(body.omega))
        first = own.stop
        shapes = odd_part(on_cells(body, around))
        for amplitude in (start.modal_coordinate[own], start.modal_velocity[own] / body.omega):
            largest = max(largest, float(np.abs(shapes @ amplitude).max(initial=0.0)))
    return largest if largest > ODD_SHAPE else 0.0


def on_cells(body: ReducedBody, around: int) -> np.ndarray:
    """Return the radial displacement of the modes, (c, a, k)."""
    count = len(body.omega)
    rows = body.radial.size // (around * count) if count else 0
    return body.radial.reshape(around, rows, count)


@compilable
def is_halved(half_surfaces: np.ndarray, p: Settings) -> bool:
    """Return whether one half of the films is computed: it exists, is chosen, and has no tilt."""
    return count_of(half_surfaces) > 0 and p.film_symmetry != WHOLE and p.pin_tilt == 0.0


@compilable
def is_half(surface: FilmSurface) -> bool:
    """Return whether the grid of a surface is one half of its film."""
    return len(surface.skirt.rows) > len(surface.skirt.angle)


@compilable
def check_half(surfaces: np.ndarray, p: Settings, faults: np.ndarray) -> None:
    """Note a fault if one half of the films is demanded, but the films are whole."""
    if p.film_symmetry == THRUST_PLANE and not is_half(surface_at(surfaces, 0)):
        refuse(faults, FAULT.no_half, 0.0, 0.0, p.pin_tilt, 0.0, 0.0)


@compiled
def check_even(surfaces: np.ndarray, forces: NodalForces, faults: np.ndarray) -> None:
    """Note a fault if one half of a film is computed, but the forces on it are not symmetric.

    Parameters
    ----------
    surfaces : ndarray
        Block of all film surfaces.
    forces : NodalForces
        Stacked [N].
    faults : ndarray
    """
    first = 0
    no_cut = np.zeros((0, 0), np.bool_)
    for s in range(count_of(surfaces)):
        surface = surface_at(surfaces, s)
        if is_half(surface):
            for number, stacked in (
                (FAULT.odd_pressure_force, forces.pressure),
                (FAULT.odd_friction_force, forces.friction),
            ):
                force = field_of(surface, stacked, first)
                i, j, k = first_odd(force, no_cut)
                if i >= 0:
                    refuse(faults, number, i + 1.0, j + 1.0, force[i, j], force[k, j], 0.0)
        first += cells_of(surface)
