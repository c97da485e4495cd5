"""The memory of bodies that need no Python: what its rows hold (`master.fmi.block`).

One part of what is given is a block of film surfaces by itself, as many as there are
(`geometry.surfaces`).
"""

from collections import namedtuple
from dataclasses import fields
from typing import Annotated, NamedTuple

import numpy as np

from ..master.fmi.block import flatten, part
from ..master.fmi.compiled import compiled, packed
from .dynamics.assembly import (
    mechanism,
    pin_spin_inertia,
)
from .dynamics.contradictions import Fit, pin_radius
from .dynamics.gas_on_bore import BoreWall
from .dynamics.modal_damping import modal_springs
from .dynamics.parameters import CRANK_PARAMETERS, Parameters, PinParameters
from .dynamics.pin_coordinates import Crankshaft, PinBodies
from .dynamics.pin_films import PinSystem
from .dynamics.response import LinearisedMotion, StepEnd
from .dynamics.state import PistonState
from .dynamics.system import BodySystem
from .geometry.arrays import Matrix, Vector
from .geometry.pin_shapes import AxisShapes
from .geometry.surfaces import pins_of

Number = Annotated[np.ndarray, "1"]
"""An array of one, for what changes."""

# ---- where variables lie

NOWHERE = -1

DECLARED = (Parameters, PinParameters, *CRANK_PARAMETERS.values())
SETTING = tuple(one.name for kind in DECLARED for one in fields(kind))
Settings = namedtuple("Settings", SETTING)
"""`Parameters` and those of pin and crank, as kernels know them: floats, 0 of what is not there."""
_, settings_from = packed(Settings)


class OutputPlaces(NamedTuple):
    """Positions of outputs that are not scalars of a step, and of two that are."""

    cylinder_pressure: int
    side_force_demand: int
    modal_coordinate: int
    modal_velocity: int
    residual_evaluations: int
    jacobian_evaluations: int
    small_end_modal_coordinate: int
    small_end_modal_velocity: int


class FieldPlaces(NamedTuple):
    """First positions of the fields of films, and their numbers of cells: arrays over surfaces.

    push, drag : nodal forces, normal and tangential; work_error : the output of this name. For a
    tangent the forces are seeds, thickness and sliding are products.
    """

    push: Vector
    drag: Vector
    thickness: Vector
    sliding: Vector
    work_error: Vector
    cells: Vector


class VariablePlaces(NamedTuple):
    """Positions among the variables, `NOWHERE` if there is none.

    settings, scalars, pin_scalars : of `SETTING`, `Scalars` and `PinScalars`, in their order;
    rings, carrier : of `variables.RINGS` and `variables.BLOCK`; on_block : of the forces on a
    mounted block; motion : of the derivatives `model.MOTION`.
    """

    settings: Vector
    scalars: Vector
    pin_scalars: Vector
    gas_source: int
    gas_pressure: int
    land_pressure: int
    crank_speed: int
    rings: Vector
    rings_seed: Vector
    carrier: Vector
    carrier_seed: Vector
    on_block: Vector
    on_block_product: Vector
    motion_product: Vector
    outputs: OutputPlaces
    skirt: FieldPlaces
    skirt_tangent: FieldPlaces
    pins: FieldPlaces
    pins_tangent: FieldPlaces


# ---- what the rows hold


class Constants(NamedTuple):
    """Radius of the bore [m], and where a run begins that the build gives its start."""

    bore_radius: float
    start_given: bool
    start_angle: float


class GasCurve(NamedTuple):
    """`tables.GasTable`, empty without one."""

    angle: Vector
    pressure: Vector
    cycle: float


class BodySetup(NamedTuple):
    """Constant part of a memory.

    Members from `settings` on are made at the start, from the parameters, as are gaps and dampers
    in `system`.

    system : of any parameters; measured, widening : what is measured of skirt and bore;
    evaluations, tangents : work so far.
    """

    places: VariablePlaces
    constants: Constants
    fit: Fit
    system: BodySystem
    measured: Vector
    heights: Vector
    widening: Matrix
    inverse: Matrix
    gas: GasCurve
    start_position: Vector
    start_velocity: Vector
    piston_omega: Vector
    block_omega: Vector
    pin_surfaces: Vector
    eye_omega: Vector
    settings: Vector
    inertia: Matrix
    with_rod: Matrix
    has_linear: Number
    evaluations: Number
    tangents: Number


class Direction(NamedTuple):
    """Data that all directions of a derivative of a tied pin share.

    by_carrier : of a mounted block, `block_force.by_carrier`.
    """

    linear: LinearisedMotion
    by_carrier: Matrix


PART_OF = namedtuple("Parts", ("given", "state", "last", "direction", "faults"))(*range(5))
"""Numbers of the parts of a memory."""
_, _given = flatten(BodySetup)
put_state, _state = flatten(PistonState)
put_last, _last = flatten(StepEnd)
put_direction, _direction = flatten(Direction)


@compiled
def given_of(memory: np.ndarray):
    """Return `BodySetup`; writing into its arrays changes the memory."""
    return _given(part(memory, PART_OF.given))


@compiled
def state_of(memory: np.ndarray):
    """Return a copy of the state."""
    return _state(part(memory, PART_OF.state).copy())


@compiled
def last_of(memory: np.ndarray):
    """Return the end of the last step."""
    return _last(part(memory, PART_OF.last))


@compiled
def direction_of(memory: np.ndarray):
    """Return `Direction`."""
    return _direction(part(memory, PART_OF.direction))


@compiled
def settings_of(given: BodySetup):
    """Return the parameters of the last start."""
    return settings_from(given.settings)


@compiled
def has_pins(given: BodySetup):
    """Return whether the pin floats."""
    return pins_of(given.pin_surfaces) > 0


@compiled
def system_of(given: BodySetup) -> BodySystem:
    """Return both bodies, the mechanism and the film, as `assembly.assemble_system` makes them."""
    settings = settings_of(given)
    system = given.system
    return BodySystem(
        system.piston,
        system.piston_static,
        system.block,
        system.block_static,
        mechanism(given.fit.piston_radius, system.pin_offset, settings),
        system.surfaces,
        system.pin_offset,
        system.gas_force,
        BoreWall(
            system.wall.lowest,
            system.wall.spacing,
            system.wall.above,
            system.wall.at,
            settings.top_ring_height,
            settings.second_ring_height,
            settings.land_pressure_share,
        ),
    )


@compiled
def pin_system_of(given: BodySetup, system: BodySystem) -> PinSystem:
    """Return the same with a floating pin, as `assembly.assemble_floating` makes it."""
    x = given.fit
    settings = settings_of(given)
    none = np.zeros(0)
    radius = pin_radius(x.piston_radius, settings)
    bodies = PinBodies(
        system.piston,
        system.mechanism,
        pin_spin_inertia(settings.pin_mass, radius, settings.pin_inertia),
        AxisShapes(none, none, none, none, none),
        modal_springs(given.eye_omega, settings),
        Crankshaft(
            x.has_big_end,
            x.has_main_bearing,
            settings.crank_mass if x.has_main_bearing else 0.0,
            settings.crank_unbalance if x.has_main_bearing else 0.0,
        ),
    )
    return PinSystem(system, bodies, given.pin_surfaces, given.inertia, given.with_rod)
