"""FMUs built once for all tests here, and a small body mesh."""

import json
import subprocess
import sys
import textwrap
import urllib.parse
from pathlib import Path

import fmpy
import pytest

from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import (
    build_native_fmu,
    too_old,
)
from piston_cosim.master.fmi.compiler import compiler

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def fmu():
    """The lubrication FMU on a small grid."""
    return build_fmu("fmu_ehd", {"grid": [12, 10]}, Path("."))


@pytest.fixture(scope="session")
def native_fmu():
    """The same without Python; the first time its kernels are compiled, some minutes."""
    return native_film([12, 10])


def native_film(grid, version="2.0", **options):
    """A native lubrication FMU for this machine."""
    return native("fmu_ehd", {"grid": grid} | options, Path("."), version=version)


def native(package, options, folder, **more):
    """A native FMU, for this machine unless others are named."""
    if not compiler():
        pytest.skip("no C compiler, or not Linux on x86-64")
    if too_old():
        pytest.skip(too_old()[0])
    return build_native_fmu(package, options, folder, **more)


def rigid_bodies(grid):
    """Build table of the numerical example's bodies, rigid, and its folder."""
    from piston_cosim.master.case.checked import check_case
    from piston_cosim.master.case.reading import find_case, read_tree

    path = find_case("numerical_example")
    build = check_case(read_tree(path), path).participants["bodies"].build | {"grid": grid}
    return build | {part: build[part] | {"modes": 0} for part in ("piston", "block")}, path.parent


@pytest.fixture(scope="session")
def native_bodies():
    """Builds rigid bodies without Python, on a grid; the first time their kernels are compiled,
    some minutes.
    """
    return lambda grid, **more: native("fmu_mfbd", *rigid_bodies(grid), **more)


@pytest.fixture(scope="session")
def native_engine():
    """Builds the numerical example, rigid, as one FMU without Python, on a grid."""

    def make(grid, changes=(), version="2.0", platforms=("linux64",)):
        from piston_cosim.master.case.checked import check_case
        from piston_cosim.master.case.export import export_fmu
        from piston_cosim.master.case.reading import find_case, read_tree

        if platforms and not compiler():
            pytest.skip("no C compiler, or not Linux on x86-64")
        if platforms and too_old():
            pytest.skip(too_old()[0])
        path = find_case("numerical_example")
        small = [
            *((f"participants.{name}.build.grid", grid) for name in ("bodies", "ehd")),
            *((f"participants.bodies.build.{body}.modes", 0) for body in ("piston", "block")),
        ]
        tree = read_tree(path, [*small, ("time.stop", "12 deg"), *changes])
        return export_fmu(check_case(tree, path), path.parent, print, version, platforms)

    return make


@pytest.fixture(scope="session")
def make_native():
    return native_film


@pytest.fixture(scope="session")
def bodies_fmu():
    """The body FMU of the numerical example, rigid, on the same small grid."""
    return build_fmu("fmu_mfbd", *rigid_bodies([12, 10]))


@pytest.fixture(scope="session")
def host(tmp_path_factory):
    """A compiled host that is not Python."""
    if not compiler():
        pytest.skip("no C compiler")
    program = tmp_path_factory.mktemp("host") / "host"
    subprocess.run(
        [compiler(), "-Wall", "-Wextra", "-o", str(program), str(HERE / "host.c"), "-ldl"],
        check=True,
    )
    return program


@pytest.fixture(scope="session")
def outside():
    """Runs code after a prelude in a bare Python away from the source, the FMU's path its argument;
    what it prints last is JSON.
    """

    def run(prelude, fmu, body):
        code = prelude + textwrap.dedent(body)
        done = subprocess.run(
            [sys.executable, "-I", "-c", code, str(fmu)],
            capture_output=True,
            text=True,
            cwd="/",
            timeout=300,
        )
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout.splitlines()[-1])

    return run


class Unpacked:
    """An FMU unpacked into a folder, with its references by name."""

    def __init__(self, path, folder):
        self.folder = Path(fmpy.extract(str(path), unzipdir=str(folder)))
        self.description = fmpy.read_model_description(str(path))
        self.identifier = self.description.coSimulation.modelIdentifier
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.location = "file://" + urllib.parse.quote(str(self.folder / "resources"))

    def arguments(self, given, value, wanted, seed):
        """What the host wants to know of this FMU."""
        return [
            self.folder,
            self.identifier,
            self.location,
            self.references[given],
            value,
            self.references[wanted],
            self.references[seed],
            self.description.guid,
        ]


@pytest.fixture(scope="session")
def unpack():
    return Unpacked
