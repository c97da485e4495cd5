"""What a reduced body leaves out: its static answer to film forces beside that of the finite
elements, from a few answers that the reduction keeps.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from .film_loads import FilmLoads
from .reduced_body import Probes, ReducedBody

if TYPE_CHECKING:  # slow to import, and used after runs without
    from .bases import Elastic
    from .interpolation import SurfaceReading

PROBES = 100
"""Random patterns: the estimate of Eq. (J17) is then good to 1/sqrt(2 PROBES) = 7 % of itself."""
COUNTED = 0.1
"""Of the largest deflection: an instant with less has nothing to lose. Our own choice."""
AT_ONCE = 20
"""Patterns solved together: bounds the memory."""


class StaticModes(NamedTuple):
    """What a static answer needs of a reduced body of k modes.

    Parameters
    ----------
    omega : ndarray, shape (k,)
        [rad/s]
    radial, axial : ndarray, shape (points, k)
        [kg^-1/2]
    """

    omega: np.ndarray
    radial: np.ndarray
    axial: np.ndarray


class Truncation(NamedTuple):
    """How far a reduced body's static deflection under the film stands from the whole body's.

    Parameters
    ----------
    error : float
        Root mean square of the missing radial deflection over that of the deflection, all points
        and instants [-].
    largest : float
        The same of the worst single instant, of those with a deflection of at least `COUNTED` of
        the largest one [-].
    """

    error: float
    largest: float


def static_modes(body: ReducedBody) -> StaticModes:
    """Of a reduced piston or block, its surface's points in one row."""
    count = len(body.omega)
    return StaticModes(body.omega, body.radial.reshape(-1, count), body.axial.reshape(-1, count))


def random_patterns(there: np.ndarray) -> np.ndarray:
    """z of Eq. (J16), independent, normal, of variance 1, (PROBES, points); the same each time.

    there : ndarray of bool, shape (points,), which points count.
    """
    return np.random.default_rng(2).standard_normal((PROBES, len(there))) * there


def probes(elastic: Elastic, reading: SurfaceReading, patterns: np.ndarray) -> Probes:
    """Answers of the whole body to patterns of radial forces.

    Eq. (J16):  a = R K^-1 R^T z,  b = A K^-1 R^T z

    Parameters
    ----------
    elastic : Elastic
    reading : SurfaceReading
        R and A: radial and axial displacement at the points, of all degrees of freedom.
    patterns : ndarray, shape (m, points)
        z [-].
    """
    radial = reading.radial[:, elastic.free].tocsr()
    axial = reading.axial[:, elastic.free].tocsr()
    answers = []
    for first in range(0, len(patterns), AT_ONCE):
        displacement = elastic.solve(radial.T @ patterns[first : first + AT_ONCE].T)
        answers.append([(radial @ displacement).T, (axial @ displacement).T])  # Eq. (J16)
    answer_radial, answer_axial = (np.concatenate(part) for part in zip(*answers))
    return Probes(patterns, answer_radial, answer_axial)


def truncation(kept: Probes, modes: StaticModes, film: FilmLoads) -> Truncation:
    """Truncation error of a body at the loads of a run.

    Eq. (J17):  e = R (K^-1 - Phi Omega^-2 Phi^T) (R^T p - A^T f),   |e|^2 = mean of (z^T e)^2

    z^T e needs the answers to z alone. Gas and inertia are left out: `pressure_modes` and
    `trained` hold them exactly.

    Parameters
    ----------
    kept : Probes
    modes : StaticModes
    film : FilmLoads
        At the points, m instants.

    Returns
    -------
    Truncation
        Estimates, with a standard error of 1/sqrt(2 PROBES) of themselves at most; 0 without any
        force.

    References
    ----------
    Our own choice; checked in tests/mfbd/test_truncation.py.
    """
    pressure, friction = (np.reshape(force, (len(force), -1)) for force in film)
    yielding = (pressure @ modes.radial - friction @ modes.axial) / modes.omega**2
    felt = kept.probe @ modes.radial / modes.omega**2
    missing_radial = kept.answer_radial - felt @ modes.radial.T
    missing_axial = kept.answer_axial - felt @ modes.axial.T
    counted = kept.probe.any(axis=0)
    # Eq. (J17)
    missing = ((pressure @ missing_radial.T - friction @ missing_axial.T) ** 2).mean(axis=1)
    deflection = ((yielding @ modes.radial[counted].T) ** 2).sum(axis=1)
    if not deflection.any():
        return Truncation(0.0, 0.0)
    loaded = deflection >= COUNTED**2 * deflection.max()
    return Truncation(
        error=float(np.sqrt(missing.sum() / deflection.sum())),
        largest=float(np.sqrt((missing[loaded] / deflection[loaded]).max())),
    )
