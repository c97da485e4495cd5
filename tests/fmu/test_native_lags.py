"""The native coupled FMU compared with the one in Python: two lags in a loop (`outside/lag`).

These participants compile in seconds.
"""

import os
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from .pairs import side_by_side
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


def given(one, k):
    """Return loads that change."""
    return {"a.load": np.sin(k), "b.load": 0.5 * np.cos(k)}


def compared(fmus, lengths, values=(), inputs=given, **more):
    """Both after steps of some numbers of macro steps, and how far they were apart."""

    def length(k):
        return STEP * lengths[k - 1]

    return side_by_side(fmus, dict(values), inputs, len(lengths), length, redo=99, **more)


def states(apart):
    """Return the last states of both FMUs."""
    return [np.array([float(one[f"{name}.x"]) for name in "ab"]) for one in apart.last]


def test_steps_and_derivatives_are_those_of_the_fmu_in_python(fmus):
    """Steps of one, three and two and a half macro steps agree, and so do their derivatives.

    A derivative takes the step again with nudged inputs and changes no state.
    """
    lengths = (1, 1, 3, 2.5, 1)
    products = ["a.x", "b.x"]
    seeds = {"a.load": 1.0, "b.load": -0.5}
    apart = compared(fmus, lengths, derive=2, seeds=seeds, products=products)
    for name in products:
        assert apart.off[name] <= ROUND_OFF < 0.1 < apart.size[name]
        assert apart.off[f"of {name}"] <= 1e-8
    # Eq. (X14) of the last macro step by hand: both inputs are those at its end
    (before, _), (after, _) = (states(compared(fmus, lengths[:n])) for n in (4, 5))
    rates = np.array([3.0, -2.0]) * np.tanh(after[::-1]) + [np.sin(5), 0.5 * np.cos(5)]
    np.testing.assert_allclose(after, (before + STEP * rates) / (1 + STEP), atol=1e-11)


@pytest.mark.parametrize("longest, halves", [(0.06, 2), (0.03, 4)])
def test_a_discarded_step_is_taken_in_halves(fmus, longest, halves):
    """As so many shorter macro steps, by hand."""
    limit = {"b.longest": longest}
    apart = compared(fmus, (1, 1, 1), limit)
    assert max(apart.off[f"{name}.x"] for name in "ab") <= ROUND_OFF
    halved, _ = states(compared(fmus, (1,), limit))
    fine, _ = states(compared(fmus, (1 / halves,) * halves, inputs=lambda one, k: given(one, 1)))
    np.testing.assert_allclose(halved, fine, atol=1e-11)  # to the tolerance of the wires
