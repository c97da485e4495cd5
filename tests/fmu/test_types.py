"""Every type of FMI 3.0 from one FMU to another at the ends of its range, arrays as long as a
structural parameter says, steps that end early, and an end that an FMU asks for.
"""

from pathlib import Path

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.methods import method_of
from piston_cosim.master.coupling.starting import closing, start
from piston_cosim.master.coupling.stepping import Stepper
from piston_cosim.master.fmi.errors import BadInput, ParticipantFault
from piston_cosim.master.participants.open import open_fmu
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

from .c_fmus import compile_model, pack

SOURCE = Path(__file__).parent / "c_models" / "typed.c"
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


def variable(kind, name, reference, causality):
    more = ' declaredType="Choice"' if kind == "Enumeration" else ""
    start = {"String": "", "Binary": "00", "Boolean": "false", "Enumeration": "1"}.get(kind, "0")
    given = f' start="{start}"' if causality == "input" else ""
    if kind in ("String", "Binary") and given:
        given, inside = "", f'<Start value="{start}"/>'
    else:
        inside = ""
    head = f'<{kind} name="{name}" valueReference="{reference}" causality="{causality}"'
    discrete = ' variability="discrete"' if kind == "Float32" else ""
    return f"{head}{discrete}{more}{given}>{inside}</{kind}>"


def description():
    rows = [
        '<Float64 name="time" valueReference="0" causality="independent"/>',
        '<UInt64 name="n" valueReference="1" causality="structuralParameter" variability="fixed" '
        'start="3"/>',
        '<Float64 name="a_in" valueReference="2" causality="input" start="0 0 0">'
        '<Dimension valueReference="1"/></Float64>',
        '<Float64 name="a_out" valueReference="3" causality="output">'
        '<Dimension valueReference="1"/></Float64>',
        '<Float64 name="ends_at" valueReference="4" causality="parameter" variability="fixed" '
        'start="1e9"/>',
        '<Float64 name="grain" valueReference="5" causality="parameter" variability="fixed" '
        'start="1e9"/>',
        '<Float64 name="events" valueReference="6" causality="output" variability="discrete"/>',
        *(variable(t, f"{t}_in", 10 + k, "input") for k, t in enumerate(LARGEST)),
        *(variable(t, f"{t}_out", 30 + k, "output") for k, t in enumerate(LARGEST)),
    ]
    outputs = [3, 6, *range(30, 30 + len(LARGEST))]
    known = "".join(f'<Output valueReference="{k}"/>' for k in outputs)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Typed" instantiationToken="1">
  <CoSimulation modelIdentifier="typed" canHandleVariableCommunicationStepSize="true"
    hasEventMode="true" mightReturnEarlyFromDoStep="true" canGetAndSetFMUState="true"/>
  {ENUMERATION}
  <ModelVariables>{"".join(rows)}</ModelVariables>
  <ModelStructure>{known}</ModelStructure>
</fmiModelDescription>
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("typed")
    library = folder / "typed.so"
    compile_model(SOURCE, library)
    pack(folder / "typed.fmu", description(), library, "x86_64-linux")
    return folder


def opened(folder, wires="", a="", b="", own="", stop="1 s"):
    """A case of two of them, and its system."""
    path = folder / "case.toml"
    path.write_text(f"""title = "types"
{"" if wires else "wires = []"}
[time]
stop = "{stop}"
step = "0.1 s"
[participants.a]
fmu = "typed.fmu"
{own}
[participants.a.parameters]
{a}
[participants.b]
fmu = "typed.fmu"
{own}
[participants.b.parameters]
{b}
{wires}
[coupling]
order = ["a", "b"]
""")
    tree = read_tree(path)
    case = check_case(tree, path)
    return case, tree, open_system(case, folder, print)


def literal(value):
    return str(value).lower() if isinstance(value, bool | int | float) else f'"{value}"'


@pytest.mark.parametrize("own", ["", "isolated = true"])
def test_every_type_is_handed_on_unchanged(folder, own):
    wires = "".join(f'[[wires]]\nfrom = "a.{t}_out"\nto = "b.{t}_in"\n' for t in LARGEST)
    wires += '[[wires]]\nfrom = "a.a_out"\nto = "b.a_in"\n'
    given = "".join(f"{t}_in = {literal(value)}\n" for t, value in LARGEST.items())
    given += "n = 5\na_in = [1.0, 2.0, 3.0, 4.0, 5.0]\n"
    case, _, system = opened(folder, wires, given, "n = 5", own)
    assert system.participants["b"].fields["a_in"].shape == (5,)
    with closing(system.participants.values()):
        start(system)
        stepper = Stepper(system, method_of(case.coupling), 3, held=system.held)
        for k in range(2):  # what is held is what was said before the step
            stepper.advance(0.1 * k, 0.1)
        b = system.participants["b"]
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
        opened(folder, a=line)


def test_a_wire_whose_value_does_not_fit_ends_the_run(folder):
    wires = '[[wires]]\nfrom = "a.Int32_out"\nto = "b.Int8_in"\n'
    case, _, system = opened(folder, wires, "Int32_in = 300")
    with closing(system.participants.values()):
        start(system)
        stepper = Stepper(system, method_of(case.coupling), 3, held=system.held)
        stepper.advance(0.0, 0.1)
        with pytest.raises(
            ParticipantFault, match="b: Int8_in: 300 does not fit its type, Int8, -128 to 127"
        ):
            stepper.advance(0.1, 0.1)


def test_a_step_that_returns_early_goes_on_through_event_mode(folder):
    """Events at 0.04, 0.08, ...: two or three to a step of 0.1 s, each in its place."""
    participant = open_fmu("one", folder / "typed.fmu")
    participant.start({"grain": 0.04}, 0.0, 1.0)
    for k in range(5):
        participant.step(0.1 * k, 0.1)
        end = 0.1 * (k + 1)
        assert participant.get("time") == pytest.approx(end, rel=1e-12)
        assert participant.get("events") == np.floor(end / 0.04 + 1e-9)
    participant.close()


@pytest.mark.parametrize("ends_at, last", [(0.35, 0.3), (0.4, 0.4)])
@pytest.mark.parametrize("own", ["", "isolated = true"])
def test_an_fmu_may_ask_for_the_end(folder, tmp_path, ends_at, last, own):
    """Inside a step what was accepted before it stands; at its end the step too."""
    case, tree, system = opened(folder, a=f"ends_at = {ends_at}", own=own)
    summary = run(system, case, tree, tmp_path / "o.h5")
    assert Results(tmp_path / "o.h5").time[-1] == pytest.approx(last)
    assert summary["ended_early"] == f"a: ends the simulation at t = {ends_at:g} s"
