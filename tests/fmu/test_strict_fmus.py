"""An FMU that keeps to the letter of the standard, in a loop with itself: its derivative is not
that of a step, it may refuse to be instantiated, it may fail, and it may refuse to end.

Eq. (X11):  (1 + H) a' = a + H g b',   (1 + H) b' = b - H g a',   a = 1, b = 0 at the start
"""

import json
import zipfile
from pathlib import Path

import numpy as np
import pytest

from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.master.participants.isolated import IsolatedParticipant
from piston_cosim.master.results.file import Results

from ..command import call
from .c_fmus import MODELS, compile_model

HERE = Path(__file__).parent
STEP, GAIN = 0.1, 30.0
NAMES = {
    "u": "input",
    "x": "output",
    "gain": "parameter",
    "x0": "parameter",
    "fails_at": "parameter",
}
STARTS = {"u": 0, "gain": 1, "x0": 0, "fails_at": 1e9}
CASE = """
title = "Two cells"
[time]
stop = "1 s"
step = "0.1 s"
[participants.a]
fmu = "{a}.fmu"
isolated = {isolated}
[participants.a.parameters]
gain = 30.0
x0 = 1.0
fails_at = {fails_at}
[participants.b]
fmu = "cell.fmu"
isolated = {isolated}
[participants.b.parameters]
gain = -30.0
[[wires]]
from = "a.x"
to = "b.u"
tolerance = {tolerance}
[[wires]]
from = "b.x"
to = "a.u"
tolerance = 1e-9
[coupling]
method = "{method}"
order = ["a", "b"]
parallel = {parallel}
"""


def description(derivative):
    variables = "".join(
        f'<ScalarVariable name="{name}" valueReference="{k}" causality="{causality}" '
        f'variability="{"fixed" if causality == "parameter" else "continuous"}"><Real '
        + (f'start="{STARTS[name]}" ' if name in STARTS else "")
        + 'nominal="1"/></ScalarVariable>'
        for k, (name, causality) in enumerate(NAMES.items())
    )
    return (
        '<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0" modelName="cell" guid="1">'
        '<CoSimulation modelIdentifier="cell" canHandleVariableCommunicationStepSize="true" '
        f'canGetAndSetFMUstate="true" providesDirectionalDerivative="{derivative}"/>'
        f"<ModelVariables>{variables}</ModelVariables><ModelStructure><Outputs>"
        '<Unknown index="2"/></Outputs></ModelStructure></fmiModelDescription>'
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("strict")
    for name, flags, derivative in (
        ("cell", (), "true"),
        ("plain", (), "false"),
        ("refuses", ("-DREFUSES",), "true"),
    ):
        library = folder / f"{name}.so"
        compile_model(MODELS / "cell.c", library, *flags)
        with zipfile.ZipFile(folder / f"{name}.fmu", "w") as target:
            target.writestr("modelDescription.xml", description(derivative))
            target.write(library, "binaries/linux64/cell.so")
    return folder


def run(folder, output, a="cell", method="newton", isolated=False, fails_at=1e9, parallel=False):
    """The finished command, and its summary if it wrote one."""
    text = CASE.format(
        a=a,
        method=method,
        fails_at=fails_at,
        isolated=str(isolated).lower(),
        parallel=str(parallel).lower(),
        tolerance="1e-9",
    )
    case = folder / "case.toml"
    case.write_text(text)
    command = ["run", case, "--no-plots", "--output", output, "--summary-json", output / "s.json"]
    done = call(*command)
    summary = output / "s.json"
    return done, json.loads(summary.read_text()) if summary.exists() else None


def exact():
    """a over the steps of Eq. (X11)."""
    matrix = np.array([[1 + STEP, -STEP * GAIN], [STEP * GAIN, 1 + STEP]])
    states = [np.array([1.0, 0.0])]
    for _ in range(10):
        states.append(np.linalg.solve(matrix, states[-1]))
    return np.array(states)[:, 0]


def test_the_standards_derivative_does_not_mislead_newton(folder, tmp_path):
    done, summary = run(folder, tmp_path)
    assert done.returncode == 0, done.stderr
    # a linear loop: differences find it in one step of Newton, two evaluations
    assert summary["mean_iterations"] <= 2.2 and summary["halved_steps"] == 0
    assert summary["derivatives_by_differences"] == 2
    assert "finite differences instead of its directional derivative" in " ".join(
        done.stdout.split()
    )
    results = Results(tmp_path / "base.h5")
    # each step is off by the tolerance of 1e-9 at most, ten of them
    np.testing.assert_allclose(results.series("a.x")[0], exact(), atol=1e-8)


def test_jacobi_in_two_processes_gives_the_bits_of_one(folder, tmp_path):
    both = []
    for isolated in (False, True):
        output = tmp_path / str(isolated)
        output.mkdir()
        done, _ = run(folder, output, method="iqn_ils", isolated=isolated, parallel=True)
        assert done.returncode == 0, done.stderr
        both.append(Results(output / "base.h5").series("a.x")[0])
    np.testing.assert_array_equal(*both)
    np.testing.assert_allclose(both[0], exact(), atol=1e-8)


@pytest.mark.parametrize("isolated", [False, True])
def test_an_fmu_that_is_not_to_be_instantiated_says_why(folder, tmp_path, isolated):
    done, _ = run(folder, tmp_path, a="refuses", isolated=isolated)
    assert done.returncode == 2 and "participants.a, no licence for this cell" in done.stderr


@pytest.mark.parametrize("isolated", [False, True])
def test_a_fault_is_heard_and_nothing_is_asked_of_the_fmu_after_it(folder, tmp_path, isolated):
    done, _ = run(folder, tmp_path, fails_at=0.55, isolated=isolated)
    assert done.returncode == 1
    assert "a: the cell has burst" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.parametrize("isolated", [False, True])
def test_an_fmu_that_cannot_be_terminated_is_heard_and_freed(folder, isolated):
    one = FmuParticipant("one", folder / "cell.fmu")
    if isolated:
        one = IsolatedParticipant(one, 30.0)
    one.start({"fails_at": 0.2}, 0.0, 1.0)
    with pytest.raises(Exception, match="one: at its end: the cell will not end"):
        one.close()
    one.close()  # nothing is left to close
