"""Pinned runs: the results of the shipped cases have not changed.

These tests do not show that the results are right: tests/ehd, tests/mfbd and tests/verification do.

The values and the runs are in values.toml. `python tests/pinned/renew.py` renews them, and prints
old and new values side by side.
"""

import pytest

from . import renew

# Measure -> tolerance, relative. The coupled step is solved to 1 nm of film: curves with 10 nm and
# with 0.1 nm differ by 2e-6 of their range (README of numerical_example), and another processor or
# library rounds each iteration differently, which at worst ends one iteration earlier or later.
TOLERANCES = {
    # a mean over all steps, in which such differences cancel: 1.2e-7 between 10 and 0.1 nm
    "mean_friction_power_w": 1e-6,
    # one cell at one instant; goes with h^-3, so three times what the film is worth, and the
    # instant's own iteration ended at up to 1 nm of 10 um
    "maximum_pressure_pa": 3e-4,
    # one cell at one instant: the coupling's 1 nm of 10 um
    "minimum_film_m": 1e-4,
    # follow from inertia and gas, the film passes them on: five times 2e-6
    "side_force_min_n": 1e-5,
    "side_force_max_n": 1e-5,
    # ranges of smooth curves: five times 2e-6
    "lateral_range_m": 1e-5,
    "rocking_range_rad": 1e-5,
    # inertia and gas with a little friction
    "crank_torque_max_nm": 1e-6,
}


def pytest_generate_tests(metafunc):
    """One test a pinned run, the slow ones marked."""
    if "name" in metafunc.fixturenames:
        table = renew.read_values()
        marks = {True: pytest.mark.slow, False: ()}
        runs = [pytest.param(name, marks=marks[entry["slow"]]) for name, entry in table.items()]
        metafunc.parametrize("name", runs)


def test_run_gives_what_it_gave(name, tmp_path):
    entry = renew.read_values()[name]
    values = renew.run(entry, tmp_path)
    assert set(values) == set(entry["values"]) == set(TOLERANCES)
    wrong = [
        f"{key} = {value:.10g}, pinned {entry['values'][key]:.10g}"
        for key, value in values.items()
        if value != pytest.approx(entry["values"][key], rel=TOLERANCES[key], abs=0.0)
    ]
    assert wrong == []
