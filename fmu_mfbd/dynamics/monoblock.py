"""Flexible block of several cylinders on its mounts: rigid motion and modes, by implicit steps.

Eq. (U30):  M q'' + C q' + K q = F,   q = (u, rotation, modal coordinates)
            M = diag(R^T M R, 1),   K = diag(0, Omega^2) + sum_j G_j^T k_j G_j
            C = diag(0, 2 zeta Omega) + tau sum_j G_j^T k_j G_j,   G_j = [1, -r_j~, phi_j]
            u, rotation of the mean frame at O, the middle of the crank axis; r_j~ v = r_j x v,
            phi_j the modes at mount j
Eq. (U31):  rigid part of F:  sum_k (f_k, z_k x f_k + M_k z/|z|),   of all that cylinder k does
            modal part:       sum_k (W_k^T F_W + d_k F_d + b_k (F_bx, F_by))
            W_k, d_k, b_k the modes on its bore, on the deck around it and at its main bearings;
            F_W, F_d, F_b what film and gas, gas and crank do there
Eq. (U32):  a_k = u'' + rotation'' x z_k,   w_k = W_k q:   given back to cylinder k

The rigid motion steps by the trapezoidal rule, the modes as those of a cylinder's own block do:
backward Euler first, generalised-alpha then; those above the quasi-static frequency follow their
load. Small motions; the modes move no momentum, so that the mounts alone couple both. Cylinders
stand upright side by side. The block starts at rest, undeformed, its mounts unloaded.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import scipy.linalg as la

from ..force_elements.element import declared
from ..mechanism.bdf2 import BY_ALPHA, STATIC, predicted_of, reach_of
from ..mechanism.generalised_alpha import Coefficients, Motion, Prediction, coefficients
from ..mechanism.motion import Increments
from ..reduction.reduced_body import ReducedMonoblock
from .first_steps import FIRST_STEPS, first_steps
from .motion_in_space import skew

RIGID_MOTIONS = 6
TRAPEZOIDAL = 1.0
"""Spectral radius of the rule that keeps all energy."""


class Cylinder(NamedTuple):
    """Actions of a cylinder on the block: unit, start and nominal value.

    `force_on_bore` is (angles, stations).
    """

    force_x: Annotated[float, "N", 0.0, 1e3]
    """Force of bore, deck and main bearings on the block along x."""
    force_y: Annotated[float, "N", 0.0, 1e3]
    """Force of bore, deck and main bearings on the block along y."""
    moment: Annotated[float, "N.m", 0.0, 1e2]
    """Moment of bore and deck on the block about the crank axis."""
    bearing_force_x: Annotated[float, "N", 0.0, 1e3]
    """Force of the crank on its main bearings along x."""
    bearing_force_y: Annotated[float, "N", 0.0, 1e3]
    """Force of the crank on its main bearings along y."""
    force_on_deck: Annotated[float, "N", 0.0, 1e3]
    """Force of the gas on the deck along y."""
    force_on_bore: Annotated[np.ndarray, "N", 0.0, 10.0]
    """Outward force of film and gas on the bore, on its grid of angles and heights."""


class CylinderMotion(NamedTuple):
    """Motion of the block at a cylinder: unit and nominal value.

    `bore_deflection` is (angles, stations).
    """

    acceleration_x: Annotated[float, "m/s2", 1.0]
    """Acceleration of the block at the cylinder along x."""
    acceleration_y: Annotated[float, "m/s2", 1.0]
    """Acceleration of the block at the cylinder along y."""
    angular_acceleration: Annotated[float, "rad/s2", 10.0]
    """Angular acceleration of the block about z."""
    angular_velocity: Annotated[float, "rad/s", 0.1]
    """Angular velocity of the block about z."""
    bore_deflection: Annotated[np.ndarray, "m", 1e-5]
    """Outward deflection of the bore, on its grid of angles and heights."""


@dataclass(frozen=True)
class BlockState:
    """Motion of all coordinates, auxiliary acceleration and forces F, each (6 + k,).

    It also has the length of the last step [s] and the number of steps.
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    auxiliary: np.ndarray
    force: np.ndarray
    step: float = 0.0
    steps: int = 0


@dataclass(frozen=True)
class BlockParameters:
    """Parameters of the block besides the stiffness of its mounts, in SI."""

    damping_time: float = declared("s", 0.0, 0.0, 1.0)
    """Damping time of the mounts: damping divided by stiffness."""
    damping_ratio: float = declared("1", 0.02, 0.0, 2.0)
    """Modal damping ratio of all modes."""
    quasi_static_frequency: float = declared("Hz", 1e9, 0.0, 1e9)
    """Frequency above which modes follow their load without inertia."""
    spectral_radius: float = declared("1", 0.6, 0.0, 1.0)
    """Spectral radius of the modes' time integrator at infinite frequency."""


class StepRule(NamedTuple):
    """Rule of a step.

    Parameters
    ----------
    parts : list of (slice, Coefficients)
        Rigid motion and modes.
    by : Increments
    factors : tuple of ndarray
        LU factors of the equations.
    """

    parts: list[tuple[slice, Coefficients]]
    by: Increments
    factors: tuple[np.ndarray, np.ndarray]


class MountedMonoblock:
    """Eqs. (U30) to (U32).

    Parameters
    ----------
    body : ReducedMonoblock
    stiffness : ndarray, shape (m, 3)
        Stiffness of the mounts along x, y, z [N/m].
    p : BlockParameters
    """

    def __init__(self, body: ReducedMonoblock, stiffness: np.ndarray, p: BlockParameters):
        self.body = body
        self.spectral_radius = p.spectral_radius
        self.size = RIGID_MOTIONS + len(body.omega)
        fast = body.omega > 2 * np.pi * p.quasi_static_frequency
        self.kinds = np.concatenate(
            [np.full(RIGID_MOTIONS, BY_ALPHA), np.where(fast, STATIC, BY_ALPHA)]
        )
        self.mass = la.block_diag(body.rigid_mass, np.diag((~fast).astype(float)))
        levers = np.array(
            [
                np.hstack([np.eye(3), -skew(place), shapes])
                for place, shapes in zip(body.mount_place, body.mount)
            ]
        )
        # Eq. (U30)
        self.mounts = np.einsum("jai,ja,jab->ib", levers, stiffness, levers)
        zeros = np.zeros(RIGID_MOTIONS)
        elastic = np.concatenate([zeros, body.omega**2])
        self.modal_damping = np.concatenate(
            [zeros, np.where(fast, 0.0, 2 * p.damping_ratio * body.omega)]
        )
        self.elastic = elastic
        self.stiffness = np.diag(elastic) + self.mounts
        self.mount_damping = p.damping_time * self.mounts
        self.damping = np.diag(self.modal_damping) + self.mount_damping
        self._rules: dict[tuple[float, bool], StepRule] = {}

    def loose(self) -> bool:
        """Return whether the mounts hold only some motions of the rigid block."""
        eigenvalues = np.linalg.eigvalsh(self.mounts[:RIGID_MOTIONS, :RIGID_MOTIONS])
        return 0.0 < eigenvalues[-1] and eigenvalues[0] <= 1e-12 * eigenvalues[-1]

    def start(self, cylinders: list[Cylinder]) -> BlockState:
        """Return the state at rest, with the forces at the start."""
        nothing = np.zeros(self.size)
        return BlockState(nothing, nothing, nothing, nothing, 0.0 * self.total(cylinders))

    def total(self, cylinders: list[Cylinder]) -> np.ndarray:
        """Return F, shape (6 + k,), of all cylinders, or of a change of their forces."""
        body = self.body
        x, y, moment = np.array([(one.force_x, one.force_y, one.moment) for one in cylinders]).T
        z = body.cylinder_z
        # Eq. (U31)
        rigid = [x.sum(), y.sum(), 0.0, -(z @ y), z @ x, moment.sum()]
        modal = sum(
            np.einsum("cs,csk->k", one.force_on_bore, radial)
            + one.force_on_deck * deck
            + one.bearing_force_x * bearing[0]
            + one.bearing_force_y * bearing[1]
            for one, radial, deck, bearing in zip(cylinders, body.radial, body.deck, body.bearing)
        )
        return np.concatenate([rigid, modal])

    def at_cylinders(
        self, position: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
    ) -> list[CylinderMotion]:
        """Return the motion of the block, or a change of it, at each cylinder."""
        across, up, _, pitch, yaw, roll = acceleration[:RIGID_MOTIONS].tolist()
        rolling = float(velocity[RIGID_MOTIONS - 1])
        # Eq. (U32)
        return [
            CylinderMotion(across + yaw * z, up - pitch * z, roll, rolling, field)
            for z, field in zip(
                self.body.cylinder_z.tolist(), self.body.radial @ position[RIGID_MOTIONS:]
            )
        ]

    def advance(self, before: BlockState, cylinders: list[Cylinder], step: float) -> BlockState:
        """Take a step [s]; the equations hold at its end, with the forces at its end."""
        rule = self._rule(step, before.steps < FIRST_STEPS)
        end = self._predicted(before, rule)
        force = self.total(cylinders)
        residual = force - self.damping @ end.velocity - self.stiffness @ end.position
        unknown = la.lu_solve(rule.factors, residual)
        acceleration = rule.by.acceleration * unknown
        auxiliary = end.auxiliary
        for part, c in rule.parts:
            auxiliary[part] += c.to_auxiliary * acceleration[part]
        steps = before.steps + 1
        if steps < FIRST_STEPS:
            auxiliary[RIGID_MOTIONS:] = 0.0
        return BlockState(
            position=end.position + rule.by.position * unknown,
            velocity=end.velocity + rule.by.velocity * unknown,
            acceleration=acceleration,
            auxiliary=auxiliary,
            force=force,
            step=step,
            steps=steps,
        )

    def change(self, after: BlockState, cylinders: list[Cylinder]) -> list[CylinderMotion]:
        """Return the change of the block's motion at each cylinder with all cylinders' forces.

        It is exact, because the equations are linear.
        """
        if not after.steps:
            return self.at_cylinders(*np.zeros((3, self.size)))
        _, by, factors = self._rule(after.step, after.steps <= FIRST_STEPS)
        unknown = la.lu_solve(factors, self.total(cylinders))
        return self.at_cylinders(
            by.position * unknown, by.velocity * unknown, by.acceleration * unknown
        )

    def energies(self, state: BlockState) -> tuple[float, float]:
        """Return kinetic energy, and elastic energy of modes and mounts [J]."""
        kinetic = state.velocity @ self.mass @ state.velocity / 2
        return float(kinetic), float(state.position @ self.stiffness @ state.position / 2)

    def lost(self, before: BlockState, after: BlockState) -> float:
        """Return the heat of mounts and modes over a step, by the trapezoidal rule [J]."""
        mean = (before.velocity + after.velocity) / 2
        return float((after.position - before.position) @ self.damping @ mean)

    def energy_error(self, before: BlockState, after: BlockState) -> float:
        """Return the work of all forces over a step minus stored and lost energy [J]."""
        work = (after.position - before.position) @ (before.force + after.force) / 2
        stored = sum(self.energies(after)) - sum(self.energies(before))
        return float(work - stored - self.lost(before, after))

    def _predicted(self, before: BlockState, rule: StepRule) -> Prediction:
        """Return the end of a step if its unknowns were zero."""
        motion = np.array([before.position, before.velocity, before.acceleration])
        auxiliary, none = before.auxiliary.copy(), np.zeros(self.size)
        ends = [
            predicted_of(c, Motion(*motion[:, part]), auxiliary[part], none, self.kinds[part])
            for part, c in rule.parts
        ]
        return Prediction(*map(np.concatenate, zip(*ends)))

    def _rule(self, step: float, begins: bool) -> StepRule:
        """Return the cached rule of a step of this length."""
        key = (step, begins)
        if key not in self._rules:
            modal = first_steps(step) if begins else coefficients(step, self.spectral_radius)
            cut = RIGID_MOTIONS
            parts = [(slice(cut), coefficients(step, TRAPEZOIDAL)), (slice(cut, None), modal)]
            reaches = [reach_of(c, self.kinds[part]) for part, c in parts]
            by = Increments(*map(np.concatenate, zip(*reaches)))
            moved = self.mass + self.damping * by.velocity + self.stiffness * by.position
            self._rules = {key: StepRule(parts, by, la.lu_factor(moved))}
        return self._rules[key]
