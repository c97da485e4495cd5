"""Memory of a coupled slave without Python: one row of float64 numbers whose parts Python lays out
(`native_given`), so that no kernel counts lengths.

It begins with a head, then what is given; then the participants' own memories, then the state in
one piece: what the participants stand at, the predictor's past, what the Krylov method remembers.
"""

from collections.abc import Iterable, Mapping

import numpy as np

from ..fmi.block import memory_of, part
from ..fmi.compiled import compiled

"""The head: lengths that `native_size` tells, then where parts begin."""

GIVEN = ("counts", "constants", "order", "starting", "rows", "wires", "exposed", "contents")
WORK = ("inside", "saved")
STATE = ("standing", "times", "past", "oldest", "images", "differences", "gram")
LAST = ("before", "marks", "last", "last_inputs", "last_outputs", "trail", "failures", "faults")
PARTS = (*GIVEN, *WORK, *STATE, *LAST)
(
    COUNTS,
    CONSTANTS,
    ORDER,
    STARTING,
    ROWS,
    WIRES,
    EXPOSED,
    CONTENTS,
    INSIDE,
    SAVED,
    STANDING,
    TIMES,
    PAST,
    OLDEST,
    IMAGES,
    DIFFERENCES,
    GRAM,
    BEFORE,
    MARKS,
    LAST_NUMBERS,
    LAST_INPUTS,
    LAST_OUTPUTS,
    TRAIL,
    FAILURES,
    FAULTS_AT,
) = range(len(PARTS))

COUNTED = (
    "participants",
    "wires",
    "size",
    "unknowns",
    "kept",
    "past",
    "iterations",
    "space",
    "halvings",
    "exposed",
)
(
    PARTICIPANTS,
    WIRE_COUNT,
    SIZE,
    UNKNOWNS,
    KEPT,
    REMEMBERED,
    ITERATIONS,
    SPACE,
    HALVINGS,
    EXPOSED_COUNT,
) = range(len(COUNTED))

CONSTANT = ("step", "lenience", "accuracy", "forcing", "noise", "nudge")
STEP, LENIENCE, ACCURACY, FORCING, NOISE, NUDGE = range(len(CONSTANT))

OF_ROW = (
    "code",
    "real",
    "reals",
    "integer",
    "integers",
    "memory",
    "memories",
    "first_state",
    "states",
    "first_fault",
    "sentence",
    "variables",
    "contents",
    "given",
    "standing",
)
"""A participant: which code it is; where its real and integer variables and its memory lie in the
whole, and how many; in its own memory the state and faults; first of its sentences; how many real
variables are no seeds or products; where its contents lie, how much of them its memory begins
with; where it stands in `standing` and `saved`.
"""
(
    CODE,
    REAL,
    REALS,
    INTEGER,
    INTEGERS,
    MEMORY,
    MEMORIES,
    OWN_STATE,
    OWN_STATES,
    OWN_FAULT,
    SENTENCE,
    VARIABLES,
    CONTENT,
    CONTENT_OF_MEMORY,
    STANDS,
) = range(len(OF_ROW))

OF_WIRE = (
    "source",
    "source_place",
    "target",
    "target_place",
    "elements",
    "first",
    "unknown",
    "nominal",
    "tolerance",
    "largest_decrease",
    "seed",
    "product",
    "low",
    "high",
    "columns",
    "sentence",
)
"""A wire: both participants and places among their real variables, elements, the first of them in
the vector and among the unknowns (-1: it runs along the order), norms, places of seed and product
(-1: there is none), range of the input, elements of the last index, first of its sentences.
"""
(
    SOURCE,
    SOURCE_PLACE,
    TARGET,
    TARGET_PLACE,
    ELEMENTS,
    FIRST,
    UNKNOWN,
    NOMINAL,
    TOLERANCE,
    LARGEST_DECREASE,
    WIRE_SEED,
    WIRE_PRODUCT,
    LOW,
    HIGH,
    COLUMNS,
    WIRE_SENTENCE,
) = range(len(OF_WIRE))
NOWHERE = -1.0

OF_EXPOSED = (
    "integral",
    "place",
    "owner",
    "own_place",
    "length",
    "causality",
    "reserved",
    "nominal",
    "kept",
)
"""A variable seen from outside: its place there, whose it is, its place there; place of its seed or
product (-1: it has none), where the last step's value lies in `last_inputs` or `last_outputs`.
"""
(
    INTEGRAL,
    PLACE,
    OWNER,
    OWN_PLACE,
    LENGTH,
    CAUSALITY,
    RESERVED,
    OUTER_NOMINAL,
    KEPT_AT,
) = range(len(OF_EXPOSED))
IS_PARAMETER, IS_INPUT, IS_OUTPUT = range(3)

OF_LAST = ("kind", "time", "step", "print")
LAST_KIND, LAST_TIME, LAST_STEP, LAST_PRINT = range(len(OF_LAST))
NOTHING, A_START, A_STEP = range(3)

OF_TRAIL = ("evaluations", "products")
"""What a macro step took; behind it the measures of every wire, by evaluation as far as there is
room.
"""
EVALUATIONS, PRODUCTS = range(len(OF_TRAIL))

FOUND = 2
"""Of the numbers that the entry `iterate` is called with: whether it found the fixed point."""

OF_PARTICIPANT, OF_WIRES, OF_SENTENCES = len(OF_ROW), len(OF_WIRE), 3

OWN_FAULTS = (
    "t = {a} s, step {b} s, and no halving is left",
    "a participant's output is not finite",
    "the residual grows: {a} of what is allowed after {i} iterations, {b} at best",
    "no convergence in {i} iterations: {a} of what is allowed is left, {b} at best",
    "there is not enough memory for a participant's step",
    "there was no step to take a derivative of",
    "step size = {a} s: more than {b} macro steps of {c} s",
)
NO_HALVING, NOT_FINITE, GROWS, TOO_MANY, NO_MEMORY, NO_STEP, TOO_LONG = range(len(OWN_FAULTS))
WORST, MUST_BE_FINITE, OUT_OF_RANGE = range(OF_SENTENCES)
"""Sentences of a wire, by their place behind its first."""


def given(contents: Mapping[str, np.ndarray], lengths: Mapping[str, int]) -> np.ndarray:
    """Return what the memory begins with, by `GIVEN` and by the lengths of all other parts."""
    parts = {name: np.ravel(contents[name]).astype(float) for name in GIVEN[:-1]}
    parts[GIVEN[-1]] = contents[GIVEN[-1]]
    return memory_of(parts, {name: lengths[name] for name in PARTS if name not in parts}, STATE)


def in_order(rows: Iterable[Mapping[str, float]], names: tuple[str, ...]) -> np.ndarray:
    """Rows of named numbers as one array."""
    return np.array([[row[name] for name in names] for row in rows], dtype=float).ravel()


@compiled
def count(memory, k):
    """One of `COUNTED`."""
    return int(part(memory, COUNTS)[k])


@compiled
def row_of(memory, p):
    """What is given of a participant, `OF_ROW`."""
    return part(memory, ROWS)[p * OF_PARTICIPANT : (p + 1) * OF_PARTICIPANT]


@compiled
def wire_of(memory, w):
    """What is given of a wire, `OF_WIRE`."""
    return part(memory, WIRES)[w * OF_WIRES : (w + 1) * OF_WIRES]


@compiled
def exposed_of(memory, k):
    """What is given of a variable seen from outside, `OF_EXPOSED`."""
    return part(memory, EXPOSED)[k * len(OF_EXPOSED) : (k + 1) * len(OF_EXPOSED)]


@compiled
def clear(to):
    """Set all to zero, in a loop."""
    for k in range(len(to)):
        to[k] = 0.0
