"""Participants, methods, step controls and observers of another installed package.

The case is the elastic tube with its wall outside.
"""

import tomllib
from pathlib import Path

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.fmi.errors import BadInput

from .counter import case_text
from .runs import run_tree, stopped, values_of

ROOT = Path(__file__).parents[2]
TUBE = ROOT / "models" / "elastic_tube" / "case.toml"
SHORT = [("time.stop", "0.05 s")]


@pytest.fixture
def installed(monkeypatch):
    """Add the example package to the path, as pip would install it."""
    monkeypatch.syspath_prepend(Path(__file__).parent / "outside")


def outside(tree):
    """Return the case with the wall of the other package."""
    tree["participants"]["wall"] = {"plugin": "outside_wall"}
    tree["wires"][1]["from"] = "wall.area"
    return tree


def test_the_tube_with_one_side_outside_gives_the_same_bits(installed, tmp_path):
    trees = {"ours": read_tree(TUBE, SHORT), "theirs": outside(read_tree(TUBE, SHORT))}
    ours, theirs = (run_tree(TUBE, tree, tmp_path / f"{n}.h5") for n, tree in trees.items())
    assert np.array_equal(ours.dataset("fluid.pressure")[:], theirs.dataset("fluid.pressure")[:])
    name = "residual_evaluations"
    assert ours.summary[name] == theirs.summary[name]


@pytest.fixture
def lags(installed, folder):
    """Tree of two lags in a loop, solved by the method of the other package."""
    tight = "tolerance = 1e-13"
    text = case_text([("a.x", "b.u", tight), ("b.x", "a.u", tight)], "anderson_one", a="k = 2.0")
    tree = tomllib.loads(text)
    tree["coupling"]["options"] = {"first": 0.7}
    tree["record"] = {"fields": [], "checkpoint_every": 2}
    return tree


def test_a_method_and_an_observer_from_outside(lags, tmp_path):
    lags["observers"] = {"window_times": {}}
    results = run_tree(tmp_path / "case", lags, tmp_path / "o.h5")
    x, summary = values_of(results, "a.x"), results.summary
    # (1 + H k) a - H b = a_0, (1 + H) b - H a = b_0
    matrix, states = np.array([[1.2, -0.1], [-0.1, 1.1]]), [np.ones(2)]
    for _ in range(10):
        states.append(np.linalg.solve(matrix, states[-1]))
    np.testing.assert_allclose(x, np.array(states)[:, 0], rtol=0, atol=1e-12)  # the tolerance
    lines = (tmp_path / "o.times").read_text().splitlines()
    ends = [float(line.split()[0]) for line in lines]
    assert ends == pytest.approx(0.1 * np.arange(1, 11))
    assert sum(int(line.split()[1]) for line in lines) == summary["residual_evaluations"]


def test_checkpoints_hold_what_the_method_remembers(lags, tmp_path):
    case, output = tmp_path / "case", tmp_path / "o.h5"
    kept = stopped(case, lags, output, 0.75)
    assert kept.account.steps_done == 6
    resumed = values_of(run_tree(case, lags, output, begin_at=kept), "a.x")
    assert np.array_equal(resumed, values_of(run_tree(case, lags, tmp_path / "whole.h5"), "a.x"))


def test_a_step_control_from_outside(installed, tmp_path):
    tree = outside(read_tree(TUBE, [("time.stop", "0.02 s")]))
    tree["coupling"]["step_control"] = "every_half"
    tree["wires"][0]["relative_tolerance"] = 1e-3
    assert run_tree(TUBE, tree, tmp_path / "o.h5").time == pytest.approx(
        [0, 0.005, 0.01, 0.015, 0.02]
    )


@pytest.mark.parametrize(
    "change, words",
    [
        (
            lambda t: t["participants"]["wall"].update(plugin="nobody"),
            "participants.wall.plugin: expected outside_wall, got unknown plugin 'nobody'",
        ),
        (lambda t: t["participants"]["wall"].update(build={"x": 1}), "unknown options x"),
        (lambda t: t["coupling"].update(method="nothing"), "unknown method 'nothing'"),
        (
            lambda t: t["coupling"].update(step_control="none"),
            "coupling.step_control: expected every_half, got unknown plugin",
        ),
        (
            lambda t: t.update(observers={"none": {}}),
            "observers: expected window_times, got unknown plugin 'none'",
        ),
    ],
)
def test_what_no_package_brings_is_refused(installed, change, words):
    tree = outside(read_tree(TUBE, SHORT))
    change(tree)
    with pytest.raises(BadInput, match=words):
        open_system(check_case(tree, "case"), TUBE.parent, print)


def test_without_the_package_its_names_are_unknown():
    with pytest.raises(
        BadInput,
        match="plugin: expected nothing, .* no plugin, got 'outside_wall'; install the package",
    ):
        open_system(check_case(outside(read_tree(TUBE, SHORT)), "case"), TUBE.parent, print)
