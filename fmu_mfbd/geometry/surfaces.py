"""All film surfaces of a body in one block of float64 numbers. How many there are, kernels are told
when they run; of a tuple they know it when they are compiled, and are compiled for each number.
"""

from collections.abc import Sequence

import numpy as np

from ...master.fmi.block import flatten, reader, row_of
from ...master.fmi.compiled import compilable
from .film import BoreSplines, FilmSurface, Skirt, knot_rule
from .pin import PinSurface

HEAD = 1
"""A block begins with the number of its rows and the place of each."""

_skirt = reader(Skirt)
_bore = reader(BoreSplines)
put_pin_surface, _pin_surface = flatten(PinSurface)


# ---- in Python


def in_block(surfaces: Sequence[FilmSurface]) -> np.ndarray:
    """Return surfaces as one block, two rows each; a bore that several have lies in it once."""
    return _rows([side for surface in surfaces for side in surface])


def pins_in_block(surfaces: Sequence[PinSurface]) -> np.ndarray:
    """Return films of a pin and of the crank as one block."""
    return _rows(surfaces)


def _rows(trees):
    """Return rows of trees behind their number and places."""
    end = HEAD + len(trees)
    places: dict[int, int] = {}
    rows = []
    for tree in trees:
        if id(tree) not in places:
            places[id(tree)] = end
            rows.append(row_of(tree))
            end += rows[-1].size
    return np.concatenate([[len(trees)], [places[id(tree)] for tree in trees], *rows])


def with_room(surfaces: Sequence[FilmSurface], stations: int) -> Sequence[FilmSurface]:
    """Return the same, with room for what widens the bore that they share at its stations where
    nothing does.
    """
    bore = surfaces[0].bore
    if len(bore.shape):
        return surfaces
    none = np.zeros((len(knot_rule(stations)), bore.shape.shape[1]))
    roomy = bore._replace(shape=none)
    return [one._replace(bore=roomy) for one in surfaces]


def each_of(block: np.ndarray) -> tuple[FilmSurface, ...]:
    """Return all surfaces, their arrays the block's own numbers."""
    return tuple(surface_at(block, k) for k in range(count_of(block)))


# ---- in kernels and in Python


@compilable
def row_at(block: np.ndarray, k: int) -> np.ndarray:
    """Return the k-th row, and what is behind it."""
    return block[int(block[HEAD + k]) :]


@compilable
def count_of(block: np.ndarray) -> int:
    """Return how many surfaces there are."""
    return int(block[0]) // 2


@compilable
def surface_at(block: np.ndarray, k: int) -> FilmSurface:
    """Return the k-th surface, its arrays the block's own numbers."""
    return FilmSurface(_skirt(row_at(block, 2 * k)), _bore(row_at(block, 2 * k + 1)))


@compilable
def pins_of(block: np.ndarray) -> int:
    """Return how many films of pin and crank there are."""
    return int(block[0])


@compilable
def pin_surface_at(block: np.ndarray, k: int) -> PinSurface:
    """Return the k-th film of pin and crank, its arrays the block's own numbers."""
    return _pin_surface(row_at(block, k))
