"""FMUs that nobody here wrote, in the manner of the Reference-FMUs: C without Python, FMI 2.0 and
3.0, wired into a loop.

Eq. (X3):  dx/dt = -k x + g x, backward Euler through the loop:  x_n = x_0 / (1 + H (k - g))^n
"""

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.participants.open import open_fmu
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

from .c_fmus import MODELS, compile_model, pack

STATES = (1.0, 2.0, -3.0)


def real(name, reference, causality, start):
    return f"""
    <ScalarVariable name="{name}" valueReference="{reference}" {causality}>
      <Real start="{start}"/>
    </ScalarVariable>"""


REALS = [
    real("k", 0, 'causality="parameter" variability="fixed"', 1),
    *(real(f"u[{i}]", i, 'causality="input"', 0) for i in (1, 2, 3)),
    *(
        real(f"x[{i}]", i + 3, 'causality="output" initial="exact"', x)
        for i, x in enumerate(STATES, 1)
    ),
]
DAHLQUIST = f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Dahlquist" guid="{{1}}">
  <CoSimulation modelIdentifier="dahlquist" canHandleVariableCommunicationStepSize="true"
    canGetAndSetFMUstate="true"/>
  <ModelVariables>
    {"".join(REALS)}
    <ScalarVariable name="below" valueReference="0" causality="output" variability="discrete"
      initial="calculated">
      <Boolean/>
    </ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs>
      <Unknown index="5"/><Unknown index="6"/><Unknown index="7"/><Unknown index="8"/>
    </Outputs>
    <InitialUnknowns><Unknown index="8"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""
FEEDTHROUGH = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Feedthrough" instantiationToken="{2}">
  <CoSimulation modelIdentifier="feedthrough" canHandleVariableCommunicationStepSize="true"
    canGetAndSetFMUState="true" canSerializeFMUState="true"/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="gain" valueReference="1" causality="parameter" variability="fixed" start="1"/>
    <Float64 name="array_input" valueReference="2" causality="input" start="0 0 0">
      <Dimension start="3"/>
    </Float64>
    <Float64 name="array_output" valueReference="3" causality="output">
      <Dimension start="3"/>
    </Float64>
    <Int32 name="integer_input" valueReference="4" causality="input" start="0"/>
    <Int32 name="integer_output" valueReference="5" causality="output"/>
    <Boolean name="boolean_input" valueReference="6" causality="input" start="false"/>
    <Boolean name="boolean_output" valueReference="7" causality="output"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="3"/><Output valueReference="5"/><Output valueReference="7"/>
    <InitialUnknown valueReference="3"/>
    <InitialUnknown valueReference="5"/>
    <InitialUnknown valueReference="7"/>
  </ModelStructure>
</fmiModelDescription>
"""
CASE = """
title = "Foreign FMUs in a loop"
[time]
stop = "1 s"
step = "0.01 s"
[participants.decay]
fmu = "dahlquist.fmu"
isolated = {isolated}
[participants.decay.parameters]
k = 2.0
[participants.loop]
fmu = "feedthrough.fmu"
isolated = {isolated}
[participants.loop.parameters]
gain = 0.5
integer_input = 7
boolean_input = true
[[wires]]
from = "decay.x"
to = "loop.array_input"
tolerance = 1e-12
[[wires]]
from = "loop.array_output"
to = "decay.u"
tolerance = 1e-12
[coupling]
method = "{method}"
order = ["decay", "loop"]
max_iterations = 60
[record]
fields = ["decay.x"]
[summary]
below = "last decay.below"
integer = "last loop.integer_output"
boolean = "last loop.boolean_output"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("foreign")
    for name, text, place in (
        ("dahlquist", DAHLQUIST, "linux64"),
        ("feedthrough", FEEDTHROUGH, "x86_64-linux"),
    ):
        library = folder / f"{name}.so"
        compile_model(MODELS / f"{name}.c", library)
        pack(folder / f"{name}.fmu", text, library, place)
    return folder


@pytest.mark.parametrize("name, size", [("dahlquist", 3), ("feedthrough", 3)])
def test_they_are_read_and_valid(folder, name, size):
    assert validate_fmu(str(folder / f"{name}.fmu")) == []
    participant = open_fmu(name, folder / f"{name}.fmu")
    assert participant.can_redo and not participant.has_derivatives
    assert {f.size for f in participant.fields.values() if f.shape} == {size}


@pytest.mark.parametrize("method", ["constant", "aitken", "iqn_ils", "newton"])
@pytest.mark.parametrize("isolated", ["false", "true"])
def test_a_loop_of_both_reaches_its_closed_form(folder, tmp_path, method, isolated):
    path = folder / "case.toml"
    path.write_text(CASE.format(method=method, isolated=isolated))
    tree = read_tree(path)
    case = check_case(tree, path)
    summary = run(open_system(case, folder, print), case, tree, tmp_path / "base.h5")
    x = Results(tmp_path / "base.h5").field("decay.x", 1.0).values
    # 100 steps, each within 1e-12 of the loop's fixed point
    np.testing.assert_allclose(x, np.array(STATES) / (1 + 0.01 * (2.0 - 0.5)) ** 100, atol=1e-10)
    assert summary["unconverged_steps"] == 0 and summary["mean_iterations"] > 1
    assert (summary["below"], summary["integer"], summary["boolean"]) == (1, 7, 1)
    assert not (tmp_path / "base.h5.checkpoint").exists()


def test_a_step_is_rolled_back_to_the_bit(folder):
    for name, field in (("dahlquist", "x"), ("feedthrough", "array_output")):
        participant = open_fmu(name, folder / f"{name}.fmu")
        participant.start({}, 0.0, 1.0)
        participant.set("u" if name == "dahlquist" else "array_input", np.array([0.1, 0.2, 0.3]))
        saved = participant.save()
        outputs = []
        for _ in range(2):
            participant.restore(saved)
            participant.set(
                "u" if name == "dahlquist" else "array_input", np.array([0.1, 0.2, 0.3])
            )
            participant.step(0.0, 0.1)
            outputs.append(participant.get(field).tobytes())
        assert outputs[0] == outputs[1]
        participant.free(saved)
        participant.close()
