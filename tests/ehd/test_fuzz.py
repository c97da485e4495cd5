import warnings

import pytest

from .fuzz import Fuzz


@pytest.mark.parametrize("calls", [3000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_no_call_raises_and_no_refusal_changes_the_state(tmp_path, calls):
    fuzz = Fuzz(1, tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # overflow in senseless values
        fuzz.run(calls)
    assert fuzz.taken > 100 and fuzz.refused > 100
