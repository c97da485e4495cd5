"""All films of a pin and of the crank in one block of float64 numbers, as those of the skirt in
`surfaces`: kernels are told their number, modes and shapes when they run.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from ...master.fmi.compiled import compilable
from .pin import PinSurface, ShellModes

HEAD = 1
"""The block begins with the number of surfaces; for each part of each then first and last place."""
NUMBERS, OUTWARD, ONWARD, CLEARANCE, MODES_OUTWARD, MODES_ONWARD, MODES_SLOPE, AXIS, PARTS = range(
    9
)


# ---- in Python


def in_block(surfaces: Sequence[PinSurface]) -> np.ndarray:
    """Surfaces as one block."""
    end = HEAD + 2 * PARTS * len(surfaces)
    places: list[int] = []
    pieces: list[np.ndarray] = []
    for surface in surfaces:
        for piece in _parts(surface):
            places += [end, end + piece.size]
            pieces.append(piece)
            end += piece.size
    return np.concatenate([[len(surfaces)], places, *pieces]).astype(float)


def _parts(surface: PinSurface) -> Iterator[np.ndarray]:
    """Parts of a surface in their order."""
    yield np.array([surface.radius])
    yield surface.outward.ravel()
    yield surface.onward.ravel()
    yield surface.clearance
    yield from (one.ravel() for one in surface.modes)
    yield surface.axis.ravel()


def each_of(block: np.ndarray) -> tuple[PinSurface, ...]:
    """All of them, their arrays the block's own numbers."""
    return tuple(pin_surface_at(block, k) for k in range(pins_of(block)))


# ---- in kernels and in Python


@compilable
def pins_of(block: np.ndarray) -> int:
    """How many there are."""
    return int(block[0])


@compilable
def part_of_pin(block: np.ndarray, k: int, which: int) -> np.ndarray:
    """A part of the k-th surface."""
    at = HEAD + 2 * (PARTS * k + which)
    return block[int(block[at]) : int(block[at + 1])]


@compilable
def pin_surface_at(block: np.ndarray, k: int) -> PinSurface:
    """The k-th of them, its arrays the block's own numbers."""
    outward = part_of_pin(block, k, OUTWARD)
    clearance = part_of_pin(block, k, CLEARANCE)
    around = len(outward) // 2
    along = len(clearance)
    cells = around * along
    yields = part_of_pin(block, k, MODES_OUTWARD)
    axis = part_of_pin(block, k, AXIS)
    of_modes = (cells, len(yields) // cells)
    return PinSurface(
        outward.reshape((2, around)),
        part_of_pin(block, k, ONWARD).reshape((2, around)),
        part_of_pin(block, k, NUMBERS)[0],
        clearance,
        ShellModes(
            yields.reshape(of_modes),
            part_of_pin(block, k, MODES_ONWARD).reshape(of_modes),
            part_of_pin(block, k, MODES_SLOPE).reshape(of_modes),
        ),
        axis.reshape((along, len(axis) // along)),
    )


@compilable
def pin_cells(block: np.ndarray, k: int) -> int:
    """Cells of the k-th surface."""
    return len(part_of_pin(block, k, OUTWARD)) // 2 * len(part_of_pin(block, k, CLEARANCE))
