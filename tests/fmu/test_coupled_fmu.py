"""The coupled system as one FMU gives what a run gives, at any communication step, and its state is
whole.
"""

import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.export import export_fmu
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.builder_native import too_old
from piston_cosim.master.fmi.compiler import compiler
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.master.participants.open import open_fmu
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

STEPS = 12
WATCHED = ("lateral_displacement", "minimum_film_thickness", "side_force", "friction_power")
SMALL = [
    ("participants.bodies.build.grid", [12, 10]),
    ("participants.ehd.build.grid", [12, 10]),
    ("time.stop", f"{STEPS} deg"),
    ("participants.bodies.build.piston.modes", 0),
    ("participants.bodies.build.block.modes", 0),
]
PATH = find_case("numerical_example")


@pytest.fixture(scope="module")
def tree():
    return read_tree(PATH, SMALL)


@pytest.fixture(scope="module")
def reference(tree, tmp_path_factory):
    """Watched outputs after every macro step of a run, shape (STEPS + 1, 4), and the macro step
    [s].
    """
    case, output = check_case(tree, PATH), tmp_path_factory.mktemp("run") / "run.h5"
    system = open_system(case, PATH.parent, print)
    run(system, case, tree, output)
    results = Results(output)
    owner = {
        name: next(o for o, p in system.participants.items() if name in p.fields)
        for name in WATCHED
    }
    return np.array([results.series(f"{owner[name]}.{name}")[0] for name in WATCHED]).T, system.step


@pytest.fixture(scope="module")
def coupled(tree):
    return export_fmu(check_case(tree, PATH), PATH.parent, print)


def started(path):
    participant = FmuParticipant("coupled", path)
    participant.start({}, 0.0, 1.0)
    return participant


def watched(participant):
    return [participant.get(name) for name in WATCHED]


def test_inputs_are_those_without_a_wire(coupled):
    inputs = {
        v.name
        for v in fmpy.read_model_description(str(coupled)).modelVariables
        if v.causality == "input"
    }
    rings = {"ring_side_force", "ring_axial_force", "ring_moment"}
    assert inputs == {
        *("crank_speed", "load_torque", "gas_pressure", "crankcase_pressure", "land_pressure"),
        *("piston_temperature", "bore_temperature"),
        *rings,
    }


def test_participants_have_the_code_of_their_own_fmus(coupled, tree):
    """So that what is compiled of a participant serves both."""
    inside = codes_in(coupled)
    builds = {name: table["build"] for name, table in tree["participants"].items()}
    for package, name in (("fmu_ehd", "ehd"), ("fmu_mfbd", "bodies")):
        own = codes_in(build_fmu(package, builds[name], PATH.parent))
        assert len(own) == 1 and own < inside
    assert len(inside) == 3


def codes_in(fmu):
    """Names of the packages of code that an FMU carries."""
    with zipfile.ZipFile(fmu) as archive:
        paths = [Path(name).parts for name in archive.namelist()]
    return {path[1] for path in paths if len(path) > 2 and path[1].startswith("code_")}


def test_same_results_as_run_at_the_macro_step(coupled, reference):
    values, step = reference
    participant = started(coupled)
    rows = [watched(participant)]
    for k in range(STEPS):
        participant.step(k * step, step)
        rows.append(watched(participant))
    assert np.array_equal(rows, values)  # the same steps at the same times by the same code


def test_a_step_a_hair_too_long_is_one_macro_step(coupled, reference):
    """An importer's clock in whole nanoseconds, rounded up: the run's own values but for 1e-5 of a
    step; two macro steps of half the length differ by 1 % in the lateral motion.
    """
    values, step = reference
    rounded = np.ceil(step * 1e9) * 1e-9
    assert step < rounded < 1.0001 * step
    participant = started(coupled)
    for k in range(STEPS):
        participant.step(k * rounded, rounded)
    np.testing.assert_allclose(watched(participant), values[-1], rtol=2e-4)


def advanced(coupled, step, factor, end):
    """Watched outputs after each communication step of `factor` macro steps, up to `end` of them;
    shape (end / factor, 4).
    """
    participant, rows = started(coupled), []
    for k in range(round(end / factor)):
        participant.step(k * factor * step, factor * step)
        rows.append(watched(participant))
    return np.array(rows)


def test_steps_between_a_tenth_and_ten_times_the_case_s(coupled, reference):
    """All of them end as near to the run in tenths of the macro step as the run itself has been
    until then: the error of that step; steps that are longer are cut into whole macro steps, and
    those of two, five and ten are the run's own values.
    """
    values, step = reference
    end = 10
    fine = advanced(coupled, step, 0.1, end)
    error = np.abs(values[1 : end + 1] - fine[9::10]).max(axis=0)
    assert np.all(error > 0)
    for factor in (0.2, 0.4, 0.5, 1.25, 2.5):
        apart = np.abs(advanced(coupled, step, factor, end)[-1] - fine[-1])
        assert np.all(apart <= error), factor
    for factor in (1, 2, 5, 10):
        np.testing.assert_allclose(advanced(coupled, step, factor, end)[-1], values[end], rtol=1e-6)


def test_derivatives_are_those_of_the_step(coupled, reference):
    """Products for a seed of both inputs beside central differences of the repeated step, and
    nothing stays behind: the next step gives the same bits as without. In the fourth step: in
    the second the piston is nearer to the middle than it is nudged, and the thinnest film changes
    sides.
    """
    _, step = reference
    last = 3
    one, two = started(coupled), started(coupled)
    for participant in (one, two):
        for k in range(last + 1):
            participant.step(k * step, step)
    seeds = {"crank_speed": 1.0, "gas_pressure": 2e4}
    products = one.derivative({k: np.array(v) for k, v in seeds.items()}, list(WATCHED))
    values = {name: one.get(name) for name in seeds}
    sides = []
    for sign in (1.0, -1.0):
        other = started(coupled)
        for k in range(last):
            other.step(k * step, step)
        for name, seed in seeds.items():
            other.set(name, values[name] + sign * seed)
        other.step(last * step, step)
        sides.append(np.array(watched(other)))
    expected = (sides[0] - sides[1]) / 2
    found = np.array([products[name] for name in WATCHED])
    # the motion is of 9e-9 m by then and changes by 4e-11 m over the nudge, of which a macro step
    # that agrees to 1e-11 m (1e-6 of its nominal value) at the latest knows some percent
    np.testing.assert_allclose(found, expected, rtol=3e-2)
    assert np.all(found != 0)
    for participant in (one, two):
        participant.step((last + 1) * step, step)
    assert watched(one) == watched(two)


def test_state_is_whole(coupled, reference):
    """A step repeated from a saved, or a serialised, state gives the same bytes, in this instance
    and in another.
    """
    _, step = reference
    one, two = started(coupled), started(coupled)
    for k in range(3):
        one.step(k * step, step)
    saved = one.save()
    data = one.serialise(saved)
    one.step(3 * step, step)
    first, after = watched(one), one.serialise(one.save())
    two.restore(two._fmu.deSerializeFMUstate(data))
    for participant in (one, two):
        if participant is one:
            one.restore(saved)
        participant.step(3 * step, step)
        assert watched(participant) == first
        assert participant.serialise(participant.save()) == after


def test_a_bare_python_simulates_it(coupled):
    script = (
        "import sys, fmpy\n"
        "r = fmpy.simulate_fmu(sys.argv[1], stop_time=2e-4, output_interval=1e-4, "
        "output=['side_force'], start_values={'crank_speed': 300.0})\n"
        "print(len(r), r['side_force'][-1])"
    )
    command = [sys.executable, "-I", "-c", script, str(coupled)]
    done = subprocess.run(command, capture_output=True, text=True, cwd="/", timeout=300)
    assert done.returncode == 0, done.stderr
    assert done.stdout.split()[0] == "3"


def test_refusals_name_the_participant(coupled):
    with pytest.raises(BadInput, match="radial_clearance: expected .*, got -1"):
        FmuParticipant("coupled", coupled).start({"radial_clearance": -1.0}, 0.0, 1.0)


def test_an_fmu_cannot_be_taken_inside(tree, coupled):
    case = check_case(
        tree | {"participants": tree["participants"] | {"ehd": {"fmu": str(coupled)}}}, PATH
    )
    with pytest.raises(BadInput, match="participants.ehd"):
        export_fmu(case, PATH.parent, print)


def test_fmi_3_gives_the_same_bits(tree, coupled, reference):
    """One master reads both versions: outputs agree to the last bit after two steps."""
    if not compiler():
        pytest.skip("no C compiler")
    third = export_fmu(check_case(tree, PATH), PATH.parent, print, "3.0")
    assert validate_fmu(str(third)) == []
    fields = {
        v.name for v in fmpy.read_model_description(str(third)).modelVariables if v.dimensions
    }
    assert {"pressure", "film_thickness", "nodal_pressure_force"} <= fields
    _, step = reference
    seen = []
    for participant in (open_fmu("second", coupled), open_fmu("third", third)):
        participant.start({}, 0.0, 1.0)
        for k in range(2):
            participant.step(k * step, step)
        seen.append(watched(participant))
    assert seen[0] == seen[1]


@pytest.mark.parametrize("native", [False, True])
def test_gas_of_table_and_input_is_told_once_and_selected(native):
    """Near firing top dead centre; the input is 1 MPa."""
    if native and (not compiler() or too_old()):
        pytest.skip("no C compiler, or numba is too old")
    path = find_case("data_sheet")
    small = [change for change in SMALL if "modes" not in change[0]]
    case = check_case(read_tree(path, small), path)
    engine = export_fmu(case, path.parent, print, platforms=("linux64",) if native else ())
    shown = {}
    for source in ("either", "table", "input", "sum"):
        one = FmuParticipant("engine", engine)
        number = one.fields["gas_source"].choices[source]
        step = float(one.description.defaultExperiment.stepSize)
        start = {"start_crank_angle": np.radians(8.0), "gas_source": number}
        one.start(start | {"gas_pressure": 1e6}, 0.0, 1.0)
        told = [text for _, text in one.log if "gas_source" in text]
        for k in range(2):
            one.step(k * step, step)
            told += [text for _, text in one.log if "gas_source" in text]
        shown[source] = one.get("cylinder_pressure")
        assert len(told) == (source == "either"), told
        one.close()
    assert shown["input"] == 1e6
    assert shown["either"] == shown["sum"] == shown["table"] + shown["input"]
    assert shown["table"] > 5e6  # near the peak of the table, 6.8 MPa at 8 deg
