"""What a run reports: logs, wall time by part, work across the interface, tables."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fmpy.util import read_csv

import piston_cosim as pc
from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.commands.app import app
from piston_cosim.master.coupling.stepping import Counters
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.logs import CouplingLog

from .runs import EXAMPLE, run_tree, small_tree

PATH, HOME = find_case("two_mass_oscillator"), Path(__file__).parent


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    tree = read_tree(PATH, [("time.stop", "0.1 s"), ("coupling.predictor", 0)])
    return folder, run_tree(PATH, tree, folder / "base.h5").summary


def table(path):
    head, *lines = path.read_text().splitlines()
    return [dict(zip(head.split(), line.split())) for line in lines]


def test_logs_account_for_every_iteration(finished):
    folder, summary = finished
    windows = table(folder / "base-iterations.log")
    evaluations = table(folder / "base-convergence.log")
    assert [int(w["Window"]) for w in windows] == list(range(1, 11))
    assert int(windows[-1]["TotalIterations"]) == len(evaluations)
    assert len(evaluations) == summary["residual_evaluations"]
    wires = list(evaluations[0])[2:]
    assert wires == [
        "right.other_displacement",
        "left.other_displacement",
        "right.der(other_displacement)",
        "left.der(other_displacement)",
    ]
    last = {s["Window"]: max(float(s[w]) for w in wires) for s in evaluations}
    assert max(last.values()) <= 1.0  # the last evaluation of each window has converged
    # and no evaluation before it
    assert sum(max(float(s[w]) for w in wires) <= 1.0 for s in evaluations) == len(windows)


def test_wall_time_is_split_without_a_rest(finished):
    _, summary = finished
    names = ("left", "right", "transport", "recording", "acceleration")
    parts = {key: value for key, value in summary.items() if key.startswith("wall_time_")}
    del parts["wall_time_s"]
    assert set(parts) == {f"wall_time_{name}_s" for name in names}
    assert all(value > 0 for value in parts.values())
    assert sum(parts.values()) == pytest.approx(summary["wall_time_s"], rel=1e-12)


def test_scalars_as_structured_array_and_csv(finished, tmp_path):
    folder, _ = finished
    results = Results(folder / "base.h5")
    records = results.structured()
    assert records.dtype.names[0] == "time" and records.size == 11
    np.testing.assert_array_equal(
        records["left.displacement"], results.series("left.displacement")[0]
    )
    with pytest.raises(SystemExit) as done:
        app(["results", "scalars", str(folder / "base.h5"), "--output", str(tmp_path / "run.csv")])
    assert not done.value.code
    read = read_csv(tmp_path / "run.csv")
    assert read.dtype.names == records.dtype.names
    np.testing.assert_array_equal(read["right.velocity"], records["right.velocity"])


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_work_balance_is_as_good_as_the_tolerance(tolerance, tmp_path):
    """A mass on a spring, in two FMUs."""
    parts = {name: f"{HOME}/mass_and_spring.py:{name.title()}" for name in ("mass", "spring")}
    ports = ("mass.displacement", "spring.displacement"), ("spring.force", "mass.force")
    wires = [{"from": one, "to": other, "tolerance": tolerance} for one, other in ports]
    wires[0]["conjugate"] = "spring.force"
    times = {"stop": "0.5 s", "step": "0.005 s"}
    case = pc.couple(parts, wires, method="constant", max_iterations=100, **times)
    results = case.run(tmp_path / "base.h5")
    summary = results.summary
    displacement, force = (
        results.series(port)[0] for port in ("mass.displacement", "spring.force")
    )
    # the right-hand sum of what was recorded; its parts agree to the tolerance of force (nominal 1
    # N) and displacement
    assert summary["interface_work_j"] == pytest.approx(
        np.sum(force[1:] * np.diff(displacement)), abs=100 * tolerance
    )
    assert 0 < abs(summary["interface_work_imbalance"]) <= tolerance


def test_a_conjugate_that_is_none_is_named():
    tree = read_tree(
        PATH, [("wires.0.conjugate", "left.velocity"), ("wires.1.conjugate", "left.displacement")]
    )
    with pytest.raises(BadInput) as refusal:
        open_system(check_case(tree, PATH), PATH.parent, print)
    assert "expected a wire of this shape to left, got none" in refusal.value.faults[0]
    assert "expected a product of work or power, got unit" in refusal.value.faults[1]


def test_a_log_goes_on_after_its_checkpoint(tmp_path):
    """Windows written after the checkpoint go, and a line that a crash has cut off."""
    wires = (SimpleNamespace(target=("right", "x")), SimpleNamespace(target=("left", "y")))
    log = CouplingLog(tmp_path / "a.h5", wires, Counters())
    for k in range(12):
        log.attempt(0.1 * k, 0.1, [[2.0, 3.0], [0.5, 0.1]], None)
    log.close()
    with open(tmp_path / "a-iterations.log", "a") as file:
        file.write("     1")
    log = CouplingLog(tmp_path / "a.h5", wires, Counters(steps=10, residual_evaluations=20))
    log.attempt(1.0, 0.1, [[1.5, 0.2]], RuntimeError("refused"))
    log.attempt(1.0, 0.05, [[0.5, 0.2]], None)
    log.close()
    rows = table(tmp_path / "a-iterations.log")
    assert [row["Window"] for row in rows] == [str(k) for k in range(1, 11)] + ["11", "11"]
    assert [row["Converged"] for row in rows[-2:]] == ["0", "1"]
    assert rows[-1]["TotalIterations"] == "22"
    assert len(table(tmp_path / "a-convergence.log")) == 22


def test_growth_of_a_warming_piston_is_no_spurious_energy(tmp_path):
    """The work of the film on the growing skirt is part of the energy that the bodies receive.

    3 K/ms close the film. That energy equals the work over the wires to a thousandth of the part
    that comes from growth.
    """
    (tmp_path / "warm.csv").write_text("time [s], warm [K]\n0, 293.15\n0.01, 323.15\n")
    tree = small_tree(("time.stop", "20 deg"))
    tree = {key: tree[key] for key in ("title", "time", "participants", "wires", "coupling")}
    tree["participants"]["warm"] = {"table": str(tmp_path / "warm.csv")}
    tree["wires"].append({"from": "warm.warm", "to": "bodies.piston_temperature"})
    tree["coupling"]["order"] = ["warm", "ehd", "bodies"]
    results = run_tree(EXAMPLE, tree, tmp_path / "o.h5")
    summary = results.summary
    opening = results.series("bodies.thermal_opening").values
    sides = [results.series(f"ehd.radial_force_{s}_side").values for s in ("thrust", "anti_thrust")]
    grown = float(np.sum(sum(sides)[1:] * np.diff(opening)))
    assert opening[-1] < -0.5e-6 and grown < -1e-3
    off = summary["energy_taken_bodies_j"] - summary["interface_work_j"]
    assert abs(off) < 1e-3 * abs(grown)
    assert abs(summary["energy_created_share_max"]) < 0.01
