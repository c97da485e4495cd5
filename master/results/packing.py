"""Arrays as text inside a page, compressed; the page's script unpacks them (templates/page.js)."""

import base64
import zlib
from typing import Any

import numpy as np

LARGEST = 6e4
"""Of the whole-range of a half-precision number, 65504, that frames are scaled to."""


def packed(data: bytes) -> str:
    """zlib, then base64."""
    return base64.b64encode(zlib.compress(data, 6)).decode()


class Columns:
    """Arrays of double precision in one text; equal ones are kept once.

    Each is known by where it begins and how many numbers it has.
    """

    def __init__(self):
        self._arrays: list[np.ndarray] = []
        self._known: dict[bytes, list[int]] = {}
        self._length = 0

    def add(self, values: Any) -> list[int]:
        """[begin, count] of the array among all numbers."""
        array = np.ascontiguousarray(values, dtype="<f8").ravel()
        key = array.tobytes()
        if key not in self._known:
            self._known[key] = [self._length, array.size]
            self._arrays.append(array)
            self._length += array.size
        return self._known[key]

    def text(self) -> str:
        """All of them, packed."""
        return packed(np.concatenate([np.empty(0), *self._arrays]).astype("<f8").tobytes())


def packed_frames(values: np.ndarray) -> dict[str, Any]:
    """Frames of a field as half-precision numbers, each but the first as its difference in bits
    from the one before: within 2^-11 of the value itself (down to 1e-9 of the largest).

    Parameters
    ----------
    values : ndarray, shape (frames, ...)

    Returns
    -------
    dict
        text : packed; scale : what the numbers are multiplied by.
    """
    scale = float(np.nanmax(np.abs(values), initial=0.0)) / LARGEST or 1.0
    bits = (values / scale).astype("<f2").view("<u2").reshape(len(values), -1)
    steps = np.diff(bits, axis=0, prepend=np.zeros((1, bits.shape[1]), "<u2"))
    return {"text": packed(steps.astype("<u2").tobytes()), "scale": scale}


def packed_singles(values: np.ndarray) -> str:
    """Numbers of single precision, packed."""
    return packed(np.ascontiguousarray(values, dtype="<f4").tobytes())


def packed_counts(values: np.ndarray) -> str:
    """Whole numbers below 2^32, packed."""
    return packed(np.ascontiguousarray(values, dtype="<u4").tobytes())
