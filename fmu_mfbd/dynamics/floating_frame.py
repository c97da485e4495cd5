"""Planar motion of a flexible body in a frame that rides on its point A: inertia and elastic forces
and their exact tangent.

References ---------- [Shabana2013] A. A. Shabana, Dynamics of Multibody Systems, 4th ed., Cambridge
University Press, 2013.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compiled


class FlexibleBody(NamedTuple):
    """Inertia integrals (Eq. (J7)) and modal springs of a reduced body; k modes, mass-orthonormal.
    k = 0 is a rigid body.

    Parameters
    ----------
    mass : float
        [kg]
    S : ndarray, shape (2,)
        First moment about A [kg m].
    I0 : float
        Moment of inertia about A, about the axis z [kg m2].
    T, b, B, g, G : ndarray, shapes (2, k), (k,), (k, k), (k,), (k, k)
    stiffness : ndarray, shape (k,)
        omega^2 [rad2/s2].
    damping : ndarray, shape (k,)
        2 zeta omega [rad/s].
    """

    mass: float
    S: np.ndarray
    I0: float
    T: np.ndarray
    b: np.ndarray
    B: np.ndarray
    g: np.ndarray
    G: np.ndarray
    stiffness: np.ndarray
    damping: np.ndarray


def rigid_body(mass, centre, inertia):
    """Rigid body of given mass [kg], centre of mass (x, y) from A [m] and moment of inertia about A
    [kg m2].
    """
    none, square = np.zeros(0), np.zeros((0, 0))
    return FlexibleBody(
        float(mass),
        mass * np.asarray(centre, dtype=float),
        float(inertia),
        np.zeros((2, 0)),
        none,
        square,
        none,
        square,
        none,
        none,
    )


@compiled
def _times(start, matrix, q):
    """start + matrix q."""
    out = matrix @ q
    for k in range(len(out)):
        out[k] += start[k]
    return out


@compiled
def frame_force(body, ax, ay, alpha, w, q, rate, acceleration):
    """Generalised force that a given motion needs: rows along the body frame's x and y, about A,
    then one a mode.

    Eq. (R1):  m a + alpha Z s - w^2 s + 2 w Z T q' + T q''                                             s = S + T q
    Eq. (R2):  (Z s) . a + alpha (I0 + 2 b.q + q.B q) + 2 w (b + B q).q' + (g + G q).q''
    Eq. (R3):  T^T a + alpha (g + G q) - w^2 (b + B q) + 2 w G q' + q'' + D q' + Omega^2 q

    Small deformations (linear elasticity in the frame, no geometric stiffening): valid while w is
    far below the body's lowest eigenfrequency. No gravity.

    Parameters
    ----------
    body : FlexibleBody
    ax, ay : float
        Acceleration of A in the body frame [m/s2].
    alpha, w : float
        Angular acceleration [rad/s2] and velocity [rad/s] about +z.
    q, rate, acceleration : ndarray, shape (k,)
        Modal coordinates [kg^1/2 m] and their derivatives in time.

    Returns
    -------
    ndarray, shape (3 + k,)
        [N], [N], [N m], [kg^-1/2 N].

    References ---------- [Shabana2013] ch. 5. Checked against a differentiated Lagrangian in
    tests/mfbd/test_floating_frame.py.
    """
    out = np.empty(3 + len(q))
    gq, bq, gr = _times(body.g, body.G, q), _times(body.b, body.B, q), body.G @ rate
    sx, sy = body.S[0] + body.T[0] @ q, body.S[1] + body.T[1] @ q
    tx, ty = 2 * w * (body.T[0] @ rate), 2 * w * (body.T[1] @ rate)
    out[0] = body.mass * ax - alpha * sy - w * w * sx - ty + body.T[0] @ acceleration  # Eq. (R1)
    out[1] = body.mass * ay + alpha * sx - w * w * sy + tx + body.T[1] @ acceleration
    inertia = body.I0 + body.b @ q + bq @ q
    out[2] = (
        -sy * ax + sx * ay + alpha * inertia + 2 * w * (bq @ rate) + gq @ acceleration
    )  # Eq. (R2)
    for i in range(len(q)):  # Eq. (R3)
        out[3 + i] = (
            body.T[0, i] * ax
            + body.T[1, i] * ay
            + alpha * gq[i]
            - w * w * bq[i]
            + 2 * w * gr[i]
            + acceleration[i]
            + body.damping[i] * rate[i]
            + body.stiffness[i] * q[i]
        )
    return out


class Arrow(NamedTuple):
    """A tangent whose modes couple to the rigid motions and to themselves: what is left out couples
    modes among each other.

    Parameters
    ----------
    top : ndarray, shape (m, m + k)
        Rows of the m rigid motions.
    left : ndarray, shape (k, m)
        Their columns, in the rows of the modes.
    diagonal : ndarray, shape (k,)
        Each mode to itself.
    """

    top: np.ndarray
    left: np.ndarray
    diagonal: np.ndarray


@compiled
def frame_arrow(body, ax, ay, alpha, w, q, rate, acceleration, c1, c2):
    """Derivative of `frame_force` with the time integrator's coefficients folded in, without
    `mode_coupling`.

    Columns: a along the body's x and y (held in that frame), then the angle and the modal
    coordinates, each with its acceleration changed by 1, its rate by c1 [s] and itself by c2 [s2].

    Parameters
    ----------
    body, ax, ay, alpha, w, q, rate, acceleration
        As for `frame_force`.
    c1, c2 : float
        [s], [s2]

    Returns
    -------
    Arrow
        Of three rigid motions.
    """
    k = len(q)
    top, left, diagonal = np.empty((3, 3 + k)), np.empty((k, 3)), np.empty(k)
    gq, bq, gr, br = (
        _times(body.g, body.G, q),
        _times(body.b, body.B, q),
        body.G @ rate,
        body.B @ rate,
    )
    ga, ba = body.G @ acceleration, bq @ rate
    sx, sy = body.S[0] + body.T[0] @ q, body.S[1] + body.T[1] @ q
    tx, ty = body.T[0] @ rate, body.T[1] @ rate
    top[0, 0] = top[1, 1] = body.mass
    top[0, 1] = top[1, 0] = 0.0
    top[2, 0] = -sy
    top[2, 1] = sx
    top[0, 2] = -sy - 2 * c1 * (w * sx + ty)
    top[1, 2] = sx - 2 * c1 * (w * sy - tx)
    top[2, 2] = body.I0 + body.b @ q + bq @ q + 2 * c1 * ba
    for i in range(k):
        x, y = body.T[0, i], body.T[1, i]
        left[i, 0] = x
        left[i, 1] = y
        left[i, 2] = gq[i] + 2 * c1 * (gr[i] - w * bq[i])
        top[0, 3 + i] = x * (1 - c2 * w * w) - y * (alpha * c2 + 2 * w * c1)
        top[1, 3 + i] = y * (1 - c2 * w * w) + x * (alpha * c2 + 2 * w * c1)
        top[2, 3 + i] = (
            gq[i]
            + c2 * (x * ay - y * ax)
            + 2 * c1 * w * bq[i]
            + c2 * (2 * alpha * bq[i] + 2 * w * br[i] - ga[i])
        )
        diagonal[i] = 1 + c1 * body.damping[i] + c2 * body.stiffness[i]
    return Arrow(top, left, diagonal)


@compiled
def mode_coupling(body, alpha, w, c1, c2):
    """What `frame_arrow` leaves out: Coriolis, Euler and centrifugal coupling of modes.

    Eq. (R4):  (2 w c1 + alpha c2) G - w^2 c2 B

    Parameters
    ----------
    body, alpha, w, c1, c2
        As for `frame_arrow`.

    Returns
    -------
    ndarray, shape (k, k)
        [-], about 2 w c1: 1e-4 for a rocking piston.
    """
    out, turn, spin = np.empty(body.G.shape), 2 * w * c1 + alpha * c2, w * w * c2
    for i in range(len(out)):
        for j in range(len(out)):
            out[i, j] = turn * body.G[i, j] - spin * body.B[i, j]  # Eq. (R4)
    return out


def whole(arrow, coupling):
    """The tangent as one matrix, (m + k, m + k)."""
    return np.vstack([arrow.top, np.hstack([arrow.left, np.diag(arrow.diagonal) + coupling])])
