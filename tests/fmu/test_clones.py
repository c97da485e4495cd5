"""Difference probes of Newton on clones at the same time: the bits do not depend on their number,
and the loop reaches its fixed point.

Eq. (X22):  (1 + H) x_i' = x_i + H (u_i + b u_1 u_2 u_3),   u = g x'
"""

import zipfile

import numpy as np
import pytest
from scipy.optimize import fsolve

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.coupling.starting import closing, start
from piston_cosim.master.fmi.errors import BadInput

from . import vectors
from .runs import run_text
from .test_foreign_fmus import FEEDTHROUGH

STEPS, H = 4, 0.1


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clones")
    vectors.make(folder)
    return folder


def solved(folder, output, more):
    text = vectors.CASE.format(stop=STEPS * H, more=more)
    results = run_text(folder, text, output=output)
    return results.summary, results.dataset("bent.x")[:]


def exact():
    """x over the steps of Eq. (X22)."""
    states = [np.array([1.0, 2.0, -3.0])]
    for _ in range(STEPS):

        def off(new, old=states[-1]):
            u = vectors.GAIN * new
            return (1 + H) * new - old - H * (u + vectors.BEND * np.prod(u))

        states.append(fsolve(off, states[-1], xtol=1e-12))
    return np.array(states)


def test_the_bits_do_not_depend_on_how_many_clones_there_are(folder, tmp_path):
    found, iterations = [], []
    for clones in (0, 1, 2, 3):
        more = f"isolated = true\nclones = {clones}"
        summary, x = solved(folder, tmp_path / f"{clones}.h5", more)
        found.append(x)
        iterations.append(summary["mean_iterations"])
        # a tolerance of 1e-10 in u a step, four steps
        np.testing.assert_allclose(x, exact(), atol=1e-9)
    assert found[1].tobytes() == found[2].tobytes() == found[3].tobytes()
    # columns are as good a derivative as the products that Newton asks for without clones
    assert iterations[1] <= iterations[0] + 0.5


def test_columns_are_those_of_the_last_step(folder):
    """dy_i/du_j = H (delta_ij + b prod(u) / u_j) / (1 + H), by Eq. (X22)."""
    path = folder / "case.toml"
    path.write_text(vectors.CASE.format(stop=1.0, more="isolated = true\nclones = 2"))
    system = open_system(check_case(read_tree(path), path), folder, print)
    bent = system.participants["bent"]
    with closing(system.participants.values()):
        start(system)
        saved = bent.save()
        for u in (np.array([1.0, 2.0, 3.0]), np.array([-0.5, 4.0, 0.25])):
            bent.restore(saved)
            bent.set("u", u)
            bent.step(0.0, H)
            v = np.array([0.3, -1.0, 2.0])
            found = bent.derivative({"u": v}, ["x"])["x"]
            matrix = H * (np.eye(3) + vectors.BEND * np.prod(u) / u) / (1 + H)
            # round-off of x, 1e-16, over a change of 1e-5 of u
            np.testing.assert_allclose(found, matrix @ v, rtol=1e-9, atol=1e-10)


@pytest.mark.parametrize(
    "more, words",
    [
        ("clones = 2", "clones: expected isolated = true with clones, got false"),
        ("isolated = true\nclones = -1", "clones: expected a value of at least 0, got -1"),
    ],
)
def test_clones_that_there_cannot_be_are_refused(folder, tmp_path, more, words):
    with pytest.raises(BadInput, match=words):
        solved(folder, tmp_path / "o.h5", more)


def test_clones_of_an_fmu_that_does_not_serialise_are_refused(folder, tmp_path):
    path = folder / "case.toml"
    text = vectors.CASE.format(stop=STEPS * H, more="").replace(
        'fmu = "gain.fmu"', 'fmu = "gain.fmu"\nisolated = true\nclones = 1'
    )
    path.write_text(text.replace("gain.fmu", "plain.fmu"))
    plain = FEEDTHROUGH.replace(' canSerializeFMUState="true"', "")
    with zipfile.ZipFile(folder / "plain.fmu", "w") as target:
        target.writestr("modelDescription.xml", plain)
    with pytest.raises(
        BadInput, match="clones: expected an FMU that saves its state, got plain.fmu"
    ):
        open_system(check_case(read_tree(path), path), folder, print)


def test_clones_beside_interpolated_inputs_are_refused(folder):
    path = folder / "case.toml"
    text = vectors.CASE.format(stop=STEPS * H, more="isolated = true\nclones = 1\nstep = '0.1 s'")
    path.write_text(text.replace("tolerance", 'interpolation = "linear"\ntolerance'))
    with pytest.raises(
        BadInput, match="expected held inputs for a participant with clones, got 'linear'"
    ):
        open_system(check_case(read_tree(path), path), folder, print)
