"""State of an FMU as bytes: a head that names its arrays, and the arrays.

Layout
    8 bytes     length of the head, little endian
    head        JSON: `arrays`, name, dtype and shape of each; further entries of the FMU
    arrays      consecutive, in the order of the head
    front       time and phase of the instance, if the FMU has the C front (front/common.c)

All but the last part is compressed by zlib, because some fields are constant or equal.

The FMU's entry `slow` names members that change little between cycles of a repeated run. They
may be set to other values at the end of a cycle, where the state is one from which the FMU can
continue. Members whose values are all at least 0 must stay so.
"""

import json
import zlib
from collections.abc import Mapping
from math import prod
from typing import Any, cast

import numpy as np

LENGTH = 8
COMPRESSION = 1
"""Level of compression; the best one takes twice as long and gains a percent."""


def join(head: Mapping[str, Any], arrays: Mapping[str, np.ndarray]) -> bytes:
    """Return the bytes of arrays by name and of a head in plain JSON."""
    listed = [(name, array.dtype.str, array.shape) for name, array in arrays.items()]
    text = json.dumps({**head, "arrays": listed}).encode()
    parts = [np.ascontiguousarray(array).tobytes() for array in arrays.values()]
    return zlib.compress(
        b"".join([len(text).to_bytes(LENGTH, "little"), text, *parts]), COMPRESSION
    )


def split(data: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Return head and arrays of bytes that `join` made; raise `ValueError` for others."""
    head, arrays, _ = _taken_apart(data)
    return head, arrays


def _taken_apart(data: bytes) -> tuple[dict[str, Any], dict[str, np.ndarray], bytes]:
    """Return head, arrays and the bytes after them."""
    packed = zlib.decompressobj()
    try:
        whole = packed.decompress(data)
    except zlib.error:
        whole = b""
    if not packed.eof:
        raise ValueError("no state of a slave")
    end = LENGTH + int.from_bytes(whole[:LENGTH], "little")
    parsed = json.loads(whole[LENGTH:end])
    if not isinstance(parsed, dict) or "arrays" not in parsed:
        raise ValueError("no state of a slave")
    head = cast(dict[str, Any], parsed)
    arrays: dict[str, np.ndarray] = {}
    for name, dtype, shape in head.pop("arrays"):
        array = np.frombuffer(whole, dtype, prod(shape), end).reshape(shape).copy()
        end += array.nbytes
        arrays[name] = array
    return head, arrays, packed.unused_data


def is_sound(array: np.ndarray) -> bool:
    """Return whether an array has finite numbers, and flags that are 0 or 1."""
    if array.dtype == bool:
        return bool((array.view(np.uint8) <= 1).all())
    return array.dtype.kind in "iu" or array.dtype == float and bool(np.isfinite(array).all())


def slow_members(data: bytes) -> dict[str, np.ndarray]:
    """Return the slow members of a serialised state; empty for FMUs of other projects."""
    try:
        head, arrays = split(data)
    except ValueError:
        return {}
    return {name: arrays[name] for name in head.get("slow", ()) if name in arrays}


def with_members(data: bytes, members: Mapping[str, np.ndarray]) -> bytes:
    """Return the state with some members set to other values of the same shape."""
    head, arrays, of_front = _taken_apart(data)
    return join(head, {**arrays, **members}) + of_front
