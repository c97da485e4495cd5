"""A model class with a fault that occurs once, when its time reaches `at`.

The fault occurs only if the file `marker` does not exist yet, and creates that file.

Eq. (X1):  dx/dt = u/2 - x + sin(2 pi t) sin(2 pi k/n),   backward Euler;
           output x, input u the other one's x
"""

import ctypes
import os
import signal
import time as clock
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from piston_cosim.master.fmi.errors import Discard
from piston_cosim.master.fmi.slave import FieldSlave
from piston_cosim.master.fmi.variables import Variable

CELLS = 400


@dataclass(frozen=True)
class State:
    x: np.ndarray


def refuse():
    raise Discard("refused on purpose")


calls = []
FAULTS = {
    "discard": refuse,
    "exception": lambda: {}["bug"],
    "hang": lambda: clock.sleep(1e6),
    "kill": lambda: os.kill(os.getpid(), signal.SIGKILL),
    "crash": lambda: ctypes.string_at(0),
    "interrupt": lambda: os.killpg(0, signal.SIGINT),
}  # as Ctrl-C does: every process of the run hears it


class Cell(FieldSlave):
    """One half of a pair."""

    name, description, state_type = "faulty_cell", "First-order lag with a fault", State

    @staticmethod
    def variables(options):
        return [
            Variable("fault", "1", "parameter", "What goes wrong", ""),
            Variable("marker", "1", "parameter", "File", ""),
            Variable("at", "s", "parameter", "When", 0.0),
            Variable("u", "1", "input", "From the other", 0.0, nominal=1.0, shape=(CELLS,)),
            Variable("x", "1", "output", "To the other", 0.0, nominal=1.0, shape=(CELLS,)),
        ]

    def start(self, values):
        return State(np.zeros(CELLS)), {"x": np.zeros(CELLS)}

    def advance(self, state, values, time, step):
        drive = np.sin(2 * np.pi * (time + step)) * np.sin(2 * np.pi * np.arange(CELLS) / CELLS)
        x = (state.x + step * (values["u"] / 2 + drive)) / (1 + step)  # Eq. (X1)
        if values["fault"] and time + step >= values["at"] and not Path(values["marker"]).exists():
            Path(values["marker"]).touch()
            x = x * np.nan if values["fault"] == "nan" else FAULTS[values["fault"]]() or x
        calls.append(time)
        return State(x), {"x": x + len(calls) % 20 if values["fault"] == "forgetful" else x}
