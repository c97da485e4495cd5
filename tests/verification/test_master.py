"""Every quick figure of `piston-cosim verify master`."""

from piston_cosim.tests.verification.cases.coupling import checks, plain_converges


def test_figures():
    assert [str(check) for check in checks() if not check.passed] == []


def test_plain_iteration_fails_on_the_tube():
    assert plain_converges() == 0
