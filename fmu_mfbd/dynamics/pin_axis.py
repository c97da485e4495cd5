"""Films of pin and crank before their parameters, and a pin that tilts and bends in its films."""

from collections.abc import Mapping

import numpy as np

from ..geometry.grid import film_rows
from ..geometry.pin import PIN_SURFACES, PinSurface, ShellModes, pin_surface, relieved, shell_modes
from ..geometry.pin_shapes import Beam, HollowPin, free_beam
from ..mechanism.cylinder import EYE
from ..reduction.reduced_body import ReducedBosses, ReducedPiston, ReducedShell
from .build_options import BuildOptions, FloatingPin
from .contradictions import pin_radius
from .parameters import AxisParameters, Parameters


def pin_surfaces(
    options: BuildOptions, bosses: ReducedBosses | None, shells: Mapping[str, ReducedShell]
) -> tuple[PinSurface, ...]:
    """Return the films of a pin that stays parallel to its shells, and of the crank.

    They have no radius and clearance yet. A tied pin has none.
    """
    names = (*(PIN_SURFACES if options.floating_pin else ()), *options.crank_surfaces())
    modes: list[ShellModes | None] = [None] * len(names)
    if bosses:
        modes[:EYE] = (shell_modes(*p) for p in zip(bosses.boss_outward, bosses.boss_onward))
    for k, name in enumerate(names):
        if shell := shells.get(name):
            modes[k] = shell_modes(shell.outward, shell.onward)
    return tuple(
        pin_surface(0.0, 0.0, grid.shape, one) for grid, one in zip(options.pin_grids(), modes)
    )


def with_shapes(
    films: tuple[PinSurface, ...],
    pin: FloatingPin,
    bosses: ReducedBosses | None,
    beam: Beam,
    axis: AxisParameters,
) -> tuple[PinSurface, ...]:
    """Return the films of a pin that tilts and bends, with relieved shells."""
    reliefs = axis.boss_relief, axis.boss_relief, axis.small_end_relief
    each = zip(films, pin_rows(pin, bosses), reliefs, pin.lengths().values())
    of_pin = [
        one._replace(clearance=relieved(one.clearance, relief, z, long), axis=beam.at(z))
        for one, z, relief, long in each
    ]
    return (*of_pin, *films[len(of_pin) :])


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


def pin_beam(
    piston: ReducedPiston,
    pin: FloatingPin,
    parameters: Parameters,
    bosses: ReducedBosses | None,
    axis: AxisParameters,
) -> Beam:
    """Return a floating pin as a free beam with the shapes of the build table."""
    hollow = HollowPin(
        mass=parameters.pin_mass,
        length=axis.pin_length or pin_span(pin, bosses),
        radius=pin_radius(piston.radius, parameters),
        bore_radius=axis.pin_bore_radius,
        young=axis.pin_young,
        poisson=axis.pin_poisson,
    )
    return free_beam(hollow, pin.pin_shapes)


def axis_faults(
    piston: ReducedPiston,
    bosses: ReducedBosses | None,
    pin: FloatingPin,
    parameters: Parameters,
    axis: AxisParameters,
) -> list[str]:
    """Return sentences about a pin whose parameters contradict each other."""
    out = []
    radius = pin_radius(piston.radius, parameters)
    if axis.pin_bore_radius >= radius:
        out.append(
            f"pin_bore_radius: expected less than the radius of the pin, {1e3 * radius:.4g} mm, "
            f"got {1e3 * axis.pin_bore_radius:.4g} mm"
        )
    span = pin_span(pin, bosses)
    if axis.pin_length and axis.pin_length < (1 - 1e-9) * span:
        out.append(
            f"pin_length: expected 0 or at least the length of all films, {1e3 * span:.4g} mm, "
            f"got {1e3 * axis.pin_length:.4g} mm"
        )
    return out
