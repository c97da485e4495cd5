"""A piston on a floating pin.

Tests cover an instant by hand, springs of modes, derivatives and works. `test_multibody` compares
motions and forces.
"""

import dataclasses

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.model_faults import faults
from piston_cosim.fmu_mfbd.dynamics.pin_shells import shell_modes_of
from piston_cosim.fmu_mfbd.geometry.pin import (
    PARALLEL,
    PIN_SURFACES,
    ModeMotion,
    PinForces,
    PinResultants,
    diameters,
    opening_of,
    pin_surface,
    power_on_grid,
    resultants_on,
    shell_modes,
    shell_pushes,
    turned,
    yielded,
)
from piston_cosim.fmu_mfbd.mechanism.carrier import FIXED
from piston_cosim.fmu_mfbd.mechanism.cylinder import COORDINATES, EYE, PIN, piston_of
from piston_cosim.fmu_mfbd.mechanism.equations import chain_forces
from piston_cosim.fmu_mfbd.mechanism.generalised_alpha import Motion
from piston_cosim.fmu_mfbd.mechanism.inertia import frame_state
from piston_cosim.fmu_mfbd.mechanism.loads import no_loads
from piston_cosim.fmu_mfbd.mechanism.piston_motion import LATERAL, ROCKING, Load
from piston_cosim.fmu_mfbd.mechanism.slider_crank import CrankMotion

from .chains import loads_of, matrix_of
from .differences import products_by_differences, rough_change
from .pin_models import (
    GRIDS,
    MODELS,
    MODES,
    OWN,
    PARAMETERS,
    RADII,
    STEP,
    bodies,
    crank_model,
    floating_model,
    options,
    rough_inputs,
    rough_way,
    shells_of,
    small_end,
    yielding_bodies,
    yielding_model,
)


def test_film_thickness_and_forces_by_hand():
    """Four cells around in a shell turned by 90 deg give the gaps and forces computed by hand.

    The shell's own +x is +y in space. The pin is 3 um above the shell's axis and 1 um left of it.
    These are 3 um along the shell's +x and 1 um along its +y.
    """
    surface = pin_surface(0.02, 10e-6, (4, 1))
    axes = turned(np.pi / 2)
    place = np.array([-1e-6, 3e-6])
    gap = surface.clearance + opening_of(surface, axes.T @ place)
    np.testing.assert_allclose(gap[:, 0], [7e-6, 9e-6, 13e-6, 11e-6], rtol=1e-12)
    # 5 N on the first cell push against the shell's +x: downwards in space; 2 N of friction there
    # act along its +y, to the left; friction on all four cancels but in its moment
    push = np.zeros((4, 1))
    push[0] = 5.0
    drag = np.full((4, 1), 0.5)
    drag[0] += 2.0
    found = resultants_on(surface, PinForces(push, drag), place, axes)
    np.testing.assert_allclose(found.force, [-2.0, -5.0], atol=1e-15)
    assert found.on_shell == pytest.approx(-0.02 * 4.0, rel=1e-14)
    # lever: d x F = (-1e-6)(-5) - (3e-6)(-2) = 11e-6
    assert found.on_pin == pytest.approx(0.08 - 11e-6, rel=1e-12)


def test_a_shell_that_yields_by_hand():
    """One mode u_e = 2 cos 2a q on eight cells around opens, closes and turns as computed by hand.

    The shell opens by 2 q at a = 0 and closes by 2 q at 90 deg. Its slope at 45 deg is -4 sin 90
    deg q, so pressure there turns the pin. Central differences of cos 2a on eight cells have the
    factor sin(2 step)/step instead of 2.
    """
    a = np.pi / 4 * np.arange(8)
    modes = shell_modes(2 * np.cos(2 * a)[:, None, None], np.sin(a)[:, None, None])
    surface = pin_surface(0.02, 10e-6, (8, 1), modes)
    q = np.array([3e-6])
    np.testing.assert_allclose(
        yielded(surface, q)[:, 0], [6e-6, 0, -6e-6, 0, 6e-6, 0, -6e-6, 0], atol=1e-20
    )
    push, drag = np.zeros((8, 1)), np.zeros((8, 1))
    push[1], drag[2] = 7.0, 5.0
    forces = PinForces(push, drag)
    on_modes, slopes = shell_pushes(surface, forces)
    np.testing.assert_allclose(slopes, [-7.0 * 2 * 4 / np.pi], rtol=1e-12)
    # pressure stands where the mode has no displacement, friction acts against u_t = sin 90 deg
    np.testing.assert_allclose(on_modes, [-5.0], atol=1e-14)
    none, straight = np.zeros(2), ModeMotion(PARALLEL, PARALLEL)
    opened = yielded(surface, q)
    still = power_on_grid(surface, forces, none, none, 30.0, opened, 0 * q, straight)
    turned_by = -7.0 * 2 * 4 / np.pi * 3e-6 * 30.0
    assert still[0] == pytest.approx(turned_by + 5.0 * 0.02 * 30.0, rel=1e-12)
    moving = power_on_grid(surface, forces, none, none, 0.0, opened, q, straight)
    assert moving[0] == pytest.approx(-5.0 * 3e-6, rel=1e-12)


def test_rows_of_shapes_and_shells_by_hand():
    """Rows of modes follow Eq. (D40), and other rows are those of a rigid pin in rigid shells.

    The shape has 7 rad2/s2 and 2 rad/s along both axes.
    """
    plain = floating_model().chain
    springs = [7.0, 7.0, 7.0, 11.0], [2.0, 2.0, 2.0, 0.5]
    stiffness, damping = map(np.array, springs)
    own = plain._replace(bodies=plain.bodies._replace(stiffness=stiffness, damping=damping))
    rng = np.random.default_rng(2)
    now = Motion(*(1e-3 * rng.standard_normal((3, COORDINATES + 4))))
    rigid = Motion(*(one[:COORDINATES] for one in now))
    crank = CrankMotion(0.7, 100.0, 0.0)
    load = Load(lateral=11.0, axial=-900.0, moment=1.5, axis_force=800.0, modal=np.zeros(0))
    films = [PinResultants(rng.standard_normal(2), 0.2, -0.3) for _ in range(2)]
    push = np.array([5.0, -4.0, 5.0, -4.0])
    loads = loads_of(plain, load, now, films)
    found = chain_forces(own, loads._replace(modal=push), now, crank, FIXED)
    without = chain_forces(plain, loads, rigid, crank, FIXED)
    assert np.array_equal(found.residual[:COORDINATES], without.residual)
    s, v, a = (one[COORDINATES:] for one in now)
    wanted = a + v * damping + s * stiffness - push
    np.testing.assert_allclose(found.residual[COORDINATES:], wanted, rtol=1e-12)


def test_modes_of_a_standing_engine_yield_by_their_springs():
    """Each mode of piston, eye and crank shells ends where its spring balances its modal force.

    The crank is at rest, forces are constant and damping is critical. The modal force is that of
    gas and films, for the piston minus the effect of the frame's acceleration. Every film opens by
    the shape of its shell. In 400 us the start decays to 1 %, and the falling parts turn by one per
    cent.
    """
    damping = ("damping_ratio", "high_frequency_damping_ratio")
    model = crank_model(yielding=True, **dict.fromkeys(damping, 1.0))
    inputs = dataclasses.replace(rough_inputs(model, 3), crank_speed=0.0)
    state, _ = model.start(0.3, 0.0, 0.0, inputs)
    for _ in range(400):
        state, out = model.advance(state, inputs, 1e-6)
    piston, _, bosses, _ = yielding_bodies()
    of_crank = [small_end(1.0, GRIDS[name], RADII[name]) for name in OWN]
    shells = [small_end(), *of_crank]
    fields = [*zip(bosses.boss_outward, bosses.boss_onward)]
    fields += [(one.outward, one.onward) for one in shells]
    pushes = [
        np.einsum("ij,ijk->k", film.pressure, outward)
        - np.einsum("ij,ijk->k", film.circumferential, onward)
        for film, (outward, onward) in zip(inputs.pins, fields, strict=True)
    ]
    last = model._last
    moved = chain_forces(model.chain, no_loads(model.chain), last.now, last.crank, FIXED)
    frame = frame_state(moved.inertia.frames, piston_of(model.chain))
    force = np.pi * 55e-3**2 * 5e5 * piston.gas_force + pushes[0] + pushes[1]
    force = force - inputs.pressure_force.ravel() @ piston.radial
    force = force + inputs.friction_force.ravel() @ piston.axial
    force = force - frame.ax * piston.T[0] - frame.ay * piston.T[1] - frame.alpha * piston.g
    forces = [force, *pushes[2:]]
    held = [push / one.omega**2 for push, one in zip(forces, (piston, *shells))]
    eye = shell_modes_of(model.chain.elements, last.now.position, EYE)
    found = [out["modal_coordinate"], eye]
    for mine, wanted in zip(found, held):
        np.testing.assert_allclose(mine, wanted, rtol=2e-2)
    # half the work of a load that grows, to the squares of what is still under way
    stored = sum(push @ way for push, way in zip(forces, held)) / 2
    assert out["elastic_energy"] == pytest.approx(stored, rel=2e-2)
    ways = [found[0], found[0], found[1], *held[2:]]
    names = (*PIN_SURFACES, *OWN)
    each = zip(names, model.pins, shells_of(model), fields, ways)
    for k, (name, surface, shell, (outward, _), way) in enumerate(each):
        more = out[f"{name}.film_thickness"] - surface.clearance
        more = more - opening_of(surface, shell.own_place())
        opened = outward @ way
        known = 1e-15 if k < 3 else 2e-2 * np.abs(opened).max()
        np.testing.assert_allclose(more, opened, rtol=0.0, atol=known)
        if k > 2:
            axes = "xy" if name == "main_bearing" else ("across", "along")
            shown = [out[f"{name}_widening_{axis}"] for axis in axes]
            np.testing.assert_allclose(shown, diameters(more), atol=1e-12)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("steps", [1, 6])
def test_derivative_of_all_films_against_differences(steps, name):
    """The derivatives of a step agree with differences, with and without backward Euler.

    With unit changes the step is affine up to 1e-6, the effect of millimetres of play and of
    turning shells.
    """
    model = MODELS[name]()
    state, _ = rough_way(model, steps)
    base = rough_inputs(model, 50)
    change = rough_change(model, base)
    products = products_by_differences(model, state, base, change, STEP, 1e-6)
    films = {f"{one.prefix}film_thickness" for one in (*model.films, *model.grids)}
    films |= {f"{one.prefix}circumferential_velocity" for one in model.grids}
    assert films <= products.keys()


@pytest.mark.parametrize("name", MODELS)
def test_work_of_every_film_is_the_same_on_its_grid_and_in_the_coordinates(name):
    """Eq. (G4) against the resultants, with forces as rough as they come; shapes and modes move."""
    model = MODELS[name]()
    state, out = rough_way(model, 5)
    for one in (*model.films, *model.grids):
        assert out[f"{one.prefix}interface_work_error"] <= 1e-13
    assert np.abs(state.velocity).min() > 1e-6


def test_what_does_not_go_with_a_floating_pin_is_told():
    wrong = dataclasses.replace(PARAMETERS, pin_mass=0.0, pin_friction_coefficient=0.05)
    told = "\n".join(faults(bodies(), options(True), wrong))
    assert "pin_mass: expected more than 0 kg with a floating pin, got 0 kg" in told
    assert "pin_friction_coefficient: expected 0 with a floating pin, got 0.05; its films" in told
    assert faults(bodies(), options(True), PARAMETERS) == []


def test_inertia_of_modes_by_hand():
    """Eq. (D22): a mode alone, with the piston's shift along either axis, and with its turning.

    Sums of some kilograms are symmetric to their last digits.
    """
    model = yielding_model()
    piston, *_ = yielding_bodies()
    M = matrix_of(model.model.parts.inertia)
    np.testing.assert_allclose(M, M.T, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(M[7:, 7:], np.eye(MODES))
    np.testing.assert_allclose(M[LATERAL, 7:], piston.T[0])
    np.testing.assert_allclose(M[PIN.boss_y, 7:], -piston.T[1])
    np.testing.assert_allclose(M[PIN.eye_y, 7:], piston.T[1])
    np.testing.assert_allclose(M[ROCKING, 7:], piston.g)
