"""C compilers: of the front of Python FMUs on this machine, and of native FMUs by platform.

If a C compiler exists, hosts of Python FMUs need not be Python.
"""

import os
import platform as machine
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

HOME = Path(__file__).parent / "front"
SOURCES = {"2.0": ("front.c", "common.c", "fmi2.c"), "3.0": ("front.c", "common.c", "fmi3.c")}


class Platform(NamedTuple):
    """Platform of a native FMU, and the command that links its library.

    compilers : alternative commands of C compilers, the preferred one first; ending : suffix of the
    library; folders : folder of the library in an FMU, by version of FMI.
    """

    compilers: tuple[tuple[str, ...], ...]
    options: tuple[str, ...]
    ending: str
    folders: Mapping[str, str]


def _zig(target: str, *options: str) -> tuple[str, ...]:
    """Return the command of zig, which contains the headers and libraries of all platforms.

    It is installed with `pip install ziglang`.
    """
    return ("zig", "cc", "-target", target, *options)


def _zig_for_linux(processor: str) -> tuple[str, ...]:
    """Return the command of zig with the oldest glibc and without its run-time library.

    The sin, cos and memcpy of that library would replace those of the system.
    """
    return _zig(f"{processor}-linux-gnu.{'.'.join(map(str, OLDEST_GLIBC))}", "-rtlib=none")


OLDEST_GLIBC = (2, 17)
"""Oldest version of glibc that release libraries support: that of RHEL 7."""

COMMON = ("-std=gnu11", "-O2", "-ffp-contract=off", "-shared")
ELF = ("-fPIC", "-fvisibility=hidden", "-Wl,-Bsymbolic", "-Wl,-z,noexecstack", "-Wl,-S")
MACH_O = ("-fPIC", "-fvisibility=hidden")
PLATFORMS = {
    "linux64": Platform(
        (_zig_for_linux("x86_64"), (os.environ.get("CC", "cc"),)),
        ELF,
        ".so",
        {"2.0": "linux64", "3.0": "x86_64-linux"},
    ),
    "win64": Platform(
        (
            _zig("x86_64-windows-gnu"),
            ("x86_64-w64-mingw32-gcc", "-static-libgcc", "-static"),
        ),
        ("-D__USE_MINGW_ANSI_STDIO=1",),
        ".dll",
        {"2.0": "win64", "3.0": "x86_64-windows"},
    ),
    "aarch64-linux": Platform(
        (_zig_for_linux("aarch64"), ("aarch64-linux-gnu-gcc",)),
        ELF,
        ".so",
        {"2.0": "aarch64-linux", "3.0": "aarch64-linux"},
    ),
    "darwin64": Platform(
        (_zig("x86_64-macos.11.0"),),
        MACH_O,
        ".dylib",
        {"2.0": "darwin64", "3.0": "x86_64-darwin"},
    ),
    "aarch64-darwin": Platform(
        (_zig("aarch64-macos.11.0"),),
        MACH_O,
        ".dylib",
        {"2.0": "aarch64-darwin", "3.0": "aarch64-darwin"},
    ),
}
"""Platforms by name, as in `native_code.TARGETS`."""
FLAGS = ("-std=gnu11", "-D_GNU_SOURCE", "-O2", "-shared", *MACH_O, "-Wl,-Bsymbolic")
"""Options for the front of Python FMUs."""


def this_platform() -> str | None:
    """Return the name of this machine's platform; None if native FMUs do not support it."""
    machines = {
        ("Linux", "x86_64"): "linux64",
        ("Linux", "aarch64"): "aarch64-linux",
        ("Windows", "AMD64"): "win64",
        ("Darwin", "x86_64"): "darwin64",
        ("Darwin", "arm64"): "aarch64-darwin",
    }
    return machines.get((machine.system(), machine.machine()))


def compiler_of(platform: str) -> tuple[str, ...] | None:
    """Return the command of the C compiler for a platform, None if there is none."""
    for command in PLATFORMS[platform].compilers:
        if path := shutil.which(command[0]):
            return (path, *command[1:])
        if command[0] == "zig" and find_spec("ziglang"):
            return (sys.executable, "-P", "-m", "ziglang", *command[1:])
    return None


def compiler() -> str | None:
    """Return the path of the C compiler for the front of Python FMUs ($CC, else cc), or None.

    Platforms other than Linux on x86-64 have none.
    """
    return shutil.which(os.environ.get("CC", "cc")) if this_platform() == "linux64" else None


def front_sources(version: str) -> dict[str, bytes]:
    """Return the sources of the front for FMI `version`, file name to bytes.

    They contribute to the identity of an FMU.
    """
    return {name: (HOME / name).read_bytes() for name in ("front.h", *SOURCES[version])}


def compile_front(version: str) -> bytes:
    """Return the front of a Python FMU; see `linked`."""
    return _compile_front(version, compiler() or "cc")


@cache
def _compile_front(version: str, command: str) -> bytes:
    files = [str(HOME / name) for name in SOURCES[version]]
    return linked([command, *FLAGS, *files, "-ldl", "-lpthread"])


def linked(command: Sequence[str], ending: str = ".so") -> bytes:
    """Return the shared library that a command of a C compiler makes.

    Raises
    ------
    RuntimeError
        With the message of the compiler.
    """
    with tempfile.TemporaryDirectory() as scratch:
        library = Path(scratch) / f"slave{ending}"
        done = subprocess.run([*command, "-o", str(library)], capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{command[0]} could not link the library of an FMU:\n{done.stderr}")
        return library.read_bytes()


def newer_symbols(library: bytes) -> list[str]:
    """Return the symbol versions of an ELF library that are newer than `OLDEST_GLIBC`."""
    versions = {
        tuple(map(int, text.split(b"."))) for text in re.findall(rb"GLIBC_(\d+(?:\.\d+)*)", library)
    }
    return [f"GLIBC_{'.'.join(map(str, v))}" for v in sorted(versions) if v > OLDEST_GLIBC]
