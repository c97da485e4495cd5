"""Files of measured values."""

import pytest

from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.compare import read_measured


def test_measured_file_names_ports_and_units(tmp_path):
    path = tmp_path / "m.csv"
    path.write_text("a.angle [deg], a.shift [um]\n0, 1\n10, 3\n")
    measured = read_measured(path)
    assert measured["a.shift"][0].tolist() == [1.0, 3.0] and measured["a.shift"][1] == "um"
    path.write_text("angle, a.shift [um], what\n0, 1, 2\n")
    with pytest.raises(BadInput) as caught:
        read_measured(path)
    assert len(caught.value.faults) == 2
