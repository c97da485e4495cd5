"""Whole runs on toys: results file, logs, summary and checkpoint hold the numbers one can work out.

x = t^2 (1, 2, 3) in steps of 1 s, plainly iterated, tolerance 0.1: the first macro step begins 1, 2
and 3 off and the second 2, 4 and 6, each converged in the second evaluation; then the parabola of
the predictor meets it at once. All numbers are whole, so they are compared as they are.
"""

import json
from dataclasses import replace
from functools import partial

import h5py
import numpy as np
import pytest

from piston_cosim.master.coupling.stepping import StepFailed
from piston_cosim.master.participants.warned import LoggedWarning
from piston_cosim.master.results.file import Results
from piston_cosim.master.results.judgement import mean_over
from piston_cosim.master.runs.checkpoint import Checkpoint, Interrupted
from piston_cosim.master.runs.logs import log_path
from piston_cosim.master.runs.reductions import Reduction

from . import toys as toy
from .toys import TOYS, at, contents, wires

TREE = TOYS | {
    "time": {"stop": "4 s", "step": "1 s"},
    "wires": wires(2),
    "coupling": TOYS["coupling"] | {"advanced": {"halvings": 1}},
    "record": {"fields": ["plant.y0"], "every": 2, "checkpoint_every": 2},
    "summary": {
        "low": "min echo.w1",
        "high": "max echo.w1",
        "mean": "mean plant.y1",
        "end": "last plant.y1",
    },
    "monitor": {"w": "last echo.w1"},
}
WINDOWS = """\
1 0.0 1.0 2 2 1
2 1.0 1.0 2 4 1
3 2.0 1.0 1 5 1
4 3.0 1.0 1 6 1
"""


@pytest.fixture
def toys(affine):
    """Maker of fresh toys, always the same."""

    def make(**given):
        weights = np.array([1.0, 2.0, 3.0])
        return affine(np.zeros((3, 3)), lambda t: t**2 * weights, shapes=((2,), ()), **given)

    return lambda: make(stop=4.0)


go = partial(toy.go, tree=TREE)
go_on = partial(toy.go_on, tree=TREE)


def rows(path):
    """Return a log's rows without its header, with single spaces."""
    return "".join(" ".join(line.split()) + "\n" for line in path.read_text().splitlines()[1:])


def test_results_file(toys, tmp_path):
    go(toys(), tmp_path / "run.h5")
    results = Results(tmp_path / "run.h5")
    assert results.title == "Toys"
    assert results.case == TREE
    assert results.time.tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert sorted(results.ports) == [
        "coupling.derivative_products",
        "coupling.iterations",
        "coupling.residual",
        "echo.w1",
        "plant.y1",
    ]
    values, unit, _ = results.series("echo.w1")
    assert (values.tolist(), unit) == ([0.0, 3.0, 12.0, 27.0, 48.0], "m")
    assert results.series("plant.y1")[1] == "N"
    assert results.series("coupling.iterations")[0].tolist() == [0, 2, 2, 1, 1]
    assert results.series("coupling.residual")[0] == pytest.approx(np.zeros(5), abs=1e-9)
    for asked, instant, field in (
        (0.9, 0.0, [0.0, 0.0]),
        (1.1, 2.0, [4.0, 8.0]),
        (9.0, 4.0, [16.0, 32.0]),
    ):
        values, time, unit, _ = results.field("plant.y0", asked)
        assert (values.tolist(), time, unit) == (field, instant, "N")
    table = results.structured()
    assert table["time"].tolist() == results.time.tolist()
    assert table["plant.y1"][2] == 12.0
    results.close()
    assert not (tmp_path / "run.h5.partial").exists()
    assert not Checkpoint.path(tmp_path / "run.h5").exists()


def test_summary(toys, tmp_path):
    summary = go(toys(), tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5") as file:
        assert json.loads(file.attrs["summary"]) == summary
    expected = {
        "steps": 4,
        "unconverged_steps": 0,
        "halved_steps": 0,
        "mean_iterations": 1.5,
        "max_iterations": 2,
        "residual_evaluations": 6,
        "jacobian_evaluations": 0,
        "derivative_products": 0,
        # over the macro steps 3, 12, 27, 48: the start is no step
        "low": 3.0,
        "high": 48.0,
        "mean": 22.5,
        "end": 48.0,
    }
    assert {key: summary[key] for key in expected} == expected
    shares = [v for k, v in summary.items() if k.startswith("wall_time_") and k != "wall_time_s"]
    # plant, echo, transport, recording and the rest, summed in another order
    assert len(shares) == 5
    assert sum(shares) == pytest.approx(summary["wall_time_s"], rel=1e-12)


def test_logs(toys, tmp_path):
    go(toys(), tmp_path / "run.h5")
    assert rows(log_path(tmp_path / "run.h5", "iterations")) == WINDOWS
    # a wire along the order has no tolerance; a wire's largest element counts
    zeros = "0.0000e+00 0.0000e+00"
    text = (tmp_path / "run-convergence.log").read_text().splitlines()
    assert text[0].split() == ["Window", "Iteration", "plant.u0", "plant.u1", "echo.v0", "echo.v1"]
    assert rows(tmp_path / "run-convergence.log").splitlines()[:4] == [
        f"1 1 2.0000e+01 3.0000e+01 {zeros}",
        f"1 2 {zeros} {zeros}",
        f"2 1 4.0000e+01 6.0000e+01 {zeros}",
        f"2 2 {zeros} {zeros}",
    ]


def test_a_halved_step_is_logged_and_recorded_in_halves(toys, tmp_path):
    system = toys()

    def tire(time, *others):
        """From 3 s on no whole step is taken."""
        system.participants["echo"].longest = 0.6 if time >= 3.0 else np.inf

    summary = go(system, tmp_path / "run.h5", tire)
    assert (summary["halved_steps"], summary["steps"]) == (1, 5)
    # the failed attempt has no evaluation that was measured; afterwards 27 is all that is known
    # of w1
    assert rows(log_path(tmp_path / "run.h5", "iterations")).splitlines()[3:] == [
        "4 3.0 1.0 0 5 0 echo: refused on purpose",
        "4 3.0 0.5 2 7 1",
        "5 3.5 0.5 2 9 1",
    ]
    results = Results(tmp_path / "run.h5")
    assert results.time.tolist() == [0.0, 1.0, 2.0, 3.0, 3.5, 4.0]
    assert results.series("echo.w1")[0].tolist() == [0.0, 3.0, 12.0, 27.0, 36.75, 48.0]
    # every second row, whatever its time
    assert results.file["fields/time"][:].tolist() == [0.0, 2.0, 3.5]
    results.close()


def recording(toys, interval):
    """Toys that are recorded at multiples of so many seconds, and their case."""
    system = replace(toys(), record_interval=interval)
    return system, TREE | {"record": TREE["record"] | {"every": f"{interval} s"}}


def test_halved_steps_do_not_move_instants_that_are_asked_for(toys, tmp_path):
    """Halved steps do not move the requested instants.

    The step to 4 s is halved. Multiples of 2 s stay.
    Steps of 1 s do not meet the multiples of 1.5 s, but halves do.
    The first row after each multiple is recorded, at its own time.
    """
    for interval, instants in ((2.0, [0.0, 2.0, 4.0]), (1.5, [0.0, 2.0, 3.0])):
        system, tree = recording(toys, interval)

        def tire(time, *others, echo=system.participants["echo"]):
            echo.longest = 0.6 if time >= 3.0 else np.inf

        go(system, tmp_path / "run.h5", tire, tree=tree)
        with Results(tmp_path / "run.h5") as results:
            assert results.time.tolist() == [0.0, 1.0, 2.0, 3.0, 3.5, 4.0]
            assert results.instants.tolist() == instants
            assert len(results.dataset("plant.y0")) == len(instants)


def test_a_run_that_goes_on_keeps_what_was_recorded_at_multiples(toys, tmp_path):
    system, tree = recording(toys, 2.0)
    go(system, tmp_path / "whole.h5", tree=tree)
    go_on(lambda: recording(toys, 2.0)[0], tmp_path / "run.h5", at(3.0), tree=tree)
    assert contents(tmp_path / "run.h5") == contents(tmp_path / "whole.h5")


def same_but_for_time(summary, other):
    """Whether two summaries agree in all but seconds."""
    kept = [
        {k: v for k, v in each.items() if not k.startswith("wall_time")}
        for each in (summary, other)
    ]
    return kept[0] == kept[1]


@pytest.mark.parametrize("instant, rows_kept", [(1.0, 2), (2.0, 3), (3.0, 4)])
def test_an_interrupted_run_goes_on_with_the_same_bits(toys, tmp_path, instant, rows_kept):
    whole = go(toys(), tmp_path / "whole.h5")
    output = tmp_path / "run.h5"
    with pytest.raises(Interrupted, match=f"interrupted at t = {instant:g} s; .*resume"):
        go(toys(), output, at(instant))
    assert not output.exists()
    checkpoint = Checkpoint.read(tmp_path / "run.h5.checkpoint")
    assert checkpoint.tree == TREE
    assert checkpoint.account.steps_done == instant
    assert checkpoint.account.rows == rows_kept
    resumed = go(toys(), output, begin_at=checkpoint)
    assert contents(output) == contents(tmp_path / "whole.h5")
    assert same_but_for_time(resumed, whole)
    for kind in ("iterations", "convergence"):
        assert rows(log_path(output, kind)) == rows(log_path(tmp_path / "whole.h5", kind))
    assert not Checkpoint.path(output).exists()


def test_a_failed_run_goes_on_from_the_last_checkpoint(toys, tmp_path):
    go(toys(), tmp_path / "whole.h5")
    output, system = tmp_path / "run.h5", toys()

    def fail():
        system.participants["plant"].longest = 0.1

    with pytest.raises(StepFailed) as failure:
        go(system, output, at(3.0, fail))
    assert "continue from the last checkpoint" in failure.value.__notes__[0]
    checkpoint = Checkpoint.read(Checkpoint.path(output))
    # every second macro step; the third was taken, recorded and logged, and goes
    assert (checkpoint.account.steps_done, checkpoint.account.rows) == (2, 3)
    assert rows(log_path(output, "iterations")).count("\n") == 5
    go(toys(), output, begin_at=checkpoint)
    assert contents(output) == contents(tmp_path / "whole.h5")
    assert rows(log_path(output, "iterations")) == WINDOWS


def test_a_run_says_that_it_replaces_an_interrupted_one(toys, tmp_path):
    output, said = tmp_path / "run.h5", []
    with pytest.raises(Interrupted):
        go(toys(), output, at(2.0), say=said.append)
    assert said == []
    go(toys(), output, say=said.append)
    assert len(said) == 1 and "replaces an interrupted one" in said[0]


def test_no_checkpoint_but_at_a_signal(toys, tmp_path):
    tree = TREE | {"record": TREE["record"] | {"checkpoint_every": 0}}
    seen = []
    path = Checkpoint.path(tmp_path / "run.h5")
    go(toys(), tmp_path / "run.h5", lambda *args: seen.append(path.exists()), tree=tree)
    assert seen == [False] * 4


def test_work_that_explicit_coupling_makes(affine, tmp_path):
    # x = 2 t, one evaluation a step: u lags a step behind v = w. Work the plant's force does on w:
    # 2 x 2 + 4 x 2 + 6 x 2 = 24 J; on u: 2 x 0 + 4 x 2 + 6 x 2 = 20 J
    back, along = TOYS["wires"]
    tree = TOYS | {
        "time": {"stop": "3 s", "step": "1 s"},
        "coupling": {"order": ["plant", "echo"], "method": "explicit", "predictor": 0},
        "wires": [back | {"conjugate": "plant.y0"}, along],
    }
    summary = go(affine([[0.0]], lambda t: 2 * t, stop=3.0), tmp_path / "run.h5", tree=tree)
    assert summary["interface_work_j"] == 24.0
    assert summary["interface_work_imbalance"] == pytest.approx(4 / 24, rel=1e-15)
    assert summary["unconverged_steps"] == 3
    results = Results(tmp_path / "run.h5")
    assert results.series("coupling.residual")[0][1:] == pytest.approx([20.0] * 3, rel=1e-12)
    results.close()


def test_a_participant_that_forgets_is_not_iterated(toys, tmp_path):
    system = toys()
    system.participants["echo"].restore = lambda saved: None
    count = iter(range(99))
    system.participants["echo"].offset = lambda t: float(next(count))
    said = []
    summary = go(system, tmp_path / "run.h5", say=said.append)
    # it counts 0 and 1 plainly, then 3 and 5 for two steps that are taken twice: of 5 at most
    assert said[0].startswith("echo: w0 differs by 4 (80 %) after step 2 ")
    assert "  explicit   plant, echo  (echo cannot restore a saved state)" in said
    assert summary["loops_stepped_explicitly"] == 1


def test_summary_of_steps_by_local_error(affine, tmp_path):
    # x = t^3 up to 7 s, as in test_values_stepping: 1, 2 and a rejected 4 s, then three of 4/3 s
    back, along = TOYS["wires"]
    tree = TOYS | {
        "time": {"stop": "7 s", "step": "7 s", "smallest_step": "1 s"},
        "wires": [back | {"local_error": "7.2 m"}, along],
        "coupling": TREE["coupling"] | {"predictor": 0},
    }
    system = affine(
        [[0.0]], lambda t: t**3, 1e-3, stop=7.0, step=7.0, smallest_step=1.0, local_error=7.2
    )
    summary = go(system, tmp_path / "run.h5", tree=tree)
    assert (summary["steps"], summary["rejected_steps"]) == (5, 1)
    assert summary["inaccurate_smallest_steps"] == 0
    assert summary["residual_evaluations"] == 12


def test_warnings_of_the_start_are_told(toys, tmp_path):
    system = toys()
    texts = ["the tank leaks", "and is hot"]
    system.participants["plant"].warned = lambda: [LoggedWarning(text, None, 1) for text in texts]
    said = []
    go(system, tmp_path / "run.h5", say=said.append)
    assert said[:2] == ["plant: the tank leaks", "plant: and is hot"]


def test_mean_is_over_time():
    # steps of 1, 3 and 0.5 s that end at 2, 4 and 10 N: (2 + 12 + 5) / 4.5
    force = Reduction("mean", "mean plant.y1", 7.0)
    for time, value in ((8.0, 2.0), (11.0, 4.0), (11.5, 10.0)):
        force.add(time, value)
    assert force.result() == pytest.approx(19.0 / 4.5, rel=1e-15)
    time, values = np.array([7.0, 8.0, 11.0, 11.5]), np.array([99.0, 2.0, 4.0, 10.0])
    assert mean_over(time, values) == pytest.approx(19.0 / 4.5, rel=1e-15)
