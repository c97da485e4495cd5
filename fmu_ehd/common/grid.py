"""The film grid: its cells, its edges, and how a five-point stencil is laid out on it.

A grid is a ring, a sector, or mirrored: half of a ring that is its own mirror image, from the line
of one mirror plane to the other. The first and the last row are their own images, every other row
represents two. Areas, faces, volumes and flows of a mirrored grid are those of all images, so

Eq. (E19):  width of row i = a_i dx,   height of the faces between two rows = 2 dy,
            a_i = 1 for the first and the last row, else 2

The flow out of the first row over its only face is that over both of its faces. There is no flow
over the sides. Balances and sums over all cells are then those of the whole film.
"""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...master.fmi.compiled import compilable, compiled, standing_for

Array = NDArray[np.float64]  # of the shape in the docstring
Flags = NDArray[np.bool_]
Field = Annotated[Array, "n_c, n_a"]
AxialFaces = Annotated[Array, "n_c, n_a + 1"]
FacesAround = Annotated[Array, "n_c + 1, n_a"]
Stencil = Annotated[Array, "5, n_c, n_a"]

# axis of the edges: both ends of the skirt, the two sides of a grid that is no ring, openings
LOWER, UPPER, FIRST, LAST, OPENINGS = range(5)

# axis of a stencil, shape (5, n_c, n_a): coefficient of the cell itself and of its neighbours
# j - 1 (south), j + 1 (north), i - 1 (west), i + 1 (east)
CENTRE, SOUTH, NORTH, WEST, EAST = range(5)


class Cells(NamedTuple):
    """Properties of a grid for kernels.

    dx, dy : cell size along i (circumferential) and j (axial) [m]; ring : True if i is periodic;
    mirrored : True for half of a ring.
    """

    dx: float
    dy: float
    ring: bool
    mirrored: bool


class Edges(NamedTuple):
    """Oil supply at the edges and in openings.

    The order is lower, upper, first, last, openings; first and last are unused on a ring.

    pressure : ndarray, shape (5,), above cavitation pressure [Pa], >= 0.
    film_fraction : ndarray, shape (5,), film fraction of the oil that sliding drags in [-], 0 to 1;
    below 1 only at cavitation pressure, `contradictions`.
    limit : ndarray, shape (n_c, n_a + 1), largest flow that sliding can drag into the film over an
    axial face at an edge or an opening [m3/s]; inf if the supply is unlimited.
    """

    pressure: Annotated[Array, "5"]
    film_fraction: Annotated[Array, "5"]
    limit: AxialFaces


class Entrainment(NamedTuple):
    """Entrainment velocity (the mean of both surfaces) along i and along j, or its derivative.

    circumferential, axial : ndarray, shape (n_c, n_a) [m/s].
    """

    circumferential: Array
    axial: Array


@compiled(forceinline=True)
def images(mirrored: bool, i: int, n_c: int):
    """Return the number of rows of the film that row i of a grid represents, Eq. (E19) [-]."""
    return 2.0 if mirrored and 0 < i < n_c - 1 else 1.0  # Eq. (E19)


@compiled(forceinline=True)
def row_at(cells: Cells, i: int, n_c: int):
    """Return the row at position i, which may be up to n_c - 1 rows beyond the grid.

    It is -1 beyond a sector.
    """
    if cells.ring:
        return i % n_c
    if cells.mirrored:
        return n_c - 1 - abs(n_c - 1 - abs(i))
    return i if 0 <= i < n_c else -1


@compiled(forceinline=True)
def face_shares(open_a: bool, open_b: bool):
    """Return the shares of both cells in the velocity at their face, 0 of a cell without a film."""
    if open_b:
        return 1.0, 0.0
    if open_a:
        return 0.0, 1.0
    return 0.5, 0.5


@compiled
def axial_face_velocity(velocity: Array, open_cells: Flags):
    """Return the entrainment velocity at the axial faces, shape (n_c, n_a + 1) [m/s].

    velocity : ndarray, shape (n_c, n_a), along j [m/s].
    """
    n_c, n_a = velocity.shape
    at_face = np.empty((n_c, n_a + 1))
    for i in range(n_c):
        for j in range(n_a + 1):
            a = max(j - 1, 0)
            b = min(j, n_a - 1)
            share_a, share_b = face_shares(open_cells[i, a], open_cells[i, b])
            at_face[i, j] = share_a * velocity[i, a] + share_b * velocity[i, b]
    return at_face


@compiled
def face_velocity_around(velocity: Array, open_cells: Flags, ring: bool):
    """Return the entrainment velocity at the faces across i, shape (n_c + 1, n_a) [m/s].

    velocity : ndarray, shape (n_c, n_a), along i [m/s].
    """
    n_c, n_a = velocity.shape
    at_face = np.empty((n_c + 1, n_a))
    for i in range(n_c + 1):
        a = (i - 1) % n_c if ring else max(i - 1, 0)
        b = i % n_c if ring else min(i, n_c - 1)
        for j in range(n_a):
            share_a, share_b = face_shares(open_cells[a, j], open_cells[b, j])
            at_face[i, j] = share_a * velocity[a, j] + share_b * velocity[b, j]
    return at_face


@compilable
def unlimited_supply(shape: tuple[int, int]) -> Array:
    """Return `Edges.limit` of a grid of this shape without a limit."""
    n_c, n_a = shape
    return np.full((n_c, n_a + 1), np.inf)


@compiled
def keep(target: Array, values: np.ndarray):
    """Copy an array into a contiguous one of the same shape, in a loop.

    Native code cannot raise the error of numpy about unequal shapes.
    """
    to = target.reshape(target.size)
    of = values.reshape(values.size)
    for k in range(to.size):
        to[k] = of[k]


@standing_for(keep)
def put(target: Array, values: Array) -> None:
    """Copy an array into one of the same shape; kernels run `keep`."""
    target[...] = values


@compiled
def _add(target, values):
    for i in range(target.shape[0]):
        for j in range(target.shape[1]):
            target[i, j] += values[i, j]


@standing_for(_add)
def add(target: Array, values: Array) -> None:
    """Add an array of shape (n_c, n_a) to a part of another; in place."""
    target += values


@compiled
def sum_of_products(a: Array, b: Array):
    """Return the sum of the products of two fields of shape (n, m), such as a volume [m3].

    >>> sum_of_products(np.full((2, 3), 10e-6), np.full((2, 3), 1e-4))
    6e-09
    """
    total = 0.0
    for i in range(a.shape[0]):
        for j in range(a.shape[1]):
            total += a[i, j] * b[i, j]
    return total
