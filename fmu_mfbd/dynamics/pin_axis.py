"""Films of pin and crank before their parameters, and a pin that tilts and bends in its films."""

from collections.abc import Mapping

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.grid import film_rows
from ..geometry.pin import PIN_SURFACES, PinSurface, ShellModes, pin_surface, shell_modes
from ..geometry.pin_shapes import Beam, HollowPin, beam_at, free_beam
from ..geometry.surfaces import pin_surface_at
from ..mechanism.cylinder import EYE
from ..reduction.reduced_body import ReducedBosses, ReducedShell
from .build_options import BuildOptions, FloatingPin
from .contradictions import pin_radius
from .parameters import Settings


def pin_surfaces(
    options: BuildOptions, bosses: ReducedBosses | None, shells: Mapping[str, ReducedShell]
) -> tuple[PinSurface, ...]:
    """Return the films of pin and crank, without radius, clearance and values of shapes.

    A tied pin has none.
    """
    names = (*(PIN_SURFACES if options.floating_pin else ()), *options.crank_surfaces())
    modes: list[ShellModes | None] = [None] * len(names)
    if bosses:
        modes[:EYE] = (shell_modes(*p) for p in zip(bosses.boss_outward, bosses.boss_onward))
    for k, name in enumerate(names):
        if shell := shells.get(name):
            modes[k] = shell_modes(shell.outward, shell.onward)
    shapes = options.floating_pin.pin_shapes if options.floating_pin else 0
    counts = (shapes if name in PIN_SURFACES else 0 for name in names)
    return tuple(
        pin_surface(0.0, 0.0, grid.shape, one, np.zeros((grid.shape[1], n)))
        for grid, one, n in zip(options.pin_grids(), modes, counts)
    )


def pin_rows(pin: FloatingPin, bosses: ReducedBosses | None) -> tuple[np.ndarray, ...]:
    """Return z of the rows of all films of the pin [m].

    Rows of bosses are those of the mesh. For a piston without a mesh of bosses they begin at the
    end of the rod's eye.
    """
    half = pin.small_end_length / 2
    outer = half + pin.boss_length
    ends = (-outer, -half), (half, outer), (-half, half)
    left, right, eye = (film_rows(*pair, pin.grid) for pair in ends)
    if bosses:
        left, right = bosses.boss_stations
    return left, right, eye


def pin_span(pin: FloatingPin, bosses: ReducedBosses | None) -> float:
    """Return the least length of a pin that reaches through all its films [m]."""
    _, along = pin.grid
    lengths = pin.lengths().values()
    rows = pin_rows(pin, bosses)
    return max(2 * np.abs(z).max() + long / along for z, long in zip(rows, lengths))


@compilable
def pin_beam(piston_radius: float, span: float, shapes: int, p: Settings) -> Beam:
    """Return a floating pin as a free beam with its first shapes.

    `span` is its length if the parameter is 0, the radius is that of the skirt [m].
    """
    hollow = HollowPin(
        mass=p.pin_mass,
        length=p.pin_length if p.pin_length > 0.0 else span,
        radius=pin_radius(piston_radius, p),
        bore_radius=p.pin_bore_radius,
        young=p.pin_young,
        poisson=p.pin_poisson,
    )
    return free_beam(hollow, shapes)


@compilable
def put_beam(
    films: np.ndarray, beam: Beam, rows: np.ndarray, lengths: np.ndarray, p: Settings
) -> None:
    """Write the shapes of a pin into its films, and widen these by the relief.

    Eq. (H12):  c(z) = c + r (2 (z - z_0)/L)^2      z_0 its middle, L its length, r the relief

    Parameters
    ----------
    films : ndarray
        All films of pin and crank, a block of `geometry.surfaces`; changed.
    beam : Beam
    rows : ndarray, shape (films, a)
        z of the rows of those of the pin [m].
    lengths : ndarray, shape (films,)
        L [m].
    p : Settings
    """
    for e in range(len(rows)):
        film, z = pin_surface_at(films, e), rows[e]
        relief = p.boss_relief if e < EYE else p.small_end_relief
        middle, shape = z.sum() / len(z), beam_at(beam, z)
        for j in range(len(z)):
            film.clearance[j] += relief * (2 * (z[j] - middle) / lengths[e]) ** 2  # Eq. (H12)
            for k in range(shape.shape[1]):
                film.axis[j, k] = shape[j, k]
