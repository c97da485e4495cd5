"""Temperatures of walls among the variables of a native FMU of bodies."""

from typing import Any, NamedTuple

import numpy as np

from ..master.fmi.compiled import compilable
from ..master.fmi.native_parts import positions_of
from .dynamics.assembly import BodySetup
from .dynamics.model import OIL
from .geometry.arrays import Vector
from .geometry.surfaces import surface_at
from .variables import WALL_FIELDS


class WallPositions(NamedTuple):
    """First positions of temperature fields and their numbers of cells, by film.

    skirt, bore : inputs of both walls; oil : outputs of the films. Arrays may be empty.
    """

    skirt: Vector
    skirt_cells: Vector
    bore: Vector
    bore_cells: Vector
    oil: Vector
    oil_cells: Vector


def wall_positions(slave: Any) -> WallPositions:
    """Return the positions of temperature fields among the variables of an FMU instance."""
    walls = slave.built.temperatures
    around, _ = slave.built.grid
    films = slave.built.film_grids()
    skirt = films if walls and walls.skirt.varies else ()
    bore = [(around, walls.stations)] if walls and walls.bore.varies else []
    oil = films if walls else ()

    def cells(shapes):
        return np.array([np.prod(shape) for shape in shapes], dtype=float)

    return WallPositions(
        skirt=positions_of(slave, [f"{one.prefix}{WALL_FIELDS['skirt']}" for one in skirt]),
        skirt_cells=cells(one.shape for one in skirt),
        bore=positions_of(slave, [WALL_FIELDS["bore"]] * len(bore)),
        bore_cells=cells(bore),
        oil=positions_of(slave, [f"{one.prefix}{OIL}" for one in oil]),
        oil_cells=cells(one.shape for one in oil),
    )


@compilable
def growths_of(bodies: BodySetup, walls: WallPositions) -> int:
    """Return the length of `PistonState.field_growth`."""
    knots = surface_at(bodies.surfaces, 0).bore.temperature.size
    return int(walls.skirt_cells.sum()) + (knots if len(walls.bore) > 0 else 0)
