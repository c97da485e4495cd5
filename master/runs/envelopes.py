"""Envelopes of a period: extreme value of every cell of the fields that the contract names."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..case.contract import envelope_kinds
from ..coupling.wiring import port_of
from .extremes import Extremes


class Envelopes(Extremes):
    """Extremes whose kinds are known.

    Parameters
    ----------
    kinds : mapping of str to {"min", "max"}
        Port -> extreme.
    """

    def __init__(self, kinds: Mapping[str, str]):
        super().__init__(map(port_of, kinds))
        self.kinds = dict(kinds)

    def values(self, participants: Mapping[str, Any]) -> dict[str, np.ndarray]:
        """Return the extreme of every cell since the beginning of the period, by port."""
        both = {"min": self.low, "max": self.high}
        by_kind = {kind: self.fields(participants, values) for kind, values in both.items()}
        return {port: by_kind[kind][port_of(port)] for port, kind in self.kinds.items()}


def envelopes(tree: dict, participants: Mapping[str, Any]) -> Envelopes:
    """Return the envelopes of a case: those that the contract names and its participants have."""

    def is_known(port):
        owner, name = port_of(port)
        return name in participants[owner].fields

    kinds = envelope_kinds(tree)
    return Envelopes({port: kind for port, kind in kinds.items() if is_known(port)})
