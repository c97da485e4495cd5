"""Libraries of native FMUs: those of a release and those for macOS.

Those of a release are used as they are. Those for macOS export the functions that a host calls
and need its system library alone.
"""

import struct
import zipfile
from pathlib import Path

import pytest

from piston_cosim.master.fmi import builder_native, compiler
from piston_cosim.master.fmi.builder_native import build_native_fmu, library_name
from piston_cosim.master.fmi.compiler import PLATFORMS, compiler_of, newer_symbols
from piston_cosim.master.fmi.errors import BadInput

GRID = {"grid": [8, 6]}
MACS = {"darwin64": 0x01000007, "aarch64-darwin": 0x0100000C}  # CPU_TYPE_X86_64, CPU_TYPE_ARM64


@pytest.fixture
def brought(monkeypatch, tmp_path):
    """Return a folder of prebuilt libraries, on a machine that can compile nothing."""
    monkeypatch.setattr(builder_native, "PREBUILT", tmp_path)
    monkeypatch.setattr(builder_native, "compiler_of", lambda platform: None)
    monkeypatch.setattr(builder_native, "too_old", lambda: ["numba is too old"])
    monkeypatch.setattr(builder_native, "object_files", lambda *_: pytest.fail("compiled"))
    return tmp_path


def bring(folder, platform, content):
    for version in ("2.0", "3.0"):
        name = library_name(["fmu_ehd"], platform, version)
        (folder / name).write_bytes(content + version.encode())


@pytest.mark.parametrize("version, place", [("2.0", "win64"), ("3.0", "x86_64-windows")])
def test_a_library_made_ahead_is_taken(brought, version, place):
    bring(brought, "win64", b"made ahead for ")
    fmu = build_native_fmu("fmu_ehd", GRID, Path("."), version=version, platforms=["win64"])
    with zipfile.ZipFile(fmu) as archive:
        library = archive.read(f"binaries/{place}/fmu_ehd.dll")
    assert library == b"made ahead for " + version.encode()


def test_what_was_not_made_ahead_asks_for_a_compiler(brought):
    bring(brought, "win64", b"")
    with pytest.raises(BadInput) as refusal:
        build_native_fmu("fmu_ehd", GRID, Path("."), platforms=["win64", "aarch64-linux"])
    assert refusal.value.faults == [
        "platform aarch64-linux: expected a C compiler, zig or aarch64-linux-gnu-gcc, got none",
        "numba is too old",
    ]


def test_a_library_of_other_sources_is_not_taken(brought, monkeypatch):
    bring(brought, "win64", b"")
    monkeypatch.setattr(builder_native, "_sources", lambda package: b"edited since")
    with pytest.raises(BadInput, match="platform win64: expected a C compiler"):
        build_native_fmu("fmu_ehd", GRID, Path("."), platforms=["win64"])


@pytest.mark.parametrize(
    "versions, newer",
    [
        (b"GLIBC_2.2.5 GLIBC_2.17", []),
        (b"GLIBC_2.2.5\0GLIBC_2.35\0GLIBC_2.18", ["GLIBC_2.18", "GLIBC_2.35"]),
    ],
)
def test_newer_symbols_are_named(versions, newer):
    assert newer_symbols(b"\x7fELF\0" + versions + b"\0") == newer


def test_a_library_that_needs_a_new_glibc_is_a_warning(monkeypatch):
    codes = {"fmu_ehd": {"linux64": b""}}
    monkeypatch.setattr(builder_native, "compiled_packages", lambda *arguments: codes)
    monkeypatch.setattr(builder_native, "link", lambda *arguments: b"GLIBC_2.2.5\0GLIBC_2.38\0")
    with pytest.warns(UserWarning, match=r"linux64: the library needs GLIBC_2\.38, .*ziglang"):
        builder_native.libraries(("fmu_ehd",), ("linux64",), "2.0")


@pytest.mark.parametrize("platform", ["linux64", "aarch64-linux"])
def test_zig_links_where_it_is_installed(monkeypatch, platform):
    monkeypatch.setattr(compiler, "find_spec", lambda name: name)
    monkeypatch.setattr(compiler.shutil, "which", lambda name: None if name == "zig" else name)
    command = compiler_of(platform)
    assert command is not None and "ziglang" in command and command[-2].endswith("gnu.2.17")


@pytest.mark.slow
@pytest.mark.parametrize("platform", ["linux64", "aarch64-linux"])
def test_a_release_library_for_linux_needs_glibc_2_17(platform):
    if "-target" not in (compiler_of(platform) or ()):
        pytest.skip("needs zig (pip install ziglang)")
    fmu = build_native_fmu("fmu_ehd", GRID, Path("."), platforms=[platform])
    with zipfile.ZipFile(fmu) as archive:
        folder = PLATFORMS[platform].folders["2.0"]
        library = archive.read(f"binaries/{folder}/fmu_ehd.so")
    assert b"GLIBC_2." in library and newer_symbols(library) == []
    for name in (b"memcpy", b"exp", b"erf"):  # zig's own would have other last digits
        assert b"\0" + name + b"\0" in library


@pytest.mark.slow
@pytest.mark.parametrize("platform", MACS)
def test_a_library_for_macos(platform):
    if compiler_of(platform) is None:
        pytest.skip("needs zig (pip install ziglang)")
    fmu = build_native_fmu("fmu_ehd", GRID, Path("."), platforms=[platform])
    with zipfile.ZipFile(fmu) as archive:
        folder = PLATFORMS[platform].folders["2.0"]
        processor, defined, asked = symbols(archive.read(f"binaries/{folder}/fmu_ehd.dylib"))
    assert processor == MACS[platform]
    assert {"_fmi2Instantiate", "_fmi2DoStep", "_fmi2GetDirectionalDerivative"} <= defined
    assert not any(word in name for name in asked for word in ("Py", "numba", "NRT"))
    assert "_malloc" in asked or "_calloc" in asked


def symbols(library):
    """Processor, names defined for others and names asked for of a 64-bit Mach-O file."""
    magic, processor, _, _, commands, *_ = struct.unpack_from("<8I", library)
    assert magic == 0xFEEDFACF
    place, defined, asked = 32, set(), set()
    for _ in range(commands):
        kind, size = struct.unpack_from("<2I", library, place)
        if kind == 2:  # LC_SYMTAB
            table, count, texts, _ = struct.unpack_from("<4I", library, place + 8)
            for k in range(count):
                name, flags = struct.unpack_from("<IB", library, table + 16 * k)
                start = texts + name
                word = library[start : library.index(b"\0", start)].decode()
                if flags & 1:  # N_EXT
                    (defined if flags & 0x0E else asked).add(word)  # N_TYPE: 0 is N_UNDF
        place += size
    return processor, defined, asked
