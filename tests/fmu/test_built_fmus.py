"""Calls that every built FMU answers alike, in Python and native, of FMI 2.0 and 3.0.

The FMUs are a film, bodies, a coupled case and two lags in a loop.
"""

from itertools import product
from pathlib import Path

import numpy as np
import pytest

from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.fmi.errors import BadInput, Discard
from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.master.participants.open import open_fmu
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

from ..mfbd.conftest import write_bodies
from .films import PATH as DATA_SHEET
from .runs import EXAMPLE, coarse, export, make, problems_of, reached, small_tree
from .test_native_bodies import GAS
from .test_native_bodies import given as given_to_bodies
from .test_native_coupled import COUNTS, HARD, STEP
from .test_native_coupled import given as given_to_coupled
from .test_native_fmu import GRID, numbered
from .test_native_lags import OUTSIDE, TREE, made_of_lags
from .test_native_lags import given as given_to_lags

BACKENDS, VERSIONS = ("python", "native"), ("2.0", "3.0")
START = {
    "film": numbered({"roughness_rms": 3e-6, "oil_supply": "bore_and_ring", "oil_splash": 1e-3}),
    "bodies": {"crank_offset": 1e-3, "barrel": 15e-6},
    "coupled": HARD,
    "lags": {},
}
"""Kind -> parameters; of all kinds others than the default but of the lags."""
GIVEN = {
    "film": lambda one, k: motored_film(GRID, k * DEGREE)._asdict(),
    "bodies": given_to_bodies,
    "coupled": given_to_coupled,
    "lags": given_to_lags,
}
LENGTH = {"film": 2.0**-14, "bodies": 2.0**-15, "coupled": STEP, "lags": 0.125}
"""Of a step [s]."""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """Return a builder of the FMU of a kind, a backend and a version of FMI; each is built once."""
    folder, table = write_bodies(tmp_path_factory.mktemp("bodies"), 16, 1, (6, 4))
    makers = {
        "film": lambda *how: make("fmu_ehd", {"grid": [*GRID]}, Path("."), *how),
        "bodies": lambda *how: make("fmu_mfbd", table | {"gas": GAS}, folder, *how),
        "coupled": lambda *how: export(small_tree(("time.stop", "12 deg")), EXAMPLE, *how),
        "engine": lambda *how: export(read_tree(DATA_SHEET, coarse(modes=None)), DATA_SHEET, *how),
        "lags": lambda *how: export(TREE, OUTSIDE / "case.toml", *how),
    }
    made = {}

    def one(kind, backend, version="2.0"):
        key = kind, backend, version
        if key not in made:
            made[key] = makers[kind](backend == "native", version)
        return made[key]

    with made_of_lags():
        yield one


@pytest.fixture(params=product(START, BACKENDS, VERSIONS), ids="-".join)
def each(request, built):
    """Kind and backend of every FMU, and a function that starts an instance."""
    kind, backend, version = request.param
    path, made = built(kind, backend, version), []

    def start(values=START[kind]):
        one = open_fmu(kind, path)
        made.append(one)
        one.start(values | GIVEN[kind](one, 0), 0.0, np.inf)
        return one

    yield kind, backend, start
    for one in made:
        one.close()


def step(one, k, length=None, **inputs):
    """Take the k-th step, of a length [s] and with inputs that may be others."""
    for name, value in (GIVEN[one.name](one, k) | inputs).items():
        one.set(name, value)
    one.step(reached(one), LENGTH[one.name] if length is None else length)


def seen(one):
    """All outputs but counts of work."""
    return {
        name: np.array(one.get(name))
        for name, field in one.fields.items()
        if field.causality == "output" and not name.endswith(COUNTS)
    }


def same(one, other):
    return [name for name in one if not np.array_equal(one[name], other[name])] == []


def test_a_state_is_whole(each):
    """A step repeated from a saved or a serialised state gives the same bits.

    It does so in this instance and in another that started with other parameters. Instances do not
    share their state.
    """
    _, _, start = each
    one, two, last = start(), start({}), start()
    step(one, 1)
    first = seen(one)
    for k in (2, 3):
        step(one, k)
    saved = one.save()
    data = one.serialise(saved)
    step(one, 4)
    step(one, 5)
    after, bytes_after = seen(one), one.serialise(one.save())
    assert not same(first, after)
    two.restore(two.deserialise(data))
    step(one, 6)
    one.restore(saved)
    for participant in (one, two):
        step(participant, 4)
        step(participant, 5)
        assert same(seen(participant), after)
        assert participant.serialise(participant.save()) == bytes_after
    damaged = bytearray(data)
    damaged[len(data) // 2] ^= 1
    with pytest.raises(Exception, match="[Ff]ailed|damaged|error"):
        two.deserialise(bytes(damaged))
    step(last, 1)
    assert same(seen(last), first)


THICK = np.full(GRID, 2e-5)
HOLE = np.where(np.arange(120).reshape(GRID) == 0, np.nan, THICK)
LENGTHS = [({}, 0.0, "step size"), ({}, -1.0, "step size")]
TOO_LONG = ({}, 1e300, r"step size = .* s: more than 1e\+06 macro steps")
REJECTED = {
    "film": [
        *LENGTHS,
        (
            {"film_thickness": THICK - 1e-3},
            None,
            r"film_thickness\[\d+,\d+\]: expected more than -4.5e-06 m, got -0\.\d+ m",
        ),
        ({"film_thickness": HOLE}, None, r"film_thickness\[1,1\]: expected a finite value"),
        ({"film_thickness": THICK * np.inf}, None, r"film_thickness\[1,1\]: expected a finite"),
    ],
    "bodies": [
        *LENGTHS,
        ({"gas_pressure": 1e9}, None, r"gas_pressure: expected -200000 to 1e\+08 Pa, got 1e\+09"),
        ({"ring_moment": np.nan}, None, "ring_moment: expected a finite value"),
        ({"crank_speed": 3e3}, 1e308, "crank angle = inf rad: must be finite"),
    ],
    "coupled": [
        *LENGTHS,
        (
            {"ring_side_force": 1e9},
            None,
            "t = 2.95139e-05 s, step 4.34.*bodies: piston motion at crank angle 0.0188168 rad",
        ),
        ({"damping_ratio": 3.0}, None, "damping_ratio: expected 0 to 2, got 3"),
        TOO_LONG,
    ],
    "lags": [*LENGTHS, TOO_LONG],
}
"""Inputs and length of a step that is rejected, and words of the rejection."""


def test_a_rejected_step_says_why_and_leaves_everything_as_it_was(each):
    kind, backend, start = each
    one, other = start(), start()
    for participant in (one, other):
        step(participant, 1)
    before = seen(one)
    for inputs, length, words in REJECTED[kind]:
        with pytest.raises(Discard, match=f"(?s){words}"):
            step(one, 2, length, **inputs)
        assert same(seen(one), before), words
    for participant in (one, other):
        step(participant, 2)
    assert same(seen(one), seen(other))


def test_a_participant_that_rejects_each_step_says_why(built):
    for backend in BACKENDS:
        one = FmuParticipant("lags", built("lags", backend))
        one.start({"b.longest": 1e-6}, 0.0, 1.0)
        with pytest.raises(Discard, match="is too long"):
            step(one, 1)
        assert [one.get("a.x"), one.get("b.x")] == [1.0, 1.0]
        one.close()


def test_no_derivative_after_a_rejected_step(built):
    one = FmuParticipant("film", built("film", "native"))
    one.start({}, 0.0, 1.0)
    with pytest.raises(Discard):
        step(one, 1, film_thickness=HOLE)
    with pytest.raises(Exception, match="the last step was refused, or there was none"):
        one.derivative({"film_thickness": THICK}, ["nodal_pressure_force"])
    one.close()


SUPPLY = "film_fraction_openings, pressure_openings: expected 1 and 0 Pa"
CLEARANCE = "radial_clearance: expected 1e-06 to 0.001 m, got 7 m"
ROD = "rod_length: expected more than crank_radius plus the offsets"
CANNOT_START = {
    "film": [
        ({"flow_factors": "patir_cheng_1978"}, "roughness_rms: expected more than 0 m"),
        ({"bore_radius": 7.0}, "bore_radius: expected 0.001 to 1 m, got 7 m"),
        ({"pressure_lower_edge": -1e3}, "pressure_lower_edge: expected at least cavitation_pressu"),
        ({"film_fraction_openings": 0.5}, SUPPLY),
        (
            {"oil_supply": "bore", "pressure_upper_edge": 1e5},
            "pressure_upper_edge: expected cavitation_pressure = 0 Pa with oil_supply = bore or",
        ),
        (
            {"oil_supply": "bore", "opening_supply": "own"},
            "opening_supply: expected lower_edge with oil_supply = bore.*got own",
        ),
    ],
    "bodies": [
        ({"rod_length": 0.02}, f"{ROD}, .*, got 0.02 m"),
        ({"crank_radius": 0.06}, "crank_radius, rod_length: expected a skirt within the bore, .*"),
        ({"radial_clearance": 7.0}, CLEARANCE),
    ],
    "coupled": [
        ({"radial_clearance": 7.0}, CLEARANCE),
        ({"rod_length": 0.02}, f"bodies.*{ROD}"),
        ({"film_fraction_openings": 0.5}, SUPPLY),
    ],
    "lags": [],
}
NATIVE = {
    "film": [
        (
            {"oil_supply": "bore", "stroke": 0.2},
            "stroke: expected at most 0.162 m for skirt_length = 0.027 m.*got 0.2 m",
        )
    ],
    "coupled": [
        ({"oil_supply": "bore", "stroke": 0.3}, "ehd: stroke: expected at most 0.162 m"),
    ],
}
"""Parameters with which no run starts, and words of the rejection; further ones without Python."""


def test_what_cannot_start_is_said_by_name(each):
    kind, backend, start = each
    rows = CANNOT_START[kind] + (NATIVE.get(kind, []) if backend == "native" else [])
    for values, words in rows:
        with pytest.raises(BadInput, match=f"(?s){words}"):
            start(numbered(values))


@pytest.mark.parametrize("kind", START)
def test_fmi_3_has_the_bits_of_fmi_2(built, kind, backend):
    """Over steps whose ends are exact, for FMI 3 hands on the end less the beginning."""
    answers = []
    for version in VERSIONS:
        one = open_fmu(kind, built(kind, backend, version))
        one.start(START[kind] | GIVEN[kind](one, 0), 0.0, 1.0)
        for k in range(1, 4):
            for name, value in GIVEN[kind](one, k).items():
                one.set(name, value)
            one.step((k - 1) * 2.0**-15, 2.0**-15)
        answers.append(seen(one))
        if kind == "film":
            along = {"film_thickness": 1e-6 * THICK, "sliding_velocity": THICK}
            answers[-1] |= one.derivative(along, ["nodal_pressure_force", "nodal_friction_force"])
        one.close()
    assert set(answers[0]) <= set(answers[1])  # fields of a coupled FMU are outputs of FMI 3 alone
    assert same(*answers)
    assert kind != "coupled" or np.ptp(answers[1]["film_thickness"]) > 1e-6


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", START)
def test_description_is_valid(built, kind, backend, version):
    assert problems_of(built(kind, backend, version)) == []


@pytest.mark.parametrize("kind, angle, table", [("bodies", 200.0, 0.1e6), ("engine", 8.0, 6.8e6)])
def test_gas_is_of_table_or_input_and_both_are_told_once(built, kind, backend, angle, table):
    """The output of the gas pressure shows its source: the table, the input or their sum.

    The table of the bodies has 0.1 MPa, linear to 3 MPa at 0 and 720 deg. The data sheet's engine
    has 6.8 MPa near its peak. If `gas_source` is `either`, using both is logged once.
    """
    shown = {}
    for source in ("either", "table", "input", "sum"):
        one = FmuParticipant(kind, built(kind, backend))
        number = one.fields["gas_source"].choices[source]
        start = {"start_crank_angle": np.radians(angle), "gas_source": number}
        one.start(start | {"gas_pressure": 1e6, "crank_speed": 0.0}, 0.0, 1.0)
        told = [text for _, text in one.log if "gas_source" in text]
        for k in range(3):
            one.set("gas_pressure", 1e6)
            one.step(k * 1e-5, 1e-5)
            told += [text for _, text in one.log if "gas_source" in text]
            one.log.clear()
        shown[source] = one.get("cylinder_pressure")
        assert len(told) == (source == "either"), told
        one.close()
    assert shown["input"] == 1e6
    assert shown["either"] == shown["sum"] == shown["table"] + shown["input"]
    assert shown["table"] == pytest.approx(table, rel=1e-12 if kind == "bodies" else 0.05)


ALONE = """
import json, sys
import fmpy
output, stop, step = sys.argv[1].split()[1:]
result = fmpy.simulate_fmu(
    sys.argv[1].split()[0], stop_time=float(stop), output_interval=float(step), output=[output]
)
assert not any(name.split(".")[0] == "piston_cosim" for name in sys.modules)
print(json.dumps([len(result), float(result[output][-1])]))
"""


@pytest.mark.parametrize(
    "kind, backend, output",
    [
        ("film", "python", "minimum_film_thickness"),
        ("film", "native", "minimum_film_thickness"),
        ("bodies", "python", "crank_angle"),
        ("coupled", "python", "side_force"),
    ],
)
def test_fmpy_simulates_it_alone(built, outside, kind, backend, output):
    """In a process that has never imported the source."""
    times, last = outside(ALONE, f"{built(kind, backend)} {output} 1e-4 1e-5", "")
    assert times == 11
    if kind == "bodies":
        assert last == pytest.approx(1e-4 * 314.1592653589793, rel=1e-9)
