"""The running model on small bodies: step map, work, symmetry, refusals."""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.assembly import assemble
from piston_cosim.fmu_mfbd.dynamics.model import Inputs, MotionNotSolved
from piston_cosim.fmu_mfbd.dynamics.parameters import Parameters
from piston_cosim.fmu_mfbd.dynamics.system import RingForce
from piston_cosim.fmu_mfbd.geometry.film import NodalForces, generalised, window_at
from piston_cosim.fmu_mfbd.mechanism.bdf2 import STATIC
from piston_cosim.fmu_mfbd.mechanism.piston_motion import ROCKING
from piston_cosim.fmu_mfbd.mechanism.slider_crank import height
from piston_cosim.fmu_mfbd.reduction.reduced_body import no_modes_in_motion

from .differences import products_by_differences, rough_change

SPEED = 314.0
STEP = np.pi / 180 / SPEED


def forces(model, seed=0, size=2.0):
    """Return a rough, one-sided pressure force and a friction force."""
    rng = np.random.default_rng(seed)
    bump = np.maximum(np.sin(model.film_surfaces[0].skirt.angle)[:, None] + 0.3, 0.0) * rng.random(
        model.film_surfaces[0].skirt.gap.shape
    )
    return size * bump, -0.1 * size * bump


def inputs(model, seed=0, gas=5e5, size=2.0):
    return Inputs(SPEED, gas, *forces(model, seed, size))


def run(model, steps=12, **given):
    state, out = model.start(0.3, 2e-6, 1e-4, inputs(model, size=0.0))
    for k in range(steps):
        state, out = model.advance(state, inputs(model, k, **given), STEP)
    return state, out


def test_the_first_two_steps_are_backward_euler(model):
    """Eq. (N8), of everything that has inertia; the third step is not."""
    before, _ = model.start(0.3, 2e-6, 1e-4, inputs(model, size=0.0))
    moving = model.system.kinds != STATIC
    apart = []
    for k in range(3):
        state, _ = model.advance(before, inputs(model, k), STEP)
        velocity = before.velocity + STEP * state.acceleration
        position = before.position + STEP * state.velocity
        sizes = np.abs(state.velocity[moving]).max(), np.abs(STEP * state.velocity[moving]).max()
        apart.append(
            max(
                np.abs(state.velocity - velocity)[moving].max() / sizes[0],
                np.abs(state.position - position)[moving].max() / sizes[1],
            )
        )
        before = state
    assert max(apart[:2]) < 1e-9 and apart[2] > 1e-3


@pytest.fixture
def rubbing(reduced):
    """As `model`, with friction at the pin."""
    return assembled(
        reduced, crank_offset=1e-3, pin_friction_coefficient=0.1, pin_friction_damping=1e-3
    )


def assembled(reduced, **values):
    """Return the small bodies with some parameters changed."""
    options, piston, block = reduced
    return assemble(piston, block, options, Parameters(**values))


@pytest.fixture
def followers(reduced):
    """As `model`, about half the modes of each body static."""
    return assembled(reduced, crank_offset=1e-3, quasi_static_frequency=22e3)


@pytest.mark.parametrize("which", ["model", "rubbing", "followers"])
def test_directional_derivative_against_differences(which, request):
    """The derivative agrees with central differences of the step.

    The step is smooth and nearly affine, so 1e-7 holds with unit changes.
    """
    model = request.getfixturevalue(which)
    state, _ = run(model)
    base = inputs(model, 50)
    base = dataclasses.replace(base, rings=RingForce(40.0, -60.0, 0.3))
    products_by_differences(model, state, base, rough_change(model, base), STEP, 1e-7)


@pytest.mark.parametrize("which", ["model", "followers"])
def test_work_is_the_same_on_the_grid_and_in_the_coordinates(which, request):
    model = request.getfixturevalue(which)
    for steps in (1, 5, 20):
        assert run(model, steps)[1]["interface_work_error"] <= 1e-13


def test_work_check_sees_a_wrong_transfer(model, monkeypatch):
    """The work check detects an error of one percent in the moment.

    The kernel runs as plain Python with a wrong transfer inside.
    """
    from piston_cosim.fmu_mfbd.dynamics import instant, skirt_films

    def wrong(*given):
        out = right(*given)
        out.push[ROCKING] *= 1.01
        return out

    right = skirt_films.generalised
    state, _ = run(model, 5)
    monkeypatch.setattr(
        "piston_cosim.fmu_mfbd.dynamics.step.end_of_step", instant.end_of_step.py_func
    )
    monkeypatch.setattr(instant, "forces_by_film", skirt_films.forces_by_film.py_func)
    assert model.advance(state, inputs(model, 9), STEP)[1]["interface_work_error"] <= 1e-13
    monkeypatch.setattr(skirt_films, "generalised", wrong)
    assert model.advance(state, inputs(model, 9), STEP)[1]["interface_work_error"] > 1e-7


def test_a_step_that_ends_nowhere_is_refused(model):
    state, _ = run(model, 1)
    with pytest.raises(MotionNotSolved, match="crank angle = inf rad: must be finite"):
        model.advance(state, inputs(model, 1), 1e308)


def test_non_finite_force_is_refused(model):
    state, _ = run(model, 2)
    F, f = forces(model)
    F[0, 0] = np.nan
    with pytest.raises(MotionNotSolved, match="piston motion at crank angle"):
        model.advance(state, Inputs(SPEED, 0.0, F, f), STEP)


def film_forces(model, state, at):
    """Generalised forces of the film, all coordinates [N], [N m], [kg^-1/2 N]."""
    system = model.system
    lever = height(system.mechanism, 0.0, state.crank_angle)
    (surface,) = model.film_surfaces
    skirt, bore = surface
    window = window_at(bore.lowest, bore.spacing, lever.height, skirt.height)
    nodal = NodalForces(at.pressure_force, at.friction_force)
    return generalised(skirt, bore, window, nodal).push


@pytest.mark.parametrize("which", ["model", "followers"])
@pytest.mark.parametrize("stop", [0.0, 10.0])
def test_energy_taken_is_work_and_what_integration_made(which, stop, request):
    """Eq. (D14): the energy gain is the film's work plus the energy error of the time integrator.

    The work follows the trapezoidal rule, across and along the film. The balance also holds in an
    impact (Eq. (N7)) and after it.

    stop : force in the seventh step over the earlier ones, against the motion.
    """
    model = request.getfixturevalue(which)
    state, out = model.start(0.3, 2e-6, 1e-4, inputs(model, size=0.0))
    assert out["received_power"] == 0.0
    push = film_forces(model, state, inputs(model, size=0.0))
    impacts = 0
    for k in range(12):
        given = inputs(model, k, size=-2.0 * stop if stop and k == 6 else 2.0)
        end, out = model.advance(state, given, STEP)
        push_then = film_forces(model, end, given)
        way = end.position - state.position
        along = STEP * out["film_power"] - push_then @ way
        work = (push + push_then) @ way / 2 + along
        # 1e-12 of the kinetic energy is what differences of it know
        small = 1e-10 * (abs(work) + out["kinetic_energy"])
        made = STEP * out["power_error"]
        assert STEP * out["received_power"] == pytest.approx(work + made, abs=small)
        impacts += k > 2 and bool(np.all(end.velocity[:2] == way[:2] / STEP))
        state, push = end, push_then
    assert (impacts > 0) == (stop > 0.0)


def test_what_nothing_moves_stays_at_rest(model):
    """All accelerations are zero, and so is what they are compared with."""
    nothing = np.zeros(model.film_surfaces[0].skirt.gap.shape)
    state, _ = model.start(0.0, 0.0, 0.0, Inputs(0.0, 0.0, nothing, nothing))
    for _ in range(2):
        state, _ = model.advance(state, Inputs(0.0, 0.0, nothing, nothing), STEP)
    assert not state.position.any() and not state.acceleration.any()


@pytest.mark.parametrize("coefficient", [0.0, 0.05])
def test_free_crank_keeps_the_energy(reduced, coefficient):
    """The kinetic energy of all parts plus the heat of pin friction is constant.

    The piston is rigid, without gas, load and film. The error falls with the step (order 2).
    """
    options, piston, block = reduced
    rigid = dataclasses.replace(piston, **no_modes_in_motion(len(piston.radial)))
    parameters = Parameters(
        crank_free=1,
        crank_inertia=2e-4,
        rod_mass=0.0,
        rod_inertia=0.0,
        pin_mass=0.4,
        pin_friction_coefficient=coefficient,
    )
    model = assemble(dataclasses.replace(rigid, S=0 * piston.S), block, options, parameters)
    nothing = np.zeros(model.film_surfaces[0].skirt.gap.shape)
    drift, swing = [], []
    for step in (2e-5, 1e-5):
        state, out = model.start(0.0, 0.0, 0.0, Inputs(200.0, 0.0, nothing, nothing))
        levels, speeds = [], []
        heat = 0.0
        for _ in range(int(0.01 / step)):
            power = out["pin_friction_power"]
            state, out = model.advance(state, Inputs(200.0, 0.0, nothing, nothing), step)
            heat += (power + out["pin_friction_power"]) / 2 * step
            mass = piston.mass + 0.4
            levels.append(
                0.5 * 2e-4 * state.crank_speed**2
                + 0.5 * mass * (out["piston_velocity"] ** 2 + state.velocity[0] ** 2)
                + 0.5 * piston.I0 * state.velocity[1] ** 2
                + heat
            )
            speeds.append(state.crank_speed)
        drift.append(np.abs(np.array(levels) / levels[0] - 1).max())
        swing.append(np.ptp(speeds))
    assert swing[1] > 50.0  # the crank really gives and takes
    assert (heat > 0.0) == (coefficient > 0.0)
    assert drift[1] < 2e-5 and drift[1] < 0.26 * drift[0]


@pytest.mark.parametrize("step", [1e-5, 2e-6, 1e-7])
def test_short_steps_at_rest_converge_within_the_round_off_of_positions(model, step):
    """Short steps at rest converge although accelerations are below the round-off of positions.

    The skirt is squeezed evenly on a crank that hardly turns. At rest its accelerations are smaller
    than the effect of the last digits of positions in a short step.
    """
    squeezed = Inputs(
        1e-6 * SPEED,
        0.0,
        np.full(model.film_surfaces[0].skirt.gap.shape, 10.0),
        np.zeros(model.film_surfaces[0].skirt.gap.shape),
    )
    state, _ = model.start(1.0, 0.0, 0.0, squeezed)
    for _ in range(300):
        state, _ = model.advance(state, squeezed, 1e-4)  # long steps calm the modes
    for _ in range(30):
        state, out = model.advance(state, squeezed, step)
    assert abs(out["film_thickness"] - model.film_surfaces[0].skirt.gap).max() > 1e-7
