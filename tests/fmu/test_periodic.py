"""A fired engine until its cycle repeats, beside plain cycles."""

import numpy as np
import pytest

from piston_cosim.master.case.schema import check_case, find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

PATH = find_case("data_sheet")
PLAIN = 6
TOLERANCE = 1e-3
PORTS = ("lateral_displacement", "rocking_angle", "side_force", "crank_angle")


def through(folder, name, *changes):
    """Summary and results of a run on 12 x 8 cells in steps of 6 deg."""
    grid = [12, 8]
    usual = [
        ("participants.bodies.build.grid", grid),
        ("participants.ehd.build.grid", grid),
        ("time.step", "6 deg"),
        ("record.fields", []),
    ]
    tree = read_tree(PATH, [*usual, *changes])
    case = check_case(tree, PATH)
    output = folder / f"{name}.h5"
    summary = run(open_system(case, PATH.parent, lambda text: None), case, tree, output)
    return summary, Results(output)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("cycles")
    plain = through(folder, "plain", ("time.stop", f"{PLAIN * 720} deg"))
    return plain, through(folder, "periodic", ("time.until_periodic", TOLERANCE))


def test_equal_to_plain_cycles_in_fewer(runs):
    """Each cycle is nearer by a factor: what is left of the way is less than the last one's."""
    (_, plain), (summary, periodic) = runs
    assert summary["periodic"]
    assert summary["cycle_distance"] <= TOLERANCE
    assert summary["cycles"] < PLAIN
    for port in PORTS[:-1]:
        ours = periodic.series(f"bodies.{port}").values
        last = plain.series(f"bodies.{port}").values[-len(ours) :]
        # 120 macro steps in both; rms over the cycle
        apart = np.sqrt(np.mean((ours - last) ** 2)) / np.ptp(last)
        assert apart <= 2 * TOLERANCE


def test_results_are_on_one_cycle(runs):
    """The case starts at -360 deg: -360 to 360 deg, whatever the number of the cycle."""
    _, (_, periodic) = runs
    angle = np.degrees(periodic.series("bodies.crank_angle").values)
    assert angle == pytest.approx(np.linspace(-360, 360, 121), abs=1e-6)
    assert periodic.time == pytest.approx(np.radians(angle + 360) / (1680 * np.pi / 30), abs=1e-9)
