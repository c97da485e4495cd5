"""Clocks of FMI 3.0 tick at their instants, whatever the macro step.

Sampled loops and triggered jumps follow closed forms.

Eq. (X20):  x((k+1) T) = e^(-T) x_k + (1 - e^(-T)) u_k,   u_k = -g (x_k + sum of x_j, j < k)
            a lag and a sampled controller that holds its output
Eq. (X21):  x(t) = e^-t before t*,  e^-t + p e^-(t - t*) after it       a lag that is pushed once
"""

from functools import partial

import numpy as np
import pytest

from piston_cosim.master.coupling.starting import closing
from piston_cosim.master.coupling.stepping import StepFailed
from piston_cosim.master.fmi.errors import BadInput, ParticipantFault
from piston_cosim.master.participants.open import open_fmu

from . import counter, runs
from .c_fmus import MODELS, Variable, compile_model, describe, pack
from .runs import problems_of

PARAMETER = partial(Variable, causality="parameter", kind="Float64")
SAMPLE = 'intervalVariability="constant" intervalCounter="1" resolution="10"'
TRIGGERED = 'intervalVariability="triggered"'
HELD = {"variability": "discrete"}


def variables(sample=SAMPLE):
    """Those of the model; the interval of the sampling clock may be another."""
    clock = partial(Variable, kind="Clock")
    return [
        Variable("time", 0, "independent", "Float64"),
        *(
            PARAMETER(name, k, attributes=f'start="{start}"')
            for k, (name, start) in enumerate(
                {"k": 1, "gain": 1, "cross_at": 1e9, "x0": 0}.items(), 1
            )
        ),
        Variable("u", 5, "input", "Float64", 'start="0"'),
        Variable("x", 6, "output", "Float64"),
        Variable("y_in", 7, "input", "Float64", 'start="0" clocks="20"', **HELD),
        Variable("u_out", 8, "output", "Float64", 'clocks="20"', **HELD),
        Variable("mark", 9, "output", "Float64", 'clocks="21"', **HELD),
        Variable("push", 10, "input", "Float64", 'start="0" clocks="22"', **HELD),
        PARAMETER("wait", 11, attributes='start="0.05"'),
        *(
            Variable(name, k, "output", "Float64", **HELD)
            for k, name in enumerate(("samples", "laters", "nexts", "fixeds", "kicks"), 12)
        ),
        clock("sample", 20, "input", attributes=sample),
        clock("crossed", 21, "output", attributes=TRIGGERED),
        clock("kick", 22, "input", attributes=TRIGGERED),
        clock("passed", 23, "output", attributes=TRIGGERED),
        clock("later", 24, "input", attributes='intervalVariability="countdown"'),
        clock("next", 25, "input", attributes='intervalVariability="changing"'),
        clock("fixed", 26, "input", attributes='intervalVariability="fixed"'),
    ]


def description(redo=True, sample=SAMPLE):
    flags = f'hasEventMode="true" canSerializeFMUState="{str(redo).lower()}"'
    return describe("3.0", "clocked", variables(sample), flags, redo)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clocked")
    library = folder / "clocked.so"
    compile_model(MODELS / "clocked.c", library)
    bad = 'intervalVariability="constant" intervalDecimal="0"'
    short = bad.replace('"0"', '"1e-4" shiftDecimal="1e-5"')
    for name, text in (
        ("clocked", description()),
        ("once", description(redo=False)),
        ("stopped", description(sample=bad)),
        ("hurried", description(sample=short)),
        ("unclocked", description().replace('clocks="20"', 'clocks="5"')),
        ("odd", description(sample='intervalVariability="often"')),
        ("nothing", description(sample=SAMPLE.replace('"10"', '"ten"'))),
    ):
        pack(folder / f"{name}.fmu", text, library)
    return folder


def case_text(wires, fmu="clocked", step="0.03 s", **more):
    fmus = f"{fmu}.fmu", "clocked.fmu"
    return counter.case_text(wires, stop="0.9 s", step=step, fmus=fmus, **more)


def solved(folder, output, text):
    results = runs.run_text(folder, text, output=output)
    return results, results.time


def test_the_description_is_valid(folder):
    assert problems_of(folder / "clocked.fmu") == []


@pytest.mark.parametrize("step", ["0.03 s", "0.1 s", "0.45 s"])
def test_every_kind_of_clock_ticks_at_its_instants(folder, tmp_path, step):
    """A row shows the number of ticks before its own instant.

    Constant clock: 0, 0.1, ... Fixed, as the FMU sets it: 0.025 + 0.125 k. Countdown: intervals
    0.05, 0.1, 0.2, ... Changing: 0, 0.1, 0.3, 0.6, ...
    """
    results, time = solved(folder, tmp_path / "o.h5", case_text([], step=step))
    for name, instants in {
        "samples": 0.1 * np.arange(20),
        "fixeds": 0.025 + 0.125 * np.arange(20),
        "laters": 0.05 * (2.0 ** np.arange(1, 9) - 1),
        "nexts": 0.05 * np.arange(9) * np.arange(1, 10),
    }.items():
        expected = [np.count_nonzero(instants < t - 1e-9) for t in time]
        seen = results.series(f"a.{name}").values
        np.testing.assert_array_equal(seen, expected, err_msg=name)


GAIN = 0.4
LOOP = [("b.x", "a.y_in", ""), ("a.u_out", "b.u", "")]


def sampled():
    """x at 0.1 k by Eq. (X20)."""
    x, total, decay = [1.0], 0.0, np.exp(-0.1)
    for _ in range(9):
        u = -GAIN * (x[-1] + total)
        total += x[-1]
        x.append(decay * x[-1] + (1 - decay) * u)  # Eq. (X20)
    return np.array(x)


@pytest.mark.parametrize(
    "method, isolated",
    [("newton", "false"), ("iqn_ils", "false"), ("explicit", "false"), ("newton", "true")],
)
def test_a_sampled_loop_is_its_difference_equation(folder, tmp_path, method, isolated):
    text = case_text(
        LOOP,
        a=f"gain = {GAIN}",
        b="x0 = 1.0",
        method=method,
        own=f"isolated = {isolated}",
    )
    results, time = solved(folder, tmp_path / "o.h5", text)
    at = [int(np.argmin(np.abs(time - 0.1 * k))) for k in range(10)]
    np.testing.assert_allclose(time[at], 0.1 * np.arange(10), atol=1e-12)
    # ten exponentials and divisions each: round-off alone
    np.testing.assert_allclose(results.series("b.x").values[at], sampled(), atol=1e-13)


PUSHED = [("a.crossed", "b.kick", ""), ("a.mark", "b.push", "")]
PLACE = {"a": "cross_at = 0.37\nx0 = 2.0", "b": "x0 = 1.0"}


@pytest.mark.parametrize(
    "more, isolated",
    [
        ({}, "false"),
        ({"method": "explicit"}, "false"),
        ({"coupling": "parallel = true"}, "false"),
        ({"coupling": "parallel = true"}, "true"),
    ],
)
def test_a_tick_inside_a_step_is_heard_at_its_instant(folder, tmp_path, more, isolated):
    text = case_text(PUSHED, **PLACE, **more, own=f"isolated = {isolated}")
    results, time = solved(folder, tmp_path / "o.h5", text)
    push = 2 * np.exp(-0.37)  # the mark: a's state at the instant
    jumped = np.where(time > 0.37 + 1e-9, push * np.exp(-(time - 0.37)), 0.0)
    np.testing.assert_allclose(results.series("b.x").values, np.exp(-time) + jumped, atol=1e-13)
    np.testing.assert_allclose(results.series("a.x").values, 2 * np.exp(-time), atol=1e-13)
    assert results.series("b.kicks").values[-1] == 1
    assert np.any(np.abs(time - 0.37) < 1e-12)  # the macro step ends there


def test_without_saved_states_a_tick_is_heard_at_the_end_of_the_macro_step(folder, tmp_path):
    text = case_text(PUSHED, **PLACE, method="explicit", fmu="once")
    results, time = solved(folder, tmp_path / "o.h5", text)
    push = 2 * np.exp(-0.37)
    heard = next(t for t in time if t > 0.37)
    jumped = np.where(time > heard + 1e-9, push * np.exp(-(time - heard)), 0.0)
    np.testing.assert_allclose(results.series("b.x").values, np.exp(-time) + jumped, atol=1e-13)


def test_ticks_go_on_from_clock_to_clock_at_one_instant(folder, tmp_path):
    """b's kick ticks `passed`, which kicks a back, by what b is after its own push."""
    wires = [*PUSHED, ("b.passed", "a.kick", ""), ("b.x", "a.push", "")]
    results, time = solved(folder, tmp_path / "o.h5", case_text(wires, **PLACE))
    assert results.series("a.kicks").values[-1] == results.series("b.kicks").values[-1] == 1
    back = 3 * np.exp(-0.37)  # e^-t* of its own, 2 e^-t* pushed
    jumped = np.where(time > 0.37 + 1e-9, back * np.exp(-(time - 0.37)), 0.0)
    expected = 2 * np.exp(-time) + jumped
    np.testing.assert_allclose(results.series("a.x").values, expected, atol=1e-13)


def stepped(folder, text, **values):
    """Take one macro step of a case, with inputs of `a`."""
    case, system = runs.open_text(folder, text)
    with closing(system.participants.values()):
        steps = runs.stepper(case, system)
        for name, value in values.items():
            system.participants["a"].set(name, value)
        steps.advance(0.0, 0.5)


def test_ticks_without_end_and_a_fault_in_an_event_are_told(folder):
    with pytest.raises(StepFailed, match="clocks trigger one another without end"):
        wires = [("a.crossed", "b.kick", ""), ("a.passed", "a.kick", "")]
        stepped(folder, case_text(wires), kick=True)
    with pytest.raises(StepFailed, match="a: later ticks without end at t = 0 s"):
        stepped(folder, case_text([], a="wait = 0.0"))
    with pytest.raises(ParticipantFault, match="b: fmi3UpdateDiscreteStates failed"):
        stepped(folder, case_text(PUSHED, a="cross_at = 0.37\nx0 = 1e8", b=PLACE["b"]))
    with pytest.raises(StepFailed, match="1000 clock ticks in a macro step"):
        stepped(folder, case_text([], fmu="hurried"))


@pytest.mark.parametrize(
    "text, words",
    [
        (
            case_text([("a.crossed", "b.sample", "")]),
            "expected a triggered clock, got one with an interval",
        ),
        (case_text([("a.crossed", "b.push", "")]), "expected equal types, got Clock and Real"),
        (
            case_text([("a.mark", "b.push", "tolerance = 1e-3")]),
            "expected a wire of real numbers for .*, got type Real to a clocked input",
        ),
        (case_text([], fmu="stopped"), "expected an interval above 0 s, got 0 s"),
        (case_text([], fmu="odd"), "expected intervalVariability .*, got 'often'"),
        (case_text([], fmu="unclocked"), "y_in: expected clocks, got other variables"),
        (case_text([], fmu="nothing"), "clocks: .*'ten'"),
        (case_text([], a="kick = true"), "expected no value for a clock"),
        (
            case_text([], more='[summary]\nx = "last a.crossed"\n'),
            "expected a scalar number, got a.crossed, a Clock",
        ),
    ],
)
def test_misuse_of_clocks_is_refused(folder, text, words):
    with pytest.raises(BadInput, match=words):
        stepped(folder, text)


def test_a_saved_state_holds_the_clocks(folder):
    one, other = (open_fmu(name, folder / "clocked.fmu") for name in ("one", "other"))
    for participant in (one, other):
        participant.start({"x0": 1.0}, 0.0, 1.0)
    one.tick(0.0, 0.1)
    saved = one.save()
    data = one.serialise(saved)
    ends = []
    for participant, state in ((one, saved), (one, saved), (other, other.deserialise(data))):
        participant.restore(state)
        assert participant.next_tick() == 0.025  # of the fixed clock
        participant.step(0.0, 0.025)
        participant.tick(0.025, 0.1)
        ends.append((participant.next_tick(), *participant.get_many(["x", "fixeds"]).values()))
    assert ends[0] == ends[1] == ends[2] == (0.05, np.exp(-0.025), 1.0)
    for participant in (one, other):
        participant.close()


def test_step_control_ends_its_steps_at_ticks(folder, tmp_path):
    """A wire with a local error divides macro steps; the jump comes at its instant all the same."""
    wires = [*PUSHED, ("a.x", "b.u", "local_error = 1e-3")]
    text = case_text(wires, **PLACE, step="0.1 s").replace(
        "[time]", '[time]\nsmallest_step = "0.01 s"'
    )
    _, time = solved(folder, tmp_path / "o.h5", text)
    for instant in (0.1, 0.37, 0.525):
        assert np.min(np.abs(time - instant)) < 1e-12
