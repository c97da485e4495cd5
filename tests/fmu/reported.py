"""Cases of FMUs of c_models/reported.c, for the situations that users of other tools reported."""

from pathlib import Path

import pytest

import piston_cosim as pc
from piston_cosim.master.fmi.errors import BadInput

from .c_fmus import Variable, make_reported


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CALLS", str(tmp_path / "calls.txt"))
    return tmp_path


def real(name, reference, causality="output", attributes="", variability=""):
    start = (
        ' start="0"' if causality in ("input", "parameter") and "start" not in attributes else ""
    )
    return Variable(name, reference, causality, "Real", attributes + start, variability)


def integer(name, reference, causality="output", attributes=""):
    start = ' start="0"' if causality == "input" else ""
    return Variable(name, reference, causality, "Integer", attributes + start)


Y = real("y", 1)
TYPED = [
    real("u", 0, "input"),
    integer("ui", 100, "input"),
    Variable("ub", 200, "input", "Boolean", 'start="false"'),
    Variable("us", 300, "input", "String", 'start=""'),
    Y,
    integer("yi", 101),
    Variable("yb", 201, "output", "Boolean"),
    Variable("ys", 301, "output", "String"),
]


def fmu(name, variables=(Y,), version="2.0", **parts):
    return make_reported(f"{name}.fmu", version, variables, **parts)


def run(participants, wires=(), stop="1 s", step="0.1 s", changes=None, **how):
    case = pc.couple(participants, list(wires), stop=stop, step=step, **how)
    return (case.changed(changes) if changes else case).run("o.h5")


def last(results, *names):
    values = [results.series(name).values[-1] for name in names]
    return values if len(names) > 1 else values[0]


def calls(word):
    lines = Path("calls.txt").read_text().splitlines()
    return [line.split()[1:] for line in lines if line.startswith(f"{word} ") or line == word]


def refused(*arguments, **how):
    with pytest.raises(BadInput) as refusal:
        run(*arguments, **how)
    return "\n".join(refusal.value.faults)
