"""Sound radiation of a block's sides by the normal motion of its modes.

References
----------
[Cremer2005] L. Cremer, M. Heckl, B. A. T. Petersson, Structure-borne sound, 3rd ed., Springer 2005,
ch. 7: radiated power, radiation efficiency.
"""

from dataclasses import dataclass

import numpy as np

from ..finite_elements.faces import normal_products
from .reduced_body import Anatomy, ReducedBlock

SIDES = (("+x", 0, 1), ("-x", 0, -1), ("+y", 1, 1), ("-y", 1, -1), ("+z", 2, 1), ("-z", 2, -1))
"""Name, axis and sign of the outward normal's largest component."""
ON_BORE = 1e-2
"""Largest distance of the corners of the bore's faces from it, relative to its radius."""


@dataclass(frozen=True)
class Radiation:
    """Matrices for the radiated power of each side.

    Eq. (J25):  P = rho c q'^T R q',   R of Eq. (M19)      power of a side, radiation efficiency 1

    Parameters
    ----------
    first : int
        Index of the block's first modal coordinate among all.
    areas : dict of str to float
        Area of each side [m2].
    products : dict of str to ndarray, shape (k, k)
        R of each side for mass-normalised modes [m2/kg].
    """

    first: int
    areas: dict[str, float]
    products: dict[str, np.ndarray]


def radiation(block: ReducedBlock, anatomy: Anatomy, first: int) -> Radiation:
    """Return the matrices of all outer faces except the bore's, by the sides of `SIDES`."""
    corners = anatomy.points[anatomy.skin[:, :3]]
    away = np.hypot(corners[..., 0], corners[..., 2])
    on_bore = (np.abs(away - block.radius) < ON_BORE * block.radius).all(axis=1)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(axis=1)
    sign = np.sign(np.take_along_axis(normal, axis[:, None], 1)[:, 0])
    areas = {}
    products = {}
    for name, its_axis, its_sign in SIDES:
        chosen = ~on_bore & (axis == its_axis) & (sign == its_sign)
        faces = anatomy.skin[chosen]
        if len(faces):
            areas[name] = float(0.5 * np.linalg.norm(normal[chosen], axis=1).sum())
            products[name] = normal_products(anatomy.points, faces, anatomy.shapes)
    return Radiation(first, areas, products)
