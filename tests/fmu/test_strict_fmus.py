"""An FMU that follows the standard to the letter, in a loop with itself.

Its derivative is not that of a step. It may refuse to be instantiated, fail, or refuse to end.

Eq. (X11):  (1 + H) a' = a + H g b',   (1 + H) b' = b - H g a',   a = 1, b = 0 at the start
"""

import json

import numpy as np
import pytest

from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.master.participants.isolated import IsolatedParticipant
from piston_cosim.master.results.file import Results

from ..command import call
from .c_fmus import MODELS, Variable, compile_model, describe, pack
from .counter import case_text

STEP, GAIN = 0.1, 30.0
VARIABLES = [
    Variable("u", 0, "input", "Real", 'start="0" nominal="1"'),
    Variable("x", 1, "output", "Real", 'nominal="1"'),
    Variable("gain", 2, "parameter", "Real", 'start="1"'),
    Variable("x0", 3, "parameter", "Real", 'start="0"'),
    Variable("fails_at", 4, "parameter", "Real", 'start="1e9"'),
]
WIRES = [("a.x", "b.u", "tolerance = 1e-9"), ("b.x", "a.u", "tolerance = 1e-9")]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("strict")
    text = describe("2.0", "cell", VARIABLES, 'providesDirectionalDerivative="true"')
    kinds = {"cell": (), "refuses": ("-DREFUSES",), "fatal": ("-DFAILS=4",)}
    kinds |= {"pending": ("-DFAILS=5",), "stays": ("-DENDS=3",)}
    for name, flags in kinds.items():
        library = folder / f"{name}.so"
        compile_model(MODELS / "cell.c", library, *flags)
        pack(folder / f"{name}.fmu", text, library, "cell.so")
    return folder


def run(
    folder,
    output,
    a="cell",
    method="newton",
    isolated=False,
    fails_at=1e9,
    parallel=False,
    b="cell",
):
    """Return the finished command, and its summary if it wrote one."""
    text = case_text(
        WIRES,
        method,
        a=f"gain = 30.0\nx0 = 1.0\nfails_at = {fails_at}",
        b="gain = -30.0",
        fmus=(f"{a}.fmu", f"{b}.fmu"),
        own=f"isolated = {str(isolated).lower()}",
        coupling=f"parallel = {str(parallel).lower()}",
    )
    case = folder / "case.toml"
    case.write_text(text)
    command = ["run", case, "--no-plots", "--output", output, "--summary-json", output / "s.json"]
    done = call(*command)
    summary = output / "s.json"
    return done, json.loads(summary.read_text()) if summary.exists() else None


def exact():
    """Return a over the steps of Eq. (X11)."""
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
@pytest.mark.parametrize(
    "fmu, words",
    [("cell", "the cell has burst"), ("fatal", "the cell has burst"), ("pending", "fmi2Pending")],
)
def test_a_fault_is_reported_and_no_forbidden_call_follows(folder, tmp_path, fmu, words, isolated):
    done, _ = run(folder, tmp_path, a=fmu, b=fmu, fails_at=0.55, isolated=isolated)
    assert done.returncode == 1
    assert f"a: {words}" in done.stderr.replace("expected a complete step, got ", "")
    assert "Traceback" not in done.stderr and "has ended" not in done.stderr


@pytest.mark.parametrize("isolated", [False, True])
def test_an_fmu_that_does_not_terminate_leaves_a_finished_run_finished(folder, tmp_path, isolated):
    done, summary = run(folder, tmp_path, a="stays", isolated=isolated)
    assert done.returncode == 0 and summary["steps"] == 10
    assert "a: at its end: the cell will not end" in done.stdout + done.stderr


@pytest.mark.parametrize("isolated", [False, True])
def test_an_fmu_that_cannot_be_terminated_is_heard_and_freed(folder, isolated):
    one = FmuParticipant("one", folder / "cell.fmu")
    if isolated:
        one = IsolatedParticipant(one, 30.0)
    one.start({"fails_at": 0.2}, 0.0, 1.0)
    with pytest.raises(Exception, match="one: at its end: the cell will not end"):
        one.close()
    one.close()  # nothing is left to close
