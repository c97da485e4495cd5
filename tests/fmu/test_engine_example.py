"""The example in models/engine: three FMUs in an SSP, run explicitly by FMPy and iterated by the
master.
"""

import importlib.util

import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

HOME = find_case("numerical_example").parents[1] / "engine"
STEPS = 40
SMALL = [
    ("participants.bodies.build.grid", [12, 10]),
    ("participants.ehd.build.grid", [12, 10]),
    ("participants.bodies.build.piston.modes", 0),
    ("participants.bodies.build.block.modes", 0),
]


def script(name):
    spec = importlib.util.spec_from_file_location(f"engine_{name}", HOME / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    return script("make").make(tmp_path_factory.mktemp("engine"), SMALL)


def test_explicit_and_iterated_runs_differ_by_the_delay_of_a_step(package, tmp_path):
    speed, lateral, power = script("by_fmpy").simulate(package, STEPS)
    tree = read_tree(package, [("time.stop", f"{STEPS * 25} us")])
    run(
        open_system(check_case(tree, package), package.parent, print),
        check_case(tree, package),
        tree,
        tmp_path / "run.h5",
    )
    results = Results(tmp_path / "run.h5")
    iterated = results.series("crankshaft.crank_speed")[0]
    largest = max(abs(iterated[1:] - iterated[:-1]))
    assert abs(speed - iterated[-1]) < 3 * largest  # the speed lags by about a step of it
    assert iterated[-1] > iterated[0]  # fired: it speeds up
    assert power == pytest.approx(results.series("piston.friction_power")[0][-1], rel=0.05)
