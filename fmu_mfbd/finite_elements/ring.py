"""Mesh of a ring about z, for the shell of a bearing without a mesh file."""

from itertools import permutations
from typing import NamedTuple

import numpy as np

from .connections import outer_faces
from .element import EDGES
from .mesh import Mesh

BORE, HELD = "bore", "held"
"""Surfaces of a shell: the bore about z, and the surface that another body holds."""


class Ring(NamedTuple):
    """Ring about z, whose outer surface is held over an arc about +y.

    Parameters
    ----------
    inside, outside : float
        Radii [m].
    length : float
        Along z, from -length/2 to length/2 [m].
    arc : float
        Angle over which the outer surface is held [rad].
    cells : (int, int, int)
        Number of blocks of six tetrahedra around, through the wall and along.
    """

    inside: float
    outside: float
    length: float
    arc: float
    cells: tuple[int, int, int]


def ring_mesh(ring: Ring) -> Mesh:
    """Return ten-node tetrahedra of a ring with the surfaces `bore` and `held`.

    Each block of a regular grid is divided along its diagonal into six tetrahedra. All nodes of
    the bore are on its cylinder. `held` has the outer faces whose nodes are all on the arc.
    """
    around, through, along = ring.cells
    lines = 2 * around, 2 * through + 1, 2 * along + 1
    blocks = np.indices(ring.cells).reshape(3, -1).T
    corners = []
    for order in permutations(range(3)):
        steps = np.vstack([np.zeros(3, dtype=int), np.cumsum(np.eye(3, dtype=int)[list(order)], 0)])
        if np.linalg.det(np.eye(3)[list(order)]) > 0:
            steps[[0, 1]] = steps[[1, 0]]  # a positive volume
        corners.append(2 * (blocks[:, None] + steps))
    corners = np.concatenate(corners)
    nodes = np.concatenate([corners, corners[:, EDGES].sum(axis=2) // 2], axis=1)
    nodes[..., 0] %= 2 * around
    tets = np.asarray(np.ravel_multi_index(tuple(np.moveaxis(nodes, -1, 0)), lines))
    angle, wall, height = (np.indices(lines).reshape(3, -1).T / (2 * np.array(ring.cells))).T
    angle = 2 * np.pi * angle
    radius = ring.inside + (ring.outside - ring.inside) * wall
    points = np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), ring.length * (height - 0.5)], axis=1
    )
    faces = outer_faces(tets)
    from_top = np.abs((angle - np.pi / 2 + np.pi) % (2 * np.pi) - np.pi)
    clamped = (wall == 1.0) & (from_top <= ring.arc / 2 + 1e-9)
    surfaces = {BORE: wall == 0.0, HELD: clamped}
    return Mesh(points, tets, {name: faces[on[faces].all(axis=1)] for name, on in surfaces.items()})
