"""Affine systems in process, the master's protocol by hand, and a browser."""

import ast
from pathlib import Path

import numpy as np
import pytest

from piston_cosim.master.case.system import System, Wire
from piston_cosim.master.fmi.errors import Discard

from .browser import Browser
from .toys import Toy, variable


@pytest.fixture(scope="session")
def trees():
    """File -> syntax tree of all code of the project but its tests."""
    root = Path(__file__).parents[2]
    parts = ("fmu_ehd", "fmu_mfbd", "master", "models")
    files = [path for part in parts for path in (root / part).rglob("*.py")]
    return {path: ast.parse(path.read_text()) for path in files}


@pytest.fixture(scope="session")
def any_browser(tmp_path_factory):
    with Browser(tmp_path_factory.mktemp("profile")) as one:
        yield one


@pytest.fixture
def browser(any_browser):
    """Return a browser with an empty page, shared by all tests."""
    any_browser.reset()
    return any_browser


class Affine(Toy):
    """Participant with outputs A u + b(t) of all inputs u.

    The time t is the sum of the steps taken, so that a step repeated without rollback shows.
    Steps longer than `longest` are rejected.
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
        """Cut the vector into the outputs."""
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
        more = (None, given.get("relative_tolerance", 0.0), given.get("local_error"))
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
