"""Coordinates of the values in a results file: crank angle, and dimensions of fields.

They name the dimensions in files, arrays and tables.
"""

import re
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from ..case.schema import Case
from ..case.shown import NEUTRAL
from ..coupling.wiring import port_of
from .instants import CRANK_ANGLE

INSTANT = "instant"
"""Name of the time of fields, next to that of scalars."""


class Dimension(NamedTuple):
    """One index of a field: name of the dimension, centres of its cells, unit and description."""

    name: str
    positions: np.ndarray
    unit: str
    description: str


def crank_angle_port(case: Case) -> str | None:
    """Return the crank angle output "participant.crank_angle" of a case; None if it has none.

    The participant is that of `time.angular_speed`. The caller checks whether it has the output.
    """
    if case.time.angular_speed is None:
        return None
    owner, _ = port_of(case.time.angular_speed)
    return f"{owner}.{CRANK_ANGLE}"


def dimensions(case: Case, port: str, shape: tuple[int, ...]) -> list[Dimension]:
    """Return the dimensions of a field of this shape at one instant, in the order of its indices.

    A field of two indices has the case's `axes`, named by the first word of their labels ("angle
    from the pin axis": angle). Other dimensions are numbered from 1 and named after the field.
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
    """Return the names that no dimension can have, for `distinct`."""
    return dict.fromkeys([*participants, "time", INSTANT, CRANK_ANGLE], -1)


def distinct(names: dict[str, int], dimension: Dimension, owner: str) -> Dimension:
    """Return the dimension under a name that no other size has; `names` stores name -> size."""
    size = dimension.positions.size
    if names.setdefault(dimension.name, size) == size:
        return dimension
    renamed = dimension._replace(name=f"{owner}_{dimension.name}_{size}")
    names[renamed.name] = size
    return renamed


def _first_word(label: str) -> str:
    match = re.search(r"\w+", label)
    return match[0] if match else "index"
