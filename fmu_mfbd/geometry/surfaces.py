"""All film surfaces of a body in one array of float64 numbers.

Kernels read the number of surfaces from the array. A tuple would require a compilation for each
number.
"""

from collections.abc import Sequence

import numpy as np

from ...master.fmi.block import flatten, reader, row_of
from ...master.fmi.compiled import compilable
from .film import BoreSplines, FilmSurface, Skirt, knot_rule
from .pin import PinSurface

HEADER_LENGTH = 1
"""Number of values before the offsets of the rows: the number of rows."""

_skirt = reader(Skirt)
_bore = reader(BoreSplines)
put_pin_surface, _pin_surface = flatten(PinSurface)


# ---- in Python


def in_block(surfaces: Sequence[FilmSurface]) -> np.ndarray:
    """Return surfaces as one block of two rows each, with a common bore only once."""
    return _rows([side for surface in surfaces for side in surface])


def pins_in_block(surfaces: Sequence[PinSurface]) -> np.ndarray:
    """Return films of a pin and of the crank as one block."""
    return _rows(surfaces)


def _rows(trees):
    """Return the number of trees, the offset of each, and their rows."""
    end = HEADER_LENGTH + len(trees)
    offsets: dict[int, int] = {}
    rows = []
    for tree in trees:
        if id(tree) not in offsets:
            offsets[id(tree)] = end
            rows.append(row_of(tree))
            end += rows[-1].size
    return np.concatenate([[len(trees)], [offsets[id(tree)] for tree in trees], *rows])


def with_room(surfaces: Sequence[FilmSurface], stations: int) -> Sequence[FilmSurface]:
    """Return the surfaces with a table for the widening of their common bore, if it has none."""
    bore = surfaces[0].bore
    if len(bore.shape):
        return surfaces
    none = np.zeros((len(knot_rule(stations)), bore.shape.shape[1]))
    roomy = bore._replace(shape=none)
    return [one._replace(bore=roomy) for one in surfaces]


def each_of(block: np.ndarray) -> tuple[FilmSurface, ...]:
    """Return all surfaces; their arrays are views of the block."""
    return tuple(surface_at(block, k) for k in range(count_of(block)))


def each_pin_of(block: np.ndarray) -> tuple[PinSurface, ...]:
    """Return all films of pin and crank; their arrays are views of the block."""
    return tuple(pin_surface_at(block, k) for k in range(pins_of(block)))


# ---- in kernels and in Python


@compilable
def row_at(block: np.ndarray, k: int) -> np.ndarray:
    """Return the k-th row and all following ones."""
    return block[int(block[HEADER_LENGTH + k]) :]


@compilable
def count_of(block: np.ndarray) -> int:
    """Return the number of surfaces."""
    return int(block[0]) // 2


@compilable
def surface_at(block: np.ndarray, k: int) -> FilmSurface:
    """Return the k-th surface; its arrays are views of the block."""
    return FilmSurface(_skirt(row_at(block, 2 * k)), _bore(row_at(block, 2 * k + 1)))


@compilable
def pins_of(block: np.ndarray) -> int:
    """Return the number of films of pin and crank."""
    return int(block[0])


@compilable
def pin_surface_at(block: np.ndarray, k: int) -> PinSurface:
    """Return the k-th film of pin and crank; its arrays are views of the block."""
    return _pin_surface(row_at(block, k))
