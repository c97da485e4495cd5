"""The coupled FMU that needs no Python, next to the one in Python, on participants that compile in
seconds: two lags in a loop (`outside/lag`).
"""

import os
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from piston_cosim.master.participants.fmi2 import FmuParticipant

from .runs import export

OUTSIDE = Path(__file__).parent / "outside"
STEP = 0.1
TREE = {
    "title": "Lags",
    "time": {"stop": "1 s", "step": "0.1 s"},
    "participants": {
        "a": {"package": "lag", "parameters": {"gain": 3.0}},
        "b": {"package": "lag", "parameters": {"gain": -2.0}},
    },
    "wires": [
        {"from": "b.x", "to": "a.u", "tolerance": 1e-12},
        {"from": "a.x", "to": "b.u", "tolerance": 1e-12, "largest_decrease": 0.2},
    ],
    "coupling": {"method": "newton", "order": ["a", "b"], "predictor": 1},
}
ROUND_OFF = 1e-13
"""Some ten operations a step on numbers of order 1, in another order, and ten steps."""


@contextmanager
def made_of_lags():
    """Put the package of the lag on the path, here and in other processes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(OUTSIDE)
        path = os.pathsep.join([str(OUTSIDE), *filter(None, [os.environ.get("PYTHONPATH")])])
        patch.setenv("PYTHONPATH", path)
        yield


@pytest.fixture(scope="module")
def fmus():
    """As machine code, and in Python."""
    with made_of_lags():
        yield [export(TREE, OUTSIDE / "case.toml", native) for native in (True, False)]


@pytest.fixture
def both(fmus):
    """Start both FMUs with some values."""

    def start(**values):
        participants = [FmuParticipant("lags", path) for path in fmus]
        for one in participants:
            one.start(values, 0.0, 10.0)
        return participants

    return start


def given(one, k):
    """Loads that change."""
    return {"a.load": np.sin(k), "b.load": 0.5 * np.cos(k)}


def step(one, k, steps=1):
    """The k-th step, or several in one."""
    for name, value in given(one, k).items():
        one.set(name, value)
    one.step((k - 1) * STEP, steps * STEP)


def values(one):
    return np.array([float(one.get(f"{name}.x")) for name in "ab"])


def agree(participants):
    ours, theirs = map(values, participants)
    np.testing.assert_allclose(ours, theirs, rtol=0.0, atol=ROUND_OFF)
    return ours


def test_steps_are_those_of_the_fmu_in_python(both):
    """Of one macro step, of three, and of two and a half."""
    one, other = both()
    moved = []
    for k, steps in ((1, 1), (2, 1), (3, 3), (6, 2.5), (8.5, 1)):
        for participant in (one, other):
            step(participant, k, steps)
        moved.append(agree((one, other)))
    assert np.ptp(moved, axis=0).min() > 0.1
    # Eq. (X14) of the last macro step by hand: both inputs are those at its end
    before, after = moved[-2:]
    rates = np.array([3.0, -2.0]) * np.tanh(after[::-1]) + [np.sin(8.5), 0.5 * np.cos(8.5)]
    np.testing.assert_allclose(after, (before + STEP * rates) / (1 + STEP), atol=1e-11)


@pytest.mark.parametrize("longest, halves", [(0.06, 2), (0.03, 4)])
def test_a_discarded_step_is_taken_in_halves(both, longest, halves):
    """As so many shorter macro steps, by hand."""
    one, other = both(**{"b.longest": longest})
    fine, _ = both()
    for participant in (one, other):
        step(participant, 1)
    halved = agree((one, other))
    fine.set("a.load", np.sin(1))
    fine.set("b.load", 0.5 * np.cos(1))
    for k in range(halves):
        fine.step(k * STEP / halves, STEP / halves)
    np.testing.assert_allclose(halved, values(fine), atol=1e-11)  # to the tolerance of the wires
    for k in (2, 3):
        for participant in (one, other):
            step(participant, k)
    agree((one, other))


def test_derivatives_are_those_of_the_fmu_in_python(both):
    """The step taken again with nudged inputs; nothing stays behind."""
    one, other = both()
    for participant in (one, other):
        step(participant, 1)
        step(participant, 2)
    seeds = {"a.load": np.array(1.0), "b.load": np.array(-0.5)}
    ours, theirs = (p.derivative(seeds, ["a.x", "b.x"]) for p in (one, other))
    for name in ("a.x", "b.x"):
        assert abs(float(theirs[name])) > 1e-3
        np.testing.assert_allclose(ours[name], theirs[name], rtol=1e-8)
    for participant in (one, other):
        step(participant, 3)
    agree((one, other))
