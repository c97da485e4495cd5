"""Loads of a chain from forces that are constant in the axes of a body, as those of films."""

from typing import NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from .chain import MOMENT, REACTION, Chain, Loads
from .equations import moment_of_shapes, point_of
from .floating_frame import X, Y
from .generalised_alpha import Motion
from .motion import ChainMotion


class AppliedForces(NamedTuple):
    """Forces of e elements, each in the axes with which it rotates.

    Parameters
    ----------
    force : ndarray, shape (e, 2)
        On the body that the element acts on [N].
    moment : ndarray, shape (e,)
        On this body about the point of the element, without slopes and shapes [N m].
    modal : ndarray, shape (k,)
        On all modes except shapes [kg^-1/2 N].
    slopes
        As of `Loads`.
    on_shapes : ndarray, shape (e, n, 2)
        [kg^-1/2 N]
    """

    force: np.ndarray
    moment: np.ndarray
    modal: np.ndarray
    slopes: np.ndarray
    on_shapes: np.ndarray


@compilable
def no_forces(chain: Chain) -> AppliedForces:
    """Return forces of zero."""
    n = len(chain.elements.acts)
    slopes, shapes = 0, 0
    for e in range(n):
        slopes += chain.elements.modes[e]
        shapes = max(shapes, chain.elements.shapes[e])
    modal = np.zeros(len(chain.bodies.stiffness))
    on_shapes = np.zeros((n, shapes, 2))
    return AppliedForces(np.zeros((n, 2)), np.zeros(n), modal, np.zeros(slopes), on_shapes)


@compilable
def no_loads(chain: Chain) -> Loads:
    """Return loads of zero."""
    none = no_forces(chain)
    wrench, laws = np.zeros((len(none.moment), 4)), np.zeros((len(chain.laws.kind), 3, 6))
    return Loads(wrench, none.modal, none.slopes, none.on_shapes, laws)


@compilable
def loads_at(chain: Chain, applied: AppliedForces, at: ChainMotion, now: Motion) -> Loads:
    """Return the loads in a motion, without those of laws. They are linear in the forces.

    Eq. (D65):  M = M_P + d x F + sum_i c_i q_i - sum_k s_k x Q_k,   M_R = -M_P - sum_i c_i q_i
                M_P the moment about the point P, d from the marker to P, c slopes by modes q
                s shapes of the body that the element acts on, Q the forces on them

    The play of an element is -d, which keeps the digits of a thin film.

    Parameters
    ----------
    chain : Chain
    applied : AppliedForces
    at : ChainMotion
    now : Motion

    Returns
    -------
    Loads
    """
    elements = chain.elements
    m = chain.joints.tip.shape[1]
    wrench, on_shapes = np.empty((len(elements.acts), 4)), np.empty(applied.on_shapes.shape)
    laws = np.zeros((len(chain.laws.kind), 3, 6))
    out = Loads(wrench, applied.modal.copy(), applied.slopes, on_shapes, laws)
    slope = 0
    for e in range(len(wrench)):
        c, s = 1.0, 0.0
        if elements.axes[e] >= 0:
            c, s = at.axes[elements.axes[e], 0], at.axes[elements.axes[e], 1]
        x = c * applied.force[e, X] - s * applied.force[e, Y]
        y = s * applied.force[e, X] + c * applied.force[e, Y]
        for k in range(elements.shapes[e]):
            fx, fy = applied.on_shapes[e, k, X], applied.on_shapes[e, k, Y]
            on_shapes[e, k, X], on_shapes[e, k, Y] = c * fx - s * fy, s * fx + c * fy
            for direction in range(2):
                j = elements.shape[e] + direction * elements.shapes[e] + k
                out.modal[j - m] += on_shapes[e, k, direction]
        moment = applied.moment[e]
        for j in range(elements.mode[e], elements.mode[e] + elements.modes[e]):
            moment += applied.slopes[slope] * now.position[j]
            slope += 1
        # Eq. (D65)
        first = elements.play[e]
        dx, dy = 0.0, 0.0
        if first >= 0:
            dx, dy = -now.position[first], -now.position[first + 1]
        elif elements.at_point[e] == 0.0:
            dx, dy = _to_point(elements, at, e)
        wrench[e, X], wrench[e, Y] = x, y
        wrench[e, MOMENT], wrench[e, REACTION] = moment + dx * y - dy * x, -moment
        if elements.shapes[e] > 0:
            wrench[e, MOMENT] -= moment_of_shapes(elements, out, now, e)
    return out


@compilable
def _to_point(elements, at, e):
    """Return the vector from the marker of element e to its point, in the block's axes [m]."""
    body = elements.acts[e]
    c, s = at.axes[body, 0], at.axes[body, 1]
    mx, my = elements.marker[e, X], elements.marker[e, Y]
    px, py = point_of(elements, at, e)
    return (
        px - at.position[body, X] - (c * mx - s * my),
        py - at.position[body, Y] - (s * mx + c * my),
    )
