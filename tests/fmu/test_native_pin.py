"""The body FMU with a floating pin that needs no Python, beside the FMU in Python: bits where no
matrices are multiplied, else products of another library; runs with both, and all in one FMU.
"""

from itertools import pairwise

import numpy as np
import pytest

from piston_cosim.master.case.ahead import declared_participants, parameters_ahead
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.contract import swap
from piston_cosim.master.case.export import export_fmu
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.participants.fmi2 import FmuParticipant

from .conftest import native
from .test_crank_bearings import PATH as CRANK_BEARINGS
from .test_crank_bearings import small as small_crank
from .test_floating_pin import PATH, computed, small
from .test_yielding_bosses import EYE, OF_PIN, settings
from .test_yielding_bosses import PATH as YIELDING

ROUND_OFF = 1e-12  # of the largest value of an output: some hundred roundings
SUMS = 1e-10  # sums in another order, by a linear solve that multiplies their difference
ROUND_OFF_ITSELF = (
    "evaluations",
    "work_error",
    "mass_imbalance",
    "energy_error",
    "friction_force_hydrodynamic",
)
"""Counts, and shares and forces that are differences of what is equal."""
OFFSETS = [
    ("participants.bodies.build.piston.pin_offset", "0.8 mm"),
    ("participants.bodies.parameters.crank_offset", "1.5 mm"),
]
"""Of pin and crank: without them half the terms are zero."""
MOTION = ("lateral_velocity", "rocking_velocity", "piston_velocity")


def of_bodies(tree, path):
    """Build table of a case's bodies, its folder, and the parameters."""
    case = check_case(tree, path)
    table = case.participants["bodies"]
    values = parameters_ahead(case, declared_participants(case, path.parent, []), [])
    return (table.package, table.build, path.parent), values["bodies"]


CASES = {
    "rigid": lambda: of_bodies(small(*OFFSETS, skirt=(12, 10), pin=(24, 4)), PATH),
    "crank": lambda: of_bodies(
        small_crank(*OFFSETS, skirt=(12, 10), pin=(24, 4), crank=(20, 4)), CRANK_BEARINGS
    ),
    "yielding": lambda: of_bodies(
        read_tree(YIELDING, settings((f"{OF_PIN}.small_end", EYE))), YIELDING
    ),
}


@pytest.fixture(scope="module")
def both():
    """FMU in Python and native FMU of a case's bodies, and its parameters."""
    made = {}

    def make(name):
        if name not in made:
            build, values = CASES[name]()
            made[name] = build_fmu(*build), native(*build), values
        return made[name]

    return make


def given(one, k):
    """Rough loads on all films of a participant that turn round, a thousand newtons on each of the
    pin's.
    """
    rng = np.random.default_rng(k)
    values = {
        "gas_pressure": 1e4 * k,
        "ring_side_force": 10.0 * np.sin(k),
        "ring_axial_force": -20.0,
        "ring_moment": 0.05 * np.cos(k),
        "crank_speed": 180.0 + k,
        "piston_temperature": 293.15 + 0.5 * k,
        "bore_temperature": 293.15 - 0.2 * k,
        "rayleigh_mass_factor": 100.0 * (k % 3),
    }
    for name, field in one.fields.items():
        film, _, what = name.rpartition(".")
        size = 5.0 if film == "skirt" else 40.0
        if what == "nodal_pressure_force":
            values[name] = size * rng.random(field.shape) * (1 + np.sin(0.3 * k))
        elif what.startswith("nodal_"):
            values[name] = 0.1 * size * rng.standard_normal(field.shape)
    return values


def seeds_of(one, rng):
    """Directions of all that has derivatives."""
    names = [n for n in one.fields if n.rpartition(".")[2].startswith("nodal_")]
    names = [n for n in names if n.startswith("skirt.") or not n.endswith("_friction_force")]
    names += ["ring_side_force", "ring_axial_force", "ring_moment"]
    return {name: rng.standard_normal(np.shape(one.get(name))) for name in names}


def products_of(one):
    """What has derivatives."""
    ends = ("film_thickness", "circumferential_velocity")
    fields = [n for n in one.fields if n.endswith(ends)]
    return [*fields, "skirt.sliding_velocity", *MOTION]


def side_by_side(python, native, values, steps=24):
    """Largest difference of every output and derivative, by its largest value; every sixth step is
    first taken otherwise and taken back, once by a state that went through bytes.
    """
    pair = [FmuParticipant("bodies", path) for path in (python, native)]
    names = [name for name, field in pair[0].fields.items() if field.causality == "output"]
    largest, off = {}, {}
    rng = np.random.default_rng(9)

    def compare(found, of=""):
        for name in found[0]:
            a, b = (np.asarray(one[name], dtype=float) for one in found)
            largest[of + name] = max(largest.get(of + name, 0.0), float(np.abs(a).max()))
            off[of + name] = max(off.get(of + name, 0.0), float(np.abs(a - b).max()))

    for one in pair:
        one.start(values | given(one, 0), 0.0, 1.0)
    compare([{name: one.get(name) for name in names} for one in pair])
    time = 0.0
    for k in range(1, steps + 1):
        size = (1 + k % 3) * 2.0**-15
        for one in pair:
            for name, value in given(one, k).items():
                one.set(name, value)
            if k % 6 == 0:
                saved = one.save()
                one.step(time, 2.0**-13)
                if k == 12:
                    saved = one._fmu.deSerializeFMUstate(one.serialise(saved))
                one.restore(saved)
            one.step(time, size)
        time += size
        compare([{name: one.get(name) for name in names} for one in pair])
        if k % 4 == 0:
            seeds, wanted = seeds_of(pair[0], rng), products_of(pair[0])
            compare([one.derivative(seeds, wanted) for one in pair], "of ")
    for one in pair:
        one.close()
    assert largest["lateral_displacement"] > 1e-6 and largest["pin_displacement_y"] > 1e-6
    # round-off by itself
    return {n: e / largest[n] for n, e in off.items() if e and "interface_work_error" not in n}


def the_bits(off):
    """Whether nothing differs but the account, whose products of vectors are numpy's in Python."""
    account = [off.pop(name, 0.0) for name in ("energy_gain", "energy_size")]
    return off == {} and max(account) <= ROUND_OFF


@pytest.mark.parametrize("name", ["rigid", "crank"])
def test_rigid_bodies_on_a_floating_pin_have_the_bits_of_the_slave(both, name):
    """Three films of the pin, and two of the crank: outputs, derivatives, steps taken back."""
    assert the_bits(side_by_side(*both(name)))


def test_bosses_and_an_eye_that_yield_are_those_of_the_slave(both):
    """Products with 50 and 40 modes are those of another library."""
    off = side_by_side(*both("yielding"), steps=12)
    assert max(off.values(), default=0.0) <= ROUND_OFF


# ---- in a run


def test_a_run_with_native_bodies_is_the_run_in_python(both, tmp_path):
    """Four films in Python, the bodies natively: the same motion in as many iterations."""
    tree = small(stop="20 deg")
    table = check_case(tree, PATH).participants["bodies"]
    swapped, left_out = swap(tree, "bodies", native(table.package, table.build, PATH.parent))
    assert left_out == []
    ports = ("lateral_displacement", "pin_displacement_y", "side_force", "pin_rotation_speed")
    found = [computed(one, tmp_path / f"{k}.h5") for k, one in enumerate((tree, swapped))]
    for name in ("steps", "mean_iterations", "unconverged_steps", "derivative_products"):
        assert found[1].summary[name] == found[0].summary[name]
    for port in ports:
        a, b = (one.series(f"bodies.{port}").values for one in found)
        assert np.array_equal(a, b), port


def test_bodies_and_four_films_in_one_native_fmu_are_those_of_the_fmu_in_python(tmp_path):
    """`fmu export floating_pin --native` stepped beside the same without it."""
    tree = small(stop="12 deg", skirt=(12, 10), pin=(24, 4))
    results = computed(tree, tmp_path / "run.h5")
    case = check_case(tree, PATH)
    pair = [
        FmuParticipant("coupled", export_fmu(case, PATH.parent, print, "2.0", platforms))
        for platforms in ((), ("linux64",))
    ]
    for one in pair:
        one.start({}, 0.0, 1.0)
    for begin, end in pairwise(results.time):
        for one in pair:
            one.step(begin, end - begin)
    moved = 0
    for name, field in pair[0].fields.items():
        if field.causality != "output" or name.endswith(ROUND_OFF_ITSELF):
            continue
        a, b = (np.asarray(one.get(name), dtype=float) for one in pair)
        assert np.abs(a - b).max() <= SUMS * max(np.abs(a).max(), 1e-9), name
        moved += np.abs(a).max() > 0.0
    assert moved > 20
    for one in pair:
        one.close()
