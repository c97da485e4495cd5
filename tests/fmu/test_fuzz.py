"""Model descriptions and case files with random damage: each is taken, or refused by a sentence.

Nothing is executed: an FMU's code trusts its own description.
"""

import random
import re
import shutil
import traceback
import warnings
import zipfile
from collections import Counter

import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.fmi.errors import BadInput

from .c_fmus import Variable, describe
from .counter import description

STRANGE = (
    *("", "0", "-1", "1e999", "nan", "inf", "-0.5", "99999999999999999999", "true", "null", "é"),
    *("a.b", "x[1]", "x[0]", "x[2,3]", "x[1", "der(x)", "../../x", "[[]]"),
    *("1 furlong", "m", "kg.m-1"),
    *("Real", "Float64", "UInt8", "Clock", "Binary", "parameter", "input", "output", "local"),
    *("2.0", "3.0", "1.0", "\x00", "&amp;", "&#x0;", "%s%n", "x" * 3000, '"', "<", "]]>"),
)
MILLIMETRE = '<Unit name="mm"><BaseUnit m="1" factor="0.001"/></Unit>'
DESCRIPTION_3 = describe(
    "3.0",
    "m",
    [
        Variable("u", 1, "input", "Float64", 'start="0" unit="mm" nominal="1"'),
        Variable("x", 2, "output", "Float64", 'unit="mm" min="-1" max="1"'),
        Variable("n", 3, "structuralParameter", "UInt64", 'start="2"', "tunable"),
        Variable(
            "field",
            4,
            "output",
            "Float64",
            inside='<Dimension valueReference="3"/><Dimension start="3"/>',
        ),
        Variable("f", 5, "output", "Float32", 'derivative="2"'),
        Variable("i", 6, "output", "Int8"),
        Variable("e", 7, "input", "Enumeration", 'start="1" declaredType="Phase"'),
        Variable("s", 8, "output", "String", inside='<Start value="a"/>'),
        Variable("b", 9, "input", "Binary", inside='<Start value="00"/>'),
        Variable("k", 10, "parameter", "Boolean", 'start="true"'),
    ],
    'canSerializeFMUState="true" hasEventMode="true"',
    before=f"<UnitDefinitions>{MILLIMETRE}</UnitDefinitions>"
    '<TypeDefinitions><EnumerationType name="Phase"><Item name="a" value="1"/></EnumerationType>'
    "</TypeDefinitions>",
)
CASE = """title = "fuzz"
[time]
start = "0 s"
stop = "1 s"
step = "0.1 s"
[participants.a]
fmu = "a.fmu"
step = "10 ms"
[participants.a.parameters]
u = "1 mm"
[participants.b]
fmu = "b.fmu"
isolated = true
timeout = "5 s"
[participants.c]
table = "table.csv"
interpolation = "linear"
[[wires]]
from = "c.u"
to = "a.u"
interpolation = "linear"
[[wires]]
from = "a.x"
to = "b.u"
tolerance = "1 um"
local_error = 1e-3
[coupling]
method = "newton"
order = ["c", "a", "b"]
max_iterations = 20
[record]
fields = ["a.x"]
every = 2
[summary]
x = "max a.x"
[[pictures]]
file = "x.png"
title = "x"
kind = "lines"
x = "a.x"
y = [["a.x"]]
[variants.other]
"time.stop" = "2 s"
"""
TABLE = "time [s], u [mm]\n0, 1\n0.5, 2\n2, 3\n3, 4\n"


DESCRIPTIONS = description(units={"u": "mm"}, definitions=MILLIMETRE), DESCRIPTION_3


def damaged(text, rng):
    """Return the text with a few random changes."""
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        text = rng.choice((_value, _value, _piece, _character, _line))(text, rng)
    return text


QUOTED = re.compile(r'(?<=")[^"\n]*(?=")')
ANY = re.compile(r"-?\d[\d.e-]*|\b[a-zA-Z]\w+\b")


def _value(text, rng):
    """Something strange, or another value, in place of a quoted text; at times of any word."""
    places = list((QUOTED if rng.random() < 0.8 else ANY).finditer(text))
    if not places:
        return text
    place, other = rng.choice(places), rng.choice(places)
    new = rng.choice(STRANGE) if rng.random() < 0.6 else other.group()
    return text[: place.start()] + new + text[place.end() :]


def _piece(text, rng):
    """Cut a piece out, or insert a copy of it elsewhere."""
    begin = rng.randrange(len(text) + 1)
    piece = text[begin : begin + rng.randint(1, 80)]
    at = rng.randrange(len(text) + 1)
    return text.replace(piece, "", 1) if rng.random() < 0.5 else text[:at] + piece + text[at:]


def _character(text, rng):
    """One character changed."""
    at = rng.randrange(len(text) + 1)
    return text[:at] + chr(rng.choice((rng.randrange(1, 128), 0xE9, 0x2028))) + text[at + 1 :]


def _line(text, rng):
    """Repeat a line, or remove it."""
    lines = text.splitlines(keepends=True)
    if not lines:
        return text
    k = rng.randrange(len(lines))
    lines[k : k + 1] = [lines[k]] * rng.choice((0, 2))
    return "".join(lines)


def attempt(seed, folder):
    """Return the outcome of one damaged system, "taken" or "refused"; raise anything else."""
    rng = random.Random(seed)
    files = {"a": DESCRIPTION_3, "b": rng.choice(DESCRIPTIONS)}
    case, table = CASE, TABLE
    target = rng.choice(("a", "b", "case", "case", "table"))
    if target == "case":
        case = damaged(case, rng)
    elif target == "table":
        table = damaged(table, rng)
    else:
        files[target] = damaged(files[target], rng)
    for name, text in files.items():
        with zipfile.ZipFile(folder / f"{name}.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", text.encode(errors="replace"))
            for library in ("linux64/counter.so", "x86_64-linux/m.so"):
                archive.writestr(f"binaries/{library}", "")
    (folder / "table.csv").write_bytes(table.encode(errors="replace"))
    path = folder / "case.toml"
    path.write_bytes(case.encode(errors="replace"))
    try:
        open_system(check_case(read_tree(path), path), folder, lambda line: None)
    except BadInput as refusal:
        assert refusal.faults, "refused without a word"
        return "refused"
    return "taken"


@pytest.mark.parametrize("count", [300, pytest.param(10_000, marks=pytest.mark.slow)])
def test_damage_is_told_by_a_sentence(tmp_path, monkeypatch, count):
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(tmp_path / "cache"))
    outcomes, bugs = Counter(), {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for seed in range(count):
            try:
                outcomes[attempt(seed, tmp_path)] += 1
            except Exception:
                bugs[seed] = traceback.format_exc()
            if seed % 500 == 499:
                shutil.rmtree(tmp_path / "cache" / "unpacked", ignore_errors=True)
    assert not bugs, next(iter(bugs.items()))
    # the undamaged case is taken, so that damage reaches every part of what is checked
    assert outcomes["taken"] > count / 10 and outcomes["refused"] > count / 3
