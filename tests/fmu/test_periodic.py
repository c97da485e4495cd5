"""A fired engine until its cycle repeats, and in plain cycles."""

import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.engine.measures import measures

from .runs import run_tree

PATH = find_case("data_sheet")
PLAIN = 6
TOLERANCE = 1e-3
UNTIL = ("time.until_periodic", TOLERANCE), ("time.stop", f"{20 * 720} deg")
PORTS = ("lateral_displacement", "rocking_angle", "side_force", "crank_angle")


def through(folder, name, *changes, path=PATH, grid=(12, 8), step="6 deg"):
    """Summary and results of a run on few cells in long steps."""
    usual = [
        ("participants.bodies.build.grid", list(grid)),
        ("participants.ehd.build.grid", list(grid)),
        ("time.step", step),
        ("record.fields", []),
    ]
    tree = read_tree(path, [*usual, *changes])
    results = run_tree(path, tree, folder / f"{name}.h5")
    return results.summary, results


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Without parts of steps: at 6 deg, 16 cycles with rebounds that parts resolve differ."""
    folder = tmp_path_factory.mktemp("cycles")
    whole = ("participants.bodies.parameters.impact_resolution", "1 m")
    never = ("time.until_periodic", 1e-12), ("time.stop", f"{PLAIN * 720} deg")
    plain = through(folder, "plain", whole, *never)
    return plain, through(folder, "periodic", whole, *UNTIL)


def test_equal_to_plain_cycles_in_fewer(runs):
    """Each cycle is nearer by a factor: what is left of the way is less than the last one's."""
    (_, plain), (summary, periodic) = runs
    assert summary["periodic"]
    assert summary["period_distance"] <= TOLERANCE
    assert summary["periods"] < PLAIN
    for port in PORTS[:-1]:
        ours = periodic.series(f"bodies.{port}").values
        last = plain.series(f"bodies.{port}").values[-len(ours) :]
        # 120 macro steps in both; rms over the cycle
        apart = np.sqrt(np.mean((ours - last) ** 2)) / np.ptp(last)
        assert apart <= 2 * TOLERANCE


def test_more_periods_change_the_numbers_by_less_than_a_hundredth(runs):
    """The remaining change is a share of the last one.

    The tolerance limits the last change to 1e-3 of each field's range. A smallest or largest value
    follows the fields by a factor of a few.
    """
    numbers = []
    for summary, results in runs:
        tilt = np.ptp(results.series("bodies.rocking_angle").values)
        design = measures(check_case(results.case, PATH), results).design
        numbers.append(summary | design | {"tilt": tilt})
    more, one = numbers
    assert one["periodic"] and more["periods"] > one["periods"]
    for name in (
        *("minimum_film_thickness_m", "maximum_pressure_pa", "mean_friction_power_w"),
        *("lateral_displacement_min_m", "lateral_displacement_max_m", "slap_energy_j", "tilt"),
    ):
        print(name, more[name] / one[name] - 1)
        assert more[name] == pytest.approx(one[name], rel=0.01), name


@pytest.mark.slow
def test_flexible_bodies_on_the_oil_that_there_is(tmp_path):
    """Motion and oil together: as 20 plain cycles, which then repeat to 1e-8, in fewer."""
    oil = [
        ("participants.ehd.parameters.oil_supply", "bore_and_ring"),
        ("participants.ehd.parameters.oil_ring_layer", "20 um"),
        ("participants.ehd.parameters.initial_oil_layer", "20 um"),
        ("participants.ehd.parameters.oil_splash", "1 mm/s"),
    ]
    case = {"path": find_case("numerical_example"), "grid": (14, 12), "step": "3 deg"}
    until = ("time.until_periodic", TOLERANCE), ("time.stop", f"{40 * 720 - 360} deg")
    forty = ("time.until_periodic", 0), ("time.stop", f"{20 * 720} deg")
    _, plain = through(tmp_path, "plain", *oil, *forty, **case)
    summary, periodic = through(tmp_path, "periodic", *oil, *until, **case)
    assert summary["periodic"]
    assert summary["periods"] < 40
    for port in PORTS[:-1]:
        ours = periodic.series(f"bodies.{port}").values
        values = plain.series(f"bodies.{port}").values
        last, before = values[-len(ours) :], values[1 - 2 * len(ours) : 1 - len(ours)]
        for other, allowed in ((before, 1e-6), (ours, TOLERANCE)):
            assert np.sqrt(np.mean((other - last) ** 2)) <= allowed * np.ptp(last)
