"""The real numbers of a state as a list of its members, for derivatives of the state."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np


def members_of(state: Any) -> list[Any]:
    """Return all members of a named tuple in order, those of nested ones too."""
    out: list[Any] = []
    for value in state:
        if isinstance(value, tuple):
            out += members_of(value)
        else:
            out.append(value)
    return out


def is_real(member: Any) -> bool:
    """Return whether a member is a real number or an array of them."""
    return isinstance(member, float) or getattr(member, "dtype", None) == np.float64


def difference(plus: Any, minus: Any, factor: float) -> list[Any]:
    """Return the difference of two states times a factor, 0 for members that are not real."""
    pairs = zip(members_of(plus), members_of(minus))
    return [factor * (a - b) if is_real(a) else 0.0 for a, b in pairs]


def moved(state: Any, change: Sequence[Any], factor: float) -> Any:
    """Return the state plus a factor times a `difference`."""
    pairs = zip(members_of(state), change)
    members = iter([a + factor * b if is_real(a) else a for a, b in pairs])
    return _rebuilt(state, members)


def layout_of(state: Any) -> list[tuple[int, ...]]:
    """Return the shapes of all members."""
    return [np.shape(member) for member in members_of(state)]


def _rebuilt(state: Any, members: Iterator[Any]) -> Any:
    """Return a tuple like a state with other members."""
    values = [_rebuilt(one, members) if isinstance(one, tuple) else next(members) for one in state]
    return type(state)(*values) if hasattr(state, "_fields") else tuple(values)
