"""Every quick figure of `piston-cosim verify mfbd`."""

from piston_cosim.tests.verification.cases.bodies import checks


def test_figures():
    assert [str(check) for check in checks() if not check.passed] == []
