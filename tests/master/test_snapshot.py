"""`piston-cosim results snapshot`: a file of outputs from which another run starts."""

import json

import h5py
import numpy as np
import pytest

from piston_cosim.master.commands.results.snapshot import command
from piston_cosim.master.fmi.errors import BadInput


@pytest.fixture
def results(tmp_path):
    """A run of four steps whose fields were kept at every second."""
    path = tmp_path / "run.h5"
    with h5py.File(path, "w") as file:
        file.attrs.update(
            {"title": "run", "case": json.dumps({"participants": {"bodies": {}, "ehd": {}}})}
        )
        file["time"] = np.arange(4) * 1e-3
        file["bodies/crank_angle"] = np.arange(4) * 0.3
        file["bodies/crank_angle"].attrs.update({"unit": "rad", "description": "Crank angle"})
        file["fields/time"] = np.array([0.0, 2e-3])
        file["fields/bodies/modal_coordinate"] = np.array([[1.0, 2.0], [3.0, 4.0]])
    return path


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


@pytest.mark.parametrize(
    "given, message",
    [
        ({"participant": "engine"}, "unknown participant 'engine'"),
        ({"participant": "bodies", "time": "2 m"}, "time: expected a time, a crank angle or"),
        ({"participant": "bodies", "time": "90 deg"}, "time: expected a crank angle of the run, 0"),
    ],
)
def test_what_is_wrong_is_named(results, tmp_path, given, message):
    with pytest.raises(BadInput, match=message):
        command(results, output=tmp_path / "start.json", **given)
