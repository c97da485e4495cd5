"""Calls at random of a native FMU under AddressSanitizer.

They include damaged states, and valid ones with other content.
"""

import os
import subprocess
from math import prod
from pathlib import Path

import pytest

from piston_cosim.master.fmi.builder_native import (
    OF_COUPLED,
    SOURCES,
    definitions,
    object_files,
)
from piston_cosim.master.fmi.compiler import HOME

HERE = Path(__file__).parent
CHECKED = ("-g", "-O1", "-std=gnu11", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
"""Anything that the sanitizers find ends the program with a status."""


INSIDE = {"fmu_ehd": [], "fmu_mfbd": [], "master.coupling": ["fmu_ehd", "fmu_mfbd"]}
"""Packages -> those whose entries theirs call, in the order of the FMU."""


pytestmark = pytest.mark.slow


@pytest.fixture(scope="session", params=["2.0", "3.0"])
def version(request):
    return request.param


@pytest.fixture(scope="session", params=INSIDE)
def fuzzed(request, version, make_native, native_bodies, native_engine, unpack, tmp_path_factory):
    """Return a function that runs random calls on two FMUs of one library and counts them."""
    inside = INSIDE[request.param]
    make = dict(zip(INSIDE, (make_native, native_bodies, native_engine)))[request.param]
    fmus = make([12, 10], version=version), make([6, 5], version=version)
    folder = tmp_path_factory.mktemp("fuzzed")
    program = folder / "fuzz_calls"
    objects = [folder / f"{package}.o" for package in (request.param, *inside)]
    for path in objects:
        path.write_bytes(object_files(path.stem, ["linux64"])["linux64"])
    of_front = (*SOURCES, f"fmi{version[0]}.c", *([OF_COUPLED] if inside else ()))
    sources = [HERE / "fuzz_calls.c", *(HOME / name for name in of_front)]
    command = [
        "gcc",
        *CHECKED,
        f"-DFMI{version[0]}",
        *definitions(request.param, inside),
        f"-I{HOME}",
    ]
    command += ["-DLONG_STEP=1e-3"] if inside else []  # s; macro steps are taken one by one
    command += [*map(str, (*sources, *objects)), "-lm"]
    told = subprocess.run([*command, "-o", str(program)], capture_output=True, text=True)
    if told.returncode and "cannot find" in told.stderr:
        pytest.skip("gcc without AddressSanitizer")
    assert told.returncode == 0, told.stderr

    def run(calls, seed):
        arguments = [str(calls), str(seed)]
        for k, path in enumerate(fmus):
            place = unpack(path, folder / str(k))
            resources = str(place.folder / "resources")
            description = place.description
            token = description.guid or description.instantiationToken
            arguments += [resources, token, " ".join(map(str, sizes(description)))]
        around = os.environ | {"ASAN_OPTIONS": "allocator_may_return_null=1"}
        command = [str(program), *arguments]
        done = subprocess.run(command, capture_output=True, text=True, env=around)
        assert done.returncode == 0, done.stderr[-4000:]
        return map(int, done.stdout.split())

    return run


def sizes(description):
    """Return the elements of each variable in the order of references, negative if it is not real.

    Time, which FMI 3.0 lists last, is left out.
    """
    variables = [v for v in description.modelVariables if v.causality != "independent"]
    if description.fmiVersion.startswith("2"):
        return [1 if v.type == "Real" else -1 for v in variables]
    variables.sort(key=lambda v: v.valueReference)
    return [
        prod(int(d.start) for d in v.dimensions) * (1 if v.type == "Float64" else -1)
        for v in variables
    ]


@pytest.mark.parametrize("calls, seed", [(5000, 1), (100_000, 2), (100_000, 3)])
def test_calls_at_random_touch_no_memory_but_their_own(fuzzed, calls, seed):
    """All calls return, and every damage is detected.

    Hundreds of calls succeed, and hundreds are rejected. Of the states with new sums, some are
    rejected and some run.
    """
    well, refused, words, damaged, forged, tried = fuzzed(calls, seed)
    assert well > calls / 10 and refused > calls / 10 and words > calls / 20
    assert damaged == tried == calls // 10
    assert 0 < forged < tried
