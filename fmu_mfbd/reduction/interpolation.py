"""From mesh nodes to the regular grid on the developed cylinder (angle x height), by one sparse
matrix.
"""

import numpy as np
import scipy.sparse as sp

from ..finite_elements.faces import triangle_functions


def interpolation(points, triangles, angle, height, radius):
    """Matrix that takes nodal values of a cylinder's faces to the grid points (angle_i, height_j),
    j fastest.

    Eq. (S1):  value(theta, y) = sum_k N_k(s, t) value_k     triangle that covers (theta, y) on the developed surface

    A grid point with no surface under it (the pin holes) takes the value of the nearest surface
    point.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Nodes [m]; the cylinder's axis is y through the origin.
    triangles : ndarray of int, shape (t, 3 or 6)
    angle, height : ndarray
        Grid lines [rad], [m].
    radius : float
        Radius that turns angles into lengths [m].

    Returns
    -------
    scipy.sparse.csr_matrix, shape (len(angle) * len(height), n)
        Rows add up to 1.
    """
    theta, y = np.repeat(angle, len(height)), np.tile(height, len(angle))
    corner = points[triangles[:, :3]]
    turn = np.arctan2(corner[:, :, 0], corner[:, :, 2])
    first = turn[:, :1]
    turn = (
        first + np.remainder(turn - first + np.pi, 2 * np.pi) - np.pi
    )  # one triangle never straddles the cut
    rows, columns, values = [], [], []
    for chunk in np.array_split(np.arange(len(theta)), max(1, len(theta) // 400)):
        centre = turn.mean(axis=1)
        shift = centre + np.remainder(theta[chunk, None] - centre + np.pi, 2 * np.pi) - np.pi
        best, s, t = _nearest(
            np.stack([radius * turn, corner[:, :, 1]], axis=-1), radius * shift, y[chunk]
        )
        rows.append(np.repeat(chunk, triangles.shape[1]))
        columns.append(triangles[best].ravel())
        values.append(triangle_functions(s, t, triangles.shape[1])[0].ravel())  # Eq. (S1)
    shape = (len(theta), len(points))
    return sp.csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape=shape
    )


def _nearest(corners, x, y):
    """Triangle nearest to each point and the nearest point's s, t in it.

    corners (t, 3, 2); x (p, t), because each triangle sees the point on its own branch of the
    angle; y (p,).
    """
    origin, u, v = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    det = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    dx, dy = x - origin[:, 0], y[:, None] - origin[:, 1]
    s, t = (dx * v[:, 1] - dy * v[:, 0]) / det, (dy * u[:, 0] - dx * u[:, 1]) / det
    s, t = _clamp(s, t, u, v)
    gap = np.hypot(dx - s * u[:, 0] - t * v[:, 0], dy - s * u[:, 1] - t * v[:, 1])
    best = gap.argmin(axis=1)
    point = np.arange(len(y))
    return best, s[point, best], t[point, best]


def _clamp(s, t, u, v):
    """Nearest point of the triangle to the point s u + t v: itself inside, else the nearest of the
    three edges' nearest points.
    """
    uu, uv, vv = (u * u).sum(1), (u * v).sum(1), (v * v).sum(1)
    inside = (s >= 0) & (t >= 0) & (s + t <= 1)
    on_u = np.clip(s + t * uv / uu, 0, 1)
    on_v = np.clip(t + s * uv / vv, 0, 1)
    ww = uu - 2 * uv + vv
    on_w = np.clip((t * (vv - uv) - (s - 1) * (uu - uv)) / ww, 0, 1)
    candidates = [(on_u, np.zeros_like(t)), (np.zeros_like(s), on_v), (1 - on_w, on_w)]
    gaps = [
        uu * (s - a) ** 2 + 2 * uv * (s - a) * (t - b) + vv * (t - b) ** 2 for a, b in candidates
    ]
    pick = np.argmin(gaps, axis=0)
    return (
        np.where(inside, s, np.choose(pick, [a for a, _ in candidates])),
        np.where(inside, t, np.choose(pick, [b for _, b in candidates])),
    )


def radial_and_axial(interpolate, angle, n_axial):
    """Matrices (grid points x 3 n) that read the outward radial and the axial displacement at the
    grid points.

    Eq. (S2):  u_r = u_x sin theta + u_z cos theta
    """
    theta = np.repeat(angle, n_axial)
    pick = [
        sp.kron(sp.identity(interpolate.shape[1], format="csr"), np.eye(3)[[a]], format="csr")
        for a in range(3)
    ]
    radial = (
        sp.diags(np.sin(theta)) @ interpolate @ pick[0]
        + sp.diags(np.cos(theta)) @ interpolate @ pick[2]
    )  # Eq. (S2)
    return radial.tocsr(), (interpolate @ pick[1]).tocsr()
