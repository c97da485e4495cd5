"""Envelopes of a period: extreme value of every cell of the fields that the contract names."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..case.contract import envelope_kinds
from ..coupling.wiring import port_of

EXTREMES = {"min": np.minimum, "max": np.maximum}


class Envelopes:
    """Running envelopes of a period: its start and every accepted macro step.

    Parameters
    ----------
    kinds : mapping of str to {"min", "max"}
        Port -> extreme.

    Attributes
    ----------
    values : dict of str to ndarray
        Port -> extreme of every cell since the beginning of the period, in SI.
    """

    def __init__(self, kinds: Mapping[str, str]):
        self.kinds = dict(kinds)
        self.values: dict[str, np.ndarray] = {}

    def begin(self, participants: Mapping[str, Any]) -> None:
        """Begin a period at the current state of the participants."""
        self.values = self._read(participants)

    def add(self, participants: Mapping[str, Any]) -> None:
        """Add an accepted step."""
        for port, value in self._read(participants).items():
            self.values[port] = EXTREMES[self.kinds[port]](self.values[port], value)

    def _read(self, participants):
        return {
            port: np.array(participants[owner].get(name), dtype=float)
            for port in self.kinds
            for owner, name in [port_of(port)]
        }


def envelopes(tree: dict, participants: Mapping[str, Any]) -> Envelopes:
    """Return the envelopes of a case: those that the contract names and its participants have."""

    def is_known(port):
        owner, name = port_of(port)
        return name in participants[owner].fields

    kinds = envelope_kinds(tree)
    return Envelopes({port: kind for port, kind in kinds.items() if is_known(port)})
