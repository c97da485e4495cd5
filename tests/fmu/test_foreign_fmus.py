"""FMUs of other origin, in the style of the Reference-FMUs, in a loop.

They are written in C without Python, for FMI 2.0 and 3.0.

Eq. (X3):  dx/dt = -k x + g x, backward Euler through the loop:  x_n = x_0 / (1 + H (k - g))^n
"""

import numpy as np
import pytest

from piston_cosim.master.participants.open import open_fmu

from .c_fmus import MODELS, Variable, compile_model, describe, pack
from .counter import case_text
from .runs import problems_of, run_text

STATES = (1.0, 2.0, -3.0)
DAHLQUIST = describe(
    "2.0",
    "dahlquist",
    [
        Variable("k", 0, "parameter", "Real", 'start="1"'),
        *(Variable(f"u[{i}]", i, "input", "Real", 'start="0"') for i in (1, 2, 3)),
        *(Variable(f"x[{i}]", i + 3, "output") for i in (1, 2, 3)),
        Variable("below", 0, "output", "Boolean"),
    ],
)
LENGTH = '<Dimension start="3"/>'
FEEDTHROUGH = describe(
    "3.0",
    "feedthrough",
    [
        Variable("time", 0, "independent", "Float64"),
        Variable("gain", 1, "parameter", "Float64", 'start="1"'),
        Variable("array_input", 2, "input", "Float64", 'start="0 0 0"', inside=LENGTH),
        Variable("array_output", 3, "output", "Float64", inside=LENGTH),
        Variable("integer_input", 4, "input", "Int32", 'start="0"'),
        Variable("integer_output", 5, "output", "Int32"),
        Variable("boolean_input", 6, "input", "Boolean", 'start="false"'),
        Variable("boolean_output", 7, "output", "Boolean"),
    ],
    'canSerializeFMUState="true"',
)
INPUTS = {"dahlquist": "u", "feedthrough": "array_input"}
OUTPUTS = {"dahlquist": "x", "feedthrough": "array_output"}
WIRES = [
    ("a.x", "b.array_input", "tolerance = 1e-12"),
    ("b.array_output", "a.u", "tolerance = 1e-12"),
]
MORE = """
[record]
fields = ["a.x"]
[summary]
below = "last a.below"
integer = "last b.integer_output"
boolean = "last b.boolean_output"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("foreign")
    for name, text in (("dahlquist", DAHLQUIST), ("feedthrough", FEEDTHROUGH)):
        library = folder / f"{name}.so"
        compile_model(MODELS / f"{name}.c", library)
        pack(folder / f"{name}.fmu", text, library)
    return folder


@pytest.mark.parametrize("name", INPUTS)
def test_they_are_read_and_valid_and_a_step_is_rolled_back_to_the_bit(folder, name):
    assert problems_of(folder / f"{name}.fmu") == []
    participant = open_fmu(name, folder / f"{name}.fmu")
    assert participant.can_redo and not participant.has_derivatives
    assert {f.size for f in participant.fields.values() if f.shape} == {3}
    participant.start({}, 0.0, 1.0)
    saved = participant.save()
    outputs = []
    for _ in range(2):
        participant.set(INPUTS[name], np.array([0.1, 0.2, 0.3]))
        participant.step(0.0, 0.1)
        outputs.append(participant.get(OUTPUTS[name]).tobytes())
        participant.restore(saved)
    assert outputs[0] == outputs[1]
    participant.free(saved)
    participant.close()


@pytest.mark.parametrize(
    "method, isolated",
    [
        *((method, "false") for method in ("constant", "aitken", "iqn_ils", "newton")),
        ("newton", "true"),
    ],
)
def test_a_loop_of_both_reaches_its_closed_form(folder, tmp_path, method, isolated):
    text = case_text(
        WIRES,
        method,
        step="0.01 s",
        a="k = 2.0",
        b="gain = 0.5\ninteger_input = 7\nboolean_input = true",
        fmus=("dahlquist.fmu", "feedthrough.fmu"),
        own=f"isolated = {isolated}",
        coupling="max_iterations = 60",
        more=MORE,
    )
    results = run_text(folder, text, output=tmp_path / "base.h5")
    x, summary = results.field("a.x", 1.0).values, results.summary
    # 100 steps, each within 1e-12 of the loop's fixed point
    np.testing.assert_allclose(x, np.array(STATES) / (1 + 0.01 * (2.0 - 0.5)) ** 100, atol=1e-10)
    assert summary["unconverged_steps"] == 0 and summary["mean_iterations"] > 1
    assert (summary["below"], summary["integer"], summary["boolean"]) == (1, 7, 1)
    assert not (tmp_path / "base.h5.checkpoint").exists()
