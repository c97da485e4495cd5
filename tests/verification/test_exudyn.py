"""Flexible piston on its crank against Exudyn, an independent multibody code, on the same mesh."""

import pytest

from piston_cosim.fmu_mfbd.verification import exudyn_checks
from piston_cosim.master.verification.rows import error_of

pytest.importorskip(
    "exudyn", reason="Exudyn (extra `oracle`) has no wheel for every Python and machine"
)


def test_piston_on_its_crank_moves_as_exudyns():
    rows = list(exudyn_checks())
    assert len(rows) == 10
    for row in rows:
        assert error_of(row) <= row["tolerance"], row
