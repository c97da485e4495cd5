"""Fields of films among the variables of a native FMU of bodies.

Kernels stack the fields of all film surfaces of a kind, their cells one after another.
"""

import numpy as np

from ..master.fmi.block import keep
from ..master.fmi.compiled import compiled


@compiled
def stacked(real, first, size):
    """Return variables from a position on."""
    return real[int(first) : int(first) + int(size)]


@compiled
def gathered(real, begins, cells):
    """Return a field of all film surfaces, their cells one after another."""
    field = np.empty(int(cells.sum()))
    first = 0
    for s in range(len(cells)):
        keep(stacked(field, first, cells[s]), stacked(real, begins[s], cells[s]))
        first += int(cells[s])
    return field


@compiled
def scatter(real, begins, cells, field):
    """Write a stacked field into the variables of all film surfaces."""
    first = 0
    for s in range(len(cells)):
        keep(stacked(real, begins[s], cells[s]), stacked(field, first, cells[s]))
        first += int(cells[s])


@compiled
def put_stacked(real, first, values):
    """Put an array into the variables from a position on."""
    keep(stacked(real, first, len(values)), values)


@compiled
def forces_at(real, places):
    """Return normal and tangential forces of films, or their seeds."""
    push = gathered(real, places.push, places.cells)
    return push, gathered(real, places.drag, places.cells)


@compiled
def put_films(real, places, thickness, sliding):
    """Write the motion of all films into the variables, or its products."""
    scatter(real, places.thickness, places.cells, thickness)
    scatter(real, places.sliding, places.cells, sliding)
