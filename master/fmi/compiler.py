"""Shared libraries of FMUs: their platforms, the C compilers, and the C front of Python FMUs."""

import os
import platform as machine
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from functools import cache
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from .errors import BadInput

HOME = Path(__file__).parent / "front"
AHEAD = Path(__file__).parent / "libraries"
"""Folder of prebuilt libraries, named by `library_name` or `front_name`."""


class Platform(NamedTuple):
    """Platform of an FMU, and the command that links its library.

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

OF_PYTHON = "linux64"
"""Platform of FMUs in Python."""
FRONTS = {"2.0": ("front.c", "common.c", "fmi2.c"), "3.0": ("front.c", "common.c", "fmi3.c")}
"""Sources of the C front of an FMU in Python, by version of FMI."""


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
        if found := shutil.which(command[0]):
            return (found, *command[1:])
        if command[0] == "zig" and find_spec("ziglang"):
            return (sys.executable, "-m", "ziglang", *command[1:])
    return None


def compiler() -> tuple[str, ...] | None:
    """Return the command of the C compiler for FMUs in Python; None if this machine has none."""
    return compiler_of(OF_PYTHON) if this_platform() == OF_PYTHON else None


def missing_compiler(platform: str) -> str:
    """Return the fault of a platform without a C compiler."""
    names = " or ".join(command[0] for command in PLATFORMS[platform].compilers)
    return f"platform {platform}: expected a C compiler, {names}, got none"


def link(platform: str, files: Sequence[Path | str], options: Sequence[str] = ()) -> bytes:
    """Return the library of a platform, linked from C sources, object files and libraries.

    Raises
    ------
    RuntimeError
        With the message of the compiler.
    """
    with tempfile.TemporaryDirectory() as scratch:
        library = Path(scratch) / f"library{PLATFORMS[platform].ending}"
        flags = (*COMMON, *PLATFORMS[platform].options, *options)
        command = [*(compiler_of(platform) or ()), *flags, *map(str, files), "-o", str(library)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"{command[0]} could not link an FMU's library:\n{done.stderr}")
        return library.read_bytes()


def newer_symbols(library: bytes) -> list[str]:
    """Return the symbol versions of an ELF library that are newer than `OLDEST_GLIBC`."""
    versions = {
        tuple(map(int, text.split(b"."))) for text in re.findall(rb"GLIBC_(\d+(?:\.\d+)*)", library)
    }
    return [f"GLIBC_{'.'.join(map(str, v))}" for v in sorted(versions) if v > OLDEST_GLIBC]


def front_name(version: str) -> str:
    """Return the name of a prebuilt front, which contains the hash of its sources."""
    digest = sha256(repr((COMMON, PLATFORMS[OF_PYTHON].options)).encode())
    for name in ("front.h", *FRONTS[version]):
        digest.update((HOME / name).read_bytes())
    return f"front-{OF_PYTHON}-{version}-{digest.hexdigest()[:16]}.so"


@cache
def front(version: str) -> bytes:
    """Return the C front of an FMU in Python: the prebuilt one, or one that is linked here.

    Raises
    ------
    BadInput
        If there is neither a prebuilt one nor a C compiler.
    RuntimeError
        With the message of the compiler.
    """
    if (ahead := AHEAD / front_name(version)).exists():
        return ahead.read_bytes()
    if compiler() is None:
        raise BadInput(f"{missing_compiler(OF_PYTHON)}; run pip install ziglang")
    return link(OF_PYTHON, [*(HOME / name for name in FRONTS[version]), "-ldl", "-lpthread"])
