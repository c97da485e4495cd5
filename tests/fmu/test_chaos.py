"""Two minutes of chaos.py: whatever happens to a run, its tables are those of a calm one."""

import pytest

from piston_cosim.master.fmi.compiler import compiler

from . import chaos

SECONDS = 120


@pytest.mark.skipif(not compiler(), reason="no C compiler")
def test_tables_are_those_of_an_undisturbed_run(tmp_path):
    rounds, seen = chaos.chaos(SECONDS, tmp_path)
    assert rounds >= 1 and sum(seen.values()) >= 1
