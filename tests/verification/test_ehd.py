"""Every quick figure of `piston-cosim verify ehd`."""

from piston_cosim.tests.verification.cases.film import checks


def test_figures():
    assert [str(check) for check in checks() if not check.passed] == []
