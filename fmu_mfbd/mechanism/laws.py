"""Forces of elements that depend on the motion of two bodies, and their derivative.

Callers skip them if a chain has none, because a call with a chain counts references to all arrays.
"""

from collections import namedtuple
from typing import Any, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable, packed
from ..force_elements import FORCE_ELEMENTS
from ..force_elements.element import PointForce, PointMotion
from .chain import BLOCK, Chain, Elements, Loads
from .equations import point_of
from .floating_frame import TURN, X, Y
from .motion import ChainMotion, MotionChanges

RATES = 3
"""Position of the first rate in a `PointMotion`."""


def _choice(member: str, motions: str) -> Any:
    """Return the kernel of all elements' `force` or `change`, (kind, numbers, *motions)."""
    scope: dict[str, Any] = {"NOTHING": PointForce(0.0, 0.0, 0.0)}
    lines = [f"def {member}(kind, numbers, {motions}):"]
    for k, one in enumerate(FORCE_ELEMENTS):
        _, scope[f"read_{k}"] = packed(namedtuple(one.parameters.__name__, one.names()))
        scope[f"of_{k}"] = getattr(one, member)
        lines += [f"    if kind == {k}:", f"        return of_{k}(read_{k}(numbers), {motions})"]
    exec("\n".join([*lines, "    return NOTHING"]), scope)
    return compilable(scope[member])


force_of = _choice("force", "at")
change_of = _choice("change", "at, by")


class RelativeMotion(NamedTuple):
    """Motion of an element's point relative to the body that it reacts on, in the block's axes.

    Parameters
    ----------
    arm_x, arm_y, x, y : float
        Position from the origins of both bodies [m].
    vx, vy : float
        Velocity relative to the material of the second body [m/s].
    """

    arm_x: float
    arm_y: float
    x: float
    y: float
    vx: float
    vy: float


@compilable
def relative_motion(elements: Elements, at: ChainMotion, e: int) -> RelativeMotion:
    """Return the motion of the point of element e."""
    body, other = elements.acts[e], elements.reacts[e]
    x, y = point_of(elements, at, e)
    arm_x, arm_y = x - at.position[body, X], y - at.position[body, Y]
    w = at.velocity[body, TURN]
    vx, vy = at.velocity[body, X] - w * arm_y, at.velocity[body, Y] + w * arm_x
    if other >= 0:
        x, y = x - at.position[other, X], y - at.position[other, Y]
        w = at.velocity[other, TURN]
        vx, vy = vx - at.velocity[other, X] + w * y, vy - at.velocity[other, Y] - w * x
    return RelativeMotion(arm_x=arm_x, arm_y=arm_y, x=x, y=y, vx=vx, vy=vy)


@compilable
def add_laws(chain: Chain, at: ChainMotion, crank_angle: float, loads: Loads) -> None:
    """Write the forces of elements that depend on the motion, and their slopes, into loads.

    Eq. (D67):  F = R f(R^T r - r_0, R^T v, chi, chi'),   v = V - V_R - w_R Z r
                R the axes of the body of the reaction, r, v the point from it, chi its angle in it

    Parameters
    ----------
    chain : Chain
    at : ChainMotion
    crank_angle : float
        [rad]
    loads : Loads
        `wrench` and `law_slopes` of these elements are overwritten.
    """
    elements, laws = chain.elements, chain.laws
    first = len(elements.acts) - len(laws.kind)
    for k in range(len(laws.kind)):
        e = first + k
        a, other = elements.acts[e], elements.reacts[e]
        c, s = 1.0, 0.0
        spin = at.velocity[a, TURN]
        if other >= 0:
            c, s = at.axes[other, 0], at.axes[other, 1]
            spin -= at.velocity[other, TURN]
        own = relative_motion(elements, at, e)
        cosine, sine = at.axes[a, 0], at.axes[a, 1]
        # Eq. (D67)
        motion = PointMotion(
            x=c * own.x + s * own.y - laws.zero[k, X],
            y=c * own.y - s * own.x - laws.zero[k, Y],
            angle=np.arctan2(sine * c - cosine * s, cosine * c + sine * s),
            vx=c * own.vx + s * own.vy,
            vy=c * own.vy - s * own.vx,
            spin=spin,
            crank_angle=crank_angle,
        )
        force = force_of(laws.kind[k], laws.numbers[k], motion)
        loads.wrench[e, X], loads.wrench[e, Y] = (
            c * force.x - s * force.y,
            s * force.x + c * force.y,
        )
        loads.wrench[e, TURN], loads.wrench[e, RATES] = force.moment, -force.moment
        _put_slopes(laws, k, motion, (c, s), loads.law_slopes[k])


@compilable
def _put_slopes(laws, k, motion, axes, slopes):
    """Write the slopes of law k by position, angle and their rates, all in the block's axes."""
    c, s = axes
    for j in range(2 * RATES):
        x, y, turn = 0.0, 0.0, 0.0
        if j % RATES == X:
            x, y = c, -s
        elif j % RATES == Y:
            x, y = s, c
        else:
            turn = 1.0
        by = PointMotion(x=x, y=y, angle=turn, vx=0.0, vy=0.0, spin=0.0, crank_angle=0.0)
        if j >= RATES:
            by = PointMotion(x=0.0, y=0.0, angle=0.0, vx=x, vy=y, spin=turn, crank_angle=0.0)
        change = change_of(laws.kind[k], laws.numbers[k], motion, by)
        slopes[X, j] = c * change.x - s * change.y
        slopes[Y, j] = s * change.x + c * change.y
        slopes[TURN, j] = change.moment


@compilable
def subtract_law_changes(
    chain: Chain, loads: Loads, at: ChainMotion, d: MotionChanges, change: np.ndarray
) -> None:
    """Subtract the change of forces by the slopes of their laws from that of all bodies.

    Forces that turn with a body are part of `derivative.chain_derivative`, also for laws.

    Eq. (D68):  dF = K (du, dchi) + C (dv, dchi'),   du = dr - t_R Z r,   dv = dv_S - t_R Z v
                dr, dv_S with resting axes, t_R the turn of the body of the reaction
    """
    elements = chain.elements
    first = len(elements.acts) - len(loads.law_slopes)
    by = np.zeros(2 * RATES)
    for k in range(len(loads.law_slopes)):
        e = first + k
        a, other = elements.acts[e], elements.reacts[e]
        own = relative_motion(elements, at, e)
        for j in range(d.position.shape[2]):
            _relative_change(elements, at, own, d, e, j, by)
            force = loads.law_slopes[k] @ by  # Eq. (D68)
            change[a, X, j] -= force[X]
            change[a, Y, j] -= force[Y]
            change[a, TURN, j] -= force[TURN] + own.arm_x * force[Y] - own.arm_y * force[X]
            if other >= 0:
                change[other, X, j] += force[X]
                change[other, Y, j] += force[Y]
                change[other, TURN, j] += force[TURN] + own.x * force[Y] - own.y * force[X]


@compilable
def _relative_change(elements, at, own, d, e, j, by):
    """Write the change of the motion of a point with unknown j, (6,), as `_put_slopes` has it."""
    a, other = elements.acts[e], elements.reacts[e]
    t, dw, w = d.position[a, TURN, j], d.velocity[a, TURN, j], at.velocity[a, TURN]
    dx, dy = d.position[a, X, j] - t * own.arm_y, d.position[a, Y, j] + t * own.arm_x
    vx = d.velocity[a, X, j] - dw * own.arm_y - w * t * own.arm_x
    vy = d.velocity[a, Y, j] + dw * own.arm_x - w * t * own.arm_y
    if other >= 0:
        turn, spin = d.position[other, TURN, j], d.velocity[other, TURN, j]
        rate = at.velocity[other, TURN]
        dx, dy = dx - d.position[other, X, j], dy - d.position[other, Y, j]
        vx += spin * own.y + rate * dy - d.velocity[other, X, j] + turn * own.vy
        vy -= spin * own.x + rate * dx + d.velocity[other, Y, j] + turn * own.vx
        dx, dy = dx + turn * own.y, dy - turn * own.x
        t, dw = t - turn, dw - spin
    by[X], by[Y], by[TURN] = dx, dy, t
    by[RATES + X], by[RATES + Y], by[RATES + TURN] = vx, vy, dw


@compilable
def from_block(chain: Chain, loads: Loads) -> np.ndarray:
    """Return the sum of the forces of laws whose reaction acts on the block, (2,) [N]."""
    out = np.zeros(2)
    for body in range(len(chain.bodies.mass)):
        force = between(chain, loads, body, BLOCK)
        out[X] += force[X]
        out[Y] += force[Y]
    return out


@compilable
def between(chain: Chain, loads: Loads, body: int, other: int) -> np.ndarray:
    """Return the sum of the forces of laws on a body from another one, (2,) [N]."""
    elements, out = chain.elements, np.zeros(2)
    for e in range(len(elements.acts) - len(chain.laws.kind), len(elements.acts)):
        sign = 0.0
        if elements.acts[e] == body and elements.reacts[e] == other:
            sign = 1.0
        elif elements.acts[e] == other and elements.reacts[e] == body:
            sign = -1.0
        out[X] += sign * loads.wrench[e, X]
        out[Y] += sign * loads.wrench[e, Y]
    return out


@compilable
def from_block_changes(
    elements: Elements, law_slopes: np.ndarray, at: ChainMotion, d: MotionChanges
) -> np.ndarray:
    """Return the change of `from_block` with a change of the motion of all bodies, (2,) [N].

    `law_slopes` are those of `Loads` in the motion `at`.
    """
    out, by = np.zeros(2), np.zeros(2 * RATES)
    first = len(elements.acts) - len(law_slopes)
    for k in range(len(law_slopes)):
        if elements.reacts[first + k] < 0:
            own = relative_motion(elements, at, first + k)
            _relative_change(elements, at, own, d, first + k, 0, by)
            force = law_slopes[k] @ by
            out[X] += force[X]
            out[Y] += force[Y]
    return out


@compilable
def law_power(chain: Chain, at: ChainMotion, loads: Loads) -> float:
    """Return the power of all elements that depend on the motion, on the bodies and the block [W].

    Eq. (D69):  P = F . v + M chi'      v, chi' as in Eq. (D67)
    """
    elements = chain.elements
    power = 0.0
    for e in range(len(elements.acts) - len(chain.laws.kind), len(elements.acts)):
        own, spin = relative_motion(elements, at, e), at.velocity[elements.acts[e], TURN]
        if elements.reacts[e] >= 0:
            spin -= at.velocity[elements.reacts[e], TURN]
        wrench = loads.wrench[e]
        power += wrench[X] * own.vx + wrench[Y] * own.vy + wrench[TURN] * spin  # Eq. (D69)
    return power


@compilable
def law_sizes(chain: Chain, at: ChainMotion, loads: Loads, k: int) -> np.ndarray:
    """Return the sums of the sizes of all terms of the force of law k, (3,).

    Positions and velocities of bodies are sums themselves, so that a stiff law amplifies their
    round-off.
    """
    e = len(chain.elements.acts) - len(loads.law_slopes) + k
    a = chain.elements.acts[e]
    x, y = point_of(chain.elements, at, e)
    sizes, out = np.zeros(2 * RATES), np.zeros(RATES)
    sizes[X], sizes[Y], sizes[TURN] = abs(x), abs(y), 1.0
    sizes[RATES + X], sizes[RATES + Y] = abs(at.velocity[a, X]), abs(at.velocity[a, Y])
    for i in range(RATES):
        out[i] = abs(loads.wrench[e, i])
        for j in range(2 * RATES):
            out[i] += abs(loads.law_slopes[k, i, j]) * sizes[j]
    return out
