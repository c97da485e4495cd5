"""The lubrication FMU that needs no Python: the values of the model, refusals, foreign machines.

It has the model's bits, but for what goes through exp or log, by those of the C library.
"""

import ctypes
import importlib
import os
import shutil
import subprocess
import time
import zipfile
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from piston_cosim.fmu_ehd.model import LubricationModel
from piston_cosim.fmu_ehd.native import uncovered
from piston_cosim.fmu_ehd.oil import Oil
from piston_cosim.fmu_ehd.parameters import CHOICES, CHOSEN, NUMBERS, Parameters
from piston_cosim.fmu_ehd.step import Fields, Scalars
from piston_cosim.fmu_ehd.variables import (
    DERIVATIVE_INPUTS,
    DERIVATIVE_OUTPUTS,
    TURNING_INPUT,
    TURNING_OUTPUT,
    variables,
)
from piston_cosim.master.api.fmus import build_fmu
from piston_cosim.master.fmi import builder
from piston_cosim.master.fmi.builder_native import ENTRIES, build_native_fmu
from piston_cosim.master.fmi.compiler import compiler_of
from piston_cosim.master.fmi.errors import BadInput, Discard
from piston_cosim.master.fmi.native_code import OPEN, TARGETS, translated
from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.master.participants.fmi3 import Fmu3Participant
from piston_cosim.tests.verification.cases.motored import (
    DEGREE,
    UNEVEN,
    motored_film,
    opening,
    physics,
)

from .runs import reached

GRID = (12, 10)
OF_OIL = ("axial temperature", "barus", "roelands", "cross", "carreau")
"""Physics with exp, log or powers of the C library."""
OF_OIL += ("flow factors", "oblong roughness", "coating and roelands")
WITH_CUT_OUTS = ("cut-out", "fed cut-out", "everything")
COVERED_PHYSICS = {
    name: changes for name, changes in physics(GRID).items() if name not in OF_OIL + WITH_CUT_OUTS
}
OTHER_OILS = {
    "all on little oil": dict(
        oil=Oil("two_point", "barus_1893", "carreau_1972", shear_thinning_exponent=0.6),
        roughness_rms=3e-6,
        flow_factors="patir_cheng_1978",
        peklenik_number_bore=6.0,
        coating_thickness=1e-5,
        film_fraction_lower_edge=0.6,
        film_fraction_upper_edge=0.5,
    ),
    **{name: physics(GRID)[name] for name in OF_OIL},
    "walther_1931": dict(oil=Oil("walther_1931"), oil_temperature_lower_edge=350.0),
    "two_point": dict(oil=Oil("two_point", viscosity_40=0.08), oil_temperature_upper_edge=390.0),
    "filled in part": dict(initial_film_fraction=0.6, roughness_rms=1e-6),
}


def flat(changes):
    """Changes of `Parameters` as parameters of the FMU."""
    default = Oil()
    own = {k: v for k, v in changes.items() if k not in ("oil", "open_cells", "surface")}
    oil = changes.get("oil", default)
    return own | {
        entry.name: getattr(oil, entry.name)
        for entry in fields(Oil)
        if getattr(oil, entry.name) != getattr(default, entry.name)
    }


def started(path, film, velocity, **values):
    """An instance of the FMU after its initialisation."""
    one = FmuParticipant("film", path)
    numbered = {k: CHOICES[k].index(v) + 1 for k, v in values.items() if k in CHOICES}
    one.start(values | numbered | {"film_thickness": film, "sliding_velocity": velocity}, 0.0, 1.0)
    return one


def step(one, film, velocity, size=DEGREE, turning=None):
    one.set("film_thickness", film)
    one.set("sliding_velocity", velocity)
    if turning is not None:
        one.set(TURNING_INPUT, turning)
    one.step(reached(one), size)


def turned(shape, time):
    """Of a journal whose velocity differs from cell to cell [m/s]."""
    cells = np.arange(shape[0] * shape[1]).reshape(shape)
    return 4.0 * (1.0 + 0.5 * np.sin(300.0 * time)) + 0.02 * cells


def side_by_side(path, shape, changes, steps):
    """Largest difference of every output between FMU and model, over its largest value, in a run in
    which every tenth step is first taken otherwise and taken back; and of the derivatives.
    """
    model = LubricationModel(Parameters(shape, **changes))
    bearing = changes.get("surface") == "bearing"
    film, velocity = motored_film(shape, 0.0)
    turning = turned(shape, 0.0) if bearing else None
    state, outputs = model.start(film, velocity, turning)
    more = {TURNING_INPUT: turning} if bearing else {}
    one = started(path, film, velocity, **flat(changes), **more)
    rng = np.random.default_rng(0)
    largest = dict.fromkeys(outputs, 0.0)
    inputs, products_of = DERIVATIVE_INPUTS, DERIVATIVE_OUTPUTS
    if bearing:
        inputs, products_of = (*inputs, TURNING_INPUT), (*products_of, TURNING_OUTPUT)
    error = dict.fromkeys((*outputs, *products_of), 0.0)

    def compare():
        for name, value in outputs.items():
            largest[name] = max(largest[name], np.abs(value).max())
            error[name] = max(error[name], np.abs(one.get(name) - value).max())

    compare()
    for k in range(1, steps + 1):
        size = UNEVEN if k % 7 == 0 else DEGREE
        film, velocity = motored_film(shape, k * DEGREE)
        turning = turned(shape, k * DEGREE) if bearing else None
        if k % 10 == 0:
            saved = one.save()
            step(one, 0.5 * film, -velocity, 3.0 * size, turning)
            one.restore(saved)
        step(one, film, velocity, size, turning)
        state, outputs = model.advance(state, film, velocity, size, turning)
        compare()
        if k % 10 == 5:
            seeds = rng.standard_normal((3, *shape)) * [[[1e-6]], [[1.0]], [[1.0]]]
            seeds = dict(zip(inputs, seeds))
            products = one.derivative(seeds, products_of)
            for name, value in zip(products_of, model.tangent(*seeds.values())):
                off = np.abs(products[name] - value).max() / max(np.abs(value).max(), 1e-300)
                error[name] = max(error[name], off)
    one.close()
    largest["mass_imbalance"] = 1.0  # a share of the oil already, and round-off by itself
    return {
        name: e / largest[name] if largest.get(name) else e for name, e in error.items() if e > 0.0
    }


@pytest.mark.parametrize("name", COVERED_PHYSICS)
def test_values_are_the_bits_of_the_model(native_fmu, name):
    differing = side_by_side(native_fmu, GRID, COVERED_PHYSICS[name], 120)
    assert differing == {}


@pytest.mark.parametrize("name", OTHER_OILS)
def test_values_of_laws_with_functions_of_the_c_library_are_the_models(native_fmu, name):
    # two C libraries' exp and log differ by a bit, and a film passes a few of these on
    differing = side_by_side(native_fmu, GRID, OTHER_OILS[name], 60)
    assert max(differing.values(), default=0.0) <= 1e-11


def mask_of(changes):
    """Build option of the open cells of a model."""
    cells = changes.get("open_cells")
    return {} if cells is None else {"mask": (~cells).astype(int).tolist()}


def test_another_grid_has_the_same_library_and_the_models_bits(native_fmu, make_native):
    other = make_native([9, 16])
    name = "binaries/linux64/fmu_ehd.so"
    libraries = [zipfile.ZipFile(path).read(name) for path in (native_fmu, other)]
    assert libraries[0] == libraries[1]
    differing = side_by_side(other, (9, 16), dict(roughness_rms=3e-6), 60)
    assert differing == {}


SCARCE = dict(film_fraction_lower_edge=0.7, film_fraction_upper_edge=0.8)
FED = dict(opening_supply="own", pressure_openings=3e5, cavitation_pressure=-5e4)


@pytest.mark.parametrize("around", [SCARCE, FED])
def test_beside_cut_outs_the_values_are_the_bits_of_the_model(make_native, around):
    """Windows on both sides, one across the first row, single ones at an edge and within, and a
    film cell with none beside it; surfaces that touch.
    """
    open_cells = opening(GRID)
    open_cells[4, 0] = open_cells[9, 5] = open_cells[2, 9] = True
    open_cells[[3, 3, 2, 4], [3, 5, 4, 4]] = True
    changes = dict(around, open_cells=open_cells, roughness_rms=3e-6)
    assert side_by_side(make_native([*GRID], **mask_of(changes)), GRID, changes, 90) == {}


@pytest.mark.parametrize("name", WITH_CUT_OUTS)
def test_beside_cut_outs_every_choice_has_the_values_of_the_model(make_native, name):
    """All laws at once, too; surfaces that touch, oil that is scarce."""
    changes = physics(GRID)[name]
    differing = side_by_side(make_native([*GRID], **mask_of(changes)), GRID, changes, 60)
    # exp and log of C libraries, as of oils; Newton's method on a coating ends at 1e-11 of it
    assert max(differing.values(), default=0.0) <= (1e-9 if name == "everything" else 0.0)


BEARINGS = {
    "ring": dict(film_fraction_lower_edge=0.6, initial_film_fraction=0.7),
    "groove and holes": dict(FED, roughness_rms=3e-6, open_cells=opening(GRID)),
    "sector": dict(
        sector_angle=2.5, opening_supply="own", pressure_openings=1e5, roughness_rms=3e-6
    ),
    "coated": dict(coating_thickness=2e-5, roughness_rms=3e-6, cavity_shear="full_film"),
    "any oil": dict(oil=Oil("vogel_1921", "roelands_1966", "cross_1965"), roughness_rms=3e-6),
    "flow factors": dict(
        roughness_rms=3e-6, flow_factors="patir_cheng_1978", peklenik_number_skirt=0.25
    ),
}


@pytest.mark.parametrize("name", BEARINGS)
def test_a_bearing_has_the_bits_of_the_model(make_native, name):
    """Sliding both ways, the film filled in part; from the library of skirts."""
    changes = dict(BEARINGS[name], surface="bearing")
    path = make_native([*GRID], surface="bearing", **mask_of(changes))
    differing = side_by_side(path, GRID, changes, 60)
    # exp and log of C libraries
    assert max(differing.values(), default=0.0) <= (
        1e-11 if name in ("any oil", "flow factors") else 0.0
    )


ON_BORE = dict(initial_oil_layer=4e-6, initial_film_fraction=0.5, chamfer_capacity=1e-8)
SUPPLIED = {
    "bore": dict(ON_BORE, oil_supply="bore", roughness_rms=3e-6),
    "ring and splash": dict(ON_BORE, oil_supply="bore_and_ring", oil_splash=1e-3),
    "below ambient": dict(
        ON_BORE,
        oil_supply="bore_and_ring",
        cavitation_pressure=-5e4,
        pressure_lower_edge=-5e4,
        pressure_upper_edge=-5e4,
        coating_thickness=2e-5,
    ),
    "cut-outs": dict(
        ON_BORE,
        oil_supply="bore_and_ring",
        oil_splash=1e-3,
        roughness_rms=3e-6,
        open_cells=opening(GRID),
    ),
}


@pytest.mark.parametrize("name", SUPPLIED)
def test_oil_on_the_bore_has_the_bits_of_the_model(make_native, name):
    """Oil that is scarce, over two strokes and more; steps taken back take the layer back."""
    changes = SUPPLIED[name]
    assert side_by_side(make_native([*GRID], **mask_of(changes)), GRID, changes, 400) == {}


LARGEST_STATE = 300_000
"""Bytes of a state on 40 x 40 cells, of which the variables of the FMU are 90 000."""


@pytest.mark.parametrize("native", [True, False])
@pytest.mark.parametrize("name", ["ring and splash", "coated"])
def test_a_saved_state_is_small_and_continues_with_the_same_bits(make_native, native, name):
    """A run goes on as another instance does that gets its state as bytes."""
    shape = (40, 40)
    changes = SUPPLIED["ring and splash"] if name != "coated" else dict(coating_thickness=2e-5)
    path = make_native([*shape])
    if not native:
        path = builder.build_fmu("fmu_ehd", {"grid": [*shape]}, Path("."))
    first, other = (started(path, *motored_film(shape, 0.0), **flat(changes)) for _ in range(2))
    for k in range(1, 21):
        step(first, *motored_film(shape, k * DEGREE))
    data = first.serialise(first.save())
    assert len(data) <= LARGEST_STATE
    other.restore(other.deserialise(data))
    for k in range(21, 31):
        for one in (first, other):
            step(one, *motored_film(shape, k * DEGREE), UNEVEN if k == 24 else DEGREE)
    for field in first.fields:
        assert np.array_equal(first.get(field), other.get(field)), field
    assert first.serialise(first.save()) == other.serialise(other.save())
    first.close()
    other.close()


def test_a_cut_out_may_have_any_temperature(make_native):
    """Oil as warm as the nearest film's is what it shows to the film beside it."""
    shape = (6, 5)
    mask = np.ones(shape, dtype=int)
    mask[2, 1:4] = mask[5, 0] = 0
    path = make_native([*shape], inputs=["oil_temperature"], mask=mask.tolist())
    model = LubricationModel(Parameters(shape, Oil("vogel_1921"), open_cells=mask == 0))
    temperature = np.linspace(340.0, 400.0, 30).reshape(shape)
    film, velocity = motored_film(shape, 0.0)
    around = dict(viscosity_law="vogel_1921", oil_temperature=temperature)
    state, _ = model.start(film, velocity, oil_temperature=temperature)
    one = started(path, film, velocity, **around)
    one.set("oil_temperature", np.where(mask == 1, temperature, 290.0))
    film, velocity = motored_film(shape, DEGREE)
    state, outputs = model.advance(state, film, velocity, DEGREE, oil_temperature=temperature)
    step(one, film, velocity)
    force = outputs["nodal_friction_force"]
    assert np.abs(one.get("nodal_friction_force") - force).max() <= 1e-11 * np.abs(force).max()
    one.close()


def test_fmi_3_has_the_same_bits(native_fmu):
    """Over steps whose ends are exact, for FMI 3 hands on the end less the beginning."""
    path = build_native_fmu("fmu_ehd", {"grid": list(GRID)}, Path("."), version="3.0")
    film, velocity = motored_film(GRID, 0.0)
    answers = []
    for one in (FmuParticipant("film", native_fmu), Fmu3Participant("film", path)):
        one.start({"film_thickness": film, "sliding_velocity": velocity}, 0.0, 1.0)
        for k in range(3):
            one.set("film_thickness", film * (1.0 - 0.1 * k))
            one.step(k * 2.0**-14, 2.0**-14)
        seeds = {"film_thickness": 1e-6 * velocity, "sliding_velocity": velocity}
        answers.append([one.get("nodal_pressure_force").copy()])
        answers[-1] += one.derivative(seeds, DERIVATIVE_OUTPUTS).values()
        one.close()
    assert all(np.array_equal(a, b) for a, b in zip(*answers))


@pytest.mark.parametrize("inputs", [[], ["oil_temperature_lower_edge", "pressure_upper_edge"]])
def test_conditions_change_between_steps(make_native, inputs):
    """Temperature and pressure of an edge as tunable parameters, and as inputs; in Python, too.
    The oil thins as well.
    """
    shape = (6, 5)
    options = dict(grid=[*shape], inputs=inputs)
    paths = make_native([*shape], inputs=inputs), builder.build_fmu("fmu_ehd", options, Path("."))
    film, velocity = motored_film(shape, 0.0)
    both = [started(path, film, velocity, viscosity_law="vogel_1921") for path in paths]
    model = LubricationModel(Parameters(shape, Oil("vogel_1921")))
    state, _ = model.start(film, velocity)
    for k in range(1, 6):
        around = dict(oil_temperature_lower_edge=373.15 + 5.0 * k, pressure_upper_edge=1e4 * k)
        around["vogel_b"] = 1010.0 - 20.0 * k
        film, velocity = motored_film(shape, k * DEGREE)
        state, outputs = model.advance(state, film, velocity, DEGREE, **around)
        force = outputs["nodal_friction_force"]
        for one in both:
            for name, value in around.items():
                one.set(name, value)
            step(one, film, velocity)
            # exp of another library
            off = np.abs(one.get("nodal_friction_force") - force).max()
            assert off <= 1e-11 * np.abs(force).max()
    for one in both:
        one.close()


def test_inputs_in_place_of_parameters(make_native):
    """Pressure of an edge and a field of temperatures that change from step to step."""
    path = make_native([6, 5], inputs=["pressure_upper_edge", "oil_temperature"])
    shape = (6, 5)
    oil = Oil("vogel_1921")
    model = LubricationModel(Parameters(shape, oil))
    temperature = np.linspace(340.0, 400.0, 30).reshape(shape)
    film, velocity = motored_film(shape, 0.0)
    state, _ = model.start(film, velocity, oil_temperature=temperature, pressure_upper_edge=1e5)
    one = started(
        path,
        film,
        velocity,
        viscosity_law="vogel_1921",
        oil_temperature=temperature,
        pressure_upper_edge=1e5,
    )
    for k in range(1, 10):
        around = dict(oil_temperature=temperature + k, pressure_upper_edge=1e5 + 1e4 * k)
        film, velocity = motored_film(shape, k * DEGREE)
        state, outputs = model.advance(state, film, velocity, DEGREE, **around)
        for name, value in around.items():
            one.set(name, value)
        step(one, film, velocity)
        force = outputs["nodal_pressure_force"]
        # exp of another library
        assert np.abs(one.get("nodal_pressure_force") - force).max() <= 1e-11 * np.abs(force).max()
    one.set("pressure_upper_edge", -1.0)
    with pytest.raises(Discard, match="pressure_upper_edge: expected at least"):
        one.step(reached(one), DEGREE)
    one.close()


# ---- what is covered


def test_every_choice_and_number_is_covered():
    assert set(CHOICES) == set(CHOSEN)
    both = [v for kind in ("skirt", "bearing") for v in variables((4, 4), surface=kind)]
    free = {v.name for v in both if v.causality == "parameter" and not v.choices}
    assert free == set(NUMBERS)
    given = {v.name for v in both if v.causality == "output"}
    assert given == {*Fields._fields, *Scalars._fields, "solver_iterations"}


@pytest.mark.parametrize(
    "name, value, words",
    [
        ("flow_factors", "patir_cheng_1978", "roughness_rms: expected more than 0 m"),
        ("bore_radius", 7.0, "bore_radius: expected 0.001 to 1 m, got 7 m"),
        ("pressure_lower_edge", -1e3, "pressure_lower_edge: expected at least cavitation_pressure"),
        (
            "film_fraction_openings",
            0.5,
            "film_fraction_openings, pressure_openings: expected 1 and 0 Pa",
        ),
    ],
)
def test_what_cannot_start_is_said_by_name(native_fmu, name, value, words):
    with pytest.raises(BadInput) as refusal:
        started(native_fmu, *motored_film(GRID, 0.0), **{name: value}).close()
    assert words in str(refusal.value)


@pytest.mark.parametrize(
    "wrong, words",
    [
        (
            dict(stroke=0.2, pressure_upper_edge=1e5),
            ["stroke: expected at most 0.162 m for skirt_length = 0.027 m", "got 0.2 m"]
            + [
                "pressure_upper_edge: expected cavitation_pressure = 0 Pa with oil_supply = bore or"
            ],
        ),
        (
            dict(opening_supply="own"),
            ["opening_supply: expected lower_edge with oil_supply = bore", "got own"],
        ),
    ],
)
def test_what_does_not_go_with_oil_from_the_bore_is_said_by_name(native_fmu, wrong, words):
    with pytest.raises(BadInput) as refusal:
        started(native_fmu, *motored_film(GRID, 0.0), oil_supply="bore", **wrong).close()
    assert all(word in str(refusal.value) for word in words)


def test_farther_than_the_stroke_is_refused_in_the_words_of_the_model(native_fmu):
    film, velocity = motored_film(GRID, 0.0)
    one = started(native_fmu, film, velocity, oil_supply="bore", stroke=1e-3)
    with pytest.raises(Discard, match="comes to 0.0.* m from .*, farther than stroke = 0.001 m"):
        for _ in range(20):
            step(one, film, velocity, 1e-4)
    one.close()


def test_options_that_are_not_covered_are_refused_before_anything_is_compiled():
    options = dict(
        grid=[200, 4], surface="bearing", inputs=[], mask=[[0, 1, 1, 1]], no_fields=False, oil={}
    )
    assert len(list(uncovered(options))) == 1
    with pytest.raises(BadInput, match="grid: expected at most 192"):
        build_native_fmu("fmu_ehd", {"grid": [193, 8]}, Path("."))
    with pytest.raises(BadInput, match="platform: expected one of linux64"):
        build_native_fmu("fmu_ehd", {"grid": [8, 8]}, Path("."), platforms=["beos"])


@pytest.mark.parametrize(
    "participant, options, platform, words",
    [
        ("ehd", {"grid": [193, 8]}, "linux64", "grid: expected at most 192"),
        ("ehd", {}, "beos", "platform: expected one of linux64"),
    ],
)
def test_what_is_not_covered_is_refused_before_a_body_is_reduced(
    monkeypatch, participant, options, platform, words
):
    """The mask of a film comes from the mesh of its body."""
    bodies = importlib.import_module("piston_cosim.fmu_mfbd.build")
    monkeypatch.setattr(bodies, "prepare", lambda *_: pytest.fail("a body was reduced"))
    with pytest.raises(BadInput, match=words):
        build_fmu("numerical_example", participant, options=options, platforms=[platform])


@pytest.mark.parametrize(
    "shift, words",
    [
        (-1e-3, r"film_thickness\[\d+,\d+\] = -0\.\d+ m, and nowhere above 0 m: there is no film"),
        (np.nan, r"film_thickness\[1,1\]: expected a finite value"),
    ],
)
def test_a_refused_step_says_why_in_the_words_of_the_model(native_fmu, shift, words):
    film, velocity = motored_film(GRID, 0.0)
    one = started(native_fmu, film, velocity)
    with pytest.raises(Discard, match=words):
        step(one, film + shift, velocity)
    with pytest.raises(Exception, match="the last step was refused, or there was none"):
        one.derivative({"film_thickness": film}, DERIVATIVE_OUTPUTS)
    step(one, film, velocity)  # goes on
    one.close()


# ---- what it needs


def test_the_library_asks_for_the_c_library_alone(native_fmu, tmp_path):
    library = zipfile.ZipFile(native_fmu).extract("binaries/linux64/fmu_ehd.so", tmp_path)
    if not shutil.which("readelf"):
        pytest.skip("no readelf")
    told = subprocess.run(["readelf", "-d", library], capture_output=True, text=True, check=True)
    needed = [
        line.split("[")[1].rstrip("]") for line in told.stdout.splitlines() if "NEEDED" in line
    ]
    assert set(needed) <= {"libc.so.6", "libm.so.6", "ld-linux-x86-64.so.2"}


def test_machine_code_that_would_call_python_is_refused():
    calling = "declare void @{0}()\ndefine void @native_size() {{ call void @{0}() ret void }}"
    assert translated(calling.format("exp"), TARGETS["linux64"])
    assert "exp" in OPEN["functions"]
    with pytest.raises(RuntimeError, match="would call PyErr_Format"):
        translated(calling.format("PyErr_Format"), TARGETS["linux64"])


def test_the_library_exports_the_standard_alone(native_fmu, unpack, tmp_path):
    """The entries of the model are inner symbols, which no other library can replace."""
    (path,) = (unpack(native_fmu, tmp_path / "a").folder / "binaries/linux64").iterdir()
    library = ctypes.CDLL(str(path))
    assert hasattr(library, "fmi2DoStep")
    assert [name for name in ENTRIES if hasattr(library, f"fmu_ehd_{name}")] == []


def test_a_host_with_an_empty_environment_and_a_read_only_folder(
    host, native_fmu, unpack, tmp_path
):
    """No Python, no PATH, no HOME; the values of the model. Load, start and five steps take no
    longer than 0.1 s, all of the process.
    """
    place = unpack(native_fmu, tmp_path / "a place")
    cell = ("nodal_pressure_force[3,4]", "film_thickness[3,4]")
    given, size, steps = 2e-5, 5e-5, 3
    arguments = place.arguments("film_thickness[3,4]", given, *cell)
    command = [str(host), repr(size), str(steps), *map(str, arguments)]
    place.folder.chmod(0o555)
    times = []
    for _ in range(5):
        begin = time.perf_counter()
        done = subprocess.run(command, capture_output=True, text=True, cwd="/", env={}, timeout=60)
        times.append(time.perf_counter() - begin)
        assert done.returncode == 0, done.stderr
    force, product, length, same = map(float, done.stdout.split())
    model = LubricationModel(Parameters(GRID))
    film = np.full(GRID, 1e-5)
    film[2, 3] = given
    still = np.zeros(GRID)
    state, _ = model.start(film, still)
    for n in range(steps + 1):
        film[2, 3] = given * (1 - 100 * (n * size))
        state, outputs = model.advance(state, film, still, size)
    seed = np.zeros(GRID)
    seed[2, 3] = 1.0
    assert force == outputs["nodal_pressure_force"][2, 3] != 0.0
    assert product == model.tangent(seed, still)[0][2, 3] != 0.0
    assert same == 1.0
    # the state: packed, at least four fields that have nothing in common
    assert 4 < length / (8 * GRID[0] * GRID[1]) < 12
    assert min(times) <= 0.1


def test_a_film_of_many_cells_gives_its_first_outputs_at_once(host, make_native, unpack, tmp_path):
    """40 x 40 cells: from nothing to an output in 0.1 s, for a host in C that knows its references,
    and here through the arrays of FMI 3. (FMI 2 names 11 281 scalars; reading them takes FMPy a
    second.)
    """
    grid = [40, 40]
    place = unpack(make_native(grid), tmp_path / "place")
    cell = ("nodal_pressure_force[3,4]", "film_thickness[3,4]")
    arguments = place.arguments("film_thickness[3,4]", 2e-5, *cell)
    in_c, in_python = [], []
    path = build_native_fmu("fmu_ehd", {"grid": grid}, Path("."), version="3.0")
    for _ in range(5):
        begin = time.perf_counter()
        command = [str(host), "5e-5", "1", *map(str, arguments)]
        subprocess.run(command, check=True, capture_output=True, env={})
        in_c.append(time.perf_counter() - begin)
        begin = time.perf_counter()
        one = Fmu3Participant("film", path)
        film, velocity = motored_film(grid, 0.0)
        one.start({"film_thickness": film, "sliding_velocity": velocity}, 0.0, 1.0)
        one.step(0.0, DEGREE)
        force = one.get("nodal_pressure_force")
        in_python.append(time.perf_counter() - begin)
        assert force.max() > 0.0
        one.close()
    assert min(in_c) <= 0.1 and min(in_python) <= 0.1


# ---- other machines


@pytest.mark.slow
@pytest.mark.parametrize(
    "platform, emulator",
    [("aarch64-linux", ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"]), ("win64", ["wine"])],
)
def test_other_machines_give_the_same_bits(native_fmu, unpack, host, tmp_path, platform, emulator):
    """The same host program, compiled for the machine, under an emulator."""
    compiler = compiler_of(platform)
    if compiler is None or shutil.which(emulator[0]) is None:
        pytest.skip(f"{platform}: needs its C compiler and {emulator[0]}")
    path = build_native_fmu("fmu_ehd", {"grid": list(GRID)}, Path("."), platforms=[platform])
    there, here = unpack(path, tmp_path / "there"), unpack(native_fmu, tmp_path / "here")
    program = tmp_path / "driver.exe"
    driver = Path(__file__).parent / "native_driver.c"
    subprocess.run([*compiler, "-o", str(program), str(driver), "-lm"], check=True)
    own = tmp_path / "driver"
    subprocess.run(["cc", "-o", str(own), str(driver), "-lm", "-ldl"], check=True)
    answers = []
    for command, place, folder, ending in (
        ([str(own)], here, "linux64", "so"),
        (
            [*emulator, str(program)],
            there,
            platform,
            "dll" if platform == "win64" else "so",
        ),
    ):
        library = place.folder / "binaries" / folder / f"fmu_ehd.{ending}"
        first = {
            name: str(place.references[f"{name}[1,1]"])
            for name in ("film_thickness", "sliding_velocity", "nodal_pressure_force")
        }
        arguments = [library, place.location, place.description.guid, "120", "200", *first.values()]
        environment = {**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": str(tmp_path / "wine")}
        done = subprocess.run(
            [*command, *map(str, arguments)],
            capture_output=True,
            timeout=500,
            env=environment,
        )
        assert done.returncode == 0, done.stderr
        answers.append(done.stdout.replace(b"\r", b""))
    assert answers[0].count(b"\n") == 200
    assert answers[0] == answers[1]
