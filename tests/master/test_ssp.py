"""A case written as an SSP and read back gives the same run, value for value."""

import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest

from piston_cosim.master.case.schema import check_case, find_case, read_tree
from piston_cosim.master.case.ssp import SPACE, export_ssp
from piston_cosim.master.case.system import open_system
from piston_cosim.master.commands.export import built
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


def test_read_back_runs_to_the_same_values(package, tmp_path):
    one, two = results(PATH, SMALL, tmp_path / "one.h5"), results(package, (), tmp_path / "two.h5")
    for port in ("bodies.lateral_displacement", "ehd.minimum_film_thickness", "ehd.friction_power"):
        np.testing.assert_array_equal(one.series(port)[0], two.series(port)[0])
    assert np.ptp(one.series("bodies.lateral_displacement")[0]) > 0


def test_structure_names_units_and_every_scalar(package):
    with zipfile.ZipFile(package) as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
        assert {"resources/ehd.fmu", "resources/bodies.ssv"} <= set(archive.namelist())
    connectors = {c.get("name"): c for c in root.iter(f"{{{SPACE['ssd']}}}Connector")}
    assert connectors["film_thickness[12,10]"][0].get("unit") == "m"
    assert len(list(root.iter(f"{{{SPACE['ssd']}}}Connection"))) == 4 * 120


def test_foreign_ssp_lacks_only_the_macro_step(package, tmp_path):
    """Without this tool's annotation the system is whole but for what SSP has no words for."""
    foreign = tmp_path / "foreign.ssp"
    with zipfile.ZipFile(package) as source, zipfile.ZipFile(foreign, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "SystemStructure.ssd":
                root = ElementTree.fromstring(data)
                root.remove(root.find(f"{{{SPACE['ssd']}}}Annotations"))
                data = ElementTree.tostring(root)
            target.writestr(name, data)
    with pytest.raises(BadInput) as refusal:
        check_case(read_tree(foreign), foreign)
    assert len(refusal.value.faults) == 1 and "time.step" in refusal.value.faults[0]
    assert len(check_case(read_tree(foreign, [("time.step", "0.02 ms")]), foreign).wires) == 4


def test_no_ssp_is_bad_input(tmp_path):
    (tmp_path / "no.ssp").write_text("no")
    with pytest.raises(BadInput, match="is no SSP"):
        read_tree(tmp_path / "no.ssp")


@pytest.fixture(scope="module")
def arrays(tmp_path_factory):
    """The same case with FMI 3.0 FMUs."""
    if not compiler():
        pytest.skip("no C compiler")
    path = tmp_path_factory.mktemp("ssp3") / "case.ssp"
    case = check_case(read_tree(PATH, SMALL), PATH)
    export_ssp(
        read_tree(PATH, SMALL), open_system(built(case, PATH.parent), PATH.parent, print), path
    )
    return path


def test_arrays_read_back_run_to_the_same_values(arrays, tmp_path):
    one, three = (
        results(PATH, SMALL, tmp_path / "one.h5"),
        results(arrays, (), tmp_path / "three.h5"),
    )
    for port in ("bodies.lateral_displacement", "ehd.minimum_film_thickness", "ehd.friction_power"):
        np.testing.assert_array_equal(one.series(port)[0], three.series(port)[0])


def test_array_connectors_have_dimensions(arrays):
    with zipfile.ZipFile(arrays) as archive:
        root = ElementTree.fromstring(archive.read("SystemStructure.ssd"))
        values = ElementTree.fromstring(archive.read("resources/ehd.ssv"))
    assert root.get("version") == values.get("version") == "2.0"
    connector = next(
        c for c in root.iter(f"{{{SPACE['ssd']}}}Connector") if c.get("name") == "film_thickness"
    )
    kind, *sizes = connector
    assert (kind.tag, kind.get("unit")) == (f"{{{SPACE['ssc']}}}Float64", "m")
    assert [size.get("size") for size in sizes] == ["12", "10"]
    assert len(list(root.iter(f"{{{SPACE['ssd']}}}Connection"))) == 4
    assert {node[0].tag.split("}")[1] for node in values.iter(f"{{{SPACE['ssv']}}}Parameter")} <= {
        "Float64",
        "Int32",
        "String",
    }


def test_arrays_and_scalars_are_not_mixed(tmp_path):
    if not compiler():
        pytest.skip("no C compiler")
    case = check_case(read_tree(PATH, SMALL), PATH)
    both = built(case, PATH.parent).participants
    mixed = case.model_copy(update={"participants": case.participants | {"ehd": both["ehd"]}})
    with pytest.raises(BadInput, match="one side alone") as refusal:
        export_ssp(
            read_tree(PATH, SMALL), open_system(mixed, PATH.parent, print), tmp_path / "mixed.ssp"
        )
    assert len(refusal.value.faults) == 4
