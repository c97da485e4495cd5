"""Shapes of a body under the film forces of a finished run, most important first."""

from typing import NamedTuple

import numpy as np
import scipy.linalg as la

from ..finite_elements.element import Sparse
from .bases import Elastic
from .film_loads import FilmLoads

NEGLIGIBLE_STRENGTH = 1e-4
"""Smallest strength of a load pattern that is used, relative to the largest."""
REMAINING_DEFLECTION = 1e-3
"""Largest remaining deflection, in the energy norm, relative to the whole."""
AT_ONCE = 20
"""Number of loads for each solution, which limits the memory."""


class LoadPatterns(NamedTuple):
    """Orthonormal patterns of pressure and friction, (r, 2 points), and strengths, (r,) [N]."""

    pattern: np.ndarray
    strength: np.ndarray


def load_patterns(film: FilmLoads) -> LoadPatterns:
    """Return the dominant patterns of film forces, even or odd about both planes of symmetry.

    Eq. (J18):  [p, f] = sum_j s_j u_j v_j^T      for each class of Eq. (J9), largest s_j first

    A slap on one side may be on the other side in the next run, and modes that are even or odd cost
    a quarter. An odd number of points around has no mirror images, and one class.

    Parameters
    ----------
    film : FilmLoads
        m instants on c x s points of `grid.cell_centres`' angles.
    """
    whole = np.stack(film, axis=-1)
    patterns = []
    strengths = []
    for part in _mirrored_classes(whole):
        flat = part.transpose(0, 3, 1, 2).reshape(len(part), -1)
        _, strength, pattern = la.svd(flat, full_matrices=False)  # Eq. (J18)
        patterns.append(pattern)
        strengths.append(strength)
    strength = np.concatenate(strengths)
    order = np.argsort(-strength, kind="stable")
    significant = order[strength[order] > NEGLIGIBLE_STRENGTH * strength.max()]
    return LoadPatterns(np.concatenate(patterns)[significant], strength[significant])


def _mirrored_classes(fields: np.ndarray) -> list[np.ndarray]:
    """Return parts of fields (m, c, s, 2) that are even and odd in x and z, or the fields."""
    around = fields.shape[1]
    if around % 2:
        return [fields]
    # theta_i = pi/2 + (i - floor(c/4)) 2 pi/c, so that pi - theta is number 2 floor(c/4) - i
    image = (2 * (around // 4) - np.arange(around)) % around
    across_z = fields[:, image]
    across_x = np.roll(across_z, around // 2, axis=1)
    both = np.roll(fields, around // 2, axis=1)
    return [
        (fields + x * across_x + z * across_z + x * z * both) / 4 for x in (1, -1) for z in (1, -1)
    ]


def trained_shapes(
    body: Elastic, spread: Sparse, film: FilmLoads, known: np.ndarray, most: int
) -> np.ndarray:
    """Return the static shapes with the smallest remaining energy under film forces.

    Eq. (J19):  X = (K^-1 - Psi Psi^T) B V S,   X^T K X w_k = e_k w_k,   phi_k = X w_k e_k^-1/2
                largest e_k first, until less than e^2 of the energy of K^-1 B V S is left,
                e = `REMAINING_DEFLECTION`

    B distributes pressure and friction from the points, V S are the patterns of Eq. (J18).

    Parameters
    ----------
    body : Elastic
    spread : scipy.sparse matrix, shape (free, 2 points)
        B [-].
    film : FilmLoads
        At the points.
    known : ndarray, shape (free, j)
        Psi: shapes that the basis already contains, Psi^T K Psi = 1.
    most : int
        Maximum number of shapes.

    Returns
    -------
    ndarray, shape (free, k)
        k <= most shapes, none if the given shapes are sufficient; phi^T K phi = 1 and
        Psi^T K phi = 0.

    Raises
    ------
    ValueError
        If there is no force.

    References
    ----------
    Proper orthogonal decomposition of the deflections, see docs/measurements/trained_modes.md.
    """
    if not any(force.any() for force in film):
        raise ValueError("train_on: expected a run whose film loads the body, got no force")
    pattern, strength = load_patterns(film)
    loads = spread @ (pattern * strength[:, None]).T
    parts = range(0, len(strength), AT_ONCE)
    answers = np.hstack([body.solve(loads[:, first : first + AT_ONCE]) for first in parts])
    whole = float(np.sum(answers * loads))
    answers -= known @ (known.T @ loads)
    gram = answers.T @ loads
    energy, turn = la.eigh((gram + gram.T) / 2)  # Eq. (J19), rising
    energy = np.maximum(energy, 0.0)
    enough = np.count_nonzero(np.cumsum(energy) > REMAINING_DEFLECTION**2 * whole)
    best = np.arange(len(energy))[::-1][: min(enough, most)]
    return answers @ (turn[:, best] / np.sqrt(energy[best]))
