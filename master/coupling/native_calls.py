"""The one thing that a coupled slave's machine code asks of its library: an entry of a participant
(front/parts.c).
"""

from numba import types

from ..fmi.compiled import compiled
from ..fmi.native_parts import CALL
from .native_block import row_of

START, ADVANCE, TANGENT = range(1, 4)
"""Entries by their number; 0 is size."""

native_part = types.ExternalFunction(
    CALL,
    types.int32(
        types.int64,
        types.CPointer(types.float64),
        types.CPointer(types.float64),
        types.CPointer(types.float64),
    ),
)


@compiled
def call(memory, p, entry, numbers):
    """Run an entry of the p-th participant on its part of the memory, with four numbers; 0 where
    that went well.
    """
    return native_part(entry, row_of(memory, p).ctypes, memory.ctypes, numbers.ctypes)
