"""A flexible body in a frame that is fixed to its point A, such as a piston at its pin.

`mechanism.inertia` computes the inertia forces of this body.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ..geometry.arrays import Matrix, Vector

X = 0
Y = 1
TURN = 2
"""Rows and columns of the frame's rigid motions: along its x and y, and about A; modes follow."""


class FlexibleBody(NamedTuple):
    """Inertia integrals (Eq. (J7)) and modal springs of a reduced body.

    The k modes are mass-orthonormal. A rigid body has k = 0.

    Parameters
    ----------
    mass : float
        [kg]
    S : ndarray, shape (2,)
        First moment about A [kg m].
    I0 : float
        Moment of inertia about A, about the axis z [kg m2].
    T : ndarray, shape (2, k)
        Change of the first moment with the modes [kg^1/2].
    b, B : ndarray, shapes (k,), (k, k)
        The moment of inertia about A is I0 + 2 b.q + q.B q, with modal coordinates q
        [kg^1/2 m], [-].
    g, G : ndarray, shapes (k,), (k, k)
        The motion of the modes has the angular momentum (g + G q).q' about A [kg^1/2 m], [-].
    stiffness : ndarray, shape (k,)
        omega^2 [rad2/s2].
    damping : ndarray, shape (k,)
        2 zeta omega [rad/s].
    """

    mass: float
    S: Annotated[np.ndarray, "2"]
    I0: float
    T: Annotated[np.ndarray, "2, k"]
    b: Annotated[np.ndarray, "k"]
    B: Annotated[np.ndarray, "k, k"]
    g: Annotated[np.ndarray, "k"]
    G: Annotated[np.ndarray, "k, k"]
    stiffness: Annotated[np.ndarray, "k"]
    damping: Annotated[np.ndarray, "k"]


class ArrowMatrix(NamedTuple):
    """Mass matrix or tangent in arrow form: modes couple to rigid motions only.

    Entries between different modes are omitted.

    Parameters
    ----------
    top : ndarray, shape (m, m + k)
        Rows of the m rigid motions.
    left : ndarray, shape (k, m)
        Their columns, in the rows of the modes.
    diagonal : ndarray, shape (k,)
        Entries of the modes on the diagonal.
    """

    top: Matrix
    left: Matrix
    diagonal: Vector
