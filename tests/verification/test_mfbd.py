"""Every quick figure of `piston-cosim verify mfbd`."""

import pytest

from fmu_mfbd.verification import checks

ROWS = list(checks())


@pytest.mark.parametrize("row", ROWS, ids=[f"{r['case']}: {r['quantity']} #{k}" for k, r in enumerate(ROWS)])
def test_figure(row):
    error = abs(row["computed"] - row["reference"])
    if row["kind"] == "relative":
        error /= abs(row["reference"])
    assert error <= row["tolerance"], row["reason"]
