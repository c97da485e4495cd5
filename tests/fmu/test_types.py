"""Every type of FMI 3.0 passes from one FMU to another at the ends of its range.

Arrays are as long as a structural parameter says. Steps may end early, and an FMU may ask for
the end of the run.
"""

import numpy as np
import pytest

from piston_cosim.master.coupling.starting import closing
from piston_cosim.master.fmi.errors import BadInput, ParticipantFault
from piston_cosim.master.participants.open import open_fmu

from .c_fmus import MODELS, Variable, compile_model, describe, pack
from .counter import case_text
from .runs import open_text, run_text, stepper

LARGEST = {
    "Float32": 0.333251953125,  # a number of 24 bits
    "Int8": -(2**7),
    "UInt8": 2**8 - 1,
    "Int16": -(2**15),
    "UInt16": 2**16 - 1,
    "Int32": -(2**31),
    "UInt32": 2**32 - 1,
    "Int64": -(2**63),
    "UInt64": 2**64 - 1,
    "Boolean": True,
    "String": "\u00e4 < \u00b5",
    "Binary": "00ff7f",
    "Enumeration": "last",
}
ENUMERATION = (
    '<TypeDefinitions><EnumerationType name="Choice"><Item name="first" value="1"/>'
    '<Item name="last" value="7"/></EnumerationType></TypeDefinitions>'
)
TEXTS = {"String": '<Start value=""/>', "Binary": '<Start value="00"/>'}
ARRAY = '<Dimension valueReference="1"/>'
FAR = 'start="1e9"'


def of_kind(kind, k):
    """Input and output of a type."""
    more = ' declaredType="Choice"' if kind == "Enumeration" else ""
    start = {"Boolean": "false", "Enumeration": "1"}.get(kind, "0")
    given = "" if kind in TEXTS else f'start="{start}"'
    return (
        Variable(
            f"{kind}_in", 10 + k, "input", kind, given + more, "discrete", TEXTS.get(kind, "")
        ),
        Variable(f"{kind}_out", 30 + k, "output", kind, more, "discrete"),
    )


VARIABLES = [
    Variable("time", 0, "independent", "Float64"),
    Variable("n", 1, "structuralParameter", "UInt64", 'start="3"'),
    Variable("a_in", 2, "input", "Float64", 'start="0 0 0"', inside=ARRAY),
    Variable("a_out", 3, "output", "Float64", inside=ARRAY),
    Variable("ends_at", 4, "parameter", "Float64", FAR),
    Variable("grain", 5, "parameter", "Float64", FAR),
    Variable("events", 6, "output", "Float64", variability="discrete"),
    *(one for k, kind in enumerate(LARGEST) for one in of_kind(kind, k)),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("typed")
    flags = 'hasEventMode="true" mightReturnEarlyFromDoStep="true"'
    text = describe("3.0", "typed", VARIABLES, flags, before=ENUMERATION)
    library = folder / "typed.so"
    for name, announces in (("announces", ["-DANNOUNCES"]), ("typed", [])):
        compile_model(MODELS / "typed.c", library, *announces)
        pack(folder / f"{name}.fmu", text, library)
    return folder


def text(wires=(), **more):
    """Return a case of two such FMUs."""
    return case_text(wires, fmus=["typed.fmu"] * 2, **more)


def literal(value):
    return str(value).lower() if isinstance(value, bool | int | float) else f'"{value}"'


@pytest.mark.parametrize("own", ["", "isolated = true"])
def test_every_type_is_handed_on_unchanged(folder, own):
    wires = [(f"a.{t}_out", f"b.{t}_in", "") for t in LARGEST] + [("a.a_out", "b.a_in", "")]
    given = "".join(f"{t}_in = {literal(value)}\n" for t, value in LARGEST.items())
    given += "n = 5\na_in = [1.0, 2.0, 3.0, 4.0, 5.0]\n"
    case, system = open_text(folder, text(wires, a=given, b="n = 5", own=own))
    b = system.participants["b"]
    assert b.fields["a_in"].shape == (5,)
    with closing(system.participants.values()):
        steps = stepper(case, system)
        for k in range(2):  # what is held is what was said before the step
            steps.advance(0.1 * k, 0.1)
        found = {t: b.get(f"{t}_out") for t in LARGEST}
        assert found == LARGEST | {"Binary": bytes.fromhex("00ff7f"), "Enumeration": 7}
        assert b.get("a_out").tolist() == [1.0, 2.0, 3.0, 4.0, 5.0]


@pytest.mark.parametrize(
    "line, words",
    [
        ("Int8_in = 128", "Int8_in: expected -128 to 127, got 128"),
        ("UInt64_in = -1", "UInt64_in: expected 0 to 18446744073709551615"),
        ("Int32_in = 2147483648", "expected -2147483648 to 2147483647"),
        ("Int64_in = 0.5", "expected a whole number"),
        ("n = -1", "a dimension of length|expected 0 to"),
    ],
)
def test_what_does_not_fit_a_type_is_refused(folder, line, words):
    with pytest.raises(BadInput, match=words):
        open_text(folder, text(a=line))


def test_a_wire_whose_value_does_not_fit_ends_the_run(folder):
    wires = [("a.Int32_out", "b.Int8_in", "")]
    case, system = open_text(folder, text(wires, a="Int32_in = 300"))
    with closing(system.participants.values()):
        steps = stepper(case, system)
        words = "b: Int8_in: 300 does not fit its type, Int8, -128 to 127"
        with pytest.raises(ParticipantFault, match=words):
            steps.advance(0.0, 0.1)


@pytest.mark.parametrize("fmu", ["typed", "announces"])
def test_a_step_is_divided_at_events_in_it(folder, fmu):
    """Events at 0.04, 0.08, ...: two or three in a step of 0.1 s, at their times."""
    participant = open_fmu("one", folder / f"{fmu}.fmu")
    participant.start({"grain": 0.04}, 0.0, 1.0)
    for k in range(5):
        saved = participant.save()
        for _ in range(2):  # a saved state contains the next event
            participant.restore(saved)
            participant.step(0.1 * k, 0.1)
        participant.free(saved)
        end = 0.1 * (k + 1)
        assert participant.get("time") == pytest.approx(end, rel=1e-12)
        assert participant.get("events") == np.floor(end / 0.04 + 1e-9)
    participant.close()


def test_the_last_step_does_not_end_beyond_the_stop_time(folder):
    """In double precision 0.7 + 0.1 is below 0.8, and 8 * 0.1 is 0.8; 0.1 + 0.2 is above 0.3."""
    participant = open_fmu("one", folder / "typed.fmu")
    for begin, step, stop in ((0.1, 0.2, 0.3), (0.7, 0.1, 0.8), (0.0, 1.1, 1.0)):
        participant.start({}, 0.0, stop)
        participant.step(begin, step)
        wanted = begin + step if step > stop else min(begin + step, stop)
        assert participant.get("time") == wanted
        participant.close()


@pytest.mark.parametrize("ends_at, last", [(0.35, 0.3), (0.4, 0.4)])
@pytest.mark.parametrize("own", ["", "isolated = true"])
def test_an_fmu_may_ask_for_the_end(folder, tmp_path, ends_at, last, own):
    """Inside a step what was accepted before it stands; at its end the step too."""
    case = text(a=f"ends_at = {ends_at}", own=own)
    results = run_text(folder, case, output=tmp_path / "o.h5")
    assert results.time[-1] == pytest.approx(last)
    assert results.summary["ended_early"] == f"a: ends the simulation at t = {ends_at:g} s"
