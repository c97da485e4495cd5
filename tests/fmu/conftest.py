"""FMUs built once for all tests here, and a small body mesh."""

import fcntl
import json
import subprocess
import sys
import textwrap
import urllib.parse
from pathlib import Path

import fmpy
import pytest

from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.compiler import compiler
from piston_cosim.master.results.file import Results

from . import shipped
from .counter import library
from .counter import make as make_counter
from .runs import EXAMPLE, build_of, export, make, needs_compiler, run_tree, small_tree

__all__ = ["library"]

HERE = Path(__file__).parent
STOP = ("time.stop", "12 deg")


@pytest.fixture(scope="session")
def results_of(tmp_path_factory, worker_id):
    """Return a function that returns the results of a run of `shipped.RUNS`.

    All workers of a session share the results file of a run.
    """
    root = tmp_path_factory.getbasetemp()
    root = root if worker_id == "master" else root.parent

    def results(name):
        file = root / f"{name}.h5"
        with open(root / f"{name}.lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not file.exists():
                run_tree(*shipped.RUNS[name](), file)
        return Results(file)

    return results


@pytest.fixture(params=["python", "native"])
def backend(request):
    """Return the backend that runs the code of an FMU."""
    return request.param


@pytest.fixture(scope="session")
def fmu():
    """Build the lubrication FMU on a small grid."""
    return build_fmu("fmu_ehd", {"grid": [12, 10]}, Path("."))


@pytest.fixture(scope="session")
def native_fmu(make_native):
    """Build the same FMU without Python; compiling its kernels for the first time takes minutes."""
    return make_native([12, 10])


def rigid_bodies(grid):
    """Build table of the numerical example's bodies, rigid, and its folder."""
    return build_of(small_tree(grid=grid), EXAMPLE, "bodies")[1:]


@pytest.fixture(scope="session")
def make_native():
    """Return a builder of native films on a grid."""
    return lambda grid, **more: make("fmu_ehd", {"grid": grid}, Path("."), True, **more)


@pytest.fixture(scope="session")
def native_bodies():
    """Return a builder of native rigid bodies on a grid."""
    return lambda grid, **more: make("fmu_mfbd", *rigid_bodies(grid), True, **more)


@pytest.fixture(scope="session")
def native_engine():
    """Return a builder of the rigid numerical example as one native FMU on a grid."""
    return lambda grid, changes=(), **more: export(
        small_tree(STOP, *changes, grid=grid), native=True, **more
    )


@pytest.fixture(scope="session")
def bodies_fmu():
    """Build the rigid body FMU of the numerical example on the same small grid."""
    return build_fmu("fmu_mfbd", *rigid_bodies([12, 10]))


@pytest.fixture
def folder(tmp_path, library):
    """Return a folder with two counters, a.fmu and b.fmu."""
    for name in "ab":
        make_counter(tmp_path / f"{name}.fmu", library)
    return tmp_path


@pytest.fixture(scope="session")
def host(tmp_path_factory):
    """Compile a host that is not Python."""
    needs_compiler(native=False)
    program = tmp_path_factory.mktemp("host") / "host"
    subprocess.run(
        [compiler(), "-Wall", "-Wextra", "-o", str(program), str(HERE / "host.c"), "-ldl"],
        check=True,
    )
    return program


@pytest.fixture(scope="session")
def outside():
    """Return a function that runs code after a prelude in a bare Python, away from the source.

    The argument of the code is the path of the FMU. The function returns the last printed line,
    read as JSON.
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
        """Return the arguments that the host needs for this FMU."""
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
