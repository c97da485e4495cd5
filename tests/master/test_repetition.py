"""A cycle repeated until it is periodic, on toys whose distances one can work out.

x = sin(pi t/2) + 10^(-t/4), a cycle of 4 s in steps of 1 s: the second term falls to a tenth in
each. Beginning and end of cycle k differ by 0.9 10^-k.
"""

import json
import os
import signal
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from piston_cosim.master.case.schema import check_case
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.checkpoint import Checkpoint, Interrupted
from piston_cosim.master.runs.repetition import Repetition, repetition
from piston_cosim.master.runs.run import run

TREE = {
    "title": "Toys",
    "time": {"stop": "4 s", "step": "1 s", "until_periodic": "1e-3"},
    "participants": {"plant": {"fmu": "plant.fmu"}, "echo": {"fmu": "echo.fmu"}},
    "wires": [
        {"from": "echo.w0", "to": "plant.u0"},
        {"from": "plant.y0", "to": "echo.v0"},
    ],
    "coupling": {"order": ["plant", "echo"], "method": "constant", "relaxation": 1.0},
    "record": {"fields": ["plant.y0"], "every": 2, "checkpoint_every": 3},
    "summary": {"high": "max echo.w0", "mean": "mean plant.y0", "end": "last echo.w0"},
}


def x(t):
    return np.sin(np.pi * t / 2) + 10 ** (-t / 4)


def distance(cycle):
    """Of cycle 1, 2, ...; the first begins at the toys' start values, 0."""
    values = x(4.0 * (cycle - 1) + np.arange(5.0))
    values[0] *= cycle > 1
    return abs(values[-1] - values[0]) / np.ptp(values)


@pytest.fixture
def toys(affine):
    """Maker of fresh toys, always the same."""
    return lambda: affine([[0.0]], x, 1e-9, stop=4.0)


def go(system, output, tree=TREE, watch=lambda *args: None, **given):
    return run(system, check_case(tree, "case.toml"), tree, output, watch, **given)


def test_cycles_are_run_until_one_repeats_the_one_before(toys, tmp_path):
    """Cycle k is 0.9 10^-(k-1) / 2 away: 4.5e-3, 4.5e-4 for the third and fourth."""
    said = []
    summary = go(toys(), tmp_path / "run.h5", say=said.append)
    assert summary["cycles"] == 4
    assert summary["periodic"] is True
    # round-off of ten digits that cancel
    assert summary["cycle_distance"] == pytest.approx(distance(4), rel=1e-9)
    assert summary["steps"] == 16
    cycles = [line for line in said if line.startswith("cycle")]
    assert cycles[2:] == [
        f"cycle 3: its end is {distance(3):.2g} from its beginning (echo.w0), wanted 0.001",
        f"cycle 4: its end is {distance(4):.2g} from its beginning (echo.w0), wanted 0.001",
    ]


def test_results_and_summary_are_of_the_last_cycle(toys, tmp_path):
    summary = go(toys(), tmp_path / "run.h5")
    last = x(12 + np.arange(5.0))
    results = Results(tmp_path / "run.h5")
    assert results.time.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert results.series("echo.w0")[0] == pytest.approx(last, rel=1e-12, abs=1e-12)
    assert results.file["fields/time"][:].tolist() == [0.0, 2.0, 4.0]
    results.close()
    assert summary["high"] == pytest.approx(last[1:].max(), rel=1e-12)
    assert summary["mean"] == pytest.approx(last[1:].mean(), rel=1e-9)
    assert summary["end"] == pytest.approx(last[-1], rel=1e-9)


def test_a_run_that_does_not_become_periodic_says_so(toys, tmp_path):
    tree = TREE | {"time": TREE["time"] | {"most_cycles": 2}}
    said = []
    summary = go(toys(), tmp_path / "run.h5", tree, say=said.append)
    assert (summary["cycles"], summary["periodic"]) == (2, False)
    assert said[-1].endswith(
        "not periodic after 2 cycles (time.most_cycles): still coming nearer, "
        f"echo.w0 {distance(2):.2g}, plant.y0 {distance(2):.2g} would need more cycles"
    )


def test_a_run_whose_cycles_do_not_come_nearer_says_what_does_not_repeat(affine, tmp_path):
    """sin(pi t/2) + sin(t): a cycle of 4 s begins and ends at unlike points of the second sine, by
    2 |sin 2 cos(4 k - 2)| in cycle k; of the first seven the fourth is the nearest.
    """

    def wandering(t):
        return np.sin(np.pi * t / 2) + np.sin(t)

    tree = TREE | {"time": TREE["time"] | {"most_cycles": 7}}
    said = []
    system = affine([[0.0]], wandering, 1e-9, stop=4.0)
    summary = go(system, tmp_path / "run.h5", tree, say=said.append)
    distances = []
    for k in range(7):
        values = wandering(4.0 * k + np.arange(5.0))
        distances.append(abs(values[-1] - values[0]) / np.ptp(values))
    nearest = int(np.argmin(distances))
    assert nearest == 3
    assert summary["cycle_distance_least"] == pytest.approx(distances[nearest], rel=1e-9)
    assert f"no nearer for 3 cycles than {distances[nearest]:.2g}" in said[-1]
    assert "no nearer" not in said[nearest + 2]
    assert "the distances have stopped falling, echo.w0" in said[-1]


@pytest.mark.parametrize("instant", [3.0, 4.0, 5.0, 10.0])
def test_an_interrupted_run_goes_on_in_its_cycle(toys, tmp_path, instant):
    """At 4 s a cycle ends: what was asked for then is done after the first step of the next."""

    def interrupt(time, *others):
        if time == instant:
            os.kill(os.getpid(), signal.SIGINT)

    whole = go(toys(), tmp_path / "whole.h5")
    output = tmp_path / "run.h5"
    with pytest.raises(Interrupted):
        go(toys(), output, watch=interrupt)
    resumed = go(toys(), output, begin_at=Checkpoint.read(Checkpoint.path(output)))
    same_results(tmp_path / "whole.h5", output)
    for key in ("cycles", "cycle_distance", "steps", "mean", "high"):
        assert resumed[key] == whole[key]


@pytest.mark.parametrize("instant", [5.0, 6.0, 9.0])
def test_a_run_that_is_killed_goes_on_from_the_beginning_of_the_cycle(toys, tmp_path, instant):
    """A checkpoint is written between two cycles: rows of an older one have gone by then."""

    def fall(time, *others):
        if time == instant:
            raise KeyboardInterrupt

    whole = go(toys(), tmp_path / "whole.h5")
    output = tmp_path / "run.h5"
    with pytest.raises(KeyboardInterrupt):
        go(toys(), output, watch=fall)
    resumed = go(toys(), output, begin_at=Checkpoint.read(Checkpoint.path(output)))
    same_results(tmp_path / "whole.h5", output)
    assert resumed["cycle_distance"] == whole["cycle_distance"]


def same_results(one, other):
    with h5py.File(one, "r") as first, h5py.File(other, "r") as second:
        for name in ("time", "echo/w0", "plant/y0", "fields/plant/y0", "coupling/iterations"):
            assert first[name][:].tolist() == second[name][:].tolist()


def standing(**values):
    """A participant `a` with these outputs."""
    values = {name: np.array(value, dtype=float) for name, value in values.items()}
    return {"a": SimpleNamespace(get=values.get)}


def test_distance_by_hand():
    """Eq. (Y2): cells 0 and 3 end at 0.3 and 3.4, rms change sqrt((0.09 + 0.16)/2); in between they
    were at 2 and -1, ranges 2 and 4.4; s ends at 1 where it began, t moves by all of its range
    10. A field that stands still counts nothing.
    """
    ports = [("a", "f"), ("a", "s"), ("a", "still")]
    one = Repetition(ports, [], 0.5, 9)
    one.begin(standing(f=[0.0, 3.0], s=1.0, still=5.0))
    one.note(standing(f=[2.0, -1.0], s=3.0, still=5.0))
    one.note(standing(f=[0.3, 3.4], s=1.0, still=5.0))
    expected = np.sqrt(0.125) / np.sqrt((2.0**2 + 4.4**2) / 2)
    assert one.end(standing(f=[0.3, 3.4], s=1.0, still=5.0)) == pytest.approx(expected, rel=1e-12)
    assert one.furthest == ("a", "f")
    assert one.is_periodic


def test_what_turns_is_counted_from_the_beginning_of_its_cycle():
    """An angle from -6 on that grows by 12 a cycle; what is not named stays."""
    one = Repetition([("a", "s")], [("a", "angle")], 0.5, 9)
    one.begin(standing(angle=-6.0, s=0.0))
    assert one.turned(("a", "angle")) == 0.0
    one.end(standing(angle=6.0, s=0.0))
    one.begin(standing(angle=6.0, s=0.0))
    assert one.turned(("a", "angle")) == 12.0
    assert one.turned(("a", "s")) == 0.0


def test_a_case_with_nothing_to_compare_is_refused(toys):
    tree = TREE | {"wires": []}
    system = toys()
    bare = SimpleNamespace(wires=(), participants=system.participants)
    with pytest.raises(BadInput, match="time.until_periodic: nothing tells"):
        repetition(check_case(tree, "case.toml"), tree, bare)


@pytest.mark.parametrize(
    "entries, fault",
    [
        ({"until_periodic": "0"}, "time.until_periodic: Input should be greater than 0"),
        ({"until_periodic": "1"}, "time.until_periodic: Input should be less than 1"),
        ({"until_periodic": "1e-3 m"}, "time.until_periodic: Input should be a valid number"),
        ({"most_cycles": 1}, "time.most_cycles: Input should be greater than or equal to 2"),
    ],
)
def test_refused_values(entries, fault):
    with pytest.raises(BadInput, match=fault):
        check_case(TREE | {"time": TREE["time"] | entries}, "case.toml")


def test_plain_runs_say_nothing_of_cycles(toys, tmp_path):
    tree = json.loads(json.dumps(TREE))
    del tree["time"]["until_periodic"]
    assert "cycles" not in go(toys(), tmp_path / "run.h5", tree)
