"""Force elements of a cylinder for the parameters of an FMU."""

import numpy as np

from ...master.fmi.compiled import compilable
from ..force_elements import FORCE_ELEMENTS
from ..force_elements.element import BODIES
from ..mechanism.chain import BLOCK
from ..mechanism.cylinder import CylinderLaws
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
MOST = max((len(one.names()) for one in FORCE_ELEMENTS), default=0)


@compilable
def cylinder_laws(p: Settings) -> CylinderLaws:
    """Return the force elements whose first parameter is not 0."""
    n = 0
    for k in range(COUNT):
        n += 1 if p[FIRST[k]] != 0.0 else 0
    kind, numbers, height = np.empty(n, np.int64), np.zeros((n, MOST)), np.zeros(n)
    out = CylinderLaws(kind, np.empty(n, np.int64), np.empty(n, np.int64), height, numbers)
    at = 0
    for k in range(COUNT):
        if p[FIRST[k]] != 0.0:
            kind[at], out.acts[at], out.reacts[at] = k, ACTS[k], REACTS[k]
            for i in range(SIZE[k]):
                numbers[at, i] = p[FIRST[k] + i]
            if HEIGHT[k] >= 0:
                height[at] = p[HEIGHT[k]]
            at += 1
    return out
