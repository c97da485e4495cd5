"""Floating-frame terms and the mechanism against independently differentiated energies."""

from functools import partial

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.pin_films import forces_of
from piston_cosim.fmu_mfbd.finite_elements.element import consistent_mass, stiffness
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED
from piston_cosim.fmu_mfbd.mechanism.chain import BLOCK
from piston_cosim.fmu_mfbd.mechanism.cylinder import motion_across
from piston_cosim.fmu_mfbd.mechanism.equations import chain_forces
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion, Prediction
from piston_cosim.fmu_mfbd.mechanism.loads import no_loads
from piston_cosim.fmu_mfbd.mechanism.motion import Increments
from piston_cosim.fmu_mfbd.mechanism.piston_motion import Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion, Mechanism
from piston_cosim.fmu_mfbd.mechanism.solution import (
    arrow_product,
    solve_motion,
)
from piston_cosim.fmu_mfbd.reduction.bases import Elastic, craig_bampton, orthonormal_modes
from piston_cosim.fmu_mfbd.reduction.frame_integrals import floating_frame_integrals
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedPiston
from piston_cosim.tests.verification.cases.bodies import (
    box_mesh,
    flexible_body,
    rigid_body,
)
from piston_cosim.tests.verification.cases.links import Link, chain_of, play
from piston_cosim.tests.verification.cases.tied import (
    tied_forces,
    tied_parts,
    tied_pin,
)

from .differences import lagrange


@pytest.fixture(scope="module")
def lump():
    """Return a compact body with all coupling terms nonzero.

    The result is (nodes, M, modes (n, 3, k), FlexibleBody).
    """
    points, tets = box_mesh((2, 2, 2), (0.04, 0.05, 0.03))
    points = points - [0.011, 0.017, 0.006]
    points = points + 0.04 * points[:, [1, 2, 0]]
    K, M = stiffness(points, tets, 7e10, 0.3), consistent_mass(points, tets, 2700.0)
    body = Elastic(K, M, np.flatnonzero(points[:, 1] < points[:, 1].min() + 5e-3))
    modes, omega = orthonormal_modes(body, craig_bampton(body, 5))
    modes = body.full(modes).reshape(len(points), 3, -1)
    integrals = floating_frame_integrals(M, points, modes)
    return points, M, modes, flexible_body(integrals, omega)


def test_integrals_about_a_moved_pin(lump):
    """Eq. (J45) against the integrals of the nodes seen from there: rounding of sums over them."""
    points, M, modes, _ = lump
    d = 1.3e-3
    begin, expected = (
        floating_frame_integrals(M, points - [shift, 0.0, 0.0], modes) for shift in (0.0, d)
    )
    rest = dict.fromkeys(("omega", "kind", "gas_force", "radial", "axial", "radius"))
    rest |= dict.fromkeys(("skirt_lower", "skirt_upper"))
    moved = ReducedPiston(**begin._asdict(), **rest, pin_offset=0.2e-3).about(0.2e-3 + d)
    for name, value in expected._asdict().items():
        np.testing.assert_allclose(getattr(moved, name), value, rtol=1e-11, atol=1e-14)
    assert moved.pin_offset == 0.2e-3 + d


def kinetic_energy(points, M, modes, coordinates, rates):
    """Return the kinetic energy from nodal velocities of the rotated, deformed body and the full M.

    It contains no floating-frame terms.
    """
    angle, q = coordinates[2], coordinates[3:]
    c, s = np.cos(angle), np.sin(angle)
    turn, spin = (
        np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
        np.array([[-s, -c, 0], [c, -s, 0], [0, 0, 0]]),
    )
    local = points + modes @ q
    velocity = (
        np.array([rates[0], rates[1], 0])
        + local @ (rates[2] * spin).T
        + (modes @ rates[3:]) @ turn.T
    )
    return 0.5 * velocity.ravel() @ (M @ velocity.ravel())


def test_frame_force_is_the_differentiated_lagrangian(lump):
    points, M, modes, body = lump
    rng = np.random.default_rng(3)
    k = modes.shape[2]
    z, r, a = (rng.standard_normal(3 + k) for _ in range(3))
    z[3:] *= 1e-3 / np.abs(modes).max()
    r, a = r * 10, a * 100
    scale = np.where(np.arange(3 + k) < 3, 1e-3, 1e-6)
    reference = lagrange(partial(kinetic_energy, points, M, modes), z, r, a, scale)
    chain = chain_of([Link(body, BLOCK, slides=play(0), angle=2)], coordinates=3)
    now, still = Motion(z, r, a), CrankMotion(0.0, 0.0, 0.0)
    force = chain_forces(chain, no_loads(chain), now, still, FIXED).residual
    force[3:] -= body.stiffness * z[3:]
    # round-off of the energy over changes of 1e-6: about 1e-9 of the largest term
    np.testing.assert_allclose(force, reference, atol=1e-7 * np.abs(reference).max())


def test_momentum_is_the_derivative_of_the_kinetic_energy(lump):
    """The energy is quadratic in the rates: e . M v = T(v + e) - T(v) - T(e) for each unit e."""
    points, M, modes, body = lump
    k = modes.shape[2]
    v = np.random.default_rng(6).standard_normal(2 + k)

    def energy(rates):
        return kinetic_energy(points, M, modes, np.zeros(3 + k), np.insert(rates, 1, 0.0))

    expected = [energy(v + e) - energy(v) - energy(e) for e in np.eye(2 + k)]
    alone = SKEW._replace(rod_mass=0.0, rod_inertia=0.0, pin_mass=0.0)
    inertia = motion_across(tied_parts(body, alone, 0.0), 0.0)
    # round-off of the differences
    np.testing.assert_allclose(arrow_product(inertia, v), expected, atol=1e-12 * energy(v))


def reach(n, c1, c2):
    """Return what an end acceleration of 1 adds to each of n velocities [s] and positions [s2]."""
    return Increments(np.full(n, c2), np.full(n, c1), np.ones(n))


SKEW = Mechanism(0.0288, 0.110, 0.0011, 0.35, 6e-4, 30 / 110, 0.06)


@pytest.mark.parametrize("step", [0.0, 5e-5])
def test_forces_that_cancel_exactly_give_a_piston_without_acceleration(step):
    """Film forces that balance the piston to the last digit leave only round-off of accelerations.

    At a start this is 1e-9 m/s2 and rad/s2, where each force alone gives 1e5. In a step it is 1e-8,
    the effect of the last digits of a position.
    """
    rng = np.random.default_rng(0)
    none = np.zeros(0)
    for k in range(100):
        body = rigid_body(0.315, (0.002 * (k % 2), 0.009 * (k % 3)), 3e-4)
        crank = CrankMotion(rng.uniform(0.0, 2 * np.pi), 314.0 * (k % 4), 0.0)
        position, velocity = rng.standard_normal((2, 2)) * [[3e-5, 1e-3], [0.1, 3.0]]
        gas = 2e4 * (k % 2)
        alone = Load(0.0, -gas, 0.0, gas, none)
        now = Motion(position, velocity, np.zeros(2))
        chain = tied_pin(body, SKEW, 0.0)
        lack = tied_forces(chain, alone, now, crank).residual
        held = alone._replace(lateral=lack[0], moment=lack[1])
        guess = rng.standard_normal(2) * [1e3, 1e4]
        start = Prediction(position, velocity, np.zeros(2))
        by = reach(2, step / 2, step**2 / 4)
        solution = solve_motion(chain, forces_of(chain, held), start, guess, by, crank, FIXED)
        assert solution.evaluations > 0
        assert np.abs(solution.now.acceleration).max() <= (1e-8 if step else 1e-9)
