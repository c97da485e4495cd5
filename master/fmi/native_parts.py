"""Native part of a participant package: the value `PART` of its module `native`."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from .compiled import compiled
from .slave import reserved

NOWHERE = -1
"""Position of a variable that does not exist."""
WHOLE, TO_COORDINATES, FROM_COORDINATES, READ, PLACE, MEASURE = map(float, range(6))
"""Task of an entry `tangent`, the first of its numbers.

WHOLE: from seeds to products. The others use the coordinates of the model, on which its outputs
depend. TO_COORDINATES, FROM_COORDINATES: from seeds to changes of them, and on to products, roughly
if the second of the numbers is not 0.
READ: write them, at the end of the step. PLACE: outputs at coordinates at the end of a step from
the state, whose length is the second of the numbers [s]. MEASURE: write how much each one changes
the outputs.
"""


@compiled
def get_each(real: np.ndarray, places: np.ndarray):
    """Return the variables at these positions, 0 if there is none."""
    numbers = np.zeros(len(places))
    for k in range(len(places)):
        if places[k] >= 0.0:
            numbers[k] = real[int(places[k])]
    return numbers


@compiled
def put_each(real: np.ndarray, places: np.ndarray, values: Any):
    """Write numbers into the variables at these positions."""
    for k in range(len(places)):
        if places[k] >= 0.0:
            real[int(places[k])] = values[k]


def symbol(package: str, name: str) -> str:
    """Return the symbol of a package's entry, since a library may contain several packages."""
    return f"{package.replace('.', '_')}_{name}"


def positions_of(slave: Any, names: Iterable[str], kind: str = "") -> np.ndarray:
    """Return the positions of variables of a slave, or of their seeds or products, `kind`."""
    keys = (reserved(kind, name) if kind else name for name in names)
    return np.array([slave.references.get(key, NOWHERE) for key in keys], dtype=float)


class NativePart(NamedTuple):
    """The compiled side of a model class.

    Attributes
    ----------
    entries : tuple of compiled.Kernel
        start, advance and tangent, `front/native.h`: kernels of four arrays without result,
        (real, integer, memory, numbers). They are real and integer variables of the FMU, its
        memory, and a few numbers of the call.
    setup : callable
        Returns the first part of an FMU's memory, ndarray of float64.
    faults : tuple of str
        Sentences by number.
    refusal : str
        First part of the message of a discarded step.
    uncovered : callable
        Yields faults of build options, checked or as in a case, that the library does not cover.
    uncovered_values : callable
        As `uncovered`, for all parameters in SI, choices by number.
    coordinates : int
        Part of the memory, `NOWHERE` for none: all coordinates of the model, or their change.
    direct : tuple of str
        Outputs that inputs also change without the coordinates.
    """

    entries: tuple[Any, ...]
    setup: Callable[[Any], Any]
    faults: tuple[str, ...]
    refusal: str
    uncovered: Callable[[Mapping[str, Any]], Iterable[str]] = lambda options: ()
    uncovered_values: Callable[[Mapping[str, Any]], Iterable[str]] = lambda values: ()
    coordinates: int = NOWHERE
    direct: tuple[str, ...] = ()
