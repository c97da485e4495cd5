"""The file of a native FMU that describes its model, which front/native.c reads."""

import struct

import numpy as np

from .native_parts import NativePart
from .slave import PRODUCT, SEED, FieldSlave, reserved
from .variables import KINDS, Variable

MARK = b"PCNATIV5"
"""First bytes of resources/slave.bin. The last digit is the version, as in front/native.c."""

WORD = 8  # bytes that are summed at once
TYPES = ("Real", "Integer", "String", "Enumeration")


def slave_file(slave: FieldSlave, part: NativePart, setup: np.ndarray) -> bytes:
    """Return the content of resources/slave.bin, which front/native.c reads.

    It contains positions, ranges and start values of the variables, the first part of the model's
    memory, and sentences.
    """
    setup = np.asarray(setup, dtype="<f8")
    blocks = [
        (slave.references[n], slave.views[n].size, slave.references[reserved(kind, n)])
        for kind, names in ((SEED, slave.derivative_inputs), (PRODUCT, slave.derivative_outputs))
        for n in names
    ]
    table = slave.table
    texts = [text for v in table for text in (v.name, v.unit, *v.choices)]
    head = [
        slave.real_count,
        len(slave.real),
        len(slave.integer),
        len(slave.derivative_inputs),
        len(slave.derivative_outputs),
        len(table),
        len(setup),
        part.coordinates,
        len(part.faults),
        len(texts),
    ]
    rows = [_row(slave, v) for v in table]
    integers = [*head, *np.ravel(blocks), *np.ravel(rows)]
    numbers = [x for v in table for x in _range(v)]
    content = b"".join(
        [
            struct.pack(f"<{len(integers)}q", *map(int, integers)),
            np.array(numbers, dtype="<f8").tobytes(),
            slave.real.astype("<f8").tobytes(),
            slave.integer.astype("<i8").tobytes(),
            setup.tobytes(),
            *(text.encode() + b"\0" for text in (*texts, *part.faults, part.refusal)),
        ]
    )
    content += bytes(-len(content) % WORD)
    return MARK + content


def sums_of(file: bytes) -> str:
    """Return the sum of all mixed words after the mark and of the running sums, hexadecimal.

    The identifier of the FMU ends with them, so that front/native.c rejects an altered file.
    """
    words = np.frombuffer(file, dtype="<u8")[1:]
    for _ in range(2):
        words = (words ^ words >> np.uint64(32)) * np.uint64(0x9E3779B97F4A7C15)
        words ^= words >> np.uint64(29)
    weights = np.arange(len(words), 0, -1, dtype=np.uint64)
    return f"{words.sum(dtype=np.uint64):016x}{(words * weights).sum(dtype=np.uint64):016x}"


def _row(slave: FieldSlave, v: Variable) -> tuple[int, ...]:
    """Return type, position, size, causality, extents, number of choices."""
    extents = (*v.shape, 0, 0, 0)[:3]
    return (
        TYPES.index(v.type),
        slave.references[v.name],
        v.size,
        KINDS.index(v.kind),
        *extents,
        len(v.choices),
    )


def _range(v: Variable) -> tuple[float, float]:
    """Return the allowed range."""
    return -np.inf if v.minimum is None else v.minimum, np.inf if v.maximum is None else v.maximum
