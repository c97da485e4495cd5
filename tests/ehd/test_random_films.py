from piston_cosim.tests.verification.cases.film import random_starved_films


def test_random_starved_films_converge_and_conserve_oil():
    failures, _, imbalance = random_starved_films(300, seed=1)  # 2000 of them: film.slow_checks
    assert failures == 0
    assert imbalance <= 1e-12  # round-off
