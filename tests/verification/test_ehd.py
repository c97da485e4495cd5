"""Every row of the lubrication model's verification table."""

import pytest

from fmu_ehd.verification import checks, passes, random_starved_films

ROWS = list(checks())


@pytest.mark.parametrize("line", ROWS, ids=[f"{r['case']}: {r['quantity']}" for r in ROWS])
def test_row(line):
    assert passes(line), f"{line['computed']} instead of {line['reference']}, allowed {line['kind']} {line['tolerance']}"


def test_random_starved_films_converge_and_conserve_oil():
    failures, _, imbalance = random_starved_films(300, seed=1)  # 2000 of them: slow_checks
    assert failures == 0
    assert imbalance <= 1e-12
