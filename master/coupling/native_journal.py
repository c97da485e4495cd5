"""What a communication step overwrites: one that fails is taken back, and a derivative takes the
last one again.

What the Krylov method remembers is most of the state, megabytes of which a step changes a few rows:
a row is copied when it is first overwritten, all else when the step begins.
"""

import numpy as np

from ..fmi.block import FIRST_STATE, PARTS_FROM, keep, part
from ..fmi.compiled import compiled
from .native_block import (
    BEFORE,
    DIFFERENCES,
    GRAM,
    IMAGES,
    KEPT,
    MARKS,
    OLDEST,
    PAST,
    STANDING,
    TIMES,
    UNKNOWNS,
    clear,
    count,
)


@compiled
def before_of(memory: np.ndarray, which: int):
    """What a part of the state was when the step began."""
    first = int(memory[PARTS_FROM + which]) - int(memory[FIRST_STATE])
    return part(memory, BEFORE)[first : first + len(part(memory, which))]


@compiled
def open_journal(memory: np.ndarray):
    """A communication step begins."""
    for which in (STANDING, TIMES, PAST, OLDEST, GRAM):
        keep(before_of(memory, which), part(memory, which))
    clear(part(memory, MARKS))


@compiled
def overwrite(memory: np.ndarray, rows: int):
    """Call before so many of the oldest pairs are overwritten."""
    kept = count(memory, KEPT)
    n = count(memory, UNKNOWNS)
    marks = part(memory, MARKS)
    first = int(part(memory, OLDEST)[0])
    for k in range(min(rows, kept)):
        row = (first + k) % kept
        if marks[row] == 0.0:
            marks[row] = 1.0
            for which in (IMAGES, DIFFERENCES):
                own = part(memory, which)[row * n : (row + 1) * n]
                keep(before_of(memory, which)[row * n : (row + 1) * n], own)


@compiled
def take_back(memory: np.ndarray):
    """Put the state back to where the step began."""
    for which in (STANDING, TIMES, PAST, OLDEST, GRAM):
        keep(part(memory, which), before_of(memory, which))
    n = count(memory, UNKNOWNS)
    marks = part(memory, MARKS)
    for row in range(len(marks)):
        if marks[row] != 0.0:
            for which in (IMAGES, DIFFERENCES):
                own = part(memory, which)[row * n : (row + 1) * n]
                keep(own, before_of(memory, which)[row * n : (row + 1) * n])


@compiled
def print_of(memory: np.ndarray):
    """A number that tells what is remembered from what another step would: all inner products,
    each with a weight of its own.
    """
    gram = part(memory, GRAM)
    total = 0.0
    for k in range(len(gram)):
        total += gram[k] * (k + 1)
    return total
