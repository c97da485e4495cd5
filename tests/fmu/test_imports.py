"""A run of foreign FMUs imports nothing slow that only our own bodies and films need."""

import pytest

from ..command import script

HEAVY = ("numba", "scipy", "matplotlib", "pint", "skfem", "pandas", "cyclopts")
PROGRAM = """
import sys
from time import process_time
import piston_cosim as pc
pc.couple
print(process_time())
pc.couple(
    {"a": "a.fmu", "b": "b.fmu"}, ["a.x -> b.u", "b.x -> a.u"], stop="5 ms", step="1 ms",
    parameters={"a": {"k": 2.0}}, method=sys.argv[1],
).run("results.h5")
print(*{name.partition(".")[0] for name in sys.modules})
"""


@pytest.mark.parametrize("method", ["explicit", "iqn_ils", "newton"])
def test_a_run_of_foreign_fmus_imports_nothing_heavy(folder, monkeypatch, method):
    # an empty cache: no answer of pint is known
    monkeypatch.setenv("PISTON_COSIM_CACHE", str(folder / "cache"))
    seconds, modules = script(PROGRAM, method, cwd=folder).splitlines()
    assert set(HEAVY) & set(modules.split()) == set()
    # 0.25 s on a quiet machine; the limit is the promise of docs/python.md, doubled for a busy one
    assert float(seconds) < 1.0
