"""Every quick figure of `piston-cosim verify mfbd`."""

from piston_cosim.fmu_mfbd.verification import checks
from piston_cosim.master.verification.rows import error_of


def test_figures():
    wrong = [
        f"{row['case']}: {row['quantity']}: {row['computed']}, off by {error_of(row)}, allowed "
        f"{row['tolerance']}: {row['reason']}"
        for row in checks()
        if not error_of(row) <= row["tolerance"]
    ]
    assert wrong == []
