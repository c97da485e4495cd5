"""Loops and chains of FMUs that other tools could have exported (`c_models/odd.c`).

The tests check which of them iterate, which step once, and whose states are restored.

Eq. (X14):  x' = u - x over a step H with u held:  x_1 = (x_0 + H u) / (1 + H)
"""

import logging
import re

import numpy as np
import pytest
from fmpy import simulate_fmu

import piston_cosim as pc
from piston_cosim.master.case.check import check
from piston_cosim.master.coupling.stepping import StepFailed
from piston_cosim.master.fmi.errors import BadInput, ParticipantFault

from .c_fmus import MODELS, Variable, compile_model, describe, pack
from .test_foreign_fmus import FEEDTHROUGH

H = 0.01
HALF, STRONG = 0.5 * (H / (1 + H)) ** 2, (200 * H / (1 + H)) ** 2
ILL = (STRONG + 1) / (STRONG - 1)
"""Gains of loops, and the condition of the last one."""
LOOP = [{"from": f"{a}.y", "to": f"{b}.u", "tolerance": 1e-10} for a, b in ("ab", "ba")]
DIRECT = ("-DFEEDS", "-DSTEP=(void)H")
FLAGS = {
    "lag": (),
    "half": ("-DOUTPUT=0.5*x",),
    "undoes": ("-DUNDOES",),
    "deaf": ("-DDEAF", "-DOUTPUT=0.5*x"),
    "one_way": ("-DSAVES=0",),
    "forgets": ("-DFORGETS=1e-2", "-DOUTPUT=0.5*x"),
    "noisy": ("-DSTEP=(void)H", "-DOUTPUT=1-3*u", "-DNOISE=5e-5"),
    "shares": ("-DSHARES",),
    "clock": ("-DOUTPUT=t",),
    "short": ("-DSTEP=if (H > 0.006) return 2; x = (x + H * u) / (1 + H)", "-DOUTPUT=0.5*x"),
    "minus_three": (*DIRECT, "-DOUTPUT=1-3*u"),
    "minus_three_one_way": ("-DSTEP=(void)H", "-DOUTPUT=1-3*u", "-DSAVES=0"),
    "doubles": ("-DSTEP=x = 2 * x; (void)H",),
    "plus_half": (*DIRECT, "-DOUTPUT=1+0.5*u"),
    "follows": ("-DSTEP=x = u + 0 * H",),
    "strong": ("-DSTEP=x = (x + H * 200 * u) / (1 + H)",),
    "strong_one_way": ("-DSTEP=x = (x + H * 200 * u) / (1 + H)", "-DSAVES=0"),
    "same": ("-DSTEP=(void)H", "-DOUTPUT=u"),
    "double": (*DIRECT, "-DOUTPUT=2*u", "-DSAVES=0"),
}


VARIABLES = [
    Variable("y", 1, "output"),
    Variable("u", 2, "input", "Real", 'start="0"'),
    Variable("n", 0, "output", "Integer"),
]


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("odd")
    for name, flags in FLAGS.items():
        compile_model(MODELS / "odd.c", folder / "odd.so", *flags)
        text = describe("2.0", "odd", VARIABLES, states="-DSAVES=0" not in flags)
        pack(folder / f"{name}.fmu", text, folder / "odd.so")
    return folder


@pytest.fixture
def coupled(fmus, tmp_path, caplog):
    """Maker of results of FMUs by name; what the run said is in `said`."""

    def case(participants, wires, stop="1 s", step="10 ms", **options):
        paths = {name: fmus / f"{fmu}.fmu" for name, fmu in participants.items()}
        return pc.couple(paths, wires, stop=stop, step=step, **options)

    def solved(case):
        with caplog.at_level(logging.INFO, logger="piston_cosim"):
            results = case.run(tmp_path / "o.h5")
        run.said = caplog.text
        return results

    def run(*system, **options):
        return solved(case(*system, **options))

    run.case, run.solved = case, solved
    return run


def last(results, port):
    return float(results.series(port).values[-1])


def lag_and_half(steps, explicit=False):
    """Return x of `lag` and of `half` after some steps in a loop that agrees at the end of each.

    If `explicit`, `half` reads the new value of `lag`, and `lag` reads the old value of `half`.
    """
    x, z = 1.0, 1.0
    matrix = np.array([[1 + H, -0.5 * H], [-H, 1 + H]])
    for _ in range(steps):
        if explicit:
            x = (x + H * 0.5 * z) / (1 + H)  # Eq. (X14)
            z = (z + H * x) / (1 + H)
        else:
            x, z = np.linalg.solve(matrix, [x, z])
    return x, z


@pytest.mark.parametrize("other", ["undoes", "deaf"])
@pytest.mark.parametrize("method", ["newton", "iqn_ils", "aitken"])
def test_a_loop_reaches_its_closed_form_whatever_habits_its_fmus_have(coupled, other, method):
    participants = {"a": "undoes", "b": "half"} if other == "undoes" else {"a": "lag", "b": "deaf"}
    results = coupled(participants, LOOP, method=method)
    # each of 100 steps is within 1e-10 of agreement
    assert last(results, "a.y") == pytest.approx(lag_and_half(100)[0], abs=1e-8)
    assert results.summary["mean_iterations"] <= (3 if method == "newton" else 8)


def test_steps_begin_where_those_of_fmpy_do(fmus, coupled):
    begun = coupled({"a": "clock"}, [], stop="0.1 s", step="1 ms").series("a.y").values[1:]
    steps = {"stop_time": 0.1, "step_size": 1e-3, "output_interval": 1e-3}
    bare = simulate_fmu(fmus / "clock.fmu", output=["y"], **steps)
    assert (begun == bare["y"][1:]).all()
    assert (begun == np.arange(100) * 1e-3).all()


@pytest.mark.parametrize("method", ["newton", "iqn_ils"])
def test_a_chain_steps_once_behind_a_loop_that_is_iterated(coupled, method):
    """y_a = 1 - 3 y_b, y_b = 1 + y_a / 2: -0.8 and 0.6; c doubles y_a and d takes that as it is."""
    participants = {"d": "double", "c": "double", "a": "minus_three", "b": "plus_half"}
    wires = [*LOOP, "a.y -> c.u", "c.y -> d.u"]
    results = coupled(participants, wires, stop="0.05 s", method=method)
    values = [last(results, f"{name}.y") for name in "abcd"]
    assert values == pytest.approx([-0.8, 0.6, -1.6, -3.2], abs=1e-9)
    assert (last(results, "c.n"), last(results, "d.n")) == (5, 5)
    assert f"  {method:10s} a, b\n" in coupled.said
    assert "once       c, d" in coupled.said


def test_a_loop_through_an_fmu_without_saved_states_is_explicit_in_that_loop_alone(coupled):
    wires = [*LOOP, "b.y -> c.u"]
    participants = {"a": "one_way", "b": "half", "c": "lag"}
    results = coupled(participants, wires)
    assert last(results, "a.y") == pytest.approx(lag_and_half(100, True)[0], rel=1e-12)
    assert "explicit   a, b  (a cannot restore a saved state)" in coupled.said
    assert results.summary["loops_stepped_explicitly"] == 1
    assert "WARNING" in coupled.said and "step without iteration" in coupled.said
    assert last(results, "b.n") == last(results, "c.n") == 100  # nothing was restored
    wires[0] = LOOP[0] | {"local_error": 1e-3}
    words = "participants.a: expected an FMU that saves its state .* remove local_error"
    with pytest.raises(BadInput, match=words):
        coupled(participants, wires)


def test_states_that_are_restored_with_an_error_are_reported_and_not_used(coupled):
    results = coupled({"a": "lag", "b": "forgets"}, LOOP)
    # x grows by 1 % of itself with each of three states: the first, and one before each step
    said = re.search(r"b: y differs by .* \((\S+) %\) .* saved and restored", coupled.said)
    assert said and float(said[1]) == pytest.approx(3.0, rel=0.1)
    assert "treated as an FMU without saved states; participants.b.rollback" in coupled.said
    assert last(results, "a.y") == pytest.approx(lag_and_half(100, True)[0], rel=1e-12)
    assert last(results, "b.n") == 100


@pytest.mark.parametrize(
    "method, isolated", [("newton", False), ("iqn_ils", False), ("newton", True)]
)
def test_a_loop_is_iterated_to_ten_times_the_noise_of_its_restored_steps(coupled, method, isolated):
    """y = (1 - 3 u) (1 + e), u = y; with a gain of 3 an exchange without iteration diverges."""
    case = coupled.case({"a": "noisy", "b": "same"}, LOOP, stop="0.5 s", method=method)
    results = coupled.solved(case.changed({"participants.a.isolated": isolated}))
    said = re.search(r"a: y differs by (\S+) \((\S+) %\) .*; its loop is iterated", coupled.said)
    noise, share = (float(text) for text in said.groups())
    assert 0.005 <= share <= 0.02  # percent: one to four times 5e-5
    # with a residual r = 1 - 3 u - u, y = 1/4 + 3/4 r
    assert results.series("a.y").values[1:] == pytest.approx(0.25, abs=0.75 * 10 * noise)
    assert results.summary["mean_iterations"] <= (3 if method == "newton" else 9)


def test_a_case_insists_on_saved_states_or_does_without(coupled):
    case = coupled.case({"a": "lag", "b": "forgets"}, LOOP)
    results = coupled.solved(case.changed({"participants.b.rollback": True}))
    assert results.summary["mean_iterations"] > 1 and last(results, "b.n") < -1000
    case = coupled.case({"a": "lag", "b": "half"}, LOOP)
    results = coupled.solved(case.changed({"participants.b.rollback": False}))
    assert last(results, "a.y") == pytest.approx(lag_and_half(100, True)[0], rel=1e-12)
    case = coupled.case({"a": "one_way", "b": "half"}, LOOP)
    with pytest.raises(BadInput, match="participants.a.rollback: expected an FMU that saves"):
        coupled.solved(case.changed({"participants.a.rollback": True}))


def test_instances_that_share_memory_are_reported(coupled):
    with pytest.raises(BadInput, match="a: expected independent instances.*; set isolated = true"):
        coupled({"a": "shares", "b": "half"}, LOOP)


def test_an_fmu_that_never_goes_back_is_not_restored_by_a_trial(coupled):
    results = coupled({"a": "lag", "b": "forgets"}, ["a.y -> b.u"])
    assert [last(results, f"{name}.n") for name in "ab"] == [100, 100]
    assert "every participant steps once" in coupled.said


def test_what_is_behind_an_fmu_that_cannot_go_back_is_halved_alone(coupled):
    """c steps once; a and b take halves, for b refuses steps of more than 6 ms."""
    participants = {"c": "one_way", "a": "lag", "b": "short"}
    results = coupled(participants, ["c.y -> a.u", "a.y -> b.u"], stop="0.02 s")
    a = b = c = 1.0
    for _ in range(2):
        c = c / (1 + H)
        for _ in range(2):
            a = (a + H / 2 * c) / (1 + H / 2)
            b = (b + H / 2 * a) / (1 + H / 2)
    assert last(results, "b.y") == pytest.approx(0.5 * b, rel=1e-13)
    assert last(results, "c.n") == 2


def test_a_step_that_an_fmu_without_saved_states_would_have_to_repeat_ends_the_run(coupled):
    with pytest.raises(ParticipantFault, match="cannot save and restore its state"):
        coupled({"b": "short", "a": "one_way"}, ["a.y -> b.u"], advanced={"halvings": 0})


@pytest.mark.parametrize("isolated", [False, True])
def test_event_mode_that_an_fmu_declares_and_rejects_can_be_switched_off(tmp_path, isolated):
    compile_model(MODELS / "feedthrough.c", tmp_path / "feedthrough.so", "-DREJECTS_EVENTS")
    text = FEEDTHROUGH.replace("<CoSimulation ", '<CoSimulation hasEventMode="true" ')
    fmu = tmp_path / "a.fmu"
    pack(fmu, text, tmp_path / "feedthrough.so")
    case = pc.couple({"a": fmu}, [], stop="1 s", step="0.1 s", parameters={"a": {"gain": 2.0}})
    case = case.changed({"participants.a.isolated": isolated})
    with pytest.raises(BadInput, match=r"rejects the Event Mode .* set event_mode = false"):
        case.run(tmp_path / "o.h5")
    case.changed({"participants.a.event_mode": False}).run(tmp_path / "o.h5")


def checked(folder, a, b):
    """Return the loop of two FMUs, with a chain behind it, as `check` reports it."""
    text = f'title = "loop"\n[time]\nstop = "1 s"\nstep = "{H} s"\n'
    for name, fmu in {"c": "double", "a": a, "b": b}.items():
        text += f'[participants.{name}]\nfmu = "{fmu}.fmu"\n'
    for source, target in ("ab", "ba", "bc"):
        text += f'[[wires]]\nfrom = "{source}.y"\nto = "{target}.u"\n'
    (folder / "case.toml").write_text(text + '[coupling]\norder = ["c", "a", "b"]\n')
    loop, chain = check(folder / "case.toml").loops
    assert (loop.component.names, loop.unknowns) == (("a", "b"), 1)
    assert (chain.component.names, chain.method) == (("c",), "once")
    return loop


@pytest.mark.parametrize(
    "a, b, gain, condition, method, step, why",
    [
        # J = dy_b/du_b dy_a/du_a; (1 + |J|) / |1 - J|
        ("minus_three", "plus_half", 1.5, 1.0, "newton", H, ""),
        ("lag", "half", HALF, 1.0, "newton", H, ""),
        ("one_way", "half", HALF, 1.0, "explicit", H, "a cannot restore a saved state"),
        # (200 H / (1 + H))^2 is 3.92 in steps of 10 ms, 0.990 of 5 and 0.249 of 2.5
        ("strong", "strong", STRONG, ILL, "newton", H, ""),
        ("strong", "strong_one_way", STRONG, ILL, "explicit", H / 4, "b cannot restore"),
        ("follows", "follows", 1.0, np.inf, "newton", H, "singular at the start"),
    ],
)
def test_loops_are_reported_before_the_run(fmus, a, b, gain, condition, method, step, why):
    loop = checked(fmus, a, b)
    # differences over 1e-5 of numbers near 1 are good to 1e-10; near a singular loop that is all
    assert loop.gain == pytest.approx(gain, rel=1e-6, abs=1e-10)
    assert 1 / loop.condition == pytest.approx(1 / condition, rel=1e-3, abs=1e-9)
    assert (loop.method, loop.step) == (method, step) and loop.why.startswith(why)


PAIR = {"a": "minus_three", "b": "plus_half"}
"""With direct feedthrough, a.y = 1 - 3 u and b.y = 1 + u/2."""


@pytest.mark.parametrize("method", ["newton", "iqn_ils", "explicit"])
def test_the_first_row_is_consistent(coupled, method):
    """The solution, whatever the method does afterwards."""
    results = coupled(PAIR, LOOP, stop="30 ms", method=method)
    # u = 1 + (1 - 3 u)/2 at u = 0.6; differences over 1e-5 of numbers near 1 are good to 1e-10
    for port, value in (("a.y", -0.8), ("b.y", 0.6)):
        assert results.series(port).values == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize(
    "first, method", [("minus_three", "explicit"), ("minus_three_one_way", "newton")]
)
def test_an_explicit_loop_whose_changes_double_ten_times_stops(coupled, first, method):
    """The gain is -3: each change is three times the last one, and the first one counts."""
    participants = {"a": first, "b": "same"}
    coupled(participants, LOOP, stop="90 ms", method=method)
    words = "residual that grew .*-fold .*; explicit exchange is unstable"
    with pytest.raises(StepFailed, match=words) as failure:
        coupled(participants, LOOP, stop="0.1 s", method=method)
    assert "cannot save" not in str(failure.value)


def test_a_signal_that_doubles_outside_of_a_loop_is_no_divergence(coupled):
    results = coupled({"b": "same", "a": "doubles"}, ["a.y -> b.u"], "0.2 s", method="explicit")
    assert last(results, "b.y") == 2.0**19


def test_an_explicit_loop_that_diverges_stops(coupled):
    """The gain is -1.5: from round-off to the limit in some 60 macro steps."""
    with pytest.raises(StepFailed, match="expected an exchange that stays bounded"):
        coupled(PAIR, LOOP, stop="2 s", method="explicit")
