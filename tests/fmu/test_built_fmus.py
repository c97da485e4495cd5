"""The built FMUs of film and bodies, in Python and native, driven in a process that has never
imported the source.
"""

import pytest

from piston_cosim.master.fmi.builder import build_fmu

from ..mfbd.conftest import write_bodies

PRELUDE = r"""
import gc, json, sys
import numpy as np
import fmpy
from fmpy import fmi2
path = sys.argv[1]
description = fmpy.read_model_description(path)
folder = fmpy.extract(path)
references = {v.name: v.valueReference for v in description.modelVariables}
rng = np.random.default_rng(1)

def field(name):
    return [one for key, one in references.items() if key.startswith(name + "[")]

is_film = description.modelName == "fmu_ehd"
sizes = len(field("film_thickness"))
rough = rng.random(sizes)
film = 20e-6 + 8e-6 * rough, np.full(sizes, 6.0)
loads = 0.3 * rough, 0.03 * rough
given = film if is_film else loads
gaps = field("film_thickness"), field("sliding_velocity")
forces = field("nodal_pressure_force"), field("nodal_friction_force")
inputs, outputs = (gaps, forces[0]) if is_film else (forces, gaps[0] + gaps[1])

def slave(**parameters):
    fmu = fmi2.FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName="one",
                         modelIdentifier=description.coSimulation.modelIdentifier)
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    for name, value in parameters.items():
        fmu.setReal([references[name]], [value])
    if is_film:
        fmu.setReal(gaps[0], np.full(sizes, 30e-6))
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu

def step(fmu, scale=1.0, time=0.0, size=5e-5, more=0.0):
    fmu.setReal(inputs[0], scale * given[0] + more)
    fmu.setReal(inputs[1], given[1] + 0.1 * np.asarray(more))
    fmu.doStep(time, size)
    return np.array(fmu.getReal(outputs))

def state(fmu):
    return bytes(fmu.serializeFMUstate(fmu.getFMUstate()))
"""


@pytest.fixture(scope="module")
def flexible(tmp_path_factory):
    """Bodies of 12 and 10 modes."""
    folder, table = write_bodies(tmp_path_factory.mktemp("bodies"), 16, 1, (6, 4))
    return build_fmu("fmu_mfbd", table, folder)


@pytest.fixture(params=["fmu", "native_fmu", "flexible"])
def built(request):
    return request.getfixturevalue(request.param)


def test_restored_step_repeats_every_byte(built, outside):
    same_outputs, same_state, moved = outside(
        PRELUDE,
        built,
        """
        assert not any(name.split(".")[0] == "piston_cosim" for name in sys.modules)
        one = slave()
        step(one)
        saved = one.getFMUstate()
        first = step(one, 0.8, 5e-5)
        after = state(one)
        one.setFMUstate(saved)
        step(one, 0.7, 5e-5, 2e-5)
        one.setFMUstate(saved)
        second = step(one, 0.8, 5e-5)
        same = [bool((first == second).all()), after == state(one)]
        print(json.dumps([*same, float(abs(first).max())]))
        """,
    )
    assert same_outputs and same_state
    assert moved > 0


def test_serialised_state_continues_in_a_new_instance(built, outside):
    difference = outside(
        PRELUDE,
        built,
        """
        one = slave(**({"viscosity": 0.02} if is_film else {}))
        step(one)
        data = state(one)
        expected = step(one, 0.9, 5e-5)
        two = slave()
        two.setFMUstate(two.deSerializeFMUstate(data))
        print(json.dumps(float(abs(step(two, 0.9, 5e-5) - expected).max())))
        """,
    )
    assert difference == 0.0


def test_refused_steps_leave_the_state_and_the_host_alone(built, outside):
    refusals, survived = outside(
        PRELUDE,
        built,
        """
        one = slave()
        bad = np.zeros(sizes)
        bad[17] = np.nan
        wrong = dict(more=bad), dict(size=0.0), dict(size=-1e-5), dict(more=0.0 * bad + np.inf)
        refusals = 0
        for one_wrong in wrong:
            try:
                step(one, **one_wrong)
            except Exception as failure:
                refusals += failure.status == fmi2.fmi2Discard
        gc.collect()
        print(json.dumps([refusals, bool(np.array_equal(step(one), step(slave())))]))
        """,
    )
    assert refusals == 4
    assert survived


def test_instances_do_not_share_state(built, outside):
    same = outside(
        PRELUDE,
        built,
        """
        one, two = slave(), slave()
        first = step(one)
        step(two, 0.5)
        print(json.dumps(bool((step(slave()) == first).all())))
        """,
    )
    assert same


def test_directional_derivative_matches_differences(flexible, outside):
    error = outside(
        PRELUDE,
        flexible,
        """
        one = slave()
        step(one)
        saved = one.getFMUstate()
        direction = rng.standard_normal(sizes)
        def moved(size):
            one.setFMUstate(saved)
            return step(one, 1.0, 5e-5, more=size * direction)
        difference = 2 * (moved(0.25) - moved(-0.25))
        moved(0.0)
        seed = list(direction) + list(0.1 * direction)
        product = one.getDirectionalDerivative(outputs, inputs[0] + inputs[1], seed)
        apart = abs(np.array(product) - difference)
        halves = slice(0, sizes), slice(sizes, None)
        print(json.dumps(max(apart[half].max() / abs(difference[half]).max() for half in halves)))
        """,
    )
    # central differences of a step map that is affine to 5e-5: third order in the direction
    assert error <= 1e-7


@pytest.mark.parametrize("form", ["fmu", "native_fmu", "bodies_fmu"])
def test_fmpy_simulates_it_alone(form, request, outside):
    times, angle = outside(
        PRELUDE,
        request.getfixturevalue(form),
        """
        wanted = ["minimum_film_thickness"] if is_film else ["crank_angle"]
        result = fmpy.simulate_fmu(path, stop_time=1e-3, output_interval=1e-4, output=wanted)
        print(json.dumps([len(result), float(result[wanted[0]][-1])]))
        """,
    )
    assert times == 11
    if form == "bodies_fmu":
        assert angle == pytest.approx(1e-3 * 314.1592653589793, rel=1e-9)
