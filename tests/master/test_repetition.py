"""Periods run until one repeats the one before, on toys whose distances one can work out.

x = sin(pi t/2) + 10^(-t/4), a period of 4 s in steps of 1 s: the second term falls to a tenth in
each. Beginning and end of period k differ by 0.9 10^-k.
"""

from copy import copy
from functools import partial
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs import run as run_module
from piston_cosim.master.runs.checkpoint import Interrupted
from piston_cosim.master.runs.envelopes import Envelopes
from piston_cosim.master.runs.repetition import Repetition, repetition

from . import toys as toy
from .toys import TOYS, at, contents, fall

TREE = TOYS | {
    "time": {"period": "4 s", "step": "1 s", "until_periodic": "1e-3"},
    "record": {"fields": ["plant.y0"], "every": 2, "checkpoint_every": 3},
    "summary": {"high": "max echo.w0", "mean": "mean plant.y0", "end": "last echo.w0"},
}
go = partial(toy.go, tree=TREE)
go_on = partial(toy.go_on, tree=TREE)


def x(t):
    return np.sin(np.pi * t / 2) + 10 ** (-t / 4)


def distance(period):
    """Of period 1, 2, ...; the first begins at the toys' start values, 0."""
    values = x(4.0 * (period - 1) + np.arange(5.0))
    values[0] *= period > 1
    return abs(values[-1] - values[0]) / np.ptp(values)


@pytest.fixture
def toys(affine):
    """Maker of fresh toys, always the same."""
    return lambda **given: affine([[0.0]], x, 1e-9, **{"stop": 80.0, "period": 4.0} | given)


def test_periods_are_run_until_one_repeats_the_one_before(toys, tmp_path):
    """Period k is 0.9 10^-(k-1) / 2 away: 4.5e-3, 4.5e-4 for the third and fourth."""
    said = []
    summary = go(toys(), tmp_path / "run.h5", log=said.append)
    assert summary["periods"] == 4
    assert summary["periodic"] is True
    # round-off of ten digits that cancel
    assert summary["period_distance"] == pytest.approx(distance(4), rel=1e-9)
    assert summary["steps"] == 16
    assert [line.partition(";")[0] for line in said] == [
        f"period {k}: relative change {distance(k):.2g} since {before} (echo.w0), tolerance 0.001"
        for k, before in enumerate(["the start", *["the previous period"] * 3], 1)
    ]
    # entries of the summary, of every period
    assert said[1].split("; ")[-1] == f"end {x(8.0):.6g}"
    assert summary["settled"] == (
        f"The relative change between the last two of 4 periods is {distance(4):.2g} "
        "(tolerance 0.001)"
    )


def test_results_and_summary_are_of_the_last_period_and_the_file_holds_all(toys, tmp_path):
    summary = go(toys(), tmp_path / "run.h5")
    last = x(12 + np.arange(5.0))
    with Results(tmp_path / "run.h5") as results:
        assert results.time.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
        assert results.series("echo.w0")[0] == pytest.approx(last, rel=1e-12, abs=1e-12)
        assert results.instants.tolist() == [0.0, 2.0, 4.0]
        fields = results.dataset("plant.y0")
        assert fields[:].tolist() == fields[[0, 1, 2]].tolist() == last[::2].tolist()
        assert fields[-1] == last[-1]
        assert results.field("plant.y0", 2.1).time == 2.0
        assert results.whole.time.tolist() == list(range(17))
        assert results.whole.series("echo.w0")[0][1:] == pytest.approx(x(np.arange(1.0, 17.0)))
        assert len(results.whole.dataset("plant.y0")) == 9
    assert summary["high"] == pytest.approx(last[1:].max(), rel=1e-12)
    assert summary["mean"] == pytest.approx(last[1:].mean(), rel=1e-9)
    assert summary["end"] == pytest.approx(last[-1], rel=1e-9)


def test_a_last_period_without_an_instant_has_no_recorded_fields(toys, tmp_path):
    """The checks of a film would look for the largest pressure among no rows."""
    tree = TREE | {"record": TREE["record"] | {"every": 1000}}
    go(toys(), tmp_path / "run.h5", tree=tree)
    with Results(tmp_path / "run.h5") as results:
        assert results.recorded == []
        assert results.whole.recorded == ["plant.y0"]


def test_a_file_that_has_the_start_alone_can_be_opened(toys, tmp_path):
    go(toys(), tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "r+") as file:
        file["time"].resize(1, 0)
    with Results(tmp_path / "run.h5") as results:
        assert results.time.tolist() == [0.0]


def test_two_periods_can_be_shown_of_at_least_five(toys, tmp_path):
    """Numbers are of the last one all the same."""
    time = TREE["time"] | {"until_periodic": 1e-12, "stop": "20 s"}
    tree = TREE | {"time": time, "record": TREE["record"] | {"periods": 2}}
    summary = go(toys(stop=20.0), tmp_path / "run.h5", tree=tree)
    assert (summary["periods"], summary["steps"]) == (5, 20)
    assert summary["mean"] == pytest.approx(x(np.arange(17.0, 21.0)).mean(), rel=1e-9)
    with Results(tmp_path / "run.h5") as results:
        assert results.time.tolist() == list(range(9))
        assert results.instants.tolist() == [0.0, 2.0, 4.0, 6.0, 8.0]
        assert results.last.time.tolist() == [4.0, 5.0, 6.0, 7.0, 8.0]
        values = results.last.series("echo.w0").values
        assert values == pytest.approx(x(np.arange(16.0, 21.0)), rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("stop, periods", [(4.0, 1), (8.0, 2), (10.0, 2), (3.0, 0)])
def test_a_fixed_stop_says_that_the_run_has_not_settled(toys, tmp_path, stop, periods):
    """The last period ends at the stop time; of 10 s it begins at 6 s. All is shown."""
    tree = TREE | {"time": {"stop": f"{stop} s", "step": "1 s", "period": "4 s"}}
    summary = go(toys(stop=stop), tmp_path / "run.h5", tree=tree)
    assert (summary["periods"], summary["periodic"], summary["steps"]) == (periods, False, stop)
    assert summary["settled"].startswith("Not periodic: ")
    assert summary["settled"].endswith(
        ". Set time.until_periodic = 0.001, and increase or remove time.stop"
    )
    last = np.arange(max(stop - 4.0, 0.0) + 1.0, stop + 1.0)
    assert summary["mean"] == pytest.approx(x(last).mean(), rel=1e-9)
    if stop == 8.0:
        apart = f"the relative change between the last two of 2 periods is {distance(2):.2g}"
        assert apart in summary["settled"]
    with Results(tmp_path / "run.h5") as results:
        assert results.time.tolist() == list(np.arange(stop + 1.0))
        assert results.last.time[1:].tolist() == last.tolist()


def test_a_run_that_does_not_become_periodic_says_so(toys, tmp_path):
    tree = TREE | {"time": TREE["time"] | {"stop": "8 s"}}
    summary = go(toys(stop=8.0), tmp_path / "run.h5", tree=tree)
    assert (summary["periods"], summary["periodic"]) == (2, False)
    assert summary["settled"] == (
        f"Not periodic: the relative change between the last two of 2 periods is {distance(2):.2g} "
        f"(tolerance 0.001). The change still decreases: echo.w0 {distance(2):.2g}, plant.y0 "
        f"{distance(2):.2g}. Set a later time.stop"
    )


def test_a_run_whose_periods_do_not_come_nearer_says_what_does_not_repeat(affine, tmp_path):
    """A run whose periods do not approach each other reports the quantity that does not repeat.

    In sin(pi t/2) + sin(t), a period of 4 s begins and ends at different points of the second sine.
    The change is 2 |sin 2 cos(4 k - 2)| in period k; of the first seven the fourth is the smallest.
    """

    def wandering(t):
        return np.sin(np.pi * t / 2) + np.sin(t)

    tree = TREE | {"time": TREE["time"] | {"stop": "28 s"}}
    said = []
    system = affine([[0.0]], wandering, 1e-9, stop=28.0, period=4.0)
    summary = go(system, tmp_path / "run.h5", tree=tree, log=said.append)
    distances = []
    for k in range(7):
        values = wandering(4.0 * k + np.arange(5.0))
        distances.append(abs(values[-1] - values[0]) / np.ptp(values))
    nearest = int(np.argmin(distances))
    assert nearest == 3
    assert summary["period_distance_least"] == pytest.approx(distances[nearest], rel=1e-9)
    assert f"no decrease for 3 periods, minimum {distances[nearest]:.2g}" in said[-1]
    assert "no decrease" not in said[nearest + 2]
    assert "The change no longer decreases: echo.w0" in summary["settled"]


@pytest.mark.parametrize(
    "instant, how, stopped",
    [
        *((instant, (), Interrupted) for instant in (3.0, 4.0, 5.0, 10.0)),
        *((instant, (fall,), KeyboardInterrupt) for instant in (5.0, 6.0, 9.0)),
    ],
)
def test_a_run_that_ends_early_goes_on_in_its_period(toys, tmp_path, instant, how, stopped):
    """A run that is interrupted continues in its period.

    A period ends at 4 s; an action requested then runs after the first step of the next period.
    A run that is killed continues from its last checkpoint.
    """
    whole = go(toys(), tmp_path / "whole.h5")
    resumed = go_on(toys, tmp_path / "run.h5", at(instant, *how), stopped=stopped)
    assert contents(tmp_path / "whole.h5") == contents(tmp_path / "run.h5")
    for key in ("periods", "period_distance", "steps", "mean", "high"):
        assert resumed[key] == whole[key]


@pytest.fixture
def enveloped(monkeypatch):
    """Set the envelope of all runs to the largest value of plant.y0."""
    kept = Envelopes({"plant.y0": "max"})
    monkeypatch.setattr(run_module, "envelopes", lambda tree, participants: copy(kept))


def largest(path):
    """Return the stored envelope, and the largest value of the file's last period."""
    with Results(path) as results:
        series = results.last.series("plant.y0").values
        return float(results.envelope("plant.y0").values), series.max()


def test_envelopes_are_those_of_the_last_period_also_after_a_resume(enveloped, toys, tmp_path):
    """The largest value falls from period to period, and is between two recorded instants."""
    output = tmp_path / "run.h5"
    go(toys(), tmp_path / "whole.h5")
    go_on(toys, output, at(15.0, fall), stopped=KeyboardInterrupt)
    stored, of_steps = largest(tmp_path / "whole.h5")
    assert largest(output) == (stored, of_steps)
    assert stored == of_steps == x(13.0) < x(9.0)
    with Results(output) as results:
        assert results.last.dataset("plant.y0")[:].max() < stored


def standing(**values):
    """Return a participant `a` with these outputs."""
    values = {name: np.array(value, dtype=float) for name, value in values.items()}
    fields = {name: SimpleNamespace(shape=value.shape) for name, value in values.items()}
    return {"a": SimpleNamespace(get=values.get, fields=fields)}


def test_distance_by_hand():
    """Eq. (Y2): cells that start at 0 and 3 end at 0.3 and 3.4, rms change sqrt((0.09 + 0.16)/2).

    In between they are 2 and -1, so that their ranges are 2 and 4.4.
    `s` ends at 1, where it began. A field that does not change does not count.
    """
    ports = [("a", "f"), ("a", "s"), ("a", "still")]
    one = Repetition(ports, 0.5)
    one.begin(standing(f=[0.0, 3.0], s=1.0, still=5.0))
    one.note(standing(f=[2.0, -1.0], s=3.0, still=5.0))
    one.note(standing(f=[0.3, 3.4], s=1.0, still=5.0))
    expected = np.sqrt(0.125) / np.sqrt((2.0**2 + 4.4**2) / 2)
    assert one.end(standing(f=[0.3, 3.4], s=1.0, still=5.0)) == pytest.approx(expected, rel=1e-12)
    assert one.furthest == ("a", "f")
    assert not one.is_periodic  # a period alone repeats nothing


def test_a_case_with_nothing_to_compare_is_refused(toys):
    tree = TREE | {"wires": []}
    system = toys()
    bare = SimpleNamespace(wires=(), participants=system.participants, period=4.0)
    with pytest.raises(BadInput, match="time.until_periodic: expected a wire"):
        repetition(check_case(tree, "case.toml"), tree, bare)


def test_a_run_until_exactly_periodic_needs_a_stop():
    with pytest.raises(BadInput, match="stop: expected a time or an angle, got"):
        check_case(TREE | {"time": TREE["time"] | {"until_periodic": 0}}, "case.toml")


def test_runs_without_a_period_say_nothing_of_it(toys, tmp_path):
    tree = TREE | {"time": {"stop": "4 s", "step": "1 s"}}
    assert "settled" not in go(toys(stop=4.0, period=0.0), tmp_path / "run.h5", tree=tree)
