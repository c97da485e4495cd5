"""Symmetry of films and bodies about the thrust plane, in which an engine moves.

A part finds the reasons why it is not its own mirror image, `build.asymmetries`. A case joins those
of a body and of its films, `case.symmetry`. If there are none, it sets the parameter
`film_symmetry` of all of them, and they compute one half.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

FILM_SYMMETRIES = ("none", "thrust_plane", "automatic")
"""Choices of the parameter `film_symmetry`."""
WHOLE, THRUST_PLANE, AUTOMATIC = map(float, range(1, 1 + len(FILM_SYMMETRIES)))
"""Their numbers in kernels."""


class Symmetry(NamedTuple):
    """Symmetry of a participant.

    Parameters
    ----------
    reasons : list of str
        Why it is not its own mirror image, each as "KEY (...)"; empty if it is.
    claims : list of str
        Keys that assume the symmetry.
    images : mapping of str to str
        Prefix of a film surface -> prefix of its mirror image, if that is another surface.
    can_halve : bool
        Whether it has a parameter `film_symmetry` to compute one half, and a grid for it.
    """

    reasons: list[str]
    claims: list[str] = []
    images: Mapping[str, str] = {}
    can_halve: bool = False


def thrust_image(n_circumferential: int) -> np.ndarray:
    """Return the index of the mirror image of each circumferential cell about the thrust plane.

    Eq. (I13):  j = 2 floor(n/4) - i  mod n      theta_j = pi - theta_i in Eq. (I10)
    """
    n = n_circumferential
    return (2 * (n // 4) - np.arange(n)) % n  # Eq. (I13)


class HalfGrid(NamedTuple):
    """Half of a ring from the thrust line to the anti-thrust line.

    Parameters
    ----------
    first, last : int
        Its first row among those of the ring, and the one after its last row.
    rows : ndarray of int, shape (n,)
        Row of the half for each row of the ring, its own or that of its mirror image.
    """

    first: int
    last: int
    rows: np.ndarray


def half_grid(n_circumferential: int) -> HalfGrid:
    """Return half of a ring with an even number of circumferential cells."""
    n = n_circumferential
    first, last = n // 4, n // 4 + n // 2 + 1
    own = np.arange(n)
    rows = np.where((first <= own) & (own < last), own, thrust_image(n)) - first
    return HalfGrid(first, last, rows)


def odd_part(field: np.ndarray, axis: int = 0) -> np.ndarray:
    """Return the part of a field on circumferential cells that is odd about the thrust plane.

    Eq. (I14):  odd = (f - M f)/2      M: theta -> pi - theta
    """
    image = np.take(field, thrust_image(field.shape[axis]), axis)
    return (field - image) / 2  # Eq. (I14)


def rejection(claim: str, reasons: list[str]) -> str:
    """Return the fault of a key that assumes a symmetry which does not exist."""
    key = "symmetric" if claim == "symmetric" else "symmetric_film"
    return (
        f"{claim}: expected a film symmetric about the thrust plane, got {', '.join(reasons)}; "
        f"set {key} = false"
    )
