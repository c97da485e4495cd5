"""A small stiff pair with closed-form steps: a mass on a squeeze film, in process, the master's
protocol by hand.
"""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest
from piston_cosim.master.case.system import Wire
from piston_cosim.master.fmi.errors import Discard


def variable(shape, nominal, causality):
    return SimpleNamespace(
        shape=shape, nominal=nominal, unit="1", causality=causality, type="Real", description=""
    )


@dataclass
class Toy:
    """Protocol with states as plain copies; subclasses give `_advance` and `derivative`."""

    name: str
    fields: dict
    state: np.ndarray
    values: dict = field(default_factory=dict)
    has_derivatives: bool = True
    refuse: int = 0
    steps: int = 0

    def set(self, name, value):
        self.values[name] = np.array(value, dtype=float)

    def get(self, name):
        return self.values[name]

    def save(self):
        return self.state.copy(), {k: v.copy() for k, v in self.values.items()}

    def restore(self, saved):
        self.state, self.values = saved[0].copy(), {k: v.copy() for k, v in saved[1].items()}

    def free(self, saved):
        pass

    def step(self, time, step):
        self.steps += 1
        if self.refuse > 0 and step > 0.6e-4:
            self.refuse -= 1
            raise Discard(f"{self.name}: refused on purpose")
        self._advance(step)


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
    mass = Mass(
        "mass",
        {"film": variable((PADS,), 1e-5, "output"), "force": variable((PADS,), 1.0, "input")},
        np.array([h, 0 * h]),
        {"film": h.copy(), "force": 0 * h},
    )
    film = Film(
        "film",
        {"film": variable((PADS,), 1e-5, "input"), "force": variable((PADS,), 1.0, "output")},
        h.copy(),
        {"film": h.copy(), "force": 0 * h},
    )
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
