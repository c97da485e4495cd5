"""Symmetry of films and bodies about the thrust plane, in which an engine moves.

A part finds the reasons why it is not its own mirror image, `build.asymmetries`. A case joins those
of a body and of its films, `case.symmetry`.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np


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
    half : mapping of str to str
        Parameters with which it computes one half only; empty if it cannot.
    """

    reasons: list[str]
    claims: list[str] = []
    images: Mapping[str, str] = {}
    half: Mapping[str, str] = {}


def thrust_image(n_circumferential: int) -> np.ndarray:
    """Return the index of the mirror image of each circumferential cell about the thrust plane.

    Eq. (I13):  j = 2 floor(n/4) - i  mod n      theta_j = pi - theta_i in Eq. (I10)
    """
    n = n_circumferential
    return (2 * (n // 4) - np.arange(n)) % n  # Eq. (I13)


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
