"""Scores against curves whose amplitude, phase and distance are known."""

import numpy as np
import pytest

from piston_cosim.master.commands.results.compare import print_scores
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.compare import Row, Score, read_measured

X = np.linspace(0.0, 4 * np.pi, 721)


def test_measured_file_names_ports_and_units(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text("a.angle [deg], a.shift [um]\n0, 1\n10, 3\n")
    measured = read_measured(path)
    assert measured["a.shift"][0].tolist() == [1.0, 3.0] and measured["a.shift"][1] == "um"
    path.write_text("angle, a.shift [um], what\n0, 1, 2\n")
    with pytest.raises(BadInput) as caught:
        read_measured(path)
    assert len(caught.value.faults) == 2


@pytest.mark.parametrize("unit, told", [("rad", "phase [deg]"), ("s", "phase [s]")])
def test_the_phase_has_a_unit(unit, told, capsys):
    """A radian is 57.3 deg."""
    print_scores([Row("run", "a.y", Score(1.0, 0.0, 1.0))], unit)
    printed = capsys.readouterr().out
    assert told in printed and ("+57.3" if unit == "rad" else "+1") in printed
