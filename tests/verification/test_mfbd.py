"""Every quick figure of `piston-cosim verify mfbd`."""

import pytest
from piston_cosim.fmu_mfbd.verification import checks
from piston_cosim.master.verification.rows import error_of

ROWS = list(checks())


@pytest.mark.parametrize(
    "row", ROWS, ids=[f"{r['case']}: {r['quantity']} #{k}" for k, r in enumerate(ROWS)]
)
def test_figure(row):
    assert error_of(row) <= row["tolerance"], row["reason"]
