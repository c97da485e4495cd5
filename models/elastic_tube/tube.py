"""Blood flow through an elastic tube, in two halves: a benchmark of coupling methods, after
Degroote et al. (2008).

Eq. (U3):  d(A)/dt + d(A v)/dy = 0                        on nodes 0..N, faces at i + 1/2, areas there a = mean of both nodes
Eq. (U4):  d(A v)/dt + d(A v v)/dy + A dp/dy = 0          density 1, momentum carried downstream
Eq. (U5):  A = a0 ((p0 - 2 c2) / (p - 2 c2))^2,  c2 = E sqrt(pi) / 2 / sqrt(a0)      wall, quasi-static

Length 10 m, E 1e4 Pa, wall thickness 1 m, a0 1 m2, p0 0, inflow velocity 10 + 3 sin(10 pi t) m/s;
outlet lets waves out.

References ---------- J. Degroote, P. Bruggeman, R. Haelterman, J. Vierendeels, Stability of a
coupling technique for partitioned solvers in FSI applications, Computers and Structures 86 (2008)
2224-2234.
"""

from dataclasses import dataclass

import numpy as np

from piston_cosim.master.fmi.errors import Discard
from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import Variable

LENGTH, NODES, WAVE = 10.0, 101, 1e4 * np.sqrt(np.pi) / 2


def field(name, unit, causality, description, start):
    return Variable(name, unit, causality, description, start, nominal=1.0, shape=(NODES,))


@dataclass(frozen=True)
class Nothing:
    """The wall has no memory."""


class Wall(FieldSlave):
    """Elastic wall without inertia, Eq. (U5)."""

    name, description, state_type = "tube_wall", "Elastic wall of a tube", Nothing

    @staticmethod
    def variables(options):
        return [
            field("pressure", "Pa", "input", "Pressure in the tube", 0.0),
            field("cross_section", "m2", "output", "Cross-section of the tube", 1.0),
        ]

    def start(self, values):
        return self.advance(Nothing(), values, 0.0, 0.0)

    def advance(self, state, values, time, step):
        return state, {
            "cross_section": (2 * WAVE / (2 * WAVE - values["pressure"])) ** 2
        }  # Eq. (U5)


@dataclass(frozen=True)
class Flow:
    velocity: np.ndarray  # [m/s], shape (NODES,)
    pressure: np.ndarray  # [Pa]
    cross_section: np.ndarray  # [m2]


class Fluid(FieldSlave):
    """Flow through the tube, backward Euler, Eqs. (U3) and (U4)."""

    name, description, state_type = "tube_fluid", "Flow through an elastic tube", Flow

    @staticmethod
    def variables(options):
        return [
            field("cross_section", "m2", "input", "Cross-section of the tube", 1.0),
            field("pressure", "Pa", "output", "Pressure in the tube", 0.0),
        ]

    def start(self, values):
        return Flow(np.full(NODES, 10.0), np.zeros(NODES), values["cross_section"]), {
            "pressure": np.zeros(NODES)
        }

    def advance(self, state, values, time, step):
        area, inflow = values["cross_section"], 10 + 3 * np.sin(10 * np.pi * (time + step))
        v, p, last = state.velocity.copy(), state.pressure.copy(), np.inf
        for _ in range(30):
            residual, tangent = balance(v, p, area, state, inflow, step)
            try:
                change = np.linalg.solve(tangent, residual)
            except np.linalg.LinAlgError:
                raise Discard(
                    f"flow at t = {time + step:g} s: singular for this cross-section"
                ) from None
            v, p = v - change[:NODES], p - change[NODES:]
            size = np.linalg.norm(change) / np.linalg.norm(np.concatenate([v, p]))
            if size <= 1e-13 or last / 2 <= size <= 1e-9:  # as small as round-off lets it be
                return Flow(v, p, area), {"pressure": p}
            last = size
        raise Discard(
            f"flow at t = {time + step:g} s: Newton's change stays at {size:.3g} of the solution"
        )


def balance(v, p, area, before, inflow, step):
    """Residual (2 NODES) of momentum then mass, boundary rows first and last, and its derivative by
    (v, p).
    """
    n, ratio = NODES, LENGTH / (NODES - 1) / step
    a, inner = (area[1:] + area[:-1]) / 2, np.arange(1, n - 1)
    momentum, mean = a * v[:-1] * (v[:-1] + v[1:]) / 2, a * (v[:-1] + v[1:]) / 2
    residual, tangent = np.zeros(2 * n), np.zeros((2 * n, 2 * n))
    residual[inner] = (
        ratio * (area * v - before.cross_section * before.velocity)[inner]
        + np.diff(momentum)
        + (a[:-1] * (p[1:-1] - p[:-2]) + a[1:] * (p[2:] - p[1:-1])) / 2
    )  # Eq. (U4)
    residual[n + inner] = ratio * (area - before.cross_section)[inner] + np.diff(mean)  # Eq. (U3)
    down, up = (
        a * (2 * v[:-1] + v[1:]) / 2,
        a * v[:-1] / 2,
    )  # derivative of the momentum flow by the node behind and ahead
    tangent[inner, inner - 1], tangent[inner, inner + 1] = -down[:-1], up[1:]
    tangent[inner, inner] = ratio * area[inner] + down[1:] - up[:-1]
    tangent[inner, n + inner - 1], tangent[inner, n + inner + 1] = -a[:-1] / 2, a[1:] / 2
    tangent[inner, n + inner] = (a[:-1] - a[1:]) / 2
    tangent[n + inner, inner - 1], tangent[n + inner, inner + 1] = -a[:-1] / 2, a[1:] / 2
    tangent[n + inner, inner] = (a[1:] - a[:-1]) / 2
    bend = np.array([1.0, -2.0, 1.0])
    residual[0], tangent[0, 0] = v[0] - inflow, 1.0
    residual[n - 1], tangent[n - 1, n - 3 : n] = bend @ v[-3:], bend
    residual[n], tangent[n, n : n + 3] = bend @ p[:3], bend
    leaving = (
        np.sqrt(WAVE - before.pressure[-1] / 2) - (v[-1] - before.velocity[-1]) / 4
    )  # outlet that lets waves out
    residual[-1] = p[-1] - 2 * (WAVE - leaving**2)
    tangent[-1, -1], tangent[-1, n - 1] = 1.0, -leaving
    return residual, tangent
