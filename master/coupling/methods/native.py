"""Entry of the iteration of a macro step, for `run` and for native coupled FMUs."""

import numpy as np

from ...fmi.compiled import compiled
from ...fmi.native_parts import CALL, Entry, NativePart
from ..native_system import find


@compiled
def iterate(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Iterate a macro step to its fixed point; the memory is that of `native_block`.

    real : guess, then the solution; numbers : length of the step and its begin [s], the last one is
    set to 1 if there is a solution, else to 0. `integer` is unused.
    """
    numbers[-1] = 1.0 if find(memory, real, numbers[1], numbers[0]) else 0.0


PART = NativePart(
    (Entry(iterate),), np.asarray, lambda options: (), {}, (), "", asks=frozenset({CALL})
)
"""Not a model: only the entry is used."""
