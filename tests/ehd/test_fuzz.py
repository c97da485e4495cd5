import importlib.util
import warnings
from pathlib import Path


def test_no_call_raises_and_no_refusal_changes_the_state(tmp_path):
    specification = importlib.util.spec_from_file_location(
        "fuzz", Path(__file__).parent / "fuzz.py"
    )
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    fuzz = module.Fuzz(1, tmp_path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # overflow in senseless values
        fuzz.run(3000)  # 100 000 of them: python tests/ehd/fuzz.py 100000
    assert fuzz.taken > 100 and fuzz.refused > 100
