"""Checkpoint of a run: enough to go on in a new process with the same bits, never damaged by a
crash.
"""

import os
import pickle
import signal
import threading
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

from ..coupling.stepping import Counters
from ..coupling.work import InterfaceWork
from ..fmi.errors import BadInput


class Interrupted(RuntimeError):
    """The run was told to stop and has left a checkpoint."""

    def __init__(self, output, time):
        super().__init__(f"interrupted at t = {time:.6g} s; {kept(output)}")


def kept(output):
    """Sentence on the checkpoint that a stopped run has left."""
    checkpoint = Checkpoint.path(output)
    if not checkpoint.exists():
        return "there is no checkpoint"
    return (
        "once the cause is gone, go on from the last checkpoint with: "
        f"piston-cosim resume {checkpoint}"
    )


@dataclass
class Account:
    """What a run has brought and taken so far: all that its summary is made of.

    counters; reductions : summary entries; work : `InterfaceWork`; spent : seconds by what they
    went into; steps_done : macro steps of the case; rows : of the results file, and wall_time [s],
    both as of the last checkpoint.
    """

    counters: Counters
    reductions: list
    work: InterfaceWork
    spent: dict
    steps_done: int = 0
    rows: int = 0
    wall_time: float = 0.0


@dataclass(frozen=True)
class Checkpoint:
    """State of a run after a macro step.

    tree, folder : resolved TOML tree, where its paths begin; frozen : participants, predictor,
    method (see `freezing`).
    """

    tree: dict
    folder: str
    frozen: bytes
    account: Account

    @staticmethod
    def path(output):
        """Where the checkpoint of a results file lies; none is written if a participant cannot
        serialise its state.
        """
        return Path(f"{output}.checkpoint")

    def write(self, output):
        """Put it beside the results file, in place of the last one in a single move."""
        target = self.path(output)
        partial = target.with_name(target.name + ".part")
        with open(partial, "wb") as file:
            pickle.dump(self, file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, target)

    @staticmethod
    def read(path):
        """The checkpoint in a file; only files of your own making: reading one can run code.
        BadInput if it is none.
        """
        try:
            with open(path, "rb") as file:
                checkpoint = pickle.load(file)
        except (OSError, pickle.UnpicklingError, EOFError, AttributeError) as error:
            raise BadInput(f"{path}: no checkpoint of this version: {error}") from None
        if not isinstance(checkpoint, Checkpoint):
            raise BadInput(f"{path}: no checkpoint")
        return checkpoint


@contextmanager
def listening():
    """SIGINT and SIGTERM are noted in `.signal` instead of ending the process, so that the macro
    step can end; the second one ends it at once, even where an FMU hangs.
    """
    heard = SimpleNamespace(signal=None)
    if threading.current_thread() is not threading.main_thread():
        yield heard
        return

    def note(number, frame):
        heard.signal = number

    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    woken = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    # a thread: while an FMU's code runs, Python calls no handler of a signal
    watcher = threading.Thread(target=_end_at_second, args=(reading,), daemon=True)
    watcher.start()
    try:
        yield heard
    finally:
        signal.set_wakeup_fd(woken)
        os.close(writing)
        watcher.join()
        for number, handler in before.items():
            signal.signal(number, handler)


def _end_at_second(reading):
    """Count the signals that come through a pipe, until it is closed."""
    heard = 0
    while number := os.read(reading, 1):
        if number[0] not in (signal.SIGINT, signal.SIGTERM):
            continue
        heard += 1
        if heard == 2:
            os.write(2, b"\nended at once; what was recorded is in the .partial file\n")
            os._exit(128 + number[0])
        os.write(2, b"\nstopping after this macro step; once more ends at once\n")
    os.close(reading)
