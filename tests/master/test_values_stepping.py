"""Predictor, halving with rollback, step control, start, work and interpolated inputs by hand.

Systems are x = b(t) (A = 0) unless a test says otherwise: the first residual of a macro step is
then the error of the predictor. rel = 1e-9 is round-off of some ten operations, amplified by the
tolerance of 1e-3 where residuals are differences of values up to 125.
"""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.coupling.methods import (
    Explicit,
    LeastSquares,
    Newton,
    QuasiNewton,
    Relaxation,
)
from piston_cosim.master.coupling.starting import start
from piston_cosim.master.coupling.step_control import StepControl, step_control
from piston_cosim.master.coupling.stepping import EnergyCreated, StepFailed, Stepper
from piston_cosim.master.coupling.wiring import Wire
from piston_cosim.master.coupling.work import InterfaceWork
from piston_cosim.master.fmi.errors import BadInput, Discard
from piston_cosim.master.participants.interpolated import InterpolatedParticipant
from piston_cosim.models.elastic_tube.secants import Ageing

from .toys import Toy, variable

FINE = 1e-3
PLAIN = Relaxation(1.0, False, 9)
"""Exact in one evaluation where A = 0; the second finds so."""


class Watched:
    """A stepper whose attempts and accepted steps are noted."""

    def __init__(self, system, method=PLAIN, halvings=0, order=0, control=None, judge=None):
        self.attempts, self.times, self.states, self.trails = [], [], [], []
        self.plant = system.participants["plant"]
        self.stepper = Stepper(system, method, halvings, self, order, control, judge=judge)
        self.advance = self.stepper.advance
        self.counters = self.stepper.counters

    def accepted(self, time, solution):
        self.times.append(time)
        self.states.append(float(self.plant.state[0]))

    def attempted(self, time, step, trail, failure):
        self.trails.append(trail)
        first = trail[0][0] * FINE if trail else None
        self.attempts.append((time, step, first, failure and str(failure)))

    @property
    def first_residuals(self):
        return [first for _, _, first, failure in self.attempts if not failure]


def square(t):
    return t**2


@pytest.mark.parametrize(
    "order, off",
    [
        (0, [1, 3, 5, 7]),  # t^2 less the last value
        (1, [1, 2, 2, 2]),  # less the line through the last two; one value alone at first
        (2, [1, 2, 0, 0]),  # the parabola is met as soon as three values are known
    ],
)
def test_first_residual_is_what_the_predictor_is_off_by(affine, order, off):
    watched = Watched(affine([[0.0]], square, FINE), order=order)
    for k in range(4):
        watched.advance(float(k), 1.0)
    assert watched.first_residuals == pytest.approx(off, rel=1e-9, abs=1e-12)


def test_predictor_goes_by_steps_of_different_length(affine):
    # through (0, 0), (1, 1), (1.5, 2.25) at 3.5 and t^3: 3.5^3 less the parabola; the remainder
    # of a cubic is (t - 0)(t - 1)(t - 1.5)
    watched = Watched(affine([[0.0]], lambda t: t**3, FINE), order=2)
    for time, step in ((0.0, 1.0), (1.0, 0.5), (1.5, 2.0)):
        watched.advance(time, step)
    assert watched.first_residuals[2] == pytest.approx(3.5 * 2.5 * 2.0, rel=1e-9)


def test_a_failed_step_leaves_the_predictor_its_last_value_alone(affine):
    system = affine([[0.0]], square, FINE)
    watched = Watched(system, halvings=1, order=2)
    for k in range(3):
        watched.advance(float(k), 1.0)
    system.participants["echo"].longest = 0.6
    watched.advance(3.0, 1.0)
    # after the failure: 3.5^2 - 9; then less the line through 9 and 12.25
    assert watched.first_residuals[3:] == pytest.approx([3.25, 0.5], rel=1e-9)
    system.participants["echo"].longest = 1.0
    watched.advance(4.0, 1.0)  # three values since: the parabola again
    assert watched.first_residuals[5] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("secants", [LeastSquares(), Ageing()])
def test_a_failed_step_leaves_no_secants(affine, secants):
    # two unknowns take four evaluations without secants and two with (tests of the methods)
    a, b = ((-1.0, 0.0), (0.0, 0.0)), np.array([2.0, 1.0])
    system = affine(a, lambda t: t * b, FINE)
    watched = Watched(system, QuasiNewton(secants, 0.25), halvings=1)
    watched.advance(0.0, 1.0)
    system.participants["plant"].longest = 0.6
    watched.advance(1.0, 1.0)
    assert watched.counters.iterations == [4, 4, 2]


def test_a_step_too_long_for_the_motion_is_repeated_in_parts(affine):
    """Parts become longer only within the limit, and the predictor keeps its history.

    The limit is the output b(t) = 1, 0.3, 0.6, 0.3 and 0.3 at t = 0, 1/4, 1/2, 3/4 and 1. A part
    of 1/4 follows the first attempt at once, because 1/2 is above 0.3.
    """
    limits = {0.25: 0.3, 0.5: 0.6, 0.75: 0.3, 1.0: 0.3}
    system = affine([[0.0]], limits.get, FINE)
    system.participants["plant"].values["y0"] = np.array(1.0)
    watched = Watched(replace(system, limits=(("plant", "y0"),)), halvings=2)
    watched.advance(0.0, 1.0)
    assert [(time, step, failure) for time, step, _, failure in watched.attempts] == [
        (0.0, 1.0, "the motion needs steps of 0.3 s"),
        (0.0, 0.25, None),
        (0.25, 0.25, None),
        (0.5, 0.5, "the motion needs steps of 0.3 s"),
        (0.5, 0.25, None),
        (0.75, 0.25, None),
    ]
    assert (watched.counters.repeated_steps, watched.counters.halved_steps) == (2, 0)
    assert watched.counters.residual_evaluations == sum(watched.counters.iterations) + 4
    assert [float(p.state[0]) for p in system.participants.values()] == [1.0, 1.0]


def test_a_motion_that_no_part_resolves_is_accepted(affine):
    system = affine([[0.0]], lambda t: 1e-9, FINE)
    watched = Watched(replace(system, limits=(("plant", "y0"),)), halvings=1)
    watched.advance(0.0, 1.0)
    assert (watched.times, watched.counters.repeated_steps) == ([0.5, 1.0], 0)


def limited(affine, **how):
    """Return `Watched` of x = 2 t after two steps of 1 s, the second of which needs quarters."""
    system = affine([[0.0]], lambda t: 2 * t, FINE)
    plant = system.participants["plant"]
    plant.values["limit"] = np.array(9.0)

    def advance(time, step, own=plant.step):
        own(time, step)
        plant.values["limit"] = np.array(9.0 if plant.state[0] == 1.0 else 0.25)

    plant.step = advance
    watched = Watched(replace(system, limits=(("plant", "limit"),)), order=1, **how)
    watched.advance(0.0, 1.0)
    watched.advance(1.0, 1.0)
    return watched


@pytest.mark.parametrize("why", ["energy", "convergence"])
def test_a_step_whose_parts_fail_is_taken_without_parts(affine, why):
    """The second step needs quarters, of which the last one creates energy or is not taken.

    Neither is a quarter halved. The whole step starts from the history before it: its first
    residual is the error of the line through 0 and 2 at 4, none. The observer sees no part as
    accepted.
    """

    def judge(time, solution, is_first, is_last):
        judged.append((time, is_first, is_last))
        if time == 2.0 and not is_first:
            raise EnergyCreated("made") if why == "energy" else Discard("made")

    judged = []
    watched = limited(affine, halvings=2, judge=judge)
    assert judged == [
        (1.0, True, True),
        (1.25, True, False),
        (1.5, False, False),
        (1.75, False, False),
        (2.0, False, True),
        (2.0, True, True),
    ]
    assert [(*one[:2], one[3]) for one in watched.attempts[1:]] == [
        (1.0, 1.0, "the motion needs steps of 0.25 s"),
        (1.0, 0.25, "undone: made"),
        (1.25, 0.25, "undone: made"),
        (1.5, 0.25, "undone: made"),
        (1.75, 0.25, "made"),
        (1.0, 1.0, None),
    ]
    assert watched.times == [1.0, 2.0]
    counters = watched.counters
    assert (counters.steps, counters.repeated_steps, counters.steps_without_parts) == (2, 1, 1)
    assert (counters.halved_steps, counters.energy_refused_steps) == (0, why == "energy")
    assert watched.first_residuals[-1] == pytest.approx(0.0, abs=1e-12)
    evaluations = counters.residual_evaluations - sum(counters.iterations)
    assert evaluations == sum(map(len, watched.trails)) - sum(counters.iterations) > 4


def test_parts_are_reported_with_the_state_at_their_end(affine):
    """Quarters of the second step are accepted once all of them are done."""
    watched = limited(affine, halvings=2)
    assert watched.times == [1.0, 1.25, 1.5, 1.75, 2.0]
    assert watched.states == watched.times
    assert watched.counters.steps_without_parts == 0
    assert watched.first_residuals[1:] == pytest.approx([0.0] * 4, abs=1e-12)


def test_newton_forgets_its_products_after_a_failure(affine):
    # what was learned makes one product enough; afresh two are needed
    a, b = ((-1.0, 0.0), (0.0, 0.0)), np.array([2.0, 1.0])
    system = affine(a, lambda t: t * b, FINE)
    watched = Watched(system, Newton(forcing=1e-3), halvings=1)
    watched.advance(0.0, 1.0)
    watched.advance(1.0, 1.0)
    assert watched.counters.derivative_products == 2 + 1
    system.participants["plant"].longest = 0.6
    watched.advance(2.0, 1.0)
    assert watched.counters.derivative_products == 3 + 2 + 1


def test_halves_are_halved_again_and_nothing_is_stepped_twice(affine):
    system = affine([[0.0]], square, FINE)
    system.participants["echo"].longest = 0.3
    watched = Watched(system, halvings=2)
    watched.advance(0.0, 1.0)
    tried = [(time, step, failure is None) for time, step, _, failure in watched.attempts]
    assert tried == [
        (0.0, 1.0, False),
        (0.0, 0.5, False),
        (0.0, 0.25, True),
        (0.25, 0.25, True),
        (0.5, 0.5, False),
        (0.5, 0.25, True),
        (0.75, 0.25, True),
    ]
    assert watched.times == [0.25, 0.5, 0.75, 1.0]
    assert watched.counters.steps == 4
    assert watched.counters.halved_steps == 3
    # what the participants have lived through, and b(1): exact in binary
    assert [float(p.state[0]) for p in system.participants.values()] == [1.0, 1.0]
    assert float(system.participants["plant"].values["y0"]) == 1.0
    assert watched.stepper.failures == [
        "t = 0 s, step 1 s: echo: refused on purpose",
        "t = 0 s, step 0.5 s: echo: refused on purpose",
        "t = 0.5 s, step 0.5 s: echo: refused on purpose",
    ]


@pytest.mark.parametrize(
    "method, halvings, count", [(Explicit(), 0, 0), (Explicit(), 1, 2), (PLAIN, 0, 2)]
)
def test_states_are_saved_where_a_step_may_be_repeated(
    affine, monkeypatch, method, halvings, count
):
    system = affine([[0.0]], square, FINE)
    saves = []
    for participant in system.participants.values():
        save = participant.save
        monkeypatch.setattr(participant, "save", lambda save=save: saves.append(1) or save())
    Watched(system, method, halvings).advance(0.0, 1.0)
    assert len(saves) == count
    assert [float(p.state[0]) for p in system.participants.values()] == [1.0, 1.0]


def test_so_many_halvings_and_no_more(affine):
    system = affine([[0.0]], square, FINE)
    system.participants["echo"].longest = 0.3
    watched = Watched(system, halvings=1)
    with pytest.raises(StepFailed, match=r"t = 0 s, step 0\.5 s"):
        watched.advance(0.0, 1.0)
    assert float(system.participants["plant"].state[0]) == 0.0


def test_evaluations_of_a_step_that_does_not_converge_are_counted(affine):
    # relaxed by 1/2, b = 2 t: from 0 the residuals 2, 1, 1/2, 1/4, 1/8, none below 0.1;
    # half the step: 1 .. 1/16; then 2 - (1 - 1/16) .. / 16
    watched = Watched(affine([[0.0]], lambda t: 2 * t, 0.1), Relaxation(0.5, False, 5), 1)
    watched.advance(0.0, 1.0)
    assert watched.counters.iterations == [5, 5]
    assert watched.counters.residual_evaluations == 15
    assert watched.counters.halved_steps == 1
    assert [first / FINE * 0.1 for _, _, first, _ in watched.attempts] == pytest.approx(
        [2.0, 1.0, 1.0625], rel=1e-9
    )


def controlled(affine, allowed, smallest=1.0):
    """Step x = t^3 to 7 s with local error control."""
    system = affine([[0.0]], lambda t: t**3, FINE, local_error=allowed)
    watched = Watched(system, control=step_control(system.wires, smallest))
    watched.advance(0.0, 7.0)
    return watched


def test_steps_by_local_error(affine):
    # 1 s to begin with, twice that, twice again: then three vectors give an estimate, Eq. (A1):
    # x - x_quad = (7 - 0)(7 - 1)(7 - 3) = 168, e = 168 x 4 x 6 / (10 x 7) / allowed = 57.6 / 460.8
    watched = controlled(affine, 460.8)
    assert watched.times == pytest.approx([1.0, 3.0, 7.0], rel=1e-12)
    assert watched.stepper.control.error == pytest.approx(0.125, rel=1e-9)
    # Eq. (A2): 4 x 0.9 x 2
    assert watched.stepper.control.step == pytest.approx(7.2, rel=1e-9)
    assert watched.counters.rejected_steps == 0


def test_a_step_with_too_large_an_error_is_taken_again_shorter(affine):
    # e = 57.6 / 7.2 = 8, 4 x 0.9 / 2 = 1.8 s next; 4 s are then three steps of 4/3 s at most, of
    # which the later ones would be allowed 1.43 and 1.58 s
    watched = controlled(affine, 7.2)
    assert watched.times == pytest.approx([1.0, 3.0, 13 / 3, 17 / 3, 7.0], rel=1e-12)
    assert watched.counters.rejected_steps == 1
    assert watched.attempts[2][1] == 4.0
    assert watched.attempts[2][3] == "local error 8 times the allowed one"
    assert watched.counters.residual_evaluations == 6 * 2
    # the last: (7 - 3)(7 - 13/3)(7 - 17/3) = 128/9, times 4/3 x 8/3 / (4 x 4) = 2/9
    assert watched.stepper.control.error == pytest.approx(128 / 9 * 2 / 9 / 7.2, rel=1e-9)


def test_steps_by_local_error_resolve_the_motion(affine):
    """The motion limits steps that end at 1, 3, 4 and 4.75 s; the constant x has no error.

    The smallest step, to 1 s, ignores its limit. The next one of 2 s is above 1.5 s: the rest of
    6 s is divided into four parts. After the first of them a step of 3 s is allowed, and the rest
    of 4.5 s is halved. This is above 2 s: three parts of 1.5 s follow, because the end of the first
    of them limits the next one to 2 s.
    """
    limits = {1.0: 2.0, 3.0: 1.5, 4.75: 2.0, 4.0: 2.0}
    system = affine([[0.0]], lambda t: limits.get(t, 9.0), FINE, local_error=1e9)
    plant = system.participants["plant"]
    plant.values["y0"] = np.array(9.0)
    limited = replace(system, limits=(("plant", "y0"),))
    watched = Watched(limited, control=step_control(system.wires, 1.0))
    watched.advance(0.0, 7.0)
    assert watched.times == pytest.approx([1.0, 2.5, 4.0, 5.5, 7.0], rel=1e-12)
    refused = [(*one[:2], one[3]) for one in watched.attempts if one[3]]
    assert refused == [
        (1.0, 2.0, "the motion needs steps of 1.5 s"),
        (2.5, 2.25, "the motion needs steps of 2 s"),
    ]
    assert (watched.counters.repeated_steps, watched.counters.rejected_steps) == (2, 0)


def test_next_step_is_within_its_bounds():
    # Eq. (A2): e = 1000 would ask for 0.09, e = 1e-6 for 90; without an estimate twice as long
    for error, factor in ((1000.0, 0.2), (1e-6, 2.0), (1.0, 0.9), (27.0, 0.3)):
        control = StepControl([(slice(0, 1), 2 / 9 * 6 / error)], 1e-9)
        for last in (0.0, 1.0, 2.0):
            solution = SimpleNamespace(x=np.array([(last + 1) ** 3]), iterations=2)
            control.accepts((last, np.array([last**3])), last, 1.0, solution)
        # three equal steps of t^3: e = 2/9 H^3 x''' / allowed
        assert control.error == pytest.approx(error, rel=1e-9)
        assert control.step == pytest.approx(factor, rel=1e-9)


def test_error_is_the_mean_over_a_wire_and_the_largest_of_wires():
    # x = (3 t^3, 4 t^3 | t^3): rms sqrt(12.5) x 2/9 6, against 2/9 6 with a tenth allowed
    for allowed, error in ((1.0, 10.0), (0.1, np.sqrt(12.5) * 10)):
        parts = [(slice(0, 2), 2 / 9 * 6 * allowed), (slice(2, 3), 2 / 9 * 6 * 0.1)]
        control, x = StepControl(parts, 1e-9), np.array([3.0, 4.0, 1.0])
        for last in (0.0, 1.0, 2.0):
            solution = SimpleNamespace(x=x * (last + 1) ** 3, iterations=2)
            control.accepts((last, x * last**3), last, 1.0, solution)
        assert control.error == pytest.approx(error, rel=1e-9)


def test_a_discarded_step_is_halved_down_to_the_smallest(affine):
    system = affine([[0.0]], square, FINE, local_error=1e9)
    control = step_control(system.wires, 0.25)
    watched = Watched(system, control=control)
    watched.advance(0.0, 0.25)
    system.participants["echo"].longest = 0.4
    control.step = 1.0
    watched.advance(0.25, 1.0)
    # 1, 1/2, 1/4 of what remains; then twice that or equal shares of the rest
    assert [step for _, step, _, failure in watched.attempts if failure] == [1.0, 0.5]
    assert watched.times == [0.25, 0.5, 0.875, 1.25]
    system.participants["echo"].longest = 0.1
    with pytest.raises(StepFailed):
        watched.advance(1.25, 1.0)


def test_inputs_begin_with_what_started_participants_say(affine):
    system = affine([[1.0]], square, FINE)
    plant, echo = system.participants.values()
    plant.values["y0"], echo.values["w0"] = np.array(3.0), np.array(5.0)
    system.parameters["echo"]["v0"] = 7.0  # gives way to what the plant says
    start(system)
    assert float(echo.values["v0"]) == 3.0
    assert float(plant.values["u0"]) == 5.0


def test_every_refusal_at_the_start_is_told(affine):
    system = affine([[1.0]], square, FINE)

    def refuse(*faults):
        raise BadInput([*faults])

    system.participants["plant"].leave = lambda *given: refuse("too long", "too wide")
    system.participants["echo"].leave = lambda *given: refuse("too high")
    with pytest.raises(BadInput) as refusal:
        start(system)
    assert refusal.value.faults == ["too long", "too wide", "too high"]


class Interface(SimpleNamespace):
    """Two wires of two elements, q at 0..1 and F at 2..3."""

    def read(self):
        return np.array([1.0, 2.0, 10.0, 20.0])


def work_of(unit, force="N", conjugate="b.F"):
    """Work of q, which a gives to b, and of F, which b gives back."""
    tables = [
        SimpleNamespace(source="a.q", target="b.q", conjugate=conjugate),
        SimpleNamespace(source="b.F", target="a.F", conjugate=None),
    ]
    wires = (
        Wire(("a", "q"), ("b", "q"), (2,), unit, 1.0, 1.0, None),
        Wire(("b", "F"), ("a", "F"), (2,), force, 1.0, 1.0, None),
    )
    return InterfaceWork(Interface(wires=wires, parts=[slice(0, 2), slice(2, 4)]), tables)


@pytest.mark.parametrize(
    "unit, first, second, exchanged",
    [
        # dq_out = (0.5, 1), F_in = (11, 22): 27.5; dq_in = (0.25, 0.5), F_out = (12, 18): 12
        ("m", 27.5, 12.0, 27.5),
        # q is a velocity, over 0.5 s: out (1.5, 3), in (1.25, 2.5): F_in . q_out H = 41.25, 30
        ("m/s", 41.25, 30.0, 41.25),
    ],
)
def test_work_on_both_sides_by_hand(unit, first, second, exchanged):
    # W1: side 1 computes q from F, side 2 F from q
    work = work_of(unit)
    end = 0.5, np.array([1.25, 2.5, 11.0, 22.0]), np.array([1.5, 3.0, 12.0, 18.0])
    work.add(end, work.exchange(work.last, end))
    assert work.work.tolist() == pytest.approx([first, second], rel=1e-14)
    # back to where it began: the amounts add, the work does not
    end = 1.0, np.array([1.0, 2.0, 11.0, 22.0]), np.array([1.0, 2.0, 12.0, 18.0])
    work.add(end, work.exchange(work.last, end))
    summary = work.summary()
    out = -27.5 if unit == "m" else 27.5
    into = -12.0 if unit == "m" else 24.0
    whole = first + out
    assert summary["interface_work_j"] == pytest.approx(whole, rel=1e-14, abs=1e-13)
    imbalance = (whole - second - into) / (exchanged + abs(out))
    assert summary["interface_work_imbalance"] == pytest.approx(imbalance, rel=1e-13, abs=1e-15)


@pytest.mark.parametrize(
    "conjugate, unit, message",
    [
        ("b.other", "N", "expected a wire of this shape to a, got none"),
        ("b.F", "Pa", "expected a product of work or power, got"),
    ],
)
def test_what_is_no_conjugate_is_refused(conjugate, unit, message):
    with pytest.raises(BadInput, match=message):
        work_of("m", unit, conjugate)


class Told(Toy):
    """A participant that only notes the courses it is told; its state is their number."""

    def __init__(self):
        fields = {"u": variable("u", "input", shape=(1,), unit="m")}
        super().__init__("told", fields, np.zeros(1), {"u": np.array([1.0])})
        self.courses = []

    def set_course(self, name, course):
        self.courses.append(course[:, 0].tolist())

    def _advance(self, step):
        self.state = self.state + 1


def tried(participant, time, end, **more):
    """Take a step to an end that is not the first to be tried: each begins at the saved ends."""
    saved = participant.save()
    for attempt in (99.0, end):
        participant.restore(saved)
        for name, value in {"u": [attempt], **more}.items():
            participant.set(name, value)
        participant.step(time, 2.0)


@pytest.mark.parametrize(
    "kind, first, second",
    [
        ("linear", [1.0, 1.0], [3.0, -0.5]),
        # Eq. (I2): slopes 1/2 at the start, 4 at 2 s, 0 at 4 s: u = 1 + s/2 - s^2 + 5/8 s^3
        ("hermite", [1.0, 0.5, -2.0, 3.75], [3.0, 4.0, 2 * (-1.5 - 8.0) / 2, 6 * (4.0 + 1.0) / 4]),
    ],
)
def test_a_step_begins_with_the_ends_of_the_last_one(kind, first, second):
    told = Told()
    participant = InterpolatedParticipant(told, {"u": kind})
    participant.start({"der(u)": np.array([0.5])} if kind == "hermite" else {}, 0.0, 9.0)
    if kind == "hermite":
        assert [*told.values] == ["u"]
        participant.set("der(u)", [0.5])
    for time, end, slope, course in ((0.0, 3.0, 4.0, first), (2.0, 2.0, 0.0, second)):
        tried(participant, time, end, **{"der(u)": [slope]} if kind == "hermite" else {})
        assert told.courses[-1] == pytest.approx(course, rel=1e-14)
    assert participant.get("u") == [2.0]
    assert told.state == 2


def test_a_step_from_an_older_state_begins_with_its_ends():
    told = Told()
    participant = InterpolatedParticipant(told, {"u": "linear"})
    participant.start({}, 0.0, 9.0)
    older = participant.save()
    tried(participant, 0.0, 3.0)
    participant.save()
    participant.restore(older)
    participant.set("u", [2.0])
    participant.step(0.0, 2.0)
    assert told.courses[-1] == [1.0, 0.5]


def test_a_mean_input_is_held_at_the_mean_and_ends_at_its_end():
    """Eq. (P10): from 1 to 3 the step sees 2 and the outputs 3; from 3 to 2 2.5 and 2."""
    told, seen = Told(), []
    told.set = lambda name, value: seen.append(float(value[0]))
    participant = InterpolatedParticipant(told, {"u": "mean"})
    participant.start({}, 0.0, 9.0)
    for time, end in ((0.0, 3.0), (2.0, 2.0)):
        tried(participant, time, end)
    assert seen == [50.0, 99.0, 2.0, 3.0, 51.0, 99.0, 2.5, 2.0]
    assert told.courses == []
