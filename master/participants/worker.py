"""Worker processes: fresh interpreters that import this package only.

The fresh processes of the standard library import the user's script again. A script without `if
__name__ == "__main__":` would then start its runs again in each of them.
"""

import os
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

GRACE_PERIOD = 1.0
"""Time that a worker has to end after the other side has closed its pipe [s]."""


class Worker:
    """Fresh process that calls `function(pipe, *arguments)`, and the pipe to it.

    Parameters
    ----------
    function : callable
        Function of a module of this package.
    *arguments
        Plain data.
    """

    def __init__(self, function: Callable[..., None], *arguments: Any) -> None:
        here, there = socket.socketpair()
        text = f"import sys; sys.path[:] = {sys.path!r}; from {__name__} import spawn_main; "
        with there:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", f"{text}spawn_main({there.fileno()})"],
                pass_fds=(there.fileno(),),
            )
        self.pipe = Connection(here.detach())
        with suppress(OSError):  # the process has ended, which the next receiver notices
            self.pipe.send((function, arguments))

    @property
    def is_alive(self) -> bool:
        return self._process.poll() is None

    def kill(self) -> None:
        """End the process immediately; call `join` afterwards."""
        self._process.kill()

    def send_signal(self, number: int) -> None:
        """Send a signal to the process if it is alive."""
        self._process.send_signal(number)

    def join(self, timeout: float | None = None) -> None:
        """Wait for the end of the process, at most `timeout` [s]."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(timeout)

    @property
    def end(self) -> str:
        """End of the process: "exit code 3" or "by SIGKILL"."""
        code = self._process.poll()
        if code is not None and code < 0:
            return f"by {signal.Signals(-code).name}"
        return f"exit code {code}"


def spawn_main(descriptor: int) -> None:
    """Call the function that the other side sends first; ignore Ctrl-C."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_follow, args=(descriptor,), daemon=True).start()
    pipe = Connection(descriptor)
    try:
        function, arguments = pipe.recv()
    except (EOFError, OSError):
        return
    function(pipe, *arguments)


def _follow(descriptor):
    """End this process after the other side has closed the pipe, even if an FMU hangs."""
    closed = select.poll()
    closed.register(descriptor, 0)  # POLLHUP only
    closed.poll()
    time.sleep(GRACE_PERIOD)
    os._exit(1)
