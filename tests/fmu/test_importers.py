"""The importers that are installed here, and a host of plain C, give what `run` writes."""

import numpy as np
import pytest

from piston_cosim.tests.verification.cases import importers
from piston_cosim.tests.verification.cases.importers import (
    ALLOWED,
    FAILED,
    HOST,
    IMPORTERS,
    NOT_INSTALLED,
    WATCHED,
    Trial,
    distance,
    engine,
    in_whole_ticks,
    judged,
    native_engine,
    shipped_run,
    try_importers,
)

from .runs import coarse

STEPS = 24
SMALL = coarse(("time.stop", f"{STEPS} deg"))


@pytest.fixture(scope="module")
def shipped(tmp_path_factory):
    return engine(SMALL, ("2.0", "3.0"), print, tmp_path_factory.mktemp("run"))


@pytest.mark.slow
@pytest.mark.parametrize("native", [False, True])
@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_every_importer_gives_what_run_writes(shipped, version, native):
    """Every importer gives the values that `run` writes, including row 0.

    Importers that are always installed must be among them. A native FMU needs no part of Python.
    """
    reference, fmus, step = shipped
    assert reference.shape == (STEPS + 1, 1 + len(WATCHED))
    if native:
        fmus = native_engine(SMALL, (version,), print) or pytest.skip("cannot be built here")
    trials = list(try_importers(fmus[version], version, STEPS, step))
    verdicts = {trial.importer: judged(trial, reference) for trial in trials}
    assert [name for name, (verdict, _) in verdicts.items() if verdict == "FAIL"] == [], verdicts
    here = {HOST, "fmpy in process", "fmpy simulate", "fmpy validate"}
    here |= {"Python alone (ctypes)"} if version == "2.0" else set()
    assert {name for name, (verdict, _) in verdicts.items() if verdict == "ok"} >= here
    assert verdicts.keys() - {HOST} == {n for n, i in IMPORTERS.items() if version in i.versions}


@pytest.mark.slow
def test_a_clock_of_whole_nanoseconds_is_held_against_a_run_in_its_steps(shipped, tmp_path):
    """The run in the case's own steps is further away than importers may be: it is not just any."""
    reference, fmus, step = shipped
    changes, ticked = in_whole_ticks(SMALL, step, 1e-9)
    assert ticked == pytest.approx(27.778e-6, rel=1e-12) and ticked != step
    run = shipped_run(changes, print, tmp_path / "run.h5")
    host, *_ = try_importers(fmus["2.0"], "2.0", STEPS, ticked)
    assert distance(host.seen, run) <= ALLOWED
    run[:, 0] = reference[:, 0]
    assert distance(run, reference) > ALLOWED


@pytest.mark.slow
def test_a_python_without_what_the_fmu_needs_is_not_tried(shipped, monkeypatch):
    monkeypatch.setattr(importers, "PACKAGES", ("numpy", "no_such_package"))
    _, fmus, step = shipped
    host, *trials = try_importers(fmus["2.0"], "2.0", 1, step)
    assert host.importer == HOST
    told = f"{NOT_INSTALLED}: no_such_package, needed in the Python that runs the FMU"
    assert {trial.seen for trial in trials if trial.python != "-"} == {told}


TIMES = np.arange(5) * 1e-5
CURVE = np.array([TIMES, [0.0, 1.0, 4.0, 9.0, 10.0]]).T


def changed(row, column, by):
    """Return the curve with one value changed."""
    curve = CURVE.copy()
    curve[row, column] += by
    return curve


def test_what_differs_or_fails_is_no_success():
    seen = {
        "same": CURVE,
        "near": changed(3, 1, 10 * 0.5 * ALLOWED),
        "off": changed(3, 1, 10 * 2 * ALLOWED),
        "short": CURVE[:2],
        "valid": "no problem",
        "problems": "['x']",
        "died": f"{FAILED} (1): no",
        "absent": f"{NOT_INSTALLED}: pip install it",
        "refused": "refused: run: python -m pip install numpy",
    }
    verdicts = {name: judged(Trial(name, "1", "3", what), CURVE)[0] for name, what in seen.items()}
    ok, left_out = ({n for n, one in verdicts.items() if one == word} for word in ("ok", "-"))
    assert ok == {"same", "near", "valid"} and left_out == {"absent", "refused"}
