"""The built FMUs in hosts that are not Python, and the ways a host can go wrong."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from fmpy import fmi2

STEP, STEPS = 5e-5, 3
CELL = ("nodal_pressure_force[3,4]", "film_thickness[3,4]")


def ask(host, *fmus, before=(), **environment):
    """Exit code, lines of numbers and error text of the host; `before` starts it."""
    arguments = [str(a) for fmu in fmus for a in fmu]
    run = subprocess.run(
        [*before, str(host), repr(STEP), str(STEPS), *arguments],
        capture_output=True,
        text=True,
        cwd="/",
        timeout=300,
        env={
            k: v
            for k, v in (os.environ | environment).items()
            if v is not None and (k in environment or not k.startswith(("PYTHON", "VIRTUAL_ENV")))
        },
    )
    return (
        run.returncode,
        [list(map(float, line.split())) for line in run.stdout.splitlines()],
        run.stderr,
    )


@pytest.fixture(scope="module")
def film(fmu, unpack, tmp_path_factory):
    return unpack(fmu, tmp_path_factory.mktemp("film")).arguments(
        "film_thickness[3,4]", 2e-5, *CELL
    )


@pytest.fixture(scope="module")
def bodies(bodies_fmu, unpack, tmp_path_factory):
    return unpack(bodies_fmu, tmp_path_factory.mktemp("bodies")).arguments(
        "crank_speed", 300.0, *reversed(CELL)
    )


def in_python(arguments):
    """The same drive as host.c's, by FMPy in this process."""
    folder, identifier, _, given, value, wanted, seed, guid = arguments
    one = fmi2.FMU2Slave(
        guid=guid, unzipDirectory=str(folder), modelIdentifier=identifier, instanceName="python"
    )
    one.instantiate()
    one.setupExperiment(startTime=0.0)
    one.enterInitializationMode()
    one.setReal([given], [value])
    one.exitInitializationMode()
    for n in range(STEPS + 1):
        one.setReal([given], [value * (1 - 100 * (n * STEP))])
        one.doStep(n * STEP, STEP)
    result = one.getReal([wanted])[0], one.getDirectionalDerivative([wanted], [seed], [1.0])[0]
    one.terminate()
    one.freeInstance()
    return result


def test_both_fmus_in_one_host_without_python(host, film, bodies):
    code, lines, errors = ask(host, film, bodies)
    assert code == 0, errors
    for line, arguments in zip(lines, (film, bodies)):
        output, product, size, repeated = line
        assert (output, product) == in_python(
            arguments
        )  # to the bit: the same code on the same numbers
        assert product != 0 and size > 1000 and repeated == 1


def test_host_finds_the_interpreter_it_is_told(host, film, tmp_path):
    marker = tmp_path / "asked"
    wrapper = tmp_path / "my python"
    wrapper.write_text(f"#!/bin/sh\ntouch '{marker}'\nexec {sys.executable} \"$@\"\n")
    wrapper.chmod(0o755)
    code, _, errors = ask(host, film, PISTON_COSIM_PYTHON=str(wrapper))
    assert code == 0, errors
    assert marker.exists()


def test_missing_packages_are_a_clean_refusal_with_the_pip_line(host, film, tmp_path):
    subprocess.run(
        [sys.executable, "-m", "venv", "--without-pip", str(tmp_path / "bare")], check=True
    )
    bare = tmp_path / "bare" / "bin" / "python"
    (tmp_path / "python.txt").write_text(str(bare))
    settings = {"PATH": str(bare.parent), "PISTON_COSIM_CACHE": str(tmp_path)}
    code, _, errors = ask(host, film, **settings)
    assert code == 1
    assert f"numpy, scipy, numba missing; run: {bare} -m pip install numpy scipy numba" in errors


@pytest.mark.parametrize("name", ["with blank", "Kolben-Öl-油", "per%20cent"])
def test_any_unzip_path(host, fmu, unpack, tmp_path, name):
    unpacked = unpack(fmu, tmp_path / name)
    code, _, errors = ask(host, unpacked.arguments("film_thickness[1,1]", 2e-5, *CELL))
    assert code == 0, errors


def test_refusals_are_errors_and_heard_without_logging(host, fmu, unpack, tmp_path):
    unpacked = unpack(fmu, tmp_path)
    code, _, errors = ask(host, unpacked.arguments("viscosity", -1.0, *CELL))
    assert code == 1
    assert "fmi2ExitInitializationMode answered 3" in errors
    assert "viscosity: expected " in errors


@pytest.fixture
def stranger():
    """Starts a command as a user without an entry in any list of users."""
    words = ["unshare", "--user", "--map-user=54321"]
    if not shutil.which("unshare") or subprocess.run([*words, "true"]).returncode:
        pytest.skip("no user namespaces here")
    return words


@pytest.mark.slow  # nothing can be kept: all is compiled
def test_a_user_without_an_entry_and_without_home(host, film, stranger):
    """What is kept of a home directory is done without; the results are the same bits."""
    _, (known,), _ = ask(host, film)
    settings = {"HOME": None, "XDG_CACHE_HOME": None, "PISTON_COSIM_PYTHON": sys.executable}
    kept = os.environ.get("PISTON_COSIM_CACHE")
    code, lines, errors = ask(host, film, before=stranger, PISTON_COSIM_CACHE=kept, **settings)
    assert code == 0, errors
    assert lines == [known]


CODE_FOLDER = """
import sys
sys.path.insert(0, sys.argv[1])
text = open(sys.argv[1] + "/" + sys.argv[2] + ".py").read()
scope = {"__file__": sys.argv[1] + "/entry.py"}
exec(text[: text.index("for code in CODES")], scope)
print(scope["folder_of"](*scope["CODES"]))
"""


def test_code_stays_in_the_fmu_where_nothing_can_be_kept(fmu, unpack, stranger, tmp_path):
    """No home, and an unzip folder that cannot be written to."""
    resources = unpack(fmu, tmp_path).folder / "resources"
    entry = (resources / "slavemodule.txt").read_text().strip()
    subprocess.run(["chmod", "-R", "a-w", str(resources)], check=True)
    done = subprocess.run(
        [*stranger, sys.executable, "-c", CODE_FOLDER, str(resources), entry],
        capture_output=True,
        text=True,
        cwd="/",
        env={"PATH": os.environ["PATH"]},
    )
    subprocess.run(["chmod", "-R", "u+w", str(resources)], check=True)
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()) == resources


def test_a_read_only_unzip_folder(host, fmu, unpack, stranger, tmp_path):
    unpacked = unpack(fmu, tmp_path / "fixed")
    subprocess.run(["chmod", "-R", "a-w", str(tmp_path / "fixed")], check=True)
    arguments = unpacked.arguments("film_thickness[1,1]", 2e-5, *CELL)
    code, _, errors = ask(host, arguments, before=stranger)
    subprocess.run(["chmod", "-R", "u+w", str(tmp_path / "fixed")], check=True)
    assert code == 0, errors


def test_the_python_of_an_active_environment_comes_before_the_recorded_one(host, film, tmp_path):
    marker = tmp_path / "asked"
    (tmp_path / "bin").mkdir()
    wrapper = tmp_path / "bin" / "python"
    wrapper.write_text(f"#!/bin/sh\ntouch '{marker}'\nexec {sys.executable} \"$@\"\n")
    wrapper.chmod(0o755)
    code, _, errors = ask(host, film, VIRTUAL_ENV=str(tmp_path))
    assert code == 0, errors
    assert marker.exists()


def test_an_environment_without_the_packages_is_passed_over(host, film, tmp_path):
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(tmp_path)], check=True)
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    code, _, errors = ask(host, film, VIRTUAL_ENV=str(tmp_path), PATH=path)
    assert code == 0, errors


def test_the_home_of_another_python_does_not_matter(host, film, tmp_path):
    code, _, errors = ask(host, film, PYTHONHOME=str(tmp_path))
    assert code == 0, errors


EMBEDDED = """
import ctypes, sys
folder, identifier, location, guid = sys.argv[1:]
said = []
text = ctypes.c_char_p
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, text, ctypes.c_int, text, text)
logger = LOGGER(lambda *arguments: said.append(arguments[-1].decode()))
callbacks = (ctypes.c_void_p * 5)(ctypes.cast(logger, ctypes.c_void_p).value)
library = ctypes.CDLL(f"{folder}/binaries/linux64/{identifier}.so")
library.fmi2Instantiate.restype = ctypes.c_void_p
made = library.fmi2Instantiate(b"one", 1, guid.encode(), location.encode(), callbacks, 0, 0)
print(bool(made), *said)
"""


def test_a_python_in_the_host_that_lacks_packages_is_told_in_one_sentence(film, tmp_path):
    """The host's own Python is the one that would run the model: what it lacks, and how to mend
    it.
    """
    folder, identifier, location, *_, guid = map(str, film)
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(tmp_path)], check=True)
    bare = tmp_path / "bin" / "python"
    done = subprocess.run(
        [str(bare), "-I", "-c", EMBEDDED, folder, identifier, location, guid],
        capture_output=True,
        text=True,
        cwd="/",
    )
    assert done.returncode == 0, done.stderr
    told = f"numpy, scipy, numba missing; run: {bare} -m pip install numpy scipy numba"
    assert done.stdout.strip() == f"False instantiate: {told}"
