"""All film surfaces of a body in one block of float64 numbers. How many there are, kernels are told
when they run; of a tuple they know it when they are compiled, and are compiled for each number.

Tables of single precision and whole numbers lie in the block by their bits.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from ...master.fmi.compiled import compilable
from .film import Bore, FilmSurface, Skirt, knot_rule
from .modal_field import ModalField

HEAD = 1
"""The block begins with the number of surfaces; for each part of each then first and last place."""
OF_FIELD = ("sizes", "table", "mode", "kind", "image", "share")
SIZES, TABLE, MODE, KIND, IMAGE, SHARE = range(len(OF_FIELD))
LINES, LENGTH, MODES, CLASSES, WIDTH = range(5)  # sizes of a modal field
SKIRT_NUMBERS, ANGLE, HEIGHT, GAP, SKIRT_RADIAL = range(5)
SKIRT_AXIAL = SKIRT_RADIAL + len(OF_FIELD)
BORE_NUMBERS = SKIRT_AXIAL + len(OF_FIELD)
SHAPE = BORE_NUMBERS + 1
BORE_RADIAL = SHAPE + 1
BORE_AXIAL = BORE_RADIAL + len(OF_FIELD)
PARTS = BORE_AXIAL + len(OF_FIELD)
"""Of a surface: those of the skirt, then those of the bore."""


# ---- in Python


def in_block(surfaces: Sequence[FilmSurface]) -> np.ndarray:
    """Surfaces as one block; a bore that several have lies in it once."""
    end = HEAD + 2 * PARTS * len(surfaces)
    places: list[int] = []
    pieces: list[np.ndarray] = []
    known: dict[int, list[int]] = {}
    for surface in surfaces:
        for side, parts in (
            (surface.skirt, _of_skirt(surface.skirt)),
            (surface.bore, _of_bore(surface.bore)),
        ):
            if id(side) not in known:
                known[id(side)] = []
                for piece in parts:
                    known[id(side)] += [end, end + piece.size]
                    pieces.append(piece)
                    end += piece.size
            places += known[id(side)]
    return np.concatenate([[len(surfaces)], places, *pieces])


def with_room(surfaces: Sequence[FilmSurface], stations: int) -> Sequence[FilmSurface]:
    """The same, with room for what widens the bore that they share at its stations where nothing
    does.
    """
    bore = surfaces[0].bore
    if len(bore.shape):
        return surfaces
    none = np.zeros((len(knot_rule(stations)), bore.shape.shape[1]))
    roomy = bore._replace(shape=none)
    return [one._replace(bore=roomy) for one in surfaces]


def _of_skirt(skirt: Skirt) -> Iterator[np.ndarray]:
    """Parts of a skirt in their order."""
    yield np.array([skirt.radius, skirt.pin_offset])
    yield skirt.angle
    yield skirt.height
    yield skirt.gap.ravel()
    yield from _of_field(skirt.radial)
    yield from _of_field(skirt.axial)


def _of_bore(bore: Bore) -> Iterator[np.ndarray]:
    """Parts of a bore in their order."""
    yield np.array([bore.lowest, bore.spacing])
    yield bore.shape.ravel()
    yield from _of_field(bore.radial)
    yield from _of_field(bore.axial)


def _of_field(field: ModalField) -> Iterator[np.ndarray]:
    """Parts of a modal field in their order."""
    lines, length = field.table.shape
    table = np.zeros(field.table.size + field.table.size % 2, dtype=np.float32)
    table[: field.table.size] = field.table.ravel()
    yield np.array([lines, length, field.modes, field.classes, field.part], dtype=float)
    yield table.view(float)
    for whole in (field.mode, field.kind, field.image):
        yield np.ascontiguousarray(whole, dtype=np.int64).ravel().view(float)
    yield field.share


def each_of(block: np.ndarray) -> tuple[FilmSurface, ...]:
    """All of them, their arrays the block's own numbers."""
    return tuple(surface_at(block, k) for k in range(count_of(block)))


# ---- in kernels and in Python


@compilable
def count_of(block: np.ndarray) -> int:
    """How many there are."""
    return int(block[0])


@compilable
def _part(block, k, which):
    """A part of the k-th surface."""
    at = HEAD + 2 * (PARTS * k + which)
    return block[int(block[at]) : int(block[at + 1])]


@compilable
def surface_at(block: np.ndarray, k: int) -> FilmSurface:
    """The k-th of them, its arrays the block's own numbers."""
    angle = _part(block, k, ANGLE)
    height = _part(block, k, HEIGHT)
    shape = _part(block, k, SHAPE)
    of_skirt = _part(block, k, SKIRT_NUMBERS)
    of_bore = _part(block, k, BORE_NUMBERS)
    skirt = Skirt(
        angle,
        height,
        _part(block, k, GAP).reshape((len(angle), len(height))),
        of_skirt[0],
        of_skirt[1],
        _field(block, k, SKIRT_RADIAL),
        _field(block, k, SKIRT_AXIAL),
    )
    bore = Bore(
        of_bore[0],
        of_bore[1],
        _field(block, k, BORE_RADIAL),
        _field(block, k, BORE_AXIAL),
        shape.reshape((len(shape) // len(angle), len(angle))),
    )
    return FilmSurface(skirt, bore)


@compilable
def _field(block, k, first):
    """The modal field whose parts of the k-th surface begin with `first`."""
    sizes = _part(block, k, first + SIZES)
    lines = int(sizes[LINES])
    length = int(sizes[LENGTH])
    classes = int(sizes[CLASSES])
    width = int(sizes[WIDTH])
    table = _part(block, k, first + TABLE).view(np.float32)
    return ModalField(
        table[: lines * length].reshape((lines, length)),
        _part(block, k, first + MODE).view(np.int64),
        _part(block, k, first + KIND).view(np.int64),
        int(sizes[MODES]),
        classes,
        width,
        _part(block, k, first + IMAGE).view(np.int64).reshape((classes, width)),
        _part(block, k, first + SHARE),
    )
