"""The step of native bodies compared with that of their Python implementation, both interpreted.

Compiled code is compared in tests/fmu/test_native_bodies.py.
"""

import json
import os
import shutil

import pytest

from piston_cosim.fmu_mfbd.build import prepare
from piston_cosim.fmu_mfbd.dynamics.parameters import (
    CRANK_PARAMETERS,
    ELEMENT_PARAMETERS,
    NO_GAS_TABLE,
    WALL_PARAMETERS,
    AxisParameters,
    Parameters,
    PinParameters,
    Settings,
)
from piston_cosim.fmu_mfbd.native import uncovered
from piston_cosim.fmu_mfbd.reduction.reduced_body import ReducedBlock, ReducedPiston, load, save

from ..command import script
from .conftest import quiet
from .test_half_films import mirrored

SCRIPT = """
import json, sys
import numpy as np
from piston_cosim.fmu_mfbd import native
from piston_cosim.fmu_mfbd.slave import Mfbd
from piston_cosim.master.fmi.symmetry import odd_part
from piston_cosim.tests.twins import Twins

COUNTS = "residual_evaluations", "jacobian_evaluations"
folder, changes = sys.argv[1], json.loads(sys.argv[2])
twins = Twins(Mfbd, native, folder)
python, machine = twins.python, twins.machine
films = python.built.film_grids()
around, _ = python.built.grid
rng = np.random.default_rng(0)
bump = np.maximum(np.sin(np.arange(around) * 2 * np.pi / around), -0.3)[:, None] + 0.3
loads = {f.prefix: (bump * rng.random(f.shape), rng.standard_normal(f.shape)) for f in films}
is_even = "film_symmetry" in changes and "odd" not in sys.argv
if is_even:
    loads = {name: [one - odd_part(one) for one in pair] for name, pair in loads.items()}
pins = {f.prefix: (rng.random(f.shape), rng.random(f.shape)) for f in python.built.pin_grids()}

def give(k):
    values = dict(
        changes,
        gas_pressure=1e5 * k,
        land_pressure=2e5,
        ring_side_force=20.0 * np.sin(k),
        ring_axial_force=-30.0,
        ring_moment=0.1 * np.cos(k),
        crank_speed=300.0 + 2 * k,
    )
    for film, (push, drag) in loads.items():
        values[f"{film}nodal_pressure_force"] = 5.0 * push * (1 + np.sin(0.4 * k))
        values[f"{film}nodal_friction_force"] = 0.1 * drag * np.cos(0.4 * k)
    for film, (push, drag) in pins.items():
        values[f"{film}nodal_pressure_force"] = 300.0 * push * (1 + np.sin(0.4 * k))
        values[f"{film}nodal_circumferential_force"] = 30.0 * drag * np.cos(0.3 * k)
    for n, name in enumerate(n for n in python.views if n.endswith("temperature_field")):
        wave = np.sin(np.arange(python.views[name].size) + n + 0.2 * k)
        values[name] = 370.0 + 2.0 * k + 9.0 * wave.reshape(python.views[name].shape)
    if python.built.mounted:  # it shakes harder than any block on mounts
        values |= dict(
            block_acceleration_x=40.0 * np.cos(k),
            block_acceleration_y=-25.0 * np.sin(k),
            block_angular_acceleration=300.0 * np.sin(2 * k),
            block_angular_velocity=0.7 * np.cos(3 * k),
        )
    twins.give(values)

give(0)
twins.start()
if python.fault:
    faults = native.parts_of(twins.memory).faults
    sentences = []
    for k in range(int(faults[0])):
        number, i, _, a, b, c = faults[1 + 6 * k : 7 + 6 * k]
        sentence = native.FAULTS[int(number)]
        for name, value in dict(a=a, b=b, c=c, i=i).items():
            sentence = sentence.replace("{" + name + "}", f"{value:g}")
        sentences.append(sentence)
    print(json.dumps([python.fault.split(chr(10)), sentences]))
    sys.exit()
twins.compare()
rows = around // 2 + 1 if is_even else around
assert len(python.model.film_surfaces[0].skirt.angle) == rows
own = slice(twins.first, twins.first + twins.length)
for k in range(1, 9):
    step = (1 + k % 3) * 2e-5
    give(k)
    if k == 5:  # taken otherwise first, and taken back
        saved, real = twins.memory[own].copy(), machine.real.copy()
        twins.numbers[0] = 3 * step
        native.advance(*twins.call)
        twins.memory[own] = saved
        machine.real[:] = real
    twins.advance(step)
    if k == 5:
        counts = {n: int(machine.views[n]) for n in COUNTS}  # of the step taken back, too
        vars(python.model).update(counts)
        python._publish(counts)
    twins.compare()
    for _ in range(2):
        shapes = {n: python.views[n].shape for n in python.derivative_inputs}
        twins.compare_derivatives({n: rng.standard_normal(one) for n, one in shapes.items()})
print(json.dumps([twins.shares(), float(abs(python.views["lateral_displacement"]))]))
"""

GAS = {
    "points": [[-10.0, 3.0], [200.0, 0.1], [710.0, 3.0]],
    "angle_unit": "deg",
    "pressure_unit": "MPa",
    "strokes": 4,
}
"""Its first angle is not 0, its first stretch steep."""

UNITS = {"time_unit": "ms", "angle_unit": "deg"}
SPEEDS = {
    "time": [[-0.2, 305.0], [0.1, 300.0], [0.15, 300.0], [0.3, 320.0]],
    "angle": [[-10.0, 300.0], [25.0, 310.0], [26.0, 310.0], [30.0, 290.0], [350.0, 300.0]],
}
"""Crank speed [rad/s]: all segments are passed, constant ones too, and the end over time."""


def speed(over):
    unit = f"{over}_unit"
    return {"points": SPEEDS[over], unit: UNITS[unit], "speed_unit": "rad/s"}


BANDS_OF_ROWS = [{"name": name, "rows": rows} for name, rows in (("low", [1, 4]), ("up", [6, 10]))]
"""Two film surfaces of unequal size, a row between them without a film."""

BEGIN = dict(
    crank_angle=0.7,
    rotation_speed=310.0,
    lateral_displacement=4e-6,
    rocking_angle=-2e-4,
    lateral_velocity=1e-2,
    rocking_velocity=-0.5,
    modal_coordinate=[1e-8 * (k - 10) for k in range(22)],
    modal_velocity=[1e-5 * (k - 7) for k in range(22)],
)
SHAPED = dict(
    barrel=20e-6,
    ovality=50e-6,
    skirt_growth_upper=8e-6,
    skirt_growth_lower=-3e-6,
    bore_growth_upper=6e-6,
    bore_growth_lower=-2e-6,
    pin_tilt=2e-4,
)
TOUCHING = dict(land_stiffness=1e7, land_damping=0.3, land_clearance=1e-6, land_height=12e-3)
EDGES = {"skirt": ["120 degC", "150 degC"], "bore": ["90 degC", "130 degC"]}
TABLE = {"file": "warm.csv", "angle_unit": "deg", "height_unit": "mm", "temperature_unit": "degC"}
WARM_ROWS = "0, 0, 90, 180, 270\n-100, 90, 100, 90, 105\n300, 120, 140, 120, 130\n"
"""Temperatures that are their own mirror image about the thrust plane."""
FREE = {name: 0.0 for name in SHAPED if "growth" in name}
HALF = SHAPED | dict(pin_tilt=0.0, film_symmetry=3)
LOADED = dict(
    crank_offset=1e-3,
    pin_friction_coefficient=0.1,
    pin_friction_damping=1e-3,
    pin_radius=6e-3,
    top_ring_height=18e-3,
    second_ring_height=14e-3,
    land_pressure_share=0.3,
    damping_transition_frequency=22e3,
    spectral_radius=0.3,
    start_crank_angle=0.4,
    start_lateral_displacement=3e-6,
    start_rocking_angle=2e-4,
    crank_inertia=0.02,
)


@pytest.fixture(scope="module")
def told(coarse, kept, tmp_path_factory):
    """Return a runner of the script on the small bodies with changed parameters and options."""

    def run(changes, *words, **options):
        folder, build = coarse
        (folder / "begin.json").write_text(json.dumps(BEGIN))
        (folder / "warm.csv").write_text(WARM_ROWS)
        prepared, files = prepare(build | {"grid": [8, 6]} | options, folder, quiet)
        resources = tmp_path_factory.mktemp("resources")
        (resources / "build.json").write_text(json.dumps(prepared))
        for file, kind in zip(files, (ReducedPiston, ReducedBlock)):
            shutil.copy(file, resources)
            if "film_symmetry" in changes:
                around, _ = prepared["grid"]
                save(resources / file.name, mirrored(load(kind, file), around, True))
        return side_by_side(resources, changes, *words)

    return run


def side_by_side(resources, changes, *words):
    """Return the script's last line for the FMU in a folder, with changed parameters.

    The word `odd` gives it loads that are not symmetric.
    """
    environment = os.environ | {"NUMBA_DISABLE_JIT": "1"}
    told = script(SCRIPT, resources, json.dumps(changes), *words, env=environment)
    return json.loads(told.splitlines()[-1])


def held(found, allowed):
    """Assert that outputs of both differ by a share of their size at most, and that they move."""
    off, moved = found
    # a relative error of round-off differs with its own round-off
    off = {name: error for name, error in off.items() if "interface_work_error" not in name}
    assert {name: error for name, error in off.items() if error > allowed} == {}
    assert moved > 1e-7


@pytest.mark.parametrize(
    "changes, options",
    [
        (SHAPED | LOADED | dict(gas_source=2, quasi_static_frequency=20e3), {"gas": GAS}),
        (SHAPED | LOADED | dict(gas_source=3), {"gas": GAS}),
        (SHAPED, {"grid": [7, 5], "start": "begin.json"}),  # no symmetry; modes that move already
        (SHAPED | LOADED | TOUCHING | dict(crank_unbalance=0.05), {"mounted": True}),
        (SHAPED, {"grid": [7, 10], "film_surfaces": BANDS_OF_ROWS, "mounted": True}),
        (HALF, {"grid": [10, 10], "film_surfaces": BANDS_OF_ROWS, "mounted": True}),
        # another speed than the input
        (LOADED | dict(crank_free=1, load_torque=30.0), {"gas": GAS, "start": "begin.json"}),
        (LOADED, {"speed": speed("time")}),
        (LOADED, {"speed": speed("angle")}),
        (SHAPED | FREE | dict(bore_growth_upper=3e-6), {"temperatures": EDGES}),
        (HALF | FREE, {"grid": [10, 10], "temperatures": {"skirt": TABLE, "bore": TABLE}}),
        (
            SHAPED | FREE,
            {
                "grid": [7, 10],
                "film_surfaces": BANDS_OF_ROWS,
                "temperatures": {"skirt": "input", "bore": "input"},
            },
        ),
    ],
)
def test_the_step_is_that_of_the_model(told, changes, options):
    """Uneven steps of bodies with modes on a rough load, one redone, with derivatives."""
    held(told(changes, **options), 1e-12)


def test_bodies_that_start_with_forces_that_are_not_symmetric_have_whole_films(told):
    held(told(HALF, "odd"), 1e-12)


def test_parameters_that_do_not_fit_are_told_in_the_words_of_the_slave(told):
    of_python, of_machine = told(dict(rod_length=0.02))
    assert of_machine == of_python and len(of_python) == 1
    of_python, of_machine = told(HALF | dict(film_symmetry=2, pin_tilt=1e-4))
    assert of_machine == of_python and "with pin_tilt = 0.0001 rad" in of_python[0]
    wrong = dict(rod_centre=0.2, top_ring_height=5e-3, second_ring_height=4e-3, crank_radius=40e-3)
    of_python, of_machine = told(wrong | dict(gas_source=2, crank_free=1), speed=speed("time"))
    assert of_machine == of_python and len(of_python) == 5
    assert NO_GAS_TABLE in of_python and "a table build.speed" in "".join(of_python)


def test_every_parameter_is_a_setting():
    kinds = Parameters, PinParameters, AxisParameters
    of_parts = *CRANK_PARAMETERS.values(), *WALL_PARAMETERS.values(), *ELEMENT_PARAMETERS
    own = {name for kind in (*kinds, *of_parts) for name in vars(kind())}
    assert set(Settings._fields) == own


def test_options_that_are_not_covered_are_said_as_a_case_gives_them_and_as_built():
    given = {"speed": {"points": []}, "floating_pin": None, "mounted": False, "film_surfaces": []}
    assert list(uncovered(given)) == []
    assert list(uncovered({"floating_pin": {"boss_modes": 60, "pin_shapes": 5}})) == []
