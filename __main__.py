"""`piston-cosim`, also as `python -m piston_cosim`."""

import os
import signal
import sys
from types import FrameType


def main() -> None:
    """Run the command line; while its modules are imported, SIGINT ends it with a message."""
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:
        signal.signal(signal.SIGINT, _stop)
    try:
        from .master.commands.app import main as command

        command()
    finally:
        signal.signal(signal.SIGINT, before)


def _stop(number: int, frame: FrameType | None) -> None:
    os.write(2, b"\nstopped: by SIGINT\n")
    os._exit(1)


if __name__ == "__main__":
    if sys.path[0] == os.getcwd():  # `python -m` would import a math.py of this folder
        del sys.path[0]
    main()
