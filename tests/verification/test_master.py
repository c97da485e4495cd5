"""Every quick figure of `piston-cosim verify master`."""

from master.verification import checks, plain_converges
from master.verify import error_of


def test_figures():
    for row in checks():
        assert error_of(row) <= row["tolerance"], f"{row['case']}, {row['quantity']}: {row['computed']}"


def test_plain_iteration_fails_on_the_tube():
    assert plain_converges() == 0
