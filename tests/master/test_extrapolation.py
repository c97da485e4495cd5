"""What is slow, extrapolated from cycle to cycle, on a tank whose cycles one can work out.

The tank is at the end of a cycle where `flow` takes the level of its beginning; beside it runs
y = sin(pi t/2), a cycle of 4 s in steps of 1 s.
"""

import zlib

import numpy as np
import pytest

from piston_cosim.master.fmi.state_bytes import join, slow_members, split, with_members
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.extrapolation import MOST_CHANGES, extrapolated

from . import toys
from .toys import TOYS, at

CYCLE = 4


def tree(tolerance=1e-3):
    return TOYS | {"time": {"period": f"{CYCLE} s", "step": "1 s", "until_periodic": tolerance}}


def tank(affine, flow, slow=("level",)):
    """Build a system whose plant is a tank, with states in the layout of the project's FMUs."""
    system = affine([[0.0]], lambda t: 0.0, 1e-9, stop=20.0 * CYCLE, period=float(CYCLE))
    plant = system.participants["plant"]

    def step(time, size):
        now, level = plant.state
        now += size
        if round(now) % CYCLE == 0:
            level = flow(level)
        plant.state = np.array([now, level])
        plant.values["y0"] = np.array(np.sin(np.pi * now / 2) + level)

    def serialise(saved):
        (now, level), values = saved
        return join({"slow": slow, "values": values["y0"].tolist()}, {"t": now, "level": level})

    def deserialise(data):
        head, arrays = split(data)
        state = np.array([arrays["t"].item(), arrays["level"].item()])
        return state, plant.values | {"y0": np.array(head["values"])}

    plant.state = np.zeros(2)
    plant.step, plant.serialise, plant.deserialise = step, serialise, deserialise
    return system


def go(system, output, tolerance=1e-3, **given):
    return toys.go(system, output, tree=tree(tolerance), **given)


def ends(output):
    """y of the last cycle."""
    results = Results(output)
    values = results.series("plant.y0").values
    results.close()
    return values


def slow_flow(level):
    """Falls by three tenths a cycle in its distance from 1."""
    return 1.0 + 0.7 * (level - 1.0)


def test_a_linear_tank_is_full_after_two_cycles_and_equals_twenty_plain_ones(affine, tmp_path):
    """The secant of a linear map is exact. After 20 plain cycles 0.7^20 = 8e-4 is left."""
    said = []
    summary = go(tank(affine, slow_flow), tmp_path / "fast.h5", log=said.append)
    assert summary["periodic"]
    assert (summary["periods"], summary["extrapolated_periods"], summary["taken_back_periods"]) == (
        4,
        1,
        0,
    )
    # to 1 from g_2 = 0.51, whose last change was 0.21
    assert "extrapolated by multiples of the last period's change: plant.level by 2.3" in said
    plain = go(tank(affine, slow_flow, slow=()), tmp_path / "plain.h5", 1e-4)
    assert plain["periods"] == 20
    assert "extrapolated_periods" not in plain
    # the tolerance, of a range of 2
    assert ends(tmp_path / "fast.h5") == pytest.approx(ends(tmp_path / "plain.h5"), abs=2e-3)
    # the round-off of a secant
    assert ends(tmp_path / "fast.h5")[-1] == pytest.approx(1.0, abs=1e-12)


def spilling(level):
    """Rises by 0.01 a cycle up to 0.2; one that is fuller than that runs dry."""
    return min(level + 0.01, 0.2) if level <= 0.2 else 0.0


def test_what_makes_it_worse_is_taken_back(affine, tmp_path):
    """An extrapolation that makes the run worse is taken back.

    A steady rise is extrapolated by 30 of its changes, from 0.02 to 0.32, and the tank runs dry.
    After the second attempt the plain cycles continue as if there had been none.
    """
    said = []
    summary = go(tank(affine, spilling), tmp_path / "fast.h5", log=said.append)
    plain = go(tank(affine, spilling, slow=()), tmp_path / "plain.h5")
    assert (summary["extrapolated_periods"], summary["taken_back_periods"]) == (2, 2)
    assert summary["periods"] - 2 == plain["periods"] == 20
    assert sum("rejected the extrapolation" in line for line in said) == 2
    assert "relative change 1 instead of 0.5" in " ".join(said)
    low, high = ends(tmp_path / "fast.h5"), ends(tmp_path / "plain.h5")
    assert low[-1] == pytest.approx(high[-1], abs=1e-12)


@pytest.mark.parametrize("instant", [6.0, 9.0, 13.0])
def test_an_interrupted_run_goes_on_extrapolating(affine, tmp_path, instant):
    whole = go(tank(affine, slow_flow), tmp_path / "whole.h5")
    output = tmp_path / "run.h5"
    resumed = toys.go_on(lambda: tank(affine, slow_flow), output, at(instant), tree=tree())
    for key in ("periods", "extrapolated_periods", "period_distance"):
        assert resumed[key] == whole[key]
    assert ends(output).tolist() == ends(tmp_path / "whole.h5").tolist()


@pytest.mark.parametrize(
    "ends, changes, expected",
    [
        # f = 0.5 then 0.25: half of it each cycle, as much again is left
        (([1.0], [1.25]), ([0.5], [0.25]), [1.5]),
        # beyond: f turns its sign, x lies between
        (([2.0], [1.0]), ([1.0], [-1.0]), [1.5]),
        # a change as large as before has no secant; neither has one that grows
        (([1.0], [1.5]), ([0.5], [0.5]), [1.5 + MOST_CHANGES * 0.5]),
        (([1.0], [1.6]), ([0.5], [0.6]), [1.6 + MOST_CHANGES * 0.6]),
        # what is nowhere negative stays so; what is may be
        (([1.0], [0.5]), ([-0.5], [-0.5]), [0.0]),
        (([-1.0], [-1.5]), ([-0.5], [-0.5]), [-1.5 - MOST_CHANGES * 0.5]),
        # nothing changes
        (([1.0], [1.0]), ([0.5], [0.0]), [1.0]),
        # cycles that do not follow one another: g(x) = x/2 + 1 stays at 2, here from 0 and 4
        (([1.0], [3.0]), ([1.0], [-1.0]), [2.0]),
    ],
)
def test_extrapolation_by_hand(ends, changes, expected):
    """Eq. (Y3)."""
    ends = tuple(np.array(each) for each in ends)
    changes = tuple(np.array(each) for each in changes)
    assert extrapolated(ends, changes) == pytest.approx(expected, rel=1e-14)


def test_slow_members_of_bytes():
    data = join({"slow": ["a"]}, {"a": np.arange(3.0), "b": np.ones((2, 2)), "c": np.array(2.0)})
    assert slow_members(data)["a"].tolist() == [0.0, 1.0, 2.0]
    assert list(slow_members(data)) == ["a"]
    moved = with_members(data + b"front", {"a": np.full(3, 7.0)})
    head, arrays = split(moved)
    assert moved.endswith(b"front")
    assert head == {"slow": ["a"]}
    assert arrays["a"].tolist() == [7.0] * 3
    assert arrays["b"].tolist() == [[1.0, 1.0], [1.0, 1.0]]


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"something else",
        *(zlib.compress(b"\x02" + 7 * b"\0" + text) for text in (b"[]", b"{}")),
    ],
)
def test_other_states_have_no_slow_members(data):
    assert slow_members(data) == {}
