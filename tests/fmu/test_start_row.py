"""FMUs with direct feedthrough, a.y = 1 - 3 u and b.y = 1 + u/2: the first row of the results is
the solution, whatever the method does afterwards.
"""

import pytest

from piston_cosim.master.coupling.stepping import StepFailed

from .test_loops import LOOP, coupled, fmus

__all__ = ["coupled", "fmus"]

PAIR = {"a": "minus_three", "b": "plus_half"}


@pytest.mark.parametrize("method", ["newton", "iqn_ils", "explicit"])
def test_the_first_row_is_consistent(coupled, method):
    results = coupled(PAIR, LOOP, stop="30 ms", method=method)
    # u = 1 + (1 - 3 u)/2 at u = 0.6; differences over 1e-5 of numbers near 1 are good to 1e-10
    for port, value in (("a.y", -0.8), ("b.y", 0.6)):
        assert results.series(port).values == pytest.approx(value, abs=1e-9)


def test_an_explicit_loop_that_diverges_stops(coupled):
    """The gain is -1.5: from round-off to the limit in some 60 macro steps."""
    with pytest.raises(StepFailed, match="expected an exchange that stays bounded"):
        coupled(PAIR, LOOP, stop="2 s", method="explicit")
