"""Examples in docstrings of laws and helpers. `test_api` runs those of the public functions."""

import doctest
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXTS = {
    path.relative_to(ROOT).with_suffix(""): path.read_text()
    for part in ("fmu_ehd", "fmu_mfbd", "master")
    for path in sorted((ROOT / part).rglob("*.py"))
}
MODULES = [path for path, text in TEXTS.items() if ">>> " in text and " pc." not in text]


@pytest.mark.parametrize("path", MODULES, ids=str)
def test_examples_run(path):
    module = import_module(".".join(["piston_cosim", *path.parts]))
    failed, tried = doctest.testmod(module, optionflags=doctest.ELLIPSIS)
    assert not failed and tried >= TEXTS[path].count("    >>> ")
