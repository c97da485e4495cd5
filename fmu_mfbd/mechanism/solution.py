"""Solution of the equations of motion of a chain at the end of a step.

References
----------
[Deuflhard2011] P. Deuflhard, Newton Methods for Nonlinear Problems, Springer, 2011.
"""

from typing import Annotated, NamedTuple

import numpy as np

from ...master.fmi.compiled import compilable
from ..geometry.arrays import Matrix
from .carrier import BlockMotion
from .chain import REACTION, Bodies, Chain, Loads
from .derivative import chain_derivative
from .elimination import LUFactors, factorise, substitute
from .equations import ChainForces, forces_at, point_of
from .floating_frame import TURN, ArrowMatrix, X, Y
from .generalised_alpha import Motion, Prediction
from .inertia import coupling_of, frame_state
from .laws import add_laws, law_sizes
from .loads import AppliedForces, loads_at
from .motion import ChainMotion, Increments, chain_motion
from .pin_friction import pin_friction_from
from .slider_crank import CrankMotion

MOST_EVALUATIONS = 80
"""Maximum number of evaluations of the residual. Three are usual."""

MOST_COUPLING_PASSES = 40
"""Maximum number of iterations for coupled modes. Each gains about four digits."""

ROUND_OFF = 4e-15
"""Relative round-off of a coordinate or a force, which is a sum of many terms."""


class ChainFactors(NamedTuple):
    """Factors of a tangent of m joint coordinates and k modes.

    Parameters
    ----------
    arrow : ArrowMatrix
    rigid : LUFactors
        Factors of its m rows after the elimination of modes (Eq. (D64)).
    """

    arrow: ArrowMatrix
    rigid: LUFactors


class Linearisation(NamedTuple):
    """The end of a step and its derivative by the unknowns of the time integrator.

    Parameters
    ----------
    forces : ChainForces
    factors : ChainFactors
        Factors of the tangent.
    on_block : ndarray, shape (3, m + k)
        Derivative of `ChainForces.on_block`.
    law_slopes
        As of `Loads`.
    """

    forces: ChainForces
    factors: ChainFactors
    on_block: Matrix
    law_slopes: Annotated[np.ndarray, "f, 3, 6"]


class ChainSolution(NamedTuple):
    """Motion that fulfils the equations of motion, and what goes with it.

    Parameters
    ----------
    now : Motion
        Motion in all m + k coordinates.
    loads : Loads
    linear : Linearisation
    evaluations, tangents : int
        Numbers of evaluations of the residual, 0 if it did not converge, and of the tangent.
    change : float
        Last change of the unknowns in the norm of the inertia; relative if it did not converge.
    """

    now: Motion
    loads: Loads
    linear: Linearisation
    evaluations: int
    tangents: int
    change: float


@compilable
def solve_motion(
    chain: Chain,
    applied: AppliedForces,
    predicted: Prediction,
    guess: np.ndarray,
    by: Increments,
    drive: CrankMotion,
    carrier: BlockMotion,
) -> ChainSolution:
    """Solve for the unknowns at the end of a step that fulfil the equations of motion.

    The error is about 1e-15 of their size, or the round-off of positions and forces. This round-off
    is larger in short steps of a slow motion, and where large forces balance each other.

    Newton's method omits the coupling of modes in the tangent (Eq. (D4)), which is smaller by
    2 w c1, about 1e-4. Each iteration with the first tangent gains three to four digits. Dry
    friction that nearly sticks needs more iterations. If the next change is not smaller, the last
    change is halved (natural monotonicity test, [Deuflhard2011] ch. 3). If changes decrease slowly,
    the tangent is recomputed.

    Parameters
    ----------
    chain : Chain
    applied : AppliedForces
        Applied forces of all elements.
    predicted : Prediction
        With unknowns of zero.
    guess : ndarray, shape (m + k,)
        Unknowns to start from.
    by : Increments
    drive, carrier
        As for `chain_forces`.

    Returns
    -------
    ChainSolution
    """
    n, has_laws = len(guess), len(chain.laws.kind) > 0
    unknown = guess.copy()
    now = Motion(np.empty(n), np.empty(n), np.empty(n))
    _move(now, predicted, by, unknown)
    at = chain_motion(chain.joints, now, drive)
    loads = loads_at(chain, applied, at, now)
    if has_laws:
        add_laws(chain, at, drive.angle, loads)
    forces = forces_at(chain, loads, at, now, carrier)
    slope = chain_derivative(chain, loads, now, forces, by)
    factors = factorise_chain(slope.arrow)
    tangents = 1
    change = np.zeros(n)
    size, total, noise, share = 0.0, 0.0, 0.0, 1.0  # of the change, of the unknowns; round-off
    for evaluation in range(1, MOST_EVALUATIONS):
        if evaluation > 1:
            at = chain_motion(chain.joints, now, drive)
            loads = loads_at(chain, applied, at, now)
            if has_laws:
                add_laws(chain, at, drive.angle, loads)
            forces = forces_at(chain, loads, at, now, carrier)
            if evaluation == 2:  # the noise changes little after the first iteration
                noise = ROUND_OFF * _noise(chain, loads, now, forces, slope, by)
            if size <= 1e-11 * total + noise:
                slope = chain_derivative(chain, loads, now, forces, by)
                factors = factorise_chain(slope.arrow)
                linear = Linearisation(forces, factors, slope.on_block, loads.law_slopes)
                return ChainSolution(
                    now=now,
                    loads=loads,
                    linear=linear,
                    evaluations=evaluation,
                    tangents=tangents + 1,
                    change=size,
                )
        next_change = substitute_chain(factors, forces.residual)
        next_size = np.sqrt(squared_size(slope.arrow, next_change))
        if evaluation > 1 and next_size > (1 - share / 4) * size:
            share /= 2
            for k in range(n):
                unknown[k] += share * change[k]
        else:
            if evaluation > 1 and next_size > 0.1 * size:
                slope = chain_derivative(chain, loads, now, forces, by)
                factors = factorise_chain(slope.arrow)
                next_change = substitute_chain(factors, forces.residual)
                tangents += 1
            change = next_change
            share = 1.0
            for k in range(n):
                unknown[k] -= change[k]
            size = np.sqrt(squared_size(slope.arrow, change))
            total = np.sqrt(squared_size(slope.arrow, unknown))
        _move(now, predicted, by, unknown)
    linear = Linearisation(forces, factors, slope.on_block, loads.law_slopes)
    return ChainSolution(
        now=now, loads=loads, linear=linear, evaluations=0, tangents=tangents, change=size / total
    )


@compilable
def _move(now, predicted, by, unknown):
    """Write the motion that follows from the predicted one by the unknowns."""
    for k in range(len(unknown)):
        now.position[k] = predicted.position[k] + by.position[k] * unknown[k]
        now.velocity[k] = predicted.velocity[k] + by.velocity[k] * unknown[k]
        now.acceleration[k] = by.acceleration[k] * unknown[k]


@compilable
def squared_size(arrow: ArrowMatrix, a: np.ndarray) -> float:
    """Return the square of accelerations in the norm of the tangent's diagonal."""
    m = len(arrow.top)
    total = 0.0
    for j in range(m):
        total += abs(arrow.top[j, j]) * a[j] ** 2
    for k in range(len(arrow.diagonal)):
        total += arrow.diagonal[k] * a[m + k] ** 2
    return total


@compilable
def _noise(chain, loads, now, forces, slope, by):
    """Return the size of accelerations by all terms without sign, in the norm of `squared_size`.

    The terms are those of positions and of all forces. The round-off of accelerations is a share of
    this size.
    """
    arrow, d = slope.arrow, slope.motion
    m, k = len(arrow.top), len(arrow.diagonal)
    places, rows = np.zeros(m + k), _sizes(chain, loads, forces)
    of_forces = 0.0
    for j in range(m):
        row = 0.0
        for b in range(len(rows)):
            for i in range(3):
                row += abs(d.acceleration[b, i, j]) * rows[b, i]  # Eq. (D61)
        of_forces += row**2 / abs(arrow.top[j, j])
    frames = np.abs(forces.inertia.frames)
    for b in range(len(rows)):
        f = frame_state(frames, b)
        for i in range(chain.bodies.first_mode[b], chain.bodies.first_mode[b + 1]):
            row = abs(loads.modal[i]) + chain.bodies.stiffness[i] * abs(now.position[m + i])
            row += abs(chain.bodies.T[X, i]) * f.ax + abs(chain.bodies.T[Y, i]) * f.ay
            of_forces += row**2 / arrow.diagonal[i]
    for i in range(chain.bodies.first_mode[-1], k):
        row = abs(loads.modal[i]) + chain.bodies.stiffness[i] * abs(now.position[m + i])
        of_forces += row**2 / arrow.diagonal[i]
    for j in range(m + k):
        if by.position[j] > 0.0:
            places[j] = now.position[j] / by.position[j]
    return np.sqrt(squared_size(arrow, places)) + np.sqrt(of_forces)


@compilable
def _sizes(chain, loads, forces):
    """Return the sums of the absolute forces [N] and moments [N m] on each body, (n, 3)."""
    bodies, elements, at = chain.bodies, chain.elements, forces.motion
    out = np.empty((len(bodies.mass), 3))
    frames = np.abs(forces.inertia.frames)
    for b in range(len(out)):
        f = frame_state(frames, b)
        acceleration = f.ax + f.ay
        joint_force = abs(forces.joint_wrench[b, X]) + abs(forces.joint_wrench[b, Y])
        out[b, X] = out[b, Y] = bodies.mass[b] * acceleration
        lever = pin_friction_from(chain.joints.friction[b]).lever
        out[b, TURN] = (f.sx + f.sy) * acceleration + lever * joint_force
    first = len(loads.wrench) - len(loads.law_slopes)
    for e in range(len(loads.wrench)):
        x, y = abs(loads.wrench[e, X]), abs(loads.wrench[e, Y])
        turn, back = abs(loads.wrench[e, TURN]), abs(loads.wrench[e, REACTION])
        if e >= first:
            x, y, turn = law_sizes(chain, at, loads, e - first)
            back = turn
        px, py = point_of(elements, at, e)
        b, other = elements.acts[e], elements.reacts[e]
        out[b, X] += x
        out[b, Y] += y
        out[b, TURN] += turn
        out[b, TURN] += abs(px - at.position[b, X]) * y + abs(py - at.position[b, Y]) * x
        if other >= 0:
            out[other, X] += x
            out[other, Y] += y
            out[other, TURN] += back
            out[other, TURN] += abs(px - at.position[other, X]) * y
            out[other, TURN] += abs(py - at.position[other, Y]) * x
    return out


@compilable
def factorise_chain(arrow: ArrowMatrix) -> ChainFactors:
    """Eliminate the modes from a tangent, and factorise the rest.

    Eq. (D64):  (A - B D^-1 C) x = a - B D^-1 c,   y = D^-1 (c - C x)
                of [A, B; C, D] with a diagonal D

    Parameters
    ----------
    arrow : ArrowMatrix

    Returns
    -------
    ChainFactors
    """
    top, left, diagonal = arrow.top, arrow.left, arrow.diagonal
    m, k = len(top), len(diagonal)
    matrix = np.empty((m, m))
    for i in range(m):
        for j in range(m):
            matrix[i, j] = top[i, j]
        if k > 0:
            # Eq. (D64)
            share = top[i][m:].copy()
            for mode in range(k):
                share[mode] /= diagonal[mode]
            by_modes = share @ left
            for j in range(m):
                matrix[i, j] -= by_modes[j]
    return ChainFactors(arrow, factorise(matrix))


@compilable
def substitute_chain(factors: ChainFactors, right: np.ndarray) -> np.ndarray:
    """Return x of `arrow` x = right, (m + k,), by Eq. (D64)."""
    top, left, diagonal = factors.arrow.top, factors.arrow.left, factors.arrow.diagonal
    m, k = len(top), len(diagonal)
    rest, out, of_modes = np.empty(m), np.empty(m + k), np.empty(k)
    for mode in range(k):
        of_modes[mode] = right[m + mode] / diagonal[mode]
    for i in range(m):
        rest[i] = right[i]
        if k > 0:
            rest[i] -= top[i][m:] @ of_modes  # Eq. (D64)
    x = substitute(factors.rigid, rest)
    for i in range(m):
        out[i] = x[i]
    if k > 0:
        carried = left @ x
        for mode in range(k):
            out[m + mode] = of_modes[mode] - carried[mode] / diagonal[mode]
    return out


@compilable
def arrow_product(arrow: ArrowMatrix, x: np.ndarray) -> np.ndarray:
    """Return `arrow` x by loops, the same bits everywhere, (m + k,)."""
    m, k = len(arrow.top), len(arrow.diagonal)
    out = np.zeros(m + k)
    for i in range(m):
        for j in range(m + k):
            out[i] += arrow.top[i, j] * x[j]
    for i in range(k):
        for j in range(m):
            out[m + i] += arrow.left[i, j] * x[j]
        out[m + i] += arrow.diagonal[i] * x[m + i]
    return out


@compilable
def solve_coupled(
    bodies: Bodies,
    at: ChainMotion,
    carrier: BlockMotion,
    by: Increments,
    factors: ChainFactors,
    right: np.ndarray,
) -> np.ndarray:
    """Return x of (tangent with coupled modes) x = right, to 1e-13 of its size.

    Eq. (N3):  x <- arrow^-1 (right - coupling x)

    The coupling is small (Eq. (D4)), so each iteration gains about four digits. It costs a product
    with the coupling. A factorisation would cost as much as hundreds of iterations.

    Parameters
    ----------
    bodies, at, by
        As for the tangent.
    carrier : BlockMotion
        Motion of the block.
    factors : ChainFactors
    right : ndarray, shape (m + k,)

    Returns
    -------
    ndarray, shape (m + k,)
        Starts with NaN if it does not converge.
    """
    x = substitute_chain(factors, right)
    if bodies.first_mode[-1] == 0:
        return x
    arrow = factors.arrow
    m = len(arrow.top)
    uncoupled = right.copy()
    for _ in range(MOST_COUPLING_PASSES):
        coupling = mode_coupling(bodies, at, carrier, by, x)
        for k in range(len(coupling)):
            uncoupled[m + k] = right[m + k] - coupling[k]  # Eq. (N3)
        next_x = substitute_chain(factors, uncoupled)
        for k in range(len(x)):
            x[k] = next_x[k] - x[k]
        if squared_size(arrow, x) <= 1e-26 * squared_size(arrow, next_x):
            return next_x
        x = next_x
    x[0] = np.nan
    return x


@compilable
def mode_coupling(
    bodies: Bodies, at: ChainMotion, carrier: BlockMotion, by: Increments, unknowns: np.ndarray
) -> np.ndarray:
    """Return the coupling of modes, which `chain_derivative` omits, times unknowns.

    Eq. (D4):  (2 w c1 + alpha c2) G - w^2 c2 B      Coriolis, Euler and centrifugal terms

    Parameters
    ----------
    bodies, at, by
        As for the tangent.
    carrier : BlockMotion
        Motion of the block.
    unknowns : ndarray, shape (m + k,)

    Returns
    -------
    ndarray, shape (k,)
        About 2 w c1, 1e-4 of the inertia of modes for a rocking piston.
    """
    out = np.zeros(len(bodies.stiffness))
    m = len(unknowns) - len(out)
    for b in range(len(bodies.mass)):
        begin, end = bodies.first_mode[b], bodies.first_mode[b + 1]
        k = end - begin
        if k == 0:
            continue
        w = at.velocity[b, TURN] + carrier.w
        alpha = at.acceleration[b, TURN] + carrier.alpha
        by_g, by_b = np.empty(k), np.empty(k)
        for i in range(k):
            j = m + begin + i
            # Eq. (D4)
            by_g[i] = (2 * w * by.velocity[j] + alpha * by.position[j]) * unknowns[j]
            by_b[i] = w * w * by.position[j] * unknowns[j]
        table = coupling_of(bodies, b)
        coriolis, centrifugal = table[k:] @ by_g, table[:k] @ by_b
        for i in range(k):
            out[begin + i] = coriolis[i] - centrifugal[i]
    return out
