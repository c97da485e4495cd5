"""The C front of an FMU. If a C compiler exists, hosts need not be Python."""

import os
import platform
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

HOME = Path(__file__).parent / "front"
SOURCES = {"2.0": ("front.c", "common.c", "fmi2.c"), "3.0": ("front.c", "common.c", "fmi3.c")}
FLAGS = (
    "-std=gnu11",
    "-D_GNU_SOURCE",
    "-O2",
    "-fPIC",
    "-shared",
    "-fvisibility=hidden",
    "-Wl,-Bsymbolic",
)


def compiler():
    """Return the path of the C compiler ($CC, else cc), or None.

    Platforms other than Linux on x86-64 have none.
    """
    if not sys.platform.startswith("linux") or platform.machine() != "x86_64":
        return None
    return shutil.which(os.environ.get("CC", "cc"))


def front_sources(version):
    """Return the sources of the front for FMI `version`, file name to bytes.

    They contribute to the identity of an FMU.
    """
    return {name: (HOME / name).read_bytes() for name in ("front.h", *SOURCES[version])}


def compile_front(version):
    """Return the shared library as bytes.

    Raises
    ------
    RuntimeError
        With the message of the compiler.
    """
    with tempfile.TemporaryDirectory() as scratch:
        library = Path(scratch) / "front.so"
        files = [str(HOME / name) for name in SOURCES[version]]
        command = [compiler(), *FLAGS, *files, "-ldl", "-lpthread", "-o", str(library)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{compiler()} could not compile the FMU's front:\n{done.stderr}")
        return library.read_bytes()
