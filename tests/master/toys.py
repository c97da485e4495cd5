"""Variables of toys, and their whole runs: the case, a run, one that goes on after a stop."""

import os
import signal
from dataclasses import dataclass, field
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.participants.plain import pack, unpack
from piston_cosim.master.runs.checkpoint import Checkpoint, Interrupted
from piston_cosim.master.runs.run import run


def wires(count):
    """So many of either kind."""
    ends = (("echo.w", "plant.u"), ("plant.y", "echo.v"))
    return [{"from": f"{a}{k}", "to": f"{b}{k}"} for a, b in ends for k in range(count)]


TOYS = {
    "title": "Toys",
    "participants": {"plant": {"fmu": "plant.fmu"}, "echo": {"fmu": "echo.fmu"}},
    "wires": wires(1),
    "coupling": {"order": ["plant", "echo"], "method": "constant", "relaxation": 1.0},
}
"""Case of the toys of the fixture `affine`, without its times."""


def variable(name, causality, **more):
    """Return a scalar without unit; `more` replaces attributes."""
    usual = {"shape": (), "nominal": 1.0, "unit": "1", "type": "Real", "description": ""}
    unknown = dict.fromkeys(("minimum", "maximum", "derivative_of"))
    return SimpleNamespace(**{"name": name, "causality": causality} | usual | unknown | more)


@dataclass
class Toy:
    """Protocol with states as plain copies; subclasses give `_advance` and `derivative`."""

    name: str
    fields: dict
    state: np.ndarray
    values: dict = field(default_factory=dict)
    steps: int = 0
    has_derivatives = can_redo = can_serialise = declares_units = True
    can_interpolate = False

    def enter(self, parameters, start_time, stop_time):
        self.values |= {key: np.array(value, dtype=float) for key, value in parameters.items()}

    def ignore(self, *given):
        """Do nothing."""

    leave = free = close = ignore

    def set(self, name, value):
        self.values[name] = np.array(value, dtype=float)

    def get(self, name):
        return self.values[name]

    def get_many(self, names):
        return {name: float(self.get(name)) for name in names}

    def step(self, time, step):
        self.steps += 1
        self._advance(step)

    def save(self):
        return self.state.copy(), {k: v.copy() for k, v in self.values.items()}

    def restore(self, saved):
        self.state, self.values = saved[0].copy(), {k: v.copy() for k, v in saved[1].items()}

    def serialise(self, saved):
        return pack(saved)

    def deserialise(self, data):
        return unpack(data)


def go(system, output, watch=lambda *args: None, *, tree, **given):
    """Run a system and return the summary."""
    return run(system, check_case(tree, "case.toml"), tree, output, watch, **given)


def at(instant, do=lambda: os.kill(os.getpid(), signal.SIGINT)):
    """Return a watch that interrupts once a time is reached."""
    return lambda time, *others: do() if time == instant else None


def fall():
    """End a run without a word."""
    raise KeyboardInterrupt


def go_on(make, output, watch, *, tree, stopped=Interrupted):
    """Stop a run, resume it with fresh toys and return the summary."""
    with pytest.raises(stopped):
        go(make(), output, watch, tree=tree)
    return go(make(), output, tree=tree, begin_at=Checkpoint.read(Checkpoint.path(output)))


def contents(path):
    """Every dataset of a results file."""
    datasets = {}

    def note(name, item):
        if isinstance(item, h5py.Dataset):
            datasets[name] = item[:].tolist()

    with h5py.File(path, "r") as file:
        file.visititems(note)
    return datasets
