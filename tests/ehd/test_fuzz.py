import warnings

from .fuzz import Fuzz


def test_no_call_raises_and_no_refusal_changes_the_state(tmp_path):
    fuzz = Fuzz(1, tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # overflow in senseless values
        fuzz.run(3000)
    assert fuzz.taken > 100 and fuzz.refused > 100
