"""Guard against FMUs that end this process.

C's exit() inside an FMU ends the process with the FMU's exit code, which may be 0. The guard is a
handler of C's `atexit`: it prints which participant called exit() and ends with exit code 1.
"""

import atexit
import ctypes
import os
import sys
from contextlib import suppress
from functools import cache
from typing import Any
from weakref import WeakSet

HANDLER = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
EXIT_CODE = 1

_started: WeakSet[Any] = WeakSet()


def guard_exit(participant: Any) -> None:
    """Guard a participant whose FMU will be loaded into this process."""
    _started.add(participant)
    _register()


@cache
def _register():
    """Register the handler once per process; only glibc and macOS can withdraw it."""
    if sys.platform != "darwin" and "CS_GNU_LIBC_VERSION" not in os.confstr_names:
        return
    libc, key = ctypes.CDLL(None), ctypes.create_string_buffer(1)
    handler = HANDLER(lambda _: _stop(list(_started)))
    libc.__cxa_atexit(handler, None, key)

    def withdraw(keep=(handler, key)):
        if calling := _calling():  # sys.exit() inside an FMU written in Python
            _stop([calling])
        _started.clear()
        libc.__cxa_finalize(key)

    atexit.register(withdraw)


def _stop(started):
    """Print which participant called exit(), and end the process; return if Python ends."""
    if not started:
        return
    calling = _calling()
    names = [calling.name] if calling else sorted(one.name for one in started)
    text = (
        f"\nstopped: {' or '.join(names)}: the FMU called exit(), which ends this process; "
        "there are no finished results.\n"
        f"  With participants.{names[0]}.isolated = true the FMU ends its own process only.\n"
    )
    with suppress(Exception):
        sys.stdout.flush()
    os.write(2, text.encode())
    os._exit(EXIT_CODE)


def _calling():
    """Return the participant whose FMU this thread is calling, or None."""
    frame = sys._getframe()
    while frame:
        one = frame.f_locals.get("self")
        if any(one is started for started in _started):
            return one
        frame = frame.f_back
    return None
