"""Blood flow through an elastic tube: a benchmark of coupling methods with two participants.

Eq. (U3):  d(A)/dt + d(A v)/dy = 0
           on nodes 0..N, faces at i + 1/2 with the mean area of both nodes
Eq. (U4):  d(A v)/dt + d(A v v)/dy + A dp/dy = 0          density 1, momentum carried downstream
Eq. (U5):  A = a0 ((p0 - 2 c2) / (p - 2 c2))^2,  c2 = E sqrt(pi) / 2 / sqrt(a0)
           quasi-static wall

Length 10 m, E 1e4 Pa, wall thickness 1 m, a0 1 m2, p0 0, inflow velocity 10 + 3 sin(10 pi t) m/s.
The outlet does not reflect waves.

References
----------
J. Degroote, P. Bruggeman, R. Haelterman, J. Vierendeels, Stability of a coupling technique for
partitioned solvers in FSI applications, Computers and Structures 86 (2008) 2224-2234.
"""

from dataclasses import dataclass

import numpy as np

from piston_cosim.master.fmi.errors import Discard
from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import input_variable, output_variable

LENGTH = 10.0  # of the tube [m]
NODES = 101
GRID = (NODES,)
WAVE = 1e4 * np.sqrt(np.pi) / 2  # c2 of Eq. (U5) [m2/s2]


@dataclass(frozen=True)
class Nothing:
    """Empty state of the wall."""


class Wall(FieldSlave):
    """Elastic wall without inertia, Eq. (U5)."""

    name, description, state_type = "tube_wall", "Elastic wall of a tube", Nothing

    @staticmethod
    def variables(options):
        return [
            input_variable("pressure", "Pa", "Pressure in the tube", 0.0, 1.0, GRID),
            output_variable(
                "cross_section", "m2", "Cross-section of the tube", 1.0, GRID, start=1.0
            ),
        ]

    def start(self, values):
        return self.advance(Nothing(), values, 0.0, 0.0)

    def advance(self, state, values, time, step):
        area = (2 * WAVE / (2 * WAVE - values["pressure"])) ** 2  # Eq. (U5)
        return state, {"cross_section": area}


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
            input_variable("cross_section", "m2", "Cross-section of the tube", 1.0, 1.0, GRID),
            output_variable("pressure", "Pa", "Pressure in the tube", 1.0, GRID),
        ]

    def start(self, values):
        uniform = Flow(np.full(NODES, 10.0), np.zeros(NODES), values["cross_section"])
        return uniform, {"pressure": np.zeros(NODES)}

    def advance(self, state, values, time, step):
        area = values["cross_section"]
        inflow = 10 + 3 * np.sin(10 * np.pi * (time + step))
        v = state.velocity.copy()
        p = state.pressure.copy()
        last = np.inf
        for _ in range(30):
            residual, tangent = linearised(v, p, area, state, inflow, step)
            try:
                change = np.linalg.solve(tangent, residual)
            except np.linalg.LinAlgError:
                raise Discard(
                    f"flow at t = {time + step:g} s: singular for this cross-section"
                ) from None
            v = v - change[:NODES]
            p = p - change[NODES:]
            size = np.linalg.norm(change) / np.linalg.norm(np.concatenate([v, p]))
            if size <= 1e-13 or last / 2 <= size <= 1e-9:  # limit of round-off
                return Flow(v, p, area), {"pressure": p}
            last = size
        raise Discard(
            f"flow at t = {time + step:g} s: Newton's change stays at {size:.3g} of the solution"
        )


def linearised(v, p, area, before, inflow, step):
    """Return residual (2 NODES) and its derivative by (v, p).

    The rows are momentum, then mass, with the boundary conditions in the first and last row of
    each.
    """
    n = NODES
    ratio = LENGTH / (NODES - 1) / step
    face = (area[1:] + area[:-1]) / 2
    inner = np.arange(1, n - 1)
    flow = face * (v[:-1] + v[1:]) / 2
    momentum = face * v[:-1] * (v[:-1] + v[1:]) / 2
    residual = np.zeros(2 * n)
    tangent = np.zeros((2 * n, 2 * n))
    # Eq. (U4)
    residual[inner] = (
        ratio * (area * v - before.cross_section * before.velocity)[inner]
        + np.diff(momentum)
        + (face[:-1] * (p[1:-1] - p[:-2]) + face[1:] * (p[2:] - p[1:-1])) / 2
    )
    # Eq. (U3)
    residual[n + inner] = ratio * (area - before.cross_section)[inner] + np.diff(flow)
    # derivative of the momentum flow by the upstream and the downstream node
    behind = face * (2 * v[:-1] + v[1:]) / 2
    ahead = face * v[:-1] / 2
    tangent[inner, inner - 1] = -behind[:-1]
    tangent[inner, inner] = ratio * area[inner] + behind[1:] - ahead[:-1]
    tangent[inner, inner + 1] = ahead[1:]
    tangent[inner, n + inner - 1] = -face[:-1] / 2
    tangent[inner, n + inner] = (face[:-1] - face[1:]) / 2
    tangent[inner, n + inner + 1] = face[1:] / 2
    tangent[n + inner, inner - 1] = -face[:-1] / 2
    tangent[n + inner, inner] = (face[1:] - face[:-1]) / 2
    tangent[n + inner, inner + 1] = face[1:] / 2
    # the ends: inflow velocity; no curvature of velocity there and of pressure here; outlet without
    # reflection
    curvature = np.array([1.0, -2.0, 1.0])
    residual[0] = v[0] - inflow
    tangent[0, 0] = 1.0
    residual[n - 1] = curvature @ v[-3:]
    tangent[n - 1, n - 3 : n] = curvature
    residual[n] = curvature @ p[:3]
    tangent[n, n : n + 3] = curvature
    leaving = np.sqrt(WAVE - before.pressure[-1] / 2) - (v[-1] - before.velocity[-1]) / 4
    residual[-1] = p[-1] - 2 * (WAVE - leaving**2)
    tangent[-1, -1] = 1.0
    tangent[-1, n - 1] = -leaving
    return residual, tangent
