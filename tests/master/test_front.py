"""The C front of FMUs on a toy model: in Python, and with native entries written in C."""

import ctypes
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description

from piston_cosim.master.fmi import builder, builder_native
from piston_cosim.master.fmi.block import memory_of
from piston_cosim.master.fmi.builder import build_fmu_of_file
from piston_cosim.master.fmi.compiler import FLAGS, HOME, compiler
from piston_cosim.master.fmi.errors import BadInput, CallFailed, Discard
from piston_cosim.master.fmi.native_parts import NativePart
from piston_cosim.master.fmi.noted import (
    ROOM,
    none_yet,
    refuse,
    remark,
    remark_of,
    sentences_of,
    take_over,
)
from piston_cosim.master.participants.open import open_fmu
from piston_cosim.master.participants.plain import pack, unpack

from .front_toy import SHAPE, Toy

pytestmark = pytest.mark.skipif(not compiler(), reason="no C compiler, or not Linux on x86-64")

HERE = Path(__file__).parent
U = np.array([[0.5, -1.0, 1.5], [2.0, -2.5, 3.0]])
PART = NativePart(
    entries=(),
    setup=lambda slave: memory_of({}, {"gain": 1, "state": U.size + 1, "faults": ROOM}),
    faults=(
        "x0: expected at most 100 %d, got {a}",
        "starts below 0",
        "{a} in {i}, {j} at {b} s for {c} s",
    ),
    refusal="the step to {a} s fails: ",
)


def link(path, *arguments):
    """Return the path of a library that the C compiler makes of these arguments."""
    command = [compiler(), *FLAGS, f"-I{HOME}", *map(str, arguments), "-o", str(path)]
    subprocess.run(command, check=True)
    return path


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Native libraries of the toy by version of FMI."""
    entries = [f"-Dnative_{name}=toy_{name}" for name in builder_native.ENTRIES]
    made = {}
    for version, front in builder_native.FRONTS.items():
        sources = [HOME / name for name in (*builder_native.SOURCES, front)]
        files = [*sources, HERE / "front_toy.c", "-lm"]
        path = tmp_path_factory.mktemp("library") / "toy.so"
        made[version] = link(path, *entries, "-Wall", "-Werror", *files).read_bytes()
    return made


@pytest.fixture(scope="module", params=["2.0", "3.0"])
def version(request):
    return request.param


@pytest.fixture(scope="module", params=["python", "native"])
def fmu(request, version, library, tmp_path_factory):
    """Return the toy as an FMU, in Python or native."""
    if request.param == "python":
        options = {"texts": True}
        return build_fmu_of_file(f"{HERE / 'front_toy.py'}:Toy", options, version=version)
    folder = tmp_path_factory.mktemp("toy")
    (folder / "build.json").write_text(json.dumps({}))
    slave = Toy(instance_name="toy", resources=folder)
    inside = builder_native.Inside(slave, PART, PART.setup(slave))
    members = builder_native._members(inside, {"linux64": library[version]}, version)
    members["resources/mark"] = os.urandom(8)  # not unpacked to the folder of another process
    builder.write_archive(members, folder / "front toy.fmu")
    return folder / "front toy.fmu"


@pytest.fixture
def toy(fmu):
    participant = open_fmu("toy", fmu)
    yield participant
    participant.close()


def started(toy, begin=0.0, **parameters):
    toy.start(parameters, begin, 2.0)
    toy.set("u", U)
    return toy


CREATED = "before Initialization Mode; enter Initialization Mode first"
IN_MODE = "in Initialization Mode; leave Initialization Mode first"
STARTED = "in Step Mode; reset the instance to start again"
ENDED = "after termination; reset the instance to start again"
READY = [("enter", 0.0, 2.0), ("leave",)]
AT_STEP = "expected a step at {} s, got one at {} s; restore a state to return"
CHANGING = "expected an input or a tunable parameter in Step Mode"
NO_TIMES = "expected finite times, got a step of {} s at {} s"
NO_START = "expected a finite start before the stop, got start {} s and stop {} s"
CALLS = [
    ([("step", 0.0, 0.1)], f"expected a call in Step Mode, got one {CREATED}"),
    ([("leave",)], f"expected a call in Initialization Mode, got one {CREATED}"),
    ([("end",)], f"expected a call in Step Mode, got one {CREATED}"),
    ([("derive",)], f"expected a call in Step Mode, got one {CREATED}"),
    ([("set", "x")], "expected a parameter or an input before Initialization Mode, got the output"),
    ([*READY[:1], ("step", 0.0, 0.1)], f"expected a call in Step Mode, got one {IN_MODE}"),
    ([*READY[:1], ("end",)], f"expected a call in Step Mode, got one {IN_MODE}"),
    (
        [*READY[:1], ("set", "cells")],
        "expected a parameter or an input in Initialization Mode, got",
    ),
    ([*READY[:1], ("set", "gain"), ("set", "law"), ("set", "u"), ("leave",)], ""),
    ([("enter", np.nan, 2.0)], NO_START.format("nan", 2)),
    ([("enter", 3.0, 2.0)], NO_START.format(3, 2)),
    ([("enter", 0.0, np.nan)], NO_START.format(0, "nan")),
    (
        [*READY, ("enter", 0.0, 2.0)],
        f"expected a call before Initialization Mode, got one {STARTED}",
    ),
    ([*READY, ("leave",)], f"expected a call in Initialization Mode, got one {STARTED}"),
    (
        [*READY, ("set", "gain")],
        f"{CHANGING}, got the parameter",
    ),
    (
        [*READY, ("set", "law")],
        f"{CHANGING}, got the parameter",
    ),
    (
        [*READY, ("set", "total")],
        f"{CHANGING}, got the output",
    ),
    ([*READY, ("step", 0.0, 1.0), ("step", 99.0, 1.0)], AT_STEP.format(1, 99)),
    ([*READY, ("step", 0.0, 1.0), ("step", 1.0 + 2e-6, 1.0)], AT_STEP.format(1, "1.000002")),
    ([*READY, ("step", 0.0, 1.0), ("step", 1.0 + 5e-7, 1.0)], ""),
    ([*READY, ("step", 0.0, 1.0), ("step", 1.0, 1e-10), ("step", 1.0 + 1.000005e-10, 1e-10)], ""),
    ([*READY, ("step", 0.0, 1.0), ("step", 1.0, 1.005)], ""),
    ([*READY, ("step", 0.0, 2.1)], "expected a step to at most 2 s, the stop time, got one to 2.1"),
    ([*READY, ("step", np.nan, 1.0)], NO_TIMES.format(1, "nan")),
    ([*READY, ("step", 0.0, np.nan)], NO_TIMES.format("nan", 0)),
    ([*READY, ("save",), ("step", 0.0, 1.0), ("restore",), ("step", 0.0, 1.0)], ""),
    ([*READY, ("step", 0.0, 1.0), ("save",), ("reset",), ("restore",), ("step", 1.0, 1.0)], ""),
    ([*READY, ("null",)], "expected a state of this FMU, got NULL"),
    ([*READY, ("log", "logAll"), ("log", "logStatusError")], ""),
    ([*READY, ("log", "all")], "expected a log category of the model description, got all"),
    ([*READY, ("end",), ("end",)], f"expected a call in Step Mode, got one {ENDED}"),
    ([*READY, ("end",), ("step", 0.0, 1.0)], f"expected a call in Step Mode, got one {ENDED}"),
    ([*READY, ("end",), ("set", "u")], "expected no variable after termination, got the input"),
    ([*READY, ("end",), ("reset",), *READY, ("step", 0.0, 1.0), ("end",)], ""),
]
"""Calls of a host, and what the FMU says of the last one; empty if it is allowed."""


def test_misuse_gives_one_sentence(fmu):
    """Each list of calls on an instance of its own, in a process without the source."""
    answers = edge_host(fmu, [calls for calls, _ in CALLS])
    for (calls, sentence), (statuses, words) in zip(CALLS, answers, strict=True):
        name = f"{calls}: {words}"
        assert statuses == [0] * (len(calls) - 1) + [3 if sentence else 0], name
        assert len(words) == bool(sentence) and sentence in "".join(words), name
        assert not words or re.match(r"fmi[23]\w+: expected .{20,200}$", words[0]), name


def test_misuse_without_a_c_compiler_gives_one_sentence(monkeypatch):
    """pythonfmu's library returns no status but that of a step."""
    stock = stock_fmu(monkeypatch)
    asked = [one for one in CALLS if one[0][-1][0] not in ("derive", "null", "log")]
    answers = edge_host(stock, [calls for calls, _ in asked])
    for (calls, sentence), (statuses, words) in zip(asked, answers, strict=True):
        discarded = [2] if sentence and calls[-1][0] == "step" else [0]
        assert statuses == [0] * (len(calls) - 1) + discarded, (calls, words)
        assert len(words) == bool(sentence) or calls[-1][0] == "enter"  # which is two calls
        assert sentence in "".join(words[:1]), (calls, words)


def test_exit_without_a_c_compiler_frees_nothing_twice(monkeypatch, tmp_path):
    """The second release of freed memory would find one user, and call what is no function."""
    source = tmp_path / "freed.c"
    source.write_text(
        '__attribute__((visibility("default")))'
        "void _ZdlPvm(int *p, long n) { while (n > 3) p[(n -= 4) / 4] = 1; }"
    )
    stock = stock_fmu(monkeypatch)
    monkeypatch.setenv("LD_PRELOAD", str(link(tmp_path / "freed.so", source)))
    assert edge_host(stock, [[*READY, ("step", 0.0, 1.0)]]) == [[[0, 0, 0], []]]


def stock_fmu(monkeypatch):
    """Return the toy with the library of pythonfmu."""
    with monkeypatch.context() as elsewhere:
        elsewhere.setenv("CC", "no-such-compiler")
        return build_fmu_of_file(f"{HERE / 'front_toy.py'}:Toy", {"texts": True})


def test_resources_of_another_place(fmu):
    """The sentence names the folder, and no Python."""
    ((statuses, words),) = edge_host(fmu, [[]], "/elsewhere")
    assert statuses == [3] and len(words) == 1
    assert re.match("instantiate: expected the folder resources of this FMU, got /else", words[0])


def edge_host(fmu, calls, *elsewhere):
    """Return statuses and log of each list of calls, see edge_host.py."""
    command = [sys.executable, HERE / "edge_host.py", fmu, json.dumps(calls), *elsewhere]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def is_native(toy):
    return (toy.folder / "resources/slave.bin").exists()


def test_values_steps_states_and_derivatives(toy):
    """Two steps by hand, one of them repeated from a saved state and from its bytes."""
    started(toy, gain=0.5, x0=1.0, rounds=2, law=2)
    np.testing.assert_array_equal(toy.get("x"), np.ones(SHAPE))
    assert toy.get("total") == 6.0 and toy.get("cells") == 6
    assert (toy.get("gain"), toy.get("law"), toy.get("rounds")) == (0.5, 2, 2)
    first = toy.save()
    toy.step(0.0, 0.25)
    once = 1.0 + 0.25 * U**2
    np.testing.assert_array_equal(toy.get("x"), once)
    seed = np.arange(1.0, 7.0).reshape(SHAPE)
    change = toy.derivative({"u": seed}, ["x", "total"])
    np.testing.assert_allclose(change["x"], 0.25 * 2 * U * seed, rtol=1e-15)
    assert change["total"] == pytest.approx((0.5 * U * seed).sum(), rel=1e-15)
    if toy.version == "2":  # one element alone
        (u, *_), (x, *_) = toy.fields["u"].references, toy.fields["x"].references
        assert toy._fmu.getDirectionalDerivative([x, x + 1], [u], [1.0]) == [0.25, 0.0]
    second = toy.save()
    data = toy.serialise(second)
    toy.set("u", -U)
    toy.step(0.25, 0.5)
    np.testing.assert_array_equal(toy.get("x"), once + 0.5 * U**2)
    assert toy.get("count") == 2
    for state in (second, toy.deserialise(data), second):
        toy.restore(state)
        np.testing.assert_array_equal(toy.get("x"), once)
        assert toy.get("count") >= 2  # work is not undone
        toy.set("u", U / 2)
        toy.step(0.25, 0.5)
        np.testing.assert_array_equal(toy.get("x"), once + 0.5 * (U / 2) ** 2)
    toy.restore(first)
    assert toy.get("total") == 6.0
    toy.free(first)
    toy.free(second)


def is_three(toy):
    """Return whether a toy is FMI 3.0, whose saved states contain the next event too."""
    return toy.description.fmiVersion.startswith("3")


def state_bytes(toy):
    data = toy.serialise(toy.save())
    return unpack(data)[0] if is_three(toy) else data


def state_from(toy, data):
    return toy.deserialise(pack((data, np.inf)) if is_three(toy) else data)


@pytest.mark.parametrize("law", [1, 2])
def test_a_state_of_other_parameters_is_started_again(toy, law):
    started(toy, gain=0.5, x0=1.0, law=2)
    toy.step(0.0, 0.5)
    data = state_bytes(toy)
    toy.close()
    started(toy, gain=2.0, x0=7.0, law=law)
    toy.restore(state_from(toy, data))
    np.testing.assert_array_equal(toy.get("x"), 1.0 + 0.25 * U**2)
    toy.set("u", U / 2)
    toy.step(0.5, 1.0)
    np.testing.assert_array_equal(toy.get("x"), 1.0 + 0.375 * U**2)
    changed = data[:-3] + bytes([data[-3] ^ 1]) + data[-2:]
    for damaged in (data[:-8], b"", *([changed] if is_native(toy) else ())):
        with pytest.raises(CallFailed):
            state_from(toy, damaged)


def test_a_tunable_parameter_acts_from_the_next_step_on(toy):
    started(toy, gain=0.0, extra=1.0)
    toy.step(0.0, 0.5)
    saved = toy.save()
    toy.set("extra", -0.5)
    toy.step(0.5, 0.5)
    np.testing.assert_array_equal(toy.get("x"), np.full(SHAPE, 0.25))
    toy.restore(saved)
    assert toy.get("extra") == 1.0
    toy.set("extra", 1.5)
    with pytest.raises(Discard, match="extra: expected -1 to 1 1/s, got 1.5"):
        toy.step(0.5, 0.5)


def test_a_failed_step_changes_nothing_and_says_why(toy):
    started(toy, 0.5, gain=4.0)
    state = toy.save()
    with pytest.raises(Discard) as refusal:
        toy.step(0.5, 0.1)
    reasons = "too fast"
    if is_native(toy):
        reasons = "-10 in 2, 2 at 0.5 s for 0.1 s; 12 in 2, 3 at 0.5 s for 0.1 s"
        reasons = f"the step to 0.6 s fails: {reasons}"
    assert str(refusal.value) == f"toy: {reasons}"
    toy.restore(state)
    toy.set("u", U / 4)
    toy.step(0.5, 0.125)
    np.testing.assert_array_equal(toy.get("x"), 0.125 * U)
    for step, words in ((0.0, "0 s: must be positive"), (np.inf, "inf s: must be positive")):
        with pytest.raises(Discard, match=f"step size = {words}"):
            toy.step(0.625, step)
    toy.set("u", np.where(U == -2.5, np.nan, U))
    with pytest.raises(Discard, match=re.escape("u[2,2]: expected a finite value, got nan m")):
        toy.step(0.625, 0.1)


def test_every_parameter_out_of_range_is_named(toy):
    with pytest.raises(BadInput) as refusal:
        started(toy, gain=10.5, rounds=4, law=5)
    assert refusal.value.faults == [
        "participants.toy, gain: expected 0 to 10 1/s, got 10.5 1/s",
        "participants.toy, law: expected 1 linear, 2 square, 3 cubic, got 5",
        "participants.toy, rounds: expected 1 to 3, got 4",
    ]
    with pytest.raises(BadInput, match="x0: expected at most 100 %d, got 101"):
        started(toy, x0=101.0)
    started(toy, gain=10.0, rounds=1)  # the ends of ranges are inside


def test_outputs_follow_inputs_in_initialization_mode(toy):
    toy.enter({"x0": 3.0}, 0.0, 1.0)
    assert toy.get("total") == 18.0
    toy.set("x0", 4.0)
    assert toy.get("total") == 24.0
    toy.set("gain", 99.0)
    toy.set("x0", 5.0)
    assert toy.get("total") == 24.0  # of valid parameters
    toy.set("gain", 1.0)
    toy.leave()
    assert toy.get("total") == 30.0
    toy.set("u", U)
    toy.step(0.0, 0.5)
    np.testing.assert_array_equal(toy.get("x"), 5.0 + 0.5 * U)
    toy._fmu.reset()
    toy._begun = False  # so that it is not terminated
    assert (toy._fmu.getReal if toy.version == "2" else toy._fmu.getFloat64)(
        [toy.fields["gain"].references[0]]
    ) == [2.0]


def test_wrong_references_tokens_and_calls_are_errors(toy, fmu):
    started(toy)
    fmi, gain = toy._fmu, toy.fields["gain"].references[0]
    whole, rounds = toy.fields["cells"].references[0], toy.fields["rounds"].references[0]
    real, integer = ("Real", "Integer") if toy.version == "2" else ("Float64", "Int32")
    after = max(k for v in toy.fields.values() if v.is_double for k in v.references) + 1
    wrong = [(real, 10**6), (real, rounds), (integer, gain), (integer, 10**6)]
    for kind, reference in [*wrong, *([(real, after)] if toy.version == "2" else ())]:
        with pytest.raises(CallFailed) as failure:
            getattr(fmi, f"get{kind}")([reference])
        assert failure.value.status == 3 and str(reference) in toy.log[-1][1]
        with pytest.raises(CallFailed):
            getattr(fmi, f"set{kind}")([reference], [1])
    assert getattr(fmi, f"get{integer}")([whole, rounds]) == [6, 1]
    for name in ("getBoolean", "getString"):
        with pytest.raises(CallFailed):
            getattr(fmi, name)([gain])
    if toy.version == "3":
        (u,) = toy.fields["u"].references
        assert len(fmi.getFloat64([u], 6)) == 6
        with pytest.raises(CallFailed):
            fmi.getFloat64([u], 5)
        for count in (0, 5, 7):
            with pytest.raises(CallFailed):
                fmi.setFloat64([u], [0.0] * count)
            words = f"fmi3SetFloat64: the variables have 6 elements, {count} values were given"
            assert toy.log[-1][1] == words
    derive = fmi.getDirectionalDerivative
    assert derive([gain], [gain], [1.0]) == [0.0]  # nothing follows a parameter within a step
    with pytest.raises(CallFailed):
        derive([10**6], [gain], [1.0])
    toy.description.guid = "{another}"
    with pytest.raises(BadInput, match="another.* is not the identifier of this FMU"):
        toy.start({}, 0.0, 1.0)


def test_dependencies_are_those_of_the_derivatives(toy, fmu):
    """An output depends on the input as declared, and the Python FMU alone needs a tool."""
    started(toy)
    toy.set("u", U / 2)
    toy.step(0.0, 0.25)
    change = toy.derivative({"u": np.ones(SHAPE)}, ["x", "total"])
    description = read_model_description(fmu)
    declared = {one.variable.name.partition("[")[0]: one for one in description.outputs}
    assert set(declared) == {"x", "total", "count"}
    for name, one in declared.items():
        names = ["u"] if one.dependencies is None else [v.name for v in one.dependencies]
        assert names == (["u"] if name in change and np.all(change[name]) else [])
    assert description.coSimulation.needsExecutionTool == (not is_native(toy))


def test_time_is_a_variable_of_fmi_3_and_reached_of_fmi_2(toy):
    started(toy)
    toy.set("u", U / 2)
    toy.step(0.0, 0.25)
    toy.step(0.25, 0.5)
    if toy.version == "3":
        assert toy.get("time") == 0.75
        assert toy._fmu.doStep(0.75, 0.25) == (False, False, False, 1.0)
        return
    reached = ctypes.c_double()
    toy._call("fmi2GetRealStatus", ctypes.c_int(2), ctypes.byref(reached))
    assert reached.value == 0.75


@pytest.mark.parametrize("fmu", ["python"], indirect=True)
def test_texts_and_courses(toy):
    """A text that the model rejects, and inputs whose derivatives are set for one step."""
    with pytest.raises(BadInput, match="label: expected another text"):
        started(toy, label="bad")
    started(toy, label="good", gain=1.0)
    assert toy.get("label") == "good"
    if toy.version == "3":
        return
    toy.set_course("u", np.array([U, 2 * U, 6 * U, -24 * U]) / 8)
    toy.step(0.0, 1.0)
    np.testing.assert_allclose(toy.get("x"), U / 8 * (1 + 1 + 1 - 1), rtol=1e-15)
    toy.step(1.0, 1.0)  # they are those of one step
    np.testing.assert_allclose(toy.get("x"), U / 8 * (2 + 1), rtol=1e-15)
    derivatives, number = toy._fmu.fmi2SetRealInputDerivatives, ctypes.c_uint * 1
    for name, order in (("u", 0), ("u", 4), ("x", 1)):
        reference = number(toy.fields[name].references[0])
        with pytest.raises(CallFailed):
            derivatives(
                toy._fmu.component, reference, 1, (ctypes.c_int * 1)(order), ctypes.c_double()
            )


@pytest.mark.parametrize("fmu", ["native"], indirect=True)
def test_a_warning_of_native_code_and_scarce_memory(toy):
    started(toy, x0=-1.0)
    assert [warning.text for warning in toy.warned()] == ["starts below 0"]
    toy.step(0.0, 0.1)
    assert not toy.log  # once
    toy.set("u", np.full(SHAPE, -1234.0))
    with pytest.raises(Discard, match="there is not enough memory for a step"):
        toy.step(0.1, 0.1)


def altered(data, rng):
    """Return bytes with a few other words, or cut, or with words in another order."""
    words = np.frombuffer(data[: len(data) // 8 * 8], dtype="<u8").copy()
    at = rng.integers(1, len(words), rng.integers(1, 4))
    kind = rng.integers(4)
    if kind == 0:
        words[at] = rng.choice(np.array([0, 1, 2, 2**31, 2**63, 2**64 - 1], dtype="<u8"), len(at))
    elif kind == 1:
        words[at] ^= np.uint64(1) << rng.integers(0, 64, len(at)).astype(np.uint64)
    elif kind == 2:
        words[at] = np.frombuffer(rng.normal(0.0, 1e3, len(at)).tobytes(), dtype="<u8")
    else:
        words = np.concatenate([words[: at[0]], words[at[0] :][::-1]])
    return words.tobytes()


@pytest.mark.parametrize("fmu", ["native"], indirect=True)
def test_damaged_model_files_give_a_sentence(toy):
    """The model description knows the sums of the file, so no other file goes with it."""
    path = toy.folder / "resources/slave.bin"
    whole = path.read_bytes()
    swapped = whole[:24] + whole[32:40] + whole[24:32] + whole[40:]
    flipped = whole[:-5] + bytes([whole[-5] ^ 1]) + whole[-4:]
    try:
        for file in (whole[:40], whole[:-8], whole[:-3], b"X" + whole[1:], swapped, flipped):
            path.write_bytes(file)
            with pytest.raises(BadInput, match="slave.bin is (cut short or )?damaged"):
                toy.start({}, 0.0, 1.0)
            toy.close()
    finally:
        path.write_bytes(whole)


COUNTS = [100, pytest.param(10_000, marks=pytest.mark.slow)]


@pytest.mark.parametrize("count", COUNTS)
def test_altered_states_give_a_sentence(toy, count):
    """Each of them is rejected."""
    started(toy)
    toy.step(0.0, 0.25)
    data, rng = state_bytes(toy), np.random.default_rng(2)
    for _ in range(count):
        if (state := altered(data, rng)) == data:
            continue
        toy.log.clear()
        with pytest.raises(CallFailed):
            state_from(toy, state)
        assert len(toy.log) == 1 and "expected the bytes of a state" in toy.log[0][1]


def test_addresses_of_other_instances_are_rejected(toy):
    """A freed state, and one that no FMU has given."""
    started(toy)
    state = toy.save()
    freed = ctypes.c_void_p((state[0] if is_three(toy) else state).value)
    toy.free(state)
    for wrong in (freed, ctypes.cast(ctypes.create_string_buffer(4096), ctypes.c_void_p)):
        with pytest.raises(CallFailed):
            toy.restore((wrong, np.inf) if is_three(toy) else wrong)
    assert "expected a state of this FMU, got an unknown or freed address" in toy.log[-1][1]


# ---- runtime.c


@pytest.fixture(scope="module")
def runtime(library, tmp_path_factory):
    path = tmp_path_factory.mktemp("runtime") / "toy.so"
    path.write_bytes(library["2.0"])
    runtime = ctypes.CDLL(str(path))
    none = np.zeros(0)  # the first call looks at the processor, also without an instance
    runtime.toy_allocate(ctypes.c_int64(0), pointer(none), pointer(none), ctypes.c_double(32.0))
    return runtime


def pointer(array):
    return array.ctypes.data_as(ctypes.c_void_p)


@pytest.mark.parametrize("wide", [0, 1])
def test_products_have_the_same_bits_with_all_vectors(runtime, wide):
    runtime.toy_dot.restype = ctypes.c_double
    had = runtime.toy_wide(wide)
    assert bool(had) == ("avx2" in Path("/proc/cpuinfo").read_text())
    if wide and not had:
        pytest.skip("this processor has no AVX2")
    rng = np.random.default_rng(1)
    try:
        for m, n in ((1, 1), (3, 2), (4, 4), (7, 5), (8, 9), (21, 6), (40, 7)):
            a = rng.standard_normal((m + 2, n), dtype=float).T.copy()  # columns, lead m + 2
            for turned, rows in ((b"n", n), (b"t", m)):
                x = rng.standard_normal(rows)
                y = np.full(m + n - rows, 9.0)
                sizes = ctypes.c_int64(m), ctypes.c_int64(n), pointer(a), ctypes.c_int64(m + 2)
                runtime.toy_times(ctypes.c_char(turned), *sizes, pointer(x), pointer(y))
                exact = a[:, :m] @ x if turned == b"t" else a[:, :m].T @ x
                np.testing.assert_allclose(y, exact, rtol=0, atol=1e-14)
        for n in (*range(20), 63):
            a, b = rng.standard_normal((2, n))
            lanes = np.zeros(8)
            for k in range(0, n - n % 8, 8):
                lanes += a[k : k + 8] * b[k : k + 8]
            total = 0.0
            for part in (*(a * b)[n - n % 8 :], *lanes):
                total += part
            assert runtime.toy_dot(ctypes.c_int64(n), pointer(a), pointer(b)) == total
    finally:
        runtime.toy_wide(had)


@pytest.mark.parametrize(
    "shape, strides, new, by_columns, wanted",
    [
        ((6,), (8,), (2, 3), 0, (24, 8)),
        ((2, 3), (24, 8), (6,), 0, (8,)),
        ((2, 1, 3), (24, 999, 8), (3, 2), 0, (16, 8)),
        ((2, 3), (48, 8), (6,), 0, None),
        ((2, 3), (24, 8), (6,), 1, None),
    ],
)
def test_new_shapes_of_arrays(runtime, shape, strides, new, by_columns, wanted):
    def numbers(values):
        return (ctypes.c_ssize_t * len(values))(*values)

    got = numbers([0] * len(new))
    old = ctypes.c_ssize_t(len(shape)), numbers(shape), numbers(strides)
    fits = runtime.toy_reshape(*old, ctypes.c_ssize_t(len(new)), numbers(new), got, by_columns)
    assert (tuple(got) if fits else None) == wanted


def test_blocks_of_memory_are_aligned_apart_and_used_again(runtime):
    sizes = np.array([300, 300, 512, 513, -1 - 1, 400, -1 - 0, -1 - 2, 257, 500], dtype=np.int64)
    at = np.zeros(len(sizes))
    count = ctypes.c_int64(len(sizes))
    runtime.toy_allocate(count, pointer(sizes), pointer(at), ctypes.c_double(32.0))
    assert at[5] == at[1] and at[8] == at[2] and at[9] == at[0]  # the last one freed comes first
    begins = at[[0, 1, 2, 3]]
    assert (begins > 0).all() and (begins % 64 == 0).all()
    order = np.argsort(begins)
    room = np.array([512, 512, 512, 1024])[order][:-1]
    assert (np.diff(begins[order]) >= room).all()
    many, at = np.full(12, 500), np.zeros(12)
    runtime.toy_allocate(ctypes.c_int64(12), pointer(many), pointer(at), ctypes.c_double(32.0))
    assert (at > 0).all()
    one = np.array([64], dtype=np.int64)
    runtime.toy_allocate(ctypes.c_int64(1), pointer(one), pointer(at), ctypes.c_double(128.0))
    assert at[0] == 0.0  # no such alignment


def test_noted_faults_and_warnings():
    """Faults of two lists, whose sentences are in one, and a warning next to none."""
    faults, others = none_yet(), none_yet()
    for number, of in ((0.0, faults), (1.0, faults), (0.0, others), (1.0, others)):
        refuse.py_func(of, number, 1.0, 2.0, 0.5 + number, -1e-6, 3.0)
    take_over.py_func(faults, others, 2.0)
    sentences = ["a {a} at {i}", "b {a} {b}", "c {a} at {j}", "d {c}"]
    assert sentences_of(faults, sentences) == ["a 0.5 at 1", "b 1.5 -1e-06", "c 0.5 at 2", "d 3"]
    remark.py_func(faults, 3.0)
    assert remark_of(faults, sentences) == ""  # a fault is more
    faults = none_yet()
    remark.py_func(faults, 3.0)
    assert remark_of(faults, sentences) == "d {c}" and sentences_of(faults, sentences) == []
