"""The built FMUs in hosts that are not Python, and the ways a host can go wrong."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import fmi2

from piston_cosim.master.fmi import requirements
from piston_cosim.master.fmi.compiler import compiler_of

STEP, STEPS = 5e-5, 3
CELL = ("nodal_pressure_force[3,4]", "film_thickness[3,4]")


def ask(host, *fmus, before=(), only=None, **environment):
    """Return exit code, lines of numbers and error text of the host; `before` starts it.

    The environment is `only`, if given. Otherwise it is that of the tests without Python's
    variables, updated by `environment`.
    """
    arguments = [str(a) for fmu in fmus for a in fmu]
    run = subprocess.run(
        [*before, str(host), repr(STEP), str(STEPS), *arguments],
        capture_output=True,
        text=True,
        cwd="/",
        timeout=300,
        env=only
        if only is not None
        else {
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
    """Drive the FMU as host.c does, by FMPy in this process."""
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
        if n == STEPS:
            one.getFMUstate()  # as the host
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


@pytest.mark.parametrize("kind", ["film", "coupled"])
def test_a_native_fmu_in_an_empty_environment_and_a_read_only_folder(
    host, native_fmu, native_engine, unpack, tmp_path, kind
):
    """No Python, no PATH, no HOME; the bits of a host in Python."""
    place = unpack(native_fmu if kind == "film" else native_engine([12, 10]), tmp_path / "a place")
    given = ("film_thickness[3,4]", 2e-5, *CELL)
    if kind == "coupled":
        given = ("crank_speed", 628.0, "side_force", "crank_speed")
    arguments = place.arguments(*given)
    place.folder.chmod(0o555)
    code, ((output, product, size, repeated),), errors = ask(host, arguments, only={})
    assert code == 0, errors
    assert (output, product) == in_python(arguments)
    assert output != 0.0 and product != 0.0 and size > 1000 and repeated == 1


@pytest.mark.parametrize("setting", ["PISTON_COSIM_PYTHON", "VIRTUAL_ENV"])
def test_host_finds_the_interpreter_it_is_told(host, film, tmp_path, setting):
    """By name, or as that of an active environment, which comes before the recorded one."""
    marker, folder = tmp_path / "asked", tmp_path / "my environment"
    wrapper = folder / "bin/python"
    wrapper.parent.mkdir(parents=True)
    wrapper.write_text(f"#!/bin/sh\ntouch '{marker}'\nexec {sys.executable} \"$@\"\n")
    wrapper.chmod(0o755)
    told = wrapper if setting == "PISTON_COSIM_PYTHON" else folder
    code, _, errors = ask(host, film, **{setting: str(told)})
    assert code == 0, errors
    assert marker.exists()


def bare_python(folder):
    """Create a Python without packages."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], check=True)
    return folder / "bin" / "python"


LACKING = "numpy, scipy, numba missing; run: {} -m pip install numpy scipy numba"


def test_missing_packages_are_a_clean_refusal_with_the_pip_line(host, film, tmp_path):
    bare = bare_python(tmp_path / "bare")
    (tmp_path / "python.txt").write_text(str(bare))
    settings = {"PATH": str(bare.parent), "PISTON_COSIM_CACHE": str(tmp_path)}
    code, _, errors = ask(host, film, **settings)
    assert code == 1
    assert LACKING.format(bare) in errors


@pytest.mark.parametrize(
    "version, words",
    [
        (None, ""),
        ("3.9", "PISTON_COSIM_PYTHON: expected Python {} as in this process, got 3.9"),
        ("", "PISTON_COSIM_PYTHON: expected a Python, got "),
    ],
)
def test_a_python_host_without_packages_takes_those_it_is_told(tmp_path, version, words):
    """If both have the same version. An empty version stands for a file that is no Python."""
    other = Path(sys.executable)
    if version is not None:
        other = tmp_path / "other"
        other.write_text(f"#!/bin/sh\necho {version}\nexit {int(not version)}\n")
        other.chmod(0o755)
    script = "import requirements; print(requirements.missing_in_host()); import numba"
    done = subprocess.run(
        [bare_python(tmp_path / "bare"), "-c", script],
        capture_output=True,
        text=True,
        cwd=Path(requirements.__file__).parent,
        env=os.environ | {"PISTON_COSIM_PYTHON": str(other)},
    )
    assert (done.returncode == 0) == (version is None)
    here = "{}.{}".format(*sys.version_info)
    assert words.format(here) in done.stdout and ("missing" in done.stdout) == bool(words)


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
    """Return the words that start a command as a user without an entry in any list of users."""
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


def test_an_environment_without_the_packages_is_passed_over(host, film, tmp_path):
    bare_python(tmp_path)
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
    """The message names the packages that the host's Python lacks and the command that adds them.

    The host's own Python is the one that would run the model.
    """
    folder, identifier, location, *_, guid = map(str, film)
    bare = bare_python(tmp_path)
    done = subprocess.run(
        [str(bare), "-I", "-c", EMBEDDED, folder, identifier, location, guid],
        capture_output=True,
        text=True,
        cwd="/",
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == f"False instantiate: {LACKING.format(bare)}"


# ---- other machines

MACHINES = {
    "aarch64-linux": ("so", ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"]),
    "win64": ("dll", ["wine"]),
}
"""Platform -> suffix of its libraries, and what runs its programs here."""
DRIVER = Path(__file__).parent / "native_driver.c"


@pytest.mark.slow
@pytest.mark.parametrize("platform", MACHINES)
@pytest.mark.parametrize(
    "kind, steps, first",
    [
        ("fmu_ehd", "200", ("film_thickness", "sliding_velocity", "nodal_pressure_force")),
        ("fmu_mfbd", "120", ("nodal_pressure_force", "nodal_friction_force", "film_thickness")),
    ],
)
def test_other_machines_say_the_same(
    make_native, native_bodies, unpack, tmp_path, platform, kind, steps, first
):
    """The same host program, compiled for another machine, gives the same under an emulator.

    The film agrees to the bit. The bodies agree to the last digits of other C libraries' sin, tanh
    and hypot.
    """
    ending, emulator = MACHINES[platform]
    compile_for, film = compiler_of(platform), kind == "fmu_ehd"
    if compile_for is None or shutil.which(emulator[0]) is None:
        pytest.skip(f"{platform}: needs its C compiler and {emulator[0]}")
    make, answers = make_native if film else native_bodies, []
    for command, compile_with, folder, suffix in (
        ([], ["cc"], "linux64", "so"),
        (emulator, compile_for, platform, ending),
    ):
        place = unpack(make([12, 10], platforms=[folder]), tmp_path / folder)
        program = tmp_path / f"driver-{folder}.exe"
        links = ["-lm"] if folder == "win64" else ["-lm", "-ldl"]
        numbers = [] if film else ["-DNUMBERS"]
        command_line = [*compile_with, *numbers, "-o", str(program), str(DRIVER), *links]
        subprocess.run(command_line, check=True)
        references = [place.references[f"{name}[1,1]"] for name in first]
        library = place.folder / "binaries" / folder / f"{kind}.{suffix}"
        words = [program, library, place.location, place.description.guid, 120, steps, *references]
        done = subprocess.run(
            [*command, *map(str, words)],
            capture_output=True,
            timeout=500,
            env={**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": str(tmp_path / "wine")},
        )
        assert done.returncode == 0, done.stderr
        answers.append(done.stdout.replace(b"\r", b""))
    assert answers[0].count(b"\n") == int(steps)
    if film:
        assert answers[0] == answers[1]
        return
    own, there = (np.array([float(one.split()[1]) for one in a.splitlines()]) for a in answers)
    assert np.ptp(own) > 1e-3 * own.max()  # the piston moves
    assert np.abs(own - there).max() <= 1e-12 * np.abs(own).max()
