"""Bodies that are their own mirror image about x = 0 and z = 0: modes that are even or odd about
both planes.
"""

import numpy as np
from scipy.spatial import cKDTree

from .bases import orthonormal_modes


def mirror_image(points, axis):
    """Node that is the mirror image of each node about the plane axis = 0, or None if one has none
    within 1e-6 of the size.
    """
    flipped = points.copy()
    flipped[:, axis] *= -1.0
    distance, image = cKDTree(points).query(flipped)
    return image if distance.max() <= 1e-6 * np.ptp(points) else None


def class_parts(modes, points):
    """Parts of modes (n, 3, k) in the four classes, (4, n, 3, k), or None without both symmetries.

    Eq. (Y1):  phi_(sx sz) = (1 + sx S_x)(1 + sz S_z) phi / 4      class 2 x + z: x, z = 1 where the sign is -1 (odd)
    """
    images = [mirror_image(points, axis) for axis in (0, 2)]
    if any(image is None for image in images):
        return None
    reflect = [
        modes[image] * np.where(np.arange(3) == axis, -1.0, 1.0)[None, :, None]
        for axis, image in zip((0, 2), images)
    ]
    both = reflect[0][images[1]] * np.array([1.0, 1.0, -1.0])[None, :, None]
    return np.stack(
        [
            (modes + sx * reflect[0] + sz * reflect[1] + sx * sz * both) / 4  # Eq. (Y1)
            for sx in (1, -1)
            for sz in (1, -1)
        ]
    )


def symmetric_modes(body, modes, omega, points):
    """Clean modes of round-off and of mesh noise across the symmetry planes.

    Parameters
    ----------
    body : Elastic
    modes : ndarray, shape (3 n, k)
        Mass-orthonormal modes on all degrees of freedom [kg^-1/2].
    omega : ndarray, shape (k,)
        [rad/s]
    points : ndarray, shape (n, 3)
        Nodes, the planes through the origin [m].

    Returns
    -------
    modes, omega
        As given, or exactly even or odd and orthonormal again, by rising frequency.
    kind : ndarray of int, shape (k,)
        Class 2 x + z of each mode (x, z = 1 where odd across x = 0, z = 0); -1 for a body without
        these symmetries.
    """
    parts = class_parts(modes.reshape(len(points), 3, len(omega)), points)
    if parts is None or not len(omega):
        return modes, omega, np.full(len(omega), -1)
    parts = [body_part.reshape(len(modes), -1)[body.free] for body_part in parts]
    spectra = [np.linalg.eigh(part.T @ (body.M @ part)) for part in parts]
    # each class holds as many directions of the modes' space as its Gram matrix has eigenvalues
    # near 1
    share = np.concatenate([value for value, _ in spectra])
    kept = np.sort(np.argsort(share)[-len(omega) :])
    pure, frequency, kind = np.empty_like(modes), np.empty_like(omega), kept // len(omega)
    for c, (part, (_, vectors)) in enumerate(zip(parts, spectra)):
        mine = np.flatnonzero(kind == c)
        if len(mine):
            shapes, frequency[mine] = orthonormal_modes(
                body, part @ vectors[:, kept[mine] % len(omega)]
            )
            pure[:, mine] = body.full(shapes)
    gram = pure[body.free].T @ (body.M @ pure[body.free])
    # nodes may mirror where elements do not, or a half-kept pair of modes may leave a class
    if share[kept].min() < 0.5 or np.abs(gram - np.eye(len(omega))).max() > 1e-9:
        return modes, omega, np.full(len(omega), -1)
    order = np.argsort(frequency, kind="stable")
    return pure[:, order], frequency[order], kind[order]
