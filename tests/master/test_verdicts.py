"""A run judged: every limit from both sides, on results made by hand."""

import json

import h5py
import numpy as np
import pytest

from piston_cosim.master.case.schema import check_case, find_case, read_tree
from piston_cosim.master.engine.verdicts import verdicts
from piston_cosim.master.results.file import Results

PATH = find_case("data_sheet")
ROUGHNESS = 0.54e-6


def judged(folder, film=5e-6, pressure=3e6, cycles=2, drift=0.0, **summary):
    """what -> verdict on a run of `cycles` cycles in steps of 10 deg, the last cycle of which is
    displaced by `drift` times its range.
    """
    tree = read_tree(PATH)
    angle = np.radians(np.arange(-360, 720 * cycles - 359, 10.0))
    lateral = np.sin(angle / 2) * 1e-5  # its range over a cycle is 2e-5
    lateral += np.where(angle > angle[-1] - 4 * np.pi + 1e-9, drift * 2e-5, 0.0)
    columns = {
        "bodies/crank_angle": (angle, "rad"),
        "bodies/lateral_displacement": (lateral, "m"),
        "ehd/minimum_film_thickness": (np.full(angle.size, film), "m"),
        "ehd/maximum_pressure": (np.full(angle.size, pressure), "Pa"),
    }
    gap = np.full((2, 40, 40), 1e-5)
    gap[1, 30, 9] = film  # cell 31 of 40 has its centre on 270 deg
    with h5py.File(folder / "run.h5", "w") as file:
        made = {"steps": 10, "unconverged_steps": 0, "interface_work_imbalance": 0.0} | summary
        made["cycles"] = made.pop("cycles_run", 0)
        file.attrs.update({"case": json.dumps(tree), "summary": json.dumps(made)})
        file["time"] = (angle - angle[0]) / 100.0
        file["fields/time"] = file["time"][:2]
        file["fields/bodies/film_thickness"] = gap
        for name, (values, unit) in columns.items():
            file[name] = values
            file[name].attrs.update({"unit": unit, "description": name})
    case = check_case(tree, PATH)
    results = Results(folder / "run.h5")
    found = {one.what: one for one in verdicts(case, results)}
    results.close()
    return found


@pytest.mark.parametrize("periodic, colour", [(True, "green"), (False, "amber")])
def test_a_repeated_cycle_is_judged_by_its_own_distance(tmp_path, periodic, colour):
    found = judged(tmp_path, cycles=1, periodic=periodic, cycles_run=4, cycle_distance=3e-4)
    assert found["periodic"].colour == colour
    assert "after 4 cycles the last is 0.0003 from the one before" in found["periodic"].said


def test_a_sound_run_is_green(tmp_path):
    found = judged(tmp_path)
    assert {one.colour for one in found.values()} == {"green"}
    assert set(found) == {"convergence", "energy", "film", "pressure", "periodic"}


@pytest.mark.parametrize(
    "given, what, colour",
    [
        ({"film": 3.01 * ROUGHNESS}, "film", "green"),
        ({"film": 2.99 * ROUGHNESS}, "film", "amber"),
        ({"film": 0.99 * ROUGHNESS}, "film", "red"),
        ({"pressure": 49e6}, "pressure", "green"),
        ({"pressure": 51e6}, "pressure", "amber"),
        ({"pressure": 101e6}, "pressure", "red"),
        ({"drift": 0.019}, "periodic", "green"),
        ({"drift": 0.03}, "periodic", "amber"),
        ({"drift": 0.2}, "periodic", "red"),
        ({"cycles": 1}, "periodic", "amber"),
        ({"unconverged_steps": 1}, "convergence", "red"),
        ({"interface_work_imbalance": -2e-3}, "energy", "amber"),
        ({"interface_work_imbalance": 0.02}, "energy", "red"),
        ({"interface_work_imbalance": float("nan")}, "energy", "red"),
    ],
)
def test_limits(given, what, colour, tmp_path):
    assert judged(tmp_path, **given)[what].colour == colour


def test_the_worst_place_by_side_angle_and_height(tmp_path):
    said = judged(tmp_path)["film"].said
    # row 10 of 40 has its centre at 9.5/40 of the skirt
    assert "anti-thrust side, angle from the pin axis 270 deg, height 19.7 mm" in said
    assert "9.26 times the roughness" in said  # 5/0.54
