"""Variables of toys, and their whole runs: the case, a run, one that goes on after a stop."""

import os
import signal
from types import SimpleNamespace

import h5py
import pytest

from piston_cosim.master.case.checked import check_case
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
    """A scalar without unit; `more` replaces what is known of it."""
    usual = {"shape": (), "nominal": 1.0, "unit": "1", "type": "Real", "description": ""}
    unknown = dict.fromkeys(("minimum", "maximum", "derivative_of"))
    return SimpleNamespace(**{"name": name, "causality": causality} | usual | unknown | more)


def go(system, output, watch=lambda *args: None, *, tree, **given):
    """The run's summary."""
    return run(system, check_case(tree, "case.toml"), tree, output, watch, **given)


def at(instant, do=lambda: os.kill(os.getpid(), signal.SIGINT)):
    """A watch that interrupts once a time is reached."""
    return lambda time, *others: do() if time == instant else None


def fall():
    """End a run without a word."""
    raise KeyboardInterrupt


def go_on(make, output, watch, *, tree, stopped=Interrupted):
    """The summary of a run that is stopped and goes on with fresh toys."""
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
