"""A piston that moves in space.

Gap, forces and inertia are computed by hand. The piston in its plane is the symmetric case.
Other tests cover closed forms, derivatives, and a free body and a whole stroke against Newton
and Euler with large rotations.
"""

import dataclasses

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from piston_cosim.fmu_mfbd.build import prepare
from piston_cosim.fmu_mfbd.dynamics.assembly import ReducedBodies, assemble, model_of
from piston_cosim.fmu_mfbd.dynamics.build_options import (
    BlockOptions,
    BuildOptions,
    InSpace,
    PistonOptions,
)
from piston_cosim.fmu_mfbd.dynamics.model import Inputs
from piston_cosim.fmu_mfbd.dynamics.model_faults import faults
from piston_cosim.fmu_mfbd.dynamics.motion_in_space import (
    SpaceBodies,
    SpaceBody,
    SpaceLoad,
    Spin,
    Stop,
    imbalance,
    inertia,
    needed,
    stop_force,
    tangent,
)
from piston_cosim.fmu_mfbd.dynamics.parameters import SpaceParameters
from piston_cosim.fmu_mfbd.dynamics.skirt_films import window_of
from piston_cosim.fmu_mfbd.geometry.film import NodalForces
from piston_cosim.fmu_mfbd.geometry.profile import BoreOrder, fourier_bore
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.mechanism.pin_friction import PinFriction
from piston_cosim.fmu_mfbd.mechanism.piston_motion import Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion, Mechanism
from piston_cosim.fmu_mfbd.native import uncovered
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedPiston, load
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.tests.verification.cases.tied import tied_pin

from .chains import rigid
from .conftest import quiet, sheets
from .differences import products_by_differences, rough_change
from .pin_models import (
    CENTRE,
    GRID,
    OFFSET,
    PARAMETERS,
    SPEED,
    STEP,
    rough_inputs,
    rough_way,
)
from .pin_models import bodies as flat_bodies

MASS = 1.39
S = MASS * np.array([*CENTRE, 2e-3])
J = np.array([[4.1e-3, -2e-4, 3e-4], [-2e-4, 3.7e-3, -1.5e-4], [3e-4, -1.5e-4, 3.98e-3]])
SYMMETRIC = InSpace(0.0, np.diag([4.1e-3, 3.7e-3, 0.003 + MASS * float(CENTRE @ CENTRE)]))
SKEWED = InSpace(S[2], J)
NO_DAMPER = dict(pin_axial_damping=0.0, pin_tilt_damping=0.0)
RUBBING = dataclasses.replace(PARAMETERS, pin_friction_coefficient=0.02)


def options(space=None, orders=()):
    return BuildOptions(
        GRID, PistonOptions("", 0, OFFSET), BlockOptions("", 0, orders), in_space=space
    )


def space_model(space=SKEWED, orders=(), parameters=RUBBING, **own):
    own = [SpaceParameters(**own)]
    return model_of(flat_bodies(), options(space, orders), parameters, own)


def flat_model(orders=(), parameters=RUBBING):
    piston, block, *_ = flat_bodies()
    return assemble(piston, block, options(None, orders), parameters)


# ---- the film


def seen(model, coordinates, angle=0.7):
    """Film thickness at rest with the piston out of its plane by [z, roll, yaw]."""
    position = np.zeros(5)
    position[2:] = coordinates
    still = Inputs(0.0, 0.0, np.zeros(GRID), np.zeros(GRID))
    return model.start_moving(angle, position, np.zeros(5), still)[1]["film_thickness"]


def test_film_thickness_by_hand():
    """Shift and roll close the gap at +z, not at the thrust side; yaw moves A's offset of 1 mm.

    There are 16 cells around: cell 0 on +z, cell 4 on +x. Rows have their own heights from below.
    """
    model = space_model()
    at_rest = seen(model, [0, 0, 0])
    height = -45.5e-3 + 82.8e-3 * (np.arange(12) + 0.5) / 12
    shifted, rolled, yawed = (seen(model, 1e-3 * one) - at_rest for one in np.eye(3))
    half = np.sqrt(0.5)
    for cell, cosine in ((0, 1.0), (2, half), (4, 0.0), (8, -1.0), (14, half)):
        np.testing.assert_allclose(shifted[cell], -1e-3 * cosine, atol=1e-17)
        np.testing.assert_allclose(rolled[cell], -1e-3 * cosine * height, atol=1e-17)
        np.testing.assert_allclose(yawed[cell], -1e-6 * cosine, atol=1e-17)


def test_a_distorted_bore_makes_yaw_matter_by_hand():
    """Yaw in a bore with two lobes of 20 um, the first at 0.4 rad, changes the gap by dw/dtheta.

    At every height dw/dtheta = -2 20 um sin(2 (theta - 0.4)). The result is the bore read at theta
    + yaw, up to second order.
    """
    lobes = (BoreOrder(2, 20e-6, 0.4),)
    model = space_model(orders=lobes)
    theta = 2 * np.pi * np.arange(16) / 16
    yaw = 1e-3
    change = seen(model, [0, 0, yaw]) - seen(model, [0, 0, 0])
    wanted = -40e-6 * np.sin(2 * (theta - 0.4)) * yaw - OFFSET * yaw * np.cos(theta)
    np.testing.assert_allclose(change, np.repeat(wanted[:, None], 12, 1), atol=1e-15)
    read = [fourier_bore(lobes, theta + way) for way in (0.0, yaw)]
    np.testing.assert_allclose(
        read[1] - read[0], change[:, 0] + OFFSET * yaw * np.cos(theta), atol=20e-6 * 4 * yaw**2
    )


def test_sliding_velocity_by_hand():
    """Roll lifts the skirt at -z and lowers it at +z, by the skirt's radius."""
    model = space_model()
    still = Inputs(0.0, 0.0, np.zeros(GRID), np.zeros(GRID))
    velocity = np.array([0.0, 0.0, 3.0, 2.0, 5.0])
    _, out = model.start_moving(0.7, np.zeros(5), velocity, still)
    cosine = np.cos(2 * np.pi * np.arange(16) / 16)
    wanted = np.repeat(-2.0 * 55e-3 * cosine[:, None], 12, 1)
    np.testing.assert_allclose(out["sliding_velocity"], wanted, atol=1e-15)


def test_forces_are_the_transpose_of_gap_and_sliding():
    """In a bore with lobes that change with height, random fields: to round-off."""
    rng = np.random.default_rng(5)
    model = space_model(orders=(BoreOrder(2, 30e-6, 0.4), BoreOrder(3, 10e-6, 1.0)))
    (side,) = model._levers(0.28)
    push, drag = rng.standard_normal((2, *GRID))
    way = rng.standard_normal(3)
    power = (push * side.opening(way) + drag * side.sliding * way[1]).sum()
    assert side.forces(NodalForces(push, drag)) @ way == pytest.approx(power, rel=1e-12)
    assert window_of(model.film_surfaces[0], 0.28).knots > 4


# ---- stops


def test_a_stop_by_hand():
    """3, 4 from the middle: 5 away, 2 beyond the play, along (0.6, 0.8); the damper always."""
    stop = Stop(3.0, 10.0, 0.5)
    found = stop_force(stop, np.array([3.0, 4.0]), np.array([1.0, -2.0]))
    np.testing.assert_allclose(found, [12.5, 15.0])
    within = stop_force(stop, np.array([1.0, 2.0]), np.array([1.0, -2.0]))
    np.testing.assert_allclose(within, [0.5, -1.0])
    np.testing.assert_allclose(stop_force(Stop(0.0, 4.0, 0.0), np.zeros(2), np.zeros(2)), 0.0)


# ---- inertia


def test_inertia_matrix_is_the_kinetic_energy():
    """Of points: eight masses with the sum, first moment and tensor that they have."""
    rng = np.random.default_rng(9)
    points, masses = rng.standard_normal((8, 3)), rng.random(8)
    first = masses @ points
    tensor = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, points))
    mechanism = Mechanism(0.07, 0.22, 0.0, 1.0, 0.01, 0.3, 0.7)
    body = SpaceBody(float(masses.sum()), first, tensor)
    stop = Stop(0.0, 0.0, 0.0)
    M = inertia(SpaceBodies(body, plane_of(mechanism), 0.7, 0.2, 0.0, 0.0, stop, stop))
    q = rng.standard_normal(5)
    V, W = np.array([q[0], 0.0, q[2]]), np.array([q[3], q[4], q[1]])
    energy = sum(m * np.sum((V + np.cross(W, r)) ** 2) for m, r in zip(masses, points))
    energy += 0.7 * V @ V + 0.2 * (q[3] ** 2 + q[4] ** 2)
    assert q @ M @ q == pytest.approx(energy, rel=1e-12)


# ---- equations of motion


def test_an_instant_by_hand():
    """Forces of an instant agree with hand calculations.

    The crank is at rest at the top. The piston is shifted by 10 um, rolled by 1 mrad and yawed by 2
    mrad, without motion. Gas gives 20 kN, the film 3 kN upwards. The rod carries 17 kN, square to a
    pin that leans. This gives 17 N along z, where gas gives 20 N with its crown. The lateral 4 kN
    give 8 N along z by yaw. About A the rod has a lever of 10 um. Gas on the bore's axis has the
    same lever, and 1 mm in x.
    """
    model = space_model(SYMMETRIC, pin_axial_play=8e-6, pin_axial_stiffness=1e6, pin_tilt_play=1.0)
    position = np.array([0.0, 0.0, 10e-6, 1e-3, 2e-3])
    now = Motion(position, np.zeros(5), np.zeros(5))
    load = SpaceLoad(Load(4e3, 3e3 - 20e3, 0.0, 20e3, np.zeros(0)), np.array([0.5, 0.25, 0.125]))
    bodies = model.bodies._replace(chain=plane_of(model.system.mechanism._replace(offset=0.0)))
    lack = imbalance(bodies, load, now, CrankMotion(0.0, 0.0, 0.0))
    np.testing.assert_allclose(lack.from_rod, [-4e3, 17e3], rtol=1e-12)
    wanted = [-17.0 + 20.0 - 8.0 - 0.5 + 2.0, 10e-6 * 3e3 - 0.25, -10e-6 * 4e3 + 20e-3 - 0.125]
    np.testing.assert_allclose(lack.residual[2:], wanted, rtol=1e-9)
    np.testing.assert_allclose(lack.out_of_plane, [-2.0, 0.0, 0.0], atol=1e-9)


MIRRORED = (8 - np.arange(16)) % 16
"""Cells around, mirrored about the plane of the crank, z = 0: theta -> pi - theta."""


def even_inputs(model, seed):
    """Rough forces that are even about the plane of the crank."""
    rough = rough_inputs(model, seed)
    push, drag = ((f + f[MIRRORED]) / 2 for f in (rough.pressure_force, rough.friction_force))
    return dataclasses.replace(rough, pressure_force=push, friction_force=drag)


COUNTS = {"residual_evaluations", "jacobian_evaluations", "interface_work_error"}
"""Outputs that follow the solver and round-off."""


def test_symmetric_loads_give_the_piston_in_its_plane():
    """In 40 steps under rough even forces every output is that of the plane piston.

    The bore has lobes and widens upwards.
    The difference is round-off of both solvers, 1e-9 of its size: accelerations are solved to
    1e-11, and steps add up. Motion across the plane is only the round-off of sums over the grid,
    1e-14 of the forces.
    """
    lobes = (BoreOrder(2, 20e-6, 0.0),)
    tapered = dataclasses.replace(RUBBING, bore_growth_upper=20e-6)
    flat, space = flat_model(lobes, tapered), space_model(SYMMETRIC, lobes, tapered)
    ends = [one.start(0.3, 2e-6, 1e-4, even_inputs(one, 0)) for one in (flat, space)]
    most = np.zeros(3)
    for k in range(40):
        ends = [
            model.advance(state, even_inputs(model, k), STEP)
            for model, (state, _) in zip((flat, space), ends)
        ]
        most = np.maximum(most, np.abs(ends[1][0].position[2:]))
        for name in ends[0][1].keys() - COUNTS:
            one, other = (np.asarray(out[name]) for _, out in ends)
            np.testing.assert_allclose(
                other, one, rtol=1e-9, atol=1e-9 * np.abs(one).max(), err_msg=name
            )
    assert most.max() < 1e-14


@pytest.mark.parametrize("steps", [1, 6])
def test_derivative_against_differences(steps):
    """The derivative of a step agrees with central differences in a bore with lobes.

    The step is tested with and without backward Euler. The tolerance is 1e-6, as the step is not
    quite affine.
    """
    model = space_model(orders=(BoreOrder(2, 20e-6, 0.4),), pin_tilt_play=0.0)
    state, _ = rough_way(model, steps)
    base = rough_inputs(model, 50)
    products_by_differences(model, state, base, rough_change(model, base), STEP, 1e-6)


def test_power_on_the_grid_is_that_in_the_coordinates():
    """In a bore with lobes and under rough forces, to round-off, and not by being nothing."""
    model = space_model(orders=(BoreOrder(2, 20e-6, 0.4),))
    state, out = rough_way(model, 6)
    assert out["interface_work_error"] < 1e-14
    assert np.abs(state.velocity[2:]).min() > 1e-5


# ---- closed forms


def standing(parameters=PARAMETERS, space=SYMMETRIC, **own):
    """Return a model whose crank is at rest at the top, without friction of the pin."""
    return space_model(space, parameters=parameters, **own)


def test_a_quarter_turn_makes_shift_and_roll_of_lateral_motion():
    """A hit at +z shifts and rolls the piston as a hit at +x moves and rocks it.

    The piston is the same across x and z, the rod has no mass, and the crank is at the top. The hit
    is an impact, whose end velocity is the mean velocity. The slant x/L = 1e-4 of the rod changes
    the displacement by a share of its square.
    """
    alike = dataclasses.replace(PARAMETERS, rod_mass=0.0, rod_inertia=0.0, crank_offset=0.0)
    piston, *rest = flat_bodies()
    piston = dataclasses.replace(piston, S=MASS * np.array([0.0, CENTRE[1]]), I0=4.5e-3)
    pin = 0.5 * (0.018**2 / 4 + (1.5 * 54.95e-3) ** 2 / 12)
    given = dataclasses.replace(
        options(InSpace(0.0, np.diag([4.5e-3 - pin, 4e-3, 4.5e-3]))),
        piston=PistonOptions("", 0, 0.0),
    )
    own = [SpaceParameters(**NO_DAMPER, pin_tilt_play=1.0, pin_axial_play=1.0)]
    step = 1e-4
    ways = []
    for cell, way in ((4, [0, 1]), (0, [2, 3])):
        model = model_of(ReducedBodies(piston, *rest), given, alike, own)
        velocity = np.zeros(5)
        velocity[way] = 0.1, 0.0
        none, hit = np.zeros(GRID), np.zeros(GRID)
        hit[cell, 4:9] = [500.0, 900.0, 700.0, 800.0, 400.0]
        state, _ = model.start_moving(0.0, np.zeros(5), velocity, Inputs(0.0, 0.0, none, none))
        ways.append([])
        for push in (none, none, none, hit, none, hit / 9):
            before = state
            state, _ = model.advance(state, Inputs(0.0, 0.0, push, none), step)
            ways[-1].append([*state.position[way], *state.velocity[way]])
            if push is hit:
                mean = (state.position - before.position)[way] / step
                np.testing.assert_allclose(state.velocity[way], mean, rtol=1e-9)
    flat, across = np.array(ways)
    across[:, 1::2] *= -1.0
    np.testing.assert_allclose(across, flat, rtol=1e-6, atol=1e-7)


# ---- against points of mass in space


class Points:
    """Piston, pin and rod as mass points on a crank at constant speed, with large rotations.

    The equations follow d'Alembert's principle. The coordinates are q = (x of the eye, rocking
    angle, displacement along the pin, roll, yaw). Rotations are about z, then x, then y. The pin's
    axis passes through the eye. Derivatives of positions use complex steps, those of velocities
    central differences. This class uses nothing of the package.
    """

    def __init__(self, size):
        rng = np.random.default_rng(11)
        # even about x = 0 and z = 0 but for a share `size` of skewness
        points = np.array([[x, y, z] for x in (1, -1) for y in (0.5, 1.6) for z in (1, -1)])
        self.points = points * [40e-3, 25e-3, 36e-3] + size * 3e-3 * rng.standard_normal((8, 3))
        self.masses = np.full(8, MASS / 8)
        self.pin = np.array([[0, 0, 30e-3], [0, 0, -30e-3]])
        self.offset = size * 0.1
        self.stiffness = 2e4
        self.gas = 2e3
        # four forces at the skirt, N at (theta, height): along the bore's normal and the axis
        self.theta = 2 * np.pi * np.array([0, 3, 9, 13]) / 16
        self.height = -45.5e-3 + 82.8e-3 * (np.array([2, 9, 4, 7]) + 0.5) / 12
        self.push = 4e3 * size * np.array([0.7, 0.2, 1.0, 0.4])
        self.drag = 1e3 * size * np.array([0.3, -0.5, 0.8, 0.6])

    def frame(self, q, t):
        """Return A and the body's axes, as columns in space."""
        r, L, phi = PARAMETERS.crank_radius, PARAMETERS.rod_length, SPEED * t
        xi = q[0] + r * np.sin(phi)
        eye = np.array([q[0], r * np.cos(phi) + np.sqrt(L**2 - xi**2), 0 * q[0]])
        c, s = np.cos(q), np.sin(q)
        about_z = np.array([[c[1], -s[1], 0], [s[1], c[1], 0], [0, 0, 1]])
        about_x = np.array([[1, 0, 0], [0, c[3], -s[3]], [0, s[3], c[3]]])
        about_y = np.array([[c[4], 0, s[4]], [0, 1, 0], [-s[4], 0, c[4]]])
        axes = about_z @ about_x @ about_y
        return eye + q[2] * axes[:, 2], axes

    def rod(self, q, t):
        """Two points with the rod's mass, centre and inertia."""
        r, L, phi = PARAMETERS.crank_radius, PARAMETERS.rod_length, SPEED * t
        crank = np.array([-r * np.sin(phi), r * np.cos(phi), 0.0])
        xi = q[0] + r * np.sin(phi)
        along = np.array([xi, np.sqrt(L**2 - xi**2), 0 * xi]) / L
        half = np.sqrt(0.017 / 1.7)
        return [crank + (72e-3 + s * half) * along for s in (1, -1)]

    def all(self, q, t):
        """All points of mass, and where they are pushed, (n, 3)."""
        A, axes = self.frame(q, t)
        skirt = [A + axes @ b for b in self.pushed_at]
        body = [A + axes @ b for b in (*self.points, *self.pin)]
        return np.array([*body, *self.rod(q, t), *skirt, A + axes @ self.gas_at])

    def velocity(self, q, dq, t):
        h = 1e-30
        return np.imag(self.all(q + 1j * h * dq, t + 1j * h)) / h

    def rates(self, t, state):
        q, dq = state[:5], state[5:]
        normal = np.array([np.sin(self.theta), 0 * self.theta, np.cos(self.theta)]).T
        self.pushed_at = 55e-3 * normal - np.array([self.offset, 0, 0])
        self.pushed_at[:, 1] += self.height
        A, axes = self.frame(q, t)
        # the material point that is on the bore's axis now
        self.gas_at = axes.T @ (np.array([-self.offset, A[1], 0.0]) - A)
        masses = np.array([*self.masses, 0.25, 0.25, 0.85, 0.85, *[0.0] * 5])[:, None]
        ways = [np.imag(self.all(q + 1e-30j * one, t)) / 1e-30 for one in np.eye(5)]
        h = 1e-6
        bias = self.velocity(q + h * dq, dq, t + h) - self.velocity(q - h * dq, dq, t - h)
        force = -masses * bias / (2 * h)
        force[-5:-1] += -self.push[:, None] * normal
        force[-5:-1, 1] += self.drag
        force[-1] -= self.gas * np.array([0.0, 1.0, axes[2, 1]])  # leans with the crown
        M = [[np.sum(masses * a * b) for a in ways] for b in ways]
        Q = np.array([np.sum(force * a) for a in ways])
        # the eye's spring on the angle between pin and z
        h = 1e-5
        Q -= [(self.held(q + h * e, t) - self.held(q - h * e, t)) / (2 * h) for e in np.eye(5)]
        return np.concatenate([dq, np.linalg.solve(M, Q)])

    def held(self, q, t):
        """Energy of the eye's spring [J]."""
        x, y, _ = self.frame(q, t)[1][:, 2]
        return self.stiffness * np.arcsin(np.hypot(x, y)) ** 2 / 2

    def of_A(self, q, t):
        """[x_A, rocking angle, z, roll, yaw] as the model has them."""
        A, axes = self.frame(q, t)
        turn = Rotation.from_euler("z", -q[1]).as_matrix() @ axes
        roll, yaw, _ = Rotation.from_matrix(turn).as_rotvec()
        return np.array([A[0], q[1], A[2], roll, yaw])


TIMES = np.linspace(0.0, 1e-3, 6)


def start_of(size):
    return size * np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 2.0, 4.0, 60.0, -40.0])


def plane_of(mechanism):
    """Return the chain of crank, rod and pin with a piston without inertia."""
    return tied_pin(rigid(0.0), mechanism, 0.0)


def space_bodies(of, offset=0.0):
    """Return the model's bodies for the same points, with the cylinder beside the crank axis."""
    points, masses = of.points, of.masses
    tensor = sum(m * (r @ r * np.eye(3) - np.outer(r, r)) for m, r in zip(masses, points))
    friction = PinFriction(0.0, 1.0, 0.0)
    mechanism = Mechanism(72e-3, 223e-3, offset, 1.7, 0.017, 72 / 223, 0.5, friction)
    pin = 0.5 * 30e-3**2
    stop = Stop(0.0, of.stiffness, 0.0)
    body = SpaceBody(MASS, masses @ points, tensor)
    free = Stop(0.0, 0.0, 0.0)
    return SpaceBodies(body, plane_of(mechanism), 0.5, pin, 0.0, of.offset, free, stop)


def load_on(of):
    """Resultants of the points' forces about A, x_A = z = 0."""
    normal = np.array([np.sin(of.theta), 0 * of.theta, np.cos(of.theta)]).T
    arm = 55e-3 * normal - np.array([of.offset, 0, 0])
    arm[:, 1] += of.height
    force = -of.push[:, None] * normal
    force[:, 1] += of.drag
    x, y, z = force.sum(0)
    roll, yaw, turn = np.cross(arm, force).sum(0)
    plane = Load(x, y - of.gas, turn + of.offset * of.gas, of.gas, np.zeros(0))
    return SpaceLoad(plane, np.array([z, roll, yaw]))


def points_motion(of, size):
    """Coordinates at all times, (times, 5)."""
    found = solve_ivp(of.rates, TIMES[[0, -1]], start_of(size), t_eval=TIMES, rtol=1e-8, atol=1e-12)
    return np.array([of.of_A(q, t) for q, t in zip(found.y[:5].T, TIMES)])


def own_motion(of, size):
    """Integrate the package's equations of motion with the same precision."""
    bodies = space_bodies(of)
    load = load_on(of)

    def rates(t, state):
        now = Motion(state[:5], state[5:], np.zeros(5))
        crank = CrankMotion(SPEED * t, SPEED, 0.0)
        lack = imbalance(bodies, load, now, crank).residual
        slope = tangent(bodies, load, now, crank, 0.0, 0.0)
        return np.concatenate([state[5:], -np.linalg.solve(slope, lack)])

    found = solve_ivp(rates, TIMES[[0, -1]], start_of(size), t_eval=TIMES, rtol=1e-8, atol=1e-12)
    return found.y[:5].T


def test_motion_against_points_in_space():
    """The error of first-order equations falls to a quarter if skewness, tilt and shift are halved.

    A skewed piston, off its axis, moves for 10 deg of a turning crank. Gas and forces at four
    points of its skirt act on it. At a roll of 0.5 mrad the error is 0.3 urad.
    """
    apart = []
    sizes = (4e-2, 2e-2)
    for size in sizes:
        of = Points(size)
        wanted = points_motion(of, size)
        own = own_motion(of, size)
        apart.append(np.abs(own - wanted).max(axis=0))
        print(f"{size:.0e}: way {np.abs(wanted).max(axis=0)}, apart {apart[-1]}")
    assert np.abs(wanted[-1][2:]).min() > 5e-5  # it does go somewhere
    np.testing.assert_allclose(apart[0] / apart[1], 4.0, atol=0.2)
    assert (apart[1] < 2e-3 * np.abs(wanted).max(axis=0)).all()


# ---- build


def sheet(**space):
    """Build table of a data sheet; `None` leaves a key out."""
    moments = {"inertia_x": "0.0033 kg*m^2", "inertia_y": "0.0029 kg*m^2"} | space
    moments = {key: value for key, value in moments.items() if value is not None}
    return sheets(piston={"pin_offset": "2.5 mm"}, motion_in_space=moments)


@pytest.fixture
def cached(tmp_path, monkeypatch):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path))


def test_a_data_sheet_by_hand(cached, tmp_path):
    """Centre of mass at (-1, 26.5, 2) mm from A."""
    given = sheet(centre_z="2 mm")
    content, _ = prepare(given, tmp_path, quiet)
    space = BuildOptions.from_json(content).in_space
    assert space.first_moment_z == pytest.approx(1.39 * 2e-3)
    x, y, z = -1e-3, 26.5e-3, 2e-3
    xy, yz, zx = 1.39 * x * y, 1.39 * y * z, 1.39 * z * x
    wanted = [
        [0.0033 + 1.39 * (y * y + z * z), -xy, -zx],
        [-xy, 0.0029 + 1.39 * (z * z + x * x), -yz],
        [-zx, -yz, 0.003 + 1.39 * (x * x + y * y)],
    ]
    np.testing.assert_allclose(space.inertia, wanted, rtol=1e-12)
    assert (
        "in_space"
        not in BuildOptions.from_json(
            {key: value for key, value in content.items() if key != "in_space"}
        ).to_json()
    )


def test_a_mesh_says_its_inertia_itself(coarse, cached):
    """The tensor from a mesh has the same moment about z as in the plane.

    A tube that is its own mirror image has no products of inertia, except from its offset pin.
    """
    folder, table = coarse
    rigid = {name: table[name] | {"modes": 0} for name in ("piston", "block")}
    content, files = prepare(table | rigid | {"motion_in_space": {}}, folder, quiet)
    space = BuildOptions.from_json(content).in_space
    piston = load(ReducedPiston, files[0])
    assert space.inertia[2, 2] == pytest.approx(piston.I0, rel=1e-9)
    assert np.abs(space.inertia - np.diag(np.diag(space.inertia))).max() < 1e-6 * piston.I0
    assert abs(space.first_moment_z) < 1e-9 * piston.mass


def refused(table, folder):
    with pytest.raises(BadInput) as caught:
        prepare(table, folder, quiet)
    return "; ".join(caught.value.faults)


def test_what_cannot_move_in_space_is_refused(coarse, cached, tmp_path):
    """Every fault in one sentence, with values and what is allowed."""
    pin = {"boss_length": "25 mm", "small_end_length": "36 mm"}
    told = refused(sheet(inertia_y=None) | {"mounted": True, "start": "here.npz"}, tmp_path)
    for words in (
        "mounted: expected nothing with motion_in_space, got",
        "start: expected nothing with motion_in_space, got",
        "motion_in_space.inertia_y: expected a value with a rigid piston, got nothing",
    ):
        assert words in told
    told = refused(sheet() | {"floating_pin": pin}, tmp_path)
    assert "floating_pin: expected nothing with motion_in_space, got" in told
    told = refused(sheet(inertia_x="0.02 kg*m^2"), tmp_path)
    assert "each at most the sum of the others, got 0.0029, 0.003, 0.02 kg.m2" in told
    folder, table = coarse
    told = refused(table | {"motion_in_space": {"centre_z": "1 mm"}}, folder)
    for words in (
        "piston.modes: expected 0 or a rigid piston with motion_in_space, got",
        "block.modes: expected 0 or a rigid block with motion_in_space, got",
        "motion_in_space.centre_z: expected nothing with a mesh, got a value",
    ):
        assert words in told
    rigid = table | {name: table[name] | {"modes": 0} for name in ("piston", "block")}
    _, files = prepare(rigid, folder, quiet)
    slim = rigid | {"piston": {"reduced": str(files[0]), "modes": 0}, "motion_in_space": {}}
    assert "piston.reduced: expected rigid_mass, angles, skirt" in refused(slim, folder)


def test_a_native_fmu_refuses_it():
    for given in ({"motion_in_space": {}}, {"in_space": {"first_moment_z": 0.0}}):
        (told,) = uncovered(given)
        assert told.endswith("expected nothing in a native FMU, got a motion in space")
    assert list(uncovered({"mounted": False, "film_surfaces": [], "speed": None})) == []


def test_a_free_crank_is_refused_beside_it():
    free_crank = dataclasses.replace(PARAMETERS, crank_free=1)
    (told,) = faults(flat_bodies(), options(SKEWED), free_crank)
    assert told == "crank_free: expected 0 with motion in space, got 1"


def test_a_held_tilt_is_where_roll_counts_from():
    """`pin_tilt` turns pin and piston; the eye holds them there, and the output tells all of it."""
    tilted = dataclasses.replace(RUBBING, pin_tilt=3e-4)
    still = Inputs(0.0, 0.0, np.zeros(GRID), np.zeros(GRID))
    model = space_model(SYMMETRIC, parameters=tilted)
    _, out = model.start(0.3, 0.0, 0.0, still)
    assert out["roll_angle"] == 3e-4
    assert out["rod_moment_x"] == 0.0
    rolled = np.array([0.0, 0.0, 0.0, 3e-4, 0.0])
    gaps = []
    for parameters, at in ((tilted, 0 * rolled), (RUBBING, rolled)):
        one = space_model(SYMMETRIC, parameters=parameters)
        gaps.append(one.start_moving(0.3, at, 0 * at, still)[1]["film_thickness"])
    np.testing.assert_allclose(gaps[0], gaps[1], atol=1e-18)


def exact_needed(acceleration, axes, omega, change):
    """Return force and moment by Newton and Euler, for axes (3, 3) of any rotation."""
    first = axes @ S
    tensor = axes @ J @ axes.T
    force = MASS * acceleration + np.cross(change, first)
    force = force + np.cross(omega, np.cross(omega, first))
    moment = np.cross(first, acceleration) + tensor @ change
    return force, moment + np.cross(omega, tensor @ omega)


def test_inertia_forces_against_large_rotations():
    """The same motion by rotation matrices: what is left falls with the square of the tilt."""
    rng = np.random.default_rng(2)
    acceleration, w, change = rng.standard_normal((3, 3))
    body = SpaceBody(MASS, S, J)
    apart = []
    for size in (1e-2, 1e-3):
        t = size * np.array([0.6, -0.8, 0.0])
        found = needed(body, Spin(acceleration, t, w, change))
        wanted = exact_needed(acceleration, Rotation.from_rotvec(t).as_matrix(), w, change)
        apart.append([np.abs(a - b).max() for a, b in zip(found, wanted)])
    ratio = np.array(apart[0]) / apart[1]
    assert (np.abs(ratio - 100) < 3).all()


def test_energy_of_the_body_closes():
    """The gain of kinetic and spring energy of the body is the work of constant film forces.

    The crank is at rest, the eye is a spring and there are no dampers. The trapezoidal rule is
    used. Equations of first order leave 1e-4.
    """
    keeping = dataclasses.replace(PARAMETERS, spectral_radius=1.0)
    model = standing(keeping, **NO_DAMPER, pin_tilt_play=0.0)
    push = np.zeros(GRID)
    push[[1, 6, 11], [3, 9, 6]] = 30.0, 20.0, 50.0
    given = Inputs(0.0, 0.0, push, np.zeros(GRID))
    state, _ = model.start(0.0, 0.0, 0.0, given)
    for _ in range(2):
        state, out = model.advance(state, given, 1e-6)

    def held(out):
        spring = 3e4 * (out["roll_angle"] ** 2 + out["yaw_angle"] ** 2) / 2
        rod = (72 / 223) ** 2 * 1.7 + 0.017 / 0.223**2
        return out["kinetic_energy"] + spring + rod * out["lateral_velocity"] ** 2 / 2

    begun, work, gain = held(out), 0.0, 0.0
    for _ in range(200):
        state, out = model.advance(state, given, 2e-6)
        work += 2e-6 * out["film_power"]
        gain += 2e-6 * out["received_power"]
    assert held(out) - begun == pytest.approx(work, rel=1e-4)
    assert gain == pytest.approx(work, rel=1e-4)
