"""Interpolation from mesh nodes to the regular grid on the developed cylinder."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..finite_elements.element import Sparse
from ..finite_elements.faces import triangle_functions

SURFACE_TOLERANCE = 1e-3
"""Largest distance of a point from a surface with straight edges, relative to the radius."""


class SurfacePoints(NamedTuple):
    """Nearest points on triangles: triangle, s and t in it, and distance [m], each (p,)."""

    triangle: np.ndarray
    s: np.ndarray
    t: np.ndarray
    distance: np.ndarray


class SurfaceReading(NamedTuple):
    """Matrices (grid points, 3 n) that read the outward radial and the axial displacement."""

    radial: Sparse
    axial: Sparse


def interpolation(
    points: np.ndarray,
    triangles: np.ndarray,
    angle: np.ndarray,
    height: np.ndarray,
    radius: float,
) -> Sparse:
    """Return the matrix from nodal values to values at the grid points (angle_i, height_j).

    Eq. (I1):  value(theta, y) = sum_k N_k(s, t) value_k     triangle that covers (theta, y) on the
                                                             developed surface

    j is the fastest index. A grid point in a hole has the value of the nearest surface point.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Nodes [m]; the cylinder's axis is y through the origin.
    triangles : ndarray of int, shape (t, 3 or 6)
    angle, height : ndarray
        Grid lines [rad], [m].
    radius : float
        Radius of the cylinder [m].

    Returns
    -------
    scipy.sparse.csr_matrix, shape (len(angle) * len(height), n)
        Rows add up to 1.
    """
    at = _nearest_points(points, triangles, angle, height, radius, holes=True)
    shape = triangle_functions(at.s, at.t, triangles.shape[1])
    rows = np.repeat(np.arange(len(at.s)), triangles.shape[1])
    ij = rows, triangles[at.triangle].ravel()
    values = shape.value.ravel()  # Eq. (I1)
    return sp.csr_matrix((values, ij), shape=(len(at.s), len(points)))


def covered(
    points: np.ndarray,
    triangles: np.ndarray,
    angle: np.ndarray,
    height: np.ndarray,
    radius: float,
) -> np.ndarray:
    """Return which grid points have the surface within `SURFACE_TOLERANCE`, (angles, heights).

    Arguments are those of `interpolation`.
    """
    at = _nearest_points(points, triangles, angle, height, radius, holes=False)
    return (at.distance <= SURFACE_TOLERANCE * radius).reshape(len(angle), len(height))


def _nearest_points(points, triangles, angle, height, radius, holes):
    """Return the nearest point of the developed surface to each grid point, j fastest.

    Without `holes`, the distance of points that are not within `SURFACE_TOLERANCE` is any larger
    value.
    """
    corner = points[triangles[:, :3]]
    turn = np.arctan2(corner[:, :, 0], corner[:, :, 2])
    first = turn[:, :1]
    # one triangle never straddles the cut
    turn = first + np.remainder(turn - first + np.pi, 2 * np.pi) - np.pi
    centre = turn.mean(axis=1)
    flat = np.stack([radius * turn, corner[:, :, 1]], axis=-1)
    lowest = flat[:, :, 0].min(axis=1) - SURFACE_TOLERANCE * radius
    highest = flat[:, :, 0].max(axis=1) + SURFACE_TOLERANCE * radius
    nearest = []
    for theta in angle:
        x = radius * (centre + np.remainder(theta - centre + np.pi, 2 * np.pi) - np.pi)
        near = np.flatnonzero((lowest <= x) & (x <= highest))
        for y in np.array_split(height, max(1, len(height) // 400)):
            none = np.full(len(y), np.inf)
            at = SurfacePoints(np.zeros(len(y), dtype=int), none, none, none)
            if len(near):
                at = _nearest(flat[near], x[near], y)
                at = at._replace(triangle=near[at.triangle])
            if holes and (at.distance > SURFACE_TOLERANCE * radius).any():
                at = _nearest(flat, x, y)
            nearest.append(at)
    return SurfacePoints(*map(np.concatenate, zip(*nearest)))


def _nearest(corners: np.ndarray, x: np.ndarray, y: np.ndarray) -> SurfacePoints:
    """Return the nearest point of the surface to each point.

    corners : (t, 3, 2). x : (t,), because each triangle has its own branch of the angle. y : (p,).
    """
    origin, second, third = corners.swapaxes(0, 1)
    u = second - origin
    v = third - origin
    ux, uy = u.T
    vx, vy = v.T
    det = ux * vy - uy * vx
    dx = x - origin[:, 0]
    dy = y[:, None] - origin[:, 1]
    s = (dx * vy - dy * vx) / det
    t = (dy * ux - dx * uy) / det
    s, t = _clamp(s, t, u, v)
    gap = np.hypot(dx - s * ux - t * vx, dy - s * uy - t * vy)
    best = gap.argmin(axis=1)
    point = np.arange(len(y))
    return SurfacePoints(best, s[point, best], t[point, best], gap[point, best])


def _clamp(s, t, u, v):
    """Return the nearest point of the triangle to s u + t v, which may be on one of its edges."""
    uu = (u * u).sum(1)
    uv = (u * v).sum(1)
    vv = (v * v).sum(1)
    ww = uu - 2 * uv + vv
    inside = (s >= 0) & (t >= 0) & (s + t <= 1)
    on_u = np.clip(s + t * uv / uu, 0, 1)
    on_v = np.clip(t + s * uv / vv, 0, 1)
    on_w = np.clip((t * (vv - uv) - (s - 1) * (uu - uv)) / ww, 0, 1)
    nothing = np.zeros_like(s)
    edge_s = [on_u, nothing, 1 - on_w]
    edge_t = [nothing, on_v, on_w]
    gaps = [
        uu * (s - a) ** 2 + 2 * uv * (s - a) * (t - b) + vv * (t - b) ** 2
        for a, b in zip(edge_s, edge_t)
    ]
    nearest = np.argmin(gaps, axis=0)
    return (
        np.where(inside, s, np.choose(nearest, edge_s)),
        np.where(inside, t, np.choose(nearest, edge_t)),
    )


def radial_and_axial(interpolate: Sparse, angle: np.ndarray, n_axial: int) -> SurfaceReading:
    """Return the matrices that read the displacement at the grid points.

    Eq. (I2):  u_r = u_x sin theta + u_z cos theta

    Parameters
    ----------
    interpolate : scipy.sparse.csr_matrix, shape (grid points, n)
        `interpolation`.
    angle : ndarray
        Grid lines [rad].
    n_axial : int
        Number of points on each line.
    """
    theta = np.repeat(angle, n_axial)
    zero = np.zeros_like(theta)
    radial = np.stack([np.sin(theta), zero, np.cos(theta)])  # Eq. (I2)
    return SurfaceReading(
        directed(interpolate, radial), directed(interpolate, [zero, zero + 1, zero])
    )


def directed(interpolate: Sparse, direction: Sequence[np.ndarray] | np.ndarray) -> Sparse:
    """Return the matrix (points, 3 n) that reads the displacement along a direction at each point.

    interpolate : (points, n). direction : x, y and z components, (3, points).
    """
    parts = [
        sp.diags(component) @ sp.kron(interpolate, axis[None, :], format="csr")
        for component, axis in zip(direction, np.eye(3))
        if component.any()
    ]
    return sp.csr_matrix(sum(parts[1:], parts[0]))
