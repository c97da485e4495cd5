"""A slave's state as bytes: a head that names its arrays, and the arrays.

Layout
    8 bytes     length of the head, little endian
    head        JSON: `arrays`, name, dtype and shape of each; what the slave puts in besides
    arrays      one behind the other, in the order of the head

Among what a slave puts in is `slow`: names of members that change little from one cycle of a
repeated run to the next, and that may be set to other values at the end of a cycle: the state is
one that the slave can go on from. Where all their values are at least 0 they have to stay so.
"""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

LENGTH = 8


def join(head: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> bytes:
    """Bytes of arrays by their names, and of a head that is plain JSON."""
    listed = [(name, array.dtype.str, array.shape) for name, array in arrays.items()]
    text = json.dumps({**head, "arrays": listed}).encode()
    parts = [np.ascontiguousarray(array).tobytes() for array in arrays.values()]
    return b"".join([len(text).to_bytes(LENGTH, "little"), text, *parts])


def split(data: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Head and arrays of the bytes that `join` made; ValueError if they are others."""
    end = LENGTH + int.from_bytes(data[:LENGTH], "little")
    head = json.loads(data[LENGTH:end])
    if not isinstance(head, dict) or "arrays" not in head:
        raise ValueError("no state of a slave")
    arrays: dict[str, np.ndarray] = {}
    for name, dtype, shape in head.pop("arrays"):
        array = np.frombuffer(data, dtype, int(np.prod(shape)), end).reshape(shape).copy()
        end += array.nbytes
        arrays[name] = array
    return head, arrays


def slow_members(data: bytes) -> dict[str, np.ndarray]:
    """Slow members of a serialised state; none in what is not a slave's of this project."""
    try:
        head, arrays = split(data)
    except ValueError:
        return {}
    return {name: arrays[name] for name in head.get("slow", ()) if name in arrays}


def with_members(data: bytes, members: Mapping[str, np.ndarray]) -> bytes:
    """The state with some members set to other values of the same shape."""
    head, arrays = split(data)
    return join(head, {**arrays, **members})
