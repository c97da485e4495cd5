"""Field exports: what is written is what was recorded."""

import csv
from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.case.shown import NEUTRAL
from piston_cosim.master.commands.results import fields as export
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.fields_export import (
    chosen,
    cylinder_cells,
    read_block,
    write_csv,
)

from .by_hand import write_results

TIMES = np.array([0.0, 0.1, 0.2])
PRESSURE = np.arange(60.0).reshape(3, 5, 4)


@pytest.fixture
def results(tmp_path):
    fields = {
        "ehd.pressure": (PRESSURE, "Pa"),
        "bodies.line": (PRESSURE[:, 0], "m"),
    }
    case = {"participants": {}}
    return write_results(tmp_path / "run.h5", TIMES, fields=fields, instants=TIMES, case=case)


def test_what_cannot_be_written_is_refused(results, tmp_path):
    with pytest.raises(BadInput, match="field: expected one of"):
        read_block(results, "ehd.film")
    with pytest.raises(BadInput, match="expected a field of two indices"):
        read_block(results, "bodies.line")
    whole = read_block(results, "ehd.pressure")
    with pytest.raises(BadInput, match="expected fields on one grid, got ehd.pressure, ehd.press"):
        write_csv([whole, chosen(whole, i=2)], tmp_path / "p.csv")


def test_csv_of_a_line_at_an_instant(results, tmp_path):
    write_csv([chosen(read_block(results, "ehd.pressure"), time=0.12, i=2)], tmp_path / "p.csv")
    with open(tmp_path / "p.csv") as file:
        rows = list(csv.DictReader(file))
    assert [(row["time [s]"], row["i"], row["j"]) for row in rows] == [
        ("0.1", "2", str(j)) for j in range(1, 5)
    ]
    assert [float(row["ehd.pressure [Pa]"]) for row in rows] == PRESSURE[1, 1].tolist()


def test_the_command_prints_the_instant(results, tmp_path, monkeypatch, capsys):
    case = SimpleNamespace(axes_of=lambda port: NEUTRAL)
    monkeypatch.setattr(export, "open_run", lambda file: (case, results))
    export.command(
        tmp_path / "run.h5", field=["ehd.pressure"], output=tmp_path / "p.csv", time="0.12 s"
    )
    assert capsys.readouterr().out.endswith("p.csv   t = 100 ms\n")


def test_a_line_outside_the_grid_is_bad_input(results):
    with pytest.raises(BadInput) as caught:
        chosen(read_block(results, "ehd.pressure"), i=6, j=0)
    assert len(caught.value.faults) == 2


def test_each_cell_of_a_skirt_is_at_its_place():
    """i from +z towards +x, the second cell's centre on +x; j along y."""
    points, cells = cylinder_cells((5, 4), 2.0, (0.0, 8.0))
    centre = points[cells].mean(axis=1).reshape(5, 4, 3)
    assert centre[0, :, 1] == pytest.approx([1.0, 3.0, 5.0, 7.0])
    angle = np.arctan2(centre[:, 0, 0], centre[:, 0, 2]) % (2 * np.pi)
    assert angle == pytest.approx(np.radians([18.0, 90.0, 162.0, 234.0, 306.0]))
