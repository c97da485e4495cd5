"""Arrays as text in a page, compressed. The script of the page unpacks them (templates/page.js)."""

import base64
import zlib
from typing import Any

import numpy as np


def packed(data: bytes) -> str:
    """Return bytes compressed by zlib, as base64."""
    return base64.b64encode(zlib.compress(data, 9)).decode()


class Columns:
    """Arrays of single precision in one text. Equal arrays are stored once.

    An array is known by the index of its first number and its count.
    """

    def __init__(self):
        self._arrays: list[np.ndarray] = []
        self._known: dict[bytes, list[int]] = {}
        self._length = 0

    def add(self, values: Any) -> list[int]:
        """Return [begin, count] of the array among all numbers."""
        array = np.ascontiguousarray(values, dtype="<f4").ravel()
        key = array.tobytes()
        if key not in self._known:
            self._known[key] = [self._length, array.size]
            self._arrays.append(array)
            self._length += array.size
        return self._known[key]

    def text(self) -> str:
        """Return all arrays, packed."""
        return packed(np.concatenate([np.empty(0), *self._arrays]).astype("<f4").tobytes())


def packed_frames(values: np.ndarray) -> dict[str, Any]:
    """Return frames of a field as 16-bit integers over their range.

    The text holds second differences from frame to frame, first their low bytes, then their high
    bytes. The error is at most 2^-17 of the range.

    Parameters
    ----------
    values : ndarray, shape (frames, ...)

    Returns
    -------
    dict
        text : packed; low, high : the range.
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    share = np.nan_to_num((values - low) / (high - low or 1.0))
    steps = np.round(65535 * share).astype("<u2").reshape(len(values), -1)
    for _ in range(2):
        steps = np.diff(steps, axis=0, prepend=np.zeros((1, steps.shape[1]), "<u2"))
    signed = steps.view("<i2")
    small = np.ascontiguousarray((signed << 1) ^ (signed >> 15))  # small differences, few bits
    text = packed(small.view("u1").reshape(-1, 2).T.tobytes())
    return {"text": text, "low": low, "high": high}


def packed_as(dtype: str, values: np.ndarray) -> str:
    """Return numbers of a type, packed."""
    return packed(np.ascontiguousarray(values, dtype=dtype).tobytes())
