"""Planar motion of a flexible body in a frame that is fixed to its point A.

It has inertia and elastic forces, and their exact tangent.

References
----------
[Shabana2013] A. A. Shabana, Dynamics of Multibody Systems, 4th ed., Cambridge University Press,
2013.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled
from ..geometry.arrays import Matrix, Vector

X = 0
Y = 1
TURN = 2
"""Rows and columns of the frame's rigid motions: along its x and y, and about A; modes follow."""

RIGID = 3
"""Number of the frame's rigid motions."""


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
        Change of half the moment of inertia with the modes [kg^1/2 m], [-].
    g, G : ndarray, shapes (k,), (k, k)
        Angular momentum of the modes' motion, undeformed and by the modes [kg^1/2 m], [-].
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


class FrameMotion(NamedTuple):
    """Motion of a body frame and of the body in it.

    Parameters
    ----------
    ax, ay : float
        Acceleration of A in the body frame [m/s2].
    alpha, w : float
        Angular acceleration [rad/s2] and velocity [rad/s] about +z.
    q, dq, ddq : ndarray, shape (k,)
        Modal coordinates [kg^1/2 m] and their derivatives in time.
    """

    ax: float
    ay: float
    alpha: float
    w: float
    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray


class FrameForce(NamedTuple):
    """Generalised force that a motion needs.

    Parameters
    ----------
    x, y : float
        Along the body frame's axes [N].
    moment : float
        About A, about +z [N m].
    modal : ndarray, shape (k,)
        [kg^-1/2 N]
    """

    x: float
    y: float
    moment: float
    modal: np.ndarray


class Arrow(NamedTuple):
    """Tangent whose modes couple to the rigid motions and to themselves.

    Coupling of modes among each other is omitted.

    Parameters
    ----------
    top : ndarray, shape (m, m + k)
        Rows of the m rigid motions.
    left : ndarray, shape (k, m)
        Their columns, in the rows of the modes.
    diagonal : ndarray, shape (k,)
        Each mode to itself.
    """

    top: Matrix
    left: Matrix
    diagonal: Vector


@compiled
def _times(start, matrix, q):
    """Return start + matrix q."""
    out = matrix @ q
    for k in range(len(out)):
        out[k] += start[k]
    return out


@compiled
def frame_force(body: FlexibleBody, motion: FrameMotion) -> FrameForce:
    """Compute the generalised force that a motion needs.

    Its members are forces along the body frame's x and y, the moment about A, and the force on each
    mode.

    Eq. (D1):  m a + alpha Z s - w^2 s + 2 w Z T q' + T q''                       s = S + T q
    Eq. (D2):  (Z s) . a + alpha (I0 + 2 b.q + q.B q) + 2 w (b + B q).q' + (g + G q).q''
    Eq. (D3):  T^T a + alpha (g + G q) - w^2 (b + B q) + 2 w G q' + q'' + D q' + Omega^2 q
               Z = [0, -1; 1, 0]

    Small deformations (linear elasticity in the frame, no geometric stiffening): valid while w is
    far below the body's lowest eigenfrequency. No gravity.

    Parameters
    ----------
    body : FlexibleBody
    motion : FrameMotion

    Returns
    -------
    FrameForce

    References
    ----------
    [Shabana2013] ch. 5. Checked against a differentiated Lagrangian in
    tests/mfbd/test_floating_frame.py.
    """
    ax = motion.ax
    ay = motion.ay
    alpha = motion.alpha
    w = motion.w
    q = motion.q
    dq = motion.dq
    ddq = motion.ddq
    gq = _times(body.g, body.G, q)
    bq = _times(body.b, body.B, q)
    coriolis = body.G @ dq
    sx = body.S[X] + body.T[X] @ q
    sy = body.S[Y] + body.T[Y] @ q
    tx = 2 * w * (body.T[X] @ dq)
    ty = 2 * w * (body.T[Y] @ dq)
    # Eq. (D1)
    x = body.mass * ax - alpha * sy - w * w * sx - ty + body.T[X] @ ddq
    y = body.mass * ay + alpha * sx - w * w * sy + tx + body.T[Y] @ ddq
    # Eq. (D2)
    inertia = body.I0 + body.b @ q + bq @ q
    moment = -sy * ax + sx * ay + alpha * inertia + 2 * w * (bq @ dq) + gq @ ddq
    modal = np.empty(len(q))
    for i in range(len(q)):
        # Eq. (D3)
        modal[i] = (
            body.T[X, i] * ax
            + body.T[Y, i] * ay
            + alpha * gq[i]
            - w * w * bq[i]
            + 2 * w * coriolis[i]
            + ddq[i]
            + body.damping[i] * dq[i]
            + body.stiffness[i] * q[i]
        )
    return FrameForce(x, y, moment, modal)


@compiled
def frame_arrow(body: FlexibleBody, motion: FrameMotion, c1: float, c2: float) -> Arrow:
    """Compute the derivative of `frame_force` with the coefficients of the time integrator.

    `mode_coupling` is omitted.

    Columns: a along the body's x and y (held in that frame), then the angle and the modal
    coordinates, each with its acceleration changed by 1, its velocity by c1 and itself by c2.

    Parameters
    ----------
    body : FlexibleBody
    motion : FrameMotion
    c1, c2 : float
        `Coefficients.to_velocity` [s], `Coefficients.to_position` [s2].

    Returns
    -------
    Arrow
        Of three rigid motions.
    """
    ax = motion.ax
    ay = motion.ay
    alpha = motion.alpha
    w = motion.w
    q = motion.q
    k = len(q)
    gq = _times(body.g, body.G, q)
    bq = _times(body.b, body.B, q)
    gv = body.G @ motion.dq
    bv = body.B @ motion.dq
    ga = body.G @ motion.ddq
    sx = body.S[X] + body.T[X] @ q
    sy = body.S[Y] + body.T[Y] @ q
    tx = body.T[X] @ motion.dq
    ty = body.T[Y] @ motion.dq

    top = np.empty((RIGID, RIGID + k))
    top[X, X] = body.mass
    top[Y, Y] = body.mass
    top[X, Y] = 0.0
    top[Y, X] = 0.0
    top[TURN, X] = -sy
    top[TURN, Y] = sx
    top[X, TURN] = -sy - 2 * c1 * (w * sx + ty)
    top[Y, TURN] = sx - 2 * c1 * (w * sy - tx)
    top[TURN, TURN] = body.I0 + body.b @ q + bq @ q + 2 * c1 * (bq @ motion.dq)

    left = np.empty((k, RIGID))
    diagonal = np.empty(k)
    for i in range(k):
        x = body.T[X, i]
        y = body.T[Y, i]
        left[i, X] = x
        left[i, Y] = y
        left[i, TURN] = gq[i] + 2 * c1 * (gv[i] - w * bq[i])
        top[X, RIGID + i] = x * (1 - c2 * w * w) - y * (alpha * c2 + 2 * w * c1)
        top[Y, RIGID + i] = y * (1 - c2 * w * w) + x * (alpha * c2 + 2 * w * c1)
        top[TURN, RIGID + i] = (
            gq[i]
            + c2 * (x * ay - y * ax)
            + 2 * c1 * w * bq[i]
            + c2 * (2 * alpha * bq[i] + 2 * w * bv[i] - ga[i])
        )
        diagonal[i] = 1 + c1 * body.damping[i] + c2 * body.stiffness[i]
    return Arrow(top, left, diagonal)


@compiled
def mode_coupling(body: FlexibleBody, alpha: float, w: float, c1: float, c2: float) -> np.ndarray:
    """Compute the part that `frame_arrow` omits: Coriolis, Euler and centrifugal coupling of modes.

    Eq. (D4):  (2 w c1 + alpha c2) G - w^2 c2 B

    Parameters
    ----------
    body : FlexibleBody
    alpha, w : float
        Angular acceleration [rad/s2] and velocity [rad/s].
    c1, c2 : float
        [s], [s2]

    Returns
    -------
    ndarray, shape (k, k)
        [-], about 2 w c1: 1e-4 for a rocking piston.
    """
    out = np.empty(body.G.shape)
    turn = 2 * w * c1 + alpha * c2
    spin = w * w * c2
    for i in range(len(out)):
        for j in range(len(out)):
            out[i, j] = turn * body.G[i, j] - spin * body.B[i, j]  # Eq. (D4)
    return out


def whole(arrow: Arrow, coupling: np.ndarray) -> np.ndarray:
    """Return the tangent as one matrix, (m + k, m + k)."""
    return np.vstack([arrow.top, np.hstack([arrow.left, np.diag(arrow.diagonal) + coupling])])
