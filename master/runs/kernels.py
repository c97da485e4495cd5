"""Compilation of kernels before a run: film and bodies in parallel, in two processes."""

from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..coupling.wiring import System
from ..fmi.errors import BadInput, Discard, ParticipantFault
from ..participants.fmi2 import FmuParticipant
from .pool import LocalPool
from .working import REFRESH_INTERVAL, Compilation, bars, every


class Rehearsal(NamedTuple):
    """Step of a single participant, with its variables on wires."""

    path: Path
    name: str
    parameters: dict[str, Any]
    begin: float
    step: float
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


def compile_kernels(systems: Iterable[System], pool: LocalPool, console) -> None:
    """Compile the kernels of all participants that run in Python, unless it was done before.

    A rehearsal that fails has no effect: the run compiles what is missing.
    """
    wanted: dict[str, Rehearsal] = {}
    marks: set[Path] = set()
    for system in systems:
        for name, one in system.participants.items():
            if type(one) is FmuParticipant and (code := _code(one)):
                marks.add(one.path.with_suffix(".compiled"))
                wanted[code] = _rehearsal(system, name, one)
    if len(wanted) < 2 or all(mark.exists() for mark in marks):
        return
    labels = {code: f"compiling {one.name}" for code, one in wanted.items()}
    with bars(console) as show:
        pool.share(
            lambda label, state: show(label, *state),
            _rehearse,
            {labels[code]: one for code, one in wanted.items()},
        )
    with suppress(OSError):
        for mark in marks:
            mark.touch()


def _code(participant: FmuParticipant) -> str:
    """Return the name of the Python code in an FMU; "" if it has none."""
    with suppress(OSError):
        return (participant.folder / "resources" / "slavemodule.txt").read_text()
    return ""


def _rehearsal(system: System, name: str, participant: FmuParticipant) -> Rehearsal:
    return Rehearsal(
        path=participant.path,
        name=name,
        parameters=dict(system.parameters[name]),
        begin=system.begin,
        step=system.step,
        inputs=tuple(wire.target[1] for wire in system.wires if wire.target[0] == name),
        outputs=tuple(
            dict.fromkeys(wire.source[1] for wire in system.wires if wire.source[0] == name)
        ),
    )


def _rehearse(send, one: Rehearsal) -> None:
    """Start a participant with its start values; take a step and a derivative if it has one."""
    compilation = Compilation(one.name)

    def tick() -> None:
        send((min(0.99, compilation.count / compilation.expected), compilation.text()))

    with every(REFRESH_INTERVAL, tick), suppress(BadInput, Discard, ParticipantFault):
        participant = FmuParticipant(one.name, one.path)
        participant.start(one.parameters, one.begin, one.begin + one.step)
        participant.step(one.begin, one.step)
        seeds = {name: np.zeros(participant.fields[name].shape) for name in one.inputs}
        if participant.has_derivatives and one.inputs and one.outputs:
            participant.derivative(seeds, one.outputs)
        participant.close()
    compilation.finish()
    send((1.0, ""))
