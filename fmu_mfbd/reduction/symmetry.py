"""Modes that are even or odd about x = 0 and z = 0, for symmetric bodies."""

from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from ..finite_elements.mesh import Mesh
from .bases import Elastic, Modes, orthonormal_modes


class ClassedModes(NamedTuple):
    """Modes with their symmetry classes.

    Parameters
    ----------
    shapes : ndarray, shape (3 n, k)
        Modes on all degrees of freedom [kg^-1/2].
    omega : ndarray, shape (k,)
        Ascending angular frequencies [rad/s].
    kind : ndarray of int, shape (k,)
        Class 2 x + z, where x, z = 1 if odd across x = 0, z = 0; -1 without symmetry.
    """

    shapes: np.ndarray
    omega: np.ndarray
    kind: np.ndarray


def mirror_image(points: np.ndarray, axis: int) -> np.ndarray | None:
    """Return the mirror image of each node about the plane axis = 0, None if one has no image.

    The tolerance is 1e-6 of the size.
    """
    flipped = points.copy()
    flipped[:, axis] *= -1.0
    distance, image = KDTree(points).query(flipped)
    return np.asarray(image) if np.max(distance) <= 1e-6 * np.ptp(points) else None


def is_mirrored(mesh: Mesh, axis: int) -> bool:
    """Return whether the nodes of a mesh and of each of its materials are their mirror image."""
    image = mirror_image(mesh.points, axis)
    if image is None:
        return False
    sets = mesh.material.name if mesh.material else np.empty(0, dtype=str)
    for name in np.unique(sets):
        own = np.zeros(len(mesh.points), dtype=bool)
        own[mesh.tets[sets == name]] = True
        if (own[image] != own).any():
            return False
    return True


def class_parts(modes: np.ndarray, points: np.ndarray) -> list[np.ndarray] | None:
    """Return the parts of modes, (n, 3, k), in the four classes, None without both symmetries.

    Eq. (J9):  phi_(sx sz) = (1 + sx S_x)(1 + sz S_z) phi / 4
               class 2 x + z: x, z = 1 where the sign is -1 (odd)
    """
    image_x = mirror_image(points, 0)
    image_z = mirror_image(points, 2)
    if image_x is None or image_z is None:
        return None
    halves = _even_and_odd(modes, image_x, 0)
    return [part for half in halves for part in _even_and_odd(half, image_z, 2)]  # Eq. (J9)


def _even_and_odd(modes, image, axis):
    """Return the parts of modes that are even and odd about the plane axis = 0."""
    reflected = modes[image]
    reflected[:, axis] *= -1.0
    return (modes + reflected) / 2, (modes - reflected) / 2


def symmetric_modes(body: Elastic, modes: Modes, points: np.ndarray) -> ClassedModes:
    """Remove round-off and mesh noise across the symmetry planes from modes.

    Parameters
    ----------
    body : Elastic
    modes : Modes
        Modes on all degrees of freedom, (3 n, k).
    points : ndarray, shape (n, 3)
        Nodes; the planes contain the origin [m].

    Returns
    -------
    ClassedModes
        Orthonormal modes that are exactly even or odd, by ascending frequency. For a body without
        these symmetries, the modes are unchanged with class -1.
    """
    shapes, omega = modes
    count = len(omega)
    unchanged = ClassedModes(shapes, omega, np.full(count, -1))
    parts = class_parts(shapes.reshape(len(points), 3, count), points)
    if parts is None or not count:
        return unchanged
    parts = [part.reshape(len(shapes), -1)[body.free] for part in parts]
    spectra = [np.linalg.eigh(part.T @ (body.M @ part)) for part in parts]
    # each class holds as many directions of the modes' space as its Gram matrix has eigenvalues
    # near 1
    share = np.concatenate([value for value, _ in spectra])
    chosen = np.sort(np.argsort(share)[-count:])
    kind = chosen // count
    pure = np.empty_like(shapes)
    frequency = np.empty_like(omega)
    for number, (part, (_, vectors)) in enumerate(zip(parts, spectra)):
        mine = np.flatnonzero(kind == number)
        if len(mine):
            of_class = orthonormal_modes(body, part @ vectors[:, chosen[mine] % count])
            frequency[mine] = of_class.omega
            pure[:, mine] = body.full(of_class.shapes)
    gram = pure[body.free].T @ (body.M @ pure[body.free])
    # nodes may mirror where elements do not, or a half-kept pair of modes may leave a class
    if share[chosen].min() < 0.5 or np.abs(gram - np.eye(count)).max() > 1e-9:
        return unchanged
    order = np.argsort(frequency, kind="stable")
    return ClassedModes(pure[:, order], frequency[order], kind[order])
