"""The built lubrication FMU, in Python and native, driven in a process that has never imported the
source.
"""

import pytest
from fmpy.validation import validate_fmu

PRELUDE = """
import json, sys
import numpy as np
import fmpy
from fmpy import fmi2
path = sys.argv[1]
description = fmpy.read_model_description(path)
folder = fmpy.extract(path)
by_name = {v.name: v.valueReference for v in description.modelVariables}

def field(name, n=12, m=10):
    return [by_name[f"{name}[{i},{j}]"] for i in range(1, n + 1) for j in range(1, m + 1)]

def slave(instance="one", **parameters):
    fmu = fmi2.FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName=instance,
                         modelIdentifier=description.coSimulation.modelIdentifier)
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    for name, value in parameters.items():
        fmu.setReal([by_name[name]], [value])
    fmu.setReal(field("film_thickness"), np.full(120, 30e-6))
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu

rng = np.random.default_rng(1)
film = (20e-6 + 8e-6 * rng.random((12, 10))).ravel()
forces = field("nodal_pressure_force")

def step(fmu, film, time=0.0, size=5e-5, speed=6.0):
    fmu.setReal(field("film_thickness"), film)
    fmu.setReal(field("sliding_velocity"), np.full(120, speed))
    fmu.doStep(time, size)
    return np.array(fmu.getReal(forces))
"""


@pytest.fixture(params=["fmu", "native_fmu"])
def fmu(request):
    return request.getfixturevalue(request.param)


def test_model_description_is_valid(fmu):
    assert validate_fmu(str(fmu)) == []


def test_restored_step_repeats_every_byte(fmu, outside):
    same_forces, same_state, moved = outside(
        PRELUDE,
        fmu,
        """
        assert not any(name.split(".")[0] == "piston_cosim" for name in sys.modules)
        one = slave()
        saved = one.getFMUstate()
        first = step(one, film)
        after = one.serializeFMUstate(one.getFMUstate())
        one.setFMUstate(saved)
        step(one, 0.7 * film)
        one.setFMUstate(saved)
        second = step(one, film)
        again = one.serializeFMUstate(one.getFMUstate())
        same = [bool((first == second).all()), bytes(after) == bytes(again)]
        print(json.dumps([*same, float(abs(first).max())]))
        """,
    )
    assert same_forces and same_state
    assert moved > 0


def test_serialised_state_continues_in_a_new_instance(fmu, outside):
    difference = outside(
        PRELUDE,
        fmu,
        """
        one = slave(viscosity=0.02)
        step(one, film)
        data = one.serializeFMUstate(one.getFMUstate())
        expected = step(one, 0.9 * film, 5e-5)
        two = slave("two")
        two.setFMUstate(two.deSerializeFMUstate(data))
        print(json.dumps(float(abs(step(two, 0.9 * film, 5e-5) - expected).max())))
        """,
    )
    assert difference == 0.0


def test_refused_steps_leave_the_state_and_the_host_alone(fmu, outside):
    refusals, survived = outside(
        PRELUDE,
        fmu,
        """
        import gc
        one = slave()
        saved = bytes(one.serializeFMUstate(one.getFMUstate()))
        bad = film.copy()
        bad[17] = np.nan
        refusals = 0
        for wrong in (
            dict(film=bad),
            dict(film=film, size=0.0),
            dict(film=film, size=-1e-5),
            dict(film=film, speed=np.inf),
        ):
            try:
                step(one, **wrong)
            except Exception as failure:
                refusals += failure.status == fmi2.fmi2Discard
        gc.collect()
        good = slave("two")
        print(json.dumps([refusals, bool(np.array_equal(step(one, film), step(good, film)))]))
        """,
    )
    assert refusals == 4
    assert survived


def test_instances_do_not_share_state(fmu, outside):
    same = outside(
        PRELUDE,
        fmu,
        """
        one, two = slave("one"), slave("two", viscosity=0.05)
        a = step(one, film)
        step(two, 0.5 * film)
        three = slave("three")
        print(json.dumps(bool((step(three, film) == a).all())))
        """,
    )
    assert same


def test_fmpy_simulates_it_alone(fmu, outside):
    count = outside(
        PRELUDE,
        fmu,
        """
        wanted = ["minimum_film_thickness"]
        result = fmpy.simulate_fmu(path, stop_time=1e-3, output_interval=1e-4, output=wanted)
        print(json.dumps(len(result)))
        """,
    )
    assert count == 11
