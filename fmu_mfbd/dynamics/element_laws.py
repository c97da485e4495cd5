"""Force elements of a cylinder for the parameters of an FMU."""

import numpy as np

from ...master.fmi.compiled import compilable
from ..force_elements import FORCE_ELEMENTS, SLIDES
from ..force_elements.element import BODIES
from ..mechanism.chain import BLOCK, IN_BLOCK, IN_PARENT
from ..mechanism.cylinder import CylinderLaws, FreeSlides
from .parameters import Settings

SWITCHES = tuple(one.names()[0] for one in FORCE_ELEMENTS)
"""First parameter of each force element, with which it exists."""

NUMBERS = {"block": BLOCK} | {name: k for k, name in enumerate(BODIES)}
COUNT = len(FORCE_ELEMENTS)
ACTS, REACTS, FIRST, SIZE, HEIGHT = (
    np.array(
        [
            (
                NUMBERS[one.acts],
                NUMBERS[one.reacts],
                Settings._fields.index(one.names()[0]),
                len(one.names()),
                Settings._fields.index(one.height) if one.height else -1,
            )
            for one in FORCE_ELEMENTS
        ],
        dtype=np.int64,
    )
    .reshape(COUNT, 5)
    .T.copy()
)
"""Bodies of each force element, first of its parameters among `Settings`, and their number.

The last one is that of its height, -1 if it has none.
"""
OF_SLIDE = np.array([FORCE_ELEMENTS.index(one) for one in SLIDES.values()], dtype=np.int64)
WAYS = np.array([one.frees[name] for name, one in SLIDES.items()], dtype=float).reshape(-1, 2)
"""Element of each of `SLIDES`, and its direction."""
MOST_PARAMETERS = max((len(one.names()) for one in FORCE_ELEMENTS), default=0)


@compilable
def cylinder_laws(p: Settings, slides: np.ndarray) -> CylinderLaws:
    """Return the force elements whose first parameter is not 0, or that free these `SLIDES`."""
    exists, n = np.zeros(COUNT, np.int64), 0
    for k in range(COUNT):
        exists[k] = 1 if p[FIRST[k]] != 0.0 else 0
    for slide in slides:
        exists[OF_SLIDE[slide]] = 1
    for k in range(COUNT):
        n += exists[k]
    kind, numbers, height = np.empty(n, np.int64), np.zeros((n, MOST_PARAMETERS)), np.zeros(n)
    out = CylinderLaws(kind, np.empty(n, np.int64), np.empty(n, np.int64), height, numbers)
    at = 0
    for k in range(COUNT):
        if exists[k]:
            kind[at], out.acts[at], out.reacts[at] = k, ACTS[k], REACTS[k]
            for i in range(SIZE[k]):
                numbers[at, i] = p[FIRST[k] + i]
            if HEIGHT[k] >= 0:
                height[at] = p[HEIGHT[k]]
            at += 1
    return out


@compilable
def free_slides(slides: np.ndarray) -> FreeSlides:
    """Return the slides of these numbers in `SLIDES`."""
    n = len(slides)
    out = FreeSlides(np.empty(n, np.int64), np.empty(n, np.int64), np.empty((n, 2)))
    for k in range(n):
        own = slides[k]
        out.acts[k] = ACTS[OF_SLIDE[own]]
        out.turns[k] = IN_BLOCK if REACTS[OF_SLIDE[own]] == BLOCK else IN_PARENT
        out.direction[k, 0], out.direction[k, 1] = WAYS[own, 0], WAYS[own, 1]
    return out
