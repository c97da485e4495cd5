"""FMUs as other tools export them.

They run alone, have their own names and units, save no states, or have wires of every type.

Eq. (X5):  x_n = x_0 / (1 + H k)^n                  a lag alone, backward Euler
Eq. (X6):  sum over n steps of k = n (n + 1) / 2    a counter read in each step
"""

import zipfile

import numpy as np
import pytest

from piston_cosim.master.case.ssp import read_ssp
from piston_cosim.master.coupling.starting import closing
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.participants.open import open_fmu
from piston_cosim.master.runs.extremes import Extremes

from .counter import LOOP, case_text, make
from .runs import run_text

H = 0.1
STEPS = 10
LAST = "".join(
    f'{name} = "last b.{name}"\n'
    for name in ("number_sum", "truth_sum", "phase_sum", "heard_length")
)


ALONE = 1.1 ** -np.arange(STEPS + 1.0)  # Eq. (X5)


def driven(inputs):
    """Return the lag from 1 on over its steps, for these inputs, by backward Euler."""
    found = [1.0]
    for u in inputs:
        found.append((found[-1] + H * u) / (1 + H))
    return found


def solved(folder, text, changes=()):
    """Summary and results of a case."""
    results = run_text(folder, text, changes)
    return results.summary, results


def refused(folder, text):
    """Return the messages that reject a case before the run."""
    with pytest.raises(BadInput) as refusal:
        solved(folder, text)
    assert not (folder / "o.h5.partial").exists()
    return "\n".join(refusal.value.faults)


def test_extremes_of_fields_of_several_types(folder):
    """n counts the steps, so the least is that of the start. x falls as in Eq. (X5)."""
    one = open_fmu("a", folder / "a.fmu")
    with closing([one]):
        one.start({}, 0.0, 1.0)
        of_steps = Extremes([("a", "x"), ("a", "n")])
        of_steps.begin({"a": one})
        for k in range(STEPS):
            one.step(k * H, H)
            of_steps.add({"a": one})
    np.testing.assert_allclose(of_steps.high, [1.0, STEPS], rtol=1e-14)
    np.testing.assert_allclose(of_steps.low, [ALONE[-1], 0.0], rtol=1e-14)


@pytest.mark.parametrize(
    "method, own",
    [("newton", ""), ("iqn_ils", ""), ("explicit", ""), ("newton", "isolated = true")],
)
def test_wires_of_all_types_carry_values_in_the_step(folder, method, own):
    typed = [
        ("a.n", "b.number", ""),
        ("a.odd", "b.truth", ""),
        ("a.phase_out", "b.phase", ""),
        ("a.words", "b.heard", ""),
    ]
    summary, _ = solved(
        folder,
        case_text([*LOOP, *typed], method, a="k = 2.0", more=f"[summary]\n{LAST}", own=own),
    )
    counted = range(1, STEPS + 1)
    assert method == "explicit" or summary["mean_iterations"] > 1  # they survive being taken back
    assert summary["number_sum"] == STEPS * (STEPS + 1) / 2  # Eq. (X6)
    assert summary["truth_sum"] == sum(k % 2 for k in counted)
    assert summary["phase_sum"] == sum(1 + k % 3 for k in counted)
    assert summary["heard_length"] == len("step 10")


@pytest.mark.parametrize(
    "wire, words",
    [
        (("a.n", "b.u", ""), "expected equal types, got Integer and Real"),
        (
            ("a.n", "b.number", "tolerance = 1e-3"),
            "expected a wire of real numbers for tolerance, got type Integer",
        ),
        (
            ("a.n", "b.number", 'interpolation = "linear"'),
            "expected a wire of real numbers for interpolation, got type Integer",
        ),
    ],
)
def test_types_that_do_not_fit_are_refused(folder, wire, words):
    assert words in refused(folder, case_text([wire]))


def test_names_as_the_standard_allows_them(folder, library):
    names = {"x": "a.flange.y", "u": "der(s[1].x)", "number_sum": "a/b"}
    make(folder / "a.fmu", library, names=names)
    wires = [("a.a.flange.y", "b.u", ""), ("b.x", "a.der(s[1].x)", "tolerance = 1e-12")]
    text = case_text(
        wires, more='[record]\nfields = ["a.a.flange.y"]\n[summary]\nx = "last a.a.flange.y"\n'
    )
    summary, results = solved(folder, text, [('participants.a.parameters."der(s[1].x)"', 0.5)])
    plain = folder / "plain"
    plain.mkdir()
    for name in "ab":
        make(plain / f"{name}.fmu", library)
    _, same = solved(plain, case_text(LOOP), [("participants.a.parameters.u", 0.5)])
    assert summary["x"] == same.series("a.x").values[-1]
    assert np.array_equal(results.series("a.a.flange.y").values, same.series("a.x").values)
    assert {"a.a.flange.y", "a.a/b"} <= set(results.ports)
    assert results.recorded == ["a.a.flange.y"]
    assert results.series("a.a/b").values.shape == (STEPS + 1,)


DEFINITIONS = (
    '<Unit name="mm"><BaseUnit m="1" factor="0.001"/></Unit><Unit name="m"><BaseUnit m="1"/></Unit>'
    '<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>'
    '<Unit name="K"><BaseUnit K="1"/></Unit>'
    '<Unit name="cubit"><BaseUnit m="1" factor="0.5"/></Unit>'
)


@pytest.mark.parametrize(
    "first, second, gain, offset",
    [
        ("mm", "m", 1e-3, 0.0),
        ("cubit", "mm", 500.0, 0.0),
        ("degC", "K", 1.0, 273.15),
    ],
)
def test_a_wire_converts_units_by_what_the_fmus_declare(
    folder, library, first, second, gain, offset
):
    described = {"definitions": DEFINITIONS}
    make(folder / "a.fmu", library, units={"x": first, "u": first}, **described)
    make(folder / "b.fmu", library, units={"x": second, "u": second}, **described)
    wires = [("a.x", "b.u", ""), ("b.x", "a.u", "tolerance = 1e-12")]
    _, results = solved(folder, case_text(wires, b="k = 2.0", a=f'u = "1 {si_of(first)}"'))
    # (1 + H) a' = a + H (b' - offset) / gain,   (1 + 2 H) b' = b + H (gain a' + offset)
    matrix = [[1 + H, -H / gain], [-H * gain, 1 + 2 * H]]
    states = [np.ones(2)]
    for _ in range(STEPS):
        states.append(np.linalg.solve(matrix, states[-1] + [-H * offset / gain, H * offset]))
    a, b = np.transpose(states)
    # every step within 1e-12 of its fixed point; 273.15 costs three digits
    np.testing.assert_allclose(results.series("a.x").values, a, atol=1e-10)
    np.testing.assert_allclose(results.series("b.x").values, b, rtol=1e-9)


def si_of(unit):
    return {"mm": "m", "cubit": "m", "degC": "K"}.get(unit, unit)


def test_a_parameter_in_a_unit_that_only_the_fmu_knows(folder, library):
    make(folder / "a.fmu", library, units={"u": "cubit"}, definitions=DEFINITIONS)
    _, results = solved(folder, case_text([], a='u = "2 m"'))
    n = np.arange(STEPS + 1)
    # dx/dt = -x + 4 cubits from x = 1: 4 - 3 (1 + H)^-n
    np.testing.assert_allclose(results.series("a.x").values, 4 - 3 * (1 + H) ** -n, rtol=1e-13)
    assert "cubit" in refused(folder, case_text([], a='u = "2 K"'))


@pytest.mark.parametrize("can_redo", [True, False])
@pytest.mark.parametrize("where", ["wire", "coupling"])
def test_the_mean_of_both_ends_needs_no_capability(folder, library, can_redo, where):
    make(folder / "b.fmu", library, can_redo=can_redo)
    of_wire = 'interpolation = "mean"' if where == "wire" else ""
    of_coupling = "" if where == "wire" else 'inputs = "mean"'
    wires = [("a.x", "b.u", of_wire), ("a.n", "b.number", "")]  # whole numbers have no mean
    _, results = solved(folder, case_text(wires, method="explicit", more=of_coupling))
    mean = (ALONE[:-1] + ALONE[1:]) / 2  # Eq. (P10)
    np.testing.assert_allclose(results.series("b.x").values, driven(mean), rtol=1e-14)


@pytest.mark.parametrize(
    "wires, more, stop, words",
    [
        (
            [*LOOP, ("a.number_sum", "b.u", "")],
            "",
            "1 s",
            "wire to b.u: expected one source, got a.x and a.number_sum",
        ),
        (
            [],
            '[summary]\nx = "last a.words"\n',
            "1 s",
            "summary.x: expected a scalar number, got a.words, a String",
        ),
        (
            [],
            "",
            "1.05 s",
            "expected a multiple of time.step = 0.1 s, got '1.05 s'; the nearest are 1 s and 1.1 s",
        ),
        ([], "", "0.05 s", "time.stop: expected at least one step of 0.1 s, got '0.05 s'"),
    ],
)
def test_faults_of_a_case_are_heard_before_the_run(folder, wires, more, stop, words):
    assert words in refused(folder, case_text(wires, stop=stop, more=more))


def test_an_array_may_begin_at_0_or_1_and_nowhere_else(folder, library):
    sums = ("number_sum", "truth_sum", "phase_sum")
    for first in (0, 1):
        names = {name: f"sums[{k + first}]" for k, name in enumerate(sums)}
        make(folder / "a.fmu", library, names=names)
        _, results = solved(folder, case_text([], more='[record]\nfields = ["a.sums"]\n'))
        # the number and truth inputs are 0, the phase input 1 all the time
        assert results.field("a.sums", 1.0).values.tolist() == [0.0, 0.0, STEPS]
        text = case_text([], more='[summary]\nsums = "max a.sums"\n')
        assert (
            "summary.sums: expected a scalar number, got a.sums, an array of shape (3,)"
            in refused(folder, text)
        )


@pytest.mark.parametrize(
    "names, source, isolated",
    [
        ({"x": "y[2]"}, "y[2]", False),
        ({"x": "y[1]", "number_sum": "y[3]"}, "y[1]", False),
        ({"x": "y", "number_sum": "y[1]"}, "y", False),
        ({"x": "y[1]", "n": "y[2]"}, "y[1]", False),
        ({"x": "y[1]", "u": "y[2]"}, "y[1]", False),
        ({"x": "y[2]", "number_sum": "y[1]"}, "y[2]", False),
        ({"x": "y[2]", "number_sum": "y[1]"}, "y[2]", True),
    ],
)
def test_elements_with_indices_are_variables(folder, library, names, source, isolated):
    make(folder / "a.fmu", library, names=names)
    text = case_text([(f"a.{source}", "b.u", "")], own="isolated = true" * isolated)
    _, results = solved(folder, text)
    np.testing.assert_allclose(results.series(f"a.{source}").values, ALONE, rtol=1e-14)
    # a residual of the wire is below 1e-6, and here 0: nothing depends on b
    np.testing.assert_allclose(results.series("b.x").values, driven(ALONE[1:]), rtol=1e-13)


def test_an_array_and_its_elements(folder, library):
    sums = {"number_sum": "sums[1]", "truth_sum": "sums[2]", "x": "sums[3]"}
    make(folder / "a.fmu", library, names=sums)
    more = '[record]\nfields = ["a.sums", "a.sums[3]"]\n[summary]\nx = "last a.sums[3]"\n'
    summary, results = solved(folder, case_text([], more=more))
    assert summary["x"] == pytest.approx(1.1**-STEPS, rel=1e-14)  # Eq. (X5)
    assert results.field("a.sums", 1.0).values.tolist() == [0.0, 0.0, summary["x"]]
    assert "a.sums[1]" not in results.ports  # named nowhere
    make(folder / "a.fmu", library, names={"u": "in[1]", "x": "out[1]"})
    both = [("b.x", "a.in", ""), ("b.x", "a.in[1]", "")]
    assert "wire to a.in[1]: expected a wire to the array or to its elements, got both" in refused(
        folder, case_text(both)
    )


def test_units_that_differ_make_no_array(folder, library):
    units = {"x": "m", "number_sum": "K"}
    names = {"x": "y[1]", "number_sum": "y[2]"}
    make(folder / "a.fmu", library, names=names, units=units, definitions=DEFINITIONS)
    _, results = solved(folder, case_text([]))
    assert results.series("a.y[1]").unit == "m" and results.series("a.y[2]").unit == "K"


@pytest.mark.parametrize("name", ["", ".", "..", "a&#10;b"])
def test_names_that_files_do_not_like_are_recorded_and_wired(folder, library, name):
    make(folder / "a.fmu", library, names={"x": name})
    written = name.replace("&#10;", "\\n")
    _, results = solved(folder, case_text([(f"a.{written}", "b.u", "")]))
    port = "a." + name.replace("&#10;", "\n")
    assert port in results.ports
    assert results.series(port).values[-1] == pytest.approx(1.1**-STEPS, rel=1e-14)  # Eq. (X5)


def test_names_of_participants_that_results_files_cannot_hold(folder):
    text = case_text([]).replace("participants.a", "participants.fields").replace('"a"', '"fields"')
    assert (
        "expected a name of letters, digits and _ other than coupling, envelopes, fields, time, "
        "got 'fields'" in refused(folder, text)
    )


@pytest.mark.parametrize(
    "joined, wires",
    [
        ([("y[2]", "v[2]")], [("a.y[2]", "b.v[2]")]),
        ([("y[1]", "v[2]"), ("y[2]", "v[1]")], [("a.y[1]", "b.v[2]"), ("a.y[2]", "b.v[1]")]),
        ([("y[1]", "v[1]"), ("y[2]", "v[2]")], [("a.y", "b.v")]),
        ([("y[2]", "z")], [("a.y[2]", "b.z")]),
    ],
)
def test_connections_of_an_ssp_join_elements_or_whole_arrays(folder, library, joined, wires):
    make(folder / "a.fmu", library, names={"x": "y[1]", "number_sum": "y[2]"})
    make(folder / "b.fmu", library, names={"u": "v[1]", "k": "v[2]"})
    ssd = "http://ssp-standard.org/SSP1/SystemStructureDescription"
    parts = [f'<ssd:Component name="{name}" source="resources/{name}.fmu"/>' for name in "ab"]
    parts += [
        f'<ssd:Connection startElement="a" startConnector="{one}" endElement="b" '
        f'endConnector="{two}"/>'
        for one, two in joined
    ]
    with zipfile.ZipFile(folder / "x.ssp", "w") as archive:
        text = f'<ssd:System xmlns:ssd="{ssd}">{"".join(parts)}</ssd:System>'
        archive.writestr("SystemStructure.ssd", text)
        for name in "ab":
            archive.write(folder / f"{name}.fmu", f"resources/{name}.fmu")
    found = [(wire["from"], wire["to"]) for wire in read_ssp(folder / "x.ssp")["wires"]]
    assert found == wires
