import json
from pathlib import Path

import numpy as np
import pytest

from fmu_ehd.build import prepare
from fmu_ehd.slave import Ehd
from master.fmi.errors import BadInput


@pytest.fixture
def slave(tmp_path):
    """The slave as the FMU's host sees it, on a small grid."""
    options, files = prepare({"grid": [8, 6]}, Path("."), print)
    assert files == []
    (tmp_path / "build.json").write_text(json.dumps(options))
    return Ehd(instance_name="film", resources=str(tmp_path))


def test_every_output_is_declared_and_every_declared_output_is_set(slave):
    slave.exit_initialization_mode()
    assert slave.fault is None
    declared = {v.name for v in slave.table if v.causality == "output"}
    state, outputs = slave.advance(slave.state, slave._values(), 0.0, 1e-4)
    assert set(outputs) == declared
    assert isinstance(state, Ehd.state_type)


def test_diagnostic_fields_can_be_left_out(tmp_path):
    options, _ = prepare({"grid": [8, 6], "no_fields": True}, Path("."), print)
    (tmp_path / "build.json").write_text(json.dumps(options))
    slave = Ehd(instance_name="film", resources=str(tmp_path))
    slave.exit_initialization_mode()
    assert slave.do_step(0.0, 1e-4)
    assert "film_fraction" not in slave.views


def test_restored_state_repeats_the_bytes(slave):
    slave.exit_initialization_mode()
    slave.views["sliding_velocity"][...] = 3.0
    slave.views["film_thickness"][...] = 1e-5 - 3e-6 * np.linspace(0.0, 1.0, 48).reshape(8, 6)
    saved = slave._get_fmu_state()
    assert slave.do_step(0.0, 1e-4)
    first = slave._fmu_state_to_bytes(slave._get_fmu_state())
    slave._set_fmu_state(saved)
    assert slave.do_step(0.0, 1e-4)
    assert slave._fmu_state_to_bytes(slave._get_fmu_state()) == first


def test_range_and_cross_faults_stop_the_start(slave):
    slave.views["pressure_upper_edge"][...] = -1e4
    slave.exit_initialization_mode()
    assert "pressure_upper_edge = -10000 Pa" in slave.fault
    assert not slave.do_step(0.0, 1e-4)


def test_bad_build_options_are_reported_together():
    with pytest.raises(BadInput) as error:
        prepare({"grid": [40, 2], "grit": 1}, Path("."), print)
    assert len(error.value.faults) == 2
