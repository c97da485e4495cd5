"""The example in models/engine: three FMUs in an SSP, run explicitly and iterated."""

import numpy as np
import pytest

from piston_cosim.master.case.reading import find_case, read_tree

from ..command import call
from .runs import coarse, run_tree

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
    runs = []
    for method in ("explicit", "newton"):
        changes = {"coupling.method": method, "coupling.parallel": True}
        tree = read_tree(package, [("time.stop", f"{STEPS * 25} us"), *changes.items()])
        runs.append(run_tree(package, tree, tmp_path / f"{method}.h5"))
    speeds, powers = (
        [results.series(port).values for results in runs]
        for port in ("crankshaft.crank_speed", "piston.friction_power")
    )
    explicit, iterated = speeds
    largest = np.abs(np.diff(iterated)).max()
    assert 0 < abs(explicit[-1] - iterated[-1]) < 3 * largest  # the speed lags by about a step
    assert iterated[-1] > iterated[0]  # fired: it speeds up
    assert powers[0][-1] == pytest.approx(powers[1][-1], rel=0.05)
