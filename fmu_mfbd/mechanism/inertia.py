"""Inertia and elastic forces of the bodies of a chain, and their derivative."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..dynamics.carrier import Carrier, transport
from ..dynamics.floating_frame import TURN, X, Y
from ..dynamics.generalised_alpha import Motion
from .chain import Chain
from .motion import ChainMotion, Increments, MotionChanges

BQ, GQ, GV = range(3)
"""Rows of `InertiaForces.fields`."""


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
    """Forces that the motion of n bodies with k modes needs, and what their derivative shares.

    Parameters
    ----------
    wrench : ndarray, shape (n, 3)
        Force in the block's axes [N], moment about the body's origin [N m].
    modal : ndarray, shape (k,)
        [kg^-1/2 N]
    frames : ndarray, shape (n, 10)
        A `FrameState` of each body.
    fields : ndarray, shape (3, k)
        b + B q and g + G q [kg^1/2 m], G q' [kg^1/2 m/s].
    carrier : Carrier
        Motion of the block.
    """

    wrench: np.ndarray
    modal: np.ndarray
    frames: np.ndarray
    fields: np.ndarray
    carrier: Carrier


class InertiaChanges(NamedTuple):
    """Derivative of `InertiaForces` by m + k unknowns.

    Parameters
    ----------
    wrench : ndarray, shape (n, 3, m + k)
    left : ndarray, shape (k, m)
        Of the forces on modes by the unknowns of joints and block.
    diagonal : ndarray, shape (k,)
        Of the force on each mode by its own unknown.
    """

    wrench: np.ndarray
    left: np.ndarray
    diagonal: np.ndarray


@compilable
def block_motion(chain: Chain, now: Motion, given: Carrier) -> Carrier:
    """Return the motion of the block, `given` unless it has coordinates."""
    k = chain.block
    if k < 0:
        return given
    a = now.acceleration
    return Carrier(a[k], a[k + 1], a[k + 2], now.velocity[k + 2])


@compilable
def frame_state(forces: InertiaForces, b: int) -> FrameState:
    """Return the state of the frame of body b."""
    f = forces.frames
    return FrameState(
        f[b, 0], f[b, 1], f[b, 2], f[b, 3], f[b, 4], f[b, 5], f[b, 6], f[b, 7], f[b, 8], f[b, 9]
    )


@compilable
def inertia_forces(chain: Chain, at: ChainMotion, now: Motion, given: Carrier) -> InertiaForces:
    """Compute the forces that the motion of all bodies needs.

    Eqs. (D1) to (D3) of each body, at the acceleration of its origin in space (Eq. (K14)).

    Parameters
    ----------
    chain : Chain
    at : ChainMotion
    now : Motion
    given : Carrier
        Motion of a block without coordinates.

    Returns
    -------
    InertiaForces
    """
    bodies = chain.bodies
    n, k = len(bodies.mass), len(bodies.stiffness)
    carrier = block_motion(chain, now, given)
    out = InertiaForces(np.empty((n, 3)), np.empty(k), np.empty((n, 10)), np.empty((3, k)), carrier)
    first = len(now.position) - k
    for b in range(n):
        _modal_fields(bodies, b, first, now, out.fields)
        frame = _frame_of(bodies, b, first, at, carrier, now, out.fields)
        for i in range(10):
            out.frames[b, i] = frame[i]
        _needed(bodies, b, first, at, frame, now, out)
    return out


@compilable
def _modal_fields(bodies, b, first, now, fields):
    """Write the fields of body b."""
    begin, end = bodies.first_mode[b], bodies.first_mode[b + 1]
    k = end - begin
    if k == 0:
        return
    table = bodies.coupling[bodies.first_entry[b] : bodies.first_entry[b + 1]].reshape((2 * k, k))
    by_position = table @ now.position[first + begin : first + end]
    by_velocity = table[k:] @ now.velocity[first + begin : first + end]
    for i in range(k):
        fields[BQ, begin + i] = bodies.b[begin + i] + by_position[i]
        fields[GQ, begin + i] = bodies.g[begin + i] + by_position[k + i]
        fields[GV, begin + i] = by_velocity[i]


@compilable
def _frame_of(bodies, b, first, at, carrier, now, fields):
    """Return the state of the frame of body b."""
    x, y = transport(
        carrier, at.position[b, X], at.position[b, Y], at.velocity[b, X], at.velocity[b, Y]
    )
    x += at.acceleration[b, X]
    y += at.acceleration[b, Y]
    c, s = at.axes[b, 0], at.axes[b, 1]
    sx, sy, inertia = bodies.S[b, X], bodies.S[b, Y], bodies.I0[b]
    tx, ty, spin = 0.0, 0.0, 0.0
    for i in range(bodies.first_mode[b], bodies.first_mode[b + 1]):
        q, v = now.position[first + i], now.velocity[first + i]
        sx += bodies.T[X, i] * q
        sy += bodies.T[Y, i] * q
        tx += bodies.T[X, i] * v
        ty += bodies.T[Y, i] * v
        inertia += (bodies.b[i] + fields[BQ, i]) * q
        spin += fields[BQ, i] * v
    return FrameState(
        c * x + s * y,
        c * y - s * x,
        at.acceleration[b, TURN] + carrier.alpha,
        at.velocity[b, TURN] + carrier.w,
        sx,
        sy,
        tx,
        ty,
        inertia,
        spin,
    )


@compilable
def _needed(bodies, b, first, at, f, now, out):
    """Write the forces that body b needs."""
    w, w2 = f.w, f.w * f.w
    # Eqs. (D1), (D2)
    x = bodies.mass[b] * f.ax - f.alpha * f.sy - w2 * f.sx - 2 * w * f.ty
    y = bodies.mass[b] * f.ay + f.alpha * f.sx - w2 * f.sy + 2 * w * f.tx
    moment = f.sx * f.ay - f.sy * f.ax + f.alpha * f.inertia + 2 * w * f.spin
    for i in range(bodies.first_mode[b], bodies.first_mode[b + 1]):
        q, v, a = now.position[first + i], now.velocity[first + i], now.acceleration[first + i]
        x += bodies.T[X, i] * a
        y += bodies.T[Y, i] * a
        moment += out.fields[GQ, i] * a
        # Eq. (D3)
        out.modal[i] = (
            bodies.T[X, i] * f.ax
            + bodies.T[Y, i] * f.ay
            + f.alpha * out.fields[GQ, i]
            - w2 * out.fields[BQ, i]
            + 2 * w * out.fields[GV, i]
            + a
            + bodies.damping[i] * v
            + bodies.stiffness[i] * q
        )
    c, s = at.axes[b, 0], at.axes[b, 1]
    out.wrench[b, X] = c * x - s * y
    out.wrench[b, Y] = s * x + c * y
    out.wrench[b, TURN] = moment


@compilable
def inertia_changes(
    chain: Chain,
    at: ChainMotion,
    forces: InertiaForces,
    now: Motion,
    by: Increments,
    d: MotionChanges,
) -> InertiaChanges:
    """Compute the derivative of `inertia_forces`.

    Coriolis, Euler and centrifugal coupling of modes (Eq. (D4)) is omitted.

    Parameters
    ----------
    chain, at, now
        As for `inertia_forces`.
    forces : InertiaForces
    by : Increments
    d : MotionChanges

    Returns
    -------
    InertiaChanges
    """
    bodies = chain.bodies
    n, m = chain.joints.tip.shape
    k = len(bodies.stiffness)
    out = InertiaChanges(np.zeros((n, 3, m + k)), np.empty((k, m)), np.empty(k))
    frame_change = np.empty((4, m))
    for b in range(n):
        frame = frame_state(forces, b)
        _frame_changes(chain, b, at, frame, forces.carrier, by, d, frame_change)
        _by_joints(bodies, b, at, frame, forces, frame_change, d, out)
        _by_modes(bodies, b, m, at, frame, forces, now, by, out)
    return out


@compilable
def _frame_changes(chain, b, at, f, carrier, by, d, out):
    """Write the change of ax, ay, alpha and w of the frame of body b with the unknowns of joints.

    Eq. (K14), differentiated, and what the rotation of the axes adds.
    """
    c, s = at.axes[b, 0], at.axes[b, 1]
    w, alpha = carrier.w, carrier.alpha
    first = chain.block
    for j in range(out.shape[1]):
        px, py = d.position[b, X, j], d.position[b, Y, j]
        # Eq. (K14)
        x = d.acceleration[b, X, j] - alpha * py - w * w * px - 2 * w * d.velocity[b, Y, j]
        y = d.acceleration[b, Y, j] + alpha * px - w * w * py + 2 * w * d.velocity[b, X, j]
        turn, spin = d.acceleration[b, TURN, j], d.velocity[b, TURN, j]
        if first >= 0 and first <= j < first + 3:
            if j == first + TURN:
                dw, da = by.velocity[j], by.acceleration[j]
                x -= da * at.position[b, Y] + 2 * dw * (w * at.position[b, X] + at.velocity[b, Y])
                y += da * at.position[b, X] - 2 * dw * (w * at.position[b, Y] - at.velocity[b, X])
                turn += da
                spin += dw
            elif j == first:
                x += by.acceleration[j]
            else:
                y += by.acceleration[j]
        t = d.position[b, TURN, j]
        out[X, j] = c * x + s * y + f.ay * t
        out[Y, j] = c * y - s * x - f.ax * t
        out[TURN, j] = turn
        out[3, j] = spin


@compilable
def _by_joints(bodies, b, at, f, forces, frame_change, d, out):
    """Write the change of the forces of body b with the unknowns of joints and block."""
    c, s = at.axes[b, 0], at.axes[b, 1]
    mass, w = bodies.mass[b], f.w
    force_x, force_y = forces.wrench[b, X], forces.wrench[b, Y]
    for j in range(frame_change.shape[1]):
        ax, ay = frame_change[X, j], frame_change[Y, j]
        alpha, dw = frame_change[TURN, j], frame_change[3, j]
        t = d.position[b, TURN, j]
        # Eqs. (D1), (D2)
        x = mass * ax - alpha * f.sy - 2 * dw * (w * f.sx + f.ty)
        y = mass * ay + alpha * f.sx - 2 * dw * (w * f.sy - f.tx)
        out.wrench[b, X, j] = c * x - s * y - force_y * t
        out.wrench[b, Y, j] = s * x + c * y + force_x * t
        out.wrench[b, TURN, j] = f.sx * ay - f.sy * ax + alpha * f.inertia + 2 * dw * f.spin
    for i in range(bodies.first_mode[b], bodies.first_mode[b + 1]):
        x, y, gq = bodies.T[X, i], bodies.T[Y, i], forces.fields[GQ, i]
        spun = 2 * (forces.fields[GV, i] - w * forces.fields[BQ, i])
        for j in range(frame_change.shape[1]):
            # Eq. (D3)
            by_frame = x * frame_change[X, j] + y * frame_change[Y, j]
            out.left[i, j] = by_frame + gq * frame_change[TURN, j] + spun * frame_change[3, j]


@compilable
def _by_modes(bodies, b, m, at, f, forces, now, by, out):
    """Write the change of the forces of body b with the unknowns of its modes."""
    begin, end = bodies.first_mode[b], bodies.first_mode[b + 1]
    k = end - begin
    if k == 0:
        return
    table = bodies.coupling[bodies.first_entry[b] : bodies.first_entry[b + 1]].reshape((2 * k, k))
    bv = table[:k] @ now.velocity[m + begin : m + end]
    ga = table[k:] @ now.acceleration[m + begin : m + end]
    c, s = at.axes[b, 0], at.axes[b, 1]
    for i in range(begin, end):
        j = m + i
        c0, c1, c2 = by.acceleration[j], by.velocity[j], by.position[j]
        x, y, bq = bodies.T[X, i], bodies.T[Y, i], forces.fields[BQ, i]
        along, across = c0 - c2 * f.w * f.w, c2 * f.alpha + 2 * c1 * f.w
        # Eqs. (D1), (D2)
        fx, fy = along * x - across * y, along * y + across * x
        moment = c2 * (x * f.ay - y * f.ax + 2 * f.alpha * bq + 2 * f.w * bv[i - begin])
        moment += c0 * forces.fields[GQ, i] + 2 * c1 * f.w * bq - c2 * ga[i - begin]
        out.wrench[b, X, j] = c * fx - s * fy
        out.wrench[b, Y, j] = s * fx + c * fy
        out.wrench[b, TURN, j] = moment
        # Eq. (D3)
        out.diagonal[i] = c0 + c1 * bodies.damping[i] + c2 * bodies.stiffness[i]
