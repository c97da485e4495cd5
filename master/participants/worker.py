"""Worker processes: fresh interpreters that import this package alone.

The standard library's fresh processes import the user's script again. A script without
`if __name__ == "__main__":` would then start its runs again in each of them.
"""

import mmap
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

import numpy as np

GRACE = 1.0
"""Seconds that a worker has to end by itself when the other side has closed its pipe."""


class Worker:
    """A fresh process that calls `function(pipe, *arguments)`, and the pipe to it.

    Parameters
    ----------
    function : callable
        Of a module of this package.
    *arguments
        Plain data.
    files : sequence of int
        File descriptors that the process shares, under the same numbers.
    """

    def __init__(
        self, function: Callable[..., None], *arguments: Any, files: Sequence[int] = ()
    ) -> None:
        here, there = socket.socketpair()
        text = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import spawn_main; "
        with there:
            self._process = subprocess.Popen(
                [sys.executable, "-c", f"{text}spawn_main({there.fileno()})"],
                pass_fds=(there.fileno(), *files),
            )
        self.pipe = Connection(here.detach())
        with suppress(OSError):  # it is gone: whoever receives from it finds out
            self.pipe.send((function, arguments))

    @property
    def is_alive(self) -> bool:
        return self._process.poll() is None

    def kill(self) -> None:
        """End it at once; `join` it then."""
        self._process.kill()

    def send_signal(self, number: int) -> None:
        """Send it a signal, if it is alive."""
        self._process.send_signal(number)

    def join(self, timeout: float | None = None) -> None:
        """Wait for its end, for `timeout` [s] at most."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout)

    @property
    def end(self) -> str:
        """How it ended: "exit code 3" or "by SIGKILL"."""
        code = self._process.poll()
        if code is not None and code < 0:
            return f"by {signal.Signals(-code).name}"
        return f"exit code {code}"


def spawn_main(descriptor: int) -> None:
    """Call what the other side sends first; Ctrl-C is for the other side."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_follow, args=(descriptor,), daemon=True).start()
    pipe = Connection(descriptor)
    try:
        function, arguments = pipe.recv()
    except (EOFError, OSError):
        return
    function(pipe, *arguments)


def _follow(descriptor):
    """End this process when the other side has closed the pipe, even if an FMU hangs."""
    closed = select.poll()
    closed.register(descriptor, 0)  # POLLHUP alone
    closed.poll()
    time.sleep(GRACE)
    os._exit(1)


def shared_file(count: int) -> int:
    """Return the descriptor of a file in memory for `count` numbers of 64 bits."""
    if hasattr(os, "memfd_create"):
        descriptor = os.memfd_create("fields")
    else:
        with tempfile.TemporaryFile() as file:
            descriptor = os.dup(file.fileno())
    os.ftruncate(descriptor, 8 * max(1, count))
    return descriptor


def shared_numbers(descriptor: int) -> np.ndarray:
    """Return the numbers of a `shared_file`, and close its descriptor."""
    memory = mmap.mmap(descriptor, 0)
    os.close(descriptor)
    return np.frombuffer(memory)
