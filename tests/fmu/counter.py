"""The FMU of c_models/counter.c, described as a test wants it, and cases with two of them."""

import pytest

from .c_fmus import MODELS, Variable, compile_model, describe, pack

SOURCE = MODELS / "counter.c"
VARIABLES = [
    Variable("k", 0, "parameter", "Real", 'start="1"'),
    Variable("u", 1, "input", "Real", 'start="0" nominal="1"'),
    Variable("x", 2, "output", "Real", 'nominal="1"'),
    Variable("number_sum", 3, "output"),
    Variable("truth_sum", 4, "output"),
    Variable("phase_sum", 5, "output"),
    Variable("n", 0, "output", "Integer"),
    Variable("number", 1, "input", "Integer", 'start="0"'),
    Variable("phase_out", 2, "output", "Enumeration", 'declaredType="Phase"'),
    Variable("phase", 3, "input", "Enumeration", 'start="1" declaredType="Phase"'),
    Variable("trouble", 4, "parameter", "Integer", 'start="0"'),
    Variable("trouble_at", 5, "parameter", "Integer", 'start="-1"'),
    Variable("heard_length", 6, "output", "Integer"),
    Variable("odd", 0, "output", "Boolean"),
    Variable("truth", 0, "input", "Boolean", 'start="false"'),
    Variable("words", 0, "output", "String"),
    Variable("heard", 0, "input", "String", 'start=""'),
]
PHASE = """<TypeDefinitions><SimpleType name="Phase"><Enumeration>
    <Item name="a" value="1"/><Item name="b" value="2"/><Item name="c" value="3"/>
  </Enumeration></SimpleType></TypeDefinitions>"""
LOOP = (("a.x", "b.u", ""), ("b.x", "a.u", "tolerance = 1e-12"))
"""Two lags in a loop."""


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """Compile the model."""
    library = tmp_path_factory.mktemp("counter") / "counter.so"
    compile_model(SOURCE, library)
    return library


def description(names=None, units=None, definitions="", can_redo=True):
    """Its modelDescription.xml.

    names : name here -> name in the FMU; units : name here -> unit; definitions : the inside of
    UnitDefinitions; can_redo : whether it offers saved states.
    """
    names, units = names or {}, units or {}
    variables = [
        one._replace(
            name=names.get(one.name, one.name),
            attributes=one.attributes + (f' unit="{units[one.name]}"' if one.name in units else ""),
        )
        for one in VARIABLES
    ]
    defined = f"<UnitDefinitions>{definitions}</UnitDefinitions>" if definitions else ""
    serial = f'canSerializeFMUstate="{str(can_redo).lower()}"'
    return describe("2.0", "counter", variables, serial, can_redo, defined + PHASE)


def make(path, library, **described):
    """Write the FMU; see `description`."""
    return pack(path, description(**described), library, "counter.so")


def case_text(
    wires,
    method="newton",
    stop="1 s",
    step="0.1 s",
    a="",
    b="",
    more="",
    fmus=("a.fmu", "b.fmu"),
    own="",
    coupling="",
):
    """Return a case of two participants a and b.

    wires : (from, to, further lines); a, b : lines of their parameters; own, coupling, more :
    further lines of both participants, of the coupling, and at the end.
    """
    tables = "".join(
        f'[[wires]]\nfrom = "{source}"\nto = "{target}"\n{further}\n'
        for source, target, further in wires
    )
    participants = "".join(
        f'[participants.{name}]\nfmu = "{fmu}"\n{own}\n[participants.{name}.parameters]\n{lines}\n'
        for name, fmu, lines in zip("ab", fmus, (a, b))
    )
    return f"""title = "a and b"
{"" if wires else "wires = []"}
[time]
stop = "{stop}"
step = "{step}"
{participants}{tables}
[coupling]
method = "{method}"
order = ["a", "b"]
{coupling}
{more}
"""
