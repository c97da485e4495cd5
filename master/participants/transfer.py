"""Values of an FMU's fields in one call, by pointers."""

import ctypes
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

REAL = ctypes.POINTER(ctypes.c_double)


@dataclass(frozen=True)
class TransferBlock:
    """Fields that one call transfers.

    references : C array of value references; count : their number; pointer : to `values`; parts
    : slice of each field.
    """

    references: ctypes.Array
    count: int
    values: np.ndarray
    pointer: Any
    parts: dict[str, slice]

    @cached_property
    def arguments(self):
        """References, their number and the pointer to the values."""
        return self.references, ctypes.c_size_t(self.count), self.pointer


class Functions(dict):
    """Functions of an FMU's library by name, without declared types, and its instance."""

    def __init__(self, fmu):
        super().__init__()
        self.library = fmu.dll
        self.component = ctypes.c_void_p(fmu.component)

    def __missing__(self, name):
        self[name] = function = self.library[name]
        return function


def transfer_block(fields):
    """Return the block of several fields (name -> Field)."""
    references = [reference for field in fields.values() for reference in field.references]
    ends = np.cumsum([field.size for field in fields.values()])
    values = np.zeros(int(ends[-1]) if fields else 0)
    parts = {
        name: slice(int(end) - field.size, int(end))
        for (name, field), end in zip(fields.items(), ends)
    }
    return TransferBlock(
        (ctypes.c_uint * len(references))(*references),
        len(references),
        values,
        values.ctypes.data_as(REAL),
        parts,
    )
