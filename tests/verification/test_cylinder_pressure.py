"""Cycles of measured cylinder pressure."""

import os
from pathlib import Path

import numpy as np
import pytest

from piston_cosim.models.measured.cylinder_pressure import study

TRACES = os.environ.get("PISTON_COSIM_TRACES")


def test_a_trace_is_kept_and_its_cycle_completed():
    """Constant before it; after it 5 bar more than at its start, which fall by 1/e in 20 deg."""
    angle = np.arange(-140.0, 121.0)
    trace = 2e5 + 5e5 * (angle + 140.0) / 260.0
    found = dict(zip(study.DEGREES, study.cycle(angle, trace) - 1e5))
    assert found[-360.0] == found[-140.0] == 0.0
    assert found[-10.0] == pytest.approx(2.5e5)
    assert found[120.0] == pytest.approx(5e5)
    assert found[140.0] == pytest.approx(5e5 / np.e)
    assert found[360.0] == pytest.approx(0.0, abs=5e5 * np.exp(-11.9))


@pytest.mark.skipif(not TRACES, reason="PISTON_COSIM_TRACES names no folder of traces")
@pytest.mark.parametrize(
    "name, highest, where",
    [
        ("pExpA25", 12.653, 6),
        ("pExpA50", 18.347, 8),
        ("pExpA75", 23.044, 10),
        ("pExpA100", 23.321, 10),
    ],
)
def test_measured_traces_have_their_highest_pressure(name, highest, where, tmp_path):
    file = study.gas_file(Path(str(TRACES), name), tmp_path)
    angle, pressure = np.loadtxt(file, delimiter=",", skiprows=1, unpack=True)
    k = pressure.argmax()
    assert pressure[k] * 1e-6 == pytest.approx(highest - 0.1, abs=1e-3)
    assert angle[k] == where
