"""What a participant package says of itself to become an FMU that needs no Python: the value
`PART` of its module `native`.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from .compiled import compiled
from .variables import Variable

CALL = "native_part"
"""Runs an entry of a participant inside a coupled slave, front/parts.c."""


class Entry(NamedTuple):
    """A kernel of four arrays, (real, integer, memory, numbers), and no result: real and integer
    variables of the slave, its own memory and a few numbers of the call.
    """

    kernel: Any  # compiled.Kernel

    def name(self, package: str) -> str:
        """Of the function in the library, where entries of several packages may meet."""
        return symbol(package, self.kernel.py_func.__name__)


@compiled
def size(real: np.ndarray, integer: np.ndarray, memory: np.ndarray, numbers: np.ndarray):
    """The entry `size` of a memory that begins with what is asked for: lengths of the whole, where
    its state begins and how long that is, where faults are; into `numbers`.
    """
    for k in range(len(numbers)):
        numbers[k] = memory[k]


def symbol(package: str, name: str) -> str:
    """Of an entry of a package in object files."""
    return f"{package.replace('.', '_')}_{name}"


class NativePart(NamedTuple):
    """The compiled side of a slave.

    entries : size, start, advance and tangent, `front/native.h`;
    given : what the memory of a slave begins with, ndarray of float64, for the slave;
    uncovered : sentences on build options that the library does not cover;
    covered : name of a parameter to the choices, or to the one value, that the library covers;
    faults : sentences by their number;
    refusal : what stands before the sentence of a refused step;
    uncovered_ahead : as `uncovered`, of build options as a case gives them;
    uncovered_values : the same of parameters, all of them, in SI and choices by their numbers;
    asks : functions that the entries call besides those of `native_code.OPEN`.
    """

    entries: tuple[Entry, ...]
    given: Callable[[Any], Any]
    uncovered: Callable[[dict[str, Any]], Iterable[str]]
    covered: Mapping[str, tuple[str, ...] | float]
    faults: tuple[str, ...]
    refusal: str
    uncovered_ahead: Callable[[Mapping[str, Any]], Iterable[str]] = lambda options: ()
    uncovered_values: Callable[[Mapping[str, Any]], Iterable[str]] = lambda values: ()
    asks: frozenset[str] = frozenset()


def uncovered_values(
    part: NativePart, variables: Sequence[Variable], given: Mapping[str, Any]
) -> Iterator[str]:
    """Sentences on parameters of a participant that are valid, but not covered by its machine code.

    Parameters
    ----------
    part : NativePart
    variables : sequence of Variable
    given : mapping
        Values in SI, choices by their numbers; the others are at their start values.
    """
    values = {v.name: v.number(v.start) for v in variables} | dict(given)
    for v in variables:
        known = part.covered.get(v.name)
        value = given.get(v.name)
        if known is None or value is None:
            continue
        if isinstance(known, tuple):
            said, is_covered = v.choices[int(value) - 1], v.choices[int(value) - 1] in known
            words = ", ".join(known)
        else:
            said, is_covered, words = f"{value:g}", value == known, f"{known:g}"
        if not is_covered:
            yield f"{v.name}: expected {words} in a native FMU, got {said}"
    yield from part.uncovered_values(values)
