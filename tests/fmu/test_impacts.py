"""Energy that a piston loses in impacts, recomputed from recorded velocities and the data sheet."""

import numpy as np
import pytest

from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.engine.impacts import impacts

from .runs import run_tree

MASS, CENTRE, INERTIA = 1.39, 0.0265, 0.003
EDGES = {"lower": -0.0455, "upper": 0.0373}
"""Piston of the data sheet: [kg], [m] above the pin's axis, [kg m2], [m] above the pin's axis."""


@pytest.mark.parametrize(
    "name", ["data_sheet", "floating_pin", pytest.param("crank_bearings", marks=pytest.mark.slow)]
)
def test_energy_lost_is_the_drop_of_the_pistons_own_energy(name, tmp_path):
    """Pin, rod and crank do not count. The tolerance of 5 % is the one asked for."""
    path = find_case(name)
    changes = [("time.stop", "400 deg"), ("time.step", "5 deg"), ("record.fields", [])]
    tree = read_tree(path, changes)
    with run_tree(path, tree, tmp_path / "run.h5") as results:
        found = impacts(results, "bodies")
        speed, rocking = (
            results.series(f"bodies.{port}").values
            for port in ("lateral_velocity", "rocking_velocity")
        )
    energy = (MASS * (speed - CENTRE * rocking) ** 2 + INERTIA * rocking**2) / 2
    assert found and max(impact.loss for impact in found) > 1e-4
    for impact, end in zip(found, [*(one.row for one in found[1:]), None]):
        lowest = impact.row + energy[impact.row : end].argmin()
        assert impact.loss == pytest.approx(energy[impact.row] - energy[lowest], rel=0.05)
        edges = {
            edge: speed[impact.row] - height * rocking[impact.row] for edge, height in EDGES.items()
        }
        assert impact.edge == max(edges, key=lambda edge: abs(edges[edge]))
        assert impact.velocity == pytest.approx(edges[impact.edge], rel=1e-9)
        assert np.sign(impact.velocity) == (1 if impact.side == "thrust" else -1)
