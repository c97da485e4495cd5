"""The example in models/engine: three FMUs in an SSP.

FMPy runs them explicitly, and the master iterates them.
"""

import pytest

from piston_cosim.master.case.reading import find_case, read_tree

from ..command import call
from .runs import coarse, module_of, run_tree

HOME = find_case("numerical_example").parents[1] / "engine"
STEPS = 40


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    folder = tmp_path_factory.mktemp("engine")
    small = [word for key, value in coarse() for word in ("--set", f"{key}={value}")]
    piston, ssp = folder / "piston.fmu", folder / "engine.ssp"
    for words in (
        ("numerical_example", *small, "--output", piston),
        (HOME / "system.toml", "--set", f"participants.piston.fmu={piston}", "--output", ssp),
    ):
        done = call("fmu", "export", *words)
        assert done.returncode == 0, done.stderr
    return ssp


def test_explicit_and_iterated_runs_differ_by_the_delay_of_a_step(package, tmp_path):
    speed, lateral, power = module_of(HOME / "by_fmpy.py").simulate(package, STEPS)
    tree = read_tree(package, [("time.stop", f"{STEPS * 25} us")])
    results = run_tree(package, tree, tmp_path / "run.h5")
    iterated = results.series("crankshaft.crank_speed")[0]
    largest = max(abs(iterated[1:] - iterated[:-1]))
    assert abs(speed - iterated[-1]) < 3 * largest  # the speed lags by about a step of it
    assert iterated[-1] > iterated[0]  # fired: it speeds up
    assert power == pytest.approx(results.series("piston.friction_power")[0][-1], rel=0.05)
