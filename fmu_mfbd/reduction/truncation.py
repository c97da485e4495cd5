"""Truncation error of a reduced body: its static deflection compared with that of its mesh.

The error follows from the deflections by smooth pressures, which the reduction computes.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import scipy.linalg as la

from .film_loads import FilmLoads
from .reduced_body import MissingShapes, ReducedBody

if TYPE_CHECKING:  # slow to import, and only its type is used
    from .smooth_prior import SurfaceAnswers

LEAST_DEFLECTION = 0.1
"""Smallest deflection of an instant or a patch that is compared, relative to the largest. Our own
choice."""
NEGLIGIBLE_ENERGY = 1e-9
"""Missing shapes of less than this share of the strongest answer's energy are round-off."""
THIN_FILM = 1e-7
"""h_0 of Eq. (J34) [m]: below it asperities carry, and the mean gap has no meaning."""


class StaticModes(NamedTuple):
    """Properties of k modes that determine a static deflection.

    Parameters
    ----------
    omega : ndarray, shape (k,)
        [rad/s]
    radial, axial : ndarray, shape (points, k)
        Displacements of the modes at the points of the surface [kg^-1/2].
    """

    omega: np.ndarray
    radial: np.ndarray
    axial: np.ndarray


class Truncation(NamedTuple):
    """Error of a reduced body's static deflection under the film.

    Parameters
    ----------
    error : float
        Root mean square of the missing radial deflection over that of the deflection, all points
        and instants [-].
    largest : float
        The same for the worst single instant, of those with a deflection of at least
        `LEAST_DEFLECTION` of the largest one [-].
    missing : ndarray, shape (m, points)
        Missing deflection, positive where it opens the gap [m].
    """

    error: float
    largest: float
    missing: np.ndarray


def static_modes(body: ReducedBody) -> StaticModes:
    """Return a reduced piston's or block's modes with its surface's points in one row."""
    count = len(body.omega)
    return StaticModes(body.omega, body.radial.reshape(-1, count), body.axial.reshape(-1, count))


def unreached(answers: SurfaceAnswers, modes: StaticModes) -> tuple[np.ndarray, np.ndarray]:
    """Return the radial and axial deflection under n patterns that modes omit, (points, n) [m/N].

    Eq. (J50):  R E, A E,   E = (K^-1 - Phi Omega^-2 Phi^T) R^T S
    """
    coordinates = modes.radial.T @ answers.root / modes.omega[:, None] ** 2
    # Eq. (J50)
    return answers.radial - modes.radial @ coordinates, answers.axial - modes.axial @ coordinates


def smooth_error(answers: SurfaceAnswers, modes: StaticModes, has_film: np.ndarray) -> float:
    """Return the largest missing share of the deflection under smooth patches, Eq. (J33) [-]."""
    patches = answers.root[has_film].T
    missing, _ = unreached(answers, modes)
    return float(_shares(missing @ patches, answers.radial @ patches).max())


def edge_error(answers: SurfaceAnswers, modes: StaticModes) -> float:
    """Return the largest missing share of the deflection under a single pattern [-].

    Eq. (J47):  max_j |R E_j| / |R K^-1 R^T S_j|      over deflections per force of at least
                `LEAST_DEFLECTION` of the largest one

    A narrow patch on a stiff part of a surface only makes a dent, which no mode contains. The
    patterns are those of `answers`.
    """
    missing, _ = unreached(answers, modes)
    size = np.linalg.norm(answers.radial, axis=0) / answers.root.sum(axis=0)
    return float(
        _shares(missing, answers.radial)[size >= LEAST_DEFLECTION * size.max()].max()
    )  # Eq. (J47)


def _shares(missing, whole):
    """Return the ratio of the norms of columns."""
    return np.linalg.norm(missing, axis=0) / np.linalg.norm(whole, axis=0)


def left_out(answers: SurfaceAnswers, modes: StaticModes, has_film: np.ndarray) -> MissingShapes:
    """Return the static shapes under smooth pressures that the modes omit.

    Eq. (J16):  S^T R E w_i = e_i w_i,   X_i = E w_i e_i^-1/2      E of `unreached`

    Parameters
    ----------
    answers : SurfaceAnswers
        Deflections under the whole prior, also if the modes are for the even part of the pressure.
    modes : StaticModes
    has_film : ndarray of bool, shape (points,)
        Points that have a film.
    """
    radial, axial = unreached(answers, modes)
    energy = answers.root.T @ radial
    whole = np.linalg.norm(answers.root.T @ answers.radial, 2)
    e, w = la.eigh((energy + energy.T) / 2)
    significant = e > NEGLIGIBLE_ENERGY * whole
    w = w[:, significant] / np.sqrt(e[significant])
    on = has_film[:, None]
    # Eq. (J16)
    return MissingShapes((radial @ w * on).astype(np.float32), (axial @ w * on).astype(np.float32))


def truncation(left: MissingShapes, modes: StaticModes, film: FilmLoads) -> Truncation:
    """Return the truncation error of a body at the loads of a run.

    Eq. (J17):  e = R X X^T (R^T p - A^T f)

    It is exact for pressures in the span of the prior (Eq. (J31)). For others it is the part of the
    missing deflection that smooth pressures can produce, so it never exceeds the missing elastic
    energy. Gas and inertia are omitted, because the bases for films contain their shapes exactly.

    Parameters
    ----------
    left : MissingShapes
    modes : StaticModes
    film : FilmLoads
        At the points, m instants.

    Returns
    -------
    Truncation
        All 0 without any force.

    References
    ----------
    Our own choice; checked in tests/mfbd/test_truncation.py against the whole body.
    """
    pressure, friction = (np.reshape(force, (len(force), -1)) for force in film)
    yielding = (pressure @ modes.radial - friction @ modes.axial) / modes.omega**2
    strength = pressure @ left.left_radial - friction @ left.left_axial
    missing = strength @ left.left_radial.T  # Eq. (J17)
    on_film = left.left_radial.any(axis=1)
    lost = (missing**2).sum(axis=1)
    deflection = (((yielding @ modes.radial.T + missing)[:, on_film]) ** 2).sum(axis=1)
    if not deflection.any():
        return Truncation(0.0, 0.0, missing)
    loaded = deflection >= LEAST_DEFLECTION**2 * deflection.max()
    return Truncation(
        error=float(np.sqrt(lost.sum() / deflection.sum())),
        largest=float(np.sqrt((lost[loaded] / deflection[loaded]).max())),
        missing=missing,
    )


def share_of_film(missing: np.ndarray, film_thickness: np.ndarray) -> float:
    """Return the largest missing gap as a share of the local film thickness.

    Eq. (J34):  s = max |e_block + e_piston| / max(h, h_0)      over points and instants

    Parameters
    ----------
    missing : ndarray, shape (m, c, a)
        Sum of both bodies' missing deflections, positive where they open the gap [m].
    film_thickness : ndarray, shape (m, c, a)
        h, inf where there is no film [m].
    """
    return float((np.abs(missing) / np.maximum(film_thickness, THIN_FILM)).max())  # Eq. (J34)
