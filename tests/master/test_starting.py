"""Start loops, participants that step at the same time, and what is said at the end of a run."""

import numpy as np
import pytest

from piston_cosim.master.coupling.interface import Interface
from piston_cosim.master.coupling.starting import closing, start
from piston_cosim.master.coupling.wiring import System, Wire
from piston_cosim.master.fmi.errors import BadInput, Discard, ParticipantFault
from piston_cosim.master.participants.interpolated import InterpolatedParticipant

from .toys import Toy, variable


class Follower(Toy):
    """y = f(u), at the start as at any other time; notes what happens to it in `events`."""

    def __init__(self, name, follows, events=None, refuse=None):
        fields = {"u": variable("u", "input"), "y": variable("y", "output")}
        super().__init__(name, fields, np.zeros(0), {"u": np.array(0.0)})
        self.follows, self.refuse = follows, refuse
        self.events = [] if events is None else events

    def start(self, parameters, start_time, stop_time):
        self.enter(parameters, start_time, stop_time)
        self.leave()

    def leave(self):
        self.left_with = self.get("u")

    def get(self, name):
        u = float(self.values["u"])
        return u if name == "u" else float(self.follows(u))

    def step(self, time, step):
        self.events.append(f"{self.name} steps")
        if self.refuse:
            raise self.refuse

    def close(self):
        self.events.append(f"{self.name} closes")
        if self.refuse:
            raise self.refuse


class Apart(Follower):
    runs_apart = True

    def launch(self):
        self.events.append(f"{self.name} is launched")

    def begin_step(self, time, step):
        self.events.append(f"{self.name} begins")

    def end_step(self):
        self.events.append(f"{self.name} ends")
        if self.refuse:
            raise self.refuse


def wire(source, target, tolerance=1e-9):
    return Wire((source, "y"), (target, "u"), (), "1", 1.0, tolerance, None)


def loop(one, two, interpolated=True, parameters=None):
    wires = (wire("one", "two"), wire("two", "one"))
    participants = {"one": one, "two": two}
    if interpolated:
        participants["two"] = InterpolatedParticipant(two, {"u": "linear"})
    given = {"one": {}, "two": {}} | (parameters or {})
    return System(participants, ("one", "two"), wires, given, 1.0, 0.1)


@pytest.mark.parametrize("interpolated", [True, False])
@pytest.mark.parametrize("first", [-40.0, 0.0, 7.0])
def test_a_start_loop_is_solved_from_any_start(first, interpolated):
    """y1 = 1 - 5 u1, y2 = u2: u = 1/6, which plain passes lead away from by a factor of five."""
    one, two = Follower("one", lambda u: 1 - 5 * u), Follower("two", lambda u: u)
    start(loop(one, two, interpolated, {"one": {"u": first}}))
    # differences over 1e-5 of numbers near 1 are good to 1e-11; the tolerance is 1e-9
    assert one.left_with == pytest.approx(1 / 6, abs=1e-9)
    assert two.left_with == pytest.approx(1 / 6, abs=1e-9)


def test_a_curved_start_loop_is_solved():
    """u = cos u at 0.7390851332151607."""
    one, two = Follower("one", np.cos), Follower("two", lambda u: u)
    start(loop(one, two))
    assert one.left_with == pytest.approx(0.7390851332151607, abs=1e-9)


def test_a_start_without_solution_is_said():
    """u = u^2 + 1 has no real one, u = u + 1 none, u = 1 - 2 sign(u) jumps over it."""
    for follows, words in (
        (lambda u: u**2 + 1, "the residual stalls"),
        (lambda u: u + 1, "the loop has no solution near here, its equations are singular"),
        (lambda u: -1.0 if u > 0 else 1.0, "the residual stalls; an output jumps"),
    ):
        with pytest.raises(BadInput, match=f"expected start values that agree.*{words}"):
            start(loop(Follower("one", follows), Follower("two", lambda u: u)))


def test_a_start_loop_that_leaves_its_values_open_is_rejected():
    """u = u is true for every u; of u = 0.999 u differences see the unique solution 0."""
    one, two = Follower("one", lambda u: u), Follower("two", lambda u: u)
    with pytest.raises(BadInput, match=r"^one.u: expected a loop that determines its values"):
        start(loop(one, two))
    start(loop(Follower("one", lambda u: 0.999 * u), two))


def evaluated(kinds, wires, order, parallel=False):
    events = []
    participants = {name: kinds.get(name, Apart)(name, lambda u: u + 1, events) for name in order}
    interface = Interface(participants, wires, parallel)
    x = np.linspace(1.0, 2.0, len(wires))
    return interface.evaluate(x, (0.0, 1.0), saved(participants)), events


def saved(participants):
    return {name: one.save() for name, one in participants.items()}


def test_all_step_at_once_in_jacobi_order():
    both = (wire("a", "b"), wire("b", "a"))
    apart, events = evaluated({}, both, ["a", "b"], parallel=True)
    assert events == ["a begins", "b begins", "a ends", "b ends"]
    here, events = evaluated({"a": Follower, "b": Follower}, both, ["a", "b"], parallel=True)
    assert events == ["a steps", "b steps"]
    for one, other in zip(apart, here):
        np.testing.assert_array_equal(one, other)


def test_those_that_wait_for_nothing_step_at_once_in_sequence():
    """a feeds b and c, both feed d: b and c form a stage."""
    wires = (wire("a", "b"), wire("a", "c"), wire("b", "d"))
    result, events = evaluated({}, wires, ["a", "b", "c", "d"])
    assert events == [
        *("a begins", "a ends"),
        *("b begins", "c begins", "b ends", "c ends"),
        *("d begins", "d ends"),
    ]
    # a restored to 0 says 1, b and c say 2
    assert result.outputs.tolist() == [1.0, 1.0, 2.0]


def test_one_of_this_process_steps_while_the_other_is_away():
    _, events = evaluated({"b": Follower}, (wire("a", "b"), wire("b", "a")), ["a", "b"], True)
    assert events == ["a begins", "b steps", "a ends"]


def test_every_one_is_waited_for_before_a_refusal_is_heard():
    events = []
    participants = {
        "a": Apart("a", lambda u: u, events, Discard("a: refused")),
        "b": Apart("b", lambda u: u, events, Discard("b: refused")),
    }
    interface = Interface(participants, (wire("a", "b"), wire("b", "a")), True)
    with pytest.raises(Discard, match="a: refused"):
        interface.evaluate(np.zeros(2), (0.0, 1.0), saved(participants))
    assert events[-2:] == ["a ends", "b ends"]


def ending(*faults):
    events = []
    return [
        Follower(f"p{k}", None, events, fault and ParticipantFault(fault))
        for k, fault in enumerate(faults)
    ], events


def test_a_fault_at_the_end_does_not_mask_the_one_before_it():
    participants, events = ending("p0: at its end", None)
    with pytest.raises(ParticipantFault, match="in a step"), closing(participants):
        raise ParticipantFault("in a step")
    assert events == ["p0 closes", "p1 closes"]


def test_faults_at_the_end_are_reported_once_all_are_closed():
    participants, events = ending("p0: at its end", "p1: too", None)
    reported = []
    with closing(participants, reported.append):
        pass
    assert reported == ["p0: at its end", "p1: too"]
    assert events == ["p0 closes", "p1 closes", "p2 closes"]
