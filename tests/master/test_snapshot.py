"""`piston-cosim results snapshot`: a file of outputs from which another run starts."""

import json

import numpy as np
import pytest

from piston_cosim.master.commands.results.snapshot import command
from piston_cosim.master.fmi.errors import BadInput

from .by_hand import write_results


@pytest.fixture
def results(tmp_path):
    """Write a run of four steps with fields at every second step."""
    write_results(
        tmp_path / "run.h5",
        np.arange(4) * 1e-3,
        {"bodies.crank_angle": (np.arange(4) * 0.3, "rad")},
        {"bodies.modal_coordinate": ([[1.0, 2.0], [3.0, 4.0]], "1")},
        [0.0, 2e-3],
        title="run",
        case={"participants": {"bodies": {}, "ehd": {}}},
    ).close()
    return tmp_path / "run.h5"


@pytest.mark.parametrize(
    "time, angle, modal",
    [
        (None, 0.6, [3.0, 4.0]),
        ("0.4 ms", 0.0, [1.0, 2.0]),
        ("0.1 rad", 0.0, [1.0, 2.0]),
        ("20 deg", 0.6, [3.0, 4.0]),  # 0.349 rad, nearer to 0.6 than to 0
    ],
)
def test_scalars_and_fields_of_the_same_instant(results, tmp_path, time, angle, modal):
    output = tmp_path / "start.json"
    command(results, participant="bodies", output=output, time=time)
    assert json.loads(output.read_text()) == {"crank_angle": angle, "modal_coordinate": modal}


def test_a_crank_angle_outside_the_run_is_refused(results, tmp_path):
    with pytest.raises(BadInput, match="time: expected a crank angle of the run, 0"):
        command(results, participant="bodies", output=tmp_path / "start.json", time="90 deg")
