"""Every row of the lubrication model's verification table."""

import pytest

from fmu_ehd.verification import checks, passes

ROWS = list(checks())


@pytest.mark.parametrize("line", ROWS, ids=[f"{r['case']}: {r['quantity']}" for r in ROWS])
def test_row(line):
    assert passes(line), f"{line['computed']} instead of {line['reference']}, allowed {line['kind']} {line['tolerance']}"
