"""SIGINT and SIGTERM during a command and during a run.

A thread receives the signals: while compiled code runs, Python calls no handler of a signal.
"""

import os
import signal
import threading
from collections.abc import Callable
from contextlib import contextmanager, suppress
from types import SimpleNamespace

SIGNALS = (signal.SIGINT, signal.SIGTERM)
GRACE_PERIOD = 0.7
"""Time after which a command ends if it does not react to a signal [s]."""
EXIT_CODE = 1
"""Exit code of a stopped command."""
_command = SimpleNamespace(
    runs=False, follows=False, forward=lambda count: None, clean=lambda: None
)
"""State of this process. `runs`: it is a command, which may exit, not the user's Python.
`follows`: it is a process of a command that forwards signals. `forward`: forwards signals to
such processes. `clean`: is called before the command exits."""


@contextmanager
def ending_soon():
    """End the command within `GRACE_PERIOD` after a signal.

    The signal raises KeyboardInterrupt; if that does not end the command, the process exits.
    """

    def ended(number: int, count: int) -> None:
        timer = threading.Timer(0.0 if count > 1 else GRACE_PERIOD, _exit, [number])
        timer.daemon = True
        timer.start()

    def interrupt(number, frame):
        raise KeyboardInterrupt(signal.Signals(number).name)

    _command.runs = True
    try:
        with _watched(interrupt, ended):
            yield
    finally:
        _command.runs = False


@contextmanager
def listening(clean: Callable[[], object] = lambda: None):
    """Yield an object that holds the `signal` that arrived, or None.

    Once the caller has set `stepped`, the macro step can end after the first signal. The second
    signal ends the process immediately, even if an FMU hangs. Before, during start and first
    compilation, the first signal ends a command.

    Parameters
    ----------
    clean : callable
        Called before a command ends that has not `stepped`.
    """
    received = SimpleNamespace(signal=None, stepped=False)
    if threading.current_thread() is not threading.main_thread():
        yield received
        return

    def note(number, frame):
        received.signal = number

    def react(number: int, count: int) -> None:
        _command.forward(count)
        if _command.runs and not received.stepped:
            _exit(number)
        _stop(number, count)

    _command.clean = clean
    try:
        with _watched(note, react):
            yield received
    finally:
        _command.clean = lambda: None


def follow_command() -> None:
    """React to SIGTERM only, and print nothing: the command of this process forwards signals."""
    _command.runs = _command.follows = True


@contextmanager
def forwarding(send: Callable[[int], object]):
    """Yield an object as `listening` does; signals go to the processes of this command.

    Parameters
    ----------
    send : callable
        Sends a signal to all processes. The first signal is sent as SIGTERM. The second one kills
        them and ends this process.
    """
    received = SimpleNamespace(signal=None, stepped=False)

    def forward(count: int) -> None:
        send(signal.SIGTERM if count == 1 else signal.SIGKILL)

    def react(number: int, count: int) -> None:
        received.signal = number
        forward(count)
        if received.stepped or count > 1:
            _stop(number, count)

    _command.forward = forward
    try:
        with _watched(lambda number, frame: None, react):
            yield received
    finally:
        _command.forward = lambda count: None
    if received.signal and not received.stepped:
        _exit(received.signal)


def _stop(number: int, count: int) -> None:
    """Print what the first signal does; end the process after the second one."""
    if count > 1:
        _print("stopped immediately; the recorded data is in the .partial file")
        os._exit(128 + number)
    _print("stopping after this macro step; repeat the signal to stop immediately")


def _exit(number: int) -> None:
    """Clean up, print the signal that stopped the command, and end the process."""
    with suppress(OSError):
        _command.clean()
    _print(f"stopped: by {signal.Signals(number).name}")
    os._exit(EXIT_CODE)


def _print(text: str) -> None:
    if not _command.follows:
        os.write(2, f"\n{text}\n".encode())


@contextmanager
def _watched(handler, react: Callable[[int, int], None]):
    """Handle signals by `handler` in this thread, and by `react(number, count)` in another one."""
    signals = (signal.SIGTERM,) if _command.follows else SIGNALS
    before = {number: signal.signal(number, handler) for number in signals}
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    woken = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    watcher = threading.Thread(target=_watch, args=(reading, react), daemon=True)
    watcher.start()
    try:
        yield
    finally:
        signal.set_wakeup_fd(woken)
        os.close(writing)
        watcher.join()
        for number, old in before.items():
            signal.signal(number, old)


def _watch(reading: int, react: Callable[[int, int], None]) -> None:
    """Count the signals that come through a pipe, until it is closed."""
    count = 0
    while number := os.read(reading, 1):
        if number[0] in SIGNALS:
            count += 1
            react(number[0], count)
    os.close(reading)
