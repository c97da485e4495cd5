"""Modes from the pressures that a film is expected to have: smooth in angle and height."""

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from ..finite_elements.element import Sparse
from ..options import MOST_MODES
from .bases import Elastic, of_unit_energy
from .interpolation import SurfaceReading

AROUND = np.radians(25.0)
"""Correlation length of pressure around skirt and bore [rad]. It is an angle, because the width of
a film's pressure follows from the gap's curvature and not from the radius alone."""
ALONG = {"skirt": 5 / 27, "bore": 12 / 95}
"""Correlation length along the axis, as a share of the surface's length [-]: 5 mm of the 27 mm
skirt, 12 mm of the 95 mm bore of models/numerical_example. Profile and edges scale with the skirt.
The bore has one set of modes for all positions of the skirt, so that it resolves less."""
NEGLIGIBLE = 1e-8
"""Patterns of less than this share of the strongest variance are not solved for."""
AT_ONCE = 64
"""Loads solved together: a block takes a third of the time of single loads."""


class SurfaceAnswers(NamedTuple):
    """Static answers of a body to the pressure patterns of the prior.

    Parameters
    ----------
    root : ndarray, shape (points, n)
        S of Eq. (J31) [-].
    radial, axial : ndarray, shape (points, n)
        R K^-1 R^T S and A K^-1 R^T S [m/N].
    """

    root: np.ndarray
    radial: np.ndarray
    axial: np.ndarray


def pressure_root(
    angle: np.ndarray, height: np.ndarray, along: float, there: np.ndarray
) -> np.ndarray:
    """Return a root of the prior covariance of nodal pressure forces.

    Eq. (J31):  <p p^T> = D (C_theta x C_y) D = S S^T
                C_theta = exp(-(d_theta/L_theta)^2 / 2),   C_y = exp(-(d_y/L_y)^2 / 2)

    D is 1 where the surface has a film and 0 elsewhere. d_theta is the shorter way around.

    Parameters
    ----------
    angle : ndarray, shape (c,)
        [rad]
    height : ndarray, shape (a,)
        [m]
    along : float
        L_y as a share of the surface's length, see `ALONG` [-].
    there : ndarray of bool, shape (c a,)
        Points that have a film, height fastest.

    Returns
    -------
    ndarray, shape (c a, n)
        S, strongest patterns first.
    """
    around, axial, variance = _prior(angle, height, along)
    strength = np.sort(variance, axis=None)[::-1]
    strength = strength[strength > NEGLIGIBLE * strength[0]]
    i, j = np.unravel_index(np.argsort(-variance, axis=None)[: len(strength)], variance.shape)
    patterns = around[:, None, i] * axial[None, :, j]
    # Eq. (J31)
    return patterns.reshape(-1, len(strength)) * np.sqrt(strength) * there[:, None]


def pattern_count(angle: np.ndarray, height: np.ndarray, along: float) -> int:
    """Return the number of columns of `pressure_root`, which has the same arguments."""
    variance = _prior(angle, height, along).variance
    return int(np.count_nonzero(variance > NEGLIGIBLE * variance.max()))


class _Prior(NamedTuple):
    """Eigenvectors of C_theta, (c, c), and of C_y, (a, a), and products of eigenvalues, (c, a)."""

    around: np.ndarray
    axial: np.ndarray
    variance: np.ndarray


def _prior(angle, height, along):
    apart = np.remainder(angle[:, None] - angle + np.pi, 2 * np.pi) - np.pi
    length = along * np.ptp(height) * len(height) / (len(height) - 1)
    around, ring = la.eigh(np.exp(-((apart / AROUND) ** 2) / 2))
    axial, line = la.eigh(np.exp(-(((height[:, None] - height) / length) ** 2) / 2))
    return _Prior(ring, line, np.multiply.outer(around, axial))


def surface_answers(body: Elastic, reading: SurfaceReading, root: np.ndarray) -> SurfaceAnswers:
    """Return the body's answers to the patterns of `pressure_root`.

    Parameters
    ----------
    body : Elastic
    reading : SurfaceReading
        R and A: radial and axial displacement at the points, of the free degrees of freedom.
    root : ndarray, shape (points, n)
    """
    answers = []
    for first in range(0, root.shape[1], AT_ONCE):
        displacement = body.solve(reading.radial.T @ root[:, first : first + AT_ONCE])
        answers.append((reading.radial @ displacement, reading.axial @ displacement))
    radial, axial = (np.hstack(part) for part in zip(*answers))
    return SurfaceAnswers(root, radial, axial)


class ExpectedPatterns(NamedTuple):
    """Eigenvectors v of Eq. (J32), (n, n), largest first, and the share of the deflection that is
    expected to be missing with the first k of them, (n + 1,) [-].
    """

    vector: np.ndarray
    missing: np.ndarray


def expected_patterns(answers: SurfaceAnswers, first: np.ndarray) -> ExpectedPatterns:
    """Return the pressure patterns to which a surface yields most under the prior.

    Eq. (J32):  S^T R G R^T S v_i = mu_i v_i,   G = K^-1 - Psi Psi^T,   largest mu_i first
    Eq. (J33):  missing(k)^2 = max_j sum_(i>k) (R G R^T S v_i)_j^2 / max_j (R K^-1 R^T S)_j^2

    Eq. (J33) compares the largest standard deviation of the missing radial deflection at any point
    with the largest one of the deflection, both under the prior.

    Parameters
    ----------
    answers : SurfaceAnswers
    first : ndarray, shape (points, j)
        R Psi, Psi^T K Psi = 1: shapes that the basis has already.
    """
    left = answers.radial - first @ (first.T @ answers.root)
    energy = answers.root.T @ left
    _, vector = la.eigh((energy + energy.T) / 2)  # Eq. (J32), rising
    vector = vector[:, ::-1]
    square = (left @ vector) ** 2
    tail = np.cumsum(square[:, ::-1], axis=1)[:, ::-1].max(axis=0)
    whole = (answers.radial**2).sum(axis=1).max()
    return ExpectedPatterns(vector, np.sqrt(np.append(tail, 0.0) / whole))  # Eq. (J33)


def smooth_pressure_modes(
    body: Elastic, radial: Sparse, answers: SurfaceAnswers, modes: int | float, first: np.ndarray
) -> np.ndarray:
    """Return the static shapes under the smooth pressures to which a surface yields most.

    Eq. (J32) gives the patterns v_i, and phi_i = G R^T S v_i. A larger basis contains every
    smaller one that has the same first shapes.

    Parameters
    ----------
    body : Elastic
    radial : scipy.sparse matrix, shape (points, free)
        R [-].
    answers : SurfaceAnswers
    modes : int or float
        Number of shapes, the first ones included; or, if a float, the share of Eq. (J33) below
        which the expected missing deflection has to be.
    first : ndarray, shape (free, j)
        Shapes that must be in the basis (`static_answers`).

    Returns
    -------
    ndarray, shape (free, k)
        Largest mu first, then the first ones.

    Raises
    ------
    ValueError
        If the patterns of the prior are not enough.

    References
    ----------
    Own choice: leading modes of a random field's answer (Karhunen-Loeve). Measured in
    docs/decisions/0005-pressure-modes.md.
    """
    psi = of_unit_energy(body, first)
    patterns = expected_patterns(answers, radial @ psi)
    count = _count(patterns, modes, first.shape[1])
    loads = answers.root @ patterns.vector[:, :count]
    shapes = [psi]
    for begin in range(0, count, AT_ONCE):
        load = radial.T @ loads[:, begin : begin + AT_ONCE]
        shapes.insert(-1, body.solve(load) - psi @ (psi.T @ load))
    return np.hstack(shapes)


def _count(patterns: ExpectedPatterns, modes: int | float, first: int) -> int:
    """Number of patterns that a basis takes."""
    if isinstance(modes, int):
        return modes - first
    count = int(np.argmax(patterns.missing <= modes))
    if count + first > MOST_MODES:
        raise ValueError(
            f"modes = {modes:.3g}: {count + first} modes are needed for this error, at most "
            f"{MOST_MODES} are possible; give a larger error"
        )
    return count
