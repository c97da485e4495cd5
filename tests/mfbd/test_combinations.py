"""Combinations of options: a floating pin with everything that a tied pin has, and the reverse.

Central differences confirm derivatives. `test_multibody` compares motions and forces.
"""

import json
from dataclasses import replace

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics import assembly, element_laws
from piston_cosim.fmu_mfbd.dynamics.instant import gas_on_modes, load_of
from piston_cosim.fmu_mfbd.dynamics.model import MOTION, ON_BLOCK, ON_FLEXIBLE_BLOCK, stacked
from piston_cosim.fmu_mfbd.dynamics.pin_films import applied_forces, film_pushes
from piston_cosim.fmu_mfbd.dynamics.skirt_films import (
    forces_by_film,
    total_forces,
)
from piston_cosim.fmu_mfbd.dynamics.start_state import check_start, read_start
from piston_cosim.fmu_mfbd.dynamics.step import others_at
from piston_cosim.fmu_mfbd.dynamics.system import skirt_modes
from piston_cosim.fmu_mfbd.force_elements.land_contact import LAND_CONTACT, LandParameters
from piston_cosim.fmu_mfbd.mechanism.carrier import BlockMotion
from piston_cosim.fmu_mfbd.mechanism.cylinder import piston_of
from piston_cosim.fmu_mfbd.mechanism.inertia import frame_state

from .differences import products_by_differences, rough_change
from .pin_models import (
    BLOCK_MODES,
    MODELS,
    PARAMETERS,
    STEP,
    bodies,
    crank_model,
    flexible_block,
    options,
    outside_model,
    rough_inputs,
    rough_way,
    yielding_bodies,
)


def forces_of_all(model, inputs):
    """Return the forces of all elements of a chain at the end of the last step."""
    given, system, guided = stacked(inputs), model.system, model._last.guide_height
    others = others_at(model.model, given, model._last.crank)
    skirt = total_forces(forces_by_film(system, guided, given.skirt))
    load = load_of(system, skirt, others)
    held = applied_forces(system, load, given.pins, film_pushes(system, given.pins))
    held.modal[: skirt_modes(system)] += gas_on_modes(system, guided, others)
    return held


# ---- a mounted block

MOVING = BlockMotion(30.0, -50.0, 400.0, 1.7)
"""A block that shakes harder than any on mounts."""


def carried_way(model, carrier=MOVING, steps=4):
    """Return the state before the last step, its inputs and its outputs in a block that moves."""
    model.model = model.model._replace(mounted=True)
    state, out = model.start(0.3, 2e-6, 1e-4, rough_inputs(model, 0, 0.0))
    for k in range(steps):
        before, inputs = state, replace(rough_inputs(model, k), carrier=carrier)
        state, out = model.advance(before, inputs, STEP)
    return before, inputs, out


@pytest.mark.parametrize("name", ["rigid", "bending, bosses, eye", "all flexible"])
def test_derivatives_with_the_motion_of_a_block_are_differences(name):
    """A floating pin in a block that moves, with rough changes of all forces and of its motion."""
    model = MODELS[name]()
    before, base, _ = carried_way(model)
    change = rough_change(model, base)
    for moved in (change, replace(change, carrier=BlockMotion(0.3, -0.2, 0.7, 1e-3))):
        products = products_by_differences(model, before, base, moved, STEP, 3e-6)
        assert {*ON_BLOCK, *MOTION} <= products.keys()


# ---- a free crank


def test_a_heavy_free_crank_turns_at_a_given_speed():
    plain, heavy = (crank_model(yielding=True, crank_inertia=one) for one in (0.02, 1e9))
    heavy.model = heavy.model._replace(settings=heavy.model.settings._replace(crank_free=1.0))
    (_, wanted), (_, out) = rough_way(plain, 5), rough_way(heavy, 5)
    for name in ("film_thickness", "lateral_velocity", "pin_force_x", "main_bearing_force_y"):
        name = "skirt.film_thickness" if name == "film_thickness" else name
        np.testing.assert_allclose(out[name], wanted[name], rtol=1e-7)


# ---- modes without inertia


def test_static_modes_follow_their_forces_with_a_floating_pin():
    """Each mode is where its spring balances films, gas and the frame's acceleration (Eq. (D6)).

    All modes of the piston and of the block are static. Their forces are those of the other tests.
    """
    model = crank_model(yielding=True, shapes=3, quasi_static_frequency=0.0)
    state, out = rough_way(model, 5)
    inputs, last = rough_inputs(model, 4), model._last
    own = forces_of_all(model, inputs).modal
    frame = frame_state(last.linear.forces.inertia.frames, piston_of(model.chain))
    piston, _, bosses, _ = yielding_bodies()
    slopes = frame.ax * piston.T[0] + frame.ay * piston.T[1]
    slopes = slopes + frame.alpha * piston.g - frame.w**2 * piston.b
    omega = np.array([*piston.omega, *flexible_block().omega])
    wanted = (own[: len(omega)] - [*slopes, *np.zeros(BLOCK_MODES)]) / omega**2
    np.testing.assert_allclose(out["modal_coordinate"], wanted, rtol=1e-9)


# ---- a bore that deflects from outside


def test_derivatives_with_a_bore_from_outside_are_differences():
    model = outside_model()
    before, base, _ = carried_way(model)
    deflection = 1e-6 * np.random.default_rng(2).standard_normal((24, 64))
    base = replace(base, bore_deflection=deflection)
    change = replace(rough_change(model, base), carrier=BlockMotion(0.3, -0.2, 0.7, 1e-3))
    products = products_by_differences(model, before, base, change, STEP, 3e-6)
    assert {*ON_BLOCK, *ON_FLEXIBLE_BLOCK} <= products.keys()


# ---- a start from a snapshot


@pytest.fixture
def sliding(monkeypatch):
    """Model whose piston slides freely along the bore in its joint on the rod."""
    monkeypatch.setattr(assembly, "SLIDES", {"rise": LAND_CONTACT})
    monkeypatch.setattr(element_laws, "OF_SLIDE", np.array([0]))
    monkeypatch.setattr(element_laws, "WAYS", np.array([[0.0, 1.0]]))
    piston, block, *_ = bodies()
    built = replace(options(False), slides=("rise",))
    return assembly.assemble(piston, block, built, PARAMETERS, [LandParameters()])


@pytest.mark.parametrize(
    "name", ["all flexible", "tied, rubbing, all flexible", "bending", "sliding"]
)
def test_a_start_from_outputs_is_the_motion_that_they_show(name, tmp_path, request):
    """Positions and velocities are those of the state, and so are films and forces of its instant.

    The file holds the outputs as `results snapshot` writes them.
    """
    model = MODELS[name]() if name in MODELS else request.getfixturevalue(name)
    state, out = rough_way(model, 6)
    assert name != "sliding" or out["rise"] == out["bearing_coordinate"].item() < -1e-6
    path = tmp_path / "start.json"
    path.write_text(json.dumps({key: np.asarray(one).tolist() for key, one in out.items()}))
    start = read_start(path)
    check_start(start, skirt_modes(model.system), len(out["bearing_coordinate"]))
    joints = model.chain.joints.tip.shape[1] - 2
    motion = start.position(joints), start.velocity(joints)
    np.testing.assert_array_equal(motion, [state.position, state.velocity])
    begun, again = model.start_moving(start.crank_angle, *motion, rough_inputs(model, 5))
    for film in (*model.films, *model.grids):
        key = f"{film.prefix}film_thickness"
        np.testing.assert_allclose(again[key], out[key], rtol=1e-12)
