"""Cost of a macro step in calls of functions, which no machine load changes.

`tests/bench/step_cost.py` prints times. A bare FMPy loop needs 15 calls for an FMU and step.
"""

import sys
from functools import partial

import pytest

from ..bench.step_cost import Bare, make, per_step, run


def calls(action):
    """Return the number of calls of functions, of Python and of C, in an action."""
    count = 0

    def note(frame, event, argument):
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(note)
    try:
        action()
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.parametrize(
    "count, method, most", [(2, "explicit", 4.4), (8, "explicit", 2.5), (2, "newton", 5.1)]
)
def test_an_evaluation_needs_few_calls(tmp_path, count, method, most):
    """Measured: 4.15, 2.38 and 4.94 times as many as a bare loop, whose calls take longer each."""
    fmu = make(tmp_path)
    ours = partial(run, fmu, count, tmp_path, method)
    evaluations = ours(200)["residual_evaluations"] / 200
    # a run that waits for the processor flushes more rows
    own, bare = (
        min(per_step(calls, action, 200) for _ in range(3))
        for action in (ours, Bare(fmu, count).run)
    )
    assert own / evaluations <= most * bare
