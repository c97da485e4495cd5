"""The built body FMU of the shipped case (60 + 60 modes), driven in a process that has never
imported the source.
"""

import pytest
from fmpy.validation import validate_fmu

from piston_cosim.master.case.schema import check_case, find_case, read_tree
from piston_cosim.master.fmi.builder import build_fmu

PRELUDE = """
import json, sys
import numpy as np
import fmpy
from fmpy import fmi2
path = sys.argv[1]
description = fmpy.read_model_description(path)
folder = fmpy.extract(path)
by_name = {v.name: v.valueReference for v in description.modelVariables}
grid = [(i, j) for i in range(1, 41) for j in range(1, 41)]
field = lambda name: [by_name[f"{name}[{i},{j}]"] for i, j in grid]
pressure, friction = field("nodal_pressure_force"), field("nodal_friction_force")
film, sliding = field("film_thickness"), field("sliding_velocity")
rng = np.random.default_rng(1)
forces = 0.3 * rng.random(len(grid))

def slave(instance="one"):
    fmu = fmi2.FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName=instance,
                         modelIdentifier=description.coSimulation.modelIdentifier)
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    return fmu

def step(fmu, forces, time=0.0, size=5e-5):
    fmu.setReal(pressure, forces)
    fmu.setReal(friction, 0.1 * forces)
    fmu.doStep(time, size)
    return np.array(fmu.getReal(film + sliding))
"""


@pytest.fixture(scope="module")
def fmu():
    path = find_case("numerical_example")
    table = check_case(read_tree(path), path).participants["bodies"]
    return build_fmu(table.package, table.build, path.parent)


def test_model_description_is_valid(fmu):
    assert validate_fmu(str(fmu)) == []


def test_restored_step_repeats_every_byte(fmu, outside):
    same_outputs, same_state = outside(
        PRELUDE,
        fmu,
        """
        assert not any(name.split(".")[0] == "piston_cosim" for name in sys.modules)
        one = slave()
        step(one, forces)
        saved = one.getFMUstate()
        first = step(one, 0.8 * forces, 5e-5)
        after = bytes(one.serializeFMUstate(one.getFMUstate()))
        one.setFMUstate(saved)
        step(one, 1.5 * forces, 5e-5, 2e-5)
        one.setFMUstate(saved)
        second = step(one, 0.8 * forces, 5e-5)
        again = bytes(one.serializeFMUstate(one.getFMUstate()))
        print(json.dumps([bool((first == second).all()), after == again]))
        """,
    )
    assert same_outputs and same_state


def test_serialised_state_continues_in_a_new_instance(fmu, outside):
    difference = outside(
        PRELUDE,
        fmu,
        """
        one = slave()
        step(one, forces)
        data = one.serializeFMUstate(one.getFMUstate())
        expected = step(one, 0.9 * forces, 5e-5)
        two = slave("two")
        two.setFMUstate(two.deSerializeFMUstate(data))
        print(json.dumps(float(abs(step(two, 0.9 * forces, 5e-5) - expected).max())))
        """,
    )
    assert difference == 0.0


def test_directional_derivative_matches_differences(fmu, outside):
    error = outside(
        PRELUDE,
        fmu,
        """
        one = slave()
        step(one, forces)
        saved = one.getFMUstate()
        direction = rng.standard_normal(len(grid))
        def moved(size):
            one.setFMUstate(saved)
            return step(one, forces + size * direction, 5e-5)
        difference = moved(0.5) - moved(-0.5)
        moved(0.0)
        seed = list(direction) + list(0.1 * direction)
        product = one.getDirectionalDerivative(film + sliding, pressure + friction, seed)
        apart = abs(np.array(product) - difference)
        halves = slice(0, len(grid)), slice(len(grid), None)
        print(json.dumps(max(apart[half].max() / abs(difference[half]).max() for half in halves)))
        """,
    )
    assert (
        error <= 1e-7
    )  # central differences of a step map that is affine to 5e-5: third order in the direction


def test_fmpy_simulates_it_alone(fmu, outside):
    angle = outside(
        PRELUDE,
        fmu,
        """
        wanted = ["crank_angle", "lateral_displacement"]
        result = fmpy.simulate_fmu(path, stop_time=1e-3, output_interval=1e-4, output=wanted)
        print(json.dumps(float(result["crank_angle"][-1])))
        """,
    )
    assert angle == pytest.approx(1e-3 * 314.1592653589793, rel=1e-9)
