"""Modes from the expected pressures of a film, which are smooth in angle and height."""

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from ..body_options import MOST_MODES
from ..finite_elements.element import Sparse
from .bases import Elastic, of_unit_energy
from .interpolation import SurfaceReading

AROUND = np.radians(25.0)
"""Correlation length of pressure around skirt and bore [rad]. It is an angle, because the width of
a film's pressure follows from the gap's curvature and not from the radius alone."""
ALONG = {"skirt": 5 / 27, "bore": 12 / 95}
"""Correlation length along the axis, as a share of the surface's length [-]: 5 mm of the 27 mm
skirt, 12 mm of the 95 mm bore of models/numerical_example. Profile and edges scale with the skirt.
The bore has one set of modes for all positions of the skirt, so that it resolves less."""
THRUST, NEAR = 0.01, np.radians(10.0)
"""Additional expected pressure near the thrust lines, and its width. Otherwise round-off would
choose between equal patterns of a symmetric body."""
PATCH_WIDTH = 0.25
"""Width of a narrow patch relative to the correlation lengths, our own choice: 15 deg and a tenth
of the skirt at half its height."""
NEGLIGIBLE_VARIANCE = 1e-8
"""Smallest variance of a pattern that is used, relative to the largest."""
AT_ONCE = 64
"""Number of loads for each solution, which limits the memory."""


class SurfaceAnswers(NamedTuple):
    """Static answers of a body to the pressure patterns of the prior.

    Parameters
    ----------
    root : ndarray, shape (points, n)
        S of Eq. (J31) [-].
    radial, axial : ndarray, shape (points, n)
        R U and A U [m/N].
    displacement : ndarray, shape (free, n)
        U = K^-1 R^T S [m/N].
    """

    root: np.ndarray
    radial: np.ndarray
    axial: np.ndarray
    displacement: np.ndarray


def pressure_root(
    angle: np.ndarray, height: np.ndarray, along: float, has_film: np.ndarray, parity: int = 0
) -> np.ndarray:
    """Return a root of the prior covariance of nodal pressure forces.

    Eq. (J31):  <p p^T> = D (C_theta x C_y) D = S S^T
                C_theta = exp(-(d_theta/L_theta)^2 / 2),   C_y = exp(-(d_y/L_y)^2 / 2)

    D is 0 where the surface has no film and 1 elsewhere, apart from `THRUST`. d_theta is the
    shorter way around. The part of the pressure that is even or odd about the thrust plane has

    Eq. (J36):  P C_theta P,   P = (1 +- M) / 2,   M: theta -> pi - theta

    instead of C_theta. The roots of both parts together are a root of the whole covariance.

    Parameters
    ----------
    angle : ndarray, shape (c,)
        [rad]
    height : ndarray, shape (a,)
        [m]
    along : float
        L_y as a share of the surface's length, see `ALONG` [-].
    has_film : ndarray of bool, shape (c a,)
        Points that have a film, height fastest.
    parity : int
        1: even part about the thrust plane, -1: odd part, 0: whole pressure.

    Returns
    -------
    ndarray, shape (c a, n)
        S, strongest patterns first.
    """
    around, axial, variance = _prior(angle, height, along, parity)
    strength = np.sort(variance, axis=None)[::-1]
    strength = strength[strength > NEGLIGIBLE_VARIANCE * strength[0]]
    i, j = np.unravel_index(np.argsort(-variance, axis=None)[: len(strength)], variance.shape)
    patterns = around[:, None, i] * axial[None, :, j]
    root = patterns.reshape(-1, len(strength)) * np.sqrt(strength)
    return _weights(angle, has_film)[:, None] * root  # Eq. (J31)


def _weights(angle, has_film):
    """Return the diagonal of D, Eq. (J31)."""
    from_thrust = np.arcsin(np.abs(np.cos(angle)))
    weight = 1.0 + THRUST * np.exp(-((from_thrust / NEAR) ** 2) / 2)
    return np.repeat(weight, len(has_film) // len(angle)) * has_film


def pattern_count(angle: np.ndarray, height: np.ndarray, along: float, parity: int = 0) -> int:
    """Return the number of columns of `pressure_root`, which has the same arguments."""
    variance = _prior(angle, height, along, parity).variance
    return int(np.count_nonzero(variance > NEGLIGIBLE_VARIANCE * variance.max()))


class _Prior(NamedTuple):
    """Eigenvectors of C_theta, (c, c), and of C_y, (a, a), and products of eigenvalues, (c, a)."""

    around: np.ndarray
    axial: np.ndarray
    variance: np.ndarray


def _prior(angle, height, along, parity):
    covariance, axial_covariance = _covariances(angle, height, along)
    if parity:
        image = _image(angle)
        covariance = (covariance + parity * covariance[image]) / 2
        covariance = (covariance + parity * covariance[:, image]) / 2  # Eq. (J36)
    around, ring = la.eigh(covariance)
    axial, line = la.eigh(axial_covariance)
    return _Prior(ring, line, np.multiply.outer(around, axial))


def _covariances(angle, height, along, width=1.0):
    """Return C_theta and C_y of Eq. (J31) with `width` times the correlation lengths."""
    length = width * along * np.ptp(height) * len(height) / (len(height) - 1)
    around = np.exp(-((_angle_between(angle, angle) / (width * AROUND)) ** 2) / 2)
    return around, np.exp(-(((height[:, None] - height) / length) ** 2) / 2)


def _image(angle):
    """Index of the mirror image of each angle about the thrust plane."""
    return np.abs(_angle_between(np.pi - angle, angle)).argmin(axis=1)


def edge_patches(
    angle: np.ndarray, height: np.ndarray, along: float, has_film: np.ndarray, symmetric: bool
) -> tuple[np.ndarray, np.ndarray]:
    """Return narrow pressure patches at the lower and at the upper edge of a surface.

    Eq. (J46):  p = D exp(-((d_theta/L_theta)^2 + (d_y/L_y)^2) / (2 b^2)),   b = `PATCH_WIDTH`

    D is 1 where there is a film. The lengths are those of Eq. (J31). The centres are the outermost
    cells with a film, at most some 36 around.

    Parameters
    ----------
    angle, height, along, has_film
        As for `pressure_root`.
    symmetric : bool
        Whether each patch has its mirror image about the thrust plane.

    Returns
    -------
    ndarray, ndarray, shapes (c a, n)
        [-]
    """
    around, axial = _covariances(angle, height, along, PATCH_WIDTH)
    if symmetric:
        around = around + around[_image(angle)]
    film = has_film.reshape(len(angle), len(height))
    column = np.flatnonzero(film.any(axis=1))[:: max(1, len(angle) // 36)]
    lower = film[column].argmax(axis=1)
    upper = len(height) - 1 - film[column, ::-1].argmax(axis=1)

    def patches(row):
        field = around[:, None, column] * axial[None, :, row] * film[:, :, None]  # Eq. (J46)
        return field.reshape(len(has_film), len(column))

    return patches(lower), patches(upper)


def _angle_between(first, second):
    """Return the smaller angle between each first and each second angle [rad]."""
    return np.remainder(first[:, None] - second + np.pi, 2 * np.pi) - np.pi


def surface_answers(body: Elastic, reading: SurfaceReading, root: np.ndarray) -> SurfaceAnswers:
    """Return the body's answers to the patterns of `pressure_root`.

    Parameters
    ----------
    body : Elastic
    reading : SurfaceReading
        R and A: radial and axial displacement at the points, of the free degrees of freedom.
    root : ndarray, shape (points, n)
    """
    displacement = np.empty((reading.radial.shape[1], root.shape[1]))
    for first in range(0, root.shape[1], AT_ONCE):
        block = slice(first, first + AT_ONCE)
        displacement[:, block] = body.solve(reading.radial.T @ root[:, block])
    radial, axial = (one @ displacement for one in reading)
    return SurfaceAnswers(root, radial, axial, displacement)


def expected_patterns(answers: SurfaceAnswers, first: np.ndarray) -> np.ndarray:
    """Return the pressure patterns to which a surface yields most under the prior.

    Eq. (J32):  S^T R G R^T S v_i = mu_i v_i,   G = K^-1 - Psi Psi^T,   largest mu_i first

    Parameters
    ----------
    answers : SurfaceAnswers
    first : ndarray, shape (points, j)
        R Psi, Psi^T K Psi = 1: shapes that the basis has already.

    Returns
    -------
    ndarray, shape (n, n)
        v_i, one a column.
    """
    energy = answers.root.T @ _remaining_answers(answers, first)
    _, vector = la.eigh((energy + energy.T) / 2)  # Eq. (J32), rising
    return vector[:, ::-1]


def expected_missing(answers: SurfaceAnswers, first: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Return the largest expected missing share of the deflection with the first k patterns.

    Eq. (J33):  missing(k) = max_j |sum_(i>k) R G R^T S v_i v_i^T S^T e_j| / |R K^-1 R^T S S^T e_j|

    The load S S^T e_j is the pressure that the prior expects, given the pressure at point j: a
    smooth patch around that point. The share is that of the root mean squares over the surface.

    Parameters
    ----------
    answers, first
        As for `expected_patterns`.
    vector : ndarray, shape (n, n)
        Its result.

    Returns
    -------
    ndarray, shape (n + 1,)
        For k = 0 to n [-], never rising.
    """
    patches = answers.root[answers.root.any(axis=1)].T
    whole = np.linalg.norm(answers.radial @ patches, axis=0)
    shares = vector.T @ patches
    # a rotation of the surface's points keeps all norms
    answer = np.asarray(np.linalg.qr(_remaining_answers(answers, first) @ vector, mode="r"))
    missing = np.zeros(shares.shape)
    out = [0.0]
    for column, share in zip(answer.T[::-1], shares[::-1]):
        missing += np.outer(column, share)
        out.append(float((np.linalg.norm(missing, axis=0) / whole).max()))  # Eq. (J33)
    return np.maximum.accumulate(out)[::-1]


def _remaining_answers(answers, first):
    """Return R G R^T S of Eq. (J32), the radial deflections without those of the first shapes."""
    return answers.radial - first @ (first.T @ answers.root)


def smooth_pressure_modes(
    body: Elastic, radial: Sparse, answers: SurfaceAnswers, modes: int | float, first: np.ndarray
) -> np.ndarray:
    """Return the static shapes under the smooth pressures to which a surface yields most.

    Eq. (J32) gives the patterns v_i, and phi_i = G R^T S v_i = U v_i - Psi Psi^T R^T S v_i. A
    larger basis contains every smaller one that has the same first shapes.

    Parameters
    ----------
    body : Elastic
    radial : scipy.sparse matrix, shape (points, free)
        R [-].
    answers : SurfaceAnswers
    modes : int or float
        Number of shapes, the first ones included. A float is the largest expected missing share,
        Eq. (J33), that they may leave.
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
    on_surface = radial @ psi
    vector = expected_patterns(answers, on_surface)
    if isinstance(modes, int):
        count = modes - psi.shape[1]
    else:
        missing = expected_missing(answers, on_surface, vector)
        count = int(np.argmax(missing <= modes))
        needed = count + psi.shape[1]
        if needed > MOST_MODES:
            raise ValueError(
                f"modes: expected an error that {MOST_MODES} modes reach, got {modes:g} with "
                f"{needed} modes; give a larger error"
            )
    strongest = vector[:, :count]
    answered = on_surface.T @ (answers.root @ strongest)
    return np.hstack([answers.displacement @ strongest - psi @ answered, psi])
