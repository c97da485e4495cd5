"""A case written as an SSP and read back gives the same run, value for value."""

import zipfile
from importlib.util import find_spec
from pathlib import Path
from xml.etree import ElementTree

import fmpy.ssp.ssd
import numpy as np
import pytest
from lxml import etree

from piston_cosim.master.case.checked import check_case
from piston_cosim.master.case.reading import find_case, read_tree
from piston_cosim.master.case.ssp import SPACE, export_ssp
from piston_cosim.master.case.system import open_system
from piston_cosim.master.commands.fmu.export import open_python
from piston_cosim.master.fmi.compiler import compiler
from piston_cosim.master.fmi.errors import BadInput
from piston_cosim.master.results.file import Results
from piston_cosim.master.runs.run import run

PATH = find_case("numerical_example")
SMALL = [
    ("participants.bodies.build.grid", [12, 10]),
    ("participants.ehd.build.grid", [12, 10]),
    ("time.stop", "6 deg"),
    ("participants.bodies.build.piston.modes", 0),
    ("participants.bodies.build.block.modes", 0),
    ("participants.bodies.build.piston.boss_length", "12 mm"),
    ("axes.0.second.lower", "bodies.build.piston.boss_length"),  # a build option, which FMUs lack
    ("symmetric", False),  # an SSP does not contain it, and half a film has other last digits
]


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    tree = read_tree(PATH, SMALL)
    path = tmp_path_factory.mktemp("ssp") / "case.ssp"
    export_ssp(tree, open_system(check_case(tree, PATH), PATH.parent, print), path)
    return path


def results(path, changes, output):
    tree = read_tree(path, changes)
    case = check_case(tree, path)
    run(open_system(case, path.parent, print), case, tree, output)
    return Results(output)


@pytest.mark.parametrize("kind", ["package", "arrays"])
def test_read_back_runs_to_the_same_values(kind, request, tmp_path):
    one = results(PATH, SMALL, tmp_path / "one.h5")
    two = results(request.getfixturevalue(kind), (), tmp_path / "two.h5")
    cases = (PATH, SMALL), (request.getfixturevalue(kind),)
    for port in ("bodies.lateral_displacement", "ehd.minimum_film_thickness", "ehd.friction_power"):
        np.testing.assert_array_equal(one.series(port)[0], two.series(port)[0])
    assert np.ptp(one.series("bodies.lateral_displacement")[0]) > 0
    ends = [check_case(read_tree(*case), PATH).axes[0].second.range for case in cases]
    assert ends[0][0] == pytest.approx(12.0) and ends[1] == pytest.approx(ends[0])


def members(path):
    """Name -> root of every XML file of an SSP."""
    with zipfile.ZipFile(path) as archive:
        return {
            name: ElementTree.fromstring(archive.read(name))
            for name in archive.namelist()
            if name.endswith((".ssd", ".ssv"))
        }


def test_every_scalar_is_a_connector_of_its_component_and_of_the_system(package):
    """Every scalar is a connector of its component and of the system.

    No wire feeds the inputs of crank, gas and rings. Each is connected to its component.
    Each starts at the value of the case: 6000 rpm = 200 pi rad/s.
    """
    files = members(package)
    root = files["SystemStructure.ssd"]
    (top,) = root.iter(f"{{{SPACE['ssd']}}}System")
    own = {c.get("name"): c for c in top.find(f"{{{SPACE['ssd']}}}Connectors")}
    inputs = {name for name, c in own.items() if c.get("kind") == "input"}
    rings = {"ring_side_force", "ring_axial_force", "ring_moment", "land_pressure"}
    warm = {"piston_temperature", "bore_temperature"}
    shaft = {"crank_speed", "load_torque", "gas_pressure", "crankcase_pressure"}
    assert inputs == shaft | warm | rings
    assert own["minimum_film_thickness"].get("kind") == "output"
    joined = [c for c in root.iter(f"{{{SPACE['ssd']}}}Connection") if len(c.attrib) == 3]
    assert len(joined) == len(own)
    (speed,) = [c for c in joined if c.get("startConnector") == "crank_speed"]
    assert (speed.get("endElement"), speed.get("endConnector")) == ("bodies", "crank_speed")
    inside = [c for c in root.iter(f"{{{SPACE['ssd']}}}Connection") if len(c.attrib) == 4]
    assert len(inside) == 4 * 120
    values = {p.get("name"): p[0] for p in files["resources/case.ssv"].iter(PARAMETER)}
    assert float(values["crank_speed"].get("value")) == pytest.approx(200 * np.pi, rel=1e-12)
    assert values.keys() == inputs


PARAMETER = f"{{{SPACE['ssv']}}}Parameter"


def test_units_are_declared_where_they_are_used(package):
    for name, root in members(package).items():
        declared = {unit.get("name") for unit in root.iter(f"{{{SPACE['ssc']}}}Unit")}
        assert {node.get("unit") for node in root.iter()} - {None} <= declared, name


def test_omsimulator_finds_its_step_and_nothing_that_it_refuses(package):
    """OMSimulator finds its step size and no element that it rejects.

    It reads the prefix as text and only the first annotation of the system.
    Of the root it accepts only System, Units, Enumerations and DefaultExperiment.
    """
    with zipfile.ZipFile(package) as archive:
        text = archive.read("SystemStructure.ssd").decode()
    root = ElementTree.fromstring(text)
    assert {node.tag.split("}")[1] for node in root} == {"System", "Units", "DefaultExperiment"}
    (top,) = root.iter(f"{{{SPACE['ssd']}}}System")
    first, own = top.find(f"{{{SPACE['ssd']}}}Annotations")
    assert (first.get("type"), own.get("type")) == ("org.openmodelica", "piston-cosim")
    (master,) = first[0][0]
    assert float(master.get("stepSize")) == pytest.approx(1 / 36000, rel=1e-12)
    for tag in ("oms:Annotations", "oms:SimulationInformation", "oms:FixedStepMaster"):
        assert f"<{tag}" in text


def schemas(version):
    """Folder of the standard's schemas: of SSP 1.0 FMPy carries them, of 2.0 pyssp-standard."""
    if version == "1.0":
        return Path(fmpy.ssp.ssd.__file__).parent / "schema"
    carrier = find_spec("pyssp_standard")
    if carrier is None:
        pytest.skip("the schemas of SSP 2.0 come with pyssp-standard, of the extra test")
    return Path(carrier.origin).parent / "resources" / "ssp2"


FILES = {".ssd": "SystemStructureDescription.xsd", ".ssv": "SystemStructureParameterValues.xsd"}


@pytest.mark.parametrize("kind, version", [("package", "1.0"), ("arrays", "2.0")])
def test_valid_against_the_schemas(kind, version, request):
    path = request.getfixturevalue(kind)
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            if (ending := Path(name).suffix) not in FILES:
                continue
            schema = etree.XMLSchema(etree.parse(str(schemas(version) / FILES[ending])))
            schema.assertValid(etree.fromstring(archive.read(name)))


def test_foreign_ssp_lacks_only_the_macro_step(package, tmp_path):
    """Without this tool's annotation the system is whole but for what SSP has no words for."""
    foreign = tmp_path / "foreign.ssp"
    with zipfile.ZipFile(package) as source, zipfile.ZipFile(foreign, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "SystemStructure.ssd":
                root = ElementTree.fromstring(data)
                (top,) = root.iter(f"{{{SPACE['ssd']}}}System")
                top.remove(top.find(f"{{{SPACE['ssd']}}}Annotations"))
                data = ElementTree.tostring(root)
            target.writestr(name, data)
    with pytest.raises(BadInput) as refusal:
        check_case(read_tree(foreign), foreign)
    assert len(refusal.value.faults) == 1 and "time.step" in refusal.value.faults[0]
    assert len(check_case(read_tree(foreign, [("time.step", "0.02 ms")]), foreign).wires) == 4


def test_no_ssp_is_bad_input(tmp_path):
    (tmp_path / "no.ssp").write_text("no")
    with pytest.raises(BadInput, match="ssp: expected an SSP, got another file"):
        read_tree(tmp_path / "no.ssp")


@pytest.fixture(scope="module")
def arrays(tmp_path_factory):
    """Export the same case with FMI 3.0 FMUs."""
    if not compiler():
        pytest.skip("no C compiler")
    path = tmp_path_factory.mktemp("ssp3") / "case.ssp"
    tree = read_tree(PATH, SMALL)
    export_ssp(tree, open_python(check_case(tree, PATH), PATH.parent, "3.0"), path)
    return path


def test_array_connectors_have_dimensions(arrays):
    files = members(arrays)
    root, values = files["SystemStructure.ssd"], files["resources/ehd.ssv"]
    assert root.get("version") == values.get("version") == "2.0"
    connector = next(
        c for c in root.iter(f"{{{SPACE['ssd']}}}Connector") if c.get("name") == "film_thickness"
    )
    kind, *sizes = connector
    assert (kind.tag, kind.get("unit")) == (f"{{{SPACE['ssc']}}}Float64", "m")
    assert [size.get("size") for size in sizes] == ["12", "10"]
    inside = [c for c in root.iter(f"{{{SPACE['ssd']}}}Connection") if len(c.attrib) == 4]
    assert len(inside) == 4
    assert {node[0].tag.split("}")[1] for node in values.iter(f"{{{SPACE['ssv']}}}Parameter")} <= {
        "Float64",
        "Int32",
        "String",
        "Enumeration",
    }


def test_arrays_and_scalars_are_not_mixed(tmp_path):
    if not compiler():
        pytest.skip("no C compiler")
    case = check_case(read_tree(PATH, SMALL), PATH)
    film = str(open_python(case, PATH.parent, "3.0").participants["ehd"].path)
    table = case.participants["ehd"].model_copy(update={"package": None, "build": {}, "fmu": film})
    mixed = case.model_copy(update={"participants": case.participants | {"ehd": table}})
    with pytest.raises(BadInput, match="film_thickness: expected one FMI version on") as refusal:
        export_ssp(
            read_tree(PATH, SMALL), open_system(mixed, PATH.parent, print), tmp_path / "mixed.ssp"
        )
    assert len(refusal.value.faults) == 4
