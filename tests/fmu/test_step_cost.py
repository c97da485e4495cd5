"""Cost of a macro step in calls of functions, which no machine load changes.

`tests/bench/step_cost.py` prints times. A bare FMPy loop needs 15 calls for an FMU and step.
"""

import gc
import sys
import threading
from functools import partial
from math import inf

import pytest

from piston_cosim.master.runs import recorder
from piston_cosim.master.runs import run as runs

from ..bench.step_cost import Bare, make, per_step, run


def calls(action):
    """Return the number of calls of functions, of Python and of C, in an action.

    Those of `threading` do not count: whether a start waits for its thread depends on the load.
    """
    count = 0

    def note(frame, event, argument):
        nonlocal count
        is_counted = frame.f_code.co_filename != threading.__file__
        count += event in ("call", "c_call") and is_counted

    gc.collect()
    gc.disable()  # finalisers are calls too
    sys.setprofile(note)
    try:
        action()
    finally:
        sys.setprofile(None)
        gc.enable()
    return count


def fewest(action):
    """Return the fewest calls of three: what Python drops from a cache is made again once."""
    return min(calls(action) for _ in range(3))


@pytest.mark.parametrize(
    "count, method, most", [(2, "explicit", 3.5), (8, "explicit", 1.8), (2, "newton", 4.0)]
)
def test_an_evaluation_needs_few_calls(tmp_path, monkeypatch, count, method, most):
    """Measured: 3.44, 1.76 and 3.97 times as many as a bare loop, whose calls take longer each."""
    monkeypatch.setattr(recorder, "LONGEST_WAIT", inf)  # else the clock decides on rows to write
    monkeypatch.setattr(runs, "FIRST_CHECKPOINT", inf)
    fmu = make(tmp_path)
    ours = partial(run, fmu, count, tmp_path, method)
    ours(1)  # fills caches
    evaluations = ours(200)["residual_evaluations"] / 200
    bare = per_step(fewest, Bare(fmu, count).run, 200)
    assert per_step(fewest, ours, 200) / evaluations <= most * bare
