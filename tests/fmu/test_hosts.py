"""The built FMUs in hosts that are not Python, and the ways a host can go wrong."""

import os
import subprocess
import sys

import numpy as np
import pytest
from fmpy import fmi2

STEP, STEPS = 5e-5, 3
CELL = ("nodal_pressure_force[3,4]", "film_thickness[3,4]")


def ask(host, *fmus, **environment):
    """Exit code, lines of numbers and error text of the host."""
    arguments = [str(a) for fmu in fmus for a in fmu]
    run = subprocess.run(
        [str(host), repr(STEP), str(STEPS), *arguments],
        capture_output=True,
        text=True,
        cwd="/",
        timeout=300,
        env={k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "VIRTUAL_ENV"))}
        | environment,
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
    assert "viscosity = -1 Pa.s: allowed is" in errors


def test_a_description_of_another_fmu_is_refused(host, film, bodies):
    """The identifier that an importer read has to be the FMU's own."""
    *mine, own = film
    *_, other = bodies
    code, _, errors = ask(host, [*mine, other])
    assert code == 1
    assert f"{other} is not the identifier of this FMU, {own}" in errors


def test_bad_step_is_a_discard(host, fmu, unpack, tmp_path):
    unpacked = unpack(fmu, tmp_path)
    code, _, errors = ask(host, unpacked.arguments("film_thickness[2,5]", np.nan, *CELL))
    assert code == 1
    assert "film_thickness" in errors
