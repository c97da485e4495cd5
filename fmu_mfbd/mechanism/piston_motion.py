"""Coordinates of the piston, which are [x_A, rocking angle, modal coordinates], and its load."""

from typing import NamedTuple

from ..geometry.arrays import Vector

LATERAL = 0
ROCKING = 1
"""Coordinates of the rigid piston: x_A [m] and the rocking angle [rad]; modal ones follow."""

RIGID = 2
"""Number of the rigid piston's coordinates."""


class Load(NamedTuple):
    """Forces on the piston at the end of a step.

    Parameters
    ----------
    lateral, axial : float
        Resultants along x and y, pin excepted [N].
    moment : float
        About A where x_A = 0, about +z [N m].
    axis_force : float
        Force along -y on the bore's axis, `axial` holds it too [N]: away from x_A = 0 its moment
        about A is larger by axis_force x_A.
    modal : ndarray, shape (k,)
        [kg^-1/2 N]
    """

    lateral: float
    axial: float
    moment: float
    axis_force: float
    modal: Vector
