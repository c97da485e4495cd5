"""Chains of bodies: against the equations by hand, differences, virtual work and momentum."""

from functools import partial

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics import floating_pin, pin_tangent, piston_motion
from piston_cosim.fmu_mfbd.dynamics.block_force import block_force
from piston_cosim.fmu_mfbd.dynamics.carrier import FIXED, Carrier
from piston_cosim.fmu_mfbd.dynamics.floating_frame import mode_coupling
from piston_cosim.fmu_mfbd.dynamics.floating_pin import PinFilms
from piston_cosim.fmu_mfbd.dynamics.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.dynamics.pin_coordinates import Crankshaft, PinBodies
from piston_cosim.fmu_mfbd.dynamics.piston_motion import Load
from piston_cosim.fmu_mfbd.geometry.pin import PinResultants
from piston_cosim.fmu_mfbd.mechanism.chain import Link, Loads, chain_of
from piston_cosim.fmu_mfbd.mechanism.equations import chain_forces, chain_tangent, solve_chain
from piston_cosim.fmu_mfbd.mechanism.motion import Increments, chain_motion

from .chains import (
    CRANK,
    CRANK_MASS,
    GAS,
    MECHANISM,
    SPIN_INERTIA,
    UNBALANCE,
    engine,
    flexible,
    rigid,
)

STEP = 1e-4
MOVING = Carrier(30.0, -40.0, 900.0, 1.3)
DIGITS = 1e-13
"""Both add up to some tens of terms in another order: 1e-16 of the largest term for each."""


def motion(built, seed=1):
    """Return a motion of deviations of micrometres, with pistons that slap."""
    rng = np.random.default_rng(seed)
    m = built.chain.joints.tip.shape[1]
    k = len(built.chain.bodies.stiffness)
    scales = np.repeat([[1e-5], [0.01], [900.0]], m, axis=1)
    for b in built.pistons:
        turn = built.chain.joints.angle[b]
        scales[:, turn - 1] = 3e-5, 0.05, 800.0
        scales[:, turn] = 2e-3, 3.0, 5e4
    modal = np.repeat([[1e-6], [1e-2], [1e3]], k, axis=1)
    return Motion(*(np.hstack([scales, modal]) * rng.standard_normal((3, m + k))))


def loads(built, now, seed=2):
    """Return films, gas and forces on modes of any size, the gas on the bore's axis."""
    rng = np.random.default_rng(seed)
    chain = built.chain
    wrench = rng.standard_normal((len(chain.elements.acts), 4)) * [9e3, 9e3, 2.0, 2.0]
    for gas, piston in zip(built.gas, built.pistons):
        x = chain_motion(chain, now, CRANK).position[piston, 0] - MECHANISM.offset
        wrench[gas] = 0.0, -GAS, GAS * x, 0.0
    return Loads(wrench, 100 * rng.standard_normal(len(chain.bodies.stiffness)))


def reach(n, c1=0.5 * STEP, c2=0.25 * STEP**2):
    return Increments(np.full(n, c2), np.full(n, c1), np.ones(n))


def in_balance(built, given, now, carrier=FIXED):
    """Return a motion with the accelerations that fulfil the equations of motion."""
    n = len(now.position)
    own = chain_forces(built.chain, given, now, CRANK, carrier)
    arrow = chain_tangent(built.chain, given, now, own, reach(n, 0.0, 0.0))
    return now._replace(acceleration=now.acceleration - solve_chain(arrow, own.residual))


def on_piston(built, given, now, carrier=FIXED):
    """Return the load of a piston as today's equations take it."""
    skirt = given.wrench[built.skirts[0]]
    return Load(skirt[0], skirt[1] - GAS, skirt[2], GAS, given.modal, carrier)


def assert_close(own, known):
    """Compare each number, and one that is small by itself with the largest."""
    size = np.abs(known).max(initial=0.0)
    np.testing.assert_allclose(own, known, rtol=DIGITS, atol=2e-15 * size)


@pytest.mark.parametrize("modes", [0, 60])
@pytest.mark.parametrize("carrier", [FIXED, MOVING], ids=["fixed", "moving"])
def test_a_tied_pin_is_the_one_by_hand(modes, carrier):
    """Residual, torque, forces on the block, tangent and its solution.

    The tangent by hand omits 2 w c1 of a moving block, so that it is compared at rest.
    """
    piston = flexible(modes)
    built = engine([piston])
    now = motion(built)
    given = loads(built, now)
    load = on_piston(built, given, now, carrier)
    by_hand = piston_motion.imbalance(piston, MECHANISM, load, now, CRANK)
    own = chain_forces(built.chain, given, now, CRANK, carrier)
    assert_close(own.residual, by_hand.residual)
    assert own.torque == pytest.approx(by_hand.torque, rel=DIGITS)
    balanced = in_balance(built, given, now, carrier)
    force = block_force(
        piston, MECHANISM, 0.0, on_piston(built, given, now, carrier), balanced, CRANK
    )
    found = chain_forces(built.chain, given, balanced, CRANK, carrier).on_block
    assert_close(found, np.array(force[:3]))
    if carrier is FIXED:
        c1, c2 = 0.5 * STEP, 0.25 * STEP**2
        known = piston_motion.tangent(piston, MECHANISM, load, now, CRANK, c1, c2)
        arrow = chain_tangent(built.chain, given, now, own, reach(2 + modes))
        for one, other in zip(arrow, known):
            for row, expected in zip(one, other):
                assert_close(row, expected)
        right = np.random.default_rng(4).standard_normal(2 + modes)
        assert_close(solve_chain(arrow, right), piston_motion.solve(known, right))


def in_order(now):
    """Return the places of today's coordinates: those of the crank's films come last."""
    return [*range(7), *range(11, len(now.position)), 7, 8, 9, 10]


def by_hand_with_films(piston, built, given):
    """Return bodies and films of all pins of one cylinder as today's equations take them."""
    crank = Crankshaft(True, True, CRANK_MASS, UNBALANCE)
    wrenches = (given.wrench[built.films[first]] for first in (2, 4, 7, 9))
    boss, eye, big_end, main = (PinResultants(w[:2], w[2], w[3]) for w in wrenches)
    none = np.zeros(0)
    films = PinFilms(boss, eye, np.zeros(len(piston.stiffness)), none, none, big_end, main)
    return PinBodies(piston, MECHANISM, SPIN_INERTIA, crank=crank), films


@pytest.mark.parametrize("modes", [0, 60])
def test_a_floating_pin_with_films_of_the_crank_is_the_one_by_hand(modes):
    """Residual, torque and tangent, plays by another rule of the integrator than the rest."""
    piston = flexible(modes)
    built = engine([piston], floating=True, crank_films=True)
    now = motion(built)
    given = loads(built, now)
    bodies, films = by_hand_with_films(piston, built, given)
    order = in_order(now)
    theirs = Motion(*(one[order] for one in now))
    load = on_piston(built, given, now)
    known = floating_pin.imbalance(bodies, load, theirs, CRANK, films)
    own = chain_forces(built.chain, given, now, CRANK, FIXED)
    assert_close(own.residual[order], known.residual)
    assert own.torque == pytest.approx(known.torque, rel=DIGITS)

    by = reach(len(order))
    held = [2, 3, 4, 5, *range(7, len(order))]
    by.velocity[held], by.position[held] = STEP, STEP**2
    slope = pin_tangent.tangent(
        bodies, load, theirs, films, known, by.velocity[order], by.position[order]
    )
    arrow = chain_tangent(built.chain, given, now, own, by)
    w, alpha = now.velocity[1], now.acceleration[1]
    coupling = mode_coupling(piston, alpha, w, by.velocity[-1], by.position[-1])
    for row, expected in zip(matrix(arrow, coupling)[np.ix_(order, order)], slope):
        assert_close(row, expected)


def matrix(arrow, coupling):
    return np.vstack([arrow.top, np.hstack([arrow.left, np.diag(arrow.diagonal) + coupling])])
