"""Faults that kernels note: the number of a sentence, two positions and three numbers.

Python makes the sentences. `{i}` and `{j}` are the positions, `{a}` to `{c}` the numbers.
"""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from .compiled import compiled

MOST_FAULTS = 24
OF_A_FAULT = 6
ROOM = 1 + MOST_FAULTS * OF_A_FAULT
"""Length of a list of faults: their count, then number of the sentence, i, j, a, b, c for each."""
DAMAGED_STATE = "the restored state is damaged: expected that of a run of this FMU"


def numbers_of(names: Iterable[str]) -> Any:
    """Return a named tuple of the numbers of sentences, from 0 on.

    They are no integers, because numba compiles a kernel anew for every literal integer.
    """
    fields = [(name, float) for name in names]
    return NamedTuple("FaultNumbers", fields)._make(map(float, range(len(fields))))


def none_yet() -> np.ndarray:
    """Return an empty list of faults."""
    return np.zeros(ROOM)


@compiled
def refuse(faults: np.ndarray, number: float, i: float, j: float, a: float, b: float, c: float):
    count = int(faults[0])
    if count < MOST_FAULTS:
        first = 1 + OF_A_FAULT * count
        faults[first] = number
        faults[first + 1] = i
        faults[first + 2] = j
        faults[first + 3] = a
        faults[first + 4] = b
        faults[first + 5] = c
        faults[0] = count + 1


@compiled
def take_over(faults: np.ndarray, others: np.ndarray, first: float):
    """Append the faults of another list, whose sentences begin at number `first` of this one."""
    for k in range(int(others[0])):
        count = int(faults[0])
        if count < MOST_FAULTS:
            for m in range(OF_A_FAULT):
                faults[1 + OF_A_FAULT * count + m] = others[1 + OF_A_FAULT * k + m]
            faults[1 + OF_A_FAULT * count] += first
            faults[0] = count + 1


@compiled
def remark(faults: np.ndarray, number: float):
    """Note a warning: a sentence without numbers. A negative number is no warning.

    It is stored as a negative number at the first fault, and the count of faults stays 0.
    """
    if faults[0] == 0.0 and number >= 0.0:
        faults[1] = -1.0 - number


def remark_of(faults: np.ndarray, sentences: Sequence[str]) -> str:
    """Return the sentence of the noted warning, empty if there is none."""
    return sentences[int(-1.0 - faults[1])] if faults[1] < 0.0 else ""


def sentences_of(faults: np.ndarray, sentences: Sequence[str]) -> list[str]:
    """Return the sentences of all noted faults."""
    noted = faults[1:].reshape(MOST_FAULTS, OF_A_FAULT)[: int(faults[0])].tolist()
    return [
        sentences[int(number)].format(i=f"{i:g}", j=f"{j:g}", a=f"{a:g}", b=f"{b:g}", c=f"{c:g}")
        for number, i, j, a, b, c in noted
    ]
