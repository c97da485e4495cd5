"""chaos.py for a while: whatever happens to a run, its tables are those of a calm one."""

import pytest

from piston_cosim.master.fmi.compiler import compiler

from . import chaos


@pytest.mark.slow
@pytest.mark.skipif(not compiler(), reason="no C compiler")
def test_tables_are_those_of_an_undisturbed_run(tmp_path):
    rounds, seen = chaos.chaos(120, tmp_path)
    assert rounds >= 1 and sum(seen.values()) >= 1
