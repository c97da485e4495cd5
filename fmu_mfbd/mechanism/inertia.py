"""Inertia and elastic forces of the bodies of a chain, and their derivative.

References
----------
[Shabana2013] A. A. Shabana, Dynamics of Multibody Systems, 4th ed., Cambridge University Press,
2013.
"""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, numbered
from ..geometry.arrays import Matrix, Vector
from .carrier import FIXED, BlockMotion, transport
from .chain import Bodies
from .floating_frame import TURN, X, Y
from .generalised_alpha import Motion
from .motion import ChainMotion, Increments, MotionChanges

ROW = numbered("ax", "ay", "alpha", "w", "sx", "sy", "tx", "ty", "inertia", "spin")
"""Places in a row of `InertiaForces.frames`."""
MODE = numbered("push", "bq", "gq", "gv")
"""Rows of the tables of modes in `InertiaForces`."""


class FrameState(NamedTuple):
    """Motion of a body's frame in space, in its own axes, and its moments of mass.

    Parameters
    ----------
    ax, ay, alpha, w : float
        Acceleration of the origin [m/s2], angular acceleration and velocity [rad/s2], [rad/s].
    sx, sy, tx, ty : float
        First moment [kg m] and its rate with the modes [kg m/s].
    inertia : float
        About the origin [kg m2].
    spin : float
        Half of its rate with the modes [kg m2/s].
    """

    ax: float
    ay: float
    alpha: float
    w: float
    sx: float
    sy: float
    tx: float
    ty: float
    inertia: float
    spin: float


class InertiaForces(NamedTuple):
    """Forces that the motion of n bodies with k + s modes needs, and what their derivative shares.

    Parameters
    ----------
    wrench : ndarray, shape (n, 3)
        Force in the block's axes [N], moment about the body's origin [N m].
    modal : ndarray, shape (k + s,)
        [kg^-1/2 N]
    frames : ndarray, shape (n, 10)
        A `FrameState` of each body.
    bq, gq, gv : ndarray, shape (k + s,)
        b + B q and g + G q [kg^1/2 m], G q' [kg^1/2 m/s].
    carrier : BlockMotion
        Motion of the block.
    """

    wrench: Matrix
    modal: Vector
    frames: Matrix
    bq: Vector
    gq: Vector
    gv: Vector
    carrier: BlockMotion


class InertiaChanges(NamedTuple):
    """Derivative of `InertiaForces` by m + k unknowns.

    Parameters
    ----------
    wrench : ndarray, shape (n, 3, m + k)
    left : ndarray, shape (k, m)
        Derivative of the forces on modes by the unknowns of joints and block.
    diagonal : ndarray, shape (k,)
        Derivative of the force on each mode by its own unknown.
    """

    wrench: np.ndarray
    left: np.ndarray
    diagonal: np.ndarray


@compilable
def frame_state(frames: np.ndarray, b: int) -> FrameState:
    """Return the state of the frame of body b."""
    f = frames[b]
    return FrameState(
        ax=f[ROW.ax],
        ay=f[ROW.ay],
        alpha=f[ROW.alpha],
        w=f[ROW.w],
        sx=f[ROW.sx],
        sy=f[ROW.sy],
        tx=f[ROW.tx],
        ty=f[ROW.ty],
        inertia=f[ROW.inertia],
        spin=f[ROW.spin],
    )


@compilable
def inertia_forces(
    bodies: Bodies, at: ChainMotion, now: Motion, carrier: BlockMotion, m: int
) -> InertiaForces:
    """Compute the forces that the motion of all bodies needs.

    They are the force of each body along the axes of its frame, the moment about its origin, and
    the forces on its modes. a is the acceleration of the origin in space, Eq. (K14).

    Eq. (D1):  m a + alpha Z s - w^2 s + 2 w Z T q' + T q''                       s = S + T q
    Eq. (D2):  (Z s) . a + alpha (I0 + 2 b.q + q.B q) + 2 w (b + B q).q' + (g + G q).q''
    Eq. (D3):  T^T a + alpha (g + G q) - w^2 (b + B q) + 2 w G q' + q'' + D q' + Omega^2 q
               Z = [0, -1; 1, 0]

    Deformations are small and linear in the frame, without geometric stiffening. This is valid if w
    is far below the lowest eigenfrequency of the body. There is no gravity.

    Eq. (D40):  q'' + D q' + omega^2 q      of modes with the inertia of their own motion alone
    Eq. (D6):   omega^2 q + T^T a + alpha g - w^2 b      if these modes deflect the last body

    Eq. (D6) is Eq. (D3) without the motion of the mode, which does not act on the frame. It is
    valid for loads far slower than the modes. Its relative error is about the square of the ratio
    of both frequencies.

    Parameters
    ----------
    bodies : Bodies
    at : ChainMotion
    now : Motion
        Motion in all coordinates, of which the first m are not modal.
    carrier : BlockMotion
        Motion of the block.
    m : int

    Returns
    -------
    InertiaForces

    References
    ----------
    [Shabana2013] ch. 5. Checked against a differentiated Lagrangian in
    tests/mfbd/test_floating_frame.py.
    """
    n, k = len(bodies.mass), len(bodies.stiffness)
    rows = np.empty((4, k))
    wrench, frames = np.empty((n, 3)), np.empty((n, 10))
    out = InertiaForces(
        wrench=wrench,
        modal=rows[MODE.push],
        frames=frames,
        bq=rows[MODE.bq],
        gq=rows[MODE.gq],
        gv=rows[MODE.gv],
        carrier=carrier,
    )
    _put_frames(bodies, at, now, m, out)
    _put_forces(bodies, at, now, m, out)
    return out


@compilable
def coupling_of(bodies: Bodies, b: int) -> np.ndarray:
    """Return B and below it G of the j modes of body b, (2 j, j)."""
    k = bodies.first_mode[b + 1] - bodies.first_mode[b]
    return bodies.coupling[bodies.first_entry[b] : bodies.first_entry[b + 1]].reshape((2 * k, k))


@compilable
def _put_frames(bodies, at, now, m, out):
    """Write the states of all frames, in the order of `FrameState`, with those of all modes."""
    carrier = out.carrier
    for b in range(len(bodies.mass)):
        x, y = at.position[b, X], at.position[b, Y]
        ax, ay = transport(carrier, x, y, at.velocity[b, X], at.velocity[b, Y])
        ax += at.acceleration[b, X]
        ay += at.acceleration[b, Y]
        c, s = at.axes[b, 0], at.axes[b, 1]
        frame = out.frames[b]
        frame[ROW.ax], frame[ROW.ay] = c * ax + s * ay, c * ay - s * ax
        frame[ROW.alpha] = at.acceleration[b, TURN] + carrier.alpha
        frame[ROW.w] = at.velocity[b, TURN] + carrier.w
        frame[ROW.sx], frame[ROW.sy] = bodies.S[b, X], bodies.S[b, Y]
        frame[ROW.inertia] = bodies.I0[b]
        frame[ROW.tx], frame[ROW.ty], frame[ROW.spin] = 0.0, 0.0, 0.0
        begin, end = bodies.first_mode[b], bodies.first_mode[b + 1]
        if end > begin:
            _add_modes(bodies, b, begin, end, now, m, frame, out)
    for i in range(bodies.first_mode[-1], len(bodies.b)):
        out.bq[i], out.gq[i], out.gv[i] = bodies.b[i], bodies.g[i], 0.0


@compilable
def _add_modes(bodies, b, begin, end, now, m, frame, out):
    """Write what the modes of body b share, and add them to the state of its frame."""
    k = end - begin
    q, v = now.position[m + begin : m + end], now.velocity[m + begin : m + end]
    table = coupling_of(bodies, b)
    by_position = table @ q
    by_velocity = table[k:] @ v
    by_x, by_y = bodies.T[X][begin:end], bodies.T[Y][begin:end]
    bq = out.bq[begin:end]
    for i in range(k):
        bq[i] = bodies.b[begin + i] + by_position[i]
        out.gq[begin + i] = bodies.g[begin + i] + by_position[k + i]
        out.gv[begin + i] = by_velocity[i]
    frame[ROW.sx] += by_x @ q
    frame[ROW.sy] += by_y @ q
    frame[ROW.tx] += by_x @ v
    frame[ROW.ty] += by_y @ v
    frame[ROW.inertia] += bodies.b[begin:end] @ q + bq @ q
    frame[ROW.spin] += bq @ v


@compilable
def _put_forces(bodies, at, now, m, out):
    """Write the forces that all bodies need."""
    for b in range(len(bodies.mass)):
        f = frame_state(out.frames, b)
        w, w2 = f.w, f.w * f.w
        # Eqs. (D1), (D2)
        x = bodies.mass[b] * f.ax - f.alpha * f.sy - w2 * f.sx - 2 * w * f.ty
        y = bodies.mass[b] * f.ay + f.alpha * f.sx - w2 * f.sy + 2 * w * f.tx
        moment = f.sx * f.ay - f.sy * f.ax + f.alpha * f.inertia + 2 * w * f.spin
        for i in range(bodies.first_mode[b], bodies.first_mode[b + 1]):
            a = now.acceleration[m + i]
            gq = out.gq[i]
            x += bodies.T[X, i] * a
            y += bodies.T[Y, i] * a
            moment += gq * a
            # Eq. (D3)
            push = bodies.T[X, i] * f.ax + bodies.T[Y, i] * f.ay + f.alpha * gq
            push += 2 * w * out.gv[i] - w2 * out.bq[i]
            spring = bodies.damping[i] * now.velocity[m + i]
            spring += bodies.stiffness[i] * now.position[m + i]
            out.modal[i] = push + a + spring
        c, s = at.axes[b, 0], at.axes[b, 1]
        out.wrench[b, X] = c * x - s * y
        out.wrench[b, Y] = s * x + c * y
        out.wrench[b, TURN] = moment
    for i in range(bodies.first_mode[-1], len(out.modal)):
        # Eq. (D40)
        spring = bodies.damping[i] * now.velocity[m + i] + bodies.stiffness[i] * now.position[m + i]
        out.modal[i] = now.acceleration[m + i] + spring
    f = frame_state(out.frames, len(bodies.mass) - 1)
    for i in range(bodies.first_mode[-1], len(bodies.b)):
        # Eq. (D6)
        out.modal[i] += bodies.T[X, i] * f.ax + bodies.T[Y, i] * f.ay
        out.modal[i] += f.alpha * bodies.g[i] - f.w * f.w * bodies.b[i]


@compilable
def inertia_changes(
    bodies: Bodies,
    at: ChainMotion,
    now: Motion,
    forces: InertiaForces,
    by: Increments,
    d: MotionChanges,
) -> InertiaChanges:
    """Compute the derivative of `inertia_forces`.

    Coriolis, Euler and centrifugal coupling of modes (Eq. (D4)) is omitted.

    Parameters
    ----------
    bodies, at, now
        As for `inertia_forces`.
    forces : InertiaForces
    by : Increments
    d : MotionChanges

    Returns
    -------
    InertiaChanges
    """
    n, _, m = d.position.shape
    k = len(bodies.stiffness)
    out = InertiaChanges(np.zeros((n, 3, m + k)), np.zeros((k, m)), np.empty(k))
    _put_joint_columns(bodies, at, forces, d, FIXED, out)
    _put_modal_columns(bodies, at, now, m, forces, by, out)
    return out


@compilable
def shaken_forces(
    bodies: Bodies, at: ChainMotion, forces: InertiaForces, d: MotionChanges, shaken: BlockMotion
) -> InertiaChanges:
    """Compute the derivative of `inertia_forces` in m directions of motion and of a block's motion.

    Parameters
    ----------
    bodies, at
        As for `inertia_forces`.
    forces : InertiaForces
    d : MotionChanges
    shaken : BlockMotion
        Change of the motion of the block in each of them.

    Returns
    -------
    InertiaChanges
        With zero shapes of what belongs to the unknowns of modes.
    """
    n, _, m = d.position.shape
    out = InertiaChanges(np.zeros((n, 3, m)), np.zeros((len(bodies.stiffness), m)), np.empty(0))
    _put_joint_columns(bodies, at, forces, d, shaken, out)
    return out


@compilable
def _frame_changes(at, forces, d, shaken):
    """Return the change of ax, ay, alpha and w of all frames with motion and that of the block."""
    w, alpha, da, dw = forces.carrier.w, forces.carrier.alpha, shaken.alpha, shaken.w
    n, _, m = d.position.shape
    out = np.empty((n, 4, m))
    for b in range(n):
        c, s = at.axes[b, 0], at.axes[b, 1]
        x, y, vx, vy = at.position[b, X], at.position[b, Y], at.velocity[b, X], at.velocity[b, Y]
        ax, ay = forces.frames[b, ROW.ax], forces.frames[b, ROW.ay]
        for j in range(m):
            # Eq. (K14)
            px, py = d.position[b, X, j], d.position[b, Y, j]
            dx = d.acceleration[b, X, j] - alpha * py - w * w * px - 2 * w * d.velocity[b, Y, j]
            dy = d.acceleration[b, Y, j] + alpha * px - w * w * py + 2 * w * d.velocity[b, X, j]
            dx += shaken.ax - da * y - 2 * dw * (w * x + vy)
            dy += shaken.ay + da * x - 2 * dw * (w * y - vx)
            t = d.position[b, TURN, j]  # the axes turn
            out[b, ROW.ax, j] = c * dx + s * dy + ay * t
            out[b, ROW.ay, j] = c * dy - s * dx - ax * t
            out[b, ROW.alpha, j] = d.acceleration[b, TURN, j] + da
            out[b, ROW.w, j] = d.velocity[b, TURN, j] + dw
    return out


@compilable
def _put_joint_columns(bodies, at, forces, d, shaken, out):
    """Write the change of all forces with the change of all frames."""
    frames = _frame_changes(at, forces, d, shaken)
    for b in range(len(frames)):
        f = frame_state(forces.frames, b)
        c, s = at.axes[b, 0], at.axes[b, 1]
        mass, w = bodies.mass[b], f.w
        force_x, force_y = forces.wrench[b, X], forces.wrench[b, Y]
        for j in range(frames.shape[2]):
            ax, ay = frames[b, ROW.ax, j], frames[b, ROW.ay, j]
            alpha, dw = frames[b, ROW.alpha, j], frames[b, ROW.w, j]
            t = d.position[b, TURN, j]
            # Eqs. (D1), (D2)
            x = mass * ax - alpha * f.sy - 2 * dw * (w * f.sx + f.ty)
            y = mass * ay + alpha * f.sx - 2 * dw * (w * f.sy - f.tx)
            out.wrench[b, X, j] = c * x - s * y - force_y * t
            out.wrench[b, Y, j] = s * x + c * y + force_x * t
            out.wrench[b, TURN, j] = f.sx * ay - f.sy * ax + alpha * f.inertia + 2 * dw * f.spin
        is_last = b == len(frames) - 1
        end = len(bodies.b) if is_last else bodies.first_mode[b + 1]
        for i in range(bodies.first_mode[b], end):
            x, y, gq = bodies.T[X, i], bodies.T[Y, i], forces.gq[i]
            spun = 2 * (forces.gv[i] - w * forces.bq[i])
            for j in range(frames.shape[2]):
                # Eq. (D3)
                by_frame = x * frames[b, ROW.ax, j] + y * frames[b, ROW.ay, j]
                out.left[i, j] = (
                    by_frame + gq * frames[b, ROW.alpha, j] + spun * frames[b, ROW.w, j]
                )


@compilable
def _put_modal_columns(bodies, at, now, m, forces, by, out):
    """Write the change of the forces of each body with the unknowns of its modes."""
    for b in range(len(bodies.mass)):
        begin, end = bodies.first_mode[b], bodies.first_mode[b + 1]
        k = end - begin
        if k == 0:
            continue
        f = frame_state(forces.frames, b)
        table = coupling_of(bodies, b)
        bv = table[:k] @ now.velocity[m + begin : m + end]
        ga = table[k:] @ now.acceleration[m + begin : m + end]
        c, s = at.axes[b, 0], at.axes[b, 1]
        for i in range(begin, end):
            j = m + i
            c0, c1, c2 = by.acceleration[j], by.velocity[j], by.position[j]
            x, y, bq = bodies.T[X, i], bodies.T[Y, i], forces.bq[i]
            along, across = c0 - c2 * f.w * f.w, c2 * f.alpha + 2 * c1 * f.w
            # Eqs. (D1), (D2)
            fx, fy = along * x - across * y, along * y + across * x
            moment = c2 * (x * f.ay - y * f.ax + 2 * f.alpha * bq + 2 * f.w * bv[i - begin])
            moment += c0 * forces.gq[i] + 2 * c1 * f.w * bq - c2 * ga[i - begin]
            out.wrench[b, X, j] = c * fx - s * fy
            out.wrench[b, Y, j] = s * fx + c * fy
            out.wrench[b, TURN, j] = moment
            # Eq. (D3)
            out.diagonal[i] = c0 + c1 * bodies.damping[i] + c2 * bodies.stiffness[i]
    for i in range(bodies.first_mode[-1], len(out.diagonal)):
        j = m + i
        # Eq. (D40)
        spring = by.velocity[j] * bodies.damping[i] + by.position[j] * bodies.stiffness[i]
        out.diagonal[i] = by.acceleration[j] + spring
