"""A fired engine until its cycle repeats, and in plain cycles; a layer of oil until it stays."""

import json

import numpy as np
import pytest

from piston_cosim.fmu_ehd.build import prepare
from piston_cosim.fmu_ehd.slave import Ehd
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.engine.headlines import measures
from piston_cosim.master.participants.local import LocalParticipant
from piston_cosim.master.runs.extrapolation import Extrapolation
from piston_cosim.tests.verification.cases.motored import DEGREE, motored_film

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
    folder = tmp_path_factory.mktemp("cycles")
    plain = through(folder, "plain", ("time.stop", f"{PLAIN * 720} deg"))
    return plain, through(folder, "periodic", *UNTIL)


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


def test_results_are_on_one_cycle(runs):
    """The case starts at -360 deg: -360 to 360 deg, whatever the number of the cycle; rows between
    are of steps halved at an impact.
    """
    _, (_, periodic) = runs
    angle = np.degrees(periodic.series("bodies.crank_angle").values)
    whole = np.linspace(-360, 360, 121)
    assert angle[np.abs(angle[:, None] - whole).argmin(axis=0)] == pytest.approx(whole, abs=1e-6)
    assert np.diff(angle).min() > 0.0 and len(angle) < 130
    assert periodic.time == pytest.approx(np.radians(angle + 360) / (1680 * np.pi / 30), abs=1e-9)


def test_another_period_changes_the_numbers_by_less_than_a_hundredth(tmp_path):
    """What is left to go is a share of the last change, which the tolerance keeps to 1e-3 of each
    field's range; a smallest or largest value follows the fields by a factor of a few.
    """
    summaries = []
    for least in (2, None):
        more = () if least else (("time.least_periods", summaries[0]["periods"] + 1),)
        case = {"path": find_case("numerical_example"), "grid": (16, 12), "step": "3 deg"}
        rigid = [(f"participants.bodies.build.{body}.modes", 0) for body in ("piston", "block")]
        summary, results = through(tmp_path, f"least{least}", *rigid, *more, **case)
        with results:
            tilt = results.series("bodies.rocking_angle").values
            described = check_case(results.case, find_case("numerical_example"))
            measured = measures(described, results.path)
            summaries.append(summary | measured | {"tilt": np.ptp(tilt)})
    one, other = summaries
    assert one["periodic"] and other["periods"] > one["periods"]
    for name in (
        *("minimum_film_thickness_m", "maximum_pressure_pa", "mean_friction_power_w"),
        *("lateral_displacement_min_m", "lateral_displacement_max_m", "slap_energy_j", "tilt"),
    ):
        assert other[name] == pytest.approx(one[name], rel=0.01), name


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
    until = ("time.until_periodic", TOLERANCE), ("time.most_periods", 40)
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


STEP = 6 * DEGREE
CYCLES = 12


def motored(folder, extrapolation=None):
    """Oil outside the film after each cycle of a skirt that slides and leans in a given way, on a
    layer of 5 um [m3], and by how much it changes within the last one.
    """
    options, _ = prepare({"grid": [8, 8]}, folder, print)
    (folder / "build.json").write_text(json.dumps(options))
    film = LocalParticipant("film", Ehd(instance_name="film", resources=str(folder)))
    for name, value in OIL.items():
        film.set(name, value)
    thickness, velocity = motored_film((8, 8), 0.0)
    film.start({"film_thickness": thickness, "sliding_velocity": velocity}, 0.0, 1.0)
    oil = []
    course = []
    for cycle in range(CYCLES):
        if extrapolation:
            extrapolation.begin({"film": film})
        course = []
        for k in range(60):
            thickness, velocity = motored_film((8, 8), (k + 1) % 60 * STEP)
            film.set("film_thickness", thickness)
            film.set("sliding_velocity", velocity)
            film.step((60 * cycle + k) * STEP, STEP)
            course.append(film.get("oil_on_bore"))
        oil.append(course[-1])
        if extrapolation:
            extrapolation.end({"film": film})
            extrapolation.proceed({"film": film})
    return np.array(oil), np.ptp(course)


OIL = {
    "oil_supply": "bore_and_ring",
    "initial_oil_layer": 5e-6,
    "oil_ring_layer": 2e-6,
    "initial_film_fraction": 0.3,
}


def test_oil_on_the_bore_is_extrapolated_to_where_it_stays(tmp_path):
    """What the skirt wears down by a hundredth a cycle is gone after a few: plainly the oil falls
    on and on by as much in each cycle.
    """
    plain, extent = motored(tmp_path)
    assert abs(plain[-1] - plain[-2]) > 3e-3 * extent
    slow = Extrapolation()
    oil, extent = motored(tmp_path, slow)
    assert slow.made > 2
    # the tolerance that is usual for a cycle
    assert np.abs(np.diff(oil[-3:])).max() <= 1e-3 * extent
