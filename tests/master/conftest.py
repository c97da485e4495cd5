"""A small stiff pair with closed-form steps: a mass on a squeeze film, in process, the master's
protocol by hand.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from piston_cosim.master.case.system import System, Wire
from piston_cosim.master.fmi.errors import Discard

from .browser import Browser
from .toys import Toy, variable


@pytest.fixture(scope="session")
def any_browser(tmp_path_factory):
    with Browser(tmp_path_factory.mktemp("profile")) as one:
        yield one


@pytest.fixture
def browser(any_browser):
    """A browser with an empty page, the same for all tests."""
    any_browser.reset()
    return any_browser


class Film(Toy):
    """Squeeze film of n pads: force = -c (h - h_n) / step / h^3."""

    coefficient = 2e-12  # at 10 um and 0.1 ms a fixed-point pass amplifies an error by 200

    def _advance(self, step):
        h = self.values["film"]
        self.values["force"] = -self.coefficient * (h - self.state) / step / h**3
        self.slope = -self.coefficient / step * (1 / h**3 - 3 * (h - self.state) / h**4)
        self.state = h.copy()

    def derivative(self, seeds, products):
        return {"force": self.slope * seeds["film"]}


class Mass(Toy):
    """Masses under a steady load, backward Euler: m dv/dt = force - load, film grows with v. state
    = (h, v).
    """

    mass, load = 1e-3, 0.1

    def _advance(self, step):
        h, v = self.state
        v = v + step / self.mass * (self.values["force"] - self.load)
        self.state, self.stepped = np.array([h + step * v, v]), step
        self.values["film"] = self.state[0].copy()

    def derivative(self, seeds, products):
        return {"film": self.stepped**2 / self.mass * seeds["force"]}


PADS = 7


@pytest.fixture
def pair():
    """Participants and wires of PADS masses on films, started at h = 10 um."""
    h = 1e-5 * np.linspace(0.6, 1.4, PADS)

    def fields(of_film, of_force):
        film = variable("film", of_film, shape=(PADS,), nominal=1e-5)
        return {"film": film, "force": variable("force", of_force, shape=(PADS,))}

    begin = {"film": h.copy(), "force": 0 * h}
    mass = Mass("mass", fields("output", "input"), np.array([h, 0 * h]), begin)
    film = Film("film", fields("input", "output"), h.copy(), dict(begin))
    wires = (
        Wire(("mass", "film"), ("film", "film"), (PADS,), "m", 1e-5, 1e-9, 0.3),
        Wire(("film", "force"), ("mass", "force"), (PADS,), "N", 1.0, 1e-6, None),
    )
    return SimpleNamespace(
        participants={"film": film, "mass": mass},
        order=("film", "mass"),
        wires=wires,
        parallel=False,
    )


class Affine(Toy):
    """Outputs A u + b(t) of all inputs u; t is the sum of the steps taken, so that a step taken
    twice without going back shows. Steps longer than `longest` are refused.
    """

    longest = np.inf

    def __init__(self, name, inputs, outputs, matrix, offset):
        super().__init__(name, inputs | outputs, np.zeros(1))
        self.inputs, self.outputs, self.matrix, self.offset = inputs, outputs, matrix, offset
        self.values = {key: np.zeros(field.shape) for key, field in self.fields.items()}

    def step(self, time, step):
        self.steps += 1
        if step > self.longest:
            raise Discard(f"{self.name}: refused on purpose")
        self.state = self.state + step
        u = np.concatenate([np.ravel(self.values[key]) for key in self.inputs])
        self._give(self.matrix @ u + self.offset(self.state[0]), self.values)

    def derivative(self, seeds, products):
        u = np.concatenate([np.ravel(seeds[key]) for key in self.inputs])
        return self._give(self.matrix @ u, {})

    def _give(self, vector, values):
        """The vector cut into the outputs."""
        for key, output in self.outputs.items():
            size = int(np.prod(output.shape))
            values[key], vector = vector[:size].reshape(output.shape), vector[size:]
        return values


@pytest.fixture
def affine():
    """Maker of systems whose macro step is x = A x + b(t), x = 0 at the start.

    `plant` steps first and computes A u + b from the wires echo.w0 -> plant.u0, ... [m], the
    unknowns; `echo` gives back as w what it gets by the wires plant.y0 -> echo.v0, ... [N]. The
    interface vector is (u, v). With `parallel`, both kinds of wires are unknowns.
    """

    def fields(letter, shapes, nominal, causality):
        unit = "m" if letter in "uw" else "N"
        given = ((f"{letter}{k}", *size) for k, size in enumerate(zip(shapes, nominal)))
        return {
            name: variable(name, causality, shape=shape, nominal=size, unit=unit)
            for name, shape, size in given
        }

    def make(matrix, offset, tolerance=0.1, shapes=None, nominal=None, stop=1.0, step=1.0, **given):
        matrix = np.atleast_2d(np.array(matrix, dtype=float))
        shapes = shapes or ((),) * len(matrix)
        nominal = nominal or (1.0,) * len(shapes)
        u, y, v, w = (
            fields(letter, shapes, nominal, "input" if letter in "uv" else "output")
            for letter in "uyvw"
        )
        plant = Affine("plant", u, y, matrix, lambda t: np.atleast_1d(offset(t)))
        echo = Affine("echo", v, w, np.eye(len(matrix)), lambda t: 0.0)
        parallel = given.pop("parallel", False)
        more = (None, *(given.get(key, d) for key, d in WIRE_DEFAULTS.items()))
        back = [
            Wire(("echo", f"w{k}"), ("plant", f"u{k}"), shape, "m", size, tolerance, *more)
            for k, (shape, size) in enumerate(zip(shapes, nominal))
        ]
        along = tolerance if parallel else np.inf
        forth = [
            Wire(("plant", f"y{k}"), ("echo", f"v{k}"), shape, "N", size, along, None)
            for k, (shape, size) in enumerate(zip(shapes, nominal))
        ]
        participants = {"plant": plant, "echo": echo}
        none = {"plant": {}, "echo": {}}
        return System(
            participants,
            ("plant", "echo"),
            (*back, *forth),
            none,
            stop,
            step,
            given.get("smallest_step", 0.0),
            period=given.get("period", 0.0),
            parallel=parallel,
        )

    return make


WIRE_DEFAULTS = {
    "relative_tolerance": 0.0,
    "local_error": None,
}
