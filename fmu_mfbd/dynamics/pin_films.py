"""All films of pin and crank: forces on the bodies, thickness and velocity, and their derivatives.

Films have the order of `PIN_SURFACES` and `CRANK_SURFACES`. They are the first force elements of
the chain. Their fields are stacked, as those of the skirt.
"""

from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.pin import (
    PinForces,
    PinSurface,
    across,
    axes_of,
    diameters,
    in_axes,
    opening_of,
    pair,
    power_on_grid,
    resultants_on,
    shell_pushes,
    yielded,
)
from ..geometry.surfaces import pin_surface_at, pins_of
from ..mechanism.bdf2 import STATIC
from ..mechanism.chain import MOMENT, REACTION, Chain, Loads
from ..mechanism.cylinder import EYE, floats
from ..mechanism.floating_frame import TURN, X, Y
from ..mechanism.generalised_alpha import Motion
from ..mechanism.loads import AppliedForces, no_forces
from ..mechanism.modal_damping import put_damping
from ..mechanism.motion import ChainMotion, MotionChanges
from ..mechanism.piston_motion import Load
from .pin_shells import (
    Shell,
    own_bent,
    own_velocity,
    shapes_of,
    shell_change,
    shell_modes_of,
    shell_of,
    turned_back,
)
from .skirt_films import FilmChange, stack
from .system import BodySystem


@compilable
def damp_modes(kinds: np.ndarray, chain: Chain, p: Any) -> None:
    """Overwrite the damping of all modes by Eq. (I5), 0 for modes without inertia."""
    m = chain.joints.tip.shape[1]
    put_damping(chain.bodies.damping, chain.bodies.stiffness, p)
    for k in range(len(chain.bodies.damping)):
        if kinds[m + k] == STATIC:
            chain.bodies.damping[k] = 0.0


@compilable
def forces_on_film(surface: PinSurface, forces: PinForces, first: int) -> PinForces:
    """Return the forces of one film, which start at cell `first` of the stacked ones."""
    last = first + surface.outward.shape[1] * len(surface.clearance)
    return PinForces(forces.pressure[first:last], forces.circumferential[first:last])


@compilable
def forces_of(chain: Chain, load: Load) -> AppliedForces:
    """Return the forces of skirt and gas, and none of films of pin and crank."""
    out = no_forces(chain)
    for k in range(len(load.modal)):
        out.modal[k] = load.modal[k]
    skirt = len(out.moment) - len(chain.laws.kind) - 2
    out.force[skirt, X], out.force[skirt, Y] = load.lateral, load.axial + load.axis_force
    out.moment[skirt] = load.moment
    out.force[skirt + 1, Y] = -load.axis_force
    return out


@compilable
def film_pushes(of: BodySystem, forces: PinForces) -> np.ndarray:
    """Return `shell_pushes` of all films, film by film, (2, all modes) [kg^-1/2 N]."""
    elements = of.chain.elements
    films, size = pins_of(of.pin_surfaces), 0
    for e in range(films):
        size += elements.modes[e]
    out = np.empty((2, size))
    cell, first = 0, 0
    for e in range(films):
        surface = pin_surface_at(of.pin_surfaces, e)
        own = forces_on_film(surface, forces, cell)
        cell += len(own.pressure)
        push = shell_pushes(surface, own)
        for k in range(push.shape[1]):
            out[0, first + k], out[1, first + k] = push[0, k], push[1, k]
        first += push.shape[1]
    return out


@compilable
def applied_forces(
    of: BodySystem, load: Load, forces: PinForces, pushes: np.ndarray
) -> AppliedForces:
    """Return the forces of all elements without laws: films of pin and crank, then skirt and gas.

    Parameters
    ----------
    of : BodySystem
    load : Load
        On the piston, without its pin, and on the modes of piston and block.
    forces : PinForces
        Nodal forces of all films of pin and crank, stacked [N].
    pushes : ndarray
        `film_pushes` of them.
    """
    elements, m = of.chain.elements, of.chain.joints.tip.shape[1]
    out = forces_of(of.chain, load)
    cell, slope = 0, 0
    for e in range(pins_of(of.pin_surfaces)):
        surface = pin_surface_at(of.pin_surfaces, e)
        own = forces_on_film(surface, forces, cell)
        cell += len(own.pressure)
        still = np.zeros((surface.axis.shape[1], 2))
        resultants = resultants_on(surface, own, np.zeros(2), axes_of(1.0, 0.0), still)
        out.moment[e] = resultants.on_pin
        for direction in range(2):
            out.force[e, direction] = resultants.force[direction]
            for k in range(elements.shapes[e]):
                out.on_shapes[e, k, direction] = resultants.on_shapes[k, direction]
        for k in range(elements.modes[e]):
            out.modal[elements.mode[e] - m + k] += pushes[0, slope]
            out.slopes[slope] = pushes[1, slope]
            slope += 1
    return out


@compilable
def _work_error(of, forces, push, opened, shell, loads, end, e):
    """Return the relative power error of a film, on the grid (Eq. (G4)) and in coordinates [-].

    `push` is the force on the modes of its shell, which is `opened`.
    """
    surface = pin_surface_at(of.pin_surfaces, e)
    modal_velocity = shell_modes_of(of.chain.elements, end.velocity, e)
    place = in_axes(shell.axes, shell.place)
    on_grid = power_on_grid(
        surface,
        forces,
        place,
        own_velocity(shell),
        shell.turning,
        opened,
        modal_velocity,
        own_bent(shell),
    )
    wrench = loads.wrench[e]
    moving = wrench[X] * shell.velocity[0] + wrench[Y] * shell.velocity[1]
    shell_turns = wrench[REACTION] * shell.own_turning
    pin_turns = wrench[MOMENT] * (shell.own_turning + shell.turning)
    yields = 0.0
    for m in range(len(push)):
        yields += push[m] * modal_velocity[m]
    bends = 0.0
    for m in range(of.chain.elements.shapes[e]):
        for direction in range(2):
            bends += loads.on_shapes[e, m, direction] * shell.bent.velocity[m, direction]
    in_coordinates = moving + shell_turns + yields + bends + pin_turns
    size = on_grid.size + abs(moving) + abs(shell_turns) + abs(yields) + abs(bends) + abs(pin_turns)
    return abs(on_grid.power - in_coordinates) / size if size > 0.0 else 0.0


@compilable
def gap_of(surface: PinSurface, shell: Shell, opened: np.ndarray) -> np.ndarray:
    """Return the film thickness in a shell of which `yielded` is `opened`, (c, a) [m]."""
    gap = opening_of(surface, in_axes(shell.axes, shell.place), own_bent(shell).position)
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
        As of `Instant`.
    widening : ndarray, shape (films, 2)
        `diameters` of all shells [m].
    friction_power : float
        Friction power of the films of the pin [W].
    driven : float
        Power on rod and crank, whose angles are not coordinates [W].
    """

    film_thickness: np.ndarray
    circumferential_velocity: np.ndarray
    work_error: np.ndarray
    widening: np.ndarray
    friction_power: float
    driven: float


@compilable
def pin_films(
    of: BodySystem,
    forces: PinForces,
    pushes: np.ndarray,
    loads: Loads,
    at: ChainMotion,
    end: Motion,
) -> PinFilmState:
    """Return all films of pin and crank at an instant; `pushes` as for `applied_forces`."""
    cells = len(forces.pressure)
    gaps = np.empty(cells)
    around = np.empty(cells)
    errors = np.empty(pins_of(of.pin_surfaces))
    wider = np.zeros((len(errors), 2))
    friction_power, driven = 0.0, 0.0
    first, mode = 0, 0
    for e in range(len(errors)):
        surface = pin_surface_at(of.pin_surfaces, e)
        shell = shell_of(of.chain.elements, at, end, e)
        own = forces_on_film(surface, forces, first)
        last = first + len(own.pressure)
        opened = yielded(surface, shell_modes_of(of.chain.elements, end.position, e))
        wider[e, X], wider[e, Y] = diameters(opened)
        stack(gaps, first, gap_of(surface, shell, opened))
        for cell in range(first, last):
            around[cell] = surface.radius * shell.turning  # Eq. (H7)
        push = pushes[0][mode : mode + of.chain.elements.modes[e]]
        mode += len(push)
        errors[e] = _work_error(of, own, push, opened, shell, loads, end, e)
        if e <= EYE and floats(of.chain):
            friction_power -= shell.turning * loads.wrench[e, MOMENT]
        for body, moment in (
            (of.chain.elements.acts[e], loads.wrench[e, MOMENT]),
            (of.chain.elements.reacts[e], loads.wrench[e, REACTION]),
        ):
            if body >= 0 and of.chain.joints.angle[body] < 0:
                driven += moment * at.velocity[body, TURN]
        first = last
    return PinFilmState(
        film_thickness=gaps,
        circumferential_velocity=around,
        work_error=errors,
        widening=wider,
        friction_power=friction_power,
        driven=driven,
    )


@compilable
def pin_changes(
    of: BodySystem, at: ChainMotion, end: Motion, moved: Motion, bodies: MotionChanges
) -> FilmChange:
    """Return the change of all films of pin and crank with a change of coordinates and bodies."""
    cells = 0
    for e in range(pins_of(of.pin_surfaces)):
        surface = pin_surface_at(of.pin_surfaces, e)
        cells += surface.outward.shape[1] * len(surface.clearance)
    gaps = np.empty(cells)
    velocities = np.empty(cells)
    first = 0
    for e in range(pins_of(of.pin_surfaces)):
        surface = pin_surface_at(of.pin_surfaces, e)
        shell = shell_of(of.chain.elements, at, end, e)
        by_motion = shell_change(of.chain.elements, moved, bodies, e)
        aside = across(shell.place)
        turn = by_motion.turn
        shift = in_axes(
            shell.axes,
            pair(by_motion.place[0] - turn * aside[0], by_motion.place[1] - turn * aside[1]),
        )
        more = shapes_of(of.chain.elements, moved.position, e)
        gap = opening_of(surface, shift, turned_back(shell, shell.bent.position, more, turn))
        opened = yielded(surface, shell_modes_of(of.chain.elements, moved.position, e))
        around, along = gap.shape
        for i in range(around):
            for j in range(along):
                gaps[first + i * along + j] = gap[i, j] + opened[i, j]
                velocities[first + i * along + j] = surface.radius * by_motion.turning
        first += gap.size
    return FilmChange(gaps, velocities)
