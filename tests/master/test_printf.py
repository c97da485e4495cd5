"""printf arguments of log messages, against the C library's own formatting."""

import ctypes
import subprocess

import pytest

from piston_cosim.master.fmi.compiler import compiler
from piston_cosim.master.participants.printf import HEARD, Logger, printed

SOURCE = r"""
typedef void (*Log)(void *, const char *, int, const char *, const char *, ...);
void say(Log log)
{
    log(0, "i", 3, "c", "%s at %5.2f%% of %d, %ld, %+.3e", "open", 12.345, -7, 1234567890123L,
        1e-7);
    log(0, "i", 3, "c", "%x %c %*d|%-6s|%.2s %u %g %g", 255, 'z', 5, 42, "ab", "xyz", 3000000000u,
        0.5, 2.0);
    log(0, "i", 3, "c", "%s", (char *)0);
    log(0, "i", 3, "c", "nothing %% to fill");
}
"""


@pytest.mark.skipif(not (compiler() and HEARD), reason="no C compiler, or not this platform")
def test_arguments_are_filled_in(tmp_path):
    library = tmp_path / "say.so"
    command = [compiler(), "-shared", "-fPIC", "-x", "c", "-", "-o", str(library)]
    subprocess.run(command, input=SOURCE, text=True, check=True)
    heard = []
    log = Logger(lambda *given: heard.append(printed(given[4], given[5:])))
    ctypes.CDLL(str(library)).say(log)
    assert heard == [
        "open at 12.35% of -7, 1234567890123, +1.000e-07",
        "ff z    42|ab    |xy 3000000000 0.5 2",
        "(null)",
        "nothing % to fill",
    ]
