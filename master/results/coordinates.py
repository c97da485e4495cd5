"""What the values of a results file are over: crank angle beside time, and what the indices of a
field run along, as the case says. Names of dimensions in the file, in arrays and in tables.
"""

import re
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ..case.schema import Case
from ..case.shown import NEUTRAL
from ..coupling.wiring import port_of

CRANK_ANGLE = "crank_angle"
"""Output that follows the angle, of the participant whose speed turns angles into times."""
INSTANT = "instant"
"""Name of the time of fields where it stands beside that of scalars."""


class Dimension(NamedTuple):
    """One index of a field: name of the dimension, centres of its cells, unit and meaning."""

    name: str
    positions: np.ndarray
    unit: str
    description: str


def crank_angle_port(case: Case) -> str | None:
    """Output that holds the crank angle, "participant.crank_angle"; None where the case knows none.

    The case says by `time.angular_speed` whose angle its times are; whether that participant has
    the output is for the caller to see.
    """
    if case.time.angular_speed is None:
        return None
    owner, _ = port_of(case.time.angular_speed)
    return f"{owner}.{CRANK_ANGLE}"


def dimensions(case: Case, port: str, shape: tuple[int, ...]) -> list[Dimension]:
    """Dimensions of a field of that shape at one instant, in the order of its indices.

    A field of two indices has the case's `axes`; a dimension is named by the first word of its
    label ("angle from the pin axis": angle). Any other is counted from 1 and named after the field.
    """
    pair = case.axes_of(port)
    if len(shape) != 2 or pair is NEUTRAL:
        _, name = port_of(port)
        return [
            Dimension(f"{name}_{k}", np.arange(1.0, size + 1.0), "1", f"index {k} of {name}")
            for k, size in enumerate(shape, start=1)
        ]
    return [
        Dimension(_first_word(axis.label), axis.positions(size), axis.unit or "1", axis.marked)
        for axis, size in zip((pair.first, pair.second), shape)
    ]


def names_taken(participants: Iterable[str]) -> dict[str, int]:
    """Names that no dimension can have, for `distinct`."""
    return dict.fromkeys([*participants, "time", INSTANT, CRANK_ANGLE], -1)


def distinct(names: dict[str, int], dimension: Dimension, owner: str) -> Dimension:
    """The dimension under a name that no other size has yet; `names` remembers name -> size."""
    size = dimension.positions.size
    if names.setdefault(dimension.name, size) == size:
        return dimension
    renamed = dimension._replace(name=f"{owner}_{dimension.name}_{size}")
    names[renamed.name] = size
    return renamed


def _first_word(label: str) -> str:
    found = re.search(r"\w+", label)
    return found[0] if found else "index"
