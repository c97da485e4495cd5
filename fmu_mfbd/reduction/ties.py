"""Ties of a piston's pin bores to pin point A."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp

from ..body_options import SLIDING_LAYER, Piston
from ..finite_elements.element import Sparse, rigid_motions
from ..finite_elements.faces import surface_matrix
from ..finite_elements.mesh import Mesh, MeshFault
from ..finite_elements.solver import Factorise
from .bases import Elastic, MeanElastic, mean_conditions
from .bosses import SIDES, SURFACE, about_y, faces_of_boss, out_of_round
from .geometry import pin_bore
from .interpolation import covered, interpolation

SHIFT_AND_TURN = [2, 5]
"""Rigid motions along the pin and about it, which a sliding tie leaves to the mean conditions."""

HINT = "; set piston.tie to rbe2 or rbe3"


class PinLayer(NamedTuple):
    """Elastic layer between both pin bores and a rigid pin, on a grid over the loaded half.

    Parameters
    ----------
    normal : scipy.sparse matrix, shape (cells, 3 n)
        D, which reads the displacement of the bore along its normal.
    area : ndarray, shape (cells,)
        Area of each cell, 0 where the mesh has no bore [m2].
    length : float
        Length of each boss that bears, from its inner end [m].
    """

    normal: Sparse
    area: np.ndarray
    length: float

    def stiffness(self) -> Sparse:
        """Return D^T (k A) D of Eq. (J51), (3 n, 3 n) [N/m]."""
        return self.normal.T @ sp.diags(SLIDING_LAYER.stiffness * self.area) @ self.normal


def pin_layer(mesh: Mesh, length: float | None) -> PinLayer:
    """Return the layer of the tie `sliding`, on the half of the bores that gas presses on the pin.

    The turn about the pin and the shift along it have no normal displacement, to round-off.

    Parameters
    ----------
    mesh : Mesh
        With a surface `pin_bore`.
    length : float, optional
        Length of each boss that bears [m]. Default: the diameter of the bore, or the length of the
        shorter boss if it is less.

    Raises
    ------
    MeshFault
        If the bores are no cylinders, are shorter than the length, or have no upper half.
    """
    position = _from_pin(mesh)
    faces = mesh.faces[SURFACE]
    radius = float(np.hypot(*position[mesh.nodes(SURFACE)][:, :2].T).mean())
    if fault := out_of_round(position, faces, radius):
        raise MeshFault([f"surface '{SURFACE}': {fault}{HINT}"])
    bosses = faces_of_boss(mesh, position)
    depth = {name: np.abs(position[np.unique(own), 2]) for name, own in bosses.items()}
    reach = min(float(np.ptp(one)) for one in depth.values())
    if length is None:
        length = min(2 * radius, reach)
    if length > (1 + 1e-6) * reach:
        raise MeshFault(
            [
                f"piston.boss_length: expected at most {1e3 * reach:.4g} mm, the length of a boss "
                f"of surface '{SURFACE}', got {1e3 * length:.4g} mm"
            ]
        )
    around, along = SLIDING_LAYER.cells
    angle = np.pi * (np.arange(around) + 0.5) / around
    rows = length * (np.arange(along) + 0.5) / along
    cell = np.pi * radius / around * length / along
    values, areas, faults = [], [], []
    for name, own in bosses.items():
        place = own, angle, np.sort(SIDES[name] * (depth[name].min() + rows)), radius
        has_bore = covered(about_y(position), *place).ravel()
        values.append(interpolation(about_y(position), *place))
        areas.append(cell * has_bore)
        if not has_bore.any():
            faults.append(
                f"surface '{SURFACE}', {name}: expected a bore above the pin, got none{HINT}"
            )
    if faults:
        raise MeshFault(faults)
    x, y, _ = position.T
    distance = np.maximum(np.hypot(x, y), 1e-9)  # other nodes may be on the axis
    outward = sp.kron(sp.diags(x / distance), [[1.0, 0.0, 0.0]])
    outward = outward + sp.kron(sp.diags(y / distance), [[0.0, 1.0, 0.0]])
    return PinLayer(sp.vstack(values) @ outward.tocsr(), np.concatenate(areas), length)


def tie_of(mesh: Mesh, options: Piston, floating: bool) -> str:
    """Return the tie of the pin bores: that of the options, or the default.

    floating : whether the pin floats on films in the bosses.
    """
    position = _from_pin(mesh)
    radius = float(np.hypot(*position[mesh.nodes(SURFACE)][:, :2].T).mean())
    cylinders = not out_of_round(position, mesh.faces[SURFACE], radius)
    return options.tie or ("rbe3" if floating else "sliding" if cylinders else "rbe2")


def held_piston(
    mesh: Mesh,
    K: Sparse,
    M: Sparse,
    options: Piston,
    progress: Callable[[str], None],
    factors: Factorise,
    floating: bool = False,
) -> Elastic:
    """Return a piston, held at its pin bores by the tie of the options (`tie_of`).

    Eq. (J51):  K' = K + D^T (k A) D       `sliding`: K' replaces K, and Eq. (J5) has rows 3 and 6

    D reads the displacement of the bore along its normal at the cells of a grid, A has the areas of
    the cells, and k is the stiffness of `SLIDING_LAYER`. The rows hold the mean shift along the pin
    and the mean turn about it. `rbe2` fixes every node of the bores, `rbe3` their mean motion.

    Raises
    ------
    MeshFault
        As of `pin_layer`.
    """
    tie = tie_of(mesh, options, floating)
    progress(f"pin bores: tie {tie}")
    if tie == "rbe2":
        return Elastic(K, M, mesh.nodes(SURFACE), factors)
    area = np.asarray(surface_matrix(mesh.points, mesh.faces[SURFACE]).sum(axis=1)).ravel()
    if tie == "rbe3":
        conditions = mean_conditions(mesh.points, area)
        return MeanElastic(K, M, conditions, rigid_motions(mesh.points), factors)
    layer = pin_layer(mesh, options.boss_length)
    progress(f"the inner {1e3 * layer.length:.4g} mm of each boss bear on the pin")
    position = _from_pin(mesh)
    conditions = mean_conditions(position, area)[SHIFT_AND_TURN]
    free = rigid_motions(position)[:, SHIFT_AND_TURN]
    return MeanElastic(K + layer.stiffness(), M, conditions, free, factors)  # Eq. (J51)


def _from_pin(mesh: Mesh) -> np.ndarray:
    """Return the nodes of a piston from its pin's axis, (n, 3) [m]."""
    axis, _ = pin_bore(mesh)
    return mesh.points - np.array([axis.first, 0.0, 0.0])
