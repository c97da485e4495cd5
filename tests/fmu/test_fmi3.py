"""The FMI 3.0 twin: true arrays, the same results to the bit as FMI 2.0, wrong counts refused
aloud.
"""

import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy import fmi3
from fmpy.validation import validate_fmu
from lxml import etree

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.contract import swap
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.system import open_system
from piston_cosim.master.fmi.builder import build_fmu
from piston_cosim.master.fmi.compiler import compiler
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.participants.fmi2 import FmuParticipant
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

CELLS = (12, 10)


@pytest.fixture(scope="module")
def twin():
    if not compiler():
        pytest.skip("no C compiler")
    return build_fmu("fmu_ehd", {"grid": list(CELLS)}, ".", version="3.0")


@pytest.fixture(scope="module")
def references(twin):
    return {v.name: v.valueReference for v in fmpy.read_model_description(str(twin)).modelVariables}


@pytest.fixture
def slave(twin, references, tmp_path):
    description = fmpy.read_model_description(str(twin))
    folder = fmpy.extract(str(twin), unzipdir=str(tmp_path))
    one = fmi3.FMU3Slave(
        guid=description.guid,
        unzipDirectory=folder,
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    one.said = []
    one.instantiate(
        loggingOn=False,
        logMessage=fmi3.fmi3LogMessageCallback(
            lambda environment, status, category, message: one.said.append(
                (status, message.decode())
            )
        ),
    )
    one.enterInitializationMode(startTime=0.0)
    one.setFloat64([references["film_thickness"]], np.full(CELLS, 3e-5).ravel())
    one.exitInitializationMode()
    yield one
    one.terminate()
    one.freeInstance()


def test_a_token_of_another_fmu_is_refused(twin, tmp_path):
    said = []
    description = fmpy.read_model_description(str(twin))
    one = fmi3.FMU3Slave(
        guid="{another}",
        unzipDirectory=fmpy.extract(str(twin), unzipdir=str(tmp_path)),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="one",
    )
    heard = fmi3.fmi3LogMessageCallback(lambda e, s, c, message: said.append(message.decode()))
    with pytest.raises(Exception, match="instantiate"):
        one.instantiate(loggingOn=False, logMessage=heard)
    assert "{another} is not the identifier of this FMU" in said[0]


def film(k):
    return 2e-5 + 8e-6 * np.random.default_rng(k).random(CELLS)


def test_description_is_valid_with_arrays_and_terminals(twin):
    assert validate_fmu(str(twin)) == []
    variables = {v.name: v for v in fmpy.read_model_description(str(twin)).modelVariables}
    assert [int(d.start) for d in variables["film_thickness"].dimensions] == list(CELLS)
    assert variables["film_thickness"].unit == "m"
    with zipfile.ZipFile(twin) as archive:
        told = archive.read("terminalsAndIcons/terminalsAndIcons.xml")
        assert archive.read("terminalsAndIcons/icon.png").startswith(b"\x89PNG")
    schemas = Path(fmpy.__file__).parent / "schema" / "fmi3"
    root = etree.fromstring(told)
    etree.XMLSchema(file=str(schemas / "fmi3TerminalsAndIcons.xsd")).assertValid(root)
    members = {m.get("variableName") for m in root.iter("TerminalMemberVariable")}
    assert members == {
        "film_thickness",
        "sliding_velocity",
        "nodal_pressure_force",
        "nodal_friction_force",
    }


def test_same_bits_as_fmi_2(fmu, slave, references):
    two = FmuParticipant("two", fmu)
    two.start({"film_thickness": np.full(CELLS, 3e-5)}, 0.0, 1.0)
    for k in range(4):
        two.set("film_thickness", film(k))
        two.set("sliding_velocity", np.full(CELLS, 4.0))
        slave.setFloat64(
            [references["film_thickness"], references["sliding_velocity"]],
            [*film(k).ravel(), *np.full(CELLS, 4.0).ravel()],
        )
        two.step(k * 5e-5, 5e-5)
        slave.doStep(k * 5e-5, 5e-5)
    forces = slave.getFloat64([references["nodal_pressure_force"]], CELLS[0] * CELLS[1])
    assert np.array_equal(np.reshape(forces, CELLS), two.get("nodal_pressure_force"))
    assert max(forces) > 0
    seed = np.random.default_rng(9).random(CELLS)
    product = slave.getDirectionalDerivative(
        [references["nodal_pressure_force"]],
        [references["film_thickness"]],
        list(seed.ravel()),
        CELLS[0] * CELLS[1],
    )
    expected = two.derivative({"film_thickness": seed}, ["nodal_pressure_force"])[
        "nodal_pressure_force"
    ]
    assert np.array_equal(np.reshape(product, CELLS), expected)
    two.close()


@pytest.mark.parametrize("count", [0, 119, 121])
def test_wrong_number_of_values_is_refused_aloud(slave, references, count):
    with pytest.raises(Exception, match="3"):
        slave.setFloat64([references["film_thickness"]], [1e-5] * count)
    status, text = slave.said[-1]
    assert status == fmi3.fmi3Error
    assert text == f"fmi3SetFloat64: the variables have 120 elements, {count} values were given"


def test_wrong_type_is_refused_aloud(slave, references):
    with pytest.raises(Exception, match="3"):
        slave.getFloat64([references["n_axial"]])
    assert "no variable of this type" in slave.said[-1][1]
    assert slave.getInt32([references["n_axial"]]) == [10]
    assert slave.getFloat64([references["time"]]) == [0.0]


def test_without_compiler_there_is_no_twin(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(BadInput, match="C compiler"):
        build_fmu("fmu_ehd", {"grid": list(CELLS)}, ".", version="3.0")


def test_master_runs_fmi_3_to_the_same_bits(twin, fmu, tmp_path):
    path = find_case("numerical_example")
    small = [
        ("participants.bodies.build.grid", list(CELLS)),
        ("time.stop", "5 deg"),
        ("participants.bodies.build.piston.modes", 0),
        ("participants.bodies.build.block.modes", 0),
    ]
    results = []
    for file in (fmu, twin):
        tree, left_out = swap(read_tree(path, small), "ehd", file)
        assert left_out == []
        case, output = check_case(tree, path), tmp_path / f"{file.stem}.h5"
        run(open_system(case, path.parent, print), case, tree, output)
        results.append(Results(output).series("bodies.lateral_displacement")[0])
    assert np.array_equal(*results)
    assert np.ptp(results[0]) > 0
