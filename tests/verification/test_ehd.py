"""Every quick figure of `piston-cosim verify ehd`."""

import pytest

from piston_cosim.tests.verification.cases import film, reciprocating


@pytest.mark.parametrize("part", [film, reciprocating])
def test_figures(part):
    assert [str(check) for check in part.checks() if not check.passed] == []
