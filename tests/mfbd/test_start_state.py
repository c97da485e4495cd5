"""The file of a start: what it holds, and what is refused."""

import json

import numpy as np
import pytest

from piston_cosim.fmu_mfbd.dynamics.start_state import FIELDS, SCALARS, check_start, read_start

WHOLE = dict.fromkeys(SCALARS, 0.25) | dict.fromkeys(FIELDS, [1.0, 2.0]) | {"film": [[3.0]]}


@pytest.fixture
def write(tmp_path):
    def at(content):
        path = tmp_path / "start.json"
        path.write_text(content if isinstance(content, str) else json.dumps(content))
        return path

    return at


@pytest.mark.parametrize(
    "angle, reduced",
    [
        (0.25, 0.25),
        (8 * np.pi + 0.5, 0.5),
        (6 * np.pi, -2 * np.pi),
        (-2 * np.pi, -2 * np.pi),
        (3 * np.pi, -np.pi),
    ],
)
def test_whole_cycles_are_left_out(write, angle, reduced):
    start = read_start(write(WHOLE | {"crank_angle": angle}))
    assert start.crank_angle == pytest.approx(reduced)
    wanted = [0.25, 0.25, 1.0, 1.0, 2.0, 2.0]  # the first of two bearings before the modes
    np.testing.assert_array_equal(start.position(1), wanted)
    np.testing.assert_array_equal(start.velocity(1), wanted)


@pytest.mark.parametrize(
    "content, message",
    [
        ("no json", "start: expected a JSON table of outputs in start.json, got other content"),
        ("[1]", "start: expected a JSON table of outputs in start.json, got other content"),
        (
            {k: v for k, v in WHOLE.items() if k not in ("rocking_angle", "lateral_velocity")},
            "start: expected rocking_angle, lateral_velocity in start.json, got nothing",
        ),
        (WHOLE | {"crank_angle": "up"}, "start: expected numbers in start.json, got other values"),
    ],
)
def test_what_is_wrong_is_named(write, content, message):
    with pytest.raises(ValueError, match=message):
        read_start(write(content))


def test_other_bodies_are_refused(write):
    check_start(read_start(write(WHOLE)), 2, 2)
    with pytest.raises(
        ValueError, match="start: expected 3 values of modal_coordinate, one per mode, got 2"
    ):
        check_start(read_start(write(WHOLE)), 3, 2)
