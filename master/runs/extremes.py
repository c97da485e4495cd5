"""Smallest and largest value of every cell of several fields over a period of a run."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..participants.participant import block_of, split

Port = tuple[str, str]
"""Participant and variable."""


class Extremes:
    """Running extremes of a period: its start and every accepted macro step.

    All fields are one vector. Each participant is read by one call.

    Parameters
    ----------
    ports : iterable of (participant, variable)

    Attributes
    ----------
    start, low, high : ndarray
        Values at the beginning of the period, and extremes since then, in SI.
    """

    def __init__(self, ports: Iterable[Port]):
        self.names: dict[str, tuple[str, ...]] = {}
        for owner, name in ports:
            self.names[owner] = (*self.names.get(owner, ()), name)
        self.start = self.low = self.high = np.zeros(0)

    def begin(self, participants: Mapping[str, Any]) -> None:
        """Begin a period at the current state of the participants."""
        self.start = self.read(participants)
        self.low, self.high = self.start.copy(), self.start.copy()

    def add(self, participants: Mapping[str, Any]) -> None:
        """Add the outputs of an accepted step."""
        values = self.read(participants)
        np.minimum(self.low, values, out=self.low)
        np.maximum(self.high, values, out=self.high)

    def read(self, participants: Mapping[str, Any]) -> np.ndarray:
        """Return the current values of all fields."""
        blocks = [block_of(participants[owner], names) for owner, names in self.names.items()]
        for block in blocks:
            block.get()
        return np.concatenate([np.zeros(0), *(block.values for block in blocks)])

    def fields(self, participants: Mapping[str, Any], values: np.ndarray) -> dict[Port, np.ndarray]:
        """Return the parts of a vector by field, in their shapes."""
        parts: dict[Port, np.ndarray] = {}
        for owner, names in self.names.items():
            own = split(participants[owner], names, values)
            parts |= {(owner, name): part for name, part in own.items()}
            values = values[sum(part.size for part in own.values()) :]
        return parts
