"""Build an FMU that needs no Python: one library for each platform.

The library consists of the participant's entries and the C front. The FMU also contains the
model description and a file that describes the model. The library does not depend on the grid,
so all FMUs of a participant have the same one. A release contains the libraries of all platforms
(`.ci/release`). If the library is missing, it is linked in a second from cached object files.
"""

import json
import os
import platform as machine
import shutil
import tempfile
import time
import warnings
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from functools import cache, lru_cache, partial
from hashlib import sha256
from importlib.metadata import version as version_of
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from . import native_code
from .builder import PACKING, code_of, packed_once, slave_of, starts_file, texts_of
from .cache import cache_folder, try_lock, write_whole
from .compiler import (
    COMMON,
    HOME,
    PLATFORMS,
    compiler_of,
    linked,
    newer_symbols,
    this_platform,
)
from .errors import BadInput, unknown
from .jobs import jobs
from .model_file import slave_file, sums_of
from .native_parts import NativePart, symbol
from .slave import FieldSlave
from .tree import ROOT, code_digest, import_part, reached, slave_class

OWN_FILES = ("builder_native.py", "model_file.py")
"""Files that determine the content of an FMU, in addition to `PACKING`."""

REPORT_INTERVAL = 4.0
"""Time between two messages about another process that compiles [s]."""

PREBUILT = Path(__file__).parent / "libraries"
"""Folder of prebuilt libraries, named by `library_name`."""

SOURCES = ("native.c", "runtime.c", "common.c")
OF_COUPLED = "parts.c"
"""Additional source of a coupled FMU, whose entries call those of its participants."""
ENTRIES = ("start", "advance", "tangent")
FRONTS = {"2.0": "fmi2.c", "3.0": "fmi3.c"}
NEW_PASSES = (0, 44)
"""First version of llvmlite with `create_pass_builder`, which native_code uses."""


def is_made_ahead(package: str) -> bool:
    """Return whether there is a prebuilt library of a package for this machine."""
    platform = this_platform()
    if platform is None or not PREBUILT.exists():
        return False
    try:
        part_of(package)
    except BadInput:
        return False
    return (PREBUILT / library_name((package,), platform, "2.0")).exists()


def build_native_fmu(
    package: str,
    options: Mapping[str, Any],
    folder: Path,
    progress: Callable[[str], object] = lambda text: None,
    version: str = "2.0",
    *,
    experiment: Any = None,
    starts: Mapping[str, Any] | None = None,
    platforms: Sequence[str] = ("linux64",),
) -> Path:
    """Return the FMU of a participant package that needs no Python, from the cache if possible.

    Parameters
    ----------
    package, options, folder, progress, version, experiment, starts
        As for `builder.build_fmu`.
    platforms : sequence of str
        Keys of `PLATFORMS`.

    Returns
    -------
    Path

    Raises
    ------
    BadInput
        With every fault of the options, including options that the library does not cover, and
        every platform without a C compiler.
    """
    part, resolved, files = check_native(package, options, folder, progress, platforms)
    made_of = {
        "build.json": json.dumps(resolved, sort_keys=True).encode(),
        **{file.name: file.read_bytes() for file in files},
        **starts_file(starts),
        **{name: (Path(__file__).parent / name).read_bytes() for name in (*PACKING, *OWN_FILES)},
        "code": code_of(package).name.encode(),
        "libraries": repr([library_name((package,), one, version) for one in platforms]).encode(),
        "version": f"{version_of('piston-cosim')} {version} {experiment!r}".encode(),
    }

    def members() -> dict[str, bytes]:
        inside = slave_inside(package, part, resolved, files, starts)
        inside.slave.experiment = experiment or inside.slave.experiment
        return _members(inside, libraries((package,), platforms, version, progress), version)

    return packed_once(f"{package}-native", made_of, members, progress)


class Inside(NamedTuple):
    """Model instance from which a native FMU is made.

    slave : instance in Python, with the variables and their positions; setup : first part of the
    model's memory.
    """

    slave: FieldSlave
    part: NativePart
    setup: np.ndarray


def pack_native_fmu(
    name: str,
    inside: Inside,
    progress: Callable[[str], object] = lambda text: None,
    version: str = "2.0",
    *,
    platforms: Sequence[str] = ("linux64",),
    package: str,
    participants: Sequence[str],
) -> Path:
    """Return the native FMU of a coupled model, from the cache if it was packed before.

    Parameters
    ----------
    name : str
        First part of the file name.
    inside : Inside
    progress, version, platforms
        As for `build_native_fmu`.
    package : str
        Package with the entries of the model.
    participants : sequence of str
        Packages whose entries they call.
    """
    built = libraries((package, *participants), platforms, version, progress)
    members = _members(inside, built, version)
    return packed_once(f"{name}-native", members, lambda: members, progress)


def _members(inside: Inside, made: Mapping[str, bytes], version: str) -> dict[str, bytes]:
    """Return the content of an FMU by path; `made` are libraries by platform."""
    slave = inside.slave
    model = slave_file(slave, inside.part, inside.setup)
    members = texts_of(slave, version, True, list(made), sums_of(model))
    for platform, library in made.items():
        ends = PLATFORMS[platform]
        members[f"binaries/{ends.folders[version]}/{slave.name}{ends.ending}"] = library
    members["resources/slave.bin"] = model
    members["resources/build.json"] = json.dumps(slave.options, sort_keys=True).encode()
    return members


def check_native(
    package: str,
    options: Mapping[str, Any],
    folder: Path,
    progress: Callable[[str], object],
    platforms: Sequence[str],
) -> tuple[NativePart, dict[str, Any], list[Path]]:
    """Return the native part of a package, its checked build options and the files that they name.

    Options that are known to be unsupported are rejected before any computation.

    Raises
    ------
    BadInput
        As `build_native_fmu`.
    """
    part = part_of(package)
    if faults := [*cannot_build(platforms, (package,)), *part.uncovered(options)]:
        raise BadInput(faults)
    resolved, files = import_part(f"{package}.build").prepare(options, Path(folder), progress)
    if faults := list(part.uncovered(resolved)):
        raise BadInput(faults)
    return part, resolved, files


def cannot_build(platforms: Sequence[str], packages: Sequence[str]) -> list[str]:
    """Return the reasons why this machine cannot build a native FMU of these packages."""
    if unknown_platforms := [name for name in platforms if name not in PLATFORMS]:
        return [f"platform: {unknown('platform', name, PLATFORMS)}" for name in unknown_platforms]
    built = [
        name
        for name in platforms
        if not all((PREBUILT / library_name(packages, name, one)).exists() for one in FRONTS)
    ]
    missing = [
        f"platform {name}: expected a C compiler, "
        + " or ".join(command[0] for command in PLATFORMS[name].compilers)
        + ", got none"
        for name in built
        if compiler_of(name) is None
    ]
    return [*missing, *too_old()] if built else []


def part_of(package: str) -> NativePart:
    """Return the `PART` of a package's module `native`; raise `BadInput` if there is none."""
    import_part(package)
    try:
        return import_part(f"{package}.native").PART
    except ModuleNotFoundError:
        raise BadInput(
            f"package: expected a package with a native FMU, got {package}; remove --native"
        ) from None


def too_old() -> list[str]:
    """Return a fault if the installed numba is too old for machine code of other platforms."""
    if tuple(map(int, version_of("llvmlite").split(".")[:2])) >= NEW_PASSES:
        return []
    return [
        f"numba: expected version 0.68 for a native FMU, got {version_of('numba')}; "
        "run pip install --upgrade numba"
    ]


def slave_inside(
    package: str,
    part: NativePart,
    options: Mapping[str, Any],
    files: Sequence[Path],
    starts: Mapping[str, Any] | None = None,
) -> Inside:
    """Return the model of a package with checked build options and the files that they name."""
    with tempfile.TemporaryDirectory() as scratch:
        (Path(scratch) / "build.json").write_text(json.dumps(options))
        for file in files:
            shutil.copy(file, scratch)
        for name, content in starts_file(starts).items():
            (Path(scratch) / name).write_bytes(content)
        slave = slave_class(slave_of(package))(instance_name="native", resources=scratch)
        if slave.string or slave.courses:
            raise BadInput(f"{package}: expected no texts in a native FMU, got some")
        return Inside(slave, part, part.setup(slave))


# ---- the library

NEEDS_NEW_GLIBC = (
    "the library needs {}, so older Linux systems cannot load it; "
    "with zig (pip install ziglang) it needs GLIBC_2.17"
)
"""Warning about a library of Linux, with the newest version that it needs."""


def libraries(
    packages: Sequence[str],
    platforms: Sequence[str],
    version: str,
    progress: Callable[[str], object] = lambda text: None,
) -> dict[str, bytes]:
    """Return the library of each platform: the prebuilt one, or one that is built here.

    Parameters
    ----------
    packages : sequence of str
        The package of the model, then those of the participants inside it.
    platforms, version, progress
        As for `build_native_fmu`.
    """
    ahead = {name: PREBUILT / library_name(packages, name, version) for name in platforms}
    missing = [name for name, path in ahead.items() if not path.exists()]
    codes = compiled_packages(packages, missing, progress) if missing else {}
    made: dict[str, bytes] = {}
    for name in platforms:
        if name not in missing:
            made[name] = ahead[name].read_bytes()
            continue
        made[name] = link(name, version, {one: files[name] for one, files in codes.items()})
        if newer := newer_symbols(made[name]):
            warnings.warn(f"{name}: {NEEDS_NEW_GLIBC.format(newer[-1])}", stacklevel=2)
    return made


def library_file(packages: Sequence[str], may_build: bool) -> Path | None:
    """Return the library of a native coupled FMU for this machine, None if there is none.

    may_build : whether to build it if no release contains it and this machine can.
    """
    platform = this_platform()
    if platform is None or platform == "win64":
        return None
    name = library_name(packages, platform, "2.0")
    if (PREBUILT / name).exists():
        return PREBUILT / name
    if not may_build or cannot_build([platform], packages):
        return None
    path = cache_folder("native") / name
    if not path.exists():
        write_whole(path, libraries(packages, [platform], "2.0")[platform])
    return path


def library_name(packages: Sequence[str], platform: str, version: str) -> str:
    """Return the name of a prebuilt library, which contains the hash of its sources."""
    ends = PLATFORMS[platform]
    digest = sha256(repr((COMMON, ends.options, native_code.TARGETS[platform])).encode())
    for one in packages:
        digest.update(_sources(one))
    headers = [path.name for path in HOME.glob("*.h")]
    for file in sorted([*_sources_in_c(version, True), *headers]):
        digest.update((HOME / file).read_bytes())
    return "-".join([*packages, platform, version, digest.hexdigest()[:16]]) + ends.ending


def _sources_in_c(version: str, is_coupled: bool) -> tuple[str, ...]:
    """Return the files in `HOME` of which a library is made."""
    return (*SOURCES, FRONTS[version], *([OF_COUPLED] if is_coupled else ()))


def compile_ahead(packages: Sequence[str], progress: Callable[[str], object]) -> None:
    """Compile the packages without a prebuilt library in parallel, if this machine can."""
    platform = this_platform()
    needed = [one for one in dict.fromkeys(packages) if not is_made_ahead(one)]
    if platform and needed and not cannot_build([platform], needed):
        compiled_packages(needed, [platform], progress)


def compiled_packages(
    packages: Sequence[str], platforms: Sequence[str], progress: Callable[[str], object]
) -> dict[str, dict[str, bytes]]:
    """Return the `object_files` of each package, compiled in parallel."""
    with ThreadPoolExecutor(jobs()) as pool:
        files = pool.map(partial(object_files, platforms=platforms, progress=progress), packages)
        return dict(zip(packages, files))


def object_files(
    package: str,
    platforms: Sequence[str],
    progress: Callable[[str], object] = lambda text: None,
) -> dict[str, bytes]:
    """Return the object file of the entries for each platform, from the cache if possible.

    If another process compiles them, wait for it.
    """
    folder = cache_folder("native")
    code = _digest_of_code(package)
    paths = {name: folder / f"{package}-{name}-{code}.o" for name in platforms}
    if not all(path.exists() for path in paths.values()):
        with sole_compiler(folder / f"{package}-{code}.lock", package, progress):
            _compile(package, paths, folder / f"{package}-{code}.ll.gz", progress)
    return {name: path.read_bytes() for name, path in paths.items()}


@contextmanager
def sole_compiler(
    path: Path, package: str, progress: Callable[[str], object]
) -> Generator[None, None, None]:
    """Hold the lock at `path`. While another process holds it, report that process and wait."""
    with open(path, "a+") as lock:
        begin = time.monotonic()
        due = begin
        while not try_lock(lock):
            if (now := time.monotonic()) >= due:
                lock.seek(0)
                holder = lock.read().strip() or "another process"
                progress(f"waiting for {holder}, which compiles {package}: {now - begin:.0f} s")
                due = now + REPORT_INTERVAL
            time.sleep(0.1)
        lock.truncate(0)
        lock.write(f"process {os.getpid()} on {machine.node()}\n")
        lock.flush()
        yield


def _compile(
    package: str, paths: Mapping[str, Path], module: Path, progress: Callable[[str], object]
) -> None:
    """Compile the missing object files."""
    missing = [name for name, path in paths.items() if not path.exists()]
    if not missing:
        return
    progress(f"compiling {package} for {', '.join(missing)}, which takes a few minutes")
    for name, data in native_code.object_files(package, missing, module, progress).items():
        write_whole(paths[name], data)


def _digest_of_code(package: str) -> str:
    """Return the digest of the kernels and of the versions that translate them."""
    versions = "".join(map(version_of, ("numba", "llvmlite"))).encode()
    return sha256(versions + _sources(package)).hexdigest()[:16]


@cache
def _sources(package: str) -> bytes:
    """Return the digests of all source files of a package's machine code."""
    files = reached(_file_of(f"{package}.native"))
    files |= {Path(native_code.__file__).resolve()}
    return b"".join(code_digest(path.read_bytes()).encode() for path in sorted(files))


def _file_of(module: str) -> Path:
    """Return the file of a module of this tree, or of an installed one, without importing it.

    The import of numba would take half a second.
    """
    for name in (f"{ROOT}.{module}", module):
        with suppress(ModuleNotFoundError):
            if (spec := find_spec(name)) and spec.origin:
                return Path(spec.origin).resolve()
    raise ModuleNotFoundError(module)


def definitions(package: str, participants: Sequence[str] = ()) -> list[str]:
    """Return the compiler options that connect the front to the entries of a package.

    They also connect the entries of a coupled FMU to those of its participants.
    """
    own = [f"-Dnative_{name}={symbol(package, name)}" for name in ENTRIES]
    inside = " ".join(f"PART({symbol(one, '')[:-1]})" for one in participants)
    iterate = f"-Dnative_iterate={symbol(package, 'iterate')}"
    return [*own, iterate, f"-DPARTS={inside}"] if inside else own


def link(platform: str, version: str, codes: Mapping[str, bytes]) -> bytes:
    """Return the library of a platform, linked from object files by package; see `linked`.

    The package of the model's entries is first, then those of the participants inside it.
    """
    return _link(platform, version, tuple(codes.items()), compiler_of(platform) or ())


@lru_cache(maxsize=8)  # a sweep packs many FMUs with few libraries
def _link(
    platform: str, version: str, codes: tuple[tuple[str, bytes], ...], command: tuple[str, ...]
) -> bytes:
    package, *participants = (name for name, _ in codes)
    with tempfile.TemporaryDirectory() as scratch:
        objects = [Path(scratch) / f"{name}.o" for name, _ in codes]
        for path, (_, code) in zip(objects, codes):
            path.write_bytes(code)
        return linked(
            [
                *command,
                *COMMON,
                *PLATFORMS[platform].options,
                *definitions(package, participants),
                *(str(HOME / name) for name in _sources_in_c(version, bool(participants))),
                *map(str, objects),
                "-lm",
            ],
            PLATFORMS[platform].ending,
        )
