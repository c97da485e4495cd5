"""Values and their types that users of other tools have reported, each with its right value."""

from pathlib import Path

import pytest

import piston_cosim as pc

from ..command import call
from .c_fmus import Variable
from .reported import TYPED, Y, fmu, folder, integer, last, real, refused, run

__all__ = ["folder"]


# types ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("isolated", [False, True])
def test_a_boolean_other_than_0_is_1(isolated):
    a = fmu("a", [Variable("yb", 201, "output", "Boolean")], OUT="m->b[1]=255")
    b = fmu("b", [TYPED[2], Y], OUT="m->r[1]=m->b[0]")
    results = run({"a": a, "b": b}, ["a.yb -> b.ub"], changes={"participants.a.isolated": isolated})
    assert last(results, "a.yb", "b.y") == [1, 1]


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_texts_are_recorded_and_handed_on_as_they_are(version):
    """NULL is an empty text; bytes that are not UTF-8 remain."""
    out, null = 'strcpy(m->s[1],"gr\\374n")', "if(m->steps==5)v[k]=0"
    a = fmu("a", [TYPED[-1]], version, OUT=out, GETS=null)
    b = fmu("b", [TYPED[3], Y], version, OUT="m->r[1]=strlen(m->s[0])")
    results = run({"a": a, "b": b}, ["a.ys -> b.us"])
    texts = results.series("a.ys").values
    assert texts[4] == b"gr\374n".decode(errors="surrogateescape") and texts[5] == ""
    assert sorted(results.series("b.y").values) == [0] + 10 * [4]
    assert results.texts == ["a.ys"] and "a.ys" not in results.ports
    for words in ("scalars", "snapshot --participant a"):
        done = call("results", *words.split(), "o.h5", "--output", "s.csv")
        text = Path("s.csv").read_bytes()
        assert done.returncode == 0 and (b'"gr\374n"' in text or b'"gr\\udcfcn"' in text), text


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_an_ssp_has_wires_of_all_types(version):
    out = 'm->r[1]=m->t;m->i[1]=m->steps;m->b[1]=m->steps%2;sprintf(m->s[1],"t=%d",m->steps)'
    echo = "m->r[1]=m->i[0]+100*m->b[0]+1000*atoi(m->s[0]+2)"
    fmu("a", TYPED, version, OUT=out), fmu("b", TYPED, version, OUT=echo)
    Path("case.toml").write_text(
        'title = "all types"\ntime = { stop = "1 s", step = "0.1 s" }\n'
        'participants = { a = { fmu = "a.fmu" }, b = { fmu = "b.fmu" } }\n'
        + "".join(f'[[wires]]\nfrom = "a.y{k}"\nto = "b.u{k}"\n' for k in ("i", "b", "s"))
        + '[coupling]\norder = ["a", "b"]\n'
    )
    for words in (["fmu", "export", "case.toml"], ["run", "s.ssp", "--no-plots"]):
        done = call(*words, "--output", "s.ssp" if words[0] == "fmu" else ".")
        assert done.returncode == 0, done.stderr
    results = pc.Results("base.h5")
    assert results.series("b.y").values[[9, 10]].tolist() == [9109, 10010]
    Path("t.csv").write_text("time [s],y\n0,1\n1,2\n")
    Path("case.toml").write_text(
        Path("case.toml").read_text().replace('fmu = "a.fmu"', 'table = "t.csv"')
    )
    done = call("fmu", "export", "case.toml", "--output", "t.ssp")
    assert (
        done.returncode == 2
        and "participants.a: expected an FMU in an SSP, got a table" in done.stderr
    )


@pytest.mark.parametrize("kind", ["hold", "linear"])
def test_a_table_feeds_inputs_of_whole_numbers(kind):
    """A column has the type of its wire's input, and holds the last row until the next."""
    enumeration = "".join(f'<Item name="{name}" value="{k}"/>' for k, name in ((1, "a"), (2, "b")))
    types = f'<SimpleType name="E"><Enumeration>{enumeration}</Enumeration></SimpleType>'
    types = f"<TypeDefinitions>{types}</TypeDefinitions>"
    mode = Variable("um", 101, "input", "Enumeration", 'declaredType="E" start="1"')
    step = "m->r[1]=100*m->i[0]+10*m->b[0]+m->i[1]"
    a = fmu("a", [*TYPED[1:3], mode, Y], STEP=step, before=types)
    Path("t.csv").write_text(
        "time [s],gear,on,mode,x\n0,3,false,1,0.5\n0.5,-4,TRUE,2,1\n1,7,1,1,2\n"
    )
    wires = ["t.gear -> a.ui", "t.on -> a.ub", "t.mode -> a.um"]
    results = run({"a": a, "t": "t.csv"}, wires, changes={"participants.t.interpolation": kind})
    assert results.series("a.y").values[[4, 5, 10]].tolist() == [301, -388, 711]
    assert results.series("t.gear").values[[4, 5, 10]].tolist() == [3, -4, 7]
    words = "t.csv, column x: expected whole numbers, got 0.5"
    assert words in refused({"a": a, "t": "t.csv"}, ["t.x -> a.ui"])


def test_integers_of_64_bits_are_recorded_as_they_are():
    out = "m->i[0]=9007199254740993LL+m->steps;m->i[1]=-1;m->i[2]=m->steps"
    variables = [
        Variable("large", 100, "output", "Int64"),
        Variable("largest", 101, "output", "UInt64"),
        integer("n", 102),
    ]
    results = run({"a": fmu("a", variables, "3.0", OUT=out)})
    assert last(results, "a.large", "a.largest", "a.n") == [2**53 + 11, 2**64 - 1, 10]
    assert results.structured()["a.large"][-1] == 2**53 + 11


MODE = """<TypeDefinitions><SimpleType name="Mode"><Enumeration>{}</Enumeration></SimpleType>
</TypeDefinitions>"""
ITEMS = '<Item name="off" value="1"/><Item name="full power" value="5"/>'


def test_an_enumeration_has_its_items_only():
    attributes = 'declaredType="Mode"'
    variables = [
        Variable("mode", 100, "parameter", "Enumeration", f'{attributes} start="1"'),
        Variable("y", 101, "output", "Enumeration", attributes),
    ]
    a = fmu("a", variables, OUT="m->i[1]=m->i[0]", before=MODE.format(ITEMS))
    for value in (5, "full power"):
        assert last(run({"a": a}, parameters={"a": {"mode": value}}), "a.y") == 5
    words = refused({"a": a}, parameters={"a": {"mode": 2}})
    assert words.endswith("parameters.mode: expected one of 'off' (1), 'full power' (5), got 2")
    inlet = Variable("u", 102, "input", "Enumeration", f'{attributes} start="1"')
    b = fmu("b", [inlet], before=MODE.format('<Item name="off" value="1"/>'))
    words = "wire a.y -> b.u: expected 'off' (1) for u, got 5"
    assert refused({"a": a, "b": b}, ["a.y -> b.u"]) == words
    Path("t.csv").write_text("time [s],mode\n0,1\n1,2\n")
    words = "participants.t.table: expected 'off' (1) for u, got 2"
    assert refused({"t": "t.csv", "b": b}, ["t.mode -> b.u"]) == words
    b = fmu("b", variables, before=MODE.format('<Item name="off"/>'))
    assert "Mode: expected an enumeration of names with whole numbers" in refused({"b": b})


def test_enumerations_on_a_wire_have_the_same_items(caplog):
    """A name with another number is a fault. Other names of a number are only a message."""
    attributes = 'declaredType="Mode"'
    a = fmu(
        "a", [Variable("y", 101, "output", "Enumeration", attributes)], before=MODE.format(ITEMS)
    )
    inlet = [Variable("u", 102, "input", "Enumeration", f'{attributes} start="1"')]
    swapped = '<Item name="full power" value="1"/><Item name="OFF" value="5"/>'
    b = fmu("b", inlet, before=MODE.format(swapped))
    words = "a.y -> b.u: expected one of 'full power' (1), 'OFF' (5) as for u, got one of 'off' (1)"
    assert words in refused({"a": a, "b": b}, ["a.y -> b.u"])
    german = '<Item name="aus" value="0"/><Item name="Off" value="1"/><Item name="voll" value="5"/>'
    b = fmu("b", inlet, before=MODE.format(german))
    with caplog.at_level("INFO", logger="piston_cosim"):
        run({"a": a, "b": b}, ["a.y -> b.u"])
    assert "wire a.y -> b.u: carries the number, whose names differ: " in caplog.text


def test_arrays_without_elements():
    """Nothing is carried along their wires; they are not recorded."""
    none = '<Dimension start="0"/>'
    size, out = "a == 10 || a == 11 ? 0 : 1", "m->r[1]=m->t"
    variables = [
        Variable("u", 10, "input", "Real", 'start=""', inside=none),
        Variable("z", 11, "output", inside=none),
        Y,
    ]
    a, b = (fmu(name, variables, "3.0", SIZE=size, OUT=out) for name in "ab")
    wires = ["a.z -> b.u", "b.z -> a.u"]
    assert last(run({"a": a, "b": b}, wires), "a.y") == pytest.approx(1.0)
    words = "record.fields: expected an array with elements, got a.z of shape (0,)"
    assert words in refused({"a": a}, record=["a.z"])
    twice = "record.fields: expected different names, got a.y twice"
    assert refused({"a": a}, record=["a.y", "a.y"]) == twice


# units and ranges -----------------------------------------------------------------------------

UNITS = (
    '<UnitDefinitions><Unit name="K"><BaseUnit K="1"/></Unit>'
    '<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>'
    '<Unit name="bar"><BaseUnit kg="1" m="-1" s="-2" factor="1e5"/></Unit>'
    '<Unit name="Pa"><BaseUnit kg="1" m="-1" s="-2"/></Unit></UnitDefinitions>'
)
TYPES = {
    "Bar": 'unit="bar"',
    "Pascal": 'unit="Pa" nominal="1e5"',
    "Rise": 'unit="degC" relativeQuantity="true"',
    "Kelvins": 'unit="K" relativeQuantity="true"',
    "Narrow": 'unit="K" min="0" max="2"',
}


def typed_head(version):
    if version == "3.0":
        types = [f'<Float64Type name="{name}" {text}/>' for name, text in TYPES.items()]
    else:
        types = [
            f'<SimpleType name="{name}"><Real {text}/></SimpleType>' for name, text in TYPES.items()
        ]
    return f"{UNITS}<TypeDefinitions>{''.join(types)}</TypeDefinitions>"


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_unit_range_and_kind_of_a_declared_type(version):
    def typed(name, reference, causality, kind):
        return real(name, reference, causality, f'declaredType="{kind}"')

    outputs = [typed("p", 3, "output", "Bar"), typed("rise", 2, "output", "Rise")]
    inputs = [typed("p", 6, "input", "Pascal"), typed("rise", 5, "input", "Kelvins")]
    more = [typed("q", 7, "parameter", "Narrow"), Y, real("y2", 2)]
    head = typed_head(version)
    a = fmu("a", outputs, version, before=head, OUT="m->r[2]=5;m->r[3]=2")
    b = fmu("b", inputs + more, version, before=head, OUT="m->r[1]=m->r[6];m->r[2]=m->r[5]")
    results = run({"a": a, "b": b}, ["a.p -> b.p", "a.rise -> b.rise"])
    assert last(results, "b.y", "b.y2") == [2e5, 5.0]
    words = refused({"b": b}, parameters={"b": {"q": "7 K"}})
    assert words == "participants.b.parameters.q: expected 0 to 2 K, got 7 K"
    info = call("fmu", "info", b, "--all").stdout
    assert [row.split() for row in info.splitlines() if " p " in row] == [
        ["input", "p", "Pa", "0", "100000"]
    ]


def test_start_values_are_printed_without_round_off():
    a = fmu("a", [real("p", 2, "parameter", 'start="4.9999999999999996e-05"'), Y])
    info = call("fmu", "info", a, "--all").stdout
    assert [row.split()[3] for row in info.splitlines() if " p " in row] == ["5e-05"]


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_variables_own_attributes_replace_those_of_its_type(version):
    own = 'declaredType="Rise" unit="K" relativeQuantity="false"'
    a = fmu("a", [real("p", 2, "parameter", own), Y], version, before=typed_head(version))
    field = pc.open_fmu(a).fields["p"]
    assert field.unit == "K" and not field.relative


def test_a_difference_has_no_offset():
    variables = [
        real("T", 4, "parameter", 'unit="K"'),
        real("dT", 5, "parameter", 'unit="K" relativeQuantity="true"'),
        Y,
        real("rise", 2),
    ]
    a = fmu("a", variables, before=UNITS, OUT="m->r[1]=m->r[4];m->r[2]=m->r[5]")
    for rise in ("5 K", "5 degC", "5 delta_degC", "9 delta_degF"):
        results = run({"a": a}, parameters={"a": {"T": "20 degC", "dT": rise}})
        assert last(results, "a.y", "a.rise") == pytest.approx([293.15, 5.0], rel=1e-15)


def test_the_range_of_unsigned_integers():
    limited = Variable("p", 101, "parameter", "UInt64", 'start="1" max="2"')
    a = fmu("a", [limited, Y], "3.0")
    assert "p: expected 0 to 2, got 3" in refused({"a": a}, parameters={"a": {"p": 3}})
    assert "p: expected a number, got True" in refused({"a": a}, parameters={"a": {"p": True}})


RPM = '<Unit name="rpm"><BaseUnit s="-1" factor="0.1"/></Unit>'
KINDS = (
    '<UnitDefinitions><Unit name="furlong"><BaseUnit m="1" factor="201.168"/></Unit>'
    f'<Unit name="m"><BaseUnit m="1"/></Unit><Unit name="s"><BaseUnit s="1"/></Unit>{RPM}'
    '<Unit name="rad/s"><BaseUnit s="-1" rad="1"/></Unit><Unit name="1"><BaseUnit/></Unit>'
    '<Unit name="%"><BaseUnit factor="0.01"/></Unit></UnitDefinitions>'
)


@pytest.mark.parametrize(
    "first, second, right",
    [
        ("A", "A", 2.0),  # named, but not defined
        ("furlong", "furlong", 2.0),
        ("furlong", "m", 402.336),
        ("m", "s", "expected units of one kind, got m and s; in base units m1 and s1"),
        ("%", "1", 0.02),
        ("rpm", "rad/s", "expected units of one kind, got rpm and rad/s"),
    ],
)
def test_units_of_both_ends(first, second, right):
    a = fmu("a", [real("y", 1, attributes=f'unit="{first}"')], before=KINDS, OUT="m->r[1]=2")
    inlet = real("u", 4, "input", f'unit="{second}"')
    b = fmu("b", [inlet, Y], before=KINDS, OUT="m->r[1]=m->r[4]")
    participants, wires = {"a": a, "b": b}, ["a.y -> b.u"]
    if isinstance(right, str):
        assert right in refused(participants, wires)
    else:
        assert last(run(participants, wires), "b.y") == pytest.approx(right, rel=1e-15)


# start values and parameters ------------------------------------------------------------------


def test_a_calculated_parameter_follows_and_cannot_be_set():
    variables = [
        real("p", 2, "parameter", 'start="1"'),
        Variable("c", 3, "calculatedParameter"),
        Y,
    ]
    a = fmu("a", variables, ENTER="m->r[3]=2*m->r[2]", OUT="m->r[1]=m->r[3]")
    assert last(run({"a": a}, parameters={"a": {"p": 4.0}}), "a.y") == 8.0
    words = "parameters.c: expected p, got unknown parameter or input 'c'"
    assert words in refused({"a": a}, parameters={"a": {"c": 4.0}})


def test_an_input_without_a_wire_has_the_fmus_start_value():
    a = fmu("a", [real("u", 0, "input", 'start="3"'), Y], START="m->r[0]=3", OUT="m->r[1]=m->r[0]")
    assert last(run({"a": a}), "a.y") == 3.0
    assert last(run({"a": a}, parameters={"a": {"u": 7.0}}), "a.y") == 7.0


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_exact_start_of_a_local_variable_can_be_set(version):
    state = Variable("x", 2, "local", "Real", 'start="1"', 'continuous" initial="exact')
    calculated = Variable("z", 3, "local", "Real", "", "continuous")
    a = fmu(
        "a",
        [state, calculated, Y],
        version,
        START="m->r[2]=1",
        STEP="m->r[2]*=2",
        OUT="m->r[1]=m->r[2]",
    )
    assert last(run({"a": a}, parameters={"a": {"x": 3.0}}), "a.y") == 3.0 * 2**10
    words = "parameters.z: expected x, got unknown parameter or input 'z'"
    assert words in refused({"a": a}, parameters={"a": {"z": 3.0}})


def tunable(name="p", attributes='start="1"'):
    return real(name, 2, "parameter", attributes, "tunable")


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_tunable_parameter_is_fed_between_steps(version):
    """In Event Mode if the FMU has one. Its units are converted."""
    Path("p.csv").write_text("time [s], p [bar]\n0, 1\n0.55, 1\n0.5500001, 3\n2, 3\n")
    attributes = 'start="1e5" unit="bar"'
    part = {"START": "m->r[2]=1e5", "STEP": "m->r[1]+=H*m->r[2]"}
    events = 'hasEventMode="true"' if version == "3.0" else ""
    a = fmu("a", [tunable("p", attributes), Y], version, flags=events, before=UNITS, **part)
    results = run({"t": "p.csv", "a": a}, ["t.p -> a.p"])
    # the value at the end of each step, as for inputs: five steps of 1 and of 3
    assert last(results, "a.y") == pytest.approx(2.0, rel=1e-14)
    lines = Path("calls.txt").read_text().splitlines()
    before = {lines[k - 1] for k, line in enumerate(lines) if line.startswith("set 2 3")}
    assert before == ({"event mode"} if events else before)


def test_a_parameter_that_is_not_tunable_is_not_fed():
    a = fmu("a", [real("p", 2, "parameter"), Y])
    words = "wire a.y -> a.p: expected nothing, because there is no input, got 'a.p'"
    assert words in refused({"a": a}, ["a.y -> a.p"])
    b = fmu("b", [tunable(), Y])
    wire = {"from": "b.y", "to": "b.p", "tolerance": 1.0}
    words = "expected a wire of real numbers for tolerance, got type Real to a tunable parameter"
    assert words in refused({"b": b}, [wire])


def test_two_names_of_one_value():
    a = fmu("a", [Y, real("alias", 1), Variable("z", 1, "local")], STEP="m->r[1]=t+H")
    b = fmu("b", [real("u", 4, "input"), Y, real("seen", 4)], OUT="m->r[1]=m->r[4]")
    results = run({"a": a, "b": b}, ["a.alias -> b.u"], record=["a.alias"])
    assert last(results, "a.y", "a.alias", "b.y", "b.seen") == [1.0] * 4


def test_wires_between_other_variables():
    variables = [
        real("u", 0, "input"),
        Y,
        Variable("z", 2, "local"),
        real("p", 3, "parameter"),
    ]
    a = fmu("a", variables, STEP="m->r[1]=0.5*m->r[0]+1")
    assert last(run({"a": a, "b": a}, ["a.y -> a.u"]), "a.y") == pytest.approx(2.0, rel=1e-6)
    for wire, words in {
        "a.z -> b.u": "expected a.y, got unknown output 'a.z'",
        "a.p -> b.u": "expected a.y, got unknown output 'a.p'",
        "a.u -> b.u": "expected a.y, got unknown output 'a.u'",
        "a.y -> b.y": "expected b.u, got unknown input 'b.y'",
        "a.y -> b.p": "expected b.u, got unknown input 'b.p'",
    }.items():
        assert words in refused({"a": a, "b": a}, [wire])
