"""A participant's directional derivative belongs to a step or to a communication point.

The cells have closed-form steps and provide one or the other.

Eq. (X10):  x1 = (x0 + H g u) / (1 + H),   y = x1:   dy/du = H g / (1 + H) over a step,
            0 at a communication point
"""

from dataclasses import replace

import numpy as np
import pytest

from piston_cosim.master.coupling.methods import Newton, Relaxation
from piston_cosim.master.coupling.negotiation import by_differences, objections, sentences
from piston_cosim.master.coupling.stepping import Stepper
from piston_cosim.master.coupling.wiring import Wire
from piston_cosim.master.fmi.errors import Discard, ParticipantFault
from piston_cosim.master.participants.derivatives import DIFFERENT, SILENT, Differenced, objection

from .toys import Toy, variable

H = 0.1
GAIN = 3.0
SLOPE = H * GAIN / (1 + H)


class Cell(Toy):
    """Cell of Eq. (X10).

    `respond(u, steps taken)` is the effect of the input, `answer` its own derivative by u.
    """

    def __init__(self, answer=SLOPE, respond=lambda u, count: GAIN * u, start=0.0):
        fields = {"u": variable("u", "input"), "y": variable("y", "output")}
        values = {"u": np.array(0.0), "y": np.array(start)}
        super().__init__("cell", fields, np.array([start, 0.0]), values)
        self.answer, self.respond = answer, respond

    def _advance(self, step):
        x, count = self.state
        y = (x + step * self.respond(float(self.values["u"]), count)) / (1 + step)
        self.state, self.values["y"] = np.array([y, count + 1]), np.array(y)

    def derivative(self, seeds, products):
        if self.answer is None:
            raise ParticipantFault("cell: no derivative for you")
        slope = self.answer(self) if callable(self.answer) else self.answer
        return {"y": slope * np.asarray(seeds["u"])}


def asked(cell):
    return objection(cell, ["u"], ["y"], H)


@pytest.mark.parametrize("start", [0.0, 1.0])
def test_the_step_maps_derivative_is_believed_and_costs_two_steps(start):
    cell = Cell(start=start)
    assert asked(cell) == ""
    assert cell.steps == 2  # one to be at, one changed


@pytest.mark.parametrize("answer", [0.0, GAIN, -SLOPE, 0.8 * SLOPE, np.nan])
def test_another_derivative_is_not(answer):
    cell = Cell(answer, start=0.7)
    before = cell.save()
    assert asked(cell) == DIFFERENT
    assert cell.steps == 9  # three places, each with one step to be at and two changes
    np.testing.assert_array_equal(cell.state, before[0])
    assert cell.values == before[1]


def test_an_error_is_an_objection_with_its_words():
    assert "no derivative for you" in asked(Cell(None))


def test_no_response_at_all_is_not_believed():
    assert asked(Cell(0.0, lambda u, count: 0.0)) == SILENT


def late(u, count):
    """From the second step on (count 1) the input acts."""
    return GAIN * u * (count >= 1)


def contact(u, count):
    """At u = 0 the derivative of one side differs from a difference to the other."""
    return GAIN * max(u, 0.0)


def curved(u, count):
    """Return a response that curves within a hundredth of the nominal value."""
    return np.sin(300 * u)


class Rounded(Cell):
    """A solver that stops early: a change of 1e-5 is answered by noise, one of 1e-2 is not."""

    def _advance(self, step):
        super()._advance(step)
        self.values["y"] = np.round(self.values["y"], 5)


@pytest.mark.parametrize(
    "honest, other",
    [
        (Cell(lambda cell: SLOPE * (cell.state[1] >= 2), late), Cell(0.0, late)),
        (Cell(lambda cell: SLOPE * (float(cell.values["u"]) > 0), contact), Cell(0.0, contact)),
        (
            Cell(lambda cell: H / (1 + H) * 300 * np.cos(300 * float(cell.values["u"])), curved),
            Cell(0.0, curved),
        ),
        (Rounded(), Rounded(0.0)),
        # ten per cent are good enough for Newton
        (Cell(0.92 * SLOPE), Cell(0.88 * SLOPE)),
    ],
    ids=["late", "kink", "curved", "rounded", "ten per cent"],
)
def test_the_cell_s_own_derivative_is_believed_and_no_other(honest, other):
    assert asked(honest) == ""
    assert asked(other) == DIFFERENT


def test_a_refused_step_is_an_objection():
    class Refusing(Cell):
        def step(self, time, step):
            raise Discard("not today")

    assert "not today" in asked(Refusing())


def test_an_input_with_little_influence_is_tried_by_itself():
    """y = u + 0.01 v: a derivative that forgets v is off by a hundredth of the whole."""

    class Two(Cell):
        def __init__(self, forgets):
            super().__init__()
            self.fields["v"] = variable("v", "input")
            self.values["v"] = np.array(0.0)
            self.forgets = forgets

        def _advance(self, step):
            self.values["y"] = self.values["u"] + 0.01 * self.values["v"]

        def derivative(self, seeds, products):
            return {"y": seeds["u"] + (not self.forgets) * 0.01 * seeds["v"]}

    assert objection(Two(False), ["u", "v"], ["y"], H) == ""
    assert objection(Two(True), ["u", "v"], ["y"], H) == DIFFERENT


def test_newton_goes_on_by_differences(affine):
    """Newton continues by differences if a derivative is wrong: x = 3 x + 1, x = -0.5.

    With a derivative of 0 a pass triples the error; with differences one Newton step is exact.
    """
    system = affine([[3.0]], lambda t: 1.0, 1e-6)
    plant = system.participants["plant"]
    plant.derivative = lambda seeds, products: {"y0": np.zeros(())}
    objected = objections(system, Newton())
    assert objected == {"plant": DIFFERENT, "echo": ""}
    (line,) = sentences(objected)
    assert line.startswith("plant: ") and "differences" in line
    negotiated = by_differences(system, objected)
    assert isinstance(negotiated.participants["plant"], Differenced)
    assert negotiated.participants["echo"] is system.participants["echo"]
    stepper = Stepper(negotiated, Newton(), 0)
    stepper.advance(0.0, 1.0)
    assert stepper.predictor.past[-1][1] == pytest.approx([-0.5, -0.5], rel=1e-6)
    assert stepper.counters.iterations == [2]


@pytest.mark.parametrize("method", [Newton(differences=True), Relaxation(1.0, False, 9)])
def test_what_needs_no_derivative_tries_none(affine, method):
    system = affine([[3.0]], lambda t: 1.0)
    assert objections(system, method) == {}
    assert system.participants["plant"].steps == 0


def test_an_output_off_every_loop_needs_no_derivative(affine):
    """A source that feeds the plant is not asked: it has no wired input."""
    system = affine([[3.0, 1.0], [0.0, 0.0]], lambda t: np.array([1.0, 0.0]), 1e-6)
    source = Cell(None, lambda u, count: 11.0)  # (0 + 11 * 1) / (1 + 1) = 5.5 after one second
    wires = list(system.wires)
    wires[1] = Wire(("source", "y"), ("plant", "u1"), (), "m", 1.0, np.inf, None)
    system = replace(
        system,
        participants={"source": source, **system.participants},
        order=("source", *system.order),
        wires=tuple(wires),
    )
    assert set(objections(system, Newton())) == {"plant", "echo"}
    stepper = Stepper(system, Newton(), 0)
    stepper.advance(0.0, 1.0)
    # x = 3 x + 5.5 + 1
    assert stepper.predictor.past[-1][1][0] == pytest.approx(-3.25, rel=1e-6)
