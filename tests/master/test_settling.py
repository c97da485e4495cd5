"""Wires of values that are not real numbers: in the same step, also in loops.

The plant returns y = on + x, and the switch returns whether y is above a threshold or below it.
"""

from dataclasses import replace

import numpy as np
import pytest

from piston_cosim.master.coupling.components import by_components, components
from piston_cosim.master.coupling.methods import Explicit, Newton, Relaxation
from piston_cosim.master.coupling.starting import start
from piston_cosim.master.coupling.stepping import Stepper
from piston_cosim.master.coupling.wiring import HeldWire, System, Wire

from .toys import Toy, variable

METHODS = [Newton(differences=True), Relaxation(1.0, False, 9), Explicit()]


class Plant(Toy):
    def _advance(self, step):
        self.values["y"] = self.values["on"] + self.values["x"]


class Switch(Toy):
    rises = True

    def _advance(self, step):
        self.values["on"] = np.array((self.values["y"] > 0.5) == self.rises)


def boolean(name, causality):
    return variable(name, causality, type="Boolean", clocked=False)


def system(rises, extra=()):
    """Return a started system: a chain plant, switch, and a Boolean wire back."""
    names = ("x", "y", "on")
    values = {name: np.array(0.0) for name in names}
    plant = {"x": variable("x", "input"), "y": variable("y", "output")}
    switch = {"y": variable("y", "input"), "on": boolean("on", "output")}
    participants = {
        "plant": Plant("plant", plant | {"on": boolean("on", "input")}, np.zeros(0), dict(values)),
        "switch": Switch("switch", switch, np.zeros(0), dict(values)),
    }
    participants["switch"].rises = rises
    one = System(
        participants,
        ("plant", "switch"),
        (Wire(("plant", "y"), ("switch", "y"), (), "1", 1.0, np.inf, None),),
        {"plant": {"x": 1.0 if rises else 0.0}, "switch": {}},
        9.0,
        1.0,
        held=(HeldWire(("switch", "on"), ("plant", "on")), *extra),
    )
    start(one)
    return one


def advanced(one, method):
    """Return the values of plant and switch after each of two steps, and the stepper."""
    stepper = Stepper(one, by_components(method, one, 0), 0, held=one.held)
    rows = []
    for k in range(2):
        stepper.advance(float(k), 1.0)
        rows.append(
            [float(one.participants[a].get(b)) for a, b in (("plant", "y"), ("switch", "on"))]
        )
    return rows, stepper


@pytest.mark.parametrize("method", METHODS[:2])
def test_a_loop_without_real_numbers_settles(method):
    """Both wires of the loop carry values at once, as those of integers do."""
    one = system(True)
    one = replace(one, wires=(), held=(*one.held, HeldWire(("plant", "y"), ("switch", "y"))))
    rows, stepper = advanced(one, method)
    assert (rows, stepper.counters.iterations) == ([[2.0, 1.0]] * 2, [2, 1])


@pytest.mark.parametrize("method", METHODS)
def test_a_switch_in_a_loop_settles_in_the_step(method):
    """y = 1 switches on, which makes it 2; without iteration one step later."""
    rows, stepper = advanced(system(True), method)
    late = isinstance(method, Explicit)
    assert rows == [[1.0 if late else 2.0, 1.0], [2.0, 1.0]]
    assert stepper.counters.iterations == ([1, 1] if late else [2, 1])


def test_a_switch_without_a_fixed_point_is_held_named_and_counted():
    """y = 0 switches on, y = 1 switches off: each step uses the switch at its beginning."""
    rows, stepper = advanced(system(False), METHODS[0])
    ((name, warning),) = stepper.warned()
    assert name == "wire switch.on -> plant.on"
    assert warning.sentence.startswith("t = 0 s, 2 times: expected a value that settles")
    assert stepper.counters.unsettled_steps == 2
    assert rows == [[0.0, 1.0], [1.0, 0.0]]


def test_the_stepping_order_follows_discrete_wires():
    """The Boolean wire alone orders a chain: the switch steps before the plant."""
    one = replace(system(True), wires=())
    assert [part.names for part in components(one)] == [("switch", "plant")]
    one.participants["switch"].values["y"] = np.array(1.0)
    rows, _ = advanced(one, METHODS[0])
    assert rows == [[2.0, 1.0]] * 2
    clocked = replace(one, held=(replace(one.held[0], clocked=True),))
    assert [part.names for part in components(clocked)] == [("plant", "switch")]
