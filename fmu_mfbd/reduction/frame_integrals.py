"""Inertia of a flexible body in planar motion, from its mass matrix and its modes."""

from typing import Any, NamedTuple

import numpy as np

from ..finite_elements.element import Sparse

Z = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # e_z x
P = np.diag([1.0, 1.0, 0.0])  # projection onto the plane of motion


class FrameIntegrals(NamedTuple):
    """Inertia of a flexible body in planar motion, Eq. (J7).

    mass [kg], S (2,) [kg m], I0 [kg m2], T (2, k), b (k,), B (k, k), g (k,), G (k, k).
    """

    mass: float
    S: np.ndarray
    I0: float
    T: np.ndarray
    b: np.ndarray
    B: np.ndarray
    g: np.ndarray
    G: np.ndarray


def floating_frame_integrals(M: Sparse, position: np.ndarray, modes: np.ndarray) -> FrameIntegrals:
    """Return the inertia of a flexible body in planar motion from its consistent mass matrix.

    Eq. (J7):  m = 1^T M 1,  S = E^T M r,  I0 = r^T M P r,  T = E^T M Phi,  b = Phi^T M P r,
               B = Phi^T M P Phi,  g = Phi^T M Z r,  G = Phi^T M Z Phi
               Z v = e_z x v,  P: projection onto x, y,  E: unit motions along x and y

    Parameters
    ----------
    M : scipy.sparse matrix, shape (3 n, 3 n)
        Mass [kg].
    position : ndarray, shape (n, 3)
        Nodes in the body frame with the origin at A [m].
    modes : ndarray, shape (n, 3, k)
        Mode shapes in the body frame [kg^-1/2].

    References
    ----------
    [Shabana2013] ch. 5. Checked against a differentiated Lagrangian in
    tests/mfbd/test_floating_frame.py.
    """
    flat = modes.reshape(3 * len(position), modes.shape[-1])
    unit = np.tile(np.eye(3)[:, :2], (len(position), 1))
    turned = np.einsum("ab,nbk->nak", Z, modes).reshape(flat.shape)
    planar = np.einsum("ab,nbk->nak", P, modes).reshape(flat.shape)
    arm = (position @ P).ravel()
    turn = (position @ Z.T).ravel()
    heavy = M @ unit
    modal = flat.T @ M
    # Eq. (J7)
    return FrameIntegrals(
        mass=float(unit[:, 0] @ heavy[:, 0]),
        S=heavy.T @ position.ravel(),
        I0=float(arm @ (M @ arm)),
        T=heavy.T @ flat,
        b=modal @ arm,
        B=modal @ planar,
        g=modal @ turn,
        G=modal @ turned,
    )


def rigid_integrals(rigid_mass: np.ndarray) -> dict[str, Any]:
    """Return mass, S and I0 of Eq. (J7) from the mass matrix of the rigid motions about A.

    Its last column is the inertia against a rotation about z.
    """
    first_x, first_y = rigid_mass[1, 5], -rigid_mass[0, 5]
    S = np.array([first_x, first_y])
    return dict(mass=float(rigid_mass[0, 0]), S=S, I0=float(rigid_mass[5, 5]))
