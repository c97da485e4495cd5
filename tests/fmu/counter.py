"""The FMU of c_models/counter.c, described as a test wants it, and cases with it."""

import zipfile

import pytest

from .c_fmus import MODELS, compile_model

SOURCE = MODELS / "counter.c"
VARIABLES = [
    # name, value reference, causality, type, attributes of the type
    ("k", 0, "parameter", "Real", 'start="1"'),
    ("u", 1, "input", "Real", 'start="0" nominal="1"'),
    ("x", 2, "output", "Real", 'nominal="1"'),
    ("number_sum", 3, "output", "Real", ""),
    ("truth_sum", 4, "output", "Real", ""),
    ("phase_sum", 5, "output", "Real", ""),
    ("n", 0, "output", "Integer", ""),
    ("number", 1, "input", "Integer", 'start="0"'),
    ("phase_out", 2, "output", "Enumeration", 'declaredType="Phase"'),
    ("phase", 3, "input", "Enumeration", 'start="1" declaredType="Phase"'),
    ("trouble", 4, "parameter", "Integer", 'start="0"'),
    ("trouble_at", 5, "parameter", "Integer", 'start="-1"'),
    ("heard_length", 6, "output", "Integer", ""),
    ("odd", 0, "output", "Boolean", ""),
    ("truth", 0, "input", "Boolean", 'start="false"'),
    ("words", 0, "output", "String", ""),
    ("heard", 0, "input", "String", 'start=""'),
]


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """The model compiled."""
    library = tmp_path_factory.mktemp("counter") / "counter.so"
    compile_model(SOURCE, library)
    return library


def description(names=None, units=None, definitions="", can_redo=True):
    """Its modelDescription.xml.

    names : name here -> name in the FMU; units : name here -> unit; definitions : the inside of
    UnitDefinitions; can_redo : whether it offers saved states.
    """
    names = names or {}
    units = units or {}
    rows = []
    for name, reference, causality, kind, attributes in VARIABLES:
        unit = f' unit="{units[name]}"' if name in units else ""
        fixed = ' variability="fixed"' if causality == "parameter" else ""
        discrete = ' variability="discrete"' if kind != "Real" and not fixed else ""
        rows.append(
            f'<ScalarVariable name="{names.get(name, name)}" valueReference="{reference}" '
            f'causality="{causality}"{fixed}{discrete}><{kind} {attributes}{unit}/>'
            "</ScalarVariable>"
        )
    outputs = "".join(
        f'<Unknown index="{k}"/>'
        for k, (_, _, causality, _, _) in enumerate(VARIABLES, 1)
        if causality == "output"
    )
    flag = str(can_redo).lower()
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="counter" guid="1">
  <CoSimulation modelIdentifier="counter" canHandleVariableCommunicationStepSize="true"
    canGetAndSetFMUstate="{flag}" canSerializeFMUstate="{flag}"/>
  <UnitDefinitions>{definitions}</UnitDefinitions>
  <TypeDefinitions><SimpleType name="Phase"><Enumeration>
    <Item name="a" value="1"/><Item name="b" value="2"/><Item name="c" value="3"/>
  </Enumeration></SimpleType></TypeDefinitions>
  <ModelVariables>{"".join(rows)}</ModelVariables>
  <ModelStructure><Outputs>{outputs}</Outputs></ModelStructure>
</fmiModelDescription>
"""


def make(path, library, **described):
    """Write the FMU; see `description`."""
    text = description(**described)
    text = text.replace("<UnitDefinitions></UnitDefinitions>", "")
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", text)
        archive.write(library, "binaries/linux64/counter.so")
    return path


def case_text(wires, method="newton", stop="1 s", step="0.1 s", a="", b="", more=""):
    """A case of two counters; wires as (from, to, further lines)."""
    tables = "".join(
        f'[[wires]]\nfrom = "{source}"\nto = "{target}"\n{further}\n'
        for source, target, further in wires
    )
    return f"""title = "counters"
{"" if wires else "wires = []"}
[time]
stop = "{stop}"
step = "{step}"
[participants.a]
fmu = "a.fmu"
[participants.a.parameters]
{a}
[participants.b]
fmu = "b.fmu"
[participants.b.parameters]
{b}
{tables}
[coupling]
method = "{method}"
order = ["a", "b"]
{more}
"""
