"""Runs and failures that users of other tools have reported, each with its right value."""

import os
import resource
import subprocess
import sys
from contextlib import suppress
from math import ulp
from pathlib import Path

import pytest

import piston_cosim as pc
from piston_cosim.master.case.check import check
from piston_cosim.master.coupling.stepping import StepFailed
from piston_cosim.master.fmi.errors import ParticipantFault

from ..command import call
from .c_fmus import Variable, make_reported
from .reported import TYPED, Y, calls, fmu, folder, integer, last, real, refused, run
from .runs import coarse

__all__ = ["folder"]


# time -----------------------------------------------------------------------------------------


def test_steps_begin_where_the_last_one_ended():
    check = "static double end;if(t>0)m->r[1]=fmax(m->r[1],fabs(t-end));end=t+H;"
    check += "m->r[2]=fmax(m->r[2],fabs(H-1e-3))"
    results = run({"a": fmu("a", [Y, real("change", 2)], STEP=check)}, stop="10 s", step="1 ms")
    # a communication point is rounded once, a step is the difference of two of them
    assert last(results, "a.y") <= ulp(10.0) and last(results, "a.change") <= 2 * ulp(10.0)


def test_a_run_that_starts_later():
    a = fmu("a", [Y, real("begin", 2), real("end", 3)], OUT="m->r[2]=m->start;m->r[3]=m->stop")
    results = run({"a": a}, stop="12 s", step="0.5 s", changes={"time.start": "10 s"})
    assert (results.time[0], results.time[-1]) == (10.0, 12.0)
    assert calls("step")[0] == ["10", "0.5"] and last(results, "a.begin", "a.end") == [10.0, 12.0]


# instances ------------------------------------------------------------------------------------


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_a_second_instance_of_an_fmu_that_allows_one_runs_isolated(version):
    once = 'canBeInstantiatedOnlyOncePerProcess="true"'
    part = "kept+=H*m->r[0];m->r[1]=kept"
    a = fmu("a", [real("u", 0, "input"), Y], version, flags=once, states=False, STEP=part)
    values = {"one": {"u": 1.0}, "two": {"u": 10.0}}
    results = run({"one": a, "two": a}, parameters=values)
    assert last(results, "one.y", "two.y") == pytest.approx([1.0, 10.0], rel=1e-14)  # ten sums


def test_a_crash_when_an_isolated_fmu_is_freed_leaves_the_results():
    a = fmu("a", FREE="abort()")
    with suppress(ParticipantFault):
        run({"a": a}, changes={"participants.a.isolated": True})
    assert len(pc.Results("o.h5").time) == 11


def test_an_asynchronous_step_is_not_supported():
    a = fmu("a", flags='canRunAsynchronuously="true"', STEP="return 5", STATUS="*value=0;return 0")
    with pytest.raises((ParticipantFault, pc.StepFailed), match="fmi2Pending"):
        run({"a": a})


def test_every_run_frees_its_instances():
    a = fmu("a", STEP="m->r[1]+=H")
    for _ in range(3):
        assert last(run({"a": a}), "a.y") == pytest.approx(1.0)
    assert len(calls("free")) == len(calls("instantiate")) >= 3


def test_messages_may_come_from_another_thread():
    thread = "pthread_t p;pthread_create(&p,0,messages,I);pthread_join(p,0);m->r[1]=t+H"
    results = run({"a": fmu("a", STEP=thread)})
    assert last(results, "a.y") == 1.0
    assert results.summary["warnings"] == ["a: t = 0 s, 20000 times: from a thread"]


# places ---------------------------------------------------------------------------------------


def test_resources_in_folders_with_unusual_names(folder):
    """The URI of FMI 2.0 is encoded, the path of FMI 3.0 is not and ends with a separator."""
    script = (
        "import sys, piston_cosim as pc\n"
        "pc.couple({'a': sys.argv[1]}, [], stop='1 s', step='1 s').run('o.h5')"
    )
    for version in ("2.0", "3.0"):
        path = make_reported(f"größe 1%20 {version}.fmu", version, [Y], files={"resources/y": "42"})
        cache = str(folder / "cache ü %41 {y}")
        settings = os.environ | {"PISTON_COSIM_CACHE": cache}
        subprocess.run([sys.executable, "-c", script, path], env=settings, check=True)
    two, three = (" ".join(words) for words in calls("instantiate"))
    assert "cache%20%C3%BC%20%2541%20%7By%7D/unpacked/gr%C3%B6%C3%9Fe%201%2520" in two
    assert two.startswith("file:///") and two.endswith("/resources")
    assert three.startswith(f"{cache}/unpacked/größe 1%20") and three.endswith("/resources/")
    assert Path(three, "y").read_text() == "42"


def test_an_fmu_without_resources_has_their_uri():
    run({"a": fmu("a")})
    assert calls("instantiate")[0][0].startswith("file:///")


# events ---------------------------------------------------------------------------------------

EVENTS = 'hasEventMode="true" mightReturnEarlyFromDoStep="true"'


def test_an_fmu_that_ends_the_simulation_at_an_event_between_steps():
    part = "if(m->t>0.35||m->i[2])*b=true"
    variables = [integer("u", 100, "input"), Y, Variable("end", 102, "parameter", "Integer")]
    a = fmu("a", variables, "3.0", flags='hasEventMode="true"', UPDATE=part)
    b = fmu("b", [integer("y", 101)], OUT="m->i[1]=m->t>0.35")
    results = run({"b": b, "a": a}, ["b.y -> a.u"])
    assert results.time[-1] == 0.4 and "a: ends the" in results.summary["ended_early"]
    with pytest.raises(StepFailed, match="ends the simulation at t = 0 s, before its first macro"):
        run({"a": a}, parameters={"a": {"end": 1}})


def test_no_events_where_the_case_does_not_use_them():
    a = fmu("a", version="3.0", flags=EVENTS)
    run({"a": a}, changes={"participants.a.event_mode": False})
    assert calls("events") == [["0"]]


# failures -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "version, call, kind, isolated",
    [(v, c, 0, False) for v in ("2.0", "3.0") for c in "gsGS"]
    + [("2.0", "g", 1, False), ("2.0", "s", 1, False), ("3.0", "g", 3, False)]
    + [("3.0", "s", 1, False), ("2.0", "g", 0, True), ("3.0", "s", 1, True)],
)
def test_a_call_that_fails_in_a_run_ends_it_with_its_message(version, call, kind, isolated):
    """A loop of reals and integers or texts; the results end before the call."""
    variables = TYPED if kind else [TYPED[0], Y]
    test = f"m->steps==5&&call=='{call}'&&first=={100 * kind}"
    a = fmu("a", variables, version, STEP="m->r[1]=1+t-0.5*m->r[0]", FAILS=f"{test}?3:0")
    b = fmu("b", variables, version, STEP="m->r[1]=m->r[0]")
    names = [("u", "y"), *([(f"u{'.ibs'[kind]}", f"y{'.ibs'[kind]}")] if kind else [])]
    wires = [line for u, y in names for line in (f"a.{y} -> b.{u}", f"b.{y} -> a.{u}")]
    with pytest.raises(ParticipantFault, match=r"a: fmi\d[SG]et.* status 3 \(error\)") as failure:
        run({"a": a, "b": b}, wires, changes={"participants.a.isolated": isolated})
    assert str(failure.value).endswith("no value here")
    # values are read at the end of the fifth step, and the others are called in the sixth one
    assert len(pc.Results("o.h5.partial").series("b.y").values) - 1 == (4 if call == "g" else 5)


def test_an_input_that_an_fmu_discards_halves_the_step():
    a = fmu("a", [TYPED[0], Y], STEP="m->r[1]=t+H", FAILS="call=='s'&&m->r[0]>0.55?2:0")
    b = fmu("b", STEP="m->r[1]=t+H")
    with pytest.raises(StepFailed, match=r"a: fmi2SetReal failed with status 2 \(discard\)"):
        run({"a": a, "b": b}, ["b.y -> a.u"])
    assert last(pc.Results("o.h5.partial"), "a.y") == pytest.approx(0.55, abs=0.1 / 64)


# warnings and saved states --------------------------------------------------------------------


def test_a_flood_of_warnings_is_counted_in_little_memory():
    flood = 'for(int k=0;k<200000;k++)logged(I,1,"value clipped to the table")'
    run({"a": fmu("a")})  # what every run needs
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    results = run({"a": fmu("a", STEP=flood)}, step="1 s")
    assert results.summary["warnings"] == ["a: t = 0 s, 200000 times: value clipped to the table"]
    # all texts together take 20 MB
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 10_000  # kB


@pytest.mark.parametrize("version", ["2.0", "3.0"])
@pytest.mark.parametrize("isolated", [False, True])
def test_warnings_are_in_summary_and_log(version, isolated, caplog):
    part = (
        'if(t>0.45)logged(I,1,t<0.55?"left its range at 0.5":"left its range at 0.6");'
        'if(t>0.65&&t<0.75)logged(I,1,"[/red] is no colour");return t>0.45'
    )
    fmu("a", version=version, STEP=part)
    Path("case.toml").write_text(
        'title = "warnings"\nwires = []\n[time]\nstop = "1 s"\nstep = "0.1 s"\n'
        f'[participants.a]\nfmu = "a.fmu"\nisolated = {str(isolated).lower()}\n'
        '[coupling]\norder = ["a"]\n'
    )
    done = call(
        "run", "case.toml", "--no-plots", "--output", ".", "--summary-json", "s.json", "--verbose"
    )
    assert done.returncode == 0, done.stderr
    listed = [
        "a: t = 0.5 s, 5 times: left its range at 0.5",
        "a: t = 0.7 s, 1 time: [/red] is no colour",
    ]
    assert pc.Results("base.h5").summary["warnings"] == listed
    words = " ".join((done.stdout + done.stderr).split())
    for line in listed:
        assert f"a: warning at {line.removeprefix('a: ')}" in words


@pytest.mark.parametrize("isolated", [False, True])
def test_warnings_before_a_failed_start_are_reported(isolated, caplog):
    part = 'void*I=m;logged(I,1,"licence ends");logged(I,3,"no file");return 3'
    own = {"participants.a.isolated": isolated}
    with caplog.at_level("INFO", logger="piston_cosim"):
        assert refused({"a": fmu("a", ENTER=part)}, changes=own) == "participants.a, no file"
        discards = part.replace("3", "2")
        assert "status 2 (discard); no file" in refused(
            {"a": fmu("a", ENTER=discards)}, changes=own
        )
    assert "a: licence ends" in caplog.text


def test_a_warning_without_a_text_is_counted():
    results = run({"a": fmu("a", STEP="return 1")})
    assert results.summary["warnings"] == [
        "a: t = 0 s, 10 times: fmi2DoStep returned a warning without a text"
    ]


# values between FMUs --------------------------------------------------------------------------


@pytest.mark.parametrize("isolated", [False, True])
def test_an_output_that_becomes_nan_is_a_step_that_cannot_be_taken(isolated):
    """It is retried once with half the step; the results end before it."""
    a = fmu("a", OUT="m->r[1]=m->t>0.42?NAN:m->t")
    words = r"t = 0.4 s, step 0.05 s: a.y: expected a finite output, got nan"
    with pytest.raises(StepFailed, match=words):
        run({"a": a}, changes={"participants.a.isolated": isolated})
    assert last(pc.Results("o.h5.partial"), "a.y") == pytest.approx(0.4)


def test_an_output_that_is_not_finite_at_the_start_is_a_warning(caplog):
    a = fmu("a", OUT="m->r[1]=m->t<0.05?INFINITY:m->t")
    results = run({"a": a})
    words = "a.y: at the start, 1 time: expected a finite output, got inf"
    assert results.summary["warnings"] == [words] and last(results, "a.y") == pytest.approx(1.0)


@pytest.mark.parametrize("parallel", [False, True])
def test_an_explicit_loop_of_gain_minus_one_is_named_with_output_and_size(parallel):
    """y_a = 1 - y_b, y_b = y_a: 1, 0, 1, 0, .. in sequence, a period of four in Jacobi's order."""
    variables = [TYPED[0], Y]
    fmu("a", variables, STEP="m->r[1]=1-m->r[0]"), fmu("b", variables, STEP="m->r[1]=m->r[0]")
    Path("case.toml").write_text(
        'title = "loop"\ntime = { stop = "3 s", step = "0.1 s" }\n'
        'participants = { a = { fmu = "a.fmu" }, b = { fmu = "b.fmu" } }\n'
        + "".join(f'[[wires]]\nfrom = "{s}.y"\nto = "{t}.u"\n' for s, t in ("ab", "ba"))
        + f'[coupling]\norder = ["a", "b"]\nmethod = "explicit"\nparallel = {parallel}\n'.lower()
    )
    assert "oscillates without damping: a change of " in "".join(check("case.toml").warnings)
    (line,) = pc.open_case("case.toml").run("o.h5").summary["warnings"]
    assert "undamped oscillation changes the output by 1 in each macro step" in line
    assert line.startswith("wire b.y -> a.u: t = ") or parallel


@pytest.mark.parametrize(
    "kind, restores, fails",
    [("i", "m->i[1]++", True), ("b", "m->b[1]=1", True), ("s", 'strcpy(m->s[1],"r")', True)]
    + [("i", "m->i[1]++", False)],
)
def test_saved_states_are_compared_by_values_of_all_types(kind, restores, fails, caplog):
    """On a wire they decide about the iteration; without one there is a message."""
    a = fmu("a", TYPED, STEP="m->r[1]=1-0.5*m->r[0]", RESTORE=f"Model*m=&I->m;{restores}")
    b = fmu("b", TYPED, STEP="m->r[1]=m->r[0]")
    wires = ["a.y -> b.u", "b.y -> a.u", *([f"a.y{kind} -> b.u{kind}"] if fails else [])]
    with caplog.at_level("INFO", logger="piston_cosim"):
        results = run({"a": a, "b": b}, wires)
    assert f"a: y{kind} differs by " in caplog.text
    assert ("treated as an FMU without saved states" in caplog.text) is fails
    assert ("loops_stepped_explicitly" in results.summary) is fails


def test_an_output_that_counts_so_far_is_no_part_of_a_state(tmp_path, monkeypatch, caplog):
    """Bodies count evaluations of repeated steps too, which says nothing of their saved states."""
    monkeypatch.chdir(tmp_path)
    case = pc.open_case("numerical_example", dict(coarse(("time.stop", "2 deg"))))
    with caplog.at_level("INFO", logger="piston_cosim"):
        assert case.run().summary["steps"] == 2
    assert "differs by" not in caplog.text
