"""Flexible piston on its crank against Exudyn, an independent multibody code, on the same mesh."""

import pytest

from piston_cosim.tests.verification.cases.bodies import exudyn_checks

pytest.importorskip(
    "exudyn", reason="Exudyn (extra `oracle`) has no wheel for every Python and machine"
)


def test_piston_on_its_crank_moves_as_exudyns():
    made = list(exudyn_checks())
    assert len(made) == 10
    assert [str(check) for check in made if not check.passed] == []
