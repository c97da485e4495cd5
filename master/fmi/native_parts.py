"""Native part of a participant package: the value `PART` of its module `native`."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from .compiled import compiled


class Entry(NamedTuple):
    """Kernel of four arrays without result, (real, integer, memory, numbers).

    They are real and integer variables of the FMU, its memory, and a few numbers of the call.
    """

    kernel: Any  # compiled.Kernel

    def name(self, package: str) -> str:
        """Return the name of the function in the library, which may contain several packages."""
        return symbol(package, self.kernel.py_func.__name__)


@compiled
def tell_size(memory: np.ndarray, numbers: np.ndarray, is_sound: bool):
    """Write the head of a memory into `numbers`, negative if the memory is not sound.

    They are total length, position and length of the state, and position of the faults.
    """
    for k in range(len(numbers)):
        numbers[k] = memory[k] if is_sound else -1.0


@compiled
def size(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """Write the head of a memory into `numbers`: an entry `size` that checks nothing."""
    tell_size(memory, numbers, True)


def symbol(package: str, name: str) -> str:
    """Return the symbol of a package's entry in object files."""
    return f"{package.replace('.', '_')}_{name}"


class NativePart(NamedTuple):
    """The compiled side of a model class.

    Attributes
    ----------
    entries : tuple of Entry
        size, start, advance and tangent, `front/native.h`.
    given : callable
        Returns the first part of an FMU's memory, ndarray of float64.
    uncovered : callable
        Yields faults of checked build options that the library does not cover.
    faults : tuple of str
        Sentences by number.
    refusal : str
        First part of the message of a discarded step.
    uncovered_ahead : callable
        As `uncovered`, for build options as in a case.
    uncovered_values : callable
        As `uncovered`, for all parameters in SI, choices by number.
    """

    entries: tuple[Entry, ...]
    given: Callable[[Any], Any]
    uncovered: Callable[[dict[str, Any]], Iterable[str]]
    faults: tuple[str, ...]
    refusal: str
    uncovered_ahead: Callable[[Mapping[str, Any]], Iterable[str]] = lambda options: ()
    uncovered_values: Callable[[Mapping[str, Any]], Iterable[str]] = lambda values: ()
