"""What a run reports: logs that continue, tables of scalars, energy of a warming piston."""

from types import SimpleNamespace

import numpy as np
import pytest
from fmpy.util import read_csv

from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.commands.app import app
from piston_cosim.master.coupling.stepping import Counters
from piston_cosim.master.runs.logs import CouplingLog

from .runs import EXAMPLE, run_tree, small_tree


def table(path):
    head, *lines = path.read_text().splitlines()
    return [dict(zip(head.split(), line.split())) for line in lines]


def test_scalars_as_structured_array_and_csv(tmp_path):
    path = find_case("two_mass_oscillator")
    results = run_tree(path, read_tree(path, [("time.stop", "0.1 s")]), tmp_path / "base.h5")
    records = results.structured()
    assert records.dtype.names[0] == "time" and records.size == 11
    np.testing.assert_array_equal(
        records["left.displacement"], results.series("left.displacement")[0]
    )
    with pytest.raises(SystemExit) as done:
        app(
            ["results", "scalars", str(tmp_path / "base.h5"), "--output", str(tmp_path / "run.csv")]
        )
    assert not done.value.code
    read = read_csv(tmp_path / "run.csv")
    assert read.dtype.names == records.dtype.names
    np.testing.assert_array_equal(read["right.velocity"], records["right.velocity"])


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
