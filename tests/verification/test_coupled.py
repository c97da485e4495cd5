"""Quick figures of `piston-cosim verify coupled`.

An error of the FMUs, or of the reference (`monolithic`, one system of equations), makes the two
sides differ.
"""

import pytest

from piston_cosim.tests.verification.cases import coupled

slow = pytest.mark.slow


@pytest.mark.parametrize("span", [coupled.IMPACT, pytest.param(coupled.FIRST_TURN, marks=slow)])
def test_figures_of_the_motored_engine(span):
    assert [str(check) for check in coupled.motored(42, span) if not check.passed] == []


def test_figures_of_the_fired_engine():
    assert [str(check) for check in coupled.fired_checks() if not check.passed] == []


def failed(change):
    """Quantities of the fired engine whose checks fail if parameters of the film are wrong."""
    return {check.quantity for check in coupled.fired_checks(change) if not check.passed}


def test_errors_of_five_percent_in_boundary_friction_and_layer_are_seen():
    wrong = {
        "boundary_friction_coefficient": "0.126",
        "oil_ring_layer": "2.1 um",
        "initial_oil_layer": "3.15 um",
    }
    assert failed(wrong) == {
        "friction_force_asperity, scale of the curve [-]",
        "oil_in_film, scale of the curve [-]",
    }
