import warnings

from .fuzz import Fuzz


def test_no_call_raises_and_no_refusal_changes_the_state(tmp_path):
    fuzz = Fuzz(1, tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # overflow in senseless values
        fuzz.run(3000)  # 100 000 of them: python tests/ehd/fuzz.py 100000
    assert fuzz.taken > 100 and fuzz.refused > 100
