"""The body FMU that needs no Python beside the FMU in Python, and foreign
hosts and machines. What is compiled is the slave's own kernels; products of a matrix with a vector
and what goes through sin, tanh and hypot are those of other libraries.
"""

import importlib
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from piston_cosim.master.api.fmus import build_fmu as build_of_case
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import build_native_fmu
from piston_cosim.master.fmi.compiler import compiler_of
from piston_cosim.master.fmi.errors import BadInput, Discard
from piston_cosim.master.participants.fmi2 import FmuParticipant

from ..mfbd.conftest import write_bodies
from .conftest import rigid_bodies
from .runs import reached

ROUND_OFF = 1e-12  # of the largest value of an output: some hundred roundings
SEEDS = (
    "nodal_pressure_force",
    "nodal_friction_force",
    "ring_side_force",
    "ring_axial_force",
    "ring_moment",
)
PRODUCTS = (
    "film_thickness",
    "sliding_velocity",
    "lateral_velocity",
    "rocking_velocity",
    "piston_velocity",
)
GAS = {
    "points": [[0.0, 3.0], [200.0, 0.1], [720.0, 3.0]],
    "angle_unit": "deg",
    "pressure_unit": "MPa",
    "strokes": 4,
}


@pytest.fixture(scope="module")
def rigid(native_bodies):
    return native_bodies([12, 10])


@pytest.fixture(scope="module")
def flexible(tmp_path_factory):
    """Build table of small bodies with 12 and 10 modes and a gas table; its folder."""
    folder, table = write_bodies(tmp_path_factory.mktemp("bodies"), 16, 1, (6, 4))
    return table | {"gas": GAS}, folder


def given(k, shape, film=""):
    """Inputs of a step: a rough load that turns round."""
    rng = np.random.default_rng(k)
    angle = np.arange(shape[0]) * 2 * np.pi / shape[0]
    bump = np.maximum(np.sin(angle - 0.3 * k), -0.2)[:, None] + 0.2
    return {
        f"{film}nodal_pressure_force": 5.0 * bump * rng.random(shape),
        f"{film}nodal_friction_force": 0.5 * rng.standard_normal(shape),
        "gas_pressure": 1e4 * k,
        "land_pressure": 1e5,
        "ring_side_force": 10.0 * np.sin(k),
        "ring_axial_force": -20.0,
        "ring_moment": 0.05 * np.cos(k),
        "crank_speed": 300.0 + k,
        "load_torque": 20.0 + 10.0 * np.sin(k),
        "piston_temperature": 293.15 + 0.5 * k,
        "bore_temperature": 293.15 - 0.2 * k,
        "damping_ratio": 0.02 + 0.01 * (k % 3),
    }


def side_by_side(python, native, parameters, steps=40):
    """Largest difference of every output of two FMUs, by its largest value, and of derivatives;
    every tenth step is first taken otherwise and taken back.
    """
    both = [FmuParticipant("bodies", path) for path in (python, native)]
    shape = both[0].fields["film_thickness"].shape
    names = [name for name, field in both[0].fields.items() if field.causality == "output"]
    largest, off = dict.fromkeys(names, 0.0), dict.fromkeys(names, 0.0)
    rng = np.random.default_rng(9)
    for one in both:
        one.start(parameters | given(0, shape), 0.0, 1.0)
    for k in range(1, steps + 1):
        size = (1 + k % 3) * 3e-5
        for one in both:
            for name, value in given(k, shape).items():
                one.set(name, value)
            if k % 10 == 0:
                saved = one.save()
                one.step(reached(one), 2.5 * size)
                one.restore(saved)
            one.step(reached(one), size)
        for name in names:
            a, b = (np.asarray(one.get(name), dtype=float) for one in both)
            largest[name] = max(largest[name], float(np.abs(a).max()))
            off[name] = max(off[name], float(np.abs(a - b).max()))
        if k % 8 == 0:
            seeds = {n: rng.standard_normal(np.shape(both[0].get(n))) for n in SEEDS}
            answers = [one.derivative(seeds, PRODUCTS) for one in both]
            for name in PRODUCTS:
                a, b = (np.asarray(answer[name]) for answer in answers)
                error = float(np.abs(a - b).max() / np.abs(a).max())
                off["of " + name] = max(off.get("of " + name, 0.0), error)
    for one in both:
        one.close()
    off.pop("interface_work_error")  # round-off by itself
    assert largest["lateral_displacement"] > 1e-6
    return {n: e / largest.get(n, 1.0) for n, e in off.items() if e}


@pytest.mark.parametrize("free", [0, 1])
def test_rigid_bodies_have_the_bits_of_the_slave(bodies_fmu, rigid, free):
    """No products of matrices: C's sin and hypot are those that Python calls here."""
    table = dict(crank_offset=1e-3, pin_friction_coefficient=0.1, start_crank_angle=0.3)
    table |= dict(crank_free=free, crank_inertia=5e-3)
    assert max(side_by_side(bodies_fmu, rigid, table).values(), default=0.0) <= ROUND_OFF


SPEEDS = {
    "time_unit": [[0.1, 300.0], [0.9, 310.0], [1.0, 310.0], [2.0, 250.0]],
    "angle_unit": [[-10.0, 300.0], [25.0, 310.0], [26.0, 310.0], [40.0, 290.0], [350.0, 300.0]],
}
"""Crank speed [rad/s] over time [ms] and angle [deg], constant in one segment of each."""


@pytest.mark.parametrize("unit, one", [("time_unit", "ms"), ("angle_unit", "deg")])
def test_a_table_of_crank_speed_is_that_of_the_slave(rigid, unit, one):
    """40 steps over 2.4 ms pass all points but the last over angle."""
    table, folder = rigid_bodies([12, 10])
    table |= {"speed": {"points": SPEEDS[unit], unit: one, "speed_unit": "rad/s", "strokes": 2}}
    both = (make("fmu_mfbd", table, folder) for make in (build_fmu, build_native_fmu))
    off = side_by_side(*both, dict(crank_offset=1e-3, start_crank_angle=0.3))
    assert max(off.values(), default=0.0) <= ROUND_OFF


def test_flexible_bodies_are_those_of_the_slave(flexible, rigid):
    table, folder = flexible
    python = build_fmu("fmu_mfbd", table, folder)
    values = dict(
        crank_offset=1e-3,
        top_ring_height=18e-3,
        second_ring_height=14e-3,
        bore_growth_upper=6e-6,
        start_rocking_angle=1e-4,
        damping_transition_frequency=22e3,
    )
    off = side_by_side(python, build_native_fmu("fmu_mfbd", table, folder), values)
    assert max(off.values(), default=0.0) <= ROUND_OFF


def test_gas_is_of_table_or_input_and_both_are_told_once(flexible, rigid):
    """By the output of the gas: 0.1 MPa of the table, linear to 3 MPa at 0 and 720 deg."""
    table, folder = flexible
    both = build_fmu("fmu_mfbd", table, folder), build_native_fmu("fmu_mfbd", table, folder)
    built_in, given = 0.1e6, 1e6
    wanted = {"either": built_in + given, "table": built_in, "input": given}
    wanted["sum"] = wanted["either"]
    for path in both:
        for source, pressure in wanted.items():
            one = FmuParticipant("bodies", path)
            number = one.fields["gas_source"].choices[source]
            start = {"start_crank_angle": np.radians(200.0), "gas_source": number}
            one.start(start | {"crank_speed": 0.0}, 0.0, 1.0)
            told = []
            for k in range(3):
                one.set("gas_pressure", given)
                one.step(1e-5 * k, 1e-5)
                told += [text for _, text in one.log if "gas_source" in text]
            assert one.get("cylinder_pressure") == pytest.approx(pressure, rel=1e-12), source
            assert len(told) == (source == "either"), (path, source, told)
            one.close()


def test_a_load_brakes_a_free_crank(rigid):
    """Impulse of the load over effective inertia, at rest and near top dead centre."""
    one = FmuParticipant("bodies", rigid)
    one.start(dict(crank_free=1, crank_inertia=0.5, crank_speed=0.0, load_torque=0.0), 0.0, 1.0)
    inertia = one.get("effective_inertia")
    one.set("load_torque", -3.0)
    for k in range(100):
        one.step(1e-5 * k, 1e-5)
    assert one.get("crank_torque") == 3.0
    # a piston that starts from dead centre moves by less than 1 um; first order at the first step
    assert one.get("rotation_speed") == pytest.approx(3.0 * 99.5e-5 / inertia, rel=1e-3)
    assert one.get("crank_angle") > 0.0
    with pytest.raises(Discard, match=r"gas_pressure: expected -200000 to 1e\+08 Pa, got 1e\+09"):
        one.set("gas_pressure", 1e9)
        one.step(1e-3, 1e-5)
    one.close()


def test_a_piston_that_warms_fills_its_bore(bodies_fmu, rigid):
    """Skirt of 28.225 mm: 22.58 um more by 40 K and 20e-6/K. Bore of 28.25 mm: 3.1075 um more by
    10 K and 11e-6/K.
    """
    grown = dict(piston_temperature=333.15, bore_temperature=303.15)
    for path in (bodies_fmu, rigid):
        one = FmuParticipant("bodies", path)
        one.start({}, 0.0, 1.0)
        cold = one.get("film_thickness").copy()
        for name, value in grown.items():
            one.set(name, value)
        one.step(0.0, 1e-9)  # nothing else moves
        assert one.get("thermal_opening") == pytest.approx(-19.4725e-6, rel=1e-12)
        np.testing.assert_allclose(one.get("film_thickness") - cold, -19.4725e-6, rtol=1e-6)
        before = one.get("film_thickness").copy()
        one.set("bore_temperature", 1100.0)
        words = "bore_temperature: expected 200 to 1000 K, got 1100 K"
        with pytest.raises(Discard, match=words):
            one.step(1e-9, 1e-9)
        assert np.array_equal(one.get("film_thickness"), before)
        with pytest.raises(FMICallException):
            one.set("piston_expansion", 1e-5)  # fixed
        one.close()


BANDS = [{"name": "low", "rows": [1, 4]}, {"name": "up", "rows": [6, 10]}]
"""Unequal, a row between them without a film."""
DIFFERENCED = 1e-8
"""Of the largest value. Derivatives of forces and moment on the block are differences of forces of
10 kN over a change of newtons (Eq. (D20)): each FMU's own add up to 1.5e-8 N alone, of 20 N. On
some processors the moment's differ by 2e-10 of 2.9 N m.
"""
ON_BLOCK = ("of force_on_block", "of moment_on_block")
SHAKEN = (
    "block_acceleration_x",
    "block_acceleration_y",
    "block_angular_acceleration",
    "block_angular_velocity",
)


def given_to_bands(k):
    """Inputs of a step of two films in a block that moves."""
    shaken = dict(zip(SHAKEN, (40 * np.cos(k), -25 * np.sin(k), 300 * np.sin(k), 0.7 * np.cos(k))))
    return given(k, (12, 4), "low.") | given(k + 100, (12, 5), "up.") | shaken


def test_several_films_in_a_block_that_moves_are_those_of_the_slave(flexible, rigid):
    """Modes, offsets and an unbalanced crank; a step taken otherwise first and taken back, by a
    state of this instance and by one that went through bytes.
    """
    table, folder = flexible
    table = table | {"grid": [12, 10], "film_surfaces": BANDS, "mounted": True}
    paths = build_fmu("fmu_mfbd", table, folder), build_native_fmu("fmu_mfbd", table, folder)
    both = [FmuParticipant("bodies", path) for path in paths]
    values = dict(crank_offset=1e-3, crank_unbalance=0.05, start_rocking_angle=1e-4, barrel=15e-6)
    names = [name for name, field in both[0].fields.items() if field.causality == "output"]
    names = [name for name in names if "interface_work_error" not in name]  # round-off by itself
    seeded = [f"{film}{one}" for film in ("low.", "up.") for one in SEEDS[:2]]
    seeded += [*SEEDS[2:], *SHAKEN]
    produced = [f"{film}{one}" for film in ("low.", "up.") for one in PRODUCTS[:2]]
    produced += [*PRODUCTS[2:], "force_on_block_x", "force_on_block_y", "moment_on_block"]
    rng = np.random.default_rng(4)
    largest, off = dict.fromkeys(names, 0.0), dict.fromkeys(names, 0.0)
    for one in both:
        one.start(values | given_to_bands(0), 0.0, 1.0)
    for k in range(1, 25):
        for one in both:
            for name, value in given_to_bands(k).items():
                one.set(name, value)
            if k % 8 == 0:
                saved = one.save()
                one.step(reached(one), 7e-5)
                if k == 16:
                    saved = one._fmu.deSerializeFMUstate(one.serialise(saved))
                one.restore(saved)
            one.step(reached(one), 3e-5)
        for name in names:
            a, b = (np.asarray(one.get(name), dtype=float) for one in both)
            largest[name] = max(largest[name], float(np.abs(a).max()))
            off[name] = max(off[name], float(np.abs(a - b).max()))
        seeds = {name: rng.standard_normal(np.shape(both[0].get(name))) for name in seeded}
        answers = [one.derivative(seeds, produced) for one in both]
        for name in produced:
            a, b = (np.asarray(answer[name]) for answer in answers)
            of = f"of {name}"
            largest[of] = max(largest.get(of, 0.0), float(np.abs(a).max()))
            off[of] = max(off.get(of, 0.0), float(np.abs(a - b).max()))
    for one in both:
        one.close()
    assert largest["lateral_displacement"] > 1e-6 and largest["moment_on_block"] > 1.0
    assert np.shape(answers[1]["up.film_thickness"]) == (12, 5)
    for name, error in off.items():
        allowed = DIFFERENCED if name.startswith(ON_BLOCK) else ROUND_OFF
        assert error <= allowed * largest[name], name


# ---- what is covered


UNCOVERED = [
    ({"motion_in_space": {}}, "motion_in_space: expected nothing"),
    ({"block": {"bore_from_outside": {}}}, "block.bore_from_outside: expected nothing"),
    ({"floating_pin": {"pin_shapes": 5}}, "floating_pin.pin_shapes: expected 0"),
]
"""Build options, and the start of what the rejection says."""


def test_what_is_not_covered_is_refused_before_a_body_is_reduced(monkeypatch):
    bodies = importlib.import_module("piston_cosim.fmu_mfbd.build")
    monkeypatch.setattr(bodies, "prepare", lambda *_: pytest.fail("a body was reduced"))
    for options, words in UNCOVERED:
        with pytest.raises(BadInput, match=f"{words} in a native FMU, got"):
            build_of_case("numerical_example", "bodies", options=options, platforms=["linux64"])


@pytest.mark.parametrize(
    "values, words",
    [
        (
            dict(rod_length=0.02),
            "rod_length: expected more than crank_radius plus the offsets, .*, got 0.02 m",
        ),
        (
            dict(crank_radius=0.06),
            "crank_radius, rod_length: expected a skirt within the bore, .*, got ",
        ),
        (dict(radial_clearance=7.0), "radial_clearance: expected 1e-06 to 0.001 m, got 7 m"),
    ],
)
def test_what_cannot_start_is_said_by_name(rigid, values, words):
    one = FmuParticipant("bodies", rigid)
    with pytest.raises(BadInput, match=words):
        one.start(values, 0.0, 1.0)
    one.close()


def test_a_refused_step_leaves_the_motion_as_it_was(rigid):
    one = FmuParticipant("bodies", rigid)
    shape = (12, 10)
    one.start(given(0, shape), 0.0, np.inf)
    one.step(reached(one), 3e-5)
    before = one.get("film_thickness").copy()
    with pytest.raises(Discard, match="crank angle = inf rad: must be finite"):
        one.step(reached(one), 1e308)
    assert np.array_equal(one.get("film_thickness"), before)
    saved = one.save()
    one.step(reached(one), 3e-5)
    after = one.get("film_thickness").copy()
    one.restore(saved)
    one.step(reached(one), 3e-5)
    assert np.array_equal(one.get("film_thickness"), after)
    one.close()


# ---- other hosts and machines


@pytest.mark.slow
@pytest.mark.parametrize(
    "platform, emulator",
    [("aarch64-linux", ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"]), ("win64", ["wine"])],
)
def test_other_machines_say_the_same(native_bodies, rigid, unpack, tmp_path, platform, emulator):
    """The same host program, compiled for the machine, under an emulator: 120 steps, to the last
    digits of other C libraries' sin, tanh and hypot.
    """
    compile_for = compiler_of(platform)
    if compile_for is None or shutil.which(emulator[0]) is None:
        pytest.skip(f"{platform}: needs its C compiler and {emulator[0]}")
    there = unpack(native_bodies([12, 10], platforms=[platform]), tmp_path / "there")
    here = unpack(rigid, tmp_path / "here")
    source = str(Path(__file__).parent / "native_driver.c")
    answers = []
    for command, compile_with, place, folder, ending in (
        ([], ["cc"], here, "linux64", "so"),
        (emulator, compile_for, there, platform, "dll" if platform == "win64" else "so"),
    ):
        program = tmp_path / f"driver-{folder}.exe"
        links = ["-lm"] if platform == folder == "win64" else ["-lm", "-ldl"]
        subprocess.run([*compile_with, "-DNUMBERS", "-o", str(program), source, *links], check=True)
        first = [
            str(place.references[f"{name}[1,1]"])
            for name in ("nodal_pressure_force", "nodal_friction_force", "film_thickness")
        ]
        library = place.folder / "binaries" / folder / f"fmu_mfbd.{ending}"
        words = [program, library, place.location, place.description.guid, 120, 120, *first]
        environment = {**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": str(tmp_path / "wine")}
        done = subprocess.run(
            [*command, *map(str, words)], capture_output=True, timeout=500, env=environment
        )
        assert done.returncode == 0, done.stderr
        answers.append(np.array([float(line.split()[1]) for line in done.stdout.splitlines()]))
    assert len(answers[0]) == 120
    assert np.ptp(answers[0]) > 1e-3 * answers[0].max()  # the piston moves
    assert np.abs(answers[0] - answers[1]).max() <= ROUND_OFF * np.abs(answers[0]).max()
